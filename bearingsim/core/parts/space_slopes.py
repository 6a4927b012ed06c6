"""The contacts of ``spatial`` as matrices of wrenches over twists (``parts/wrench.py``): races, flanges, pockets.

Left out: that what an excitation shares changes along a pit, and in flanges products of rates and of how far axes
lean.
"""

from math import sqrt
from typing import Any

from bearingsim.core import layout as lay
from bearingsim.core.geometry.sides import side_rows, sign
from bearingsim.core.geometry.slices import DROP, WEIGHT, ZETA
from bearingsim.core.geometry.vectors import angular_velocity, combine, combine_three, cross, dot
from bearingsim.core.jit import generic, jit
from bearingsim.core.laws.damping.interface import normal_force, slopes
from bearingsim.core.laws.friction.interface import mu, mu_slope
from bearingsim.core.parts.cage import FreeCage, KinematicCage, radial_stop
from bearingsim.core.parts.cage_in_space import CageInPlane, CageInSpace, axial_stop, pocket_axes, relative_to_cage
from bearingsim.core.parts.cage_slopes import radial_stop_slopes
from bearingsim.core.parts.flanges import Flanges, NoFlanges, half_chord, roller_in_ring, slip_at
from bearingsim.core.parts.flanges import approach_gradient as approach_slopes
from bearingsim.core.parts.races_in_space import AT_REST, slice_force, slice_kinematics
from bearingsim.core.parts.wrench import (
    add_contact,
    add_force,
    add_rolling,
    combine_six,
    matrix_of,
    six,
    subtract_outer,
    turn_moment_arm,
    wrench,
)
from bearingsim.core.pits.on_slices import (
    SLICE_REACHED,
    clear_pit_response,
    mark_rollers_at_pits,
    slice_pit_curvature,
    slice_pit_response,
)

ZERO_3, ZERO_6 = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@jit
def friction_terms(friction, slip, drift, u):
    """mu, its slopes by slip and rolling (s/m), mu over the slip's speed (s/m), and the slip's direction."""
    speed = sqrt(slip * slip + drift * drift + AT_REST * AT_REST)
    value = mu(friction, speed, u)
    by_slip, by_rolling = mu_slope(friction, speed, u)
    return value, by_slip, by_rolling, value / speed, slip / speed, drift / speed


@jit
def axis_of(y, j):
    """A roller's axis along e_r, e_theta, e_z."""
    return y[lay.TILT + j], y[lay.SKEW + j], y[lay.AXIS_Z + j]


@jit
def relative_to_body(body, bearing, omega_cage, y, j):
    """A roller as a body sees it that moves and turns: place (m), velocity (m/s), angular velocity (rad/s)."""
    c = y[lay.COS_POCKET + j] * y[lay.COS_EPS + j] - y[lay.SIN_POCKET + j] * y[lay.SIN_EPS + j]
    s = y[lay.SIN_POCKET + j] * y[lay.COS_EPS + j] + y[lay.COS_POCKET + j] * y[lay.SIN_EPS + j]
    d_r, d_t, d_z, v_r, v_t, v_z = relative_to_cage(bearing, body, omega_cage, y, j)
    a = axis_of(y, j)
    own = combine(1.0, cross(a, (y[lay.TILT_V + j], y[lay.SKEW_V + j], y[lay.AXIS_Z_V + j])), y[lay.OMEGA + j], a)
    return (d_r, d_t, d_z), (v_r, v_t, v_z), combine(1.0, own, -1.0, angular_velocity(body, c, s))


@jit
def rate_by_rotation(d, omega, X):
    """How the rate along ``d`` of a point at ``X`` from the centre changes as the roller turns (six-vector)."""
    m = cross(X, cross(d, omega))
    return 0.0, 0.0, 0.0, m[0], m[1], m[2]


@jit
def race_jacobian(side, law, model, t, ring, b_z_outer, b_z_inner, omega_cage, y, n):
    """Add all slices' contacts with a race to the matrices, from the rows that ``face`` filled.

    b_z_outer, b_z_inner: third components of the rings' axes.
    """
    b, table = model.bearing, model.slices.table
    met = mark_rollers_at_pits(model, t, b_z_outer, b_z_inner, y) if len(model.pits.head) > 0 else 0
    for k in range(len(table)):
        if met > 0:
            slice_pit_response(model, t, k, 1.0, b_z_outer, b_z_inner, y)
        slice_kinematics(side, b, ring, table[k, ZETA], table[k, DROP], y, n)
        slice_force(side, law, model.friction, table[k, WEIGHT], y, n)
        for j in range(b.Z):
            if y[side_rows(side) + lay.LOAD + j] > 0.0:
                slice_jacobian(side, law, model, t, ring, omega_cage, k, y, j)
    if met > 0:
        clear_pit_response(model, y)


