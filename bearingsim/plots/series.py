"""Series and spectra of chosen jobs: a row of axes per job, a column per channel."""

import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from math import pi
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure as Canvas
from matplotlib.lines import Line2D

from bearingsim.config.names import Line, roller_of
from bearingsim.plots import labels, lines, recorded, select
from bearingsim.plots.caption import fixed_values
from bearingsim.plots.recorded import Job, Signal
from bearingsim.plots.style import COLOURS, COLUMN_IN
from bearingsim.plots.sweep import axis_label, finish, share_scales

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from bearingsim.store import Results

__all__ = ["DRAW", "amplitude_spectrum", "done_jobs", "roller_angle", "some_jobs"]

SHOWN_PASSES = {"ring.": 8, "load_zone.": 8, "roller.": 26}  # of a series, in ball passes; of others all
SHOWN_IN_SECONDS = 0.5  # s: shorter times stand in ms
SHOWN_LINES = 6  # multiples of the first line in a spectrum
SOME = 3
ROW_IN, LOW_ROW_IN = 1.7, 1.15
MANY = 6  # jobs above which rows are low
HEALTHY = "0.35"
MARK_COLOURS = {"outer": COLOURS[1], "inner": COLOURS[3], "roller": COLOURS[2]}
PARTS = {"": COLOURS[0], "x": COLOURS[2], "y": COLOURS[3]}
LABEL_LETTERS, LETTER_IN = 26, 0.075
SQUARES = 3.0  # a square reads well from 0.1 on
DASHED = (0, (2, 2))

Curve = tuple[np.ndarray, np.ndarray]


class View(NamedTuple):
    """A way to look at signals: their curve, in SI; what stands on the axes; the power of the channel's unit.

    twins: whether the healthy twin is drawn too, where a channel has one curve.
    """

    curve: Callable[[Job, str, Signal], Curve]
    x_label: Callable[[str], str]
    y_label: Callable[[str], str]
    power: int = 1
    twins: bool = True


def done_jobs(rows: "pd.DataFrame") -> list[str]:
    """The finished cases among some rows of the table."""
    return list(rows[rows["status"] == "done"]["job"])


def some_jobs(rows: "pd.DataFrame") -> list[str]:
    """A few finished cases from all over some rows of the table: the first, the last, one between."""
    done = done_jobs(rows)
    return list(dict.fromkeys(done[round(i * (len(done) - 1) / (SOME - 1))] for i in range(SOME))) if done else []


# Curves


def first_line(known: Mapping[Any, Any]) -> float:
    """The frequency (Hz) of the first line of the job's defects."""
    return lines.frequency(lines.FAMILIES[(lines.races(known) or ["outer"])[0]].first, known)


def whole_periods(signal: Signal, frequency: float) -> np.ndarray:
    """The signal's values over a whole number of periods of a frequency (Hz); all if it is shorter than one."""
    periods = int(len(signal.time) / signal.rate * frequency + 1e-9)
    count = min(len(signal.time), round(periods * signal.rate / frequency))
    return signal.values[: count or None]


def amplitude_spectrum(signal: Signal, frequency: float) -> Curve:
    """Frequencies (Hz) and amplitudes of the lines, over whole periods of a frequency (Hz), Hann window.

    A sine of amplitude A gives a peak of height A.
    """
    from bearingsim import signals

    return signals.spectrum(whole_periods(signal, frequency), signal.rate)


def envelope_spectrum(signal: Signal, frequency: float) -> Curve:
    """Frequencies (Hz) and amplitudes of the squared envelope's lines, over whole periods of a frequency (Hz)."""
    from bearingsim import signals

    return signals.envelope_spectrum(whole_periods(signal, frequency), signal.rate)


def _shown_spectrum(spectrum: Callable[[Signal, float], Curve], job: Job, _: str, signal: Signal) -> Curve:
    first = first_line(job.known)
    frequency, amplitude = spectrum(signal, first)
    shown = frequency <= (SHOWN_LINES + 0.5) * first
    return frequency[shown], amplitude[shown]


