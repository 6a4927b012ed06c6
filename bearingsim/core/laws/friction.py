"""The friction coefficient of one contact as a function of its slip.

A law gives mu(v, u), odd in the slip speed v (m/s) of one surface over the other: the friction force on the
first is -mu(v, u) Q. u > 0 (m/s) is the mean of the speeds at which the two surfaces pass through the contact.
Every law has a finite slope at v = 0 and so no sticking: under a steady force less than mu Q a contact creeps.

``mu`` keeps the vector lanes of a loop over rollers.
"""

from typing import Any, NamedTuple

import numpy as np

from bearingsim.core.jit import generic, jit

SLOWEST_ROLLING = 0.01  # m/s: below it, traction is what it is there; a film needs rolling
JUMP_WITHIN = 1e-3  # slide-to-roll ratio over which a traction curve that jumps at zero slip is made to rise
DECAYED = 40.0  # e^-40 is less than rounding


class Frictionless(NamedTuple):
    """mu = 0."""


class StaticDynamic(NamedTuple):
    """Dry friction of the multibody codes: up to mu_s at the slip v_s, down to mu_d at v_d, then level.

    Cubic steps, from -mu_s at -v_s to mu_s at v_s and from there to mu_d; 0 < v_s < v_d (m/s); whatever ``u``.
    Sources: the contact friction of Adams (STEP) and RecurDyn; written out by Wingertszahn et al., Lubricants 11
    (2023) 369, eqs 21-27. v_s and v_d are numerical, not material: no surface slips at v_s under a static force.
    """

    mu_s: float
    mu_d: float
    v_s: float
    v_d: float


class Traction(NamedTuple):
    """Lubricated traction, mu = (a + b s) e^(-c s) + d with the slide-to-roll ratio s = |v|/u; b, c > 0, a <= 0.

    ``KRAGELSKII`` holds the constants that papers on bearing dynamics take from Kragelskii, Dobychin and Kombalov,
    Friction and Wear: Calculation Methods, Pergamon 1982. They have not been compared with the book. With them mu
    rises with the slope 40.4/u, peaks with 0.120 at s = 0.0100 and sinks to 0.1. Neither load nor temperature nor
    viscosity enters.

    The curve starts from a + d, which is 0 in a fluid; otherwise it would jump there, and a cubic step over
    ``JUMP_WITHIN`` takes the jump's place.
    """

    a: float
    b: float
    c: float
    d: float


KRAGELSKII = Traction(-0.1, 22.28, 181.46, 0.1)


@generic
def mu(law: Any, v: float, u: float) -> float:
    """Friction coefficient, of the sign of the slip speed ``v`` (m/s), at the rolling speed ``u`` > 0 (m/s)."""


@generic
def steepest(law: Any, u: float) -> float:
    """Largest d(mu)/dv (s/m) at the rolling speed ``u`` (m/s): what limits an explicit step."""


@generic
def mu_slope(law: Any, v: float, u: float) -> tuple[float, float]:
    """Exact d(mu)/dv and d(mu)/du (s/m) at the slip speed ``v`` and the rolling speed ``u`` > 0 (m/s)."""


@jit
def taken(t):
    """Part of a lag that is taken where slip would die out ``t`` times within it, t/(1 + t).

    Friction that is slow beside the lag hardly needs it: so its error is of second order in the lag, t^2. Slip
    still dies out no faster than within the lag: at the rate t (1 + t)/(1 + t + t^2) of it.
    """
    return t / (1.0 + t)


@jit
def lagged(rate, lag):
    """Rate (1/s) at which slip dies out with the lag (s), ``rate`` being that without."""
    t = lag * rate
    return rate / (1.0 + taken(t) * t)


@jit
def rub(k_o, k_i, s_o, s_i, a, b):
    """Friction (N) at a roller's two contacts: that of the slips as they will be a lag later.

    k_o, k_i: friction over slip at either contact (N s/m); s_o, s_i: slip (m/s). A force F_o changes the slips at
    the rates -(1/m + R_w^2/I) F_o and -(1/m - R_w^2/I) F_o, crosswise F_i; a, b: these factors times the lag
    (s/kg), of which a part is ``taken``. The new slips follow from forces k s with the new s, in closed form. So
    slip never dies out faster than within the lag, however steep the friction's curve, and an explicit step as
    long as the lag is stable; without lag the force is k s.
    """
    part = taken(a * (k_o + k_i))
    a, b = part * a, part * b
    determinant = (1.0 + a * k_o) * (1.0 + a * k_i) - b * b * k_o * k_i
    f_o = k_o * ((1.0 + a * k_i) * s_o - b * k_i * s_i) / determinant
    f_i = k_i * ((1.0 + a * k_o) * s_i - b * k_o * s_o) / determinant
    return f_o, f_i


