"""Flanges of the rings, which guide the rollers axially.

The flat end of a roller, at c + sigma (L_w/2) a, touches the face of the flange, at sigma (L_w/2 + play) along the
ring's axis b, at two points of the chord of the end's circle at half of the flange's height above the race:

    X = u + sigma (L_w/2 + play) b + rho_f n +- t tau,     approach = L_w/2 - sigma (X - c).a

n points from the ring's axis to the roller's centre, tau = b x n, and rho_f is the radius at half of the height.
Half of the chord is T = sqrt(R_w^2 - (R_w - height/2)^2), and t = T/sqrt(3): these two Gauss points have the same
force and moment as a uniform line of springs along the chord if a skewed end touches the flange.

The approach depends only on the relative position of the two bodies, and force and moment are proportional to its
gradient, so energy and momentum are conserved at all angles. Friction acts at X, perpendicular to the roller's
axis.
"""

from math import inf, sqrt
from typing import Any, NamedTuple

from bearingsim.core import layout as lay
from bearingsim.core.geometry.orientation import Body
from bearingsim.core.geometry.sides import InnerSide, OuterSide, side_rows, sign
from bearingsim.core.geometry.vectors import combine, combine_three, cross, dot
from bearingsim.core.jit import absent, generic, jit
from bearingsim.core.laws.damping.interface import normal_force
from bearingsim.core.laws.friction.interface import mu
from bearingsim.core.laws.stiffness.interface import tangent
from bearingsim.core.parts.races_in_space import SLIP_OFFSET


@absent
class NoFlanges(NamedTuple):
    """Rings without flanges: only friction and the cage restrain a roller axially."""


class Flanges(NamedTuple):
    """Flanges of the two rings; the flat end of a roller touches one at two points along the race.

    inner_minus, inner_plus, outer_minus, outer_plus: 1.0 if this flange exists, else 0.0 (minus: at -z); play: gap
    between the end of a centred roller and the flange (m); height: of the flange above its race (m), with contact
    at half of it; law: contact law of one point; friction: friction law of roller end and flange.
    """

    inner_minus: float
    inner_plus: float
    outer_minus: float
    outer_plus: float
    play: float
    height: float
    law: Any
    friction: Any


@generic(absent=None)
def add_flange_forces(flanges: Any, model: Any, outer: Any, inner: Any, y: Any, n: int) -> None:
    """Add the flange forces to the contact sums of both sides of every roller; outer, inner: the rings."""


@add_flange_forces.register(Flanges)
def _add_flange_forces(flanges, model, outer, inner, y, n):
    for j in range(n):
        y[lay.Q_F + j], y[lay.KAPPA_F + j] = 0.0, 0.0
    if flanges.outer_minus + flanges.outer_plus > 0.0 and any_roller_near_flange(
        OuterSide(), flanges, model, outer, y, n
    ):
        add_side_flange_forces(OuterSide(), flanges, flanges.outer_minus, flanges.outer_plus, model, outer, y, n)
    if flanges.inner_minus + flanges.inner_plus > 0.0 and any_roller_near_flange(
        InnerSide(), flanges, model, inner, y, n
    ):
        add_side_flange_forces(InnerSide(), flanges, flanges.inner_minus, flanges.inner_plus, model, inner, y, n)


@jit
def any_roller_near_flange(side, flanges, model, ring, y, n):
    """Check if any roller may touch a flange of this ring; usually none does, and the ring's flanges are skipped.

    The approach at the point X is L_w/2 (1 - a.b) - play a.b + sigma w a.b - sigma (X - c).(a - (a.b) b). It is
    at most |w| + (R_w + t + L_w/2) tilt - play (1 - tilt), with w the axial offset and tilt the sine of the angle
    between the axes.
    """
    base, R_mean = side_rows(side), 0.5 * (model.bearing.R_o + model.bearing.R_i)
    play, lever_arm = flanges.play, 2.0 * model.bearing.R_w + 0.5 * model.L_w + flanges.play
    count = 0
    for j in range(n):
        c, s = y[lay.COS + j], y[lay.SIN + j]
        d_r, d_t = R_mean + y[lay.RADIAL + j] - ring.x * c - ring.y * s, ring.x * s - ring.y * c
        axial_offset = d_r * y[base + lay.RING_AXIS_R + j] + d_t * y[base + lay.RING_AXIS_T + j]
        axial_offset += (y[lay.AXIAL + j] - ring.z) * ring.a_z
        a_r, a_t, a_z = y[base + lay.DIRECTION_R + j], y[base + lay.DIRECTION_T + j], y[base + lay.DIRECTION_Z + j]
        max_offset = abs(axial_offset) + lever_arm * sqrt(a_r * a_r + a_t * a_t + a_z * a_z)
        count += 0 if max_offset < play else 1  # NaN counts as near
    return count > 0


@jit
def add_side_flange_forces(side, flanges, minus, plus, model, ring, y, n):
    """Add the forces of the flanges of one ring; minus, plus: 1.0 for a flange at this end, else 0.0."""
    if minus > 0.0:
        add_flange_force(side, flanges, model, ring, -1.0, y, n)
    if plus > 0.0:
        add_flange_force(side, flanges, model, ring, 1.0, y, n)


