"""How a ring is held against moving along its axis and leaning: the coordinates that ``planar`` does not have.

A ring's axis is the unit vector b; its components b_x, b_y in the bearing's plane are the lean (rad, for the small
angles of a bearing). A ring that is held with a lean is misaligned.
"""

from typing import NamedTuple


class Held(NamedTuple):
    """Does not move along its axis, nor lean further than it was mounted.

    lean_x, lean_y: components (1) of its axis along e_0 and e_90.
    """

    lean_x: float
    lean_y: float


class Sprung(NamedTuple):
    """On springs and dampers along the axis and against leaning, about where it was mounted.

    m: kg; I_a, I_t: moments of inertia about its axis and across it (kg m^2); k_z: N/m; c_z: N s/m;
    k_lean: N m/rad; c_lean: N m s/rad; lean_x, lean_y: components (1) of its axis as mounted.
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
