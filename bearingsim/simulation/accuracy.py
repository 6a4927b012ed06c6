"""How well a record knows its line and its RMS: standard errors from its ball passes."""

from typing import Any, NamedTuple

import numpy as np
from scipy.special import stdtrit

from bearingsim import signals
from bearingsim.config import Case
from bearingsim.core.sampling import sampling_kernel
from bearingsim.simulation.features import sensed
from bearingsim.simulation.raw_record import RawRecord
from bearingsim.simulation.record_windows import windows
from bearingsim.simulation.time_grid import Grid

MIN_BLOCKS = 8  # of passes: fewer do not tell how they scatter
MIN_PASSES = 16
THREE_SIGMA = 0.99865  # the probability of no more than that
LOOK_AGAIN = 1.1  # times as many passes: so seldom the errors are looked at
QUIET_LINE = 1e-3  # a line under this part of the RMS (60 dB below it) is none, and is measured by it


class StandardErrors(NamedTuple):
    """Of the velocity's line at BPFO and of its RMS, relative."""

    line: float
    rms: float

    @property
    def largest(self) -> float:
        """The larger one."""
        return max(self)


def standard_errors(case: Case, model: Any, cut: Grid, raw: RawRecord) -> StandardErrors:
    """Those of what has been computed of a record; infinite of too few passes."""
    taps = sampling_kernel(cut.fine_rate / case.sampling)
    of_record = windows(case, cut, raw, reach=len(taps) // 2)
    M, n = of_record.M, len(of_record.index)
    if raw.repetition.period > 0:
        return StandardErrors(0.0, 0.0)
    if n < MIN_PASSES:
        return StandardErrors(np.inf, np.inf)
    velocity = sensed(case, raw, "velocity", of_record.start, n * M)
    angle = case.bearing.rollers * model.bearing.theta_0
    (lines,) = signals.lines_by_pass(velocity, M, [1], of_record.start, angle)
    low = sensed(case, raw.through(taps), "velocity", of_record.start, n * M)
    power = np.mean(low.reshape(n, M) ** 2, axis=1)
    mean, rms = lines.mean(), np.sqrt(power.mean())
    along = (lines * np.exp(-1j * np.angle(mean))).real
    return StandardErrors(
        float(standard_error(along) / (max(abs(mean), QUIET_LINE * rms) or 1.0)),
        float(0.5 * standard_error(power) / (power.mean() or 1.0)),
    )


def standard_error(values: np.ndarray) -> float:
    """The standard error of the mean of ``values`` (n,), of which neighbours may be alike.

    From blocks of 1, 2, 4 ... of them, whichever says more: what is loud may stay loud for a while. Few blocks
    tell little of how they scatter, so by Student's t it is such that three of it hold as surely as three sigma.
    """
    found, size = 0.0, 1
    while len(values) // size >= MIN_BLOCKS:
        blocks = values[: len(values) // size * size].reshape(-1, size).mean(axis=1)
        n = len(blocks)
        found = max(found, float(stdtrit(n - 1.0, THREE_SIGMA) / 3.0 * blocks.std(ddof=1)) / n**0.5)
        size *= 2
    return found