def _beginning(span: float | None, scale: float, job: Job, channel: str, signal: Signal) -> Curve:
    shown = signal.time <= (shown_time(job, channel) if span is None else span)
    return signal.time[shown] / scale, signal.values[shown]


def shown_time(job: Job, channel: str) -> float:
    """How much of a series is worth showing (s): what is fast only for some ball passes."""
    passes = next((passes for start, passes in SHOWN_PASSES.items() if channel.startswith(start)), np.inf)
    if _has_ramp(job):
        passes = np.inf
    return float(min(passes / lines.frequency(lines.FAMILIES["outer"].first, job.known), job.known["duration"]))


def _has_ramp(job: Job) -> bool:
    return bool(job.known.get("ramp.to", np.nan) > 0.0)


def roller_angle(job: Job, number: int) -> np.ndarray:
    """Where a roller (from 1) was during the record: rad from the load line, growing.

    From the recorded speed or slip of the cage, or else as if it did not slip during the record. A roller's place
    in its pocket is not known. Raises PlotError for a speed that changes.
    """
    if _has_ramp(job):
        raise labels.PlotError("under a ramp the rollers' angles are not known: draw the series instead")
    series, known = job.series, job.known
    omega_c = 2.0 * pi * lines.frequency(Line(cage=1), known)
    speed = omega_c * (1.0 - np.asarray(series.channels.get("cage.slip", np.zeros(len(series.time))), np.float64))
    speed = np.asarray(series.channels.get("cage.speed", speed), np.float64)
    turned = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(series.time))])
    between = 2.0 * pi * (number - 1) / known["bearing.rollers"]
    return np.asarray(float(job.info["cage_angle_start_rad"]) + between + turned)


def _round(job: Job, channel: str, signal: Signal) -> Curve:
    """The signal over the roller's angle (deg, from the load line), broken where a turn ends."""
    number, _ = roller_of(channel) or (1, "")
    angle = np.degrees(roller_angle(job, number) + pi) % 360.0 - 180.0
    ends = np.flatnonzero(np.diff(angle) < 0.0) + 1
    return np.insert(angle, ends, np.nan), np.insert(signal.values, ends, np.nan)


# Drawing


def draw_series(
    results: "Results", jobs: Sequence[str], y: Sequence[str] = (), span: float | None = None
) -> Canvas:
    """Channels over time, a panel per job, its healthy twin in dark grey; ``span``: so much of them (s)."""
    found = recorded.all_jobs(results, jobs)
    channels = recorded.channels_for(found, y)
    longest = max(shown_time(job, channel) for job in found.values() for channel in channels)
    unit, scale = ("s", 1.0) if (span or longest) >= SHOWN_IN_SECONDS else ("ms", 1e-3)
    view = View(partial(_beginning, span, scale), lambda _: f"Time ({unit})", recorded.text_of)
    return _grid(results, found, channels, view)[0]


def draw_spectrum(
    results: "Results",
    jobs: Sequence[str],
    y: Sequence[str] = (),
    spectrum: Callable[[Signal, float], Curve] = amplitude_spectrum,
    of: str = "Amplitude of the {}",
    power: int = 1,
) -> Canvas:
    """Amplitude spectrum of channels, the lines of the defects' families marked, else like ``draw_series``."""
    found = recorded.all_jobs(results, jobs)
    view = View(
        partial(_shown_spectrum, spectrum),
        lambda _: "Frequency (Hz)",
        lambda channel: of.format(_lowered(recorded.text_of(channel))),
        power,
    )
    canvas, axes = _grid(results, found, recorded.channels_for(found, y), view)
    for row, job in zip(axes, found.values(), strict=True):
        for ax in row:
            ax.set_ylim(bottom=0.0)
            ax.set_xlim(0.0, (SHOWN_LINES + 0.5) * first_line(job.known))
            if not _has_ramp(job):
                _mark_lines(ax, job, named=row is axes[0])
    _name_sidebands(canvas, found.values())
    return canvas


