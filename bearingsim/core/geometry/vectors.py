"""Vectors by their components along three orthogonal directions."""

from bearingsim.core.jit import jit


@jit
def cross_components(a_r, a_t, a_z, b_r, b_t, b_z):
    """Return the vector product."""
    return a_t * b_z - a_z * b_t, a_z * b_r - a_r * b_z, a_r * b_t - a_t * b_r


@jit
def dot(a, b):
    """Return the scalar product of two vectors (3,)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@jit
def cross(a, b):
    """Return the vector product of two vectors (3,)."""
    return cross_components(a[0], a[1], a[2], b[0], b[1], b[2])


@jit
def combine(p, a, q, b):
    """Return p a + q b."""
    return p * a[0] + q * b[0], p * a[1] + q * b[1], p * a[2] + q * b[2]


@jit
def combine_three(p, a, q, b, s, c):
    """Return p a + q b + s c."""
    return p * a[0] + q * b[0] + s * c[0], p * a[1] + q * b[1] + s * c[1], p * a[2] + q * b[2] + s * c[2]


@jit
def angular_velocity(body, c, s):
    """Return the angular velocity (rad/s) of a ``Body`` along e_r, e_theta and e_z at the angle with cosine c and
    sine s."""
    o_x, o_y, o_z = cross_components(body.a_x, body.a_y, body.a_z, body.w_x, body.w_y, body.w_z)
    o_x, o_y = o_x + body.omega * body.a_x, o_y + body.omega * body.a_y
    return o_x * c + o_y * s, o_y * c - o_x * s, o_z + body.omega * body.a_z
