"""Johnson's line contact of two cylinders.

In dimensionless form one curve applies to all radii, lengths and materials. With x = Q'/(4 pi E* dR) and y =
delta/(4 dR)

    y = -x (ln x + 1),    dy/dx = -(ln x + 2)

x(y) has no closed form, and a logarithm would prevent the vectorisation of loops over rollers, so it is tabulated
(``laws/octaves.py``). The tabulated x and its derivative are continuous; the derivative is that of the
interpolant.

For 2^-36 <= y <= 2^-6 the relative error of x is below 1e-9, that of the derivative below 1e-6. Below, where the
slow variation with 1/ln y is negligible, the table is a parabola through the origin; above, a straight line. The
formula ends at y = e^-2 = 0.135 (x = e^-2), where its stiffness is infinite.
"""

from math import exp, log, pi
from typing import Any, NamedTuple

import numpy as np

from bearingsim.core.jit import generic, jit
from bearingsim.core.laws.hertz import effective_modulus
from bearingsim.core.laws.octaves import derivative, second_derivative, tabulate, value
from bearingsim.core.laws.stiffness.interface import curvature, elastic, tangent
from bearingsim.core.laws.stiffness.series import inner_approach, inner_approach_by_newton


def reduced_curve(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return x (n,) and dx/dy (n,), dimensionless, at each ``y`` (n,).

    Uses Newton's method on w - ln w = -1 - ln y, where w = y/x = -(ln x + 1) > 1.
    """
    right = -1.0 - np.log(y)
    w = right + np.log(right)
    for _ in range(8):
        w -= (w - np.log(w) - right) / (1.0 - 1.0 / w)
    return y / w, 1.0 / (w - 1.0)


TABLE = tabulate(reduced_curve)


@jit
def reduced_force(y):
    """Return x, the force over 4 pi E* dR L, at ``y`` >= 0, the approach over 4 dR."""
    return value(TABLE, y)


@jit
def reduced_derivative(y):
    """Return dx/dy, the derivative of ``reduced_force``."""
    return derivative(TABLE, y)


@jit
def reduced_curvature(y):
    """Return d2x/dy2, the derivative of ``reduced_derivative``, slightly discontinuous between cells."""
    return second_derivative(TABLE, y)


class Johnson(NamedTuple):
    """Line contact of two cylinders, delta = Q'/(pi E*) [ln(4 pi E* dR/Q') - 1] with Q' = Q/L solved for Q.

    force: 4 pi E* dR L (N), length: 4 dR (m); see ``make_johnson``. Source: K. L. Johnson, Contact Mechanics,
    Cambridge 1985, section 5.6: a cylinder of radius R is compressed, from its axis to the contact of half width
    a, by Q'/(2 pi E*) [2 ln(4 R/a) - 1]. The sum for R_1 and R_2, with a^2 = 4 Q' R_1 R_2/(pi E* (R_1 +- R_2)), is
    the formula above, with dR = R_1 + R_2, or R_2 - R_1 inside a ring (Pereira, Ramalho and Ambrosio, Nonlinear
    Dynamics 63 (2011) 681). It assumes a ring as thick as its own radius; twice the thickness would add Q' ln
    2/(pi E*), about 5 %.

    Plane strain: no end effects. The bracket must exceed 1, which it does for delta < 0.5 dR; the tabulated curve
    (``TABLE``) is within 1e-9 of the formula for 6e-11 dR < delta < 0.06 dR and is extended smoothly beyond.
    """

    force: float
    length: float


def make_johnson(E: float, nu: float, L: float, dR: float) -> Johnson:
    """Return the law of a roller of length ``L`` (m) on a race, both of ``E`` (Pa) and ``nu``.

    ``dR`` (m): R_i + R_w on the inner race, R_o - R_w on the outer.
    """
    return Johnson(4.0 * pi * effective_modulus(E, nu) * dR * L, 4.0 * dR)


@elastic.register(Johnson)
def _elastic(law, delta):
    return law.force * reduced_force(delta * (1.0 / law.length))


@tangent.register(Johnson)
def _tangent(law, delta):
    per_length = 1.0 / law.length
    return law.force * per_length * reduced_derivative(delta * per_length)


@curvature.register(Johnson)
def _curvature(law, delta):
    per_length = 1.0 / law.length
    return law.force * per_length * per_length * reduced_curvature(delta * per_length)


def _inner_approach_of_other(inner, outer, delta):
    return inner_approach_by_newton(outer, inner, delta)


@generic(otherwise=_inner_approach_of_other)
def inner_approach_with_johnson(inner: Any, outer: Any, delta: float) -> float:
    """Return ``inner_approach`` if the outer contact is ``Johnson``'s."""


@inner_approach.register(Johnson)
def _inner_approach_in_johnson(outer, inner, delta):
    return inner_approach_with_johnson(inner, outer, delta)


@inner_approach_with_johnson.register(Johnson)
def _inner_approach_of_two_johnson(inner, outer, delta):
    """Treat two contacts of this law in series as one contact of this law.

    With F = ``force`` and P = ``force``/``length`` of each, delta = Q (1/P_o + 1/P_i) [ln(F/Q) - 1], where ln F is
    the mean of ln F_o and ln F_i weighted by 1/P; the inner part is Q/P_i [ln(F_i/Q) - 1].
    """
    P_o, P_i = outer.force / outer.length, inner.force / inner.length
    weight = P_o / (P_o + P_i)
    log_ratio = log(inner.force / outer.force)
    F, S = outer.force * exp(weight * log_ratio), 1.0 / P_o + 1.0 / P_i
    Q = F * reduced_force(max(delta, 0.0) * (1.0 / (F * S)))
    return weight * max(delta, 0.0) + ((1.0 - weight) * log_ratio / P_i) * Q
