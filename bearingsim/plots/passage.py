"""When a roller passes a pit, from what its job has recorded."""

from math import pi
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from bearingsim.plots.pit_shape import Pit, pits_of
from bearingsim.plots.recorded import Job
from bearingsim.plots.series import roller_angle

if TYPE_CHECKING:
    from bearingsim.config import Case

__all__ = ["Passage", "first_passage"]

BEFORE, AFTER = 1.5, 3.0  # widths of the pit that are shown before and after its middle
LEAST = 6e-4  # m: taken for the width of a narrower pit, since a roller may be anywhere in its pocket


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
        ahead = case.speed * (case.settle + time) - ahead
        radius -= case.bearing.roller_diameter
    turns = ahead / (2.0 * pi)
    speed = float((ahead[-1] - ahead[0]) / (time[-1] - time[0]) * radius)
    for turn in range(int(np.ceil(turns[0])), int(np.floor(turns[-1])) + 1):
        found = Passage(pit, float(np.interp(turn, turns, time)), speed)
        if found.window[0] >= time[0] and found.window[1] <= time[-1]:
            return found
    return None
