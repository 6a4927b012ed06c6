"""Periodic motion: the cases that may have it, and the search for the pass from which on it is periodic.

At the end of a ball pass every roller stands where the next one stood at its start. So two instants, or two
passes, are compared by place: roller j now with roller j + m of m passes ago. Periods are not computed again
(docs/repetition.md).
"""

from collections import deque
from collections.abc import Callable
from math import inf, isfinite, nan
from typing import Any, NamedTuple

import numpy as np

from bearingsim.catalogue import METHODS
from bearingsim.config import Case
from bearingsim.config.rules.conflicts import ALIKE
from bearingsim.core import layout as lay
from bearingsim.core.models.interface import degrees_of_freedom
from bearingsim.simulation.fastest import lengths

CONSTANT = frozenset(
    {
        *("bearing", "rig", "speed", "load", "load_across", "gravity", "clearance", "contact", "friction", "drag"),
        *("shaft", "misalignment", "step", "tolerance", "step_check", "duration", "settle", "start_angle", "seed"),
        *("sampling", "antialias", "features", "record", "until"),
    }
)
"""Fields of a case that act alike in every ball pass."""

CONDITIONS: dict[str, Callable[[Case], bool]] = {
    **{name: alike.holds for name, alike in ALIKE.items()},
    "method": lambda case: case.method is None or not METHODS[case.method].adaptive,
    "periodic": lambda case: case.periodic,
}
"""Conditions on the other fields."""


def may_repeat(case: Case) -> bool:
    """Check if the motion of a case, its method named, may become the same in each ball pass.

    A case with a field in neither table is computed in full.
    """
    fields = CONSTANT | CONDITIONS.keys()
    return fields.issuperset(type(case).model_fields) and all(holds(case) for holds in CONDITIONS.values())


def passes_are_alike(case: Case) -> bool:
    """Check if the motion of a case may be periodic, even if `periodic: false` computes it in full."""
    return may_repeat(case.model_copy(update={"periodic": True}))


def period_is_sought(case: Case) -> bool:
    """Check if a case is first computed until it is periodic: for its record, or to check its step on a period."""
    wanted = case.periodic or case.checks_step
    return wanted and case.step_check != "strict" and passes_are_alike(case)


EXTREMES = {
    "outer_force.max": lay.Q_O_MAX,
    "inner_force.max": lay.Q_I_MAX,
    "cage_force.max": lay.Q_P_MAX,
    "tilt.max": lay.TILT_MAX,
    "line_load.max": lay.LINE_LOAD_MAX,
}
"""Largest values that any roller met, by feature, and the rows in which the buffer keeps them."""


class Repetition(NamedTuple):
    """Computed ball passes of a motion, and its period.

    computed: ball passes that were computed; period: in ball passes, 0 if the motion is not periodic; difference:
    the largest of the last pass to the one a period before, over the range of the quantity (NaN if no period was
    searched for).
    """

    computed: int
    period: int
    difference: float

    def source(self, p: np.ndarray | int) -> np.ndarray:
        """Return the computed pass that pass ``p`` (any shape) equals, by place."""
        p = np.asarray(p)
        start = self.computed - self.period
        return np.where(p < self.computed, p, start + (p - start) % max(1, self.period))


LONGEST_PERIOD = 4  # ball passes; longer ones have not been seen


class Closeness(NamedTuple):
    """Limits of differences over the range: with, and without, regard to how fast they shrink.

    times: passes in a row within a limit, for a period of one pass; ``period`` - 1 more for others.
    """

    shrinking: float
    anyhow: float
    times: int


OF_A_RECORD = Closeness(1e-7, 1e-10, times=2)
"""Limits for a record that is computed once."""
SLOWEST = 0.98  # ratio of differences from pass to pass above which they do not count as shrinking
NEAR = 1e3  # times as far apart the ends of two passes may be for all of the passes to be compared
MOST_HELD = 256e6  # bytes of recordings held to compare with
LEAST_RANGE = 1e-3  # of the wider of a pair's ranges: the least by which x and y are measured


