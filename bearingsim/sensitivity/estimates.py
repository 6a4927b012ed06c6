"""Sobol' indices and elementary effects after Morris, with bootstrap confidence intervals.

Sobol' indices are shares of the variance V of a feature f for independent parameters.

- The first-order index of a parameter, S_j = V(E(f | x_j))/V, is the share due to the parameter alone.
- The total index, T_j = E(V(f | all others))/V, includes its interactions with other parameters.
- 1 - sum S_j is the share due to interactions only.

An elementary effect is the change of a feature by one step of one parameter, divided by the length of the step in
the unit cube. It has the unit of the feature and refers to the whole range of the parameter.

- mu, the mean of the effects of a parameter, is its average slope.
- mu*, the mean of their magnitudes, measures its influence, even if effects cancel.
- sigma, their standard deviation, measures nonlinearity and interactions.

Morris, Technometrics 33 (1991) 161-174; mu*: Campolongo, Cariboni and Saltelli, Environmental Modelling & Software
22 (2007) 1509-1518. Elementary effects rank parameters; they are not shares of a variance.
"""

import warnings
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
LEVEL = 0.95
"""Confidence level of the intervals."""
RESAMPLE_COUNT, SEED = 999, 1  # of the bootstrap


class Estimate(NamedTuple):
    """Values with the limits of their confidence intervals, in arrays of the same shape."""

    value: Array
    low: Array
    high: Array


def estimate(statistic: Callable[[Array], Array], blocks: Array) -> Estimate:
    """Compute a statistic of the blocks (n, ...) with bootstrap confidence intervals.

    Whole blocks are resampled with replacement, because their rows depend on each other. The intervals are
    percentiles of 999 resamples (Efron and Tibshirani, An Introduction to the Bootstrap, 1993, ch. 13). The
    resampling is seeded, so the same blocks give the same interval. Blocks of a Sobol' sequence are more uniform
    than random ones, so intervals of their indices are conservative. NaN if the statistic of a resample is
    undefined.
    """
    from scipy.stats import DegenerateDataWarning, bootstrap

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DegenerateDataWarning)  # the interval is then NaN
        interval = bootstrap(
            (np.arange(len(blocks)),),
            lambda sample: statistic(blocks[sample]),
            n_resamples=RESAMPLE_COUNT,
            vectorized=False,
            confidence_level=LEVEL,
            method="percentile",
            random_state=np.random.default_rng(SEED),
        ).confidence_interval
    return Estimate(statistic(blocks), np.asarray(interval.low), np.asarray(interval.high))


class Indices(NamedTuple):
    """First-order and total indices of d parameters, and the scalar 1 - sum S_j."""

    first: Estimate
    total: Estimate
    interaction: Estimate


def sobol_indices(blocks: Array) -> Array:
    """Compute Sobol' indices (2, d), first-order and total, from blocks (n, d + 2).

    The columns of the blocks are f(A), f(B), f(AB^1) ... f(AB^d).

    AB^j is A with the values of parameter j from B. With the correlations r of f(A) and f(B), c_j of f(B) and
    f(AB^j), and e_j of f(A) and f(AB^j):

        S_j = (c_j - r e_j)/(1 - r^2),    T_j = mean((f(A) - f(AB^j))^2)/(2 V), V over A and B

    If A and B were independent, r would be zero and S_j = c_j. In a Sobol' sequence of few points, some columns of
    A and B are correlated, and the contribution of r to c_j is removed (Glen and Isaacs, Environmental Modelling &
    Software 37 (2012) 157-166). For any r, S_j is 0 for a parameter without influence and 1 for the only one with
    influence. T_j: Jansen 1999, as in Saltelli et al., Computer Physics Communications 181 (2010) 259-270, table 2
    (f), and in ``scipy.stats.sobol_indices``. Estimates may be slightly below 0 or above 1; NaN if f is constant.
    """
    centred = blocks - blocks.mean(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        standardised = centred / np.sqrt((centred**2).mean(axis=0))
        a, b, mixed = standardised[:, :1], standardised[:, 1:2], standardised[:, 2:]
        r, c, e = (a * b).mean(), (b * mixed).mean(axis=0), (a * mixed).mean(axis=0)
        first_order = (c - r * e) / (1.0 - r**2)
        differences = blocks[:, :1] - blocks[:, 2:]
        total = (differences**2).mean(axis=0) / (2.0 * blocks[:, :2].var())
    return np.stack([first_order, total])


def estimate_indices(blocks: Array) -> Indices:
    """Compute Sobol' indices of blocks (as in ``sobol_indices``), and 1 - sum S_j, with intervals."""
    estimates = estimate(_all_indices, blocks)
    d = blocks.shape[1] - 2
    parts = (slice(d), slice(d, 2 * d), slice(2 * d, None))
    return Indices(*(Estimate(*(array[part] for array in estimates)) for part in parts))


def _all_indices(blocks: Array) -> Array:
    """Concatenate first-order indices, total indices and 1 - sum S_j into (2 d + 1,)."""
    first_order, total = sobol_indices(blocks)
    with np.errstate(invalid="ignore"):  # infinities of a degenerate resample are subtracted
        return np.concatenate([first_order, total, [1.0 - first_order.sum()]])


class Effects(NamedTuple):
    """Morris effects mu, mu* and sigma of d parameters, in the unit of the feature over the whole range."""

    mu: Estimate
    mu_star: Estimate
    sigma: Estimate


def elementary_effects(points: Array, values: Array) -> Array:
    """Compute the elementary effects (n, d) of trajectories.

    points: (n, d + 1, d) in the unit cube; values: (n, d + 1). Each step of a trajectory changes one parameter,
    and each parameter changes once.
    """
    steps, changes = np.diff(points, axis=1), np.diff(values, axis=1)
    changed_step = np.argmax(steps != 0.0, axis=1)  # (n, d): step that changes each parameter
    lengths = np.take_along_axis(steps, changed_step[:, None, :], axis=1)[:, 0, :]
    return np.asarray(np.take_along_axis(changes, changed_step, axis=1) / lengths)


def estimate_effects(points: Array, values: Array) -> Effects:
    """Compute mu, mu* and sigma of trajectories (as in ``elementary_effects``), with intervals."""
    statistics = estimate(_effect_statistics, elementary_effects(points, values))
    return Effects(*(Estimate(*(array[row] for array in statistics)) for row in range(3)))


def _effect_statistics(effects: Array) -> Array:
    return np.stack([effects.mean(axis=0), np.abs(effects).mean(axis=0), effects.std(axis=0, ddof=1)])
