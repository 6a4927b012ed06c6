"""Spectra of signals, with the spectral lines of the defects marked."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from bearingsim.config.bands import PASSBAND
from bearingsim.plots import labels, lines, recorded
from bearingsim.plots.grid import Content, CurvePoints, Display, compute_content, draw_grid
from bearingsim.plots.labels import PlotError
from bearingsim.plots.marks import (
    GAP_POINTS,
    ROW_POINTS,
    fundamental_frequency,
    mark_lines,
    raise_title,
    share_lines,
    sideband_entries,
)
from bearingsim.plots.recorded import Job, Signal
from bearingsim.plots.sheet import Sheet, file_words
from bearingsim.plots.units import RANGE_DB
from bearingsim.plots.window import crop, window_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from bearingsim.store import Results
    from bearingsim.study import Figure

SHOWN_LINES = {"spectrum": 12, "envelope": 6}  # multiples of the fundamental line shown by default
ORDERS_POINTS = 30.0  # height of the axis in orders above the axes
AROUND_PASSES = 8.0  # ball passes in the spectrum around an impact
MIN_BINS = 8  # minimum number of frequencies in a spectrum
HEADROOM, MARGIN_DB = 2.0, 5.0  # upper limit of a logarithmic axis relative to the largest value; margin of levels
DECADES = 5  # limit of the decades of a logarithmic axis below the largest value

Spectrum = Callable[[np.ndarray, float], CurvePoints]


def _spectrum_of(figure: "Figure", band: tuple[float, float]) -> Spectrum:
    """Return the function that computes the spectrum of a kind of figure; band: of envelopes (Hz)."""
    from bearingsim import signals

    def spectrum(values: np.ndarray, rate: float) -> CurvePoints:
        return signals.envelope_spectrum(values, rate, band)

    return spectrum if figure.kind == "envelope" else signals.spectrum


def _band_of(figure: "Figure", records: Mapping[str, Job]) -> tuple[float, float]:
    """Return the band (Hz) of the envelopes of all curves: that of the view, else the passband of all records."""
    passband = PASSBAND * min(float(job.parameters["sampling"]) for job in records.values())
    return figure.view.band or (0.0, passband)


def _envelope_label(channel: str) -> str:
    return f"Squared envelope of the {channel[:1].lower()}{channel[1:]}"


def spectra_of(results: "Results", figure: "Figure", jobs: Sequence[str]) -> Content:
    """Compute the spectra, or envelope spectra, of channels.

    Raises PlotError for a channel that was not recorded, and for a spectrum that is too coarse.
    """
    records = recorded.load_jobs(results, jobs)
    limits = frequency_range(figure, records.values())
    band, is_envelope = _band_of(figure, records), figure.kind == "envelope"
    spectrum = _spectrum_of(figure, band)
    if figure.view.band:
        recorded.check_passband("band", figure.view.band, *records.values())

    def curve(name: str, job: Job, channel: str, signal: Signal) -> CurvePoints:
        leading = records[name]
        if is_envelope:
            recorded.check_rate(signal, band[1])
        window = window_of(
            results, name, leading, channel, figure.view, float(signal.time[-1]), passes=AROUND_PASSES
        )
        frequency, amplitude = compute_spectrum(spectrum, crop(signal, window), limits, name, leading)
        resolution = f"{frequency[1] - frequency[0]:.3g} Hz between lines"
        if resolution not in notes:
            notes.append(resolution)
        return frequency, amplitude

    notes = [_quantity(figure, band), "Hann window"]
    y_label, power = (_envelope_label, 2) if is_envelope else (str, 1)
    display = Display(curve, "Frequency (Hz)", notes, y_label, power, amplitude=True)
    return compute_content(results, records, recorded.channels_for(records, figure.y), figure, display)


def draw(results: "Results", figure: "Figure", jobs: Sequence[str]) -> list[Sheet]:
    """Draw spectra of channels, of amplitude (a sine of amplitude A has height A) or of the squared envelope."""
    content = spectra_of(results, figure, jobs)
    panels = draw_grid(content, figure.title, sideband_entries(job for row in content.jobs for job in row))
    limits = frequency_range(figure, (job for row in panels.jobs for job in row))
    marked: list[Job] = []
    for row, jobs_of_row in zip(panels.axes, panels.jobs, strict=True):
        has_marks = share_lines(jobs_of_row)
        is_named = not marked or not share_lines([marked[-1], jobs_of_row[0]])
        for ax in row:
            _set_scales(ax, figure, *limits)
            with_orders = figure.view.orders and row is panels.axes[0]
            if with_orders:
                _add_orders(ax, [job for row in panels.jobs for job in row])
            if has_marks:
                mark_lines(ax, jobs_of_row[0], named=is_named, above=ORDERS_POINTS if with_orders else 0.0)
        marked += jobs_of_row[:1] if has_marks else []
    panels.share_scales()
    for ax in (ax for row in panels.axes for ax in row):
        _limit_range(ax, figure)
    return [Sheet(file_words(figure, jobs), panels.canvas)]


def frequency_range(figure: "Figure", jobs: Iterable[Job]) -> tuple[float, float]:
    """Return the frequencies (Hz) to show: those of the view, else some multiples of the fundamental line.

    Raises PlotError for frequencies beyond the passband of the records.
    """
    jobs = list(jobs)
    if figure.view.range is None:
        flat = PASSBAND * min(float(job.parameters["sampling"]) for job in jobs)
        fundamental = max(fundamental_frequency(job.parameters) for job in jobs)
        return 0.0, min((SHOWN_LINES.get(figure.kind, 12) + 0.5) * fundamental, flat)
    recorded.check_passband("range", figure.view.range, *jobs)
    return figure.view.range


def compute_spectrum(
    spectrum: Spectrum, signal: Signal, limits: tuple[float, float], name: str, job: Job
) -> CurvePoints:
    """Compute the spectrum of whole ball passes of a signal between two frequencies (Hz).

    name, job: id and record of the job whose ball passes count. Raises PlotError for fewer than ``MIN_BINS``
    frequencies.
    """
    frequency, amplitude = spectrum(*whole_periods(signal, fundamental_frequency(job.parameters)))
    in_range = (frequency >= limits[0]) & (frequency <= limits[1])
    source = signal.source or f"job {name}"
    if frequency[-1] <= limits[0]:
        raise PlotError(
            f"{source} is sampled at {signal.rate:g} Hz, too slowly for {limits[0]:g} to {limits[1]:g} Hz"
        )
    if np.count_nonzero(in_range) < MIN_BINS:
        part = f"{1e3 * len(signal.time) / signal.rate:.3g} ms of {source} resolve {frequency[1]:.3g} Hz"
        raise PlotError(
            f"{part}, too coarse for {limits[0]:g} to {limits[1]:g} Hz; show a longer part of the record"
        )
    return frequency[in_range], amplitude[in_range]


def whole_periods(signal: Signal, frequency: float) -> tuple[np.ndarray, float]:
    """Trim a signal to whole periods of ``frequency`` (Hz), if it has any; return its values and sampling rate."""
    from bearingsim import signals

    return signals.cut_to_whole_periods(signal.values, signal.rate, frequency), signal.rate


def _quantity(figure: "Figure", band: tuple[float, float]) -> str:
    """Name the plotted quantity, with the band (Hz) of an envelope."""
    if figure.kind != "envelope":
        return "amplitude spectrum"
    low, high = band
    return f"amplitude spectrum of the squared envelope of {low / 1e3:.4g} to {high / 1e3:.4g} kHz"


# Axes


def _set_scales(ax: "Axes", figure: "Figure", low: float, high: float) -> None:
    ax.set_xlim(low, high)
    if "x" in figure.log:
        ax.set_xlim(max(low, high * 1e-3), high)
        ax.set_xscale("log")
    if "y" in figure.log:
        ax.set_yscale("log", nonpositive="clip")
        ax.set_ylim(10.0**-DECADES * ax.dataLim.y1, HEADROOM * ax.dataLim.y1)
    elif figure.view.db:
        ax.set_ylim(ax.dataLim.y0 - MARGIN_DB, ax.dataLim.y1 + MARGIN_DB)
    else:
        ax.set_ylim(bottom=0.0)


def _limit_range(ax: "Axes", figure: "Figure") -> None:
    """Limit a logarithmic axis, or one of levels, to a range below its largest value."""
    low, high = ax.get_ylim()
    if "y" in figure.log:
        ax.set_ylim(high / HEADROOM * 10.0**-DECADES, high)
    elif figure.view.db:
        ax.set_ylim(max(low, high - RANGE_DB - 2.0 * MARGIN_DB), high)


def _add_orders(ax: "Axes", jobs: Sequence[Job]) -> None:
    """Add an axis in orders of the shaft's speed above the axes. Raises PlotError if jobs differ in speed, or one
    changes."""
    speeds = {lines.frequency(lines.SHAFT, job.parameters) for job in jobs}
    if len(speeds) > 1 or any(recorded.has_ramp(job) for job in jobs):
        reason = "the speed changes in a ramp" if len(speeds) == 1 else "the jobs differ in speed"
        raise PlotError(f"a frequency has no single order, because {reason}: omit `orders`")
    shaft = speeds.pop()
    functions = (partial(np.multiply, 1.0 / shaft), partial(np.multiply, shaft))
    axis = ax.secondary_xaxis("top", functions=functions)
    axis.set_xlabel(f"Order of the shaft frequency, {labels.number_text(shaft)} Hz", fontsize=8.0)
    raise_title(ax, ORDERS_POINTS + GAP_POINTS + ROW_POINTS)
