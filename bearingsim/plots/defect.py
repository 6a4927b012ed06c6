"""Defects to scale: depth map with the roller's length, and sections with the roller's path."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from math import floor, log10
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure as Canvas

from bearingsim.plots import labels, recorded, select
from bearingsim.plots.axes import finish, label_panel
from bearingsim.plots.caption import fixed_values
from bearingsim.plots.passage import (
    MARGIN,
    Defect,
    Reals,
    RollerPath,
    Section,
    compute_section,
    defects_of,
    distinct_sections,
    ends_of_slices,
    roller_path,
)
from bearingsim.plots.sheet import Sheet
from bearingsim.plots.style import COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from bearingsim.store import Results
    from bearingsim.study import Figure

MAP_IN, SECTION_IN = 4.2, 4.4  # height of the map, width of a section
MIN_SECTION_IN, MAX_SECTION_IN = 0.7, 1.9  # limits of the height of a section
MIN_MAP_RATIO, MAX_MAP_IN = 0.3, 5.0  # limits of the width of the map: relative to its length, and in inches
LEFT_IN, COLOUR_BAR_IN, RIGHT_IN = 0.65, 1.5, 0.2  # widths left of the map, right of it, and of the right margin
TITLE_IN, LABEL_IN, CAPTION_LINE_IN = 0.3, 0.55, 0.14  # heights of a title, of axis labels, of a caption line
MAP_MARGIN = 0.04  # margin around roller and defect, relative to their length
HEADROOM = 0.45  # height shown above the race, relative to the depth shown
SHALLOW_RATIO = 0.3  # depth of a path relative to that of the defect, below which it is repeated, magnified
MAGNIFIED_RATIO = 1.6  # depth shown in a magnified panel, relative to the depth of the path
ROLLER_POSITIONS = (-0.62, -0.25, 0.0, 0.25, 0.62)  # positions of the drawn rollers, in widths of the defect
COLOUR_MAP = "YlGnBu"
RACE_COLOUR, PATH_COLOUR, ROLLER_COLOUR, RECORDED_COLOUR = "0.15", COLOURS[1], "0.55", COLOURS[0]
ROUND_FACTORS = (1.0, 2.0, 5.0)  # mantissas of round factors


class Picture(NamedTuple):
    """Figure to draw: a defect, its jobs, and the roller.

    number, total: its number (from 1) in its case, and the number of defects; roller_length: contact length (m);
    slice_ends: ends of the roller's slices (m), empty without slices.
    """

    defect: Defect
    number: int
    total: int
    jobs: list[str]
    roller_length: float
    slice_ends: Reals


def collect_pictures(results: "Results", jobs: Sequence[str]) -> list[Picture]:
    """Collect the distinct defects of some finished jobs.

    Raises PlotError if no job has a defect, ResultsError if a job is not done.
    """
    distinct: dict[Any, Picture] = {}
    done = results.parameters()
    for name in jobs:
        if name not in done.index:
            results.series(name)  # raises ResultsError with the reason
    for job, parameters in done.loc[list(jobs)].iterrows():
        for picture in _job_pictures(results, str(job), parameters.to_dict()):
            earlier = distinct.setdefault(_key(picture), picture)
            if earlier is not picture:
                earlier.jobs.append(str(job))
    if not distinct:
        raise labels.PlotError("these cases have no defect to draw")
    return list(distinct.values())


def draw_defects(results: "Results", _: "Figure", jobs: Sequence[str]) -> list[Sheet]:
    """Draw a figure for each distinct defect of some jobs."""
    return [
        Sheet(
            ["pit", picture.jobs[0][:8], *([str(picture.number)] if picture.total > 1 else [])],
            draw_defect(results, picture),
        )
        for picture in collect_pictures(results, jobs)
    ]


def _job_pictures(results: "Results", job: str, parameters: Mapping[Any, Any]) -> Iterator[Picture]:
    from bearingsim.assemble.defects import contact_length

    case = recorded.case_of(results, job, parameters)
    defects = list(defects_of(case))
    for number, defect in enumerate(defects, 1):
        length = contact_length(case, side=1 if defect.race == "inner" else 0)
        yield Picture(defect, number, len(defects), [job], length, ends_of_slices(case))


def _key(picture: Picture) -> tuple[Any, ...]:
    """Return a hashable key that is equal for pictures that look the same."""
    defect, drawn = picture.defect, (picture.defect.depth_map, picture.slice_ends)
    numbers = np.round([defect.R, *defect.s, *defect.z, picture.roller_length], 9)
    return defect.race, *numbers, *(np.round(part, 12).tobytes() for part in drawn)


def draw_defect(results: "Results", picture: Picture) -> Canvas:
    """Draw one defect: its map, and its sections at the deepest point and the centre, with the roller's path.

    Lengths are to scale; the heights of a section are exaggerated by a round factor, printed in its title. A path
    much shallower than the defect is repeated in a magnified panel.
    """
    path = _roller_path(results, picture)
    panels = list(_make_panels(picture.defect, path[1] if path else None))
    map_width, map_height = _map_inches(picture)
    right = LEFT_IN + map_width + COLOUR_BAR_IN
    canvas = Canvas(figsize=(right + SECTION_IN + RIGHT_IN, 1.0))
    finish(canvas, _title(picture), _caption(results, picture, path))
    bottom = CAPTION_LINE_IN * (canvas.get_supxlabel().count("\n") + 1) + LABEL_IN
    stack = sum(panel.inches + TITLE_IN + LABEL_IN for panel in panels)
    head = TITLE_IN if canvas.get_suptitle() else 0.0
    canvas.set_size_inches(canvas.get_figwidth(), bottom + max(map_height + TITLE_IN, stack) + head)
    top = canvas.get_figheight() - head
    _draw_map(_axes_at(canvas, LEFT_IN, top - TITLE_IN - map_height, map_width, map_height), picture, panels)
    for number, panel in enumerate(panels, 1):
        top -= TITLE_IN + panel.inches
        ax = _axes_at(canvas, right, top, SECTION_IN, panel.inches)
        _draw_section(ax, panel, picture.defect.R, number)
        if path is not None:
            _draw_roller_path(ax, panel, path[1])
        top -= LABEL_IN
    _add_legend(ax, right, top)
    return canvas


def _axes_at(canvas: Canvas, left: float, bottom: float, width: float, height: float) -> "Axes":
    """Add axes at a position in inches, because their lengths are to scale."""
    canvas_width, canvas_height = canvas.get_size_inches()
    return canvas.add_axes(
        (left / canvas_width, bottom / canvas_height, width / canvas_width, height / canvas_height)
    )


def _add_legend(ax: "Axes", left: float, top: float) -> None:
    """Add the legend at a position in inches."""
    canvas = ax.get_figure(root=True)
    assert canvas is not None
    anchor = (left / canvas.get_figwidth(), top / canvas.get_figheight())
    position: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": anchor, "borderaxespad": 0.0}
    canvas.legend(*ax.get_legend_handles_labels(), ncols=4, fontsize=7.5, **position)


# The map


def _map_limits(picture: Picture) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the limits (m) of the map along rolling and along the roller, around roller and defect."""
    half = picture.roller_length / 2.0
    low, high = min(-half, picture.defect.z[0]), max(half, picture.defect.z[1])
    margin = MAP_MARGIN * (high - low)
    half_width = max(np.ptp(picture.defect.positions()), MIN_MAP_RATIO * (high - low)) / 2.0
    centre = (picture.defect.s[0] + picture.defect.s[1]) / 2.0
    return (centre - half_width, centre + half_width), (low - margin, high + margin)


