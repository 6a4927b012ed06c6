"""Cage: motion, guidance, pocket contacts, and the drag on cage and rollers.

The position of a roller in its pocket, relative to the cage's centre c_c along the pocket's directions e_r,
e_theta, is

    e = (c_j - c_c).e_theta,   rho = (c_j - c_c).e_r,   N = pocket(|e| - c_p/2, d|e|/dt)

The walls are flat and radial, so N acts along e_theta and friction along e_r.
"""

from math import hypot
from typing import Any, NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.jit import absent, generic, jit
from bearingsim.core.laws.damping.interface import normal_force
from bearingsim.core.laws.friction.interface import mu
from bearingsim.core.laws.stiffness.interface import tangent
from bearingsim.core.sums import sum_loads


@absent
class KinematicCage(NamedTuple):
    """Cage at its kinematic speed about the bearing's centre, with every roller centred in its pocket."""


class FreeCage(NamedTuple):
    """Cage that rotates and moves under the forces of rollers and guide.

    m: kg; inertia: kg m^2 about its axis; play: half of the pocket's clearance (m); pocket: contact law of a
    pocket's wall; friction: friction law of roller and wall; guide: guidance of its centre.
    """

    m: float
    inertia: float
    play: float
    pocket: Any
    friction: Any
    guide: Any


@absent
class Centred(NamedTuple):
    """Cage centre fixed at the bearing's centre."""


class RollerGuided(NamedTuple):
    """Guidance by the rollers: a pocket stops its roller radially after ``play`` (m) by the contact ``law``."""

    play: float
    law: Any


class RingGuided(NamedTuple):
    """Guidance by a land of a ring with the radial ``play`` (m).

    land: radius of the land (m); outer: 1.0 on the outer ring, 0.0 on the inner; law, friction: contact law and
    friction law of cage and land.
    """

    play: float
    land: float
    outer: float
    law: Any
    friction: Any


@absent
class NoDrag(NamedTuple):
    """No drag on rollers and cage."""


class OilDrag(NamedTuple):
    """Oil drag on the orbiting rollers, and on the cage at the land of a ring.

    roller: 1/2 rho C_d L D, N s^2/m^2; land: N m s/rad; outer: 1.0 if the land is on the outer ring, whose
    rotation is neglected here, else 0.0.
    """

    roller: float
    land: float
    outer: float


@generic(absent=0.0)
def orbit_drag(drag: Any, speed: float) -> float:
    """Return the drag (N) on a roller along its orbit at ``speed`` (m/s)."""


@generic(absent=0.0)
def land_drag(drag: Any, omega_cage: float, omega_i: float) -> float:
    """Return the drag torque (N m) on the cage at the speeds (rad/s) of the cage and the inner ring."""


@orbit_drag.register(OilDrag)
def _orbit_drag_oil(drag, speed):
    return -drag.roller * speed * abs(speed)


@land_drag.register(OilDrag)
def _land_drag_oil(drag, omega_cage, omega_i):
    return -drag.land * (omega_cage - (1.0 - drag.outer) * omega_i)


@generic(absent=0.0)
def radial_stop(guide: Any, offset: float, speed: float) -> float:
    """Return the force (N) of a pocket on its roller along e_r.

    offset, speed: displacement from the pocket's centre (m) and its rate (m/s), outwards.
    """


@radial_stop.register(RingGuided)
def _radial_stop_ring(guide, offset, speed):
    return 0.0


@radial_stop.register(RollerGuided)
def _radial_stop_rollers(guide, offset, speed):
    force = normal_force(guide.law, abs(offset) - guide.play, speed if offset > 0.0 else -speed)
    return -force if offset > 0.0 else force


@generic(absent=(0.0, 0.0))
def cage_centre_acceleration(guide: Any, m: float, y: Any) -> tuple[float, float]:
    """Return the acceleration (m/s^2) of the cage's centre under the forces in the cells F_X_C, F_Y_C."""


@cage_centre_acceleration.register(RollerGuided)
def _cage_centre_acceleration_rollers(guide, m, y):
    return y[lay.F_X_C] / m, y[lay.F_Y_C] / m