@jit
def rise(x):
    """-1 up to x = -1, 1 from x = 1, the odd cubic between: continuous with its slope, which is 1.5 at x = 0."""
    x = min(max(x, -1.0), 1.0)
    return x * (1.5 - 0.5 * x * x)


@jit
def rise_slope(x):
    """Slope of ``rise``."""
    x = min(max(x, -1.0), 1.0)
    return 1.5 - 1.5 * x * x


@jit
def exp_minus(x):
    """e^-x for 0 <= x <= 40 without a call, relative error below 2e-14.

    e^-x = 2^n e^r, n the whole number nearest to -x/ln 2, |r| <= ln(2)/2. Adding 1.5 * 2^52 rounds to whole
    numbers and leaves n in the lowest bits, from where it is shifted into the exponent; e^r is its series.
    """
    shifted = x * -1.4426950408889634 + 6755399441055744.0
    n = shifted - 6755399441055744.0
    r = -x - n * 0.6931471805599453
    power = np.int64((np.float64(shifted).view(np.int64) << 52) + 4607182418800017408).view(np.float64)
    series = 1.0 + r / 11.0
    for k in range(10):
        series = 1.0 + series * r * (1.0 / (10.0 - k))
    return power * series


@mu.register(Frictionless)
def _mu_frictionless(law, v, u):
    return 0.0


@steepest.register(Frictionless)
def _steepest_frictionless(law, u):
    return 0.0


@mu_slope.register(Frictionless)
def _mu_slope_frictionless(law, v, u):
    return 0.0, 0.0


@mu.register(StaticDynamic)
def _mu_static_dynamic(law, v, u):
    beyond = (abs(v) - law.v_s) * (1.0 / (law.v_d - law.v_s))
    fall = 0.5 * (law.mu_s - law.mu_d) * (1.0 + rise(2.0 * beyond - 1.0))
    return law.mu_s * rise(v * (1.0 / law.v_s)) - (fall if v > 0.0 else -fall)


@steepest.register(StaticDynamic)
def _steepest_static_dynamic(law, u):
    return 1.5 * law.mu_s / law.v_s


@mu_slope.register(StaticDynamic)
def _mu_slope_static_dynamic(law, v, u):
    per_fall, per_rise = 1.0 / (law.v_d - law.v_s), 1.0 / law.v_s
    fall = (law.mu_s - law.mu_d) * per_fall * rise_slope(2.0 * (abs(v) - law.v_s) * per_fall - 1.0)
    return law.mu_s * per_rise * rise_slope(v * per_rise) - fall, 0.0


@mu.register(Traction)
def _mu_traction(law, v, u):
    s = abs(v) / max(u, SLOWEST_ROLLING)
    flowing = min(s, DECAYED / law.c)  # beyond it only d is left
    level = (law.a + law.b * flowing) * exp_minus(law.c * flowing) + law.d
    level -= (law.a + law.d) * (1.0 - rise(s * (1.0 / JUMP_WITHIN)))
    return level if v > 0.0 else -level


@steepest.register(Traction)
def _steepest_traction(law, u):
    slope = law.b - law.c * law.a + 1.5 * (law.a + law.d) / JUMP_WITHIN
    return slope / max(u, SLOWEST_ROLLING)


@mu_slope.register(Traction)
def _mu_slope_traction(law, v, u):
    rolling = max(u, SLOWEST_ROLLING)
    s = abs(v) / rolling
    flowing = min(s, DECAYED / law.c)
    slope = (law.b - law.c * (law.a + law.b * flowing)) * exp_minus(law.c * flowing)
    slope = slope if s < DECAYED / law.c else 0.0
    slope += (law.a + law.d) * (1.0 / JUMP_WITHIN) * rise_slope(s * (1.0 / JUMP_WITHIN))
    by_slip = slope / rolling
    by_rolling = by_slip * v / rolling
    return by_slip, (-by_rolling if u > SLOWEST_ROLLING else 0.0)