@jit
def slice_jacobian(side, law, model, t, ring, omega_cage, k, y, j):
    """Add the contact of slice ``k`` of roller ``j``, as ``slice_kinematics`` and ``slice_force`` left it."""
    at, sigma, row, a = side_rows(side), sign(side), model.slices.table[k], axis_of(y, j)
    b = y[at + lay.RING_AXIS_R + j], y[at + lay.RING_AXIS_T + j], ring.a_z
    n = (y[at + lay.NORMAL_R + j], y[at + lay.NORMAL_T + j], y[at + lay.NORMAL_Z + j])
    rho = y[at + lay.RHO + j]
    lean = y[at + lay.NORMAL_SLOPE + j]
    tau, cosine, delta = cross(b, n), 1.0 - y[at + lay.NORMAL_VERSINE + j], y[at + lay.APPROACH + j]
    sine, arm = sigma * lean * cosine, sigma * (model.bearing.R_w - row[DROP] - 0.5 * delta)
    e, out, g = combine(cosine, tau, sine, n), combine(cosine, n, -sine, tau), combine(sigma, n, -lean, tau)
    X = row[ZETA] * a[0], row[ZETA] * a[1], row[ZETA] * a[2]
    touch, own = combine(1.0, X, arm, out), y[at + lay.OWN_PIT + j] * rho  # a roller's own pit goes round with it
    aside, about = wrench(tau, X), six(ZERO_3, b)
    w_n, w_e, w_b = combine_six(1.0, wrench(g, X), own * lean, about), wrench(e, touch), wrench(b, touch)

    _, v, omega = relative_to_body(ring, model.bearing, omega_cage, y, j)
    v_p, v_touch = combine(1.0, v, 1.0, cross(omega, X)), combine(1.0, v, 1.0, cross(omega, touch))
    # of n, by place; of the normal, next
    across, turned = dot(tau, v_p), combine_six(1.0 / rho, aside, 0.0, aside)
    tilted, bends = ZERO_6, ZERO_6
    k_n = combine_six(1.0, rate_by_rotation(g, omega, X), sigma * across + lean * dot(n, v_p), turned)
    if y[at + lay.PIT_REACH + j] == SLICE_REACHED:
        bent, radius = slice_pit_curvature(model, t, k, sigma > 0.0, ring.a_z, y, j)
        passes = combine_six(radius / rho, aside, -radius / rho * own, about)  # s, by place
        bends = combine_six(bent, passes, 0.0, passes)
        tilted = combine_six(radius / rho, bends, -lean / rho, wrench(n, X))
        k_n = combine_six(1.0, k_n, -radius * (across / rho - y[at + lay.OWN_PIT + j] * dot(omega, b)), bends)
        k_n = combine_six(1.0, k_n, lean * across / rho, wrench(n, X))
        pit_jacobian(j, y[at + lay.LOAD + j], aside, tilted, radius * own / rho, about, bends, y)
    leant = combine_six(1.0, turned, -sigma * cosine * cosine, tilted)
    k_e = combine_six(1.0, rate_by_rotation(e, omega, X), -dot(out, v_touch), leant)
    k_b = combine_six(1.0, rate_by_rotation(b, omega, X), arm * dot(b, cross(omega, e)), leant)
    shrinks = combine_six(-0.5 * sigma, w_n, 0.0, w_n)  # the arm, by place
    round_out = cross(omega, out)
    k_e, k_b = combine_six(1.0, k_e, dot(e, round_out), shrinks), combine_six(1.0, k_b, dot(b, round_out), shrinks)

    K, C = slopes(law, delta, y[at + lay.APPROACH_V + j])
    kept, load = row[WEIGHT] * (1.0 - y[at + lay.STIFFNESS_LOSS + j]), y[at + lay.LOAD + j]
    m, by_slip, by_rolling, per_slip, p, q = friction_terms(
        model.friction, y[at + lay.SLIP_T + j], y[at + lay.SLIP_Z + j], y[lay.ROLLING_SPEED + j]
    )
    w_1 = combine_six(p, w_e, q, w_b)
    w_2 = combine_six(-q, w_e, p, w_b)
    k_1 = combine_six(p, k_e, q, k_b)
    k_2 = combine_six(-q, k_e, p, k_b)
    add_contact(j, w_n, w_1, w_2, kept * K, kept * C, m, load * by_slip, load * per_slip, k_n, k_1, k_2, y)
    add_rolling(j, w_1, load * by_rolling, y)

    f, f_b = m * load * p, m * load * q
    normal, friction = (-load * g[0], -load * g[1], -load * g[2]), combine(-f, e, -f_b, b)
    loads = combine_six(load, wrench(combine(sigma, tau, lean, n), X), 0.0, w_n)
    # the touching point goes round too
    rubs = combine_six(-f, wrench(out, touch), arm * f_b, six(ZERO_3, cross(e, b)))
    subtract_outer(matrix_of(j), loads, turned, rubs, leant, six(ZERO_3, cross(friction, out)), shrinks, y)
    M = combine(1.0, cross(X, normal), 1.0, cross(touch, friction))
    F = combine(1.0, normal, 1.0, friction)
    add_force(j, F, combine(1.0, M, -own * lean * load, b), y)
    turn_moment_arm(j, X, F, y)