@jit
def gauss_offset(R_w, height):
    """Return t, the distance (m) of each of the two contact points from the centre of the chord."""
    return sqrt(R_w * R_w - (R_w - 0.5 * height) ** 2) / sqrt(3.0)


@jit
def add_flange_force(side, flanges, model, ring, sigma, y, n):
    """Add the forces at both points of one flange, at the +z (``sigma`` 1) or the -z end (-1) of the rollers."""
    t = gauss_offset(model.bearing.R_w, flanges.height)
    add_flange_point_force(side, flanges, model, ring, sigma, t, y, n)
    add_flange_point_force(side, flanges, model, ring, sigma, -t, y, n)


@jit
def add_flange_point_force(side, flanges, model, ring, sigma, t, y, n):
    """Add force, friction and moment at one point, ``t`` (m) along the race, of every roller.

    Equation (S4) of docs/spatial.md.
    """
    b, half = model.bearing, 0.5 * model.L_w
    face = b.R_o - 0.5 * flanges.height if sign(side) > 0.0 else b.R_i + 0.5 * flanges.height
    for j in range(n):
        roller = roller_in_ring(side, b, ring, y, j)
        q = face - roller.rho
        z = sigma * (half + flanges.play) - roller.axial_offset
        Y = combine_three(z, roller.b, q, roller.n, t, roller.tau)  # X - c
        g, axis_rate = approach_gradient(roller, sigma, q, t)
        rate = dot(g, roller.velocity) - sigma * dot(Y, axis_rate)
        N = b.m_r * y[lay.INVERSE_MASS + j] * normal_force(flanges.law, half - sigma * dot(Y, roller.a), rate)
        slip, roll_speed = contact_slip(roller, ring, Y, axis_rate, y[lay.OMEGA + j])
        kappa = mu(flanges.friction, slip[3], b.R_w * roll_speed) * N / slip[3]
        add_point(side, sigma, N, kappa, g, Y, roller.a, slip, y, j)


class RollerInRing(NamedTuple):
    """Roller relative to a ring, along e_r, e_theta, e_z.

    a, b: axes of roller and ring; a_v, b_v: their rates (1/s); n: direction from the ring's axis to the roller's
    centre, and tau = b x n; rho: distance of the centre from the axis (m); axial_offset: distance along the axis
    from the ring's centre (m); velocity: of the centre relative to the tilting ring (m/s).
    """

    a: Any
    a_v: Any
    b: Any
    b_v: Any
    n: Any
    tau: Any
    rho: float
    axial_offset: float
    velocity: Any


@jit
def roller_in_ring(side, bearing, ring, y, j):
    """Return ``RollerInRing`` of roller ``j``, from the rows filled by ``fill_race_frame`` of
    ``parts/races_in_space.py``."""
    base = side_rows(side)
    r = 0.5 * (bearing.R_o + bearing.R_i) + y[lay.RADIAL + j]
    c = y[lay.COS + j]
    s = y[lay.SIN + j]
    b = y[base + lay.RING_AXIS_R + j], y[base + lay.RING_AXIS_T + j], ring.a_z
    b_v = ring.w_x * c + ring.w_y * s, ring.w_y * c - ring.w_x * s, ring.w_z
    d = r - ring.x * c - ring.y * s, ring.x * s - ring.y * c, y[lay.AXIAL + j] - ring.z
    X = r + y[base + lay.OFFSET_R + j], y[base + lay.OFFSET_T + j], y[base + lay.OFFSET_Z + j]
    rho, axial_rate = sqrt(dot(X, X)), dot(d, b_v)
    n = X[0] / rho, X[1] / rho, X[2] / rho
    velocity = combine(
        1.0,
        (y[base + lay.OFFSET_V_R + j], y[base + lay.OFFSET_V_T + j], y[base + lay.OFFSET_V_Z + j]),
        axial_rate,
        b,
    )
    a = (y[lay.TILT + j], y[lay.SKEW + j], y[lay.AXIS_Z + j])
    a_v = (y[lay.TILT_V + j], y[lay.SKEW_V + j], y[lay.AXIS_Z_V + j])
    return RollerInRing(a, a_v, b, b_v, n, cross(b, n), rho, dot(d, b), velocity)


@jit
def approach_gradient(roller, sigma, q, t):
    """Return the gradient (1) of the approach with respect to the roller's centre, and the rate (1/s) of the
    roller's axis relative to the ring.

    q, t: position of the contact point relative to the roller's centre, along n and tau (m).
    """
    a_b, a_n = dot(roller.a, roller.b), dot(roller.a, roller.n)
    a_tau = (t * a_n - q * dot(roller.a, roller.tau)) / roller.rho  # the contact point orbits with the roller
    g = combine_three(sigma * a_b, roller.b, sigma * a_n, roller.n, sigma * a_tau, roller.tau)
    return g, combine_three(1.0, roller.a_v, -a_b, roller.b_v, dot(roller.a, roller.b_v), roller.b)


