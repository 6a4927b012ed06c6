"""Dry friction of the multibody codes."""

from typing import NamedTuple

from bearingsim.core.laws.friction.cubic_step import rise, rise_slope
from bearingsim.core.laws.friction.interface import mu, mu_slope, steepest


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


@mu.register(StaticDynamic)
def _mu(law, v, u):
    beyond = (abs(v) - law.v_s) * (1.0 / (law.v_d - law.v_s))
    fall = 0.5 * (law.mu_s - law.mu_d) * (1.0 + rise(2.0 * beyond - 1.0))
    return law.mu_s * rise(v * (1.0 / law.v_s)) - (fall if v > 0.0 else -fall)


@mu_slope.register(StaticDynamic)
def _mu_slope(law, v, u):
    per_fall, per_rise = 1.0 / (law.v_d - law.v_s), 1.0 / law.v_s
    fall = (law.mu_s - law.mu_d) * per_fall * rise_slope(2.0 * (abs(v) - law.v_s) * per_fall - 1.0)
    return law.mu_s * per_rise * rise_slope(v * per_rise) - fall, 0.0


@steepest.register(StaticDynamic)
def _steepest(law, u):
    return 1.5 * law.mu_s / law.v_s
