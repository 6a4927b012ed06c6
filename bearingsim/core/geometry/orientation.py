"""Direction and rotation of axisymmetric bodies (symmetric tops).

The axis is a unit vector a, of which the components a_x, a_y in fixed directions are stored, a_z = sqrt(1 - a_x^2
- a_y^2). The body's angle beta about the axis is measured from the orientation after the smallest rotation from
e_z to a. Its angular velocity is then

    Omega = a x a' + omega a,     omega = beta' + winding,     winding = (a_x' a_y - a_x a_y')/(1 + a_z)

where the winding is the speed about the axis that is due to its precession. With the axial and transverse moments
of inertia I_a and I_t and the moment M about the centre,

    omega' = M.a/I_a,     a'' = [(M - I_a omega a') x a]/I_t - |a'|^2 a

Both are exact, without small-angle approximation, and regular for tilts of the axis below 90 deg.
"""

from math import sqrt
from typing import NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.jit import jit


class Body(NamedTuple):
    """Current state of a ring or the cage, along e_0, e_90 and e_z.

    x, y, z: centre (m), v_x, v_y, v_z: velocity (m/s); a_x, a_y, a_z: axis, w_x, w_y, w_z: its rate (1/s); omega:
    angular velocity about the axis (rad/s).
    """

    x: float
    y: float
    z: float
    v_x: float
    v_y: float
    v_z: float
    a_x: float
    a_y: float
    a_z: float
    w_x: float
    w_y: float
    w_z: float
    omega: float


@jit
def axis_z(a_x, a_y):
    """Return the z component of an axis, a unit vector."""
    return sqrt(1.0 - a_x * a_x - a_y * a_y)


@jit
def axis_precession(a_x, a_y, a_z, w_x, w_y):
    """Return the winding (rad/s), the speed of a body about its axis that is due to the precession of the axis.

    Equation (S1) of docs/spatial.md.
    """
    return (w_x * a_y - a_x * w_y) / (1.0 + a_z)


@jit
def axis_precession_rate(body, l_x, l_y):
    """Return the rate (rad/s^2) of ``axis_precession`` if the axis has the acceleration ``l_x``, ``l_y``
    (1/s^2)."""
    denominator = 1.0 + body.a_z
    numerator = body.w_x * body.a_y - body.a_x * body.w_y
    return (l_x * body.a_y - body.a_x * l_y) / denominator - numerator * body.w_z / (denominator * denominator)


@jit
def axis_acceleration(m_x, m_y, m_z, spin, I_t, a_x, a_y, a_z, w_x, w_y, w_z):
    """Return the acceleration (1/s^2) of the x and y components of the axis under a moment (N m).

    spin: angular momentum about the axis (kg m^2/s). All components are along the same directions, fixed or those
    of the current frame.

    The term a'' of equation (S1) in docs/spatial.md.
    """
    t_x, t_y, t_z = m_x - spin * w_x, m_y - spin * w_y, m_z - spin * w_z
    rate_squared = w_x * w_x + w_y * w_y + w_z * w_z
    return (t_y * a_z - t_z * a_y) / I_t - rate_squared * a_x, (t_z * a_x - t_x * a_z) / I_t - rate_squared * a_y


@jit
def body_at(y, x, z, tilt_x, tilt_y, angle_rate):
    """Return the body stored in cells ``x``, ``x`` + 1, ``z`` (centre), ``tilt_x`` and ``tilt_y`` (axis).

    angle_rate: rate (rad/s) of its angle about the axis.
    """
    p, v = lay.POSITION, lay.VELOCITY
    a_x, a_y, w_x, w_y = y[p + tilt_x], y[p + tilt_y], y[v + tilt_x], y[v + tilt_y]
    a_z = axis_z(a_x, a_y)
    w_z = -(a_x * w_x + a_y * w_y) / a_z
    omega = angle_rate + axis_precession(a_x, a_y, a_z, w_x, w_y)
    return Body(
        y[p + x], y[p + x + 1], y[p + z], y[v + x], y[v + x + 1], y[v + z], a_x, a_y, a_z, w_x, w_y, w_z, omega
    )
