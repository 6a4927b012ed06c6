"""Periodic motion: conditions on the case, and search for the period, ball pass by ball pass.

During a ball pass each roller moves to the initial position of the next one. Passes are therefore compared by
position: roller j with roller j + m of m passes before. Periods after the first are not computed
(docs/repetition.md).
"""

from collections import deque
from collections.abc import Callable
from functools import cache
from math import inf, isfinite, nan
from typing import Any, NamedTuple

import numpy as np

from bearingsim.catalogue import METHODS
from bearingsim.config import Case
from bearingsim.config.rules.conflicts import PASS_CONDITIONS
from bearingsim.core import layout as lay
from bearingsim.core.models.interface import degrees_of_freedom
from bearingsim.simulation.fastest import length_factors
from bearingsim.simulation.rounding import NO_ROUNDING, PEAK_TO_PEAK, Rounding

CONSTANT_FIELDS = frozenset(
    {
        *("bearing", "rig", "speed", "load", "load_across", "gravity", "clearance", "contact", "friction", "drag"),
        *("shaft", "misalignment", "step", "tolerance", "step_check", "duration", "settle", "start_angle", "seed"),
        *("sampling", "antialias", "features", "record", "until"),
    }
)
"""Fields of a case whose effect is the same in every ball pass."""

CONDITIONS: dict[str, Callable[[Case], bool]] = {
    **{name: condition.is_met for name, condition in PASS_CONDITIONS.items()},
    "method": lambda case: case.method is None or not METHODS[case.method].adaptive,
}
"""Conditions for a periodic motion on the other fields, except `periodic`."""


def may_repeat(case: Case) -> bool:
    """Check if the run of a case with a named method ends when its motion is periodic."""
    return case.periodic and may_be_periodic(case)


def may_be_periodic(case: Case) -> bool:
    """Check if the motion of a case may be periodic, even if it is computed in full (`periodic: false`).

    Cases of a class with a field in neither ``CONSTANT_FIELDS`` nor ``CONDITIONS`` are computed in full.
    """
    return _has_only_known_fields(type(case)) and all(is_met(case) for is_met in CONDITIONS.values())


@cache
def _has_only_known_fields(case_class: type[Case]) -> bool:
    """Check if all fields of a class of cases are in ``CONSTANT_FIELDS`` or ``CONDITIONS``."""
    return {*CONSTANT_FIELDS, *CONDITIONS, "periodic"}.issuperset(case_class.model_fields)


def searches_for_period(case: Case) -> bool:
    """Check if a case is first computed until it is periodic, for its record or to check its step on a period."""
    is_used = case.periodic or case.checks_step
    return is_used and case.step_check != "strict" and may_be_periodic(case)


EXTREMES = {
    "outer_force.max": lay.Q_O_MAX,
    "inner_force.max": lay.Q_I_MAX,
    "cage_force.max": lay.Q_P_MAX,
    "tilt.max": lay.TILT_MAX,
    "line_load.max": lay.LINE_LOAD_MAX,
}
"""Buffer rows with the largest values of each roller, by feature."""


class Repetition(NamedTuple):
    """Computed ball passes of a motion, and its period.

    computed: number of computed ball passes; period: in ball passes, 0 if the motion is not periodic; difference:
    largest difference of the last pass from the pass a period before, relative to the range of the quantity (the
    smallest for any period if the motion is not periodic, NaN without a search); contraction: ratio of the last
    difference of successive passes to the one before (inf if unknown).
    """

    computed: int
    period: int
    difference: float
    contraction: float = inf

    def source(self, p: np.ndarray | int) -> np.ndarray:
        """Return the number of the computed pass that equals pass ``p`` (any shape), roller numbers apart."""
        p = np.asarray(p)
        start = self.computed - self.period
        return np.where(p < self.computed, p, start + (p - start) % max(1, self.period))


LONGEST_PERIOD = 4  # ball passes, longest observed period


