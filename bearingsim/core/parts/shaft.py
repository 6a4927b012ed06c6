"""What holds the inner ring, and the outer ring against rotation."""

from math import cos, sin
from typing import Any, NamedTuple

from bearingsim.core.jit import absent, generic
from bearingsim.core.layout import ACCELERATION, F_X_I, F_Y_I, M_RING, POSITION, PSI, VELOCITY, X_I, Y_I


@absent
class RigidShaft(NamedTuple):
    """The inner ring's centre stays where it is."""


class ElasticShaft(NamedTuple):
    """The inner ring on a spring and a damper, and an unbalance that turns with it.

    m: of inner ring and shaft (kg); k: N/m; c: N s/m; unbalance: mass times its distance from the axis (kg m), at
    ``angle`` (rad) from the load line at t = 0. Displacements count from where the load holds the ring.
    """

    m: float
    k: float
    c: float
    unbalance: float
    angle: float


@generic(absent=None)
def move_inner_ring(shaft: Any, model: Any, theta_i: float, omega_i: float, alpha_i: float, y: Any) -> None:
    """Write the inner ring's acceleration from the forces gathered in the cells F_X_I, F_Y_I.

    theta_i, omega_i, alpha_i: its angle (rad), speed (rad/s) and angular acceleration (rad/s^2).
    """


@move_inner_ring.register(ElasticShaft)
def _move_inner_ring_elastic(shaft, model, theta_i, omega_i, alpha_i, y):
    support, at = model.support, theta_i + shaft.angle
    c, s = cos(at), sin(at)
    f_x = y[F_X_I] + support.F - shaft.k * y[POSITION + X_I] - shaft.c * y[VELOCITY + X_I]
    f_y = y[F_Y_I] + support.F_across - shaft.k * y[POSITION + Y_I] - shaft.c * y[VELOCITY + Y_I]
    y[ACCELERATION + X_I] = (f_x + shaft.unbalance * (omega_i * omega_i * c + alpha_i * s)) / shaft.m
    y[ACCELERATION + Y_I] = (f_y + shaft.unbalance * (omega_i * omega_i * s - alpha_i * c)) / shaft.m


@absent
class FixedRing(NamedTuple):
    """The bracket does not let the outer ring rotate."""


class TorsionSpring(NamedTuple):
    """The bracket holds the outer ring by a torsion spring k (N m/rad) and damper c (N m s/rad).

    inertia: of the ring about its axis (kg m^2).
    """

    inertia: float
    k: float
    c: float


@generic(absent=None)
def rotate_ring(bracket: Any, y: Any) -> None:
    """Write the outer ring's angular acceleration from the torque gathered in the cell M_RING."""


@rotate_ring.register(TorsionSpring)
def _rotate_ring_spring(bracket, y):
    torque = y[M_RING] - bracket.k * y[POSITION + PSI] - bracket.c * y[VELOCITY + PSI]
    y[ACCELERATION + PSI] = torque / bracket.inertia


@generic(absent=0.0)
def mobility(part: Any) -> float:
    """What a force (N) or torque (N m) accelerates the ring by: 1/kg, 1/(kg m^2); 0 where it is held."""


@mobility.register(ElasticShaft)
def _mobility_shaft(part):
    return 1.0 / part.m


@mobility.register(TorsionSpring)
def _mobility_torsion(part):
    return 1.0 / part.inertia


@generic(absent=0.0)
def held_stiffness(part: Any) -> float:
    """Stiffness over mass (1/s^2) of the shaft's or the bracket's own spring."""


@generic(absent=0.0)
def held_damping(part: Any) -> float:
    """Damping over mass (1/s) of its damper."""


@held_stiffness.register(ElasticShaft)
def _held_stiffness_shaft(part):
    return part.k / part.m


@held_damping.register(ElasticShaft)
def _held_damping_shaft(part):
    return part.c / part.m


@held_stiffness.register(TorsionSpring)
def _held_stiffness_torsion(part):
    return part.k / part.inertia


@held_damping.register(TorsionSpring)
def _held_damping_torsion(part):
    return part.c / part.inertia
