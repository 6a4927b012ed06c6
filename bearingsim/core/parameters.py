"""Parameters of the models, in SI units, with the symbols of docs/model.md.

Every float must be a ``float``, because an ``int`` would compile a second copy of the core; ``build`` ensures it.
"""

from typing import NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.jit import jit


class Bearing(NamedTuple):
    """Geometry, masses and motion of a bearing. Speeds are kinematic, for rolling without slip; at t = 0 if
    ramped."""

    Z: int  # number of rollers
    R_w: float  # roller radius, m
    R_o: float  # outer race radius, m
    R_i: float  # inner race radius, m
    gap: float  # a quarter of the diametral radial clearance, m: gap at each contact of a centred roller
    m_r: float  # roller mass, kg
    I_r: float  # roller's moment of inertia about its axis, kg m^2
    m_o: float  # outer ring mass, kg
    omega_i: float  # inner ring's speed, rad/s
    omega_c: float  # cage speed, rad/s
    omega_b: float  # a roller's spin relative to the cage, rad/s, positive against the sense of rotation
    theta_0: float  # angle of the first roller at t = 0, rad


class Support(NamedTuple):
    """Support and load of the outer ring: the load -F e_0 - F_across e_90, and the bracket's spring and damper.

    The spring is unloaded with the ring's centre at (x_0, y_0).
    """

    F: float  # N
    F_across: float  # N
    k_b: float  # N/m
    c_b: float  # N s/m
    x_0: float  # m
    y_0: float  # m


@jit
def lanes(bearing):
    """Return the number of lanes in use: the rollers, padded to the vector width."""
    return (bearing.Z + lay.VECTOR_WIDTH - 1) // lay.VECTOR_WIDTH * lay.VECTOR_WIDTH


@jit
def kinematic_angles(bearing, t):
    """Return the angles (rad) of the cage, of the inner ring and of a roller relative to the cage at time ``t``
    (s), without slip.

    Equation (M2) of docs/model.md.
    """
    return bearing.theta_0 + bearing.omega_c * t, bearing.omega_i * t, bearing.omega_b * t
