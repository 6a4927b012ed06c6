"""Spectra of signals, with the spectral lines of the defects marked."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure as Canvas
from matplotlib.lines import Line2D

from bearingsim.config.bands import PASSBAND
from bearingsim.plots import labels, lines, recorded
from bearingsim.plots.grid import Curve, Display, grid
from bearingsim.plots.labels import PlotError
from bearingsim.plots.recorded import Job, Signal
from bearingsim.plots.sheet import Sheet, file_words
from bearingsim.plots.style import COLOURS
from bearingsim.plots.units import RANGE_DB
from bearingsim.plots.window import cut, window_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from bearingsim.store import Results
    from bearingsim.study import Figure

SHOWN_LINES = {"spectrum": 12, "envelope": 6}  # multiples of the fundamental line shown by default
MARK_COLOURS = {"outer": COLOURS[1], "inner": COLOURS[3], "roller": COLOURS[2]}
DASHED = (0, (2, 2))
MARKS_APART = 0.02  # of the axis, least distance of marks; closer ones are left out
NAMES_APART = 0.085  # of the axis, least distance of the names of marks
ORDERS_POINTS = 30.0  # height of the axis in orders above the axes
ROUND_STEPS = (1, 2, 5, 10, 20, 50, 100, 200, 500)
"""Steps of the harmonics that are marked or named."""
NAME_LETTER = 0.0105  # of the axis, width of a letter of a name
AROUND_PASSES = 8.0  # ball passes of which the spectrum around an impact is computed
FEWEST_BINS = 8  # least number of frequencies in a spectrum
DECADES = 5  # largest range of a logarithmic axis below the largest value

Spectrum = Callable[[np.ndarray, float], Curve]


def draw_spectrum(results: "Results", figure: "Figure", jobs: Sequence[str]) -> list[Sheet]:
    """Draw the amplitude spectra of channels: a sine of amplitude A gives a peak of height A."""
    from bearingsim import signals

    return _draw(results, figure, jobs, signals.spectrum, "amplitude spectrum", power=1)


def draw_envelope_spectrum(results: "Results", figure: "Figure", jobs: Sequence[str]) -> list[Sheet]:
    """Draw the spectra of the squared envelope of channels, or of their content in a band."""
    from bearingsim import signals

    def spectrum(values: np.ndarray, rate: float) -> Curve:
        try:
            return signals.envelope_spectrum(values, rate, figure.view.band)
        except ValueError as error:
            raise PlotError(f"{error}; raise `sampling`") from None

    return _draw(results, figure, jobs, spectrum, "spectrum of the squared envelope", power=2)


def _draw(
    results: "Results", figure: "Figure", jobs: Sequence[str], spectrum: Spectrum, quantity: str, power: int
) -> list[Sheet]:
    records = recorded.load_jobs(results, jobs)
    low, high = frequency_range(figure, records.values())

    def curve(name: str, job: Job, channel: str, signal: Signal) -> Curve:
        leading = records[name]
        window = window_of(
            results, name, leading, channel, figure.view, float(signal.time[-1]), passes=AROUND_PASSES
        )
        frequency, amplitude = spectrum(*whole_periods(cut(signal, window), first_line(leading.parameters)))
        shown = (frequency >= low) & (frequency <= high)
        if np.count_nonzero(shown) < FEWEST_BINS:
            part = f"{1e3 * (window.stop - window.start):.3g} ms of job {name} resolve {frequency[1]:.3g} Hz"
            raise PlotError(f"{part}, too coarse for {low:g} to {high:g} Hz; show a longer part of the record")
        resolution = f"Hann window, {frequency[1]:.3g} Hz between lines"
        if resolution not in notes:
            notes.append(resolution)
        return frequency[shown], amplitude[shown]

    notes = _texts(figure, records)
    display = Display(
        curve,
        "Frequency (Hz)",
        lambda text: f"{quantity} of the {text[:1].lower()}{text[1:]}",
        power,
        amplitude=True,
    )
    channels = recorded.channels_for(records, figure.y)
    made = grid(results, records, channels, figure, display, notes)
    for row, shown in zip(made.axes, made.jobs, strict=True):
        for ax in row:
            _set_scales(ax, figure, low, high)
            top = row is made.axes[0]
            with_orders = figure.view.orders and top
            if with_orders:
                _add_orders(ax, shown[0])
            if share_lines(shown):
                mark_lines(ax, shown[0], named=top, above=ORDERS_POINTS if with_orders else 0.0)
    _name_sidebands(made.canvas, [job for row in made.jobs for job in row])
    return [Sheet(file_words(figure, jobs), made.canvas)]


def frequency_range(figure: "Figure", jobs: Iterable[Job]) -> tuple[float, float]:
    """Return the frequencies (Hz) to show: those of the view, else some multiples of the fundamental line.

    Raises PlotError for frequencies beyond the passband of the records.
    """
    jobs = list(jobs)
    flat = PASSBAND * min(float(job.parameters["sampling"]) for job in jobs)
    if figure.view.range is None:
        fundamental = max(first_line(job.parameters) for job in jobs)
        return 0.0, min((SHOWN_LINES.get(figure.kind, 12) + 0.5) * fundamental, flat)
    low, high = figure.view.range
    if high > flat * (1.0 + 1e-9):
        raise PlotError(
            f"`range` ends at {high:g} Hz; the records are flat to {flat:g} Hz, {PASSBAND:g} of their `sampling`"
        )
    return low, high


def first_line(parameters: Mapping[Any, Any]) -> float:
    """Compute the fundamental frequency (Hz) of the job's defects."""
    return lines.frequency(lines.FAMILIES[(lines.races(parameters) or ["outer"])[0]].fundamental, parameters)


