"""The contacts of ``spatial`` as matrices of wrenches over twists (``parts/wrench.py``): races, flanges, pockets.

Left out: that what an excitation shares changes along a pit, and in flanges products of rates and of how far axes
lean.
"""

from math import sqrt
from typing import Any

from bearingsim.core.geometry.sides import rows_of, sign
from bearingsim.core.geometry.slices import DROP, WEIGHT, ZETA
from bearingsim.core.geometry.vectors import both, cross, dot, mix, turning
from bearingsim.core.jit import generic, jit
from bearingsim.core.laws.damping.interface import normal_force, slopes
from bearingsim.core.laws.friction.interface import mu, mu_slope
from bearingsim.core.layout import (
    APPROACH,
    BENT,
    CE,
    CLOSING,
    FAR,
    GAP,
    GAP_V,
    IN_GAP,
    IN_GAP_V,
    IN_WALL,
    IN_WALL_Z,
    LEAN,
    LOAD,
    LOST,
    OMEGA,
    OUT_R,
    OUT_T,
    OUT_Z,
    OVER,
    OWN,
    PC,
    PS,
    RING_R,
    RING_T,
    ROLLING,
    SE,
    SKEW,
    SKEW_V,
    SLIP_T,
    SLIP_Z,
    SPINS,
    SWINGS,
    TILT,
    TILT_V,
    UPRIGHT,
    UPRIGHT_V,
    WALL,
    WALL_Z,
)
from bearingsim.core.parts.cage import FreeCage, KinematicCage, radial_stop
from bearingsim.core.parts.cage_in_space import CageInPlane, CageInSpace, apart, axial_stop, pocket_axes
from bearingsim.core.parts.cage_slopes import radial_stop_slopes
from bearingsim.core.parts.flanges import Flanges, NoFlanges, chord, seen_from, slip_at
from bearingsim.core.parts.flanges import slopes as approach_slopes
from bearingsim.core.parts.races_in_space import AT_REST, press, stand
from bearingsim.core.parts.wrench import (
    add_contact,
    add_force,
    add_rolling,
    of_roller,
    plus,
    six,
    take,
    turn_arm,
    wrench,
)
from bearingsim.core.pits.on_slices import FELT, bend_at, find_pits, leave_pits, over_pits

NONE, STILL = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@jit
def rubbing(friction, slip, drift, u):
    """mu, its slopes by slip and rolling (s/m), mu over the slip's speed (s/m), and the slip's direction."""
    speed = sqrt(slip * slip + drift * drift + AT_REST * AT_REST)
    value = mu(friction, speed, u)
    by_slip, by_rolling = mu_slope(friction, speed, u)
    return value, by_slip, by_rolling, value / speed, slip / speed, drift / speed


@jit
def axis_of(y, j):
    """A roller's axis along e_r, e_theta, e_z."""
    return y[TILT + j], y[SKEW + j], y[UPRIGHT + j]


@jit
def seen_by(body, bearing, omega_cage, y, j):
    """A roller as a body sees it that moves and turns: place (m), velocity (m/s), angular velocity (rad/s)."""
    c, s = y[PC + j] * y[CE + j] - y[PS + j] * y[SE + j], y[PS + j] * y[CE + j] + y[PC + j] * y[SE + j]
    d_r, d_t, d_z, v_r, v_t, v_z = apart(bearing, body, omega_cage, y, j)
    a = axis_of(y, j)
    own = both(1.0, cross(a, (y[TILT_V + j], y[SKEW_V + j], y[UPRIGHT_V + j])), y[OMEGA + j], a)
    return (d_r, d_t, d_z), (v_r, v_t, v_z), both(1.0, own, -1.0, turning(body, c, s))


@jit
def swung(d, omega, X):
    """How the rate along ``d`` of a point at ``X`` from the centre changes as the roller turns (six-vector)."""
    m = cross(X, cross(d, omega))
    return 0.0, 0.0, 0.0, m[0], m[1], m[2]


@jit
def touch_race(side, law, model, t, ring, b_z_outer, b_z_inner, omega_cage, y, n):
    """Add all slices' contacts with a race to the matrices, from the rows that ``face`` filled.

    b_z_outer, b_z_inner: third components of the rings' axes.
    """
    b, table = model.bearing, model.slices.table
    met = find_pits(model, t, b_z_outer, b_z_inner, y) if len(model.pits.head) > 0 else 0
    for k in range(len(table)):
        if met > 0:
            over_pits(model, t, k, 1.0, b_z_outer, b_z_inner, y)
        stand(side, b, ring, table[k, ZETA], table[k, DROP], y, n)
        press(side, law, model.friction, table[k, WEIGHT], y, n)
        for j in range(b.Z):
            if y[rows_of(side) + LOAD + j] > 0.0:
                touch_slice(side, law, model, t, ring, omega_cage, k, y, j)
    if met > 0:
        leave_pits(model, y)


