"""Marks in spectra: the spectral lines of the defects and their sidebands, with names and frequencies."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D

from bearingsim.plots import lines, recorded
from bearingsim.plots.recorded import Job
from bearingsim.plots.style import COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MARK_COLOURS = {"outer": COLOURS[1], "inner": COLOURS[3], "roller": COLOURS[2]}
DASHED = (0, (2, 2))
MIN_MARK_DISTANCE = 0.02  # minimum distance of marks, relative to the length of the axis
MIN_NAME_DISTANCE_IN = 0.56  # inches, minimum distance of the names of marks
CHARACTER_IN = 0.069  # inches, width of a character of a name
GAP_POINTS, ROW_POINTS = 2.0, 8.0  # points, distance of the lowest row of names from the axes, height of a row
ROUND_STEPS = (1, 2, 5, 10, 20, 50, 100, 200, 500)
"""Steps of the harmonics that are marked or named."""
ALIGNMENTS = {-1: ("right", 1.0), 0: ("center", 0.5), 1: ("left", 0.0)}
"""Alignment of a name, and the fraction of its width left of the mark, by side of the sideband (0: harmonic)."""


def share_lines(jobs: Sequence[Job]) -> bool:
    """Check if all jobs have defects of the same elements, and the same, constant fundamental frequency."""
    races = {tuple(lines.races(job.parameters)) for job in jobs}
    fundamentals = [fundamental_frequency(job.parameters) for job in jobs]
    steady = not any(recorded.has_ramp(job) for job in jobs)
    return steady and len(races) == 1 and max(fundamentals) <= (1.0 + 1e-9) * min(fundamentals)


def fundamental_frequency(parameters: Mapping[Any, Any]) -> float:
    """Compute the fundamental frequency (Hz) of the first family with a defect in a job; BPFO if it is healthy."""
    return lines.frequency(lines.FAMILIES[(lines.races(parameters) or ["outer"])[0]].fundamental, parameters)


def mark_lines(ax: "Axes", job: Job, named: bool, above: float = 0.0) -> None:
    """Mark the lines of the defects' families, or of BPFO if there is no defect; sidebands are dashed.

    named: True to write names between the axes and their title; above: distance (points) of the names from the
    axes, in addition to ``GAP_POINTS``. Each family has a row of names of harmonics, and below it a row of names
    of sidebands if any fits. Marks and names too close to others are omitted.
    """
    low, high = ax.get_xlim()
    height = above + GAP_POINTS
    for race in lines.races(job.parameters) or ["outer"]:
        colour = MARK_COLOURS[race]
        marks = [mark for mark in lines.marks(job.parameters, high) if mark.race == race]
        marks = [mark for mark in marks if low <= mark.frequency <= high]
        fundamental = lines.frequency(lines.FAMILIES[race].fundamental, job.parameters)
        drawn_marks = _select_apart(marks, fundamental, MIN_MARK_DISTANCE * (high - low))
        for mark in drawn_marks:
            dashes: Mapping[str, Any] = {"ls": DASHED, "alpha": 0.4} if mark.side else {"alpha": 0.5}
            ax.axvline(mark.frequency, color=colour, lw=0.7, zorder=0.9, **dashes)
        if named:
            distance = MIN_NAME_DISTANCE_IN / _width(ax) * (high - low)
            harmonics = _select_apart([mark for mark in marks if not mark.side], fundamental, distance)
            sidebands = [mark for mark in drawn_marks if mark.side and mark.number]
            for row in (sidebands, [*(mark for mark in drawn_marks if not mark.number), *harmonics]):
                height += ROW_POINTS * _name_marks(ax, row, colour, height)
    if named:
        raise_title(ax, height)


def raise_title(ax: "Axes", points: float) -> None:
    """Move the title of the axes to ``points`` above them."""
    ax.set_title(ax.get_title(loc="left"), loc="left", fontsize=8, pad=points + 1.0)


def _name_marks(ax: "Axes", marks: Sequence[lines.Mark], colour: str, height: float) -> bool:
    """Write names of marks in a row, at ``height`` points above the axes; return True if any fits.

    The names of sidebands and of the fundamental line include the frequency, those of other harmonics only if all
    fit. Names of sidebands are on the outer side of their marks. Names that would overlap others are omitted.
    """
    character_width = CHARACTER_IN / _width(ax)  # part of the axis
    to_axes = ax.transData + ax.transAxes.inverted()
    positions = [float(to_axes.transform((mark.frequency, 0.0))[0]) for mark in marks]
    longest = max((len(_with_frequency(mark)) for mark in marks), default=0)
    has_room = character_width * longest < min(np.diff(positions), default=1.0)
    occupied: list[tuple[float, float]] = []
    for mark, position in sorted(
        zip(marks, positions, strict=True), key=lambda pair: (pair[0].number != 1, pair[1])
    ):
        alignment, part = ALIGNMENTS[mark.side if mark.number else 0]
        for text in _name_texts(mark, has_room):
            left = position - part * character_width * len(text)
            right = left + character_width * len(text)
            is_inside = alignment == "center" or 0.0 <= left < right <= 1.0
            if is_inside and all(right <= start or left >= end for start, end in occupied):
                occupied.append((left, right))
                ax.annotate(text, (mark.frequency, 1.0), (0, height), xycoords=("data", "axes fraction"),
                            textcoords="offset points", ha=alignment, fontsize=7, color=colour)  # fmt: skip
                break
    return bool(occupied)


def _name_texts(mark: lines.Mark, has_room: bool) -> list[str]:
    """List the alternative texts of a name, the longest first."""
    if mark.side and mark.number:
        return [_with_frequency(mark), *([f"{mark.frequency:.1f} Hz"] if mark.number == 1 else [])]
    return [_with_frequency(mark), mark.name] if has_room or mark.number <= 1 else [mark.name]


def _with_frequency(mark: lines.Mark) -> str:
    return f"{mark.name} {mark.frequency:.1f} Hz"


def _width(ax: "Axes") -> float:
    """Return the approximate width (inches) of the axes."""
    canvas, subplot = ax.get_figure(root=True), ax.get_subplotspec()
    assert canvas is not None
    assert subplot is not None
    return float(canvas.get_size_inches()[0]) / subplot.get_gridspec().ncols


def _select_apart(marks: Sequence[lines.Mark], fundamental: float, distance: float) -> list[lines.Mark]:
    """Select the fundamental, and harmonics in steps of a round number that are ``distance`` (Hz) or more apart.

    Their sidebands are included if every harmonic is selected, and the sidebands are at least ``distance``/3 from
    the harmonics.
    """
    stride = next((step for step in ROUND_STEPS if step * fundamental >= distance), ROUND_STEPS[-1])
    spacings = [abs(mark.frequency - mark.number * fundamental) for mark in marks if mark.side]
    with_sidebands = stride == 1 and min(spacings, default=0.0) >= distance / 3.0
    selected = [mark for mark in marks if mark.number == 1 or mark.number % stride == 0]
    return [mark for mark in selected if with_sidebands or not mark.side]


def sideband_entries(jobs: Iterable[Job]) -> list[Line2D]:
    """Make legend entries that explain the dashed lines, the sidebands."""
    steady = [job for job in jobs if not recorded.has_ramp(job)]
    elements = dict.fromkeys(race for job in steady for race in lines.races(job.parameters))
    entries = []
    for race in elements:
        family = lines.FAMILIES[race]
        if family.modulation:
            distances = {f"{lines.frequency(family.modulation, job.parameters):.4g} Hz" for job in steady}
            text = f"± {family.spacing_name}" + (f" ({distances.pop()})" if len(distances) == 1 else "")
            entries.append(Line2D([], [], color=MARK_COLOURS[race], lw=0.7, ls=DASHED, label=text))
    return entries
