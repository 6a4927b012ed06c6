"""Nystrom's method of fourth order for q'' = f(t, q, v), four evaluations per step.

For equations of second order. It costs as much as RK4; its second and third stages have the same positions.
Source: Nystrom 1925; Hairer, Norsett and Wanner, Solving ODEs I, 2nd ed. 1993, sec. II.14, eq. 14.13 ("Nystrom
method of order 4" for velocity-dependent forces; Kreyszig, Advanced Engineering Mathematics, sec. 21.3).
"""

from typing import NamedTuple

import numpy as np

from bearingsim.core.methods.interface import MethodKind
from bearingsim.core.methods.tableau import Tableau, cusp_fraction, register_fixed_step

a, A = np.zeros((4, 4)), np.zeros((4, 4))
a[1, 0], a[2, 1], a[3, 2] = 1 / 2, 1 / 2, 1
A[1, 0], A[2, 0], A[3, 2] = 1 / 8, 1 / 8, 1 / 2
TABLE = Tableau(a.sum(axis=1), a, A, np.array([1, 2, 2, 1]) / 6, np.array([1, 1, 1, 0]) / 6)


class Nystrom(NamedTuple):
    """Parameters. h: step, s."""

    h: float


register_fixed_step(Nystrom, TABLE)

KIND = MethodKind(Nystrom, evaluations=4, fraction=0.25, per_period=20, cusp=cusp_fraction(TABLE), order=4)
