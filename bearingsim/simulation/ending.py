"""Ball passes after which a record with `until` is inspected, and may end.

With a free cage or a rotating defect, tens of successive passes are correlated. A record is inspected after nearly
whole revolutions of every defect, but not before 64 passes, five revolutions of the cage and six units
(docs/repetition.md).
"""

from collections.abc import Iterator
from math import ceil

from bearingsim.config import Case
from bearingsim.simulation.pilot import DEFECT_TURN, elements_with_deviations

MIN_PASSES, MIN_CAGE_TURNS, MIN_UNITS = 64, 5, 6
"""Smallest numbers of ball passes, of cage turns and of units (``unit``) in a record that ends early."""
MIN_UNIT = 2
"""Smallest unit, in ball passes."""
UNIT_TOLERANCE = 0.01
"""Largest distance of a unit from whole revolutions, relative to the unit; passes differ more otherwise."""
INSPECTION_RATIO = 1.25
"""Smallest ratio of the numbers of ball passes at successive inspections."""
RECORD_TOLERANCE = 0.2
"""Largest distance from whole revolutions, relative to the record, as a fraction of `until`. The relative error of
an RMS is at most half the distance times the ratio of the largest mean square within a revolution to that of the
revolution."""


def turn_lengths(case: Case) -> list[float]:
    """Return the number of ball passes in a turn through the load zone, for each element that turns with a defect
    or form."""
    rate = case.bearing.ball_pass_frequency(case.speed)
    lengths = (DEFECT_TURN[element](case) * rate for element in elements_with_deviations(case))
    return [float(length) for length in lengths if length > 0.0]


def unit(case: Case) -> int:
    """Return the smallest number of ball passes that is nearly a whole number of revolutions of every defect."""
    lengths = turn_lengths(case)
    max_passes = ceil(case.duration * case.bearing.ball_pass_frequency(case.speed))
    return next(
        (n for n in range(MIN_UNIT, max_passes) if _distance(n, lengths) <= UNIT_TOLERANCE * n), max_passes
    )


def _distance(passes: int, lengths: list[float]) -> float:
    """Return the largest distance of a number of ball passes from whole revolutions, in ball passes."""
    return max((abs(passes - round(passes / turn) * turn) for turn in lengths), default=0.0)


def inspection_passes(case: Case) -> Iterator[int]:
    """Yield the ball passes of a record after which it is inspected before its end; none without `until`."""
    if case.until is None:
        return
    max_passes = ceil(case.duration * case.bearing.ball_pass_frequency(case.speed) - 1.0)
    lengths = turn_lengths(case)
    passes = min_passes(case)
    while passes < max_passes:
        if _distance(passes, lengths) <= RECORD_TOLERANCE * case.until * passes:
            yield passes
            passes = ceil(INSPECTION_RATIO * passes)
        else:
            passes += 1


def min_passes(case: Case) -> int:
    """Return the smallest number of ball passes in a record that ends at the accuracy `until`."""
    return max(MIN_PASSES, MIN_CAGE_TURNS * case.bearing.rollers, MIN_UNITS * unit(case))