@jit
def pit_jacobian(j, load, aside, tilted, carried, about, bends, y):
    """How the force (N) on a pit's edge turns as the edge bends; carried: radius (m) of an own pit, or 0."""
    of_own = combine_six(carried * load, about, 0.0, about)
    subtract_outer(matrix_of(j), combine_six(-load, aside, 0.0, aside), tilted, of_own, bends, ZERO_6, ZERO_6, y)


# Flanges


@generic
def flange_jacobian(flanges: Any, side: Any, model: Any, ring: Any, omega_cage: float, y: Any) -> None:
    """Add the contacts of the rollers' ends with a ring's flanges."""


@flange_jacobian.register(NoFlanges)
def _flange_jacobian_none(flanges, side, model, ring, omega_cage, y):
    return None


@flange_jacobian.register(Flanges)
def _flange_jacobian(flanges, side, model, ring, omega_cage, y):
    outer, t = sign(side) > 0.0, half_chord(model.bearing.R_w, flanges.height)
    minus = flanges.outer_minus if outer else flanges.inner_minus
    beyond = flanges.outer_plus if outer else flanges.inner_plus
    for sigma, there in ((-1.0, minus), (1.0, beyond)):
        for j in range(model.bearing.Z if there > 0.0 else 0):
            for way in (-t, t):
                flange_point_jacobian(side, flanges, model, ring, omega_cage, sigma, way, y, j)


@jit
def flange_point_jacobian(side, flanges, model, ring, omega_cage, sigma, t, y, j):
    """One point of roller ``j`` on the side ``sigma``, ``t`` (m) along the race
    (``flanges.flange_point_force``).
    """
    b, half = model.bearing, 0.5 * model.L_w
    face = b.R_o - 0.5 * flanges.height if sign(side) > 0.0 else b.R_i + 0.5 * flanges.height
    view = roller_in_ring(side, b, ring, y, j)
    q = face - view.rho
    Y = combine_three(sigma * (half + flanges.play) - view.off, view.b, q, view.n, t, view.tau)
    g, tips = approach_slopes(view, sigma, q, t)
    depth, rate = half - sigma * dot(Y, view.a), dot(g, view.moves) - sigma * dot(Y, tips)
    N = normal_force(flanges.law, depth, rate)
    if N > 0.0:
        slip, rolls = slip_at(view, ring, Y, tips, y[lay.OMEGA + j])
        m, by_slip, _, per_slip, _, _ = friction_terms(flanges.friction, slip[3], 0.0, b.R_w * rolls)
        p_1 = slip[0] / slip[3], slip[1] / slip[3], slip[2] / slip[3]
        p_2, (K, C) = cross(view.a, p_1), slopes(flanges.law, depth, rate)
        w_n = six(g, cross(Y, (sigma * view.a[0], sigma * view.a[1], sigma * view.a[2])))
        _, v, omega = relative_to_body(ring, b, omega_cage, y, j)
        swings = combine(q / view.rho, view.tau, -t / view.rho, view.n)  # the point as the roller goes round
        nods = combine_three(dot(v, view.b), view.b, dot(v, view.n), view.n, -dot(v, view.tau), swings)
        nods = cross(view.a, combine(sigma, nods, -sigma, cross(Y, omega)))
        k_1, k_2 = slip_by_place(view, Y, p_1, v, omega, swings), slip_by_place(view, Y, p_2, v, omega, swings)
        w_1, w_2 = wrench(p_1, Y), wrench(p_2, Y)
        add_contact(j, w_n, w_1, w_2, K, C, m, N * by_slip, N * per_slip, six(ZERO_3, nods), k_1, k_2, y)
        turn_flange_forces(j, view, sigma * N, m * N, Y, p_1, swings, y)
        F = combine(-N, g, -m * N, p_1)
        add_force(j, F, cross(Y, combine(-m * N, p_1, -N * sigma, view.a)), y)


