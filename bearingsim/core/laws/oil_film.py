"""Oil between a rolling element and a race: film thickness and damping of a line contact. Plain Python and numpy.

Assumptions: smooth surfaces, flooded and isothermal contact, Newtonian oil, pure rolling, small oscillations about
equilibrium. Loads, stiffnesses and frequencies are floats or arrays in SI units.

Derivation, accuracy and limits: docs/evidence/oil_film.md. Sources:

- H. Moes, Lubrication and Beyond, lecture notes, University of Twente 2000, and C. H. Venner, Multilevel Solution
  of the EHL Line and Point Contact Problems, thesis, Twente 1991: film thickness.
- H. M. Martin, Engineering (London) 102, 1916: rigid cylinders.
- The damping is derived here, with coefficients fitted to the solutions of tests/independent/ehl.py.
"""

from typing import Any, NamedTuple

import numpy as np

Number = Any  # a float or an array

# Speed


def entrainment_speed(omega_inner: float, D_m: float, D_w: float, omega_outer: float = 0.0) -> float:
    """Return the entrainment speed u (m/s) of both contacts of an element that rolls without slip.

    ``omega_inner``, ``omega_outer``: angular speeds of the rings (rad/s). ``D_m``: pitch diameter, ``D_w``:
    diameter of the element (m). With g = D_w/D_m the cage rotates at (omega_i (1 - g) + omega_o (1 + g))/2.
    Relative to it the inner race of radius D_m (1 - g)/2, the outer race of radius D_m (1 + g)/2 and the element's
    surface have the same speed:

        u = |omega_i - omega_o| (D_m^2 - D_w^2)/(4 D_m)

    With a contact angle use D_w cos(angle) as D_w.
    """
    return abs(omega_inner - omega_outer) * (D_m**2 - D_w**2) / (4.0 * D_m)


# Film thickness

MARTIN = 4.896  # rigid cylinders, constant viscosity: minimum gap h = 4.896 eta u R/(Q/L)


class LubricatedLine(NamedTuple):
    """A lubricated line contact.

    ``L``: length (m). ``R``: reduced radius (m), see ``hertz.half_width``. ``E_star``: E/(2 (1 - nu^2)) of two
    equal bodies (Pa); E' of Moes and Dowson is twice that. ``eta``: viscosity (Pa s) of the oil at the inlet,
    ``alpha``: d(ln eta)/dp at p = 0 (1/Pa). ``u``: mean speed (not the sum) of both surfaces relative to the
    contact (m/s).
    """

    L: float
    R: float
    E_star: float
    eta: float
    alpha: float
    u: float


class Thickness(NamedTuple):
    """Film thickness (m): ``central``, the flow over u and length, and ``minimum``, the narrowest gap."""

    central: Number
    minimum: Number


def moes_numbers(Q: Number, line: LubricatedLine) -> tuple[Number, float]:
    """Return Moes' load parameter M = W U^(-1/2) and lubricant parameter L = alpha E' U^(1/4).

    W = (Q/L)/(E' R), here with the length L of the contact, U = eta (2 u)/(E' R) and E' = 2 E*.
    """
    E_prime = 2.0 * line.E_star
    U = line.eta * 2.0 * line.u / (E_prime * line.R)
    return Q / (line.L * E_prime * line.R * U**0.5), line.alpha * E_prime * U**0.25


def film_thickness(Q: Number, line: LubricatedLine) -> Thickness:
    """Return Moes' film thickness under the load ``Q`` > 0 (N), a blend of four asymptotes in units of R U^(1/2):

        rigid, isoviscous       central 3.0 / M            minimum 2.45 / M
        elastic, isoviscous             2.621 M^(-1/5)             2.05 M^(-1/5)
        rigid, piezoviscous             1.287 L^(2/3)              1.05 L^(2/3)
        elastic, piezoviscous           1.311 M^(-1/8) L^(3/4)     0.96 M^(-1/8) L^(3/4)

    The central film thickness is h for a flow of u h per length; for rigid cylinders it is 1.226 times the
    narrowest gap. Both are within 7 % of the solutions of tests/independent/ehl.py (M 0.1 to 120, L 7 to 26).
    """
    M, L = moes_numbers(Q, line)
    scale = line.R * (line.eta * line.u / (line.E_star * line.R)) ** 0.5
    central = _regime_blend(3.0 / M, 2.621 * M**-0.2, 1.287 * L ** (2 / 3), 1.311 * M**-0.125 * L**0.75)
    minimum = _regime_blend(2.45 / M, 2.05 * M**-0.2, 1.05 * L ** (2 / 3), 0.96 * M**-0.125 * L**0.75)
    return Thickness(scale * central, scale * minimum)