@jit
def touch_slice(side, law, model, t, ring, omega_cage, k, y, j):
    """Add the contact of slice ``k`` of roller ``j``, as ``stand`` and ``press`` left it."""
    at, sigma, row, a = rows_of(side), sign(side), model.slices.table[k], axis_of(y, j)
    b = y[at + RING_R + j], y[at + RING_T + j], ring.a_z
    n, rho, lean = (y[at + OUT_R + j], y[at + OUT_T + j], y[at + OUT_Z + j]), y[at + FAR + j], y[at + LEAN + j]
    tau, cosine, delta = cross(b, n), 1.0 - y[at + BENT + j], y[at + APPROACH + j]
    sine, arm = sigma * lean * cosine, sigma * (model.bearing.R_w - row[DROP] - 0.5 * delta)
    e, out, g = both(cosine, tau, sine, n), both(cosine, n, -sine, tau), both(sigma, n, -lean, tau)
    X = row[ZETA] * a[0], row[ZETA] * a[1], row[ZETA] * a[2]
    touch, own = both(1.0, X, arm, out), y[at + OWN + j] * rho  # a roller's own pit goes round with it
    aside, about = wrench(tau, X), six(NONE, b)
    w_n, w_e, w_b = plus(1.0, wrench(g, X), own * lean, about), wrench(e, touch), wrench(b, touch)

    _, v, omega = seen_by(ring, model.bearing, omega_cage, y, j)
    v_p, v_touch = both(1.0, v, 1.0, cross(omega, X)), both(1.0, v, 1.0, cross(omega, touch))
    across, turned = dot(tau, v_p), plus(1.0 / rho, aside, 0.0, aside)  # of n, by place; of the normal, next
    tilted, bends = STILL, STILL
    k_n = plus(1.0, swung(g, omega, X), sigma * across + lean * dot(n, v_p), turned)
    if y[at + OVER + j] == FELT:
        bent, radius = bend_at(model, t, k, sigma > 0.0, ring.a_z, y, j)
        passes = plus(radius / rho, aside, -radius / rho * own, about)  # s, by place
        bends = plus(bent, passes, 0.0, passes)
        tilted = plus(radius / rho, bends, -lean / rho, wrench(n, X))
        k_n = plus(1.0, k_n, -radius * (across / rho - y[at + OWN + j] * dot(omega, b)), bends)
        k_n = plus(1.0, k_n, lean * across / rho, wrench(n, X))
        add_pit(j, y[at + LOAD + j], aside, tilted, radius * own / rho, about, bends, y)
    leant = plus(1.0, turned, -sigma * cosine * cosine, tilted)
    k_e = plus(1.0, swung(e, omega, X), -dot(out, v_touch), leant)
    k_b = plus(1.0, swung(b, omega, X), arm * dot(b, cross(omega, e)), leant)
    shrinks = plus(-0.5 * sigma, w_n, 0.0, w_n)  # the arm, by place
    round_out = cross(omega, out)
    k_e, k_b = plus(1.0, k_e, dot(e, round_out), shrinks), plus(1.0, k_b, dot(b, round_out), shrinks)

    K, C = slopes(law, delta, y[at + CLOSING + j])
    kept, load = row[WEIGHT] * (1.0 - y[at + LOST + j]), y[at + LOAD + j]
    m, by_slip, by_rolling, per_slip, p, q = rubbing(
        model.friction, y[at + SLIP_T + j], y[at + SLIP_Z + j], y[ROLLING + j]
    )
    w_1, w_2, k_1, k_2 = plus(p, w_e, q, w_b), plus(-q, w_e, p, w_b), plus(p, k_e, q, k_b), plus(-q, k_e, p, k_b)
    add_contact(j, w_n, w_1, w_2, kept * K, kept * C, m, load * by_slip, load * per_slip, k_n, k_1, k_2, y)
    add_rolling(j, w_1, load * by_rolling, y)

    f, f_b = m * load * p, m * load * q
    normal, friction = (-load * g[0], -load * g[1], -load * g[2]), both(-f, e, -f_b, b)
    loads = plus(load, wrench(both(sigma, tau, lean, n), X), 0.0, w_n)
    rubs = plus(-f, wrench(out, touch), arm * f_b, six(NONE, cross(e, b)))  # the touching point goes round too
    take(of_roller(j), loads, turned, rubs, leant, six(NONE, cross(friction, out)), shrinks, y)
    M = both(1.0, cross(X, normal), 1.0, cross(touch, friction))
    F = both(1.0, normal, 1.0, friction)
    add_force(j, F, both(1.0, M, -own * lean * load, b), y)
    turn_arm(j, X, F, y)