@jit
def slip_by_place(view, Y, p, v, omega, swings):
    """How the slip along ``p`` changes with the place alone: the point moves, the end's plane tips."""
    whirl, past = cross(p, omega), -dot(combine(1.0, v, 1.0, cross(omega, Y)), view.a)
    moves = combine_three(-dot(view.b, whirl), view.b, -dot(view.n, whirl), view.n, dot(swings, whirl), view.tau)
    tips = cross(view.a, p)
    return six(moves, (past * tips[0], past * tips[1], past * tips[2]))


@jit
def turn_flange_forces(j, view, load, rub, Y, p_1, swings, y):
    """How the forces at a flange turn: load, rub: along the roller's axis and the slip (N)."""
    at, b, n, a = matrix_of(j), view.b, view.n, view.a
    tau, G = view.tau, combine(-load, a, -rub, p_1)
    by_b, by_n, by_tau = six(ZERO_3, cross(a, b)), six(ZERO_3, cross(a, n)), six(ZERO_3, cross(swings, a))
    f_b, f_n, f_tau = combine(load, b, 0.0, b), combine(load, n, 0.0, n), combine(load, tau, 0.0, tau)
    subtract_outer(at, six(f_b, ZERO_3), by_b, six(f_n, ZERO_3), by_n, six(f_tau, ZERO_3), by_tau, y)
    m_b, m_n, m_tau = six(ZERO_3, cross(b, G)), six(ZERO_3, cross(n, G)), six(ZERO_3, cross(G, swings))
    subtract_outer(at, m_b, six(b, ZERO_3), m_n, six(n, ZERO_3), m_tau, six(tau, ZERO_3), y)
    plane, turned = wrench(a, Y), six(ZERO_3, cross(a, p_1))
    subtract_outer(at, combine_six(-rub, plane, 0.0, plane), turned, ZERO_6, ZERO_6, ZERO_6, ZERO_6, y)
    turn_moment_arm(j, (load * a[0], load * a[1], load * a[2]), Y, y)  # the load is along the axis


# Pockets


@generic
def axial_stop_slopes(cage_z: Any, out: float, speed: float) -> tuple[float, float]:
    """How ``axial_stop`` grows with the way out (N/m) and its rate (N s/m)."""


@axial_stop_slopes.register(CageInPlane)
def _axial_stop_slopes_plane(cage_z, out, speed):
    return 0.0, 0.0


@axial_stop_slopes.register(CageInSpace)
def _axial_stop_slopes_space(cage_z, out, speed):
    K, C = slopes(cage_z.law, abs(out) - cage_z.play_z, speed if out > 0.0 else -speed)
    return -K, -C


@generic
def cage_mobility_in_space(cage_z: Any, cage: Any) -> tuple[float, float, float]:
    """What a force accelerates the cage by along the axis (1/kg), a moment its axis (1/(kg m^2)); its I_a."""


@cage_mobility_in_space.register(CageInPlane)
def _cage_mobility_plane(cage_z, cage):
    return 0.0, 0.0, 0.0


@cage_mobility_in_space.register(CageInSpace)
def _cage_mobility_space(cage_z, cage):
    return 1.0 / cage.m, 1.0 / cage_z.I_t, cage.inertia


@generic
def pocket_jacobian(cage: Any, model: Any, body: Any, omega_cage: float, spin: float, y: Any) -> None:
    """Add the contacts of the rollers with their pockets, from the rows that ``face_walls`` filled."""


@pocket_jacobian.register(KinematicCage)
def _pocket_jacobian_kinematic(cage, model, body, omega_cage, spin, y):
    return None


