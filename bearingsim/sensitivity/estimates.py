"""Sobol indices and elementary effects after Morris, with bootstrap confidence intervals.

Sobol indices are shares of the variance V of a feature f; the parameters vary independently.

- The first index of a parameter, S_j = V(E(f | x_j))/V, is the share that it decides alone.
- The total index, T_j = E(V(f | all others))/V, is that with all it does together with others.
- 1 - sum S_j is what only acts together.

An elementary effect is the change of a feature by one step of one parameter, over the length of the step in the
unit cube: it is in the feature's unit, for the whole range of the parameter.

- mu, the mean of the effects of a parameter: which way it acts.
- mu*, the mean of their magnitudes: how much it matters, also where effects cancel.
- sigma, their standard deviation: how much that depends on where the others are, or on itself.

Morris, Technometrics 33 (1991) 161-174; mu*: Campolongo, Cariboni and Saltelli, Environmental Modelling & Software
22 (2007) 1509-1518. They rank; they are no shares of a variance.
"""

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


class Indices(NamedTuple):
    """First and total indices of d parameters, and the one number 1 - sum S_j."""

    first: Estimate
    total: Estimate
    together: Estimate


def indices(blocks: Array) -> Array:
    """Compute first (row 0) and total (row 1) indices (2, d) of blocks (n, d + 2) f(A), f(B), f(AB^1) ... f(AB^d).

    AB^j is A with parameter j from B. By the correlations r of f(A) and f(B), c_j of f(B) and f(AB^j), e_j of f(A)
    and f(AB^j):

        S_j = (c_j - r e_j)/(1 - r^2),    T_j = mean((f(A) - f(AB^j))^2)/(2 V), V over A and B

    c_j alone would be S_j if A and B were independent, and r zero. In a design by Sobol' of few points, some
    columns of A and B are correlated, and r is not zero: what it puts into c_j is taken out (Glen and Isaacs,
    Environmental Modelling & Software 37 (2012) 157-166). An inert parameter has 0, the only one 1, whatever r is.
    T_j: Jansen 1999, as in Saltelli et al., Computer Physics Communications 181 (2010) 259-270, table 2 (f), and
    in ``scipy.stats.sobol_indices``. Estimates may be a little below 0 or above 1. NaN where f does not vary.
    """
    f = blocks - blocks.mean(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        unit = f / np.sqrt((f**2).mean(axis=0))
        a, b, mixed = unit[:, :1], unit[:, 1:2], unit[:, 2:]
        r, c, e = (a * b).mean(), (b * mixed).mean(axis=0), (a * mixed).mean(axis=0)
        alone = (c - r * e) / (1.0 - r**2)
        steps = blocks[:, :1] - blocks[:, 2:]
        total = (steps**2).mean(axis=0) / (2.0 * blocks[:, :2].var())
    return np.stack([alone, total])


def estimate_indices(blocks: Array) -> Indices:
    """Compute the indices of blocks as in ``indices``, with intervals."""
    estimates = estimate(_all, blocks)
    d = blocks.shape[1] - 2
    parts = (slice(d), slice(d, 2 * d), slice(2 * d, None))
    return Indices(*(Estimate(*(ends[part] for ends in estimates)) for part in parts))


def _all(blocks: Array) -> Array:
    """Concatenate first indices, total ones, and 1 - sum S_j, (2d + 1,)."""
    alone, total = indices(blocks)
    return np.concatenate([alone, total, [1.0 - alone.sum()]])


class Effects(NamedTuple):
    """mu, mu* and sigma of d parameters, in the feature's unit over the whole range."""

    mean: Estimate
    magnitude: Estimate
    spread: Estimate


def elementary(points: Array, values: Array) -> Array:
    """Compute the elementary effects (n, d) of trajectories: points (n, d + 1, d) in the unit cube, values (n, d +
    1).

    Each step of a trajectory changes one parameter, and each parameter changes once.
    """
    steps, changes = np.diff(points, axis=1), np.diff(values, axis=1)
    moved = np.argmax(steps != 0.0, axis=1)  # (n, d): the step that moves each parameter
    lengths = np.take_along_axis(steps, moved[:, None, :], axis=1)[:, 0, :]
    return np.asarray(np.take_along_axis(changes, moved, axis=1) / lengths)


def estimate_effects(points: Array, values: Array) -> Effects:
    """Compute mu, mu* and sigma of trajectories as in ``elementary``, with intervals."""
    statistics = estimate(_statistics, elementary(points, values))
    return Effects(*(Estimate(*(ends[row] for ends in statistics)) for row in range(3)))


def _statistics(effects: Array) -> Array:
    return np.stack([effects.mean(axis=0), np.abs(effects).mean(axis=0), effects.std(axis=0, ddof=1)])