class Search:
    """Search for a period, a ball pass at a time.

    Two passes are compared through all their steps, in the ring's position and velocity and in all else that is
    recorded, in the largest forces (and tilt), and in the whole state at their ends. Each difference is taken over
    the range of its quantity within a pass. It must be small twice in a row, and so must the sum of all that
    follow: with a ratio rho from pass to pass that is rho/(1 - rho) of it.
    """

    def __init__(
        self, places: np.ndarray, steps: int, model: Any, memoryless: bool, close: Closeness, keeps: float = 0.0
    ) -> None:
        """Prepare the comparison of passes.

        places: (C,) of the buffer, the first four the ring's position and velocity; steps: in a pass; memoryless:
        the first pass is periodic; close: limits of the differences; keeps: decay of the slowest mode of the
        bearing at rest in a pass, as a ratio.
        """
        self.places, self.memoryless, self.close, self.Z = places, memoryless, close, model.bearing.Z
        self.keeps = keeps
        self.model = model
        self.compared = np.r_[0:4, 9 : len(places)]  # accelerations jump; the cage is part of the state
        self.compared = self.compared[places[self.compared] != lay.SENSOR_A]
        self.weights = np.zeros(12 * lay.ROW) if memoryless else lengths(model)
        self.least_peaks = np.array([name == "tilt.max" for name in EXTREMES]) / model.bearing.R_o
        held = int(MOST_HELD // (8 * len(places) * steps))
        self.periods = range(1, 1 + min(LONGEST_PERIOD, held))
        self.recordings: deque[np.ndarray] = deque(maxlen=len(self.periods) + 1)
        self.ends: deque[np.ndarray] = deque(maxlen=len(self.periods) + 1)
        self.peaks: deque[np.ndarray] = deque(maxlen=len(self.periods) + 1)
        of_compared = places[self.compared]
        self.partners = {period: turned(of_compared, self.Z, period) for period in self.periods}
        self.differences: dict[int, list[float]] = {period: [] for period in self.periods}

    def after_pass(self, window: np.ndarray, y: np.ndarray, peaks: np.ndarray) -> tuple[int, float]:
        """Return the period in ball passes at the end of a pass, 0 if there is none.

        Second, the difference of passes a period apart; the smallest of any period if there is none.

        window: (C, n) the pass's recording, with the end of the one before in front; y: the buffer at its end;
        peaks: ``EXTREMES`` within it.
        """
        if self.memoryless:
            return 1, 0.0
        if not self.periods:
            return 0, nan
        self.recordings.append(window[self.compared])
        self.ends.append(y[lay.POSITION : lay.POSITION + 2 * lay.STATE] * self.weights)
        self.peaks.append(peaks)
        ranges = self._ranges(window)
        for period in self.periods:
            if period < len(self.ends):
                differences = self.differences[period]
                differences.append(self._difference(period, ranges))
                passes = self.close.times + period - 1  # each of a period
                if all(
                    _settled(differences[: len(differences) - n], self.close, self.keeps) for n in range(passes)
                ):
                    return period, differences[-1]
        return 0, min((differences[-1] for differences in self.differences.values() if differences), default=nan)

    def _ranges(self, window: np.ndarray) -> np.ndarray:
        """Return the range of the quantity of each recorded row (C,)."""
        high, low = np.zeros(len(window)), np.zeros(len(window))
        for c in self.compared:
            high[c], low[c] = window[c].max(), window[c].min()
        ranges = high - low
        for pair in (ranges[:2], ranges[2:4]):
            pair[:] = np.maximum(pair, LEAST_RANGE * pair.max())
        lane = lay.lane_of(self.places)
        for kind in set((self.places - lane)[lane >= 0].tolist()):  # all rollers' rows of a quantity have one
            rows = (lane >= 0) & (self.places - lane == kind)
            ranges[rows] = high[rows].max() - low[rows].min()
        return ranges

    def _difference(self, period: int, ranges: np.ndarray) -> float:
        """Return the largest difference to ``period`` passes ago; of their ends if these are not near."""
        at_end = self._end_difference(period, ranges)
        if not at_end <= NEAR * self.close.shrinking:
            return at_end
        now, before = self.recordings[-1], self.recordings[-1 - period]
        apart = np.array([np.abs(a - before[c]).max() for a, c in zip(now, self.partners[period], strict=True)])
        least = self.least_peaks * ranges[:2].max()
        largest = np.abs(self.peaks[-1] - self.peaks[-1 - period])
        of_peaks = _largest_ratio(largest, np.maximum(self.peaks[-1], least))
        return max(at_end, _largest_ratio(apart, ranges[self.compared]), of_peaks)

    def _end_difference(self, period: int, ranges: np.ndarray) -> float:
        """Return the largest difference of the states at the passes' ends, as lengths and speeds."""
        now, before = (self.ends[-1 - n].reshape(2, 6, lay.ROW) for n in (0, period))
        before = turned_state(before, self.model, -period)
        lanes = slice(lay.FIRST_LANE, lay.FIRST_LANE + self.Z)
        ring_ranges = np.array([[ranges[:2].max()], [ranges[2:4].max()]])
        roller_ranges = now[:, :, lanes].max(axis=2) - now[:, :, lanes].min(axis=2)
        return _largest_ratio(np.abs(now - before).max(axis=2), np.maximum(ring_ranges, roller_ranges))


def turned(cells: np.ndarray, Z: int, m: int) -> np.ndarray:
    """Return the row (C,) of a recording of ``cells`` that held the quantity of each row ``m`` passes before."""
    lane = lay.lane_of(cells)
    partner = np.where(lane >= 0, cells - lane + (lane + m) % Z, cells)
    row_of = {int(cell): row for row, cell in enumerate(cells)}
    return np.array([row_of[int(cell)] for cell in partner])


def turned_state(state: np.ndarray, model: Any, passes: int) -> np.ndarray:
    """Return positions and velocities (2, 6, ROW) with the rollers rotated by ``passes`` ball passes."""
    moved, own = state.copy(), degrees_of_freedom(model)[0]
    lanes = slice(lay.FIRST_LANE, lay.FIRST_LANE + model.bearing.Z)
    moved[:, :own, lanes] = np.roll(moved[:, :own, lanes], passes, axis=2)
    return moved


def _largest_ratio(differences: np.ndarray, ranges: np.ndarray) -> float:
    """Return the largest of differences over their ranges; no difference counts as 0 whatever its range."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return float(np.max(np.where(differences == 0.0, 0.0, differences / ranges), initial=0.0))


def _settled(differences: list[float], close: Closeness, keeps: float) -> bool:
    """Check if the last of differences, and the sum of those to come, is small.

    keeps: ratio of successive differences of the slowest mode, which may itself be too small to be seen.
    """
    if not differences or not isfinite(differences[-1]):
        return False
    last = differences[-1]
    if last <= close.anyhow and remaining_sum(last, keeps) <= close.shrinking:
        return True
    if len(differences) < 3 or not isfinite(differences[-3]):
        return False
    before, further = differences[-2], differences[-3]
    if before == 0.0 or further == 0.0:  # no convergence
        return False
    rho = max(last / before, before / further, keeps)
    return rho < SLOWEST and remaining_sum(last, rho) <= close.shrinking


def remaining_sum(difference: float, rho: float) -> float:
    """Return the sum of the differences after one, each ``rho`` times the one before; at least that one."""
    return difference * max(1.0, rho / (1.0 - rho)) if rho < 1.0 else inf
