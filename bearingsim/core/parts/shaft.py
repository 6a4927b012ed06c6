"""Supports of the inner ring, and of the outer ring against rotation."""

from math import cos, sin
from typing import Any, NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.jit import absent, generic


@absent
class RigidShaft(NamedTuple):
    """Fixed centre of the inner ring."""


class ElasticShaft(NamedTuple):
    """Support of the inner ring by a spring and a damper, with a rotating unbalance.

    m: mass of inner ring and shaft (kg); k: N/m; c: N s/m; unbalance: mass times its distance from the axis
    (kg m), at ``angle`` (rad) from the load line at t = 0. Displacements count from the position under the load.
    """

    m: float
    k: float
    c: float
    unbalance: float
    angle: float


@generic(absent=None)
def accelerate_inner_ring(shaft: Any, model: Any, theta_i: float, omega_i: float, alpha_i: float, y: Any) -> None:
    """Write the acceleration of the inner ring from the forces in the cells F_X_I, F_Y_I.

    theta_i, omega_i, alpha_i: angle (rad), speed (rad/s) and angular acceleration (rad/s^2) of the ring.
    """


@accelerate_inner_ring.register(ElasticShaft)
def _accelerate_inner_ring_elastic(shaft, model, theta_i, omega_i, alpha_i, y):
    """Implement ``accelerate_inner_ring`` by equation (P11) of docs/planar.md."""
    support, angle = model.support, theta_i + shaft.angle
    c, s = cos(angle), sin(angle)
    f_x = y[lay.F_X_I] + support.F - shaft.k * y[lay.POSITION + lay.X_I] - shaft.c * y[lay.VELOCITY + lay.X_I]
    f_y = (
        y[lay.F_Y_I] + support.F_across - shaft.k * y[lay.POSITION + lay.Y_I] - shaft.c * y[lay.VELOCITY + lay.Y_I]
    )
    y[lay.ACCELERATION + lay.X_I] = (f_x + shaft.unbalance * (omega_i * omega_i * c + alpha_i * s)) / shaft.m
    y[lay.ACCELERATION + lay.Y_I] = (f_y + shaft.unbalance * (omega_i * omega_i * s - alpha_i * c)) / shaft.m


@absent
class FixedRing(NamedTuple):
    """Outer ring fixed against rotation."""


class TorsionSpring(NamedTuple):
    """Bracket with a torsion spring k (N m/rad) and a damper c (N m s/rad) on the outer ring.

    inertia: moment of inertia of the ring about its axis (kg m^2).
    """

    inertia: float
    k: float
    c: float


@generic(absent=None)
def accelerate_ring_rotation(bracket: Any, y: Any) -> None:
    """Write the angular acceleration of the outer ring from the torque in the cell M_RING."""


@accelerate_ring_rotation.register(TorsionSpring)
def _accelerate_ring_rotation_spring(bracket, y):
    torque = y[lay.M_RING] - bracket.k * y[lay.POSITION + lay.PSI] - bracket.c * y[lay.VELOCITY + lay.PSI]
    y[lay.ACCELERATION + lay.PSI] = torque / bracket.inertia


@generic(absent=0.0)
def mobility(support: Any) -> float:
    """Return the ring's acceleration under a unit force or torque: 1/kg, 1/(kg m^2); 0 if the support is rigid."""


@mobility.register(ElasticShaft)
def _mobility_shaft(support):
    return 1.0 / support.m


@mobility.register(TorsionSpring)
def _mobility_torsion(support):
    return 1.0 / support.inertia


@generic(absent=0.0)
def spring_per_mass(support: Any) -> float:
    """Return the stiffness over mass (1/s^2) of the spring of a shaft or a bracket."""


@generic(absent=0.0)
def damper_per_mass(support: Any) -> float:
    """Return the damping over mass (1/s) of the damper of a shaft or a bracket."""


@spring_per_mass.register(ElasticShaft)
def _spring_per_mass_shaft(support):
    return support.k / support.m


@damper_per_mass.register(ElasticShaft)
def _damper_per_mass_shaft(support):
    return support.c / support.m


@spring_per_mass.register(TorsionSpring)
def _spring_per_mass_torsion(support):
    return support.k / support.inertia


@damper_per_mass.register(TorsionSpring)
def _damper_per_mass_torsion(support):
    return support.c / support.inertia
