"""Runge-Kutta-Chebyshev method, second order, eight evaluations per step, explicit, for heavy damping.

With s stages its stability region reaches -0.65 (s^2 - 1) along the real axis: with eight stages -41, per
evaluation 7.4 times as far as RK4's. For oscillating motion it has almost no advantage. Source: Sommeijer,
Shampine and Verwer, J. Comput. Appl. Math. 88 (1998) 315, eqs 2.1-2.6, damping eps = 2/13. The recurrence of the
stages is expanded into a table (with eight stages the results are equal except for rounding errors).
"""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import Chebyshev

from bearingsim.core.methods.interface import MethodKind
from bearingsim.core.methods.tableau import Tableau, cusp_fraction, make_runge_kutta, register_fixed_step

STAGES, EPS = 8, 2 / 13  # EPS: damping of the stability polynomial


def make_chebyshev_table(s: int) -> Tableau:
    """Return the table of the method with ``s`` stages: row j contains the weights of the rates in stage Y_j.

    The last stage is the new state.
    """
    w_0 = 1.0 + EPS / s**2
    T = [Chebyshev.basis(j) for j in range(s + 1)]
    derivative, second_derivative = ([float(p.deriv(m)(w_0)) for p in T] for m in (1, 2))
    w_1 = derivative[s] / second_derivative[s]
    b = [
        second_derivative[j] / derivative[j] ** 2 if j > 1 else second_derivative[2] / derivative[2] ** 2
        for j in range(s + 1)
    ]
    rows = np.zeros((s + 1, s))
    rows[1, 0] = b[1] * w_1
    for j in range(2, s + 1):
        mu, nu, mu_tilde = 2.0 * b[j] * w_0 / b[j - 1], -b[j] / b[j - 2], 2.0 * b[j] * w_1 / b[j - 1]
        rows[j] = mu * rows[j - 1] + nu * rows[j - 2]
        rows[j, j - 1] += mu_tilde
        rows[j, 0] -= (1.0 - b[j - 1] * float(T[j - 1](w_0))) * mu_tilde
    return make_runge_kutta(rows[:s], rows[s])


TABLE = make_chebyshev_table(STAGES)


class Stabilised(NamedTuple):
    """Parameters. h: step, s."""

    h: float


register_fixed_step(Stabilised, TABLE)

KIND = MethodKind(Stabilised, evaluations=STAGES, fraction=0.25, per_period=40, cusp=cusp_fraction(TABLE), order=2)
