"""Time series and spectra of some jobs: a row of axes per job, a column per channel."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure as Canvas
from matplotlib.lines import Line2D

from bearingsim.config.names import Line, roller_of
from bearingsim.plots import labels, lines, recorded
from bearingsim.plots.grid import Curve, View, grid
from bearingsim.plots.recorded import Job, Signal
from bearingsim.plots.style import COLOURS

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from bearingsim.store import Results

SHOWN_PASSES = {
    "ring.": 8,
    "load_zone.": 8,
    "roller.": 26,
}  # ball passes shown, by channel; other channels are shown in full
SHOWN_IN_SECONDS = 0.5  # s; shorter time axes are in ms
SHOWN_LINES = 6  # multiples of the fundamental line shown in a spectrum
SOME = 3
MARK_COLOURS = {"outer": COLOURS[1], "inner": COLOURS[3], "roller": COLOURS[2]}
DASHED = (0, (2, 2))


def done_jobs(rows: "pd.DataFrame") -> list[str]:
    """List the ids of the finished cases in the rows."""
    return list(rows[rows["status"] == "done"]["job"])


def some_jobs(rows: "pd.DataFrame") -> list[str]:
    """List the ids of the first, a middle and the last finished case in the rows."""
    done = done_jobs(rows)
    return list(dict.fromkeys(done[round(i * (len(done) - 1) / (SOME - 1))] for i in range(SOME))) if done else []


# Curves


def first_line(parameters: Mapping[Any, Any]) -> float:
    """Compute the fundamental frequency (Hz) of the job's defects."""
    return lines.frequency(lines.FAMILIES[(lines.races(parameters) or ["outer"])[0]].fundamental, parameters)


def whole_periods(signal: Signal, frequency: float) -> np.ndarray:
    """Trim a signal to a whole number of periods of ``frequency`` (Hz); return all of it if shorter than one."""
    periods = int(len(signal.time) / signal.rate * frequency + 1e-9)
    count = min(len(signal.time), round(periods * signal.rate / frequency))
    return signal.values[: count or None]


def amplitude_spectrum(signal: Signal, frequency: float) -> Curve:
    """Compute the amplitude spectrum (Hz, SI) over whole periods of ``frequency`` (Hz), Hann window.

    A sine of amplitude A gives a peak of height A.
    """
    from bearingsim import signals

    return signals.spectrum(whole_periods(signal, frequency), signal.rate)


def envelope_spectrum(signal: Signal, frequency: float) -> Curve:
    """Compute the squared-envelope spectrum (Hz, SI) over whole periods of ``frequency`` (Hz)."""
    from bearingsim import signals

    return signals.envelope_spectrum(whole_periods(signal, frequency), signal.rate)


def _shown_spectrum(spectrum: Callable[[Signal, float], Curve], job: Job, _: str, signal: Signal) -> Curve:
    fundamental = first_line(job.parameters)
    frequency, amplitude = spectrum(signal, fundamental)
    shown = frequency <= (SHOWN_LINES + 0.5) * fundamental
    return frequency[shown], amplitude[shown]


def _beginning(span: float | None, scale: float, job: Job, channel: str, signal: Signal) -> Curve:
    shown = signal.time <= (shown_time(job, channel) if span is None else span)
    return signal.time[shown] / scale, recorded.drawn_values(job, channel, signal)[shown]


def shown_time(job: Job, channel: str) -> float:
    """Return the duration (s) of a series to draw, from ``SHOWN_PASSES``."""
    passes = next((passes for start, passes in SHOWN_PASSES.items() if channel.startswith(start)), np.inf)
    if _has_ramp(job):
        passes = np.inf
    return float(
        min(
            passes / lines.frequency(lines.FAMILIES["outer"].fundamental, job.parameters),
            job.parameters["duration"],
        )
    )


def _has_ramp(job: Job) -> bool:
    return bool(job.parameters.get("ramp.to", np.nan) > 0.0)


def roller_angle(job: Job, number: int) -> np.ndarray:
    """Compute the angle (n,) of a roller (from 1) during the record: rad from the load line, increasing.

    Uses the recorded speed or slip of the cage, else pure rolling, and neglects the pocket clearance, since the
    position in the pocket is not recorded. Raises PlotError for a varying speed.
    """
    if _has_ramp(job):
        raise labels.PlotError("roller angles are not available during a ramp; use `--kind series`")
    series, parameters = job.series, job.parameters
    omega_c = 2.0 * pi * lines.frequency(Line(cage=1), parameters)
    speed = omega_c * (1.0 - np.asarray(series.channels.get("cage.slip", np.zeros(len(series.time))), np.float64))
    speed = np.asarray(series.channels.get("cage.speed", speed), np.float64)
    turned = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(series.time))])
    between = 2.0 * pi * (number - 1) / parameters["bearing.rollers"]
    return np.asarray(float(job.info["cage_angle_start_rad"]) + between + turned)


def _round(job: Job, channel: str, signal: Signal) -> Curve:
    """Return the signal over the roller's angle (deg, from the load line), with a gap after each revolution."""
    number, _ = roller_of(channel) or (1, "")
    angle = np.degrees(roller_angle(job, number) + pi) % 360.0 - 180.0
    ends = np.flatnonzero(np.diff(angle) < 0.0) + 1
    return np.insert(angle, ends, np.nan), np.insert(recorded.drawn_values(job, channel, signal), ends, np.nan)


