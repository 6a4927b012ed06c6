"""Geometry of defects for figures, and passages of rollers over them from the channels of a job."""

from collections.abc import Iterator
from math import pi
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bearingsim.config.names import roller_of
from bearingsim.plots.recorded import Job, recorded_as, roller_angle

if TYPE_CHECKING:
    from bearingsim.config import Case


ROLLING_POINTS, AXIAL_POINTS = 401, 241  # grid points of a depth map along rolling and along the roller
SECTION_REFINEMENT = 4  # intervals of a section per interval of the depth map
SAME_DEPTH_RATIO = 0.98  # depth of the central section, relative to the largest, from which it is the deepest
MARGIN = 0.3  # margin shown on either side, relative to the defect's width

Reals = NDArray[np.float64]


class Defect(NamedTuple):
    """One defect. Lengths in m; s along rolling from its centre, z along the roller from the roller's centre.

    race: its carrier; R: effective radius of the roller on the race (the outer race for a roller's defect);
    angle: rad, as in the case; map: its depth (``defects/depth.py``); s, z: its limits.
    """

    race: str
    R: float
    angle: float
    map: Any
    s: tuple[float, float]
    z: tuple[float, float]

    def positions(self, count: int = ROLLING_POINTS, margin: float = MARGIN) -> Reals:
        """Return positions (count,) in m along rolling, up to ``margin`` defect widths beyond the defect."""
        more = margin * (self.s[1] - self.s[0])
        return np.linspace(self.s[0] - more, self.s[1] + more, count)

    @property
    def axial_positions(self) -> Reals:
        """Axial positions (AXIAL_POINTS,) in m of the sections: midpoints of equal intervals of the defect."""
        return self.z[0] + (self.z[1] - self.z[0]) * (np.arange(AXIAL_POINTS) + 0.5) / AXIAL_POINTS

    @property
    def depth_map(self) -> Reals:
        """Depth (AXIAL_POINTS, ROLLING_POINTS) in m at ``axial_positions`` and ``positions()``."""
        from bearingsim.core.defects.depth import section
        from bearingsim.core.defects.profile import depth_at

        return np.stack([depth_at(section(self.map, float(z)), self.positions()) for z in self.axial_positions])


class Section(NamedTuple):
    """Section of a defect across the roller's axis at z: s, depth p and path h of the roller, each (n,); in m."""

    z: float
    s: Reals
    p: Reals
    h: Reals


def compute_section(defect: Defect, z: float) -> Section:
    """Compute the section of a defect at z (m) along the roller."""
    from bearingsim.core.defects.depth import section
    from bearingsim.core.defects.envelope import path_drop, trace_path
    from bearingsim.core.defects.profile import depth_at

    s, profile = defect.positions(SECTION_REFINEMENT * (ROLLING_POINTS - 1) + 1), section(defect.map, z)
    return Section(z, s, depth_at(profile, s), path_drop(trace_path(profile, defect.R), s)[0])


def distinct_sections(defect: Defect) -> list[float]:
    """List the positions z (m) of the sections to draw: the deepest, and the central one if it differs."""
    depths = defect.depth_map.max(axis=1)
    deepest, centre = int(np.argmax(depths)), AXIAL_POINTS // 2
    if depths[centre] >= SAME_DEPTH_RATIO * depths[deepest]:
        return [float(defect.axial_positions[centre])]
    return [float(defect.axial_positions[k]) for k in ((deepest, centre) if depths[centre] > 0.0 else (deepest,))]


def defects_of(case: "Case") -> Iterator[Defect]:
    """Yield the defects of a case in its order; overlapping defects count as one."""
    from bearingsim.assemble import defects
    from bearingsim.core.defects.depth import ShiftedDefect, extent

    for cluster in defects.cluster_defects(case):
        d = cluster.reference
        race, R = d.race, defects.reduced_radius(case, 1 if d.race == "inner" else 0)
        defect = cluster.depth_map or ShiftedDefect(defects.build_depth_map(d), 0.0, d.offset)
        low, high, left, right = extent(defect)
        yield Defect(race, R, cluster.angle, defect, (low, high), (left, right))


def ends_of_slices(case: "Case") -> Reals:
    """Return the ends of the slices of a roller (m, from its centre); empty for a model without slices."""
    from bearingsim.catalogue import MODELS
    from bearingsim.config.rules.completion import slice_ends

    return np.asarray(slice_ends(case) if MODELS[case.model].sliced else ())


WIDTHS_BEFORE, WIDTHS_AFTER = 1.5, 3.0  # widths of the defect shown before and after its centre
MIN_WIDTH = 6e-4  # m, minimum width of a defect in the time range, to cover the pocket clearance of the roller


class RollerPath(NamedTuple):
    """Path of a roller (number from 1) over a defect: position s and depth below the undamaged race, (n,) in m.

    tilt: (n,) in rad of the roller's axis; the depth increases by tilt times z.
    """

    number: int
    s: np.ndarray
    depth: np.ndarray
    tilt: np.ndarray

    def depth_at(self, z: float) -> np.ndarray:
        """Compute the depth (n,) in m of the roller's lowest point in the section z (m)."""
        return self.depth + self.tilt * z