@pocket_jacobian.register(FreeCage)
def _pocket_jacobian_free(cage, model, body, omega_cage, spin, y):
    b, table = model.bearing, model.slices.table
    for j in range(b.Z):
        d, _, omega = relative_to_body(body, b, omega_cage, y, j)
        rad, w, leans, _ = pocket_axes(
            body, y[lay.COS_POCKET + j], y[lay.SIN_POCKET + j], y[lay.COS_EPS + j], y[lay.SIN_EPS + j]
        )
        axis = leans[0], leans[1], body.a_z
        if abs(y[lay.POCKET_OFFSET + j]) + 0.5 * model.L_w * abs(y[lay.POCKET_OFFSET_SLOPE + j]) > cage.play:
            for k in range(len(table)):
                pocket_slice_jacobian(cage, b.R_w, b.R_w * abs(spin), table[k], rad, w, axis, omega, y, j)
        out, aside = dot(d, rad) - 0.5 * (b.R_o + b.R_i), dot(d, axis)
        K, C = radial_stop_slopes(cage.guide, out, y[lay.POCKET_SLIP + j])
        stop_jacobian(j, rad, -K, -C, radial_stop(cage.guide, out, y[lay.POCKET_SLIP + j]), y)
        K, C = axial_stop_slopes(model.cage_z, aside, y[lay.POCKET_SLIP_Z + j])
        stop_jacobian(j, axis, -K, -C, axial_stop(model.cage_z, aside, y[lay.POCKET_SLIP_Z + j]), y)


@jit
def stop_jacobian(j, way, K, C, force, y):
    """A stop of a pocket, along ``way`` (3,) at the roller's centre; force: that way (N)."""
    if force != 0.0:
        add_contact(j, six(way, ZERO_3), ZERO_6, ZERO_6, K, C, 0.0, 0.0, 0.0, ZERO_6, ZERO_6, ZERO_6, y)
        add_force(j, (force * way[0], force * way[1], force * way[2]), ZERO_3, y)


@jit
def pocket_slice_jacobian(cage, R_w, u, row, rad, w, axis, omega, y, j):
    """One slice (``row`` of the table) of roller ``j`` on its pocket's wall
    (``cage_in_space.pocket_slice_force``).
    """
    zeta, radius, a = row[ZETA], R_w - row[DROP], axis_of(y, j)
    e = y[lay.POCKET_OFFSET + j] + zeta * y[lay.POCKET_OFFSET_SLOPE + j]
    side = 1.0 if e > 0.0 else -1.0
    depth, rate = abs(e) - cage.play, side * (y[lay.POCKET_OFFSET_V + j] + zeta * y[lay.POCKET_OFFSET_V_SLOPE + j])
    N = row[WEIGHT] * normal_force(cage.pocket, depth, rate)
    if N > 0.0:
        slip = (
            y[lay.POCKET_SLIP + j]
            + zeta * y[lay.POCKET_SLIP_SLOPE + j]
            - side * radius * y[lay.POCKET_OMEGA_Z + j]
        )
        drift = (
            y[lay.POCKET_SLIP_Z + j]
            + zeta * y[lay.POCKET_SLIP_Z_SLOPE + j]
            + side * radius * y[lay.POCKET_OMEGA_R + j]
        )
        m, by_slip, _, per_slip, p, q = friction_terms(cage.friction, slip, drift, u)
        X = zeta * a[0], zeta * a[1], zeta * a[2]
        touch = combine(1.0, X, side * radius, w)
        wall = (side * w[0], side * w[1], side * w[2])
        p_1 = combine(p, rad, q, axis)
        p_2 = combine(-q, rad, p, axis)
        k_n = rate_by_rotation(wall, omega, X)
        k_1 = rate_by_rotation(p_1, omega, X)
        k_2 = rate_by_rotation(p_2, omega, X)
        K, C = slopes(cage.pocket, depth, rate)
        add_contact(
            j,
            wrench(wall, X),
            wrench(p_1, touch),
            wrench(p_2, touch),
            row[WEIGHT] * K,
            row[WEIGHT] * C,
            m,
            N * by_slip,
            N * per_slip,
            k_n,
            k_1,
            k_2,
            y,
        )
        normal, friction = combine(-N, wall, 0.0, wall), combine(-m * N, p_1, 0.0, p_1)
        F = combine(1.0, normal, 1.0, friction)
        add_force(j, F, combine(1.0, cross(X, normal), 1.0, cross(touch, friction)), y)
        turn_moment_arm(j, X, F, y)
