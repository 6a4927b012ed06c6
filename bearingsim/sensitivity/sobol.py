"""Sobol indices: shares of the variance of a feature by parameter.

The parameters vary independently, each by its distribution. V is the variance of the feature f.

- The first index of a parameter, S_j = V(E(f | x_j))/V, is the share that it decides alone.
- The total index, T_j = E(V(f | all others))/V, is that with all it does together with others.
- 1 - sum S_j is what only acts together.
"""

from typing import NamedTuple

import numpy as np

from bearingsim.sensitivity.intervals import Array, Estimate, estimate


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


def of_blocks(blocks: Array) -> Indices:
    """Compute the indices of blocks as in ``indices``, with intervals."""
    estimates = estimate(_all, blocks)
    d = blocks.shape[1] - 2
    parts = (slice(d), slice(d, 2 * d), slice(2 * d, None))
    return Indices(*(Estimate(*(ends[part] for ends in estimates)) for part in parts))


def _all(blocks: Array) -> Array:
    """Concatenate first indices, total ones, and 1 - sum S_j, (2d + 1,)."""
    alone, total = indices(blocks)
    return np.concatenate([alone, total, [1.0 - alone.sum()]])