class Passage(NamedTuple):
    """Passage of a roller: the defect, the time (s) over its centre, and the speed (m/s) along rolling.

    angle: position (rad) of the roller at that time, from the load line.
    """

    defect: Defect
    time: float
    speed: float
    angle: float

    @property
    def time_range(self) -> tuple[float, float]:
        """Beginning and end (s) of the time shown."""
        width = max(self.defect.s[1] - self.defect.s[0], MIN_WIDTH)
        return self.time - WIDTHS_BEFORE * width / self.speed, self.time + WIDTHS_AFTER * width / self.speed

    @property
    def crossing(self) -> tuple[float, float]:
        """Times (s) at which the contact enters and leaves the defect; it moves towards -s on the inner race."""
        low, high = self.defect.s
        start, end = (-high, -low) if self.defect.race == "inner" else (low, high)
        return self.time + start / self.speed, self.time + end / self.speed

    def samples(self, rate: float) -> float:
        """Compute the number of samples, at ``rate`` (Hz), during the crossing of the defect."""
        return rate * (self.defect.s[1] - self.defect.s[0]) / self.speed


def first_passage(job: Job, case: "Case", number: int, race: str) -> Passage | None:
    """Find the first complete passage of a roller (from 1) over a defect of ``race``, else of the other race.

    Returns None if there is no complete passage in the record. Raises PlotError under a ramp.
    """
    return next(iter(passages(job, case, number, race)), None)


def passages(job: Job, case: "Case", number: int, race: str) -> list[Passage]:
    """List the complete passages of a roller (from 1) over the first defect that it passes; empty without any.

    Defects of ``race`` are tried first, those of rollers not at all. Raises PlotError under a ramp.
    """
    defects = [defect for defect in defects_of(case) if defect.race != "roller"]
    ordered = sorted(defects, key=lambda defect: defect.race != race)
    of_defects = (list(_passages(job, case, number, defect)) for defect in ordered)
    return next(filter(None, of_defects), [])


def _passages(job: Job, case: "Case", number: int, defect: Defect) -> Iterator[Passage]:
    """Yield the passages over one defect whose time ranges lie in the record."""
    time = job.series.time
    angle = roller_angle(job, number)
    ahead = angle - defect.angle
    radius = (case.bearing.pitch_diameter + case.bearing.roller_diameter) / 2.0
    if defect.race == "inner":
        settle = float(job.info.get("settle_s", case.settle))  # stored per job by the first version
        ahead = case.speed * (settle + time) - ahead
        radius -= case.bearing.roller_diameter
    revolutions = ahead / (2.0 * pi)
    speed = float((ahead[-1] - ahead[0]) / (time[-1] - time[0]) * radius)
    centre_times = np.interp(
        np.arange(np.ceil(revolutions[0]), np.floor(revolutions[-1]) + 1.0), revolutions, time
    )
    for centre_time, position in zip(centre_times, np.interp(centre_times, time, angle), strict=True):
        passage = Passage(defect, float(centre_time), speed, float(position))
        if passage.time_range[0] >= time[0] and passage.time_range[1] <= time[-1]:
            yield passage


def roller_path(job: Job, case: "Case", defect: Defect) -> RollerPath | None:
    """Compute the path of the first roller whose radial position was recorded.

    Returns None without such a record, or if the roller does not pass the defect. The depth of the lowest point is
    the displacement of the roller relative to the ring (outward; inward for a defect of the inner race) minus a
    quarter of the clearance. It includes the elastic approach of the contact.
    """
    series = {name: np.asarray(values, np.float64) for name, values in job.series.channels.items()}
    names = [name for name in job.recorded if (roller_of(name) or (0, ""))[1] == "radial"]
    ring = "inner" if defect.race == "inner" else "ring"
    is_fixed = ring == "inner" and case.shaft is None
    if not names or defect.race == "roller" or not (is_fixed or f"{ring}.displacement.x" in series):
        return None
    number, _ = roller_of(names[0]) or (1, "")
    passage = next(_passages(job, case, number, defect), None)
    if passage is None:
        return None
    angle = roller_angle(job, number)
    x, y = (0.0 if is_fixed else series[f"{ring}.displacement.{part}"] for part in "xy")
    outwards = series[names[0]] - (x * np.cos(angle) + y * np.sin(angle))
    depth = (-outwards if ring == "inner" else outwards) - case.clearance / 4.0
    s = (job.series.time - passage.time) * passage.speed
    tilt = recorded_as(f"roller.{number}.tilt", job.recorded)
    tilts = series[tilt] if tilt else np.zeros(len(s))
    if ring == "inner":  # faster than the rollers, which move towards -s on it
        s, depth, tilts = -s[::-1], depth[::-1], -tilts[::-1]
    in_defect = (s >= defect.positions()[0]) & (s <= defect.positions()[-1])
    return RollerPath(number, s[in_defect], depth[in_defect], tilts[in_defect])