def _map_inches(picture: Picture) -> tuple[float, float]:
    """Compute width and height of the map in inches."""
    s, z = _map_limits(picture)
    scale = min(MAP_IN / (z[1] - z[0]), MAX_MAP_IN / (s[1] - s[0]))
    return scale * (s[1] - s[0]), scale * (z[1] - z[0])


def _draw_map(ax: "Axes", picture: Picture, panels: "Sequence[Panel]") -> None:
    """Draw depth over s and z, with the roller's length, the ends of its slices and the section planes."""
    defect, half = picture.defect, 500.0 * picture.roller_length
    depths = 1e6 * np.ma.masked_equal(defect.depth_map, 0.0)
    s_mm, z_mm = 1e3 * defect.positions(), 1e3 * defect.axial_positions
    mesh = ax.pcolormesh(s_mm, z_mm, depths, cmap=COLOUR_MAP, shading="nearest",
                         vmin=min(0.0, float(depths.min())), rasterized=True, zorder=2)  # fmt: skip
    s, z = _map_limits(picture)
    ax.set_xlim(1e3 * s[0], 1e3 * s[1])
    ax.set_ylim(1e3 * z[0], 1e3 * z[1])
    ax.grid(visible=False)
    ax.axhspan(-half, half, color="0.95", zorder=0.5, lw=0.0)
    for end in (-half, half):
        ax.axhline(end, color="0.3", lw=0.9, zorder=3)
    ax.annotate("roller's end", (0.03, half), (0, 1), xycoords=("axes fraction", "data"),
                textcoords="offset points", va="bottom", fontsize=7, color="0.3", zorder=4)  # fmt: skip
    for end in picture.slice_ends[1:-1]:
        ax.axhline(1e3 * end, color="0.3", lw=0.3, alpha=0.7, zorder=3)
    highest = max(panel.section.z for panel in panels)
    for position, name in dict.fromkeys((panel.section.z, panel.name) for panel in panels):
        ax.axhline(1e3 * position, color=PATH_COLOUR, lw=0.8, ls=(0, (4, 2)), zorder=3)
        up, va = (2, "bottom") if position == highest else (-2, "top")
        ax.annotate(name, (0.98, 1e3 * position), (0, up), xycoords=("axes fraction", "data"), ha="right", va=va,
                    textcoords="offset points", fontsize=8, color=PATH_COLOUR, zorder=4)  # fmt: skip
    ax.set_xlabel("Along rolling, s (mm)")
    ax.set_ylabel("Along the roller, z (mm)")
    label_panel(ax, 0, 2, "to scale")
    gap = 0.12 / _map_inches(picture)[0]
    bar = ax.figure.colorbar(mesh, cax=ax.inset_axes((1.0 + gap, 0.2, gap, 0.6)))
    bar.set_label("Depth (µm)")
    bar.ax.invert_yaxis()


