"""Figure of the outer ring in static equilibrium over a ball pass, with exaggerated displacements."""

import warnings
from collections.abc import Iterator, Sequence
from math import cos, pi, sin
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure as Canvas
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from bearingsim.plots import labels, recorded, select
from bearingsim.plots.axes import finish, label_panel
from bearingsim.plots.caption import fixed_values
from bearingsim.plots.defect import round_below
from bearingsim.plots.ring_shape import AppliedForce, DefectMark, Instant, Reals, RingShape, ring_shape
from bearingsim.plots.sheet import Sheet
from bearingsim.plots.style import COLOURS, COLUMN_IN

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from bearingsim.store import Results
    from bearingsim.study import Figure

DISPLACEMENT_RATIO = 0.1  # largest displacement as drawn, relative to the outer radius
SPRING_RATIO, ARROW_RATIO, MARGIN_RATIO = 0.16, 0.2, 0.16  # lengths of springs, arrows and margins, relative to it
MIN_HALF_ANGLE = 0.035  # rad, minimum half angle of a defect as drawn
SENSOR_RATIO = 0.04  # distance of the sensor inside the carrier, relative to the outer radius
COILS = 3
MAX_COILED = 12  # largest number of springs that are drawn with coils
ALL_ANGLES = np.linspace(-pi, pi, 721)
COLOUR_MAP = "YlGnBu"
RING_COLOUR, EDGE_COLOUR, UNDEFORMED_COLOUR, INNER_COLOUR, LIFTED_COLOUR = "0.84", "0.15", "0.5", "0.95", "0.75"
DEFECT_COLOUR, SPRING_COLOUR, SENSOR_COLOUR = COLOURS[1], COLOURS[2], COLOURS[3]
FRACTION_TEXTS = {0.25: "¼ of a ball pass later", 0.5: "½ later", 0.75: "¾ later"}


class RingView(NamedTuple):
    """Ring as drawn, in mm, with displacements and clearance multiplied by ``exaggeration``.

    darkest: force (N) of the darkest shade.
    """

    shape: RingShape
    exaggeration: float
    darkest: float

    @property
    def race(self) -> float:
        """Radius of the undeformed outer race."""
        return 1e3 * (self.shape.pitch + self.shape.roller + self.exaggeration * self.shape.gap)

    @property
    def outside(self) -> float:
        """Outer radius of the undeformed ring."""
        return 1e3 * (self.shape.outside + self.exaggeration * self.shape.gap)

    @property
    def inner_race(self) -> float:
        """Radius of the inner race."""
        return 1e3 * (self.shape.pitch - self.shape.roller - self.exaggeration * self.shape.gap)

    @property
    def carrier(self) -> float:
        """Radius of the carrier around the springs."""
        return (1.0 + SPRING_RATIO) * self.outside

    def exaggerate(self, metres: Any) -> Any:
        """Convert a displacement (m) to the drawing (mm), exaggerated."""
        return 1e3 * self.exaggeration * metres

    def ring_points(self, instant: Instant, angles: Reals, radius: float) -> tuple[Reals, Reals]:
        """Return the drawn positions of ring points with undeformed ``radius`` at some angles."""
        return to_drawing_axes(
            angles,
            radius + self.exaggerate(instant.bending(angles)),
            self.exaggerate(instant.x),
            self.exaggerate(instant.y),
        )

    def carrier_points(self, instant: Instant, angles: Reals, beyond: float = 0.0) -> tuple[Reals, Reals]:
        """Return the drawn positions of carrier points, or of points ``beyond`` the carrier (mm)."""
        return to_drawing_axes(angles, self.carrier + beyond, *(self.exaggerate(part) for part in instant.carrier))

    def roller_centre(self, instant: Instant, j: int) -> tuple[float, float]:
        """Return the drawn position of the centre of roller ``j``."""
        right, up = to_drawing_axes(
            instant.angles[j], 1e3 * self.shape.pitch + self.exaggerate(instant.outwards[j])
        )
        return float(right), float(up)


def to_drawing_axes(angles: Any, radius: Any, x: float = 0.0, y: float = 0.0) -> tuple[Any, Any]:
    """Convert polar coordinates around (x, y) to drawing axes (right, up): 0 deg is up, 90 deg is left."""
    return -(radius * np.sin(angles) + y), radius * np.cos(angles) + x


