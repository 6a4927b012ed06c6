"""Functions of the unit cube whose Sobol' indices are known in closed form."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class ReferenceIndices(NamedTuple):
    """A function of points (..., d), and its indices (d,)."""

    function: Callable[[Array], Array]
    first: Array
    total: Array


def _ishigami(a: float = 7.0, b: float = 0.1) -> ReferenceIndices:
    """sin x + a sin^2 y + b z^4 sin x, each of them from -pi to pi (Ishigami and Homma, 1990)."""

    def function(u: Array) -> Array:
        x, y, z = np.moveaxis(math.pi * (2.0 * u - 1.0), -1, 0)
        return np.asarray(np.sin(x) + a * np.sin(y) ** 2 + b * z**4 * np.sin(x))

    variance_x = 0.5 * (1.0 + b * math.pi**4 / 5.0) ** 2
    variance_y = a**2 / 8.0
    variance_xz = b**2 * math.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)  # x and z
    variance = variance_x + variance_y + variance_xz
    return ReferenceIndices(
        function,
        np.array([variance_x, variance_y, 0.0]) / variance,
        np.array([variance_x + variance_xz, variance_y, variance_xz]) / variance,
    )


def _sobol_g(a: Array) -> ReferenceIndices:
    """The product of (|4 x_j - 2| + a_j)/(1 + a_j) (Saltelli and Sobol', 1995)."""

    def function(u: Array) -> Array:
        return np.asarray(np.prod((np.abs(4.0 * u - 2.0) + a) / (1.0 + a), axis=-1))

    variances = 1.0 / 3.0 / (1.0 + a) ** 2
    variance = np.prod(1.0 + variances) - 1.0
    return ReferenceIndices(
        function, variances / variance, variances * np.prod(1.0 + variances) / (1.0 + variances) / variance
    )


ISHIGAMI = _ishigami()
SOBOL_G = _sobol_g(np.array([0.0, 1.0, 4.5, 9.0]))
