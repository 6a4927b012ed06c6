"""Axial and tilting supports of a ring, for the coordinates that ``planar`` does not have.

The axis of a ring is the unit vector b; its components b_x, b_y in the plane of the bearing are the tilt (rad, for
the small angles of a bearing). A ring mounted with a tilt is misaligned.
"""

from math import sqrt
from typing import Any, NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.geometry.orientation import Body, axis_acceleration, axis_precession_rate
from bearingsim.core.jit import absent, generic


@absent
class RigidMount(NamedTuple):
    """Rigid axial and tilting support.

    tilt_x, tilt_y: components (1) of the ring's axis as mounted, along e_0 and e_90.
    """

    tilt_x: float
    tilt_y: float


class ElasticMount(NamedTuple):
    """Axial and tilting support by springs and dampers, at rest in the mounted position.

    m: kg; I_a, I_t: moments of inertia of the ring about its axis and a diameter (kg m^2); k_z: N/m; c_z: N s/m;
    k_tilt: N m/rad; c_tilt: N m s/rad; tilt_x, tilt_y: components (1) of the axis as mounted.

    The tilting spring has the energy k_tilt/2 ((b_x - tilt_x)^2 + (b_y - tilt_y)^2); the damper dissipates the
    power c_tilt (b_x'^2 + b_y'^2). For an outer ring that also rotates, I_a equals ``TorsionSpring.inertia``.
    """

    m: float
    I_a: float
    I_t: float
    k_z: float
    c_z: float
    k_tilt: float
    c_tilt: float
    tilt_x: float
    tilt_y: float


@generic
def set_mounted_ring(mount: Any, y: Any, z: int, tilt_x: int, tilt_y: int) -> None:
    """Set a ring on a rigid mount to its mounted position, with zero velocity and acceleration.

    z, tilt_x, tilt_y: cells of the ring's axial position and tilts in a block of the state.
    """


@set_mounted_ring.register(RigidMount)
def _set_mounted_ring_rigid(mount, y, z, tilt_x, tilt_y):
    y[lay.POSITION + z], y[lay.POSITION + tilt_x], y[lay.POSITION + tilt_y] = 0.0, mount.tilt_x, mount.tilt_y
    for block in (lay.VELOCITY, lay.ACCELERATION):
        y[block + z], y[block + tilt_x], y[block + tilt_y] = 0.0, 0.0, 0.0


@set_mounted_ring.register(ElasticMount)
def _set_mounted_ring_elastic(mount, y, z, tilt_x, tilt_y):
    return None


@generic(absent=0.0)
def accelerate_mounted_ring(
    mount: Any,
    ring: Body,
    f_z: float,
    m_x: float,
    m_y: float,
    m_z: float,
    y: Any,
    z: int,
    tilt_x: int,
    tilt_y: int,
) -> float:
    """Write the axial acceleration of the ring and that of its axis, under a force (N) and a moment (N m).

    z, tilt_x, tilt_y: as in ``set_mounted_ring``. Returns the torque (N m) due to precession of the axis, which
    does not accelerate the ring's angle.
    """


@accelerate_mounted_ring.register(ElasticMount)
def _accelerate_mounted_ring_elastic(mount, ring, f_z, m_x, m_y, m_z, y, z, tilt_x, tilt_y):
    b = ring
    tip_x = -mount.k_tilt * (b.a_x - mount.tilt_x) - mount.c_tilt * b.w_x  # force (N) on the tip of b, at 1 m
    tip_y = -mount.k_tilt * (b.a_y - mount.tilt_y) - mount.c_tilt * b.w_y
    m_x, m_y, m_z = m_x - b.a_z * tip_y, m_y + b.a_z * tip_x, m_z + b.a_x * tip_y - b.a_y * tip_x
    l_x, l_y = axis_acceleration(
        m_x, m_y, m_z, mount.I_a * b.omega, mount.I_t, b.a_x, b.a_y, b.a_z, b.w_x, b.w_y, b.w_z
    )
    y[lay.ACCELERATION + z] = (f_z - mount.k_z * b.z - mount.c_z * b.v_z) / mount.m
    y[lay.ACCELERATION + tilt_x], y[lay.ACCELERATION + tilt_y] = l_x, l_y
    return mount.I_a * axis_precession_rate(b, l_x, l_y)


@generic(absent=(0.0, 0.0))
def mount_spring_rates(mount: Any) -> tuple[float, float]:
    """Return the axial (N/m) and the tilting stiffness (N m/rad) of the mount; zero if it is rigid."""


@generic(absent=(0.0, 0.0, 0.0))
def mount_load(
    mount: Any, y: Any, f_z: float, m_x: float, m_y: float, m_z: float, z: int, tilt_x: int, tilt_y: int
) -> tuple[float, float, float]:
    """Return the net axial force (N) and the net generalised moments (N m) on b_x and b_y, without dampers; zero
    if rigid."""


@mount_spring_rates.register(ElasticMount)
def _mount_spring_rates_elastic(mount):
    return mount.k_z, mount.k_tilt


@mount_load.register(ElasticMount)
def _mount_load_elastic(mount, y, f_z, m_x, m_y, m_z, z, tilt_x, tilt_y):
    b_x, b_y = y[lay.POSITION + tilt_x], y[lay.POSITION + tilt_y]
    b_z = sqrt(1.0 - b_x * b_x - b_y * b_y)
    tip_x, tip_y = m_y * b_z - m_z * b_y, m_z * b_x - m_x * b_z  # equivalent force on the tip of b, at 1 m
    return (
        f_z - mount.k_z * y[lay.POSITION + z],
        tip_x - mount.k_tilt * (b_x - mount.tilt_x),
        tip_y - mount.k_tilt * (b_y - mount.tilt_y),
    )


@generic(absent=0.0)
def mount_stiffness(mount: Any) -> float:
    """Return the larger stiffness over inertia (1/s^2) of the mount's springs."""


@generic(absent=0.0)
def mount_damping(mount: Any) -> float:
    """Return the larger damping over inertia (1/s) of the mount's dampers."""


@mount_stiffness.register(ElasticMount)
def _mount_stiffness_elastic(mount):
    return max(mount.k_z / mount.m, mount.k_tilt / mount.I_t)


@mount_damping.register(ElasticMount)
def _mount_damping_elastic(mount):
    return max(mount.c_z / mount.m, mount.c_tilt / mount.I_t)
