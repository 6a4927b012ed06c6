"""How a ring is held against moving along its axis and leaning: the coordinates that ``planar`` does not have.

A ring's axis is the unit vector b; its components b_x, b_y in the bearing's plane are the lean (rad, for the small
angles of a bearing). A ring that is held with a lean is misaligned.
"""

from typing import Any, NamedTuple

from bearingsim.core.geometry.orientation import Body, tip, winding_rate
from bearingsim.core.jit import absent, generic
from bearingsim.core.layout import ACCELERATION, POSITION, VELOCITY


@absent
class Held(NamedTuple):
    """Does not move along its axis, nor lean further than it was mounted.

    lean_x, lean_y: components (1) of its axis along e_0 and e_90.
    """

    lean_x: float
    lean_y: float


class Sprung(NamedTuple):
    """On springs and dampers along the axis and against leaning, about where it was mounted.

    m: kg; I_a, I_t: moments of inertia about its axis and across it (kg m^2); k_z: N/m; c_z: N s/m; k_lean:
    N m/rad; c_lean: N m s/rad; lean_x, lean_y: components (1) of its axis as mounted.

    The spring against leaning has the energy k_lean/2 ((b_x - lean_x)^2 + (b_y - lean_y)^2), the damper loses
    c_lean (b_x'^2 + b_y'^2). A ring that also turns on its bracket has the bracket's inertia for I_a.
    """

    m: float
    I_a: float
    I_t: float
    k_z: float
    c_z: float
    k_lean: float
    c_lean: float
    lean_x: float
    lean_y: float


@generic
def hold(held: Any, y: Any, z: int, lean_x: int, lean_y: int) -> None:
    """Put the ring where it is held, if it is, once: it stays, as nothing accelerates it.

    z, lean_x, lean_y: its shared coordinates.
    """


@hold.register(Held)
def _hold_held(held, y, z, lean_x, lean_y):
    y[POSITION + z], y[POSITION + lean_x], y[POSITION + lean_y] = 0.0, held.lean_x, held.lean_y
    for block in (VELOCITY, ACCELERATION):
        y[block + z], y[block + lean_x], y[block + lean_y] = 0.0, 0.0, 0.0


@hold.register(Sprung)
def _hold_sprung(held, y, z, lean_x, lean_y):
    return None


@generic(absent=0.0)
def move_mounted(
    held: Any, ring: Body, f_z: float, m_x: float, m_y: float, m_z: float, y: Any, z: int, lean_x: int, lean_y: int
) -> float:
    """Write the ring's acceleration along the axis and that of its axis, under a force (N) and a moment (N m).

    Returns the torque (N m) that the axis' motion takes up before the ring's angle feels the rest.
    """


@move_mounted.register(Sprung)
def _move_mounted_sprung(held, ring, f_z, m_x, m_y, m_z, y, z, lean_x, lean_y):
    b = ring
    s_x = -held.k_lean * (b.a_x - held.lean_x) - held.c_lean * b.w_x  # on the axis' tip, at 1 m
    s_y = -held.k_lean * (b.a_y - held.lean_y) - held.c_lean * b.w_y
    m_x, m_y, m_z = m_x - b.a_z * s_y, m_y + b.a_z * s_x, m_z + b.a_x * s_y - b.a_y * s_x
    l_x, l_y = tip(m_x, m_y, m_z, held.I_a * b.turns, held.I_t, b.a_x, b.a_y, b.a_z, b.w_x, b.w_y, b.w_z)
    y[ACCELERATION + z] = (f_z - held.k_z * b.z - held.c_z * b.v_z) / held.m
    y[ACCELERATION + lean_x], y[ACCELERATION + lean_y] = l_x, l_y
    return held.I_a * winding_rate(b, l_x, l_y)


@generic(absent=(0.0, 0.0, 0.0))
def mount_mobility(held: Any) -> tuple[float, float, float]:
    """What a force accelerates the ring by along the axis (1/kg), a moment its axis (1/(kg m^2)); its I_a."""


@generic(absent=(0.0, 0.0, 0.0, 0.0))
def mount_springs(held: Any) -> tuple[float, float, float, float]:
    """Springs and dampers over what they hold: along the axis (1/s^2, 1/s), against leaning (1/s^2, 1/s)."""


@mount_mobility.register(Sprung)
def _mount_mobility_sprung(held):
    return 1.0 / held.m, 1.0 / held.I_t, held.I_a


@mount_springs.register(Sprung)
def _mount_springs_sprung(held):
    return held.k_z / held.m, held.c_z / held.m, held.k_lean / held.I_t, held.c_lean / held.I_t


@generic(absent=None)
def mount_rates(held: Any) -> tuple[float, float] | None:
    """Spring rates along the axis (N/m) and against leaning (N m/rad); None where nothing gives way."""


@mount_rates.register(Sprung)
def _mount_rates_sprung(held):
    return held.k_z, held.k_lean


@generic(absent=0.0)
def mount_stiffness(held: Any) -> float:
    """The larger stiffness over inertia (1/s^2) of the mount's springs."""


@generic(absent=0.0)
def mount_damping(held: Any) -> float:
    """The larger damping over inertia (1/s) of the mount's dampers."""


@mount_stiffness.register(Sprung)
def _mount_stiffness_sprung(held):
    return max(held.k_z / held.m, held.k_lean / held.I_t)


@mount_damping.register(Sprung)
def _mount_damping_sprung(held):
    return max(held.c_z / held.m, held.c_lean / held.I_t)
