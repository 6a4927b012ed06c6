"""How the force between rollers and a race of ``planar`` changes as they move: exact, in the order of its making.

A contact has three ways to move: its approach along n, its place s over a pit across it, and its slip. With
sigma = 1 at the outer race, -1 at the inner, and n' = n tilted by the pit, the force on the roller is
-sigma Q n' - f tau', and

    dQ = Q_d d(delta) + Q_v dv + Q_s ds + Q_z d(s'),   df = mu dQ + Q (mu_v d(slip) + mu_u du)

while n and tau turn as the roller moves across. What moves is in the rows P (place) and W (velocity), along e_r
and e_theta as the ring's centre sees it; what follows is added to the rows CHANGE.
"""

from math import sqrt
from typing import Any

from bearingsim.core.geometry.plane import from_centre
from bearingsim.core.geometry.sides import InnerSide, OuterSide, sign, totals
from bearingsim.core.jit import generic, jit
from bearingsim.core.laws.damping.interface import normal_force, slopes
from bearingsim.core.laws.friction.interface import mu, mu_slope
from bearingsim.core.layout import (
    BY_INNER,
    BY_OUTER,
    CHANGE_M,
    CHANGE_R,
    CHANGE_SHARED,
    CHANGE_T,
    COS,
    EPS_V,
    F_I,
    F_O,
    M_R,
    N_R,
    P_R,
    P_T,
    POSITION,
    PSI,
    ROW,
    SIN,
    SPIN_V,
    VELOCITY,
    W_R,
    W_T,
    X_I,
    Q,
    V,
    X,
)
from bearingsim.core.pits.excitations import bend, felt
from bearingsim.core.pits.on_roller import outdone, standing
from bearingsim.core.pits.pairs import HALF_WIDTH, ON, ON_INNER, ON_OUTER, OUTER, RADIUS, REDUCED, SIDE, USED, W

# rows of a contact: rate of rho (m/s); how the force (LOAD) and, in a pit, the sideways force (ASIDE) and the mean
# approach grow with approach (D), its rate (V), place (S) and ds/dt (Z); radii (m) of the surface that carries the
# pit: of any, of the ring, of the roller
APART, LOAD_D, LOAD_V, LOAD_S, ASIDE_D, ASIDE_V, ASIDE_S, ASIDE_Z, MEAN_D, MEAN_S, PIT, PIT_RING, PIT_ROLLER = (
    n * ROW for n in range(13)
)
# tilt of the normal: tangent, cosine, sine; 1/force (1/N); arms on roller and ring (m); mu, force times its slopes
# by slip and by rolling speed (N s/m); force on the roller along and across n (N)
LEAN, COS_L, SIN_L, PER_LOAD, ARM, ON_RING, MU, MU_V, MU_U, ALONG_N, ACROSS_N = (n * ROW for n in range(13, 24))
N, RHO, ACROSS = 0, 2 * ROW, 3 * ROW  # rows from N_R or M_R on: n along e_r (and e_theta), rho, speed across n


@generic
def slope_rows(side: Any) -> tuple[int, int, int, int]:
    """Where the rows above begin; rows of n and of the friction; the ring's first shared coordinate."""


@slope_rows.register(OuterSide)
def _slope_rows_outer(side):
    return BY_OUTER, N_R, F_O, X


@slope_rows.register(InnerSide)
def _slope_rows_inner(side):
    return BY_INNER, M_R, F_I, X_I


@jit
def contact_slopes(side, law, y, n):
    """Slopes of every contact with an undamaged race."""
    at, _, _, _ = slope_rows(side)
    _, approach, rate, _, _ = totals(side)
    sigma = sign(side)
    for j in range(n):
        y[at + LOAD_D + j], y[at + LOAD_V + j] = slopes(law, y[approach + j], y[rate + j])
        y[at + APART + j] = sigma * y[rate + j]
        y[at + LOAD_S + j], y[at + MEAN_D + j], y[at + MEAN_S + j] = 0.0, 1.0, 0.0
        y[at + ASIDE_D + j], y[at + ASIDE_V + j], y[at + ASIDE_S + j], y[at + ASIDE_Z + j] = 0.0, 0.0, 0.0, 0.0
        y[at + PIT + j], y[at + PIT_RING + j], y[at + PIT_ROLLER + j] = 0.0, 0.0, 0.0


