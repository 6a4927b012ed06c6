"""When a roller passes a pit, and on which path, from what its job has recorded."""

from math import pi
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from bearingsim.config.names import roller_of
from bearingsim.plots.pit_shape import Pit, pits_of
from bearingsim.plots.recorded import Job, recorded_as
from bearingsim.plots.series import roller_angle
from bearingsim.simulation.settling import settled

if TYPE_CHECKING:
    from bearingsim.config import Case

__all__ = ["Passage", "RollerPath", "first_passage", "roller_path"]

BEFORE, AFTER = 1.5, 3.0  # widths of the pit that are shown before and after its middle
LEAST = 6e-4  # m: taken for the width of a narrower pit, since a roller may be anywhere in its pocket


class RollerPath(NamedTuple):
    """The path that a roller (from 1) took over a pit: place s and depth below the sound race (m), (n,) each.

    lean: of the roller's axis, outwards (rad; (n,)), by which another section than its middle lies deeper.
    """

    number: int
    s: np.ndarray
    depth: np.ndarray
    lean: np.ndarray

    def at(self, z: float) -> np.ndarray:
        """Depth (n,) m of the roller's lowest point in the section z (m)."""
        return self.depth + self.lean * z


class Passage(NamedTuple):
    """A roller over a pit: the pit, the time (s) over its middle, and the speed (m/s) along rolling."""

    pit: Pit
    time: float
    speed: float

    @property
    def window(self) -> tuple[float, float]:
        """Beginning and end (s) of what is worth showing."""
        width = max(self.pit.s[1] - self.pit.s[0], LEAST)
        return self.time - BEFORE * width / self.speed, self.time + AFTER * width / self.speed

    def samples(self, rate: float) -> float:
        """Samples, at ``rate`` (Hz), while the roller crosses the pit."""
        return rate * (self.pit.s[1] - self.pit.s[0]) / self.speed


def first_passage(job: Job, case: "Case", number: int, race: str) -> Passage | None:
    """The first time that a roller (from 1) wholly passes a pit of a race, or else of the other one.

    None if no race has a pit, or none is passed within the record. Raises PlotError under a ramp.
    """
    pits = [pit for pit in pits_of(case) if pit.race != "roller"]
    ordered = sorted(pits, key=lambda pit: pit.race != race)
    found = (_passage(job, case, number, pit) for pit in ordered)
    return next((one for one in found if one is not None), None)


def _passage(job: Job, case: "Case", number: int, pit: Pit) -> Passage | None:
    """The first passage of one pit whose window lies in the record."""
    time = job.series.time
    ahead = roller_angle(job, number) - pit.angle
    radius = (case.bearing.pitch_diameter + case.bearing.roller_diameter) / 2.0
    if pit.race == "inner":
        ahead = case.speed * (settled(case).settle + time) - ahead
        radius -= case.bearing.roller_diameter
    turns = ahead / (2.0 * pi)
    speed = float((ahead[-1] - ahead[0]) / (time[-1] - time[0]) * radius)
    for turn in range(int(np.ceil(turns[0])), int(np.floor(turns[-1])) + 1):
        found = Passage(pit, float(np.interp(turn, turns, time)), speed)
        if found.window[0] >= time[0] and found.window[1] <= time[-1]:
            return found
    return None


def roller_path(job: Job, case: "Case", pit: Pit) -> RollerPath | None:
    """The path of the first roller whose place was recorded; None without, or if it does not pass the pit.

    The depth of its lowest point is what it has moved outwards beyond the play, less what the ring has (for a pit
    of the inner race inwards). It includes the contact's elastic approach.
    """
    series = {name: np.asarray(values, np.float64) for name, values in job.series.channels.items()}
    names = [name for name in job.recorded if (roller_of(name) or (0, ""))[1] == "radial"]
    ring = "inner" if pit.race == "inner" else "ring"
    held = ring == "inner" and case.shaft is None
    if not names or pit.race == "roller" or not (held or f"{ring}.displacement.x" in series):
        return None
    number, _ = roller_of(names[0]) or (1, "")
    passage = _passage(job, case, number, pit)
    if passage is None:
        return None
    angle = roller_angle(job, number)
    x, y = (0.0 if held else series[f"{ring}.displacement.{part}"] for part in "xy")
    outwards = series[names[0]] - (x * np.cos(angle) + y * np.sin(angle))
    depth = (-outwards if ring == "inner" else outwards) - case.clearance / 4.0
    s = (job.series.time - passage.time) * passage.speed
    tilt = recorded_as(f"roller.{number}.tilt", job.recorded)
    lean = series[tilt] if tilt else np.zeros(len(s))
    if ring == "inner":  # which is faster than the rollers: they move towards -s
        s, depth, lean = -s[::-1], depth[::-1], -lean[::-1]
    shown = (s >= pit.places()[0]) & (s <= pit.places()[-1])
    return RollerPath(number, s[shown], depth[shown], lean[shown])
