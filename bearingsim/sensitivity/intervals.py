"""Confidence intervals of estimates from the blocks of a design, by the bootstrap."""

import warnings
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
LEVEL = 0.95
"""Confidence level of an interval."""
RESAMPLES, SEED = 999, 1


class Estimate(NamedTuple):
    """Values with the limits of their confidence intervals; arrays of one shape."""

    value: Array
    low: Array
    high: Array


def estimate(statistic: Callable[[Array], Array], blocks: Array) -> Estimate:
    """Compute a statistic of the blocks (n, ...) with bootstrap confidence intervals.

    Blocks are resampled with replacement, each as a whole, since its rows belong together. An interval lies
    between two percentiles of 999 resamples (Efron and Tibshirani, An Introduction to the Bootstrap, 1993, ch.
    13). The resampling is seeded: the same blocks give the same interval. Blocks of one Sobol sequence are more
    even than random ones, so intervals of their indices are conservative. NaN if the statistic of a resample is
    undefined.
    """
    from scipy.stats import DegenerateDataWarning, bootstrap

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DegenerateDataWarning)  # the interval is NaN then, which says it
        interval = bootstrap(
            (np.arange(len(blocks)),),
            lambda drawn: statistic(blocks[drawn]),
            n_resamples=RESAMPLES,
            vectorized=False,
            confidence_level=LEVEL,
            method="percentile",
            random_state=np.random.default_rng(SEED),
        ).confidence_interval
    return Estimate(statistic(blocks), np.asarray(interval.low), np.asarray(interval.high))