@cage_centre_acceleration.register(RingGuided)
def _cage_centre_acceleration_ring(guide, m, y):
    return y[lay.F_X_C] / m, y[lay.F_Y_C] / m


@generic(absent=None)
def add_land_contact(guide: Any, omega_cage: float, omega_i: float, y: Any) -> None:
    """Add the force between cage and guiding land to the load cells of cage and ring."""


@add_land_contact.register(RollerGuided)
def _add_land_contact_rollers(guide, omega_cage, omega_i, y):
    return None


@jit
def cage_motion_in_land(guide, y):
    """Return position (m, m) and velocity (m/s, m/s) of the cage's centre relative to that of the guiding ring."""
    outer, inner = guide.outer, 1.0 - guide.outer  # 1 for the guiding ring, 0 for the other
    e_x = y[lay.POSITION + lay.X_C] - outer * y[lay.POSITION + lay.X] - inner * y[lay.POSITION + lay.X_I]
    e_y = y[lay.POSITION + lay.Y_C] - outer * y[lay.POSITION + lay.Y] - inner * y[lay.POSITION + lay.Y_I]
    v_x = y[lay.VELOCITY + lay.X_C] - outer * y[lay.VELOCITY + lay.X] - inner * y[lay.VELOCITY + lay.X_I]
    v_y = y[lay.VELOCITY + lay.Y_C] - outer * y[lay.VELOCITY + lay.Y] - inner * y[lay.VELOCITY + lay.Y_I]
    return e_x, e_y, v_x, v_y


@add_land_contact.register(RingGuided)
def _add_land_contact_ring(guide, omega_cage, omega_i, y):
    """Compute the contact of cage and land, which closes when the eccentricity of cage and ring exceeds the play.

    The point of contact lies on the line through both centres.
    """
    outer, inner = guide.outer, 1.0 - guide.outer  # 1 for the guiding ring, 0 for the other
    e_x, e_y, v_x, v_y = cage_motion_in_land(guide, y)
    eccentricity = max(hypot(e_x, e_y), 1e-30)
    c, s = e_x / eccentricity, e_y / eccentricity
    N = normal_force(guide.law, eccentricity - guide.play, v_x * c + v_y * s)
    omega_ring = inner * omega_i + outer * y[lay.VELOCITY + lay.PSI]
    # arms from the centres of cage and ring to the point of contact: the cage touches an outer land on the side to
    # which it is displaced, an inner land on the opposite side
    cage_arm = (outer - inner) * guide.land
    ring_arm = cage_arm + eccentricity
    slip = -v_x * s + v_y * c + cage_arm * omega_cage - ring_arm * omega_ring
    f = mu(guide.friction, slip, guide.land * abs(omega_cage)) * N
    f_x, f_y = -N * c + f * s, -N * s - f * c
    y[lay.F_X_C] += f_x
    y[lay.F_Y_C] += f_y
    y[lay.M_C] -= cage_arm * f
    y[lay.F_X] -= outer * f_x
    y[lay.F_Y] -= outer * f_y
    y[lay.M_RING] += outer * ring_arm * f
    y[lay.F_X_I] -= inner * f_x
    y[lay.F_Y_I] -= inner * f_y


@generic(inline="late", absent=None)
def add_pocket_force(cage: Any, model: Any, common: Any, y: Any, j: int) -> None:
    """Add the pocket's force to the rows FORCE_R, FORCE_T, TORQUE of roller ``j``; fill its loads on the cage.

    common: fields ``cage`` (a ``Centre``), ``omega_cage`` (speed of the cage, rad/s) and ``spin`` (nominal spin of
    a roller, rad/s) are used.
    """