class PeriodCriterion(NamedTuple):
    """Criterion of a periodic motion: limits of the differences between passes, relative to the range.

    sum_limit: limit of the estimated sum of all later differences; difference_limit: limit of the last difference,
    below which no decay of the differences is required; pass_count: number of successive passes that must meet the
    criterion for a period of one pass, ``period`` - 1 more for longer periods; contraction: ratio of successive
    differences in a run of the same case with another step (inf if unknown), from which later differences are
    estimated after a single one.
    """

    sum_limit: float
    difference_limit: float
    pass_count: int
    contraction: float = inf


RECORD_CRITERION = PeriodCriterion(1e-7, 1e-10, pass_count=2)
"""Criterion for a record."""
CONTRACTION_MARGIN, MAX_CONTRACTED = 10.0, 0.02
"""Safety factor on a contraction from another step, and largest difference of passes to which it applies."""
MAX_DECAY_RATIO = 0.98  # ratio of successive differences above which they do not count as decaying
NEAR_FACTOR = 1e3  # factor on ``sum_limit`` within which final states must agree before all steps are compared
MAX_STORED_BYTES = 256e6  # bytes of recordings stored for comparison
MIN_RELATIVE_RANGE = 1e-3  # smallest range of x or y, relative to the larger of the two


class Search:
    """Search for a period, ball pass by ball pass.

    Two passes are compared at all steps in the position and velocity of the ring and in the other recorded
    quantities except accelerations, and also in the largest forces (and tilt) and in the final state. Each
    difference is relative to the range of the quantity within a pass. The difference must be small in
    ``PeriodCriterion.pass_count`` successive passes, and so must the sum of all later differences: if each is rho
    times the one before, this sum is rho/(1 - rho) times the last difference.
    """

    def __init__(
        self,
        cells: np.ndarray,
        steps: int,
        model: Any,
        memoryless: bool,
        criterion: PeriodCriterion,
        slowest_ratio: float = 0.0,
        rounding: Rounding = NO_ROUNDING,
    ) -> None:
        """Prepare the comparison of passes.

        cells: (C,) recorded cells of the buffer, beginning with position and velocity of the ring; steps: number
        in a pass; memoryless: whether the first pass is already periodic; criterion: limits of the differences;
        slowest_ratio: part of the slowest mode at equilibrium that is left after a pass; rounding: bounds of the
        motion of rings due to rounding.
        """
        self.cells, self.memoryless, self.criterion, self.Z = cells, memoryless, criterion, model.bearing.Z
        self.slowest_ratio, self.steps = slowest_ratio, steps
        self.rounding_ranges = PEAK_TO_PEAK * rounding.of_cells(cells)
        self.near_limit = NEAR_FACTOR * criterion.sum_limit if criterion.contraction == inf else MAX_CONTRACTED
        self.model = model
        # without accelerations, which jump, and without the cage, which is part of the final state
        self.compared_rows = np.r_[0:4, 9 : len(cells)]
        self.compared_rows = self.compared_rows[cells[self.compared_rows] != lay.SENSOR_A]
        self.weights = length_factors(model)
        self.lane = lay.lane_of(cells)
        self.lane_rows = set((cells - self.lane)[self.lane >= 0].tolist())
        self.min_peaks = np.array([name == "tilt.max" for name in EXTREMES]) / model.bearing.R_o
        capacity = int(MAX_STORED_BYTES // (8 * len(cells) * steps))
        self.periods = range(1, 1 + min(LONGEST_PERIOD, capacity))
        self.recordings: deque[np.ndarray] = deque(maxlen=len(self.periods) + 1)
        self.end_states: deque[np.ndarray] = deque(maxlen=len(self.periods) + 1)
        self.peaks: deque[np.ndarray] = deque(maxlen=len(self.periods) + 1)
        compared_cells = cells[self.compared_rows]
        self.rotated_rows = {period: rotated_rows(compared_cells, self.Z, period) for period in self.periods}
        self.differences: dict[int, list[float]] = {period: [] for period in self.periods}

    def add_pass(self, pass_values: np.ndarray, y: np.ndarray, peaks: np.ndarray) -> tuple[int, float]:
        """Compare a pass with those before it; return the period in ball passes (0 for none) and a difference.

        The difference is that of passes a period apart, or the smallest for any period if there is none.

        pass_values: (C, n) values at the steps of the pass, preceded by the end of the pass before; y: the buffer
        at its end; peaks: ``EXTREMES`` within it.
        """
        if self.memoryless:
            return 1, 0.0
        if not self.periods:
            return 0, nan
        self.recordings.append(pass_values[self.compared_rows, -self.steps :])
        end_state = y[lay.POSITION : lay.POSITION + 2 * lay.STATE] * self.weights
        self.end_states.append(end_state.reshape(2, 6, lay.ROW))
        self.peaks.append(peaks)
        ranges = self._ranges(self.recordings[-1])
        end_ranges = self._end_ranges(ranges)
        for period in self.periods:
            if period < len(self.end_states):
                differences = self.differences[period]
                differences.append(self._difference(period, ranges, end_ranges))
                passes = self.criterion.pass_count + period - 1  # each pass of a period must agree
                if all(
                    _has_converged(differences[: len(differences) - n], self.criterion, self.slowest_ratio)
                    for n in range(passes)
                ):
                    return period, differences[-1]
        if len(self.end_states) > 1 and self._is_near_orbit(self.differences[1][-1]):
            return 1, self.differences[1][-1]
        return 0, min((differences[-1] for differences in self.differences.values() if differences), default=nan)

    @property
    def contraction(self) -> float:
        """Ratio of the last difference of successive passes to the one before; that of another step if unknown."""
        last_two = self.differences.get(1, [])[-2:]
        if len(last_two) < 2 or not 0.0 < last_two[0] < inf:
            return self.criterion.contraction
        return max(last_two[1] / last_two[0], self.slowest_ratio)

    def _is_near_orbit(self, difference: float) -> bool:
        """Check if a pass is on the periodic orbit, by its last difference and a known contraction."""
        error = CONTRACTION_MARGIN * self.criterion.contraction * difference
        return difference <= MAX_CONTRACTED and error <= self.criterion.sum_limit

    def _ranges(self, recording: np.ndarray) -> np.ndarray:
        """Return the range of the quantity of each recorded row (C,), 0 if it is not compared.

        It is infinite for motion within rounding, whose differences are no differences of the motion.
        """
        high, low = np.zeros(len(self.cells)), np.zeros(len(self.cells))
        high[self.compared_rows], low[self.compared_rows] = recording.max(axis=1), recording.min(axis=1)
        ranges = high - low
        for pair in (ranges[:2], ranges[2:4]):
            pair[:] = np.maximum(pair, MIN_RELATIVE_RANGE * pair.max())
        for row in self.lane_rows:  # one range for all rollers
            rows = (self.lane >= 0) & (self.cells - self.lane == row)
            ranges[rows] = high[rows].max() - low[rows].min()
        ranges[(ranges <= self.rounding_ranges) & (self.rounding_ranges > 0.0)] = inf
        return ranges

    def _end_ranges(self, ranges: np.ndarray) -> np.ndarray:
        """Return the range (2, 6) of each row of positions and velocities over the rollers at the last end."""
        rollers = self.end_states[-1][:, :, lay.FIRST_LANE : lay.FIRST_LANE + self.Z]
        ring_ranges = np.array([[ranges[:2].max()], [ranges[2:4].max()]])
        roller_ranges = rollers.max(axis=2) - rollers.min(axis=2)
        only_rollers = np.isinf(ring_ranges) & (roller_ranges > 0.0)  # rollers move although the ring does not
        return np.where(only_rollers, roller_ranges, np.maximum(ring_ranges, roller_ranges))

    def _difference(self, period: int, ranges: np.ndarray, end_ranges: np.ndarray) -> float:
        """Return the largest difference of the last pass from that ``period`` passes before.

        Only the final states are compared if they differ by more than ``near_limit``.
        """
        previous_end = rotate_state(self.end_states[-1 - period], self.model, -period)
        end_differences = np.abs(self.end_states[-1] - previous_end).max(axis=2)
        end_difference = _largest_ratio(end_differences, end_ranges)  # as lengths and speeds
        if not end_difference <= self.near_limit:
            return end_difference
        current, previous = self.recordings[-1], self.recordings[-1 - period]
        row_differences = np.array(
            [np.abs(a - previous[c]).max() for a, c in zip(current, self.rotated_rows[period], strict=True)]
        )
        displacement_range = ranges[:2].max()
        if np.isinf(displacement_range):  # within rounding
            displacement_range = self.rounding_ranges[:2].max()
        min_peaks = self.min_peaks * displacement_range
        peak_differences = np.abs(self.peaks[-1] - self.peaks[-1 - period])
        peak_ratio = _largest_ratio(peak_differences, np.maximum(self.peaks[-1], min_peaks))
        return max(end_difference, _largest_ratio(row_differences, ranges[self.compared_rows]), peak_ratio)


def rotated_rows(cells: np.ndarray, Z: int, m: int) -> np.ndarray:
    """Return the rows (C,) of the rollers that were in the same positions ``m`` passes earlier.

    cells: (C,) recorded cells; rows without a roller are unchanged.
    """
    lane = lay.lane_of(cells)
    rotated = np.where(lane >= 0, cells - lane + (lane + m) % Z, cells)
    row_of = {int(cell): row for row, cell in enumerate(cells)}
    return np.array([row_of[int(cell)] for cell in rotated])


def rotate_state(state: np.ndarray, model: Any, passes: int) -> np.ndarray:
    """Return positions and velocities (2, 6, ROW) with the rollers rotated by ``passes`` ball passes."""
    rotated, row_count = state.copy(), degrees_of_freedom(model)[0]
    if row_count == 0:  # rollers without mass
        return rotated
    lanes = slice(lay.FIRST_LANE, lay.FIRST_LANE + model.bearing.Z)
    rotated[:, :row_count, lanes] = np.roll(rotated[:, :row_count, lanes], passes, axis=2)
    return rotated


def _largest_ratio(differences: np.ndarray, ranges: np.ndarray) -> float:
    """Return the largest ratio of difference to range; a zero difference counts as 0 even for a zero range."""
    differs = differences != 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        return float((differences[differs] / ranges[differs]).max(initial=0.0))


def _has_converged(differences: list[float], criterion: PeriodCriterion, slowest_ratio: float) -> bool:
    """Check if the last of successive differences, and the estimated sum of all later ones, are small.

    slowest_ratio: ratio of successive differences in the slowest mode, which may be too small to show in the
    differences.
    """
    if not differences or not isfinite(differences[-1]):
        return False
    last = differences[-1]
    if last <= criterion.difference_limit and remaining_sum(last, slowest_ratio) <= criterion.sum_limit:
        return True
    if len(differences) < 3 or not isfinite(differences[-3]):
        return False
    previous, earlier = differences[-2], differences[-3]
    if previous == 0.0 or earlier == 0.0:  # the ratio is undefined
        return False
    rho = max(last / previous, previous / earlier, slowest_ratio)
    return rho < MAX_DECAY_RATIO and remaining_sum(last, rho) <= criterion.sum_limit


def remaining_sum(difference: float, ratio: float) -> float:
    """Return the sum of a geometric sequence of ratio ``ratio`` after ``difference``, at least ``difference``."""
    return difference * max(1.0, ratio / (1.0 - ratio)) if ratio < 1.0 else inf
