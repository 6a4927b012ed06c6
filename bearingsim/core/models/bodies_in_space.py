"""Rings and cage of ``spatial``, the bodies that all rollers touch: positions, motion and accelerations."""

from typing import NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.geometry.motion import kinematic_time
from bearingsim.core.geometry.orientation import Body, body_at
from bearingsim.core.jit import jit
from bearingsim.core.models.outer_ring import accelerate_outer_ring
from bearingsim.core.parts.cage import accelerate_cage
from bearingsim.core.parts.cage_in_space import accelerate_cage_axis, cage_body
from bearingsim.core.parts.mounts import accelerate_mounted_ring, set_mounted_ring
from bearingsim.core.parts.shaft import accelerate_inner_ring, accelerate_ring_rotation


class Bodies(NamedTuple):
    """Position and motion of the bodies that all rollers touch.

    outer, inner, cage: position and velocity of the body; time: kinematic time (s); ramp_rate: relative
    acceleration of all speeds (1/s); theta_i, omega_i: angle (rad) and speed (rad/s) of the inner ring;
    omega_cage: speed of the cage (rad/s); spin: nominal spin of a roller (rad/s).
    """

    outer: Body
    inner: Body
    cage: Body
    time: float
    ramp_rate: float
    theta_i: float
    omega_i: float
    omega_cage: float
    spin: float


@jit
def bodies_at(model, t, y):
    """Return ``Bodies`` at time ``t`` (s)."""
    b = model.bearing
    time, rate, ramp_rate = kinematic_time(model.motion, t)
    omega_i, omega_cage = b.omega_i * rate, b.omega_c * rate + y[lay.VELOCITY + lay.PHI_C]
    return Bodies(
        outer=body_at(y, lay.X, lay.Z, lay.RING_TILT_X, lay.RING_TILT_Y, y[lay.VELOCITY + lay.PSI]),
        inner=body_at(y, lay.X_I, lay.Z_I, lay.INNER_TILT_X, lay.INNER_TILT_Y, omega_i),
        cage=cage_body(model.cage_z, omega_cage, y),
        time=time,
        ramp_rate=ramp_rate,
        theta_i=b.omega_i * time,
        omega_i=omega_i,
        omega_cage=omega_cage,
        spin=(b.omega_c - b.omega_b) * rate,
    )


@jit
def set_mounted_rings(model, y):
    """Set the rings on rigid mounts to their mounted positions."""
    set_mounted_ring(model.mount_o, y, lay.Z, lay.RING_TILT_X, lay.RING_TILT_Y)
    set_mounted_ring(model.mount_i, y, lay.Z_I, lay.INNER_TILT_X, lay.INNER_TILT_Y)


@jit
def accelerate_rings_and_cage(model, common, y):
    """Write the accelerations of rings and cage from their load cells; return the cage's angular acceleration
    (rad/s^2).

    The cells M_C and M_RING are overwritten by the torques about the axes of cage and outer ring.
    """
    b = model.bearing
    precession = accelerate_cage_axis(model.cage_z, model.cage, common.cage, y)
    y[lay.M_C] = y[lay.M_X_C] * common.cage.a_x + y[lay.M_Y_C] * common.cage.a_y + y[lay.M_C] * common.cage.a_z
    precession_torque = accelerate_mounted_ring(
        model.mount_o,
        common.outer,
        y[lay.F_Z],
        y[lay.M_X],
        y[lay.M_Y],
        y[lay.M_RING],
        y,
        lay.Z,
        lay.RING_TILT_X,
        lay.RING_TILT_Y,
    )
    y[lay.M_RING] = (
        y[lay.M_X] * common.outer.a_x
        + y[lay.M_Y] * common.outer.a_y
        + y[lay.M_RING] * common.outer.a_z
        - precession_torque
    )
    accelerate_mounted_ring(
        model.mount_i,
        common.inner,
        y[lay.F_Z_I],
        y[lay.M_X_I],
        y[lay.M_Y_I],
        y[lay.M_INNER],
        y,
        lay.Z_I,
        lay.INNER_TILT_X,
        lay.INNER_TILT_Y,
    )

    alpha_kinematic = b.omega_c * common.ramp_rate
    alpha_cage = (
        accelerate_cage(model.cage, model, common.omega_cage, common.omega_i, alpha_kinematic, y) - precession
    )
    y[lay.ACCELERATION + lay.PHI_C] = alpha_cage - alpha_kinematic
    accelerate_outer_ring(model, y)
    accelerate_ring_rotation(model.bracket, y)
    accelerate_inner_ring(model.shaft, model, common.theta_i, common.omega_i, b.omega_i * common.ramp_rate, y)
    return alpha_cage