def whole_periods(signal: Signal, frequency: float) -> tuple[np.ndarray, float]:
    """Trim a signal to whole periods of ``frequency`` (Hz), if it has any; return its values and sampling rate."""
    periods = int(len(signal.time) / signal.rate * frequency + 1e-9)
    count = min(len(signal.time), round(periods * signal.rate / frequency))
    return signal.values[: count or None], signal.rate


def _texts(figure: "Figure", records: Mapping[str, Job]) -> list[str]:
    band = figure.view.band
    if figure.kind == "envelope" and band is None:
        high = PASSBAND * min(float(job.parameters["sampling"]) for job in records.values())
        band = (0.0, high)
    return [f"envelope of {band[0] / 1e3:.4g} to {band[1] / 1e3:.4g} kHz"] if band else []


# Axes


def _set_scales(ax: "Axes", figure: "Figure", low: float, high: float) -> None:
    ax.set_xlim(low, high)
    if "x" in figure.log:
        ax.set_xlim(max(low, high * 1e-3), high)
        ax.set_xscale("log")
    if "y" in figure.log:
        largest = ax.dataLim.y1
        ax.set_yscale("log", nonpositive="clip")
        ax.set_ylim(largest * 10.0**-DECADES, 2.0 * largest)
    elif figure.view.db:
        largest = ax.dataLim.y1
        ax.set_ylim(max(ax.dataLim.y0, largest - RANGE_DB) - 5.0, largest + 5.0)
    else:
        ax.set_ylim(bottom=0.0)


def share_lines(jobs: Sequence[Job]) -> bool:
    """Check if all jobs have the same spectral lines: the same defects and frequencies, at a constant speed."""
    races = {tuple(lines.races(job.parameters)) for job in jobs}
    frequencies = [first_line(job.parameters) for job in jobs]
    steady = not any(recorded.has_ramp(job) for job in jobs)
    return steady and len(races) == 1 and max(frequencies) <= (1.0 + 1e-9) * min(frequencies)


def mark_lines(ax: "Axes", job: Job, named: bool, above: float = 0.0) -> None:
    """Mark the lines of the defects' families, sidebands dashed; names are above, one height per family.

    above: distance (points) of the lowest names from the axes. Marks and names closer than ``MARKS_APART`` and
    ``NAMES_APART`` to the one before are left out.
    """
    elements = lines.races(job.parameters) or ["outer"]
    low, high = ax.get_xlim()
    for race in elements:
        colour, height = MARK_COLOURS[race], above + 2.0 + 8.0 * elements.index(race)
        harmonics = [mark for mark in lines.marks(job.parameters, high) if mark.race == race and mark.hertz >= low]
        for mark in _apart(harmonics, MARKS_APART * (high - low)):
            dashes: Mapping[str, Any] = {"ls": DASHED, "alpha": 0.4} if mark.sideband else {"alpha": 0.5}
            ax.axvline(mark.hertz, color=colour, lw=0.7, zorder=0.9, **dashes)
        if named:
            _name_marks(ax, [mark for mark in harmonics if not mark.sideband], colour, height)


