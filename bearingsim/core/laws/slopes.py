"""Exact derivatives of the contact force, for methods that solve with them: what implicit steps are built on.

    K = dQ/d(delta),   C = dQ/dv   of   Q = max(0, k delta^m1 + damping(delta, v)),   delta > 0

Where the force is clamped, or nothing touches, both are 0: at a kink one of its two sides is taken, as Newton's
method for semismooth equations may (Qi and Sun, Mathematical Programming 58 (1993) 353). K can be negative: a
dashpot that holds a contact back does so more the deeper it is. (``stiffness_slope`` and ``damping_slope`` of
``laws/damping.py`` are bounds, for the watch over the step.)
"""

from typing import Any

from bearingsim.core.jit import generic
from bearingsim.core.laws.damping import General, HuntCrossley, Kraemer, raised, raised_slope
from bearingsim.core.laws.johnson import reduced_curvature
from bearingsim.core.laws.stiffness import Johnson, Linear, PowerLaw, TenNinths, ThreeHalves, elastic, tangent

SHALLOWEST = 1e-12  # m: approach below which a slope that is infinite at touch-down is taken there
SLOWEST = 1e-12  # m/s: the same of a damping force that is infinitely steep at rest


@generic
def curvature(law: Any, delta: float) -> float:
    """Slope of the tangent stiffness, d2Q/d(delta)2 (N/m^2), at approach ``delta`` >= 0 (m)."""


@curvature.register(TenNinths)
def _curvature_ten_ninths(law, delta):
    return tangent(law, delta) / (9.0 * max(delta, SHALLOWEST))


@curvature.register(ThreeHalves)
def _curvature_three_halves(law, delta):
    return tangent(law, delta) / (2.0 * max(delta, SHALLOWEST))


@curvature.register(Linear)
def _curvature_linear(law, delta):
    return 0.0


@curvature.register(PowerLaw)
def _curvature_power_law(law, delta):
    return (law.m - 1.0) * tangent(law, delta) / max(delta, SHALLOWEST)


@curvature.register(Johnson)
def _curvature_johnson(law, delta):
    per_length = 1.0 / law.length
    return law.force * per_length * per_length * reduced_curvature(delta * per_length)


@generic
def slopes(contact: Any, delta: float, v: float) -> tuple[float, float]:
    """K (N/m) and C (N s/m) of ``normal_force`` at approach ``delta`` (m, any sign) and rate ``v`` (m/s)."""


@slopes.register(HuntCrossley)
def _slopes_hunt_crossley(contact, delta, v):
    d, growth = max(delta, 0.0), 1.0 + contact.chi * v
    pressing = 1.0 if delta > 0.0 else 0.0
    pressing = pressing if growth > 0.0 else 0.0
    return pressing * tangent(contact.stiffness, d) * growth, pressing * elastic(
        contact.stiffness, d
    ) * contact.chi


@slopes.register(Kraemer)
def _slopes_kraemer(contact, delta, v):
    d, rate = max(delta, 0.0), contact.beta * v
    stiffness = tangent(contact.stiffness, d)
    pressing = 1.0 if delta > 0.0 else 0.0
    pressing = pressing if elastic(contact.stiffness, d) + stiffness * rate > 0.0 else 0.0
    return pressing * (stiffness + curvature(contact.stiffness, d) * rate), pressing * stiffness * contact.beta


@slopes.register(General)
def _slopes_general(contact, delta, v):
    """At 0, |v|^(m2-1) and delta^(m3-1) are infinite if the exponent is below 1: SLOWEST, SHALLOWEST stand in."""
    d, speed = max(delta, 0.0), abs(v)
    deep = raised(contact.m3, d)
    drag = contact.c * raised(contact.m2, speed)
    drag = drag if v > 0.0 else -drag
    pressing = 1.0 if delta > 0.0 else 0.0
    pressing = pressing if elastic(contact.stiffness, d) + drag * deep > 0.0 else 0.0
    K = tangent(contact.stiffness, d) + drag * raised_slope(contact.m3, max(d, SHALLOWEST))
    C = contact.c * raised_slope(contact.m2, max(speed, SLOWEST)) * deep
    return pressing * K, pressing * C