@jit
def add_pit(j, load, aside, tilted, carried, about, bends, y):
    """How the force (N) on a pit's edge turns as the edge bends; carried: radius (m) of an own pit, or 0."""
    of_own = plus(carried * load, about, 0.0, about)
    take(of_roller(j), plus(-load, aside, 0.0, aside), tilted, of_own, bends, STILL, STILL, y)


# Flanges


@generic
def touch_flanges(flanges: Any, side: Any, model: Any, ring: Any, omega_cage: float, y: Any) -> None:
    """Add the contacts of the rollers' ends with a ring's flanges."""


@touch_flanges.register(NoFlanges)
def _touch_flanges_none(flanges, side, model, ring, omega_cage, y):
    return None


@touch_flanges.register(Flanges)
def _touch_flanges(flanges, side, model, ring, omega_cage, y):
    outer, t = sign(side) > 0.0, chord(model.bearing.R_w, flanges.height)
    minus = flanges.outer_minus if outer else flanges.inner_minus
    beyond = flanges.outer_plus if outer else flanges.inner_plus
    for sigma, there in ((-1.0, minus), (1.0, beyond)):
        for j in range(model.bearing.Z if there > 0.0 else 0):
            for way in (-t, t):
                touch_end(side, flanges, model, ring, omega_cage, sigma, way, y, j)


@jit
def touch_end(side, flanges, model, ring, omega_cage, sigma, t, y, j):
    """One point of roller ``j`` on the side ``sigma``, ``t`` (m) along the race (``flanges.one_point``)."""
    b, half = model.bearing, 0.5 * model.L_w
    face = b.R_o - 0.5 * flanges.height if sign(side) > 0.0 else b.R_i + 0.5 * flanges.height
    view = seen_from(side, b, ring, y, j)
    q = face - view.rho
    Y = mix(sigma * (half + flanges.play) - view.off, view.b, q, view.n, t, view.tau)
    g, tips = approach_slopes(view, sigma, q, t)
    depth, rate = half - sigma * dot(Y, view.a), dot(g, view.moves) - sigma * dot(Y, tips)
    N = normal_force(flanges.law, depth, rate)
    if N > 0.0:
        slip, rolls = slip_at(view, ring, Y, tips, y[OMEGA + j])
        m, by_slip, _, per_slip, _, _ = rubbing(flanges.friction, slip[3], 0.0, b.R_w * rolls)
        p_1 = slip[0] / slip[3], slip[1] / slip[3], slip[2] / slip[3]
        p_2, (K, C) = cross(view.a, p_1), slopes(flanges.law, depth, rate)
        w_n = six(g, cross(Y, (sigma * view.a[0], sigma * view.a[1], sigma * view.a[2])))
        _, v, omega = seen_by(ring, b, omega_cage, y, j)
        swings = both(q / view.rho, view.tau, -t / view.rho, view.n)  # the point as the roller goes round
        nods = mix(dot(v, view.b), view.b, dot(v, view.n), view.n, -dot(v, view.tau), swings)
        nods = cross(view.a, both(sigma, nods, -sigma, cross(Y, omega)))
        k_1, k_2 = slides(view, Y, p_1, v, omega, swings), slides(view, Y, p_2, v, omega, swings)
        w_1, w_2 = wrench(p_1, Y), wrench(p_2, Y)
        add_contact(j, w_n, w_1, w_2, K, C, m, N * by_slip, N * per_slip, six(NONE, nods), k_1, k_2, y)
        turn_end(j, view, sigma * N, m * N, Y, p_1, swings, y)
        F = both(-N, g, -m * N, p_1)
        add_force(j, F, cross(Y, both(-m * N, p_1, -N * sigma, view.a)), y)


@jit
def slides(view, Y, p, v, omega, swings):
    """How the slip along ``p`` changes with the place alone: the point moves, the end's plane tips."""
    whirl, past = cross(p, omega), -dot(both(1.0, v, 1.0, cross(omega, Y)), view.a)
    moves = mix(-dot(view.b, whirl), view.b, -dot(view.n, whirl), view.n, dot(swings, whirl), view.tau)
    tips = cross(view.a, p)
    return six(moves, (past * tips[0], past * tips[1], past * tips[2]))