@jit
def contact_slip(roller, ring, Y, axis_rate, omega):
    """Return the slip (m/s) perpendicular to the roller's axis, with its magnitude as fourth entry, and the
    roller's absolute rotation speed relative to the tilting ring (rad/s).

    Y: contact point relative to the roller's centre (m); axis_rate: rate (1/s) of the roller's axis relative
    to the ring; omega: speed (rad/s) about the axis.
    """
    roll_speed = omega - dot(roller.a, cross(roller.b, roller.b_v))
    rotation = combine_three(1.0, cross(roller.a, axis_rate), roll_speed, roller.a, -ring.omega, roller.b)
    v = combine_three(1.0, cross(rotation, Y), 1.0, roller.velocity, -ring.omega * roller.rho, roller.tau)
    v = combine(1.0, v, -dot(v, roller.a), roller.a)
    return (v[0], v[1], v[2], sqrt(dot(v, v) + SLIP_OFFSET * SLIP_OFFSET)), abs(roll_speed)


@jit
def add_point(side, sigma, N, kappa, g, Y, a, slip, y, j):
    """Add the normal force ``N`` (N) and the friction at ``Y`` to the sums of roller ``j``.

    kappa: friction over slip (N s/m); g: gradient of the approach (1); Y: contact point relative to the roller's
    centre (m); a: axis of the roller; slip: m/s.
    """
    base = side_rows(side)
    G = combine(-kappa, slip, -N, g)
    M = cross(Y, combine(-kappa, slip, -N * sigma, a))  # sigma a x Y = Y x -sigma a
    y[base + lay.CONTACT_FORCE_R + j] += G[0]
    y[base + lay.CONTACT_FORCE_T + j] += G[1]
    y[base + lay.CONTACT_FORCE_Z + j] += G[2]
    y[base + lay.COUPLE_R + j] += M[0]
    y[base + lay.COUPLE_T + j] += M[1]
    y[base + lay.COUPLE_Z + j] += M[2]
    y[lay.Q_F + j] -= N * g[2]
    y[lay.KAPPA_F + j] += kappa


@generic(absent=0.0)
def axial_position(
    flanges: Any, bearing: Any, outer: Body, inner: Body, c: float, s: float, r: float, tilt: float
) -> float:
    """Return the axial position (m) of a centred roller at radius ``r`` (m) and the angle of cosine c, sine s.

    The position is the mean of both rings' ``flange_centre``, weighted by their numbers of flanges and limited to
    the play of every flange, which is smaller at one of the two contact points if the flange is skewed to the
    roller. If tilted rings leave no such position, it is halfway between the two flanges that touch the roller,
    whose forces are then about equal. tilt: of the roller (1).
    """


@axial_position.register(Flanges)
def _axial_position(flanges, bearing, outer, inner, c, s, r, tilt):
    n_outer, n_inner = flanges.outer_minus + flanges.outer_plus, flanges.inner_minus + flanges.inner_plus
    z_outer = flange_centre(outer, bearing.R_o - 0.5 * flanges.height, c, s, r, tilt)
    z_inner = flange_centre(inner, bearing.R_i + 0.5 * flanges.height, c, s, r, tilt)
    centre = (n_outer * z_outer + n_inner * z_inner) / max(n_outer + n_inner, 1.0)
    t = gauss_offset(bearing.R_w, flanges.height)
    play_outer = flanges.play - t * abs(outer.a_y * c - outer.a_x * s)
    play_inner = flanges.play - t * abs(inner.a_y * c - inner.a_x * s)
    low, high = -inf, inf
    if flanges.outer_minus > 0.0:
        low = z_outer - play_outer
    if flanges.inner_minus > 0.0:
        low = max(low, z_inner - play_inner)
    if flanges.outer_plus > 0.0:
        high = z_outer + play_outer
    if flanges.inner_plus > 0.0:
        high = min(high, z_inner + play_inner)
    return 0.5 * (low + high) if low > high else min(max(centre, low), high)


@jit
def flange_centre(ring, face, c, s, r, tilt):
    """Return the axial position (m) of a roller whose ends have the same approach to both flanges of a ring.

    It follows from the approach to first order in the tilts. face: radius (m) at half of the flanges' height; r:
    of the roller's centre (m); tilt: of the roller (1).
    """
    ring_tilt = ring.a_x * c + ring.a_y * s
    return ring.z - r * ring_tilt + (face - r) * (tilt - ring_tilt)


@generic(absent=0.0)
def flange_stiffness(flanges: Any, per_mass: float, per_inertia: float, R_w: float) -> float:
    """Return the stiffness of a flange over the effective mass (1/s^2) of a roller.

    per_mass, per_inertia: inverse of a roller's mass (1/kg) and of its moment of inertia about a diameter
    (1/(kg m^2)).
    """


@flange_stiffness.register(Flanges)
def _flange_stiffness(flanges, per_mass, per_inertia, R_w):
    return 2.0 * tangent(flanges.law.stiffness, flanges.play) * (per_mass + R_w * R_w * per_inertia)