def draw_roller(results: "Results", jobs: Sequence[str], y: Sequence[str] = ()) -> Canvas:
    """What a roller meets on its way round: its recorded channels over its angle from the load line."""
    found = recorded.all_jobs(results, jobs)
    channels = recorded.channels_for(found, y, prefix="roller.")
    if not y:
        known = next(iter(found.values())).recorded
        number = (roller_of(channels[0]) or (1, ""))[0]
        channels = [name for name in known if (roller_of(name) or (0, ""))[0] == number]
    for name in channels:
        if roller_of(name) is None:
            raise labels.PlotError(f"`{name}` is of no roller: draw its series instead")
    view = View(_round, lambda _: "Angle of the roller (°)", recorded.text_of, twins=False)
    canvas, axes = _grid(results, found, channels, view)
    for row, job in zip(axes, found.values(), strict=True):
        for ax in row:
            ax.set_xlim(-180.0, 180.0)
            ax.set_xticks(range(-180, 181, 90))
            for angle in _outer_pits(job.known):
                ax.axvline(np.degrees(angle), color=MARK_COLOURS["outer"], lw=0.7, alpha=0.6, zorder=0.9)
    return canvas


def _outer_pits(known: Mapping[Any, Any]) -> list[float]:
    """Angles (rad) of the pits that stand still."""
    heads = [str(name).removesuffix(".race") for name in known if str(name).endswith(".race")]
    return [known[f"{head}.angle"] for head in heads if known[f"{head}.race"] == "outer"]


DRAW: dict[str, Callable[..., Canvas]] = {
    "series": draw_series,
    "spectrum": draw_spectrum,
    "envelope": partial(draw_spectrum, spectrum=envelope_spectrum, of="Squared envelope of the {}", power=2),
    "roller": draw_roller,
}
"""By kind of figure."""


def _lowered(text: str) -> str:
    return text[:1].lower() + text[1:]


def _mark_lines(ax: "Axes", job: Job, named: bool) -> None:
    """A line at each line of the defects' families, sidebands dashed; names above, one height per family."""
    known = lines.races(job.known) or ["outer"]
    for mark in lines.marks(job.known, ax.get_xlim()[1]):
        colour = MARK_COLOURS[mark.race]
        dashes: Mapping[str, Any] = {"ls": DASHED, "alpha": 0.4} if mark.sideband else {"alpha": 0.5}
        ax.axvline(mark.hertz, color=colour, lw=0.7, zorder=0.9, **dashes)
        if named and not mark.sideband:
            ax.annotate(mark.name, (mark.hertz, 1.0), (0, 2 + 8 * known.index(mark.race)),
                        xycoords=("data", "axes fraction"), textcoords="offset points", ha="center",
                        fontsize=7, color=colour)  # fmt: skip


def _name_sidebands(canvas: Canvas, jobs: Iterable[Job]) -> None:
    """Beside the curves' legend entries what the dashed lines are."""
    known = dict.fromkeys(race for job in jobs if not _has_ramp(job) for race in lines.races(job.known))
    entries = [
        Line2D(
            [], [], color=MARK_COLOURS[race], lw=0.7, ls=(0, (2, 2)), label=f"± {lines.FAMILIES[race].distance}"
        )
        for race in known
        if lines.FAMILIES[race].beside
    ]
    if entries:
        shown = canvas.legends[0] if canvas.legends else None
        old = list(shown.legend_handles) if shown else []
        if shown:
            shown.remove()
        handles = [*(handle for handle in old if handle is not None), *entries]
        canvas.legend(handles=handles, loc="outside upper right", ncols=len(handles))


