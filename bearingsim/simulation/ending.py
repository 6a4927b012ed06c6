"""Ball passes after which a record with `until` is inspected, and may end.

With a free cage or a rotating defect, tens of successive passes are correlated. A record is inspected after whole
turns of every defect, but not before 64 passes and five turns of the cage (docs/repetition.md).
"""

from collections.abc import Iterator
from math import ceil

from bearingsim.config import Case
from bearingsim.simulation.pilot import DEFECT_TURN

FEWEST_PASSES, FEWEST_CAGE_TURNS, FEWEST_UNITS = 64, 5, 6
"""Smallest numbers of ball passes, of cage turns and of units (``unit``) in a record that ends early."""
PASSES = 2
"""Smallest unit, in ball passes."""
NEARLY_WHOLE = 0.01
"""Largest distance of a unit from whole turns, relative to the unit; passes differ by more for other reasons."""
LOOK_AGAIN = 1.25
"""Smallest ratio of the numbers of ball passes at successive inspections."""
WHOLE = 0.2
"""Largest distance from whole turns, relative to the record, as a fraction of `until`. The relative error of an
RMS is at most half the distance times the ratio of the largest mean square within a turn to that of the turn."""


def turns(case: Case) -> list[float]:
    """Return the number of ball passes in a turn through the load zone, for each kind of rotating defect."""
    rate = case.bearing.ball_pass_frequency(case.speed)
    lengths = (DEFECT_TURN[race](case) * rate for race in dict.fromkeys(defect.race for defect in case.defects))
    return [float(length) for length in lengths if length > 0.0]


def unit(case: Case) -> int:
    """Return the smallest number of ball passes that is nearly a whole number of turns of every defect."""
    of_defects = turns(case)
    most = ceil(case.duration * case.bearing.ball_pass_frequency(case.speed))
    return next((n for n in range(PASSES, most) if _distance(n, of_defects) <= NEARLY_WHOLE * n), most)


def _distance(passes: int, turns: list[float]) -> float:
    """Return the largest distance of a number of ball passes from whole turns, in ball passes."""
    return max((abs(passes - round(passes / turn) * turn) for turn in turns), default=0.0)


def looks(case: Case) -> Iterator[int]:
    """Yield the ball passes of a record after which it is inspected before its end; none without `until`."""
    if case.until is None:
        return
    most = ceil(case.duration * case.bearing.ball_pass_frequency(case.speed) - 1.0)
    of_defects = turns(case)
    passes = fewest(case)
    while passes < most:
        if _distance(passes, of_defects) <= WHOLE * case.until * passes:
            yield passes
            passes = ceil(LOOK_AGAIN * passes)
        else:
            passes += 1


def fewest(case: Case) -> int:
    """Return the smallest number of ball passes in a record that ends at the accuracy `until`."""
    return max(FEWEST_PASSES, FEWEST_CAGE_TURNS * case.bearing.rollers, FEWEST_UNITS * unit(case))
