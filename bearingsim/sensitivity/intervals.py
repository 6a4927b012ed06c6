"""How well an estimate from the blocks of a design is known: intervals by the bootstrap."""

import warnings
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["LEVEL", "Array", "Estimate", "estimate"]

Array = NDArray[np.float64]
LEVEL = 0.95
"""Of an interval: of 100 of them some 95 hold the value."""
RESAMPLES, SEED = 999, 1


class Estimate(NamedTuple):
    """Some values, each with the ends of its interval; arrays of one shape."""

    value: Array
    low: Array
    high: Array


def estimate(statistic: Callable[[Array], Array], blocks: Array) -> Estimate:
    """What a statistic makes of the blocks (n, ...), and how far chance moves it.

    Blocks are drawn with replacement, each as a whole, since its rows belong together. An interval lies between
    two percentiles of what 999 draws give (Efron and Tibshirani, An Introduction to the Bootstrap, 1993, ch. 13).
    The draws are seeded: the same blocks give the same interval. Blocks of one Sobol' sequence are more even than
    draws, so intervals of their indices are rather too wide. NaN where a draw has no value of the statistic.
    """
    from scipy.stats import DegenerateDataWarning, bootstrap

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DegenerateDataWarning)  # the interval is NaN then, which says it
        found = bootstrap(
            (np.arange(len(blocks)),),
            lambda drawn: statistic(blocks[drawn]),
            n_resamples=RESAMPLES,
            vectorized=False,
            confidence_level=LEVEL,
            method="percentile",
            random_state=np.random.default_rng(SEED),
        ).confidence_interval
    return Estimate(statistic(blocks), np.asarray(found.low), np.asarray(found.high))
