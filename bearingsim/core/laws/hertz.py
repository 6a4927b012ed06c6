"""Hertz contact: constants of the contact laws from geometry and material. Plain Python, not compiled.

Valid for smooth and dry elastic half-spaces of one material (E, nu), with a contact small compared to the radii.
Source: K. L. Johnson, Contact Mechanics, Cambridge 1985, sections 4.1 and 4.2.
"""

from math import exp, log, pi, sqrt
from typing import Any, NamedTuple

MAX_AXIS_RATIO = 1e4  # of a contact ellipse; a longer one would be a line contact


def effective_modulus(E: float, nu: float) -> float:
    """Return E* = E/(2 (1 - nu^2)) (Pa) of two bodies of Young's modulus ``E`` (Pa) and Poisson's ratio ``nu``."""
    return E / (2.0 * (1.0 - nu * nu))


# Line contact


def half_width(Q: float, L: float, R: float, E: float, nu: float) -> float:
    """Return the half width b (m) of a line contact of length ``L`` (m) under ``Q`` (N); both bodies: E (Pa), nu.

    b^2 = 4 Q R/(pi L E*), Johnson's equation (4.43). ``R``: reduced radius (m), R_w R_i/(R_i + R_w) on an inner
    race, R_w R_o/(R_o - R_w) on an outer, R_w on a flat.
    """
    return sqrt(8.0 * Q * R * (1.0 - nu * nu) / (pi * L * E))


def line_pressure(Q_per_m: float, R: float, E_star: float) -> float:
    """Return the largest pressure (Pa) of a line contact.

    2 Q'/(pi b) = sqrt(Q' E*/(pi R)). Q': ``Q_per_m``, load per length (N/m); ``R``: reduced radius (m), as in
    ``half_width``; ``E_star``: ``effective_modulus`` (Pa).
    """
    return sqrt(Q_per_m * E_star / (pi * R))


# Point contact


class PointContact(NamedTuple):
    """An elliptic contact, Q = k delta^(3/2), with semi-axes a Q^(1/3) and b Q^(1/3).

    k: N/m^(3/2); a >= b: m/N^(1/3).
    """

    k: float
    a: float
    b: float

    def semi_axes(self, Q: Any) -> tuple[Any, Any]:
        """Return the longer and the shorter semi-axis (m) of the ellipse under the force ``Q`` (N, or an
        array)."""
        return self.a * Q ** (1.0 / 3.0), self.b * Q ** (1.0 / 3.0)

    def pressure(self, Q: float) -> float:
        """Return the largest pressure (Pa) under the force ``Q`` (N): 3 Q/(2 pi a b)."""
        a, b = self.semi_axes(Q)
        return 1.5 * Q / (pi * a * b)


def make_ball_contact(E: float, nu: float, D_w: float, r_g: float, R: float) -> PointContact:
    """Return the contact of a ball of diameter ``D_w`` (m) on a race with groove radius ``r_g`` (m).

    E, nu: Young's modulus (Pa) and Poisson's ratio of both; ``R``: radius (m) of the race at the bottom of its
    groove, positive for an inner race (convex), negative for an outer one (concave). The long axis is transverse
    to rolling. Raises ValueError if the ball does not fit the groove, or so closely that the contact is no ellipse
    (``axis_ratio``).
    """
    rho_along, rho_across = 2.0 / D_w + 1.0 / R, 2.0 / D_w - 1.0 / r_g  # relative curvatures, 1/m
    if rho_along <= 0.0 or rho_across <= 0.0:
        raise ValueError(f"a ball of diameter {D_w} m does not fit a groove of {r_g} m on a race of {R} m")
    return make_elliptic_contact(effective_modulus(E, nu), rho_along, rho_across)


def make_elliptic_contact(E_star: float, rho_1: float, rho_2: float) -> PointContact:
    """Return the contact of two bodies with relative principal curvatures ``rho_1``, ``rho_2`` > 0 (1/m), in any
    order.

    E_star: ``effective_modulus`` (Pa). Raises ValueError if the ratio of the curvatures is too large
    (``axis_ratio``). With kappa = a/b, the complete elliptic integrals K and E of the modulus e, e^2 = 1 -
    1/kappa^2, and A + B = (rho_1 + rho_2)/2:

        k = (2 pi E*/3) kappa sqrt(E/(K^3 (A + B))),    a^3 = 3 Q kappa^2 E/(2 pi E* (A + B))

    The integrals are computed by the arithmetic-geometric mean and kappa by bisection, accurate to 1e-11. (The
    usual fits of Hamrock and Brewe are accurate to a few per cent.)

    Equation (C2) of docs/contact.md; Johnson, Contact Mechanics 1985, sections 4.1 and 4.2.
    """
    kappa = axis_ratio(max(rho_1, rho_2) / min(rho_1, rho_2))
    K, deficit = elliptic_integrals(kappa)
    E, A_plus_B = K * (1.0 - deficit), (rho_1 + rho_2) / 2.0
    k = 2.0 * pi * E_star / 3.0 * kappa * sqrt(E / (K**3 * A_plus_B))
    a = (1.5 * kappa**2 * E / (pi * E_star * A_plus_B)) ** (1.0 / 3.0)
    return PointContact(k, a, a / kappa)


def elliptic_integrals(kappa: float) -> tuple[float, float]:
    """Return K, and 1 - E/K, of the modulus e with e^2 = 1 - 1/kappa^2.

    K = pi/(2 agm(1, 1/kappa)), 1 - E/K = sum of 2^(n-1) c_n^2 (Abramowitz and Stegun, 17.6). The second is
    returned directly, because differences such as K - E would have large rounding errors.
    """
    high, low = 1.0, 1.0 / kappa
    total, weight = modulus_squared(kappa) / 2.0, 1.0
    while high - low > 1e-15:
        c = (high - low) / 2.0
        high, low = (high + low) / 2.0, sqrt(high * low)
        total += weight * c * c
        weight *= 2.0
    return pi / (2.0 * high), total


def modulus_squared(kappa: float) -> float:
    """Return e^2 = 1 - 1/kappa^2."""
    return (kappa - 1.0) * (kappa + 1.0) / (kappa * kappa)


def curvature_ratio(kappa: float) -> float:
    """Return the ratio of curvatures B/A = (kappa^2 E - K)/(K - E) for which the contact ellipse has the axis
    ratio ``kappa`` > 1."""
    _, deficit = elliptic_integrals(kappa)
    return kappa * kappa * (modulus_squared(kappa) - deficit) / deficit


def axis_ratio(ratio: float) -> float:
    """Return kappa = a/b of the contact ellipse of bodies with the ratio of curvatures B/A = ``ratio`` >= 1.

    Raises ValueError if kappa exceeds ``MAX_AXIS_RATIO``.
    """
    if ratio < 1.0 + 1e-12:
        return 1.0  # a circle, for which the ratio is 0/0
    low, high = 0.0, log(MAX_AXIS_RATIO)
    if ratio > curvature_ratio(MAX_AXIS_RATIO):
        raise ValueError(f"curvatures in the ratio {ratio:.3g} make a line, not an ellipse")
    while high - low > 1e-15 * (1.0 + high):
        midpoint = (low + high) / 2.0
        if midpoint in (low, high):
            break
        low, high = (midpoint, high) if curvature_ratio(exp(midpoint)) < ratio else (low, midpoint)
    return exp((low + high) / 2.0)