# Sections


class Panel(NamedTuple):
    """Section as drawn: its name on the map, limits of depth (m), exaggeration of heights, panel height (inches).

    is_magnified: True for the magnified copy of a section.
    """

    section: Section
    name: str
    top: float
    floor: float
    exaggeration: float
    inches: float
    is_magnified: bool


def _make_panels(defect: Defect, roller_path: RollerPath | None) -> Iterator[Panel]:
    """Yield the panels of the sections, and magnified panels of the first one for shallow paths."""
    for number, position in enumerate(distinct_sections(defect)):
        section, name = compute_section(defect, position), "AB"[number]
        deepest, path = (float(np.max(values)) for values in (section.p, section.h))
        depths = [deepest or float(defect.depth_map.max())]
        path_depths = [path, *([float(np.max(roller_path.depth_at(position)))] if roller_path else [])]
        depths += [
            MAGNIFIED_RATIO * shallower
            for deeper, shallower in pairwise([deepest, *path_depths])
            if 0.0 < shallower < SHALLOW_RATIO * deeper
        ]
        drawn_depths = depths if number == 0 else depths[:1]
        yield from (_make_panel(section, name, depth, is_magnified=n > 0) for n, depth in enumerate(drawn_depths))


def _make_panel(section: Section, name: str, depth: float, is_magnified: bool) -> Panel:
    top, bottom = min(float(np.min(section.p)), 0.0) - HEADROOM * depth, 1.08 * depth
    exaggeration = choose_exaggeration(np.ptp(section.s) / SECTION_IN, bottom - top)
    inches = exaggeration * (bottom - top) * SECTION_IN / np.ptp(section.s)
    return Panel(section, name, top, bottom, exaggeration, max(float(inches), MIN_SECTION_IN), is_magnified)