def _regime_blend(
    rigid: Number, elastic: Number, rigid_piezoviscous: Number, elastic_piezoviscous: Number
) -> Number:
    """Return Moes' blend of the asymptotes of the four regimes."""
    s = (7.0 + 8.0 * np.exp(-2.0 * elastic / rigid)) / 5.0
    isoviscous = (rigid ** (7 / 3) + elastic ** (7 / 3)) ** (3 / 7)
    piezoviscous = (rigid_piezoviscous**-3.5 + elastic_piezoviscous**-3.5) ** (-2 / 7)
    return (isoviscous**s + piezoviscous**s) ** (1 / s)


# Damping

TIME_CONSTANT = 0.946  # damping over stiffness of a film between rigid cylinders, over sqrt(2 R h)/u; exact
L_OFFSET, Z_SCALE, Z_EXPONENT = 20.0, 21.3, 3.4  # fits, see ``transition_parameter``
FLATTENING_Z, FLATTENING_EXPONENT = 2.25, 4.0  # fits, see ``entrainment_damping``
ROLL_OFF_FACTOR, ROLL_OFF_PHASE, ROLL_OFF_EXPONENT = 0.79, 1.4, 1.3  # fits: ``squeeze_damping``, ``roll_off``
MIN_LOAD = 1e-6  # N, load below which the damping is zero


def film_damping(Q: Number, k: Number, line: LubricatedLine, omega: Number = 0.0, exponent: float = 0.5) -> Number:
    """Return the damping c (N s/m) that the film adds to the elastic law of a contact.

    The force is Q + k x + c dx/dt for a small change x of the approach.

    ``Q``: load (N); ``k``: tangent stiffness dQ/d(delta) (N/m) of the elastic law at this load; ``omega``: angular
    frequency of the oscillation (rad/s), 0 for a slow one. ``exponent``: of the half width, b ~ Q^exponent, 1/2
    for lines, 1/3 for balls (``equivalent_line_contact``). The result is smooth in Q and tends to zero as Q^(3/2).

    It is the sum of ``squeeze_damping`` and ``entrainment_damping``. For slow oscillations it is within a factor
    1.25 of 9 in 10 solutions. The others have z from 1 to 1.8 (``transition_parameter``), where the film has
    little damping, and the result is 0.7 to 11 times the solution. At the natural frequency of the element on its
    contacts it is accurate only to an order of magnitude.
    """
    load = np.maximum(Q, MIN_LOAD)
    c = squeeze_damping(load, k, line, omega) + entrainment_damping(load, k, line, omega, exponent)
    return np.where(np.asarray(Q) > MIN_LOAD, c, 0.0)[()]


def inlet_squeeze(h: Number, line: LubricatedLine) -> Number:
    """Return the damping (N s/m) of the film between *rigid* cylinders at the narrowest gap ``h`` (m), constant
    viscosity.

        6.551 eta L (R/h)^(3/2)

    From Reynolds' equation, with the outlet at x = 0.4751 sqrt(2 R h) as in steady state. For comparison, the
    half-Sommerfeld condition gives 6.664, half of the 3 sqrt(2) pi of a full film.
    """
    return TIME_CONSTANT * MARTIN * 2.0**0.5 * line.eta * line.L * (line.R / h) ** 1.5


def transition_parameter(Q: Number, line: LubricatedLine) -> Number:
    """Return z = M (L + 20)/21.3: below 1 the film deflects as between rigid cylinders, above 2 the contact is
    flat."""
    M, L = moes_numbers(Q, line)
    return M * (L + L_OFFSET) / Z_SCALE


