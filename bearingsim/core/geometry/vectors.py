"""Vector algebra with components along three orthonormal, right-handed directions.

Vectors are tuples or arrays (3,); results are tuples of three numbers.
"""

from bearingsim.core.jit import jit


@jit
def cross_components(a_r, a_t, a_z, b_r, b_t, b_z):
    """Return a x b from the components of a and of b along the three directions."""
    return a_t * b_z - a_z * b_t, a_z * b_r - a_r * b_z, a_r * b_t - a_t * b_r


@jit
def dot(a, b):
    """Return the scalar product a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@jit
def cross(a, b):
    """Return the vector product a x b."""
    return cross_components(a[0], a[1], a[2], b[0], b[1], b[2])


@jit
def combine(p, a, q, b):
    """Return p a + q b, with scalars p, q and vectors a, b."""
    return p * a[0] + q * b[0], p * a[1] + q * b[1], p * a[2] + q * b[2]


@jit
def combine_three(p, a, q, b, r, c):
    """Return p a + q b + r c, with scalars p, q, r and vectors a, b, c."""
    return p * a[0] + q * b[0] + r * c[0], p * a[1] + q * b[1] + r * c[1], p * a[2] + q * b[2] + r * c[2]


@jit
def angular_velocity(body, c, s):
    """Return the angular velocity (rad/s) of a ``Body`` along e_r, e_theta and e_z at the angle with cosine ``c``
    and sine ``s``.

    Equation (S1) of docs/spatial.md: a x da/dt + omega a, with the unit vector a along the axis.
    """
    omega_x, omega_y, omega_z = cross_components(body.a_x, body.a_y, body.a_z, body.w_x, body.w_y, body.w_z)
    omega_x, omega_y = omega_x + body.omega * body.a_x, omega_y + body.omega * body.a_y
    return omega_x * c + omega_y * s, omega_y * c - omega_x * s, omega_z + body.omega * body.a_z