def choose_exaggeration(metres_per_inch: float, height: float) -> float:
    """Return the round factor by which a height (m) is exaggerated so that it fills a panel; 1 at least."""
    return max(1.0, round_below(MAX_SECTION_IN * metres_per_inch / height))


def round_below(limit: float) -> float:
    """Round down to 1, 2 or 5 times a power of ten."""
    decade = 10.0 ** floor(log10(limit))
    return max(step for step in ROUND_FACTORS if step * decade <= limit * (1.0 + 1e-9)) * decade


def _draw_section(ax: "Axes", panel: Panel, R: float, number: int) -> None:
    """Draw the defect, the path of a roller over it, and the roller at some positions; depth points down."""
    section = panel.section
    s, width = 1e3 * section.s, np.ptp(section.s)
    ax.fill_between(s, 1e6 * section.p, 1e6 * panel.floor, color="0.88", lw=0.0, zorder=1)
    ax.plot(s, 1e6 * section.p, color=RACE_COLOUR, lw=1.1, label="defect", zorder=3)
    ax.plot(s, 1e6 * section.h, color=PATH_COLOUR, lw=1.5, label="path of a rigid round roller", zorder=4)
    inner = width / (1.0 + 2.0 * MARGIN)
    for position, name in zip(ROLLER_POSITIONS, ["roller", *[None] * (len(ROLLER_POSITIONS) - 1)], strict=True):
        centre = float(np.mean(section.s)) + position * inner
        low = float(np.interp(centre, section.s, section.h))
        ax.plot(
            s,
            1e6 * (low - (section.s - centre) ** 2 / (2.0 * R)),
            color=ROLLER_COLOUR,
            lw=0.8,
            label=name,
            zorder=2,
        )
        ax.plot(1e3 * centre, 1e6 * low, "o", color=PATH_COLOUR, markersize=3, zorder=5)
    ax.set_xlim(s[0], s[-1])
    ax.set_ylim(1e6 * panel.floor, 1e6 * panel.top)
    ax.set_aspect(1e-3 * panel.exaggeration)
    ax.set_xlabel("s (mm)")
    ax.set_ylabel("Depth (µm)")
    scale_text = "to scale" if panel.exaggeration == 1.0 else f"heights ×{labels.number_text(panel.exaggeration)}"
    label_panel(ax, number, 2, f"section {panel.name}, {'enlarged, ' if panel.is_magnified else ''}{scale_text}")


def _draw_roller_path(ax: "Axes", panel: Panel, path: RollerPath) -> None:
    """Draw the recorded path of a roller, clipped to the panel."""
    ax.plot(
        1e3 * path.s,
        1e6 * path.depth_at(panel.section.z),
        color=RECORDED_COLOUR,
        lw=1.3,
        ls=(0, (4, 1.2)),
        label="recorded path",
        zorder=6,
    )


# Words


def _title(picture: Picture) -> str | None:
    where = {"outer": "the outer race", "inner": "the inner race", "roller": "a roller"}[picture.defect.race]
    return f"defect {picture.number} of {picture.total}, on {where}" if picture.total > 1 else None


def _roller_path(results: "Results", picture: Picture) -> tuple[str, RollerPath] | None:
    """Find the first job with a recorded roller path over the defect; return its id and the path, else None."""
    for job in picture.jobs:
        [record] = recorded.load_jobs(results, [job]).values()
        path = roller_path(record, recorded.case_of(results, job, record.parameters), picture.defect)
        if path is not None:
            return job, path
    return None


def _caption(results: "Results", picture: Picture, path: tuple[str, RollerPath] | None) -> list[str]:
    rows = select.case_rows(results)
    R = labels.number_text(round(1e3 * picture.defect.R, 2))
    texts = [f"raceway drawn flat, roller with its effective radius {R} mm"]
    if path is not None:
        swept = next(entry["swept"] for entry in results.plan["jobs"] if entry["job"] == path[0])
        case = labels.swept_text(swept, results.plan["units"])
        texts.append(f"path of roller {path[1].number} at {case or 'this case'}")
    return [*texts, *fixed_values(results, rows[rows["job"].isin(picture.jobs)], set())]