def film_compliance(Q: Number, line: LubricatedLine) -> Number:
    """Return -dh/dQ (m/N) of the film for slow changes of load: h/Q of rigid cylinders times exp(-z^3.4).

    h = 4.896 eta u R L/Q; z: ``transition_parameter``. Where the viscosity increases with pressure, h is nearly
    independent of the load, so the film is stiff.
    """
    h = MARTIN * line.eta * line.u * line.R * line.L / Q
    return h / Q * np.exp(-(transition_parameter(Q, line) ** Z_EXPONENT))


def squeeze_damping(Q: Number, k: Number, line: LubricatedLine, omega: Number = 0.0) -> Number:
    """Return the damping (N s/m) due to squeezing of the oil at the inlet, with the contact's stiffness in series.

    The film is a spring k_f and a damper tau k_f in parallel, with the time constant tau = 0.946 sqrt(2 R h)/u. In
    series with k (N/m) their damping is k tau s (1 - s), s = k_f/(k + k_f), with a roll-off of 1/(1 + (0.79 omega
    tau s)^2). For a film much softer than the contact this is ``inlet_squeeze``.
    """
    ratio = k * film_compliance(Q, line)  # k/k_f
    tau = TIME_CONSTANT * np.sqrt(2.0 * line.R * film_thickness(Q, line).minimum) / line.u
    s = 1.0 / (1.0 + ratio)
    return k * tau * ratio * s**2 / (1.0 + (ROLL_OFF_FACTOR * omega * tau * s) ** 2)


def entrainment_damping(
    Q: Number, k: Number, line: LubricatedLine, omega: Number = 0.0, exponent: float = 0.5
) -> Number:
    """Return the damping (N s/m) due to the thicker film that a growing contact entrains.

    An inlet edge moving outwards at db/dt entrains a film thicker by n (h/u) db/dt, n = d(ln h)/d(ln u), so that

        c = n (h/u) k db/d(delta),    db/d(delta) = exponent b k/Q

    n = 1.1/(1 + L/30) and its factor z^4/(2.25^4 + z^4), which tends to zero without a flat contact, are fits. The
    result is multiplied by ``roll_off``.
    """
    z = transition_parameter(Q, line)
    _, L = moes_numbers(Q, line)
    n = 1.1 / (1.0 + L / 30.0) / (1.0 + (FLATTENING_Z / z) ** FLATTENING_EXPONENT)
    b = half_widths(Q, line)
    c = n * film_thickness(Q, line).central / line.u * k * exponent * b * k / Q
    return c * roll_off(omega * 2.0 * b / line.u)


def half_widths(Q: Number, line: LubricatedLine) -> Number:
    """Return the half width b (m) of the dry contact, as ``hertz.half_width``, for arrays of loads."""
    return np.sqrt(4.0 * Q * line.R / (np.pi * line.L * line.E_star))


def roll_off(omega_T: Number) -> Number:
    """Return the share (1) of ``entrainment_damping`` that remains at ``omega_T``.

    omega_T: angular frequency times T = 2 b/u, the transit time of the oil. The share is 1/(1 + (omega
    T/1.4)^1.3). For omega T above 3 the solutions oscillate about zero like sin(x)/x and fall as 1/x, so the
    result is accurate only to an order of magnitude.
    """
    return 1.0 / (1.0 + (omega_T / ROLL_OFF_PHASE) ** ROLL_OFF_EXPONENT)


def hysteresis_damping(k: Number, omega: Number, loss_factor: float) -> Number:
    """Return the damping (N s/m) due to hysteresis of the bodies.

    c = loss_factor k/omega. The energy loss per cycle of amplitude X is pi loss_factor k X^2 at any frequency.
    """
    return loss_factor * k / omega


def equivalent_line_contact(a: Number, b: Number, pressure: Number, E_star: float) -> tuple[Number, Number]:
    """Return length L (m) and reduced radius R (m) of a line contact equivalent to an elliptic one.

    Both have the same half width ``b``, largest pressure and load. Semi-axes ``a`` > ``b`` in m, a transverse to
    rolling; ``pressure``: largest pressure p (Pa). From Q = 2 pi a b p/3 = pi b p L/2 follows L = 4 a/3, from b =
    2 p R/E* R. Side flow and the decrease of pressure and film towards the ends of the ellipse are neglected, so
    the accuracy is only a factor 2.
    """
    return 4.0 * a / 3.0, b * E_star / (2.0 * pressure)