@jit
def pit_slopes(side, law, pits, d, s, speed, delta, v, y, j):
    """Slopes of the contact of roller ``j`` that stands in meeting ``d``: ``force_over_pit``'s, group by group."""
    at, _, _, _ = slope_rows(side)
    head = pits.head[d]
    load_d, load_v, load_s, mean_d, mean_s = 0.0, 0.0, 0.0, 0.0, 0.0
    aside_d, aside_v, aside_s, aside_z = 0.0, 0.0, 0.0, 0.0
    for k in range(int(head[USED])):
        group = pits.groups[d, k]
        share, h, slope = felt(pits.excitation, group, s, head[REDUCED])
        share_s, slope_s = bend(pits.excitation, group, s, head[REDUCED])
        here, rate, closed = delta - h, v - slope * speed, 1.0 if delta > h else 0.0
        K, C = slopes(law, here, rate)
        weight, force = share * group[W], normal_force(law, here, rate)
        K, C = weight * K, weight * C
        by_s = share_s * group[W] * force - K * slope - C * slope_s * speed
        load_d, load_v, load_s = load_d + K, load_v + C, load_s + by_s
        aside_d, aside_v, aside_z = aside_d + K * slope, aside_v + C * slope, aside_z - C * slope * slope
        aside_s += by_s * slope + weight * force * slope_s
        mean_d += weight * closed
        mean_s += group[W] * closed * (share_s * here - share * slope)
    y[at + LOAD_D + j], y[at + LOAD_V + j], y[at + LOAD_S + j] = load_d, load_v, load_s
    y[at + ASIDE_D + j], y[at + ASIDE_V + j], y[at + ASIDE_S + j] = aside_d, aside_v, aside_s
    y[at + ASIDE_Z + j], y[at + MEAN_D + j], y[at + MEAN_S + j] = aside_z, mean_d, mean_s


@jit
def slopes_over_pits(side, law, model, t, omega_cage, omega_i, spin, y):
    """Correct the slopes of each contact of this side that stands over a pit (``planar.over_pits``)."""
    pits, b, sigma = model.pits, model.bearing, sign(side)
    at, frame, _, shared = slope_rows(side)
    for d in range(len(pits.head)):
        on, radius = pits.head[d, ON], pits.head[d, RADIUS]
        if (pits.head[d, SIDE] == OUTER) == (sigma > 0.0):
            j, s = standing(model, d, t, y)
            if abs(s) < pits.head[d, HALF_WIDTH] and not outdone(model, d, j, s, t, y):
                turning = omega_i if on == ON_INNER else y[VELOCITY + PSI]
                turning = spin + y[SPIN_V + j] if on >= 0.0 else turning
                _, n_r, n_t, short, d_r, d_t = from_centre(
                    y[COS + j],
                    y[SIN + j],
                    0.5 * (b.R_o + b.R_i) + y[Q + j],
                    y[V + j],
                    omega_cage + y[EPS_V + j],
                    y[POSITION + shared],
                    y[POSITION + shared + 1],
                    y[VELOCITY + shared],
                    y[VELOCITY + shared + 1],
                )
                delta, apart = sigma * (y[Q + j] - short) - b.gap, n_r * d_r + n_t * d_t
                speed = radius * (y[frame + ACROSS + j] / y[frame + RHO + j] - turning)
                pit_slopes(side, law, pits, d, s, speed, delta, sigma * apart, y, j)
                y[at + APART + j], y[at + PIT + j] = apart, radius
                y[at + PIT_RING + j] = radius if on == ON_OUTER else 0.0
                y[at + PIT_ROLLER + j] = radius if on >= 0.0 else 0.0


@jit
def rubbing_slopes(side, friction, R_w, omega_cage, spin, y, n):
    """Tilt of the normal, arms and friction of every contact, as they stand."""
    at, frame, rubs, _ = slope_rows(side)
    force, approach, _, slip, tilt = totals(side)
    sigma = sign(side)
    for j in range(n):
        turning = omega_cage + y[EPS_V + j] - spin - y[SPIN_V + j]
        Q, f = y[force + j], y[rubs + j]
        per_load = 1.0 / max(Q, 1e-300)
        per_load = per_load if Q > 0.0 else 0.0
        lean = y[tilt + j] * per_load
        cosine = 1.0 / sqrt(1.0 + lean * lean)
        sine, arm = lean * cosine, R_w - 0.5 * y[approach + j]
        by_slip, by_rolling = mu_slope(friction, y[slip + j], R_w * abs(turning))
        y[at + LEAN + j], y[at + COS_L + j], y[at + SIN_L + j], y[at + PER_LOAD + j] = lean, cosine, sine, per_load
        y[at + ARM + j], y[at + ON_RING + j] = arm, y[frame + RHO + j] * cosine + sigma * arm
        y[at + MU + j] = mu(friction, y[slip + j], R_w * abs(turning))
        y[at + MU_V + j] = Q * by_slip
        y[at + MU_U + j] = Q * by_rolling * (R_w if turning > 0.0 else -R_w)
        y[at + ALONG_N + j] = -sigma * (Q + f * sine)
        y[at + ACROSS_N + j] = y[tilt + j] - f * cosine


