"""Ball passes after which a record with `until` is inspected, and may end.

With a free cage or a rotating defect, tens of successive passes are correlated. A record is inspected after nearly
whole revolutions of every defect, but not before 64 passes, five revolutions of the cage and six common periods of
the defects (docs/repetition.md).
"""

from collections.abc import Iterator
from math import ceil

from bearingsim.config import Case
from bearingsim.simulation.pilot import REVOLUTION_TIME, elements_with_deviations

MIN_PASSES, MIN_CAGE_REVOLUTIONS, MIN_COMMON_PERIODS = 64, 5, 6
"""Smallest numbers of ball passes, of cage revolutions and of common periods (``common_period``) in a record that
ends early."""
MIN_COMMON_PERIOD = 2
"""Shortest common period, in ball passes."""
COMMON_PERIOD_TOLERANCE = 0.01
"""Largest distance of a common period from whole revolutions, relative to the common period."""
INSPECTION_RATIO = 1.25
"""Smallest ratio of the numbers of ball passes at successive inspections."""
RECORD_TOLERANCE = 0.2
"""Largest distance of a record from whole revolutions, relative to the record, as a fraction of `until`. The
relative error of an RMS is at most half the distance times the ratio of the largest mean square within a
revolution to the mean square of the revolution."""


def revolution_lengths(case: Case) -> list[float]:
    """Return the ball passes in a revolution through the load zone, for each rotating defect or form."""
    rate = case.bearing.ball_pass_frequency(case.speed)
    revolutions = (REVOLUTION_TIME[element](case) * rate for element in elements_with_deviations(case))
    return [float(length) for length in revolutions if length > 0.0]


def common_period(case: Case) -> int:
    """Return the smallest number of ball passes that is nearly a whole number of revolutions of every defect.

    All passes of the record if there is no smaller one.
    """
    revolutions = revolution_lengths(case)
    max_passes = ceil(case.duration * case.bearing.ball_pass_frequency(case.speed))
    return next(
        (
            n
            for n in range(MIN_COMMON_PERIOD, max_passes)
            if _distance(n, revolutions) <= COMMON_PERIOD_TOLERANCE * n
        ),
        max_passes,
    )


def _distance(passes: int, revolutions: list[float]) -> float:
    """Return the largest distance (in ball passes) of a number of ball passes from whole revolutions.

    revolutions: lengths of the revolutions, in ball passes.
    """
    return max((abs(passes - round(passes / revolution) * revolution) for revolution in revolutions), default=0.0)


def inspection_passes(case: Case) -> Iterator[int]:
    """Yield the numbers of ball passes after which a record is inspected before its end; none without `until`."""
    if case.until is None:
        return
    max_passes = ceil(case.duration * case.bearing.ball_pass_frequency(case.speed) - 1.0)
    revolutions = revolution_lengths(case)
    passes = min_passes(case)
    while passes < max_passes:
        if _distance(passes, revolutions) <= RECORD_TOLERANCE * case.until * passes:
            yield passes
            passes = ceil(INSPECTION_RATIO * passes)
        else:
            passes += 1


def min_passes(case: Case) -> int:
    """Return the smallest number of ball passes in a record that ends at the accuracy `until`."""
    return max(MIN_PASSES, MIN_CAGE_REVOLUTIONS * case.bearing.rollers, MIN_COMMON_PERIODS * common_period(case))
