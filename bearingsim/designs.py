"""Space-filling designs: points in the unit cube, reproducible on every machine.

=========  ==========================================================  ==============  ===========================
kind       construction                                                rows            effect of a larger n
=========  ==========================================================  ==============  ===========================
lhs        Latin hypercube (McKay, Beckman, Conover 1979)              n               different points
sobol      scrambled Sobol' sequence (Matousek 1998; Joe, Kuo 2008)    n               keeps the points, adds more
saltelli   halves A, B of a Sobol' point, A with one column of B       n (d + 2)       keeps the points, adds more
morris     trajectories that move one parameter at a time              n (d + 1)       keeps the points, adds more
=========  ==========================================================  ==============  ===========================
"""

from typing import TYPE_CHECKING, Literal, get_args

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

Kind = Literal["lhs", "sobol", "saltelli", "morris"]
KINDS: tuple[Kind, ...] = get_args(Kind)
EXTENSIBLE: tuple[Kind, ...] = ("sobol", "saltelli", "morris")
"""Designs whose existing rows do not change when ``n`` is increased."""
LEVELS = (1 / 16, 5 / 16, 11 / 16, 15 / 16)
"""Levels of a parameter in a Morris design, as probabilities: one in each quarter."""
MORRIS_STEP = 5 / 8
"""Step of a Morris design as a share of the range, two levels up or down. A step of 1/2 would miss effects with a
period of half the range."""


def unit_cube_points(kind: Kind, n: int, d: int, seed: int) -> "NDArray[np.float64]":
    """Compute the points of a design, an array (rows, d) in [0, 1).

    n: number of points of `lhs` and `sobol`, of base points of `saltelli`, of trajectories of `morris`. Rows are
    ordered in blocks of ``block_size(kind, d)`` rows.
    """
    import numpy as np

    return _CONSTRUCTORS[kind](n, d, np.random.default_rng(seed))


def block_size(kind: Kind, d: int) -> int:
    """Return the number of rows in a block: 1 for `lhs` and `sobol`, d + 2 for `saltelli`, d + 1 for `morris`."""
    return {"saltelli": d + 2, "morris": d + 1}.get(kind, 1)


def _lhs(n: int, d: int, rng: "np.random.Generator") -> "NDArray[np.float64]":
    from scipy.stats import qmc

    return qmc.LatinHypercube(d, seed=rng).random(n)


def _sobol(n: int, d: int, rng: "np.random.Generator") -> "NDArray[np.float64]":
    """Draw the smallest number 2^k >= n of points, for which the sequence is balanced; return the first n."""
    from scipy.stats import qmc

    return qmc.Sobol(d, seed=rng).random_base2((n - 1).bit_length())[:n]


def _saltelli(n: int, d: int, rng: "np.random.Generator") -> "NDArray[np.float64]":
    """Compute the blocks A_i, B_i, AB_i^(1) ... AB_i^(d); AB_i^(j) is A_i with column j of B_i.

    A and B are the halves of one sequence in 2d dimensions. Saltelli et al., Computer Physics Communications 181
    (2010) 259-270, table 2 (b) and (f), as used by ``scipy.stats.sobol_indices``.
    """
    import numpy as np

    points = _sobol(n, 2 * d, rng)
    a, b = points[:, :d], points[:, d:]
    mixed = np.where(np.eye(d, dtype=bool), b[:, None, :], a[:, None, :])
    return np.concatenate([a[:, None, :], b[:, None, :], mixed], axis=1).reshape(-1, d)


def _morris(n: int, d: int, rng: "np.random.Generator") -> "NDArray[np.float64]":
    """Compute trajectories of d + 1 points; each step changes one parameter, in random order, by MORRIS_STEP.

    Morris, Technometrics 33 (1991) 161-174, with p = 4 levels and steps of two levels. Its levels are 0, 1/3, 2/3
    and 1; ``LEVELS`` lie in the interior, so that a normal distribution is not sampled at its bounds.
    """
    import numpy as np

    start, direction, order = np.moveaxis(rng.random((n, 3, d)), 1, 0)
    half = len(LEVELS) // 2
    low = np.floor(half * start).astype(int)
    decreasing = direction < 0.5
    rank = order.argsort(axis=1).argsort(axis=1)
    stepped = rank[:, None, :] < np.arange(d + 1)[:, None]
    level = low[:, None, :] + half * (stepped ^ decreasing[:, None, :])
    return np.array(LEVELS)[level].reshape(-1, d)


_CONSTRUCTORS: dict[Kind, "Callable[[int, int, np.random.Generator], NDArray[np.float64]]"] = {
    "lhs": _lhs,
    "sobol": _sobol,
    "saltelli": _saltelli,
    "morris": _morris,
}