@add_pocket_force.register(FreeCage)
def _add_pocket_force_free(cage, model, common, y, j):
    """Implement ``add_pocket_force`` by equation (P10) of docs/planar.md."""
    b, omega_cage = model.bearing, common.omega_cage
    R_mean, R_w, mask = 0.5 * (b.R_o + b.R_i), b.R_w, b.m_r * y[lay.INVERSE_MASS + j]  # mask: 0 in a padded lane
    pc, ps, ce, se = y[lay.COS_POCKET + j], y[lay.SIN_POCKET + j], y[lay.COS_EPS + j], y[lay.SIN_EPS + j]
    r, v = R_mean + y[lay.RADIAL + j], y[lay.RADIAL_V + j]
    w = r * (omega_cage + y[lay.EPS_V + j])
    e = r * se + common.cage.x * ps - common.cage.y * pc
    rho = r * ce - common.cage.x * pc - common.cage.y * ps
    # velocity relative to the cage's centre, along the pocket's e_r and e_theta
    v_r = v * ce - w * se - common.cage.v_x * pc - common.cage.v_y * ps
    v_t = v * se + w * ce + common.cage.v_x * ps - common.cage.v_y * pc
    side = 1.0 if e > 0.0 else -1.0
    N = normal_force(cage.pocket, abs(e) - cage.play, side * (v_t - omega_cage * rho))
    slip = v_r - side * R_w * (common.spin + y[lay.SPIN_V + j]) + omega_cage * (e + side * R_w)
    f = mu(cage.friction, slip, R_w * abs(common.spin)) * N
    stop = radial_stop(cage.guide, rho - R_mean, v_r + omega_cage * e)
    force_r, force_t = mask * (stop - f), -mask * side * N  # on the roller, along the pocket's e_r and e_theta
    y[lay.Q_P + j] = force_t
    y[lay.FORCE_R + j] += force_r * ce + force_t * se
    y[lay.FORCE_T + j] += force_t * ce - force_r * se
    y[lay.TORQUE + j] += mask * side * R_w * f
    y[lay.roller_load(lay.F_X_C) + j] = -force_r * pc + force_t * ps
    y[lay.roller_load(lay.F_Y_C) + j] = -force_r * ps - force_t * pc
    y[lay.roller_load(lay.M_C) + j] = e * force_r - rho * force_t - mask * side * R_w * f


@generic(inline="late", absent=None)
def sum_pocket_forces(cage: Any, y: Any, n: int) -> None:
    """Fill the load cells of the cage with the sums of the pocket forces in the plane."""


@sum_pocket_forces.register(FreeCage)
def _sum_pocket_forces_free(cage, y, n):
    sum_loads(lay.F_X_C, lay.M_C, y, n)


@generic
def accelerate_cage(cage: Any, model: Any, omega_cage: float, omega_i: float, alpha: float, y: Any) -> float:
    """Return the cage's angular acceleration (rad/s^2); write the acceleration of its centre into the state.

    alpha: acceleration of the kinematic angle (rad/s^2). Adds the forces of the cage's guide to the load cells of
    the rings.
    """


@accelerate_cage.register(KinematicCage)
def _accelerate_cage_kinematic(cage, model, omega_cage, omega_i, alpha, y):
    return alpha


@accelerate_cage.register(FreeCage)
def _accelerate_cage_free(cage, model, omega_cage, omega_i, alpha, y):
    y[lay.F_X_C] += cage.m * model.gravity
    add_land_contact(cage.guide, omega_cage, omega_i, y)
    y[lay.ACCELERATION + lay.X_C], y[lay.ACCELERATION + lay.Y_C] = cage_centre_acceleration(cage.guide, cage.m, y)
    return (y[lay.M_C] + land_drag(model.drag, omega_cage, omega_i)) / cage.inertia


@generic(absent=0.0)
def pocket_stiffness(cage: Any, per_mass: float, Z: int) -> float:
    """Return the stiffness of the pockets' walls over the effective mass (1/s^2) of ``Z`` rollers and the cage.

    per_mass: inverse mass of a roller (1/kg). That of the cage is Z r^2/I = Z/m if all rollers push it, because
    its moment of inertia I is m r^2; its translation adds no more.
    """


@pocket_stiffness.register(FreeCage)
def _pocket_stiffness_free(cage, per_mass, Z):
    return tangent(cage.pocket.stiffness, cage.play) * (per_mass + Z / cage.m)


@generic(absent=0.0)
def cage_constraint(cage: Any, acceleration: float) -> float:
    """Return ``acceleration`` of a roller along a coordinate that a kinematic cage prescribes; 0 with such a
    cage."""


@cage_constraint.register(FreeCage)
def _cage_constraint_free(cage, acceleration):
    return acceleration