def make_view(shape: RingShape) -> RingView:
    """Choose a round exaggeration, and the force of the darkest shade, for a ring."""
    exaggeration = round_below(DISPLACEMENT_RATIO * shape.outside / max(shape.largest(), 1e-12))
    largest_force = max(float(instant.forces[instant.loaded].max(initial=0.0)) for instant in shape.instants)
    return RingView(shape, exaggeration, largest_force or 1.0)


def draw_rings(results: "Results", _: "Figure", jobs: Sequence[str]) -> list[Sheet]:
    """Draw a figure per job with a static equilibrium; raise the first error if none has one."""
    sheets, problems = [], []
    for job in jobs:
        try:
            sheets.append(Sheet(["ring", job[:8]], draw_ring(results, job)))
        except labels.PlotError as error:
            problems.append((job, error))
    if not sheets:
        raise problems[0][1]
    for job, problem in problems:
        warnings.warn(f"job {job} skipped: {problem}", labels.PlotWarning, stacklevel=2)
    return sheets


def draw_ring(results: "Results", job: str) -> Canvas:
    """Draw the ring of a finished job. Raises PlotError without equilibrium, ResultsError if not done."""
    done = results.parameters()
    if job not in done.index:
        results.series(job)  # raises ResultsError with the reason
    shape = ring_shape(recorded.case_of(results, job, done.loc[job].to_dict()))
    rows = select.case_rows(results)
    return draw_shape(shape, fixed_values(results, rows[rows["job"] == job], set()))