# Drawing


def draw_series(
    results: "Results", jobs: Sequence[str], y: Sequence[str] = (), span: float | None = None
) -> Canvas:
    """Draw channels over time, a row per job, with its healthy baseline in dark grey.

    ``span``: time shown (s).
    """
    records = recorded.all_jobs(results, jobs)
    channels = recorded.channels_for(records, y)
    longest = max(shown_time(job, channel) for job in records.values() for channel in channels)
    unit, scale = ("s", 1.0) if (span or longest) >= SHOWN_IN_SECONDS else ("ms", 1e-3)
    view = View(partial(_beginning, span, scale), f"Time ({unit})", str)
    return grid(results, records, channels, view)[0]


def draw_spectrum(
    results: "Results",
    jobs: Sequence[str],
    y: Sequence[str] = (),
    spectrum: Callable[[Signal, float], Curve] = amplitude_spectrum,
    of: str = "Amplitude of the {}",
    power: int = 1,
) -> Canvas:
    """Draw the amplitude spectrum of channels like ``draw_series``, with the lines of the defects marked."""
    records = recorded.all_jobs(results, jobs)
    view = View(
        partial(_shown_spectrum, spectrum),
        "Frequency (Hz)",
        lambda text: of.format(text[:1].lower() + text[1:]),
        power,
    )
    canvas, axes = grid(results, records, recorded.channels_for(records, y), view)
    for row, job in zip(axes, records.values(), strict=True):
        for ax in row:
            ax.set_ylim(bottom=0.0)
            ax.set_xlim(0.0, (SHOWN_LINES + 0.5) * first_line(job.parameters))
            if not _has_ramp(job):
                _mark_lines(ax, job, named=row is axes[0])
    _name_sidebands(canvas, records.values())
    return canvas


def draw_roller(results: "Results", jobs: Sequence[str], y: Sequence[str] = ()) -> Canvas:
    """Draw the recorded channels of a roller over its angle from the load line."""
    records = recorded.all_jobs(results, jobs)
    channels = recorded.channels_for(records, y, prefix="roller.")
    if not y:
        names = [name for name in next(iter(records.values())).recorded if not recorded.is_of_slice(name)]
        number = (roller_of(channels[0]) or (1, ""))[0]
        channels = [name for name in names if (roller_of(name) or (0, ""))[0] == number]
    for name in channels:
        if roller_of(name) is None:
            raise labels.PlotError(f"`{name}` is not a roller channel; use `--kind series`")
    view = View(_round, "Angle of the roller (°)", str, baselines=False)
    canvas, axes = grid(results, records, channels, view)
    for row, job in zip(axes, records.values(), strict=True):
        for ax in row:
            ax.set_xlim(-180.0, 180.0)
            ax.set_xticks(range(-180, 181, 90))
            for angle in _outer_defects(job.parameters):
                ax.axvline(np.degrees(angle), color=MARK_COLOURS["outer"], lw=0.7, alpha=0.6, zorder=0.9)
    return canvas


def _outer_defects(parameters: Mapping[Any, Any]) -> list[float]:
    """List the angles (rad) of the stationary defects."""
    heads = [str(name).removesuffix(".race") for name in parameters if str(name).endswith(".race")]
    return [parameters[f"{head}.angle"] for head in heads if parameters[f"{head}.race"] == "outer"]


DRAW: dict[str, Callable[..., Canvas]] = {
    "series": draw_series,
    "spectrum": draw_spectrum,
    "envelope": partial(draw_spectrum, spectrum=envelope_spectrum, of="Squared envelope of the {}", power=2),
    "roller": draw_roller,
}
"""Drawing functions by kind of figure."""


def _mark_lines(ax: "Axes", job: Job, named: bool) -> None:
    """Mark the lines of the defects' families, sidebands dashed; names are above, one height per family."""
    elements = lines.races(job.parameters) or ["outer"]
    for mark in lines.marks(job.parameters, ax.get_xlim()[1]):
        colour = MARK_COLOURS[mark.race]
        dashes: Mapping[str, Any] = {"ls": DASHED, "alpha": 0.4} if mark.sideband else {"alpha": 0.5}
        ax.axvline(mark.hertz, color=colour, lw=0.7, zorder=0.9, **dashes)
        if named and not mark.sideband:
            ax.annotate(mark.name, (mark.hertz, 1.0), (0, 2 + 8 * elements.index(mark.race)),
                        xycoords=("data", "axes fraction"), textcoords="offset points", ha="center",
                        fontsize=7, color=colour)  # fmt: skip


def _name_sidebands(canvas: Canvas, jobs: Iterable[Job]) -> None:
    """Add the meaning of the dashed lines to the legend."""
    elements = dict.fromkeys(race for job in jobs if not _has_ramp(job) for race in lines.races(job.parameters))
    entries = [
        Line2D(
            [], [], color=MARK_COLOURS[race], lw=0.7, ls=(0, (2, 2)), label=f"± {lines.FAMILIES[race].distance}"
        )
        for race in elements
        if lines.FAMILIES[race].beside
    ]
    if entries:
        shown = canvas.legends[0] if canvas.legends else None
        old = list(shown.legend_handles) if shown else []
        if shown:
            shown.remove()
        handles = [*(handle for handle in old if handle is not None), *entries]
        canvas.legend(handles=handles, loc="outside upper right", ncols=len(handles))
