"""Friction laws: no friction, dry friction of multibody codes, traction of an oil film."""

from typing import NamedTuple

import numpy as np

from bearingsim.core.jit import absent, jit
from bearingsim.core.laws.friction.interface import mu, mu_derivative, mu_derivative_bound


@absent
class Frictionless(NamedTuple):
    """No friction, mu = 0."""


@jit
def cubic_step(x):
    """Return a smooth step: -1 for x <= -1, 1 for x >= 1, and between an odd cubic with the slope 1.5 at x = 0.

    Its derivative is continuous.
    """
    x = min(max(x, -1.0), 1.0)
    return x * (1.5 - 0.5 * x * x)


@jit
def cubic_step_derivative(x):
    """Return the derivative of ``cubic_step``."""
    x = min(max(x, -1.0), 1.0)
    return 1.5 - 1.5 * x * x


class StaticDynamic(NamedTuple):
    """Dry friction of multibody codes: mu rises to mu_s at slip v_s and falls to mu_d at v_d, then is constant.

    Cubic steps from -mu_s at -v_s to mu_s at v_s and from there to mu_d, with 0 < v_s < v_d (m/s), independent of
    ``u``. v_s and v_d are numerical parameters, not material properties: below mu_s Q real surfaces do not slip,
    whereas here they creep at up to v_s. Sources: the contact friction of Adams (STEP) and RecurDyn; equations
    21-27 of Wingertszahn et al., Lubricants 11 (2023) 369.
    """

    mu_s: float
    mu_d: float
    v_s: float
    v_d: float


@mu.register(StaticDynamic)
def _mu_static_dynamic(law, v, u):
    fraction = (abs(v) - law.v_s) * (1.0 / (law.v_d - law.v_s))  # of the way from v_s to v_d
    drop = 0.5 * (law.mu_s - law.mu_d) * (1.0 + cubic_step(2.0 * fraction - 1.0))
    return law.mu_s * cubic_step(v * (1.0 / law.v_s)) - (drop if v > 0.0 else -drop)


@mu_derivative.register(StaticDynamic)
def _mu_derivative_static_dynamic(law, v, u):
    per_v_drop, per_v_s = 1.0 / (law.v_d - law.v_s), 1.0 / law.v_s
    drop = (law.mu_s - law.mu_d) * per_v_drop * cubic_step_derivative(2.0 * (abs(v) - law.v_s) * per_v_drop - 1.0)
    return law.mu_s * per_v_s * cubic_step_derivative(v * per_v_s) - drop, 0.0


@mu_derivative_bound.register(StaticDynamic)
def _mu_derivative_bound_static_dynamic(law, u):
    return 1.5 * law.mu_s / law.v_s


MIN_ROLLING_SPEED = 0.01  # m/s: lower bound of u in the traction curve; a film requires rolling
JUMP_WIDTH = 1e-3  # slide-to-roll ratio over which a jump of a traction curve at zero slip is smoothed
MAX_EXPONENT = 40.0  # e^-40 is below rounding errors of 1


class Traction(NamedTuple):
    """Lubricated traction, mu = (a + b s) e^(-c s) + d with the slide-to-roll ratio s = |v|/u; b, c > 0, a <= 0.

    ``KRAGELSKII`` contains the constants that papers on bearing dynamics cite from Kragelskii, Dobychin and
    Kombalov, Friction and Wear: Calculation Methods, Pergamon 1982. They have not been compared with the book.
    With them mu rises with the slope 40.4/u (s/m), has a maximum of 0.120 at s = 0.0100 and falls to 0.1. The law
    is independent of load, temperature and viscosity.

    The curve starts from a + d, which is 0 for a fluid; otherwise a cubic step over ``JUMP_WIDTH`` smooths the
    jump at zero slip.
    """

    a: float
    b: float
    c: float
    d: float


KRAGELSKII = Traction(-0.1, 22.28, 181.46, 0.1)


@mu.register(Traction)
def _mu_traction(law, v, u):
    s = abs(v) / max(u, MIN_ROLLING_SPEED)
    s_limited = min(s, MAX_EXPONENT / law.c)  # mu = d for larger s
    coefficient = (law.a + law.b * s_limited) * exp_minus(law.c * s_limited) + law.d
    coefficient -= (law.a + law.d) * (1.0 - cubic_step(s * (1.0 / JUMP_WIDTH)))
    return coefficient if v > 0.0 else -coefficient


@mu_derivative.register(Traction)
def _mu_derivative_traction(law, v, u):
    rolling = max(u, MIN_ROLLING_SPEED)
    s = abs(v) / rolling
    s_limited = min(s, MAX_EXPONENT / law.c)
    derivative = (law.b - law.c * (law.a + law.b * s_limited)) * exp_minus(law.c * s_limited)
    derivative = derivative if s < MAX_EXPONENT / law.c else 0.0
    derivative += (law.a + law.d) * (1.0 / JUMP_WIDTH) * cubic_step_derivative(s * (1.0 / JUMP_WIDTH))
    mu_v = derivative / rolling
    mu_u = mu_v * v / rolling
    return mu_v, (-mu_u if u > MIN_ROLLING_SPEED else 0.0)


@mu_derivative_bound.register(Traction)
def _mu_derivative_bound_traction(law, u):
    derivative = law.b - law.c * law.a + 1.5 * (law.a + law.d) / JUMP_WIDTH
    return derivative / max(u, MIN_ROLLING_SPEED)


@jit
def exp_minus(x):
    """Return e^-x for 0 <= x <= 40 without a library call, with a relative error below 2e-14.

    e^-x = 2^n e^r, n the integer nearest to -x/ln 2, |r| <= ln(2)/2. Adding 1.5 * 2^52 rounds to an integer and
    leaves n in the lowest bits, which are shifted into the exponent; e^r is computed by its series.
    """
    shifted = x * -1.4426950408889634 + 6755399441055744.0
    n = shifted - 6755399441055744.0
    r = -x - n * 0.6931471805599453
    power = np.int64((np.float64(shifted).view(np.int64) << 52) + 4607182418800017408).view(np.float64)
    series = 1.0 + r / 11.0
    for k in range(10):
        series = 1.0 + series * r * (1.0 / (10.0 - k))
    return power * series
