"""Ball passes after which a record with `until` is judged, and may end.

Passes of a free cage, and those over a defect that turns, are correlated over tens of passes. A record is judged
over whole turns of every defect, never before 64 passes and five turns of the cage (docs/repetition.md).
"""

from collections.abc import Iterator
from math import ceil

from bearingsim.config import Case
from bearingsim.simulation.pilot import DEFECT_TURN

FEWEST_PASSES, FEWEST_CAGE_TURNS, FEWEST_UNITS = 64, 5, 6
"""Smallest numbers of ball passes, of turns of the cage, and of units (``unit``) in a record that ends."""
PASSES = 2
"""Smallest unit, in ball passes."""
NEARLY_WHOLE = 0.01
"""Largest distance of a unit from whole turns, in parts of it: less than other differences between its passes."""
LOOK_AGAIN = 1.25
"""Least ratio of the passes at which a record is judged again to those before."""
WHOLE = 0.2
"""Largest distance from whole turns, in parts of the record, over `until`: an RMS errs by no more than its half
times the ratio of a turn's largest mean square to its mean."""


def turns(case: Case) -> list[float]:
    """Return the ball passes in a turn of each kind of defect that turns."""
    rate = case.bearing.ball_pass_frequency(case.speed)
    lengths = (DEFECT_TURN[race](case) * rate for race in dict.fromkeys(defect.race for defect in case.defects))
    return [float(length) for length in lengths if length > 0.0]


def unit(case: Case) -> int:
    """Return the fewest ball passes that nearly hold whole turns of every defect; passes by the unit are alike."""
    of_defects = turns(case)
    most = ceil(case.duration * case.bearing.ball_pass_frequency(case.speed))
    return next((n for n in range(PASSES, most) if _distance(n, of_defects) <= NEARLY_WHOLE * n), most)


def _distance(passes: int, turns: list[float]) -> float:
    """Return the largest distance of some ball passes from whole turns, in ball passes."""
    return max((abs(passes - round(passes / turn) * turn) for turn in turns), default=0.0)


def looks(case: Case) -> Iterator[int]:
    """Yield the ball passes of a record after which it is judged, fewer than it holds; none without `until`."""
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
    """Return the smallest number of ball passes in a record that ends `until` an accuracy."""
    return max(FEWEST_PASSES, FEWEST_CAGE_TURNS * case.bearing.rollers, FEWEST_UNITS * unit(case))