@jit
def turn_end(j, view, load, rub, Y, p_1, swings, y):
    """How the forces at a flange turn: load, rub: along the roller's axis and the slip (N)."""
    at, b, n, a = of_roller(j), view.b, view.n, view.a
    tau, G = view.tau, both(-load, a, -rub, p_1)
    by_b, by_n, by_tau = six(NONE, cross(a, b)), six(NONE, cross(a, n)), six(NONE, cross(swings, a))
    f_b, f_n, f_tau = both(load, b, 0.0, b), both(load, n, 0.0, n), both(load, tau, 0.0, tau)
    take(at, six(f_b, NONE), by_b, six(f_n, NONE), by_n, six(f_tau, NONE), by_tau, y)
    m_b, m_n, m_tau = six(NONE, cross(b, G)), six(NONE, cross(n, G)), six(NONE, cross(G, swings))
    take(at, m_b, six(b, NONE), m_n, six(n, NONE), m_tau, six(tau, NONE), y)
    plane, turned = wrench(a, Y), six(NONE, cross(a, p_1))
    take(at, plus(-rub, plane, 0.0, plane), turned, STILL, STILL, STILL, STILL, y)
    turn_arm(j, (load * a[0], load * a[1], load * a[2]), Y, y)  # the load is along the axis


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
def touch_pockets(cage: Any, model: Any, body: Any, omega_cage: float, spin: float, y: Any) -> None:
    """Add the contacts of the rollers with their pockets, from the rows that ``face_walls`` filled."""


@touch_pockets.register(KinematicCage)
def _touch_pockets_kinematic(cage, model, body, omega_cage, spin, y):
    return None


@touch_pockets.register(FreeCage)
def _touch_pockets_free(cage, model, body, omega_cage, spin, y):
    b, table = model.bearing, model.slices.table
    for j in range(b.Z):
        d, _, omega = seen_by(body, b, omega_cage, y, j)
        rad, w, leans, _ = pocket_axes(body, y[PC + j], y[PS + j], y[CE + j], y[SE + j])
        axis = leans[0], leans[1], body.a_z
        if abs(y[GAP + j]) + 0.5 * model.L_w * abs(y[IN_GAP + j]) > cage.play:
            for k in range(len(table)):
                touch_wall(cage, b.R_w, b.R_w * abs(spin), table[k], rad, w, axis, omega, y, j)
        out, aside = dot(d, rad) - 0.5 * (b.R_o + b.R_i), dot(d, axis)
        K, C = radial_stop_slopes(cage.guide, out, y[WALL + j])
        stop(j, rad, -K, -C, radial_stop(cage.guide, out, y[WALL + j]), y)
        K, C = axial_stop_slopes(model.cage_z, aside, y[WALL_Z + j])
        stop(j, axis, -K, -C, axial_stop(model.cage_z, aside, y[WALL_Z + j]), y)


@jit
def stop(j, way, K, C, force, y):
    """A stop of a pocket, along ``way`` (3,) at the roller's centre; force: that way (N)."""
    if force != 0.0:
        add_contact(j, six(way, NONE), STILL, STILL, K, C, 0.0, 0.0, 0.0, STILL, STILL, STILL, y)
        add_force(j, (force * way[0], force * way[1], force * way[2]), NONE, y)


@jit
def touch_wall(cage, R_w, u, row, rad, w, axis, omega, y, j):
    """One slice (``row`` of the table) of roller ``j`` on its pocket's wall (``cage_in_space.wall_slice``)."""
    zeta, radius, a = row[ZETA], R_w - row[DROP], axis_of(y, j)
    e = y[GAP + j] + zeta * y[IN_GAP + j]
    side = 1.0 if e > 0.0 else -1.0
    depth, rate = abs(e) - cage.play, side * (y[GAP_V + j] + zeta * y[IN_GAP_V + j])
    N = row[WEIGHT] * normal_force(cage.pocket, depth, rate)
    if N > 0.0:
        slip = y[WALL + j] + zeta * y[IN_WALL + j] - side * radius * y[SPINS + j]
        drift = y[WALL_Z + j] + zeta * y[IN_WALL_Z + j] + side * radius * y[SWINGS + j]
        m, by_slip, _, per_slip, p, q = rubbing(cage.friction, slip, drift, u)
        X = zeta * a[0], zeta * a[1], zeta * a[2]
        touch = both(1.0, X, side * radius, w)
        wall, p_1, p_2 = (side * w[0], side * w[1], side * w[2]), both(p, rad, q, axis), both(-q, rad, p, axis)
        k_n, k_1, k_2 = swung(wall, omega, X), swung(p_1, omega, X), swung(p_2, omega, X)
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
        normal, friction = both(-N, wall, 0.0, wall), both(-m * N, p_1, 0.0, p_1)
        F = both(1.0, normal, 1.0, friction)
        add_force(j, F, both(1.0, cross(X, normal), 1.0, cross(touch, friction)), y)
        turn_arm(j, X, F, y)
