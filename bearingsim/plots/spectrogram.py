"""Amplitude of a signal over time and frequency."""

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure as Canvas

from bearingsim.config.bands import PASSBAND
from bearingsim.plots import labels, recorded, select
from bearingsim.plots.axes import finish
from bearingsim.plots.caption import fixed_values, rounding_texts, sampling_texts
from bearingsim.plots.labels import PlotError
from bearingsim.plots.sheet import Sheet, file_words
from bearingsim.plots.style import COLUMN_IN
from bearingsim.plots.units import choose_scale
from bearingsim.plots.window import crop, origin_text, pass_period, window_of

if TYPE_CHECKING:
    from bearingsim.plots.recorded import Signal
    from bearingsim.store import Results
    from bearingsim.study import Figure

ROW_IN = 2.0
CHARACTER_IN = 0.08  # inches, width of a character of a label
DEFAULT_PASSES = 4.0  # ball passes shown by default
SEGMENTS_PER_PASS = 8.0  # ball pass period relative to the length of a segment, which separates single impacts
MIN_SAMPLES = 32  # minimum length of a segment
HOPS_PER_SEGMENT = 8  # length of a segment over the hop between the starts of adjacent segments
COLOUR_MAP = "viridis"
DYNAMIC_RANGE_DB = 80.0  # dB, range of the colours below the largest amplitude


def draw_spectrogram(results: "Results", figure: "Figure", jobs: Sequence[str]) -> list[Sheet]:
    """Draw the amplitude spectra of overlapping segments of a channel, a row per job, colours in dB or in a unit.

    Raises PlotError if the sampling is too coarse to separate impacts.
    """
    view = figure.view
    records = recorded.load_jobs(results, jobs)
    channel = recorded.channels_for(records, figure.y)[0]
    if view.range:
        recorded.check_passband("range", view.range, *records.values())
    swept = {entry["job"]: entry["swept"] for entry in results.plan["jobs"]}
    maps = {}
    for name, job in records.items():
        signal = next(recorded.signals_of(job, channel))
        window = window_of(results, name, job, channel, view, DEFAULT_PASSES * pass_period(job))
        maps[name] = (*segment_spectra(crop(signal, window), pass_period(job)), window.origin)
    unit = recorded.unit_of(channel)
    scale = choose_scale(unit, channel, max(float(a.max()) for _, _, a, _ in maps.values()), view)
    canvas = Canvas(figsize=(2 * COLUMN_IN, ROW_IN * len(jobs) + 0.9), layout="constrained")
    axes = canvas.subplots(len(jobs), 1, sharex=True, squeeze=False)[:, 0]
    scaled = {name: scale.to_axis(amplitude) for name, (_, _, amplitude, _) in maps.items()}
    top = max(float(values.max()) for values in scaled.values())
    bottom = top - DYNAMIC_RANGE_DB if view.db else 0.0
    for ax, (name, (time, frequency, _, origin)) in zip(axes, maps.items(), strict=True):
        colours = ax.pcolormesh(1e3 * (time - origin), frequency / 1e3, scaled[name], cmap=COLOUR_MAP, vmin=bottom,
                                vmax=top, shading="nearest", rasterized=True)  # fmt: skip
        low, high = view.range or (0.0, PASSBAND * float(records[name].parameters["sampling"]))
        ax.set_ylim(low / 1e3, high / 1e3)
        ax.set_ylabel("Frequency (kHz)")
        ax.grid(False)
        ax.set_title(labels.swept_text(swept[name], results.plan["units"]), loc="left", fontsize=8)
    axes[-1].set_xlabel(f"Time{origin_text(records.values()) if view.around else ''} (ms)")
    text = recorded.text_of(channel)
    label = f"{text} ({scale.unit_text(amplitude=True)})"
    canvas.colorbar(colours, ax=list(axes), label=textwrap.fill(label, int(ROW_IN * len(jobs) / CHARACTER_IN)))
    table = select.case_rows(results)
    swept_paths = set().union(*(swept[name] for name in jobs))
    fixed = fixed_values(results, table[table["job"].isin(jobs)], swept_paths)
    lengths = sorted(1e3 * pass_period(job) / SEGMENTS_PER_PASS for job in records.values())
    ends = " to ".join(dict.fromkeys(f"{length:.2g}" for length in (lengths[0], lengths[-1])))
    overlap = f"{100.0 * (1.0 - 1.0 / HOPS_PER_SEGMENT):g} % overlap"
    segments = f"Hann segments of {ends} ms, {overlap}"
    texts = [*rounding_texts(results, records, [channel]), *sampling_texts(records.values(), [channel])]
    finish(canvas, figure.title, [segments, *texts, *fixed])
    return [Sheet(file_words(figure, jobs), canvas)]


def segment_spectra(signal: "Signal", period: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Compute the amplitude spectra of overlapping segments of a signal, with a Hann window.

    period: of the ball passes (s). Returns the centres of the segments (m,) in s, frequencies (f,) in Hz and
    amplitudes (f, m) in SI. Raises PlotError if a segment has fewer than ``MIN_SAMPLES`` samples, or is longer
    than the signal.
    """
    from bearingsim import signals

    length = round(period / SEGMENTS_PER_PASS * signal.rate)
    if length < MIN_SAMPLES:
        needed = MIN_SAMPLES * SEGMENTS_PER_PASS / period
        raise PlotError(
            f"a spectrogram that separates the ball passes needs `sampling` of {needed:.0f} Hz or more"
        )
    starts = np.arange(0, len(signal.values) - length + 1, max(1, length // HOPS_PER_SEGMENT))
    if not len(starts):
        raise PlotError(f"the time axis is shorter than a segment of {length / signal.rate:.3g} s")
    spectra = [signals.spectrum(signal.values[start : start + length], signal.rate) for start in starts]
    centres = signal.time[0] + (starts + 0.5 * (length - 1)) / signal.rate
    return centres, spectra[0][0], np.stack([amplitude for _, amplitude in spectra], axis=1)
