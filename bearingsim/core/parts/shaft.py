"""Supports of the inner ring, and of the outer ring against rotation."""

from math import cos, sin
from typing import Any, NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.jit import absent, generic


@absent
class RigidShaft(NamedTuple):
    """Rigid support of the inner ring, whose centre is fixed."""


class ElasticShaft(NamedTuple):
    """Support of the inner ring by a spring and a damper, with a rotating unbalance.

    m: mass of inner ring and shaft (kg); k: stiffness (N/m); c: damping (N s/m); unbalance: mass times
    eccentricity (kg m), at ``angle`` (rad) from the load direction e_0 towards e_90 at t = 0. Displacements are
    relative to the static equilibrium position under the load.
    """

    m: float
    k: float
    c: float
    unbalance: float
    angle: float


@generic(absent=None)
def accelerate_inner_ring(shaft: Any, model: Any, theta_i: float, omega_i: float, alpha_i: float, y: Any) -> None:
    """Write the acceleration of the inner ring from the forces in the cells F_X_I, F_Y_I.

    model: its ``support`` contains the load; theta_i, omega_i, alpha_i: angle (rad), speed (rad/s) and angular
    acceleration (rad/s^2) of the ring, positive from e_0 to e_90; y: buffer (``core/layout.py``), updated in
    place.
    """


@accelerate_inner_ring.register(ElasticShaft)
def _accelerate_inner_ring_elastic(shaft, model, theta_i, omega_i, alpha_i, y):
    """Implement ``accelerate_inner_ring`` by equation (P11) of docs/planar.md."""
    load, angle = model.support, theta_i + shaft.angle
    c, s = cos(angle), sin(angle)
    f_x = y[lay.F_X_I] + load.F - shaft.k * y[lay.POSITION + lay.X_I] - shaft.c * y[lay.VELOCITY + lay.X_I]
    f_y = y[lay.F_Y_I] + load.F_across - shaft.k * y[lay.POSITION + lay.Y_I] - shaft.c * y[lay.VELOCITY + lay.Y_I]
    y[lay.ACCELERATION + lay.X_I] = (f_x + shaft.unbalance * (omega_i * omega_i * c + alpha_i * s)) / shaft.m
    y[lay.ACCELERATION + lay.Y_I] = (f_y + shaft.unbalance * (omega_i * omega_i * s - alpha_i * c)) / shaft.m


@absent
class FixedRing(NamedTuple):
    """Outer ring fixed against rotation."""


class TorsionSpring(NamedTuple):
    """Torsion spring k (N m/rad) and damper c (N m s/rad) between the outer ring and a fixed bracket.

    inertia: moment of inertia of the ring about its axis (kg m^2). The spring is unloaded at the angle 0.
    """

    inertia: float
    k: float
    c: float


@generic(absent=None)
def accelerate_ring_rotation(bracket: Any, y: Any) -> None:
    """Write the angular acceleration (rad/s^2) of the outer ring from the torque (N m) in the cell M_RING.

    bracket: ``FixedRing`` (nothing is written) or ``TorsionSpring``; y: buffer (``core/layout.py``). The equation
    is I psi'' = M - k psi - c psi' (docs/planar.md, "Shaft, speed, gravity").
    """


@accelerate_ring_rotation.register(TorsionSpring)
def _accelerate_ring_rotation_spring(bracket, y):
    torque = y[lay.M_RING] - bracket.k * y[lay.POSITION + lay.PSI] - bracket.c * y[lay.VELOCITY + lay.PSI]
    y[lay.ACCELERATION + lay.PSI] = torque / bracket.inertia


@generic(absent=0.0)
def accelerance(support: Any) -> float:
    """Return the accelerance of a supported ring: 1/mass (1/kg) or 1/(moment of inertia) (1/(kg m^2)).

    support: of the inner ring (``RigidShaft``, ``ElasticShaft``) or of the outer ring's rotation (``FixedRing``,
    ``TorsionSpring``); the result is 0 if it is rigid.
    """


@accelerance.register(ElasticShaft)
def _accelerance_shaft(support):
    return 1.0 / support.m


@accelerance.register(TorsionSpring)
def _accelerance_torsion(support):
    return 1.0 / support.inertia


@generic(absent=0.0)
def spring_per_mass(support: Any) -> float:
    """Return the stiffness over the ring's mass, for a bracket over its moment of inertia (1/s^2); 0 if rigid.

    support: as in ``accelerance``.
    """


@generic(absent=0.0)
def damper_per_mass(support: Any) -> float:
    """Return the damping over the ring's mass, for a bracket over its moment of inertia (1/s); 0 if rigid.

    support: as in ``accelerance``.
    """


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
