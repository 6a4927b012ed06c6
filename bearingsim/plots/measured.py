"""Figure of a measured signal: time, spectrum, envelope spectrum with the lines of the races, kurtogram."""

from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from bearingsim.diagnosis import NONE, Diagnosis
from bearingsim.diagnosis.thresholds import decibels
from bearingsim.measured.si import factor_to
from bearingsim.plots.labels import PlotError, format_unit
from bearingsim.plots.marks import MARK_COLOURS
from bearingsim.plots.plot import FORMATS, METADATA, is_replaceable
from bearingsim.plots.style import COLOURS, PAGE_IN, disable_invalid_math, drawing
from bearingsim.signals import band_pass, envelope_spectrum, spectrum
from bearingsim.store import write_bytes
from bearingsim.text.numbers import significant

if TYPE_CHECKING:
    from bearingsim.diagnosis.comparison import Signal
    from bearingsim.diagnosis.kurtogram import Kurtogram
    from bearingsim.measured import Recording

SHOWN_PASSES = 8.0
"""Number of periods of the line shown in the panel of the time signal."""
MIN_SHOWN = 1e-8
"""Smallest amplitude shown in a spectrum, relative to the largest; smaller ones are rounding errors."""
LOWEST_DB = -10.0
"""dB, lower limit of the axis of an envelope spectrum; 90 % of the bins of noise are above -8 dB."""
MAX_POINTS = 4000
"""Limit of the points of a drawn spectrum; a longer one is reduced to the maxima of groups of neighbours."""
LINE_NAMES = {"outer": "BPFO", "inner": "BPFI", "roller": "2 BSF"}
QUANTITIES = {"m/s^2": "Acceleration", "m/s": "Velocity", "m": "Displacement", "N": "Force"}
"""Quantities by SI unit."""
HARMONICS = 3
SCORE_THRESHOLD = "threshold of the score of 3 lines"
"""Legend of the threshold, which applies to the score of three harmonics, not to single lines."""
TITLES = {
    "outer": "outer race",
    "inner": "inner race",
    "roller": "rolling element",
    "outer or roller": "outer race or rolling element",
    "other rhythm": "a periodicity that matches no line of the bearing",
    "none": "no line found",
}
"""Titles of the figure by verdict."""


def check_path(path: Path) -> None:
    """Raise PlotError for another format, a missing folder, or an existing file that is not a figure."""
    if path.suffix.removeprefix(".").lower() not in FORMATS:
        raise PlotError(f"{path}: expected a name that ends in .{', .'.join(FORMATS)}")
    if not path.parent.is_dir():
        raise PlotError(f"{path}: there is no folder {path.parent}")
    if not is_replaceable(path):
        raise PlotError(f"{path} exists and is not a figure of bearingsim; name another file")


@drawing()
def draw_diagnosis(
    recording: "Recording",
    channel: str,
    diagnosis: Diagnosis,
    image: "Kurtogram",
    band: tuple[float, float],
    bearing: str,
) -> Figure:
    """Draw the four panels; bearing: its name in the title."""
    canvas = Figure(figsize=(PAGE_IN, 0.8 * PAGE_IN), layout="constrained")
    (time, spectrum), (envelope, kurtosis) = canvas.subplots(2, 2)
    values, fs, unit = recording.channels[channel], recording.rate.value, recording.units[channel].value
    in_unit = f" ({format_unit(unit)})" if unit else ""
    quantity = _quantity(unit)
    _draw_time(time, values, fs, diagnosis, f"{quantity}{in_unit}")
    _draw_spectrum(spectrum, values, fs, f"{quantity}, 0-peak{in_unit}")
    _draw_envelope(envelope, diagnosis, band)
    _draw_kurtogram(kurtosis, image, band)
    source = f"{recording.path.name}, {channel}, {bearing} at {diagnosis.lines.shaft * 60.0:.6g} rpm"
    canvas.suptitle(f"{source}\n{_title(diagnosis)}", fontsize=9.0)
    return canvas


def _quantity(unit: str) -> str:
    """Return the quantity of a unit, `Acceleration`, or `Signal` for one that is unknown."""
    return next((QUANTITIES[si] for si in QUANTITIES if factor_to(si, unit) is not None), "Signal")


def _title(diagnosis: Diagnosis) -> str:
    """Return the verdict with its frequency."""
    if diagnosis.verdict == NONE and diagnosis.has_other_rhythm:
        return f"{TITLES[NONE]}; strongest other periodicity {diagnosis.strongest_other.frequency:.2f} Hz"
    if diagnosis.is_of_shaft:
        other = diagnosis.strongest_other.frequency
        line = f"order {round(other / diagnosis.lines.shaft)} of the shaft, {other:.2f} Hz"
        return f"{line}, whose harmonics explain {LINE_NAMES[diagnosis.best]}"
    frequency = {"none": None, "other rhythm": diagnosis.strongest_other.frequency}.get(
        diagnosis.verdict, diagnosis.findings[diagnosis.best].comb.frequency
    )
    healthy = " or a healthy bearing with clearance" if diagnosis.clearance_may_cause else ""
    return f"{TITLES[diagnosis.verdict]}{healthy}{f', {frequency:.2f} Hz' if frequency else ''}"


