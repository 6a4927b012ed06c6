"""Sobol' indices: which share of the variance of a feature is whose.

The parameters vary independently, each by its distribution. V is the variance of the feature f.

- The first index of a parameter, S_j = V(E(f | x_j))/V, is the share that it decides alone.
- The total index, T_j = E(V(f | all others))/V, is that with all it does together with others.
- 1 - sum S_j is what only acts together.
"""

from typing import NamedTuple

import numpy as np

from bearingsim.sensitivity.intervals import Array, Estimate, estimate

__all__ = ["Indices", "indices", "of_blocks"]


class Indices(NamedTuple):
    """First and total indices of d parameters, and the one number 1 - sum S_j."""

    first: Estimate
    total: Estimate
    together: Estimate


def indices(blocks: Array) -> Array:
    """First (row 0) and total (row 1) indices (2, d) of blocks (n, d + 2) f(A), f(B), f(AB^1) ... f(AB^d).

    AB^j is A with parameter j from B. The estimators are those of ``scipy.stats.sobol_indices``, which takes only
    whole designs of 2^m blocks:

        S_j = mean(f(B) (f(AB^j) - f(A)))/V,    T_j = mean((f(A) - f(AB^j))^2)/(2 V)

    (Saltelli et al., Computer Physics Communications 181 (2010) 259-270, table 2 (b); (f), after Jansen 1999), V
    over A and B. f is centred first: S_j is a mean of products, whose error grows with the mean of f, which has
    nothing to do with S_j. Estimates may be a little below 0 or above 1. NaN where f does not vary.
    """
    f = blocks - blocks[:, :2].mean()
    a, b, mixed = f[:, :1], f[:, 1:2], f[:, 2:]
    with np.errstate(invalid="ignore", divide="ignore"):
        first = (b * (mixed - a)).mean(axis=0) / f[:, :2].var()
        total = ((a - mixed) ** 2).mean(axis=0) / (2.0 * f[:, :2].var())
    return np.stack([first, total])


def of_blocks(blocks: Array) -> Indices:
    """The indices of blocks as of ``indices``, with intervals."""
    found = estimate(_all, blocks)
    d = blocks.shape[1] - 2
    parts = (slice(d), slice(d, 2 * d), slice(2 * d, None))
    return Indices(*(Estimate(*(ends[part] for ends in found)) for part in parts))


def _all(blocks: Array) -> Array:
    """First indices, total ones, and 1 - sum S_j, one after the other (2d + 1)."""
    first, total = indices(blocks)
    return np.concatenate([first, total, [1.0 - first.sum()]])