@jit
def race_change(side, spin, omega_ring, roll, roll_v, orbit_v, ring, ring_v, y, n):
    """Add to the rows CHANGE what follows from the rows P and W, and from turns: for every roller at once.

    spin, omega_ring: a roller's nominal spin and the ring's speed (rad/s); roll, roll_v: changes of the rollers'
    turning, orbit_v: of their orbit's speed (rolling depends on it), ring, ring_v: of the ring's (rad, rad/s).
    """
    at, frame, rubs, shared = slope_rows(side)
    _, _, _, _, tilt = totals(side)
    sigma = sign(side)
    for j in range(n):
        n_r, n_t, rho, across = y[frame + N + j], y[frame + N + ROW + j], y[frame + RHO + j], y[frame + ACROSS + j]
        p_r, p_t, w_r, w_t = y[P_R + j], y[P_T + j], y[W_R + j], y[W_T + j]
        apart, pit, lean, f = y[at + APART + j], y[at + PIT + j], y[at + LEAN + j], y[rubs + j]
        cosine, sine, arm, on_ring = y[at + COS_L + j], y[at + SIN_L + j], y[at + ARM + j], y[at + ON_RING + j]
        pit_ring, pit_roller = y[at + PIT_RING + j], y[at + PIT_ROLLER + j]

        out, turned = n_r * p_r + n_t * p_t, (n_r * p_t - n_t * p_r) / rho
        apart_1 = n_r * w_r + n_t * w_t + across * turned
        across_1 = n_r * w_t - n_t * w_r - apart * turned
        deep, closing = sigma * out, sigma * apart_1
        along = pit * turned - pit_ring * ring - pit_roller * roll
        passing = pit * (across_1 - across * out / rho) / rho - pit_ring * ring_v - pit_roller * roll_v
        load = y[at + LOAD_D + j] * deep + y[at + LOAD_V + j] * closing
        load += y[at + LOAD_S + j] * along - y[at + ASIDE_V + j] * passing  # Q_z = -S_v, group by group
        aside = y[at + ASIDE_D + j] * deep + y[at + ASIDE_V + j] * closing
        aside += y[at + ASIDE_S + j] * along + y[at + ASIDE_Z + j] * passing

        tilt_1 = (pit * aside - y[tilt + j] * out) / rho
        lean_1 = (tilt_1 - lean * load) * y[at + PER_LOAD + j] * cosine * cosine
        cosine_1, sine_1 = -sine * lean_1, cosine * lean_1
        arm_1 = -0.5 * (y[at + MEAN_D + j] * deep + y[at + MEAN_S + j] * along)
        on_ring_1 = out * cosine + rho * cosine_1 + sigma * arm_1
        slip = across_1 * cosine + across * cosine_1 - ring_v * on_ring - omega_ring * on_ring_1
        slip += sigma * (apart_1 * sine + apart * sine_1 + roll_v * arm + (spin + y[SPIN_V + j]) * arm_1)
        f_1 = y[at + MU + j] * load + y[at + MU_U + j] * (orbit_v - roll_v)
        f_1 += y[at + MU_V + j] * slip

        along_n = -sigma * (load + f_1 * sine + f * sine_1) - y[at + ACROSS_N + j] * turned
        across_n = tilt_1 - f_1 * cosine - f * cosine_1 + y[at + ALONG_N + j] * turned
        push_r, push_t = along_n * n_r - across_n * n_t, along_n * n_t + across_n * n_r
        c, s = y[COS + j], y[SIN + j]
        y[CHANGE_R + j] += push_r
        y[CHANGE_T + j] += push_t
        y[CHANGE_M + j] -= sigma * (f_1 * arm + f * arm_1) + pit_roller * aside
        y[CHANGE_SHARED + shared * ROW + j] += push_t * s - push_r * c
        y[CHANGE_SHARED + (shared + 1) * ROW + j] -= push_r * s + push_t * c
        on_race = f_1 * on_ring + f * on_ring_1 - pit_ring * aside
        y[CHANGE_SHARED + PSI * ROW + j] += on_race if sigma > 0.0 else 0.0