def draw_shape(shape: RingShape, caption: list[str]) -> Canvas:
    """Draw a panel per instant, with a legend above and the ``caption`` below."""
    view = make_view(shape)
    rows = -(-len(shape.instants) // 2)
    canvas = Canvas(figsize=(2 * COLUMN_IN + 0.8, rows * 3.1 + 1.1),
                    layout=ConstrainedLayoutEngine(w_pad=0.04, h_pad=0.04))  # fmt: skip
    axes = list(canvas.subplots(rows, 2, squeeze=False).flat)
    for number, (ax, instant) in enumerate(zip(axes, shape.instants, strict=False)):
        draw_instant(ax, view, instant)
        label_panel(ax, number, len(shape.instants), _time_text(shape, instant))
    shades = ScalarMappable(Normalize(0.0, view.darkest), COLOUR_MAP)
    bar = canvas.colorbar(shades, ax=axes, shrink=0.5, aspect=25, pad=0.02)
    bar.set_label("Force of a roller on the outer race (N)")
    entries = list(_legend(view))
    title = f"Ring at rest; displacements and clearance ×{labels.number_text(view.exaggeration)}"
    canvas.legend(entries, [str(entry.get_label()) for entry in entries], loc="outside upper left", ncols=4,
                  fontsize=7.5, title=title, title_fontsize=9.0, alignment="left")  # fmt: skip
    finish(canvas, None, caption)
    return canvas


def _time_text(shape: RingShape, instant: Instant) -> str:
    """Describe the time of an instant."""
    if instant.fraction in FRACTION_TEXTS:
        return FRACTION_TEXTS[instant.fraction]
    where = "over the defect" if any(mark.on == "outer" for mark in instant.marks) else "at the load line"
    return (
        f"a roller {where}"
        if instant.fraction == 0.0
        else f"{labels.number_text(instant.fraction)} of a ball pass later"
    )


def draw_instant(ax: "Axes", view: RingView, instant: Instant) -> None:
    """Draw the bearing at one instant of a ball pass."""
    ax.set_aspect("equal")
    ax.set_axis_off()
    draw_bodies(ax, view, instant)
    for j in range(len(instant.angles)):
        draw_roller(ax, view, instant, j)
    for mark in instant.marks:
        ax.plot(
            *defect_line(view, instant, mark),
            color=DEFECT_COLOUR,
            lw=3.0,
            solid_capstyle="butt",
            zorder=6,
            gid="defect",
        )
    draw_springs(ax, view, instant)
    for applied_force in view.shape.applied_forces:
        draw_applied_force(ax, view, instant, applied_force)
    sensor = sensor_position(view, instant)
    ax.plot(*sensor, marker="s", ls="", color=SENSOR_COLOUR, ms=5.5, mec="white", mew=0.6, zorder=8, gid="sensor")
    left, right, low, high = axis_limits(view)
    ax.set_xlim(left, right)
    ax.set_ylim(low, high)


def axis_limits(view: RingView) -> tuple[float, float, float, float]:
    """Return left, right, lower and upper limit of the drawing, equal at all instants."""
    radius = view.carrier if len(view.shape.spring_angles) else view.outside
    angles = np.array([applied_force.angle for applied_force in view.shape.applied_forces])
    right, up = to_drawing_axes(angles, radius + ARROW_RATIO * view.outside)
    margin, extent = MARGIN_RATIO * view.outside, (1.0 + DISPLACEMENT_RATIO) * radius
    sides = np.r_[right - margin, right + margin, -extent, extent]
    heights = np.r_[up - margin, up + margin, -extent, extent]
    return float(sides.min()), float(sides.max()), float(heights.min()), float(heights.max())


def draw_bodies(ax: "Axes", view: RingView, instant: Instant) -> None:
    """Draw the ring, its undeformed shape as dashed circles, the inner race, and arrows at 0 and 90 deg."""
    inside, outside = (
        view.ring_points(instant, ALL_ANGLES, view.race),
        view.ring_points(instant, ALL_ANGLES, view.outside),
    )
    ax.fill(
        *(np.r_[a, b[::-1]] for a, b in zip(outside, inside, strict=True)), color=RING_COLOUR, lw=0.0, zorder=1
    )
    for line, name in ((inside, "race"), (outside, "outside")):
        ax.plot(*line, color=EDGE_COLOUR, lw=1.0, zorder=3, gid=name)
    for radius in (view.race, view.outside):
        ax.add_patch(
            Circle((0.0, 0.0), radius, fill=False, ec=UNDEFORMED_COLOUR, lw=0.5, ls=(0, (6, 3)), zorder=4)
        )
    ax.add_patch(Circle((0.0, 0.0), view.inner_race, fc=INNER_COLOUR, ec=EDGE_COLOUR, lw=0.8, zorder=1))
    for angle, word in ((0.0, "0°"), (pi / 2.0, "90°")):
        tip, beyond = to_drawing_axes(angle, 0.35 * view.inner_race), to_drawing_axes(angle, 0.5 * view.inner_race)
        arrow: dict[str, Any] = {
            "arrowstyle": "-|>",
            "lw": 0.7,
            "color": "0.4",
            "shrinkA": 0.0,
            "mutation_scale": 7.0,
        }
        ax.annotate("", tip, (0.0, 0.0), arrowprops=arrow)
        ax.annotate(word, beyond, ha="center", va="center", fontsize=7, color="0.4")


def draw_roller(ax: "Axes", view: RingView, instant: Instant, j: int) -> None:
    """Draw roller ``j``: shaded by its force, hollow if unloaded."""
    shade = colormaps[COLOUR_MAP](instant.forces[j] / view.darkest) if instant.loaded[j] else "white"
    centre, radius = view.roller_centre(instant, j), 1e3 * view.shape.roller
    ax.add_patch(Circle(centre, radius, fc=shade, ec=EDGE_COLOUR, lw=0.7, zorder=2, gid=f"roller {j + 1}"))


def defect_line(view: RingView, instant: Instant, mark: DefectMark) -> tuple[Reals, Reals]:
    """Return the line that marks a defect on a race or a roller."""
    if mark.on == "roller":
        right, up = view.roller_centre(instant, mark.roller)
        radius = 1e3 * view.shape.roller
        half = max(mark.half, MIN_HALF_ANGLE * view.race / radius)
        arc = to_drawing_axes(np.linspace(mark.angle - half, mark.angle + half, 21), radius)
        return right + arc[0], up + arc[1]
    half = max(mark.half, MIN_HALF_ANGLE)
    angles = np.linspace(mark.angle - half, mark.angle + half, 21)
    if mark.on == "inner":
        return to_drawing_axes(angles, view.inner_race)
    return view.ring_points(instant, angles, view.race)


def draw_springs(ax: "Axes", view: RingView, instant: Instant) -> None:
    """Draw the springs around the ring, loaded ones darker, and the carrier behind them."""
    if not len(instant.springs):
        return
    ax.plot(*view.carrier_points(instant, ALL_ANGLES), color=SPRING_COLOUR, lw=1.1, zorder=3, gid="carrier")
    for p in range(len(instant.springs)):
        presses = instant.springs[p] > 0.0
        ax.plot(*spring_line(view, instant, p), color=SPRING_COLOUR if presses else LIFTED_COLOUR,
                lw=1.0 if presses else 0.6, zorder=5 if presses else 4,
                gid="pressed" if presses else "lifted")  # fmt: skip


def spring_line(view: RingView, instant: Instant, p: int) -> tuple[Reals, Reals]:
    """Return the line of spring ``p`` from ring to carrier: a coil if there are few springs, else straight."""
    angle = view.shape.spring_angles[p : p + 1]
    inner, outer = (np.concatenate(end) for end in (view.ring_points(instant, angle, view.outside),
                                                   view.carrier_points(instant, angle)))  # fmt: skip
    if len(instant.springs) > MAX_COILED:
        return np.array([inner[0], outer[0]]), np.array([inner[1], outer[1]])
    along = np.r_[0.0, 0.15, 0.15 + 0.7 * (np.arange(2 * COILS) + 0.5) / (2 * COILS), 0.85, 1.0]
    lateral = 0.03 * view.outside * np.r_[0.0, 0.0, np.tile([1.0, -1.0], COILS), 0.0, 0.0]
    normal = to_drawing_axes(angle[0] + pi / 2.0, 1.0)
    right, up = (inner[i] + along * (outer[i] - inner[i]) + lateral * normal[i] for i in (0, 1))
    return right, up


def draw_applied_force(ax: "Axes", view: RingView, instant: Instant, applied_force: AppliedForce) -> None:
    """Draw an applied force as an arrow to the ring or carrier, with its magnitude."""
    tip, tail = arrow_ends(view, instant, applied_force)
    ax.annotate("", tip, tail, arrowprops={"arrowstyle": "-|>", "lw": 1.4, "color": EDGE_COLOUR, "shrinkA": 0.0,
                                           "shrinkB": 0.0, "mutation_scale": 11.0}, zorder=7)  # fmt: skip
    sideways, upwards = -sin(applied_force.angle), cos(applied_force.angle)
    ha = "center" if abs(sideways) < 0.3 else "right" if sideways < 0.0 else "left"
    va = "bottom" if upwards > 0.3 else "top" if upwards < -0.3 else "center"
    ax.annotate(f"{labels.number_text(applied_force.force, 3)} N", tail, (2.0 * sideways, 2.0 * upwards),
                textcoords="offset points", ha=ha, va=va, fontsize=7.5, zorder=7, gid="push")  # fmt: skip


def arrow_ends(
    view: RingView, instant: Instant, applied_force: AppliedForce
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return tip and tail of the arrow of a force."""
    angles, length = np.array([applied_force.angle]), ARROW_RATIO * view.outside
    if len(instant.springs):
        ends = view.carrier_points(instant, angles), view.carrier_points(instant, angles, length)
    else:
        ends = (
            view.ring_points(instant, angles, view.outside),
            view.ring_points(instant, angles, view.outside + length),
        )
    tip, tail = ((float(right[0]), float(up[0])) for right, up in ends)
    return tip, tail


def sensor_position(view: RingView, instant: Instant) -> tuple[Reals, Reals]:
    """Return the position of the sensor: in the ring's section, or just inside the carrier, clear of forces."""
    angles = np.array([view.shape.sensor])
    if view.shape.sensor_on == "housing":
        return view.carrier_points(instant, angles, -SENSOR_RATIO * view.outside)
    return view.ring_points(instant, angles, 0.5 * (view.race + view.outside))


def _legend(view: RingView) -> Iterator[Line2D]:
    """Yield the legend entries of the marks."""
    round_mark: dict[str, Any] = {"ls": "", "marker": "o", "mec": EDGE_COLOUR, "mew": 0.7, "ms": 8.0}
    yield Line2D([], [], color=UNDEFORMED_COLOUR, lw=0.7, ls=(0, (6, 3)), label="undeformed ring")
    yield Line2D([], [], mfc="white", label="roller without load", **round_mark)
    if any(instant.marks for instant in view.shape.instants):
        yield Line2D([], [], color=DEFECT_COLOUR, lw=3.0, label="defect")
    yield Line2D([], [], ls="", marker="s", color=SENSOR_COLOUR, mec="white", ms=6.0, label="sensor")
    if len(view.shape.spring_angles):
        behind = "housing" if view.shape.by == "housing" else "carrier"
        yield Line2D([], [], color=SPRING_COLOUR, lw=1.1, label=f"{behind}, springs in contact")
        yield Line2D([], [], color=LIFTED_COLOUR, lw=0.9, label="springs out of contact")