def _name_marks(ax: "Axes", harmonics: Sequence[lines.Mark], colour: str, height: float) -> None:
    """Write the names of harmonics above the axes, with the frequency of all or, in a wide range, the first.

    height: above the axes (points). Names that would overlap the one before are left out.
    """
    low, high = ax.get_xlim()
    named = _apart(harmonics, NAMES_APART * (high - low))
    positions = ax.transAxes.inverted().transform(ax.transData.transform([(mark.hertz, 0.0) for mark in named]))
    distance = min(np.diff(positions[:, 0]), default=1.0) if len(named) else 1.0
    long_names = [f"{mark.name} {mark.hertz:.1f} Hz" for mark in named]
    all_long = NAME_LETTER * max(map(len, long_names), default=0) < distance
    end = -np.inf  # of the name before, of the axes
    for mark, (place, _), long_name in zip(named, positions, long_names, strict=True):
        text = long_name if all_long or mark.number == 1 else mark.name
        half = 0.5 * NAME_LETTER * len(text)
        if place - half < end:
            continue
        end = place + half
        ax.annotate(text, (mark.hertz, 1.0), (0, height), xycoords=("data", "axes fraction"),
                    textcoords="offset points", ha="center", fontsize=7, color=colour)  # fmt: skip


def _apart(marks: Sequence[lines.Mark], distance: float) -> list[lines.Mark]:
    """Select marks about ``distance`` (Hz) apart: the fundamental, multiples of a round number, their sidebands.

    Sidebands are left out if they would be closer than a third of that.
    """
    fundamentals = [mark.hertz / mark.number for mark in marks if not mark.sideband]
    if not fundamentals:
        return []
    every = next((step for step in ROUND_STEPS if step * fundamentals[0] >= distance), ROUND_STEPS[-1])
    beside = [abs(mark.hertz - mark.number * fundamentals[0]) for mark in marks if mark.sideband]
    with_sidebands = every == 1 and min(beside, default=0.0) >= distance / 3.0
    round_ones = [mark for mark in marks if mark.number == 1 or mark.number % every == 0]
    return [mark for mark in round_ones if with_sidebands or not mark.sideband]


def _add_orders(ax: "Axes", job: Job) -> None:
    """Add an axis in orders of the shaft's speed above the axes."""
    shaft = lines.frequency(lines.SHAFT, job.parameters)
    functions = (partial(np.multiply, 1.0 / shaft), partial(np.multiply, shaft))
    axis = ax.secondary_xaxis("top", functions=functions)
    axis.set_xlabel(f"Order of the shaft frequency, {labels.number_text(shaft)} Hz", fontsize=8.0)
    ax.set_title(ax.get_title(loc="left"), loc="left", fontsize=8, pad=ORDERS_POINTS + 11.0)


def _name_sidebands(canvas: Canvas, jobs: Iterable[Job]) -> None:
    """Add the meaning of the dashed lines to the legend."""
    steady = [job for job in jobs if not recorded.has_ramp(job)]
    elements = dict.fromkeys(race for job in steady for race in lines.races(job.parameters))
    entries = []
    for race in elements:
        family = lines.FAMILIES[race]
        if family.beside:
            distances = {f"{lines.frequency(family.beside, job.parameters):.4g} Hz" for job in steady}
            text = f"± {family.distance}" + (f" ({distances.pop()})" if len(distances) == 1 else "")
            entries.append(Line2D([], [], color=MARK_COLOURS[race], lw=0.7, ls=DASHED, label=text))
    if entries:
        shown = canvas.legends[0] if canvas.legends else None
        old = list(shown.legend_handles) if shown else []
        if shown:
            shown.remove()
        handles = [*(handle for handle in old if handle is not None), *entries]
        canvas.legend(handles=handles, loc="outside upper right", ncols=len(handles))