def _draw_time(ax: Axes, values: np.ndarray, fs: float, diagnosis: Diagnosis, label: str) -> None:
    """Draw some periods of the line around the largest sample."""
    count = min(len(values), int(SHOWN_PASSES * fs / diagnosis.findings[diagnosis.best].comb.frequency))
    start = int(np.clip(np.argmax(np.abs(values - values.mean())) - count // 2, 0, len(values) - count))
    ax.plot(1e3 * np.arange(start, start + count) / fs, values[start : start + count], color=COLOURS[0], lw=0.7)
    ax.set_xlabel("Time (ms)")
    ax.set_ylabel(label)
    ax.margins(x=0.0)


def _draw_spectrum(ax: Axes, values: np.ndarray, fs: float, label: str) -> None:
    frequency, amplitude = spectrum(values, fs)
    group = max(1, len(frequency) // MAX_POINTS)
    count = len(frequency) // group * group
    drawn = amplitude[:count].reshape(-1, group).max(axis=1)
    ax.semilogy(1e-3 * frequency[:count:group], drawn, color=COLOURS[0], lw=0.6)
    ax.set_xlabel(f"Frequency (kHz), line spacing {significant(float(frequency[1] - frequency[0]), 2)} Hz")
    ax.set_ylabel(label)
    ax.set_ylim(_lower_limit(drawn), 2.0 * float(drawn.max()))
    ax.margins(x=0.0)


def _lower_limit(amplitude: np.ndarray) -> float:
    """Return the lower limit of a logarithmic axis, below all amplitudes (n,) except the lowest 1 %."""
    return max(0.5 * float(np.quantile(amplitude, 0.01)), MIN_SHOWN * float(amplitude.max()))


def _draw_envelope(ax: Axes, diagnosis: Diagnosis, band: tuple[float, float]) -> None:
    """Draw the first envelope spectrum in dB, with the harmonics of each race or of a stronger periodicity, the
    sidebands of the named race, and the height of three equal harmonics at the threshold."""
    spectrum = diagnosis.spectra[0]
    height = 10.0 * np.log10(np.maximum(spectrum.height[1:], 1e-9))
    ax.plot(spectrum.frequency[1:], height, color=COLOURS[0], lw=0.6)
    for race, finding in diagnosis.findings.items():
        is_verdict = race in diagnosis.verdict
        for number in range(1, HARMONICS + 1):
            text = LINE_NAMES[race] if number == 1 else None
            ax.axvline(
                number * finding.comb.frequency, color=MARK_COLOURS[race], lw=1.0, label=text, zorder=0.9,
                ls="-" if is_verdict else (0, (2, 2)), alpha=0.7,
            )  # fmt: skip
    if diagnosis.has_other_rhythm:
        for number in range(1, HARMONICS + 1):
            label = f"{diagnosis.strongest_other.frequency:.2f} Hz" if number == 1 else None
            ax.axvline(number * diagnosis.strongest_other.frequency, color="0.2", lw=1.0, label=label, zorder=0.9)
    spacings = {"inner": ("fr", diagnosis.lines.shaft), "roller": ("FTF", diagnosis.lines.cage)}
    if diagnosis.verdict in spacings:
        (name, spacing), line = spacings[diagnosis.verdict], diagnosis.findings[diagnosis.verdict].comb.frequency
        sidebands = [n * line + side * spacing for n in range(1, HARMONICS + 1) for side in (-1.0, 1.0)]
        for number, sideband in enumerate(sidebands):
            ax.axvline(sideband, color="0.5", lw=0.7, ls=":", zorder=0.8, label=None if number else f"± {name}")
    ax.axhline(decibels(diagnosis.threshold), color="0.3", lw=0.8, ls=(0, (5, 2)), label=SCORE_THRESHOLD)
    ax.set_xlim(0.0, 1.05 * HARMONICS * max(finding.comb.frequency for finding in diagnosis.findings.values()))
    ax.set_ylim(LOWEST_DB, 1.25 * float(height.max()))
    ax.set_xlabel("Frequency (Hz)")
    ax.set_ylabel(f"Envelope, {band[0] / 1e3:.3g}-{band[1] / 1e3:.3g} kHz\n(dB over the local median)")
    ax.legend(
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        ncols=3,
        fontsize=7.0,
        columnspacing=0.7,
        handlelength=1.3,
        handletextpad=0.4,
    )


def _draw_kurtogram(ax: Axes, image: "Kurtogram", band: tuple[float, float]) -> None:
    """Draw kurtosis by level and band, the edges of the analysed band, and a frame around the largest kurtosis."""
    levels = np.arange(len(image.kurtosis) + 1) - 0.5
    mesh = ax.pcolormesh(
        1e-3 * image.edges, levels, np.maximum(image.kurtosis, 0.0), cmap="viridis", rasterized=True
    )
    for edge in band:
        ax.axvline(1e-3 * edge, color="white", lw=1.0, ls=(0, (4, 2)), clip_on=False)
    low, high = (1e-3 * edge for edge in image.best)
    level = round(np.log2(1e-3 * image.edges[-1] / (high - low)))
    frame = Rectangle((low, level - 0.5), high - low, 1.0, fill=False, ec="#d62728", lw=1.5, clip_on=False)
    ax.add_patch(frame)
    ax.grid(visible=False)
    ax.set_ylim(levels[-1], levels[0])
    ax.set_xlabel("Frequency (kHz)")
    ax.set_title(f"red: most impulsive, {low:.3g}-{high:.3g} kHz; dashed: analysed", fontsize=7.0)
    ax.set_ylabel("Level (halvings of the band)")
    canvas = ax.get_figure(root=True)
    assert canvas is not None
    canvas.colorbar(mesh, ax=ax, label="Excess kurtosis of the envelope")


# A simulation and a measurement


@drawing()
def draw_comparison(
    simulated: "Signal",
    measured: "Signal",
    race: str,
    band: tuple[float, float],
    names: tuple[str, str],
    unit: str,
    factor: float | None,
) -> Figure:
    """Draw time signals around their largest samples, spectra and envelope spectra, one over the other.

    names: of the simulated and the measured signal; unit: of both, empty if it is not stated; band: of the
    envelope (Hz); factor: by which the simulated signal was multiplied. If None, each time signal is drawn
    relative to its largest sample.
    """
    canvas = Figure(figsize=(PAGE_IN, 1.15 * PAGE_IN), layout="constrained")
    time, whole, envelope = canvas.subplots(3, 1)
    if factor is not None:
        names = f"{names[0]}, times {factor:.3g}", names[1]
    for signal, name, colour, width in zip(
        (measured, simulated), names[::-1], COLOURS[1::-1], (0.9, 0.7), strict=True
    ):
        series = band_pass(signal.series - signal.series.mean(), signal.fs, band)
        count = min(len(series), int(SHOWN_PASSES * signal.fs / signal.lines.of_race(race)))
        peak = int(np.argmax(np.abs(series)))
        start = int(np.clip(peak - count // 4, 0, len(series) - count))
        part = series[start : start + count]
        passes = (np.arange(start, start + count) - peak) / signal.fs * signal.lines.of_race(race)
        largest = float(np.abs(part).max())
        if factor is None:
            part, name = part / largest, f"{name} (largest sample {largest:.3g} {format_unit(unit)})"
        time.plot(passes, part, color=colour, lw=width, label=name)
        centres, heights = _interval_maxima(
            *spectrum(signal.series, signal.fs), signal.lines.of_race(race), band[1]
        )
        whole.semilogy(1e-3 * centres, heights, color=colour, lw=width + 0.3, drawstyle="steps-mid")
        orders, level = envelope_spectrum(signal.series, signal.fs, band)
        orders = orders / signal.lines.shaft
        shown = (orders > 0.2) & (orders <= (HARMONICS + 1.2) * signal.lines.of_race(race) / signal.lines.shaft)
        envelope.plot(orders[shown], level[shown] / level[shown].max(), color=colour, lw=width)
    for number in range(1, HARMONICS + 2):
        order = number * simulated.lines.of_race(race) / simulated.lines.shaft
        envelope.axvline(order, color="0.5", lw=0.7, ls=(0, (2, 2)), zorder=0.9)
    line, quantity = LINE_NAMES[race], _quantity(unit)
    in_unit = f" ({format_unit(unit)})" if unit else ""
    time.set_xlabel(f"Time in passes ({line}), from the largest sample; band to {band[1] / 1e3:.3g} kHz")
    time.set_ylabel(f"{quantity},\nof its largest sample" if factor is None else f"{quantity}{in_unit}")
    whole.set_xlabel("Frequency (kHz)")
    whole.set_ylabel(f"Largest amplitude\nper {line} interval, 0-peak{in_unit}")
    envelope.set_xlabel(f"Order of the shaft; dashed: {line} and multiples")
    envelope.set_ylabel("Squared envelope,\nof its largest line")
    for ax in (time, whole, envelope):
        ax.margins(x=0.0)
    canvas.legend(loc="outside upper left")
    return canvas


def _interval_maxima(
    frequency: np.ndarray, amplitude: np.ndarray, width: float, highest: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return centres (m,) in Hz and largest amplitudes (m,) of intervals of a ``width`` (Hz), up to ``highest``.

    A periodic signal has one line in each interval as wide as its frequency, so the curve connects its lines.
    """
    edges = np.arange(0.5 * width, highest, width)
    starts = np.searchsorted(frequency, edges)
    return edges[:-1] + 0.5 * width, np.maximum.reduceat(amplitude, starts)[:-1]


@drawing()
def write(canvas: Figure, path: Path) -> None:
    """Write a figure in the format of the file's suffix."""
    disable_invalid_math(canvas)
    content, kind = BytesIO(), path.suffix.removeprefix(".").lower()
    canvas.savefig(content, format=kind, metadata=METADATA[kind])
    write_bytes(path, content.getvalue())