def _grid(
    results: "Results", jobs: dict[str, Job], channels: Sequence[str], view: View
) -> tuple[Canvas, list[list["Axes"]]]:
    """A row of axes per job, a column per channel with one unit; titles of what was swept; the healthy twins."""
    swept = {entry["job"]: entry["swept"] for entry in results.plan["jobs"]}
    twin_of = _twins(results, jobs) if view.twins else {}
    twins = recorded.all_jobs(results, sorted(set(twin_of.values())))
    height = LOW_ROW_IN if len(jobs) > MANY else ROW_IN
    size = (max(2, len(channels)) * COLUMN_IN, height * len(jobs) + (0.6 if len(jobs) > 1 else 1.0))
    canvas = Canvas(figsize=size, layout="constrained")
    made = canvas.subplots(len(jobs), len(channels), sharex="col", squeeze=False)
    axes = [list(row) for row in made]
    for column, channel in enumerate(channels):
        drawn = {job: _curves(one, channel, view) for job, one in jobs.items()}
        unit, factor = _unit(channel, view, drawn)
        for row, (job, curves) in zip(axes, drawn.items(), strict=True):
            known = job in twin_of and len(curves) == 1
            _panel(row[column], curves, _curves(twins[twin_of[job]], channel, view) if known else {}, factor)
        _name_axes([row[column] for row in axes], axis_label(view.y_label(channel), unit), len(channels) == 1)
        axes[-1][column].set_xlabel(view.x_label(channel))
    for row, job in zip(axes, jobs, strict=True):
        title = labels.described(swept[job], results.plan["units"])
        row[0].set_title(title, loc="left", fontsize=8, pad=11 if row is axes[0] else 4)
    share_scales(axes)
    _legend(canvas, [ax for row in axes for ax in row])
    rows = select.case_rows(results)
    finish(canvas, None, fixed_values(results, rows[rows["job"].isin(jobs)], set().union(*swept.values())))
    return canvas, axes


def _curves(job: Job, channel: str, view: View) -> dict[str, Curve]:
    """The curve of each component."""
    return {signal.component: view.curve(job, channel, signal) for signal in recorded.signals_of(job, channel)}


def _unit(channel: str, view: View, drawn: Mapping[str, Mapping[str, Curve]]) -> tuple[str, float]:
    """The unit of a column and the factor from SI that suits its largest value."""
    largest = max(float(np.nanmax(np.abs(y))) for curves in drawn.values() for _, y in curves.values())
    alike = (SQUARES if view.power == 2 else 1.0) * largest ** (1.0 / view.power)
    unit, factor = labels.readable(recorded.unit_of(channel), channel, alike)
    return (labels.squared(unit) if view.power == 2 else unit), factor**view.power


def _panel(ax: "Axes", curves: Mapping[str, Curve], healthy: Mapping[str, Curve], factor: float) -> None:
    for component, (x, y) in curves.items():
        name = component or ("with defect" if healthy else None)
        ax.plot(x, factor * y, color=PARTS[component], lw=0.9, label=name)
    for x, y in healthy.values():
        ax.plot(x, factor * y, color=HEALTHY, lw=0.9, label="healthy")
    ax.margins(x=0.0)


def _name_axes(column: Sequence["Axes"], label: str, only: bool) -> None:
    """The label of a column's y axes: once beside all of them if there is no other column."""
    if only and len(column) > 1:
        canvas = column[0].get_figure(root=True)
        assert canvas is not None
        letters = int(canvas.get_size_inches()[1] / LETTER_IN)
        canvas.supylabel(textwrap.fill(label, letters), fontsize=9.0)
        return
    for ax in column:
        ax.set_ylabel(textwrap.fill(label, LABEL_LETTERS), fontsize=8.0)


def _legend(canvas: Canvas, axes: Iterable["Axes"]) -> None:
    """One entry for each name that a curve has."""
    entries = {name: handle for ax in axes for handle, name in zip(*ax.get_legend_handles_labels(), strict=True)}
    if entries:
        canvas.legend(list(entries.values()), list(entries), loc="outside upper right", ncols=len(entries))


def _twins(results: "Results", jobs: Iterable[str]) -> dict[str, str]:
    """The healthy twins of some jobs, as far as they are done."""
    table = results.table().set_index("job")
    done = set(table.index[table["status"] == "done"])
    return {job: twin for job in jobs if (twin := str(table.loc[job, "healthy"])) in done}
