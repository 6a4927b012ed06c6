"""``planar``: rings, rollers and cage move freely in the plane; friction drives the rollers, slip comes out.

Per roller: radial displacement q, angle eps from the middle of its own pocket, and spin; besides, the ring in x
and y (and its rotation, on a torsion spring), the cage's rotation and centre, the inner ring's on its shaft. With
rho = |c_j - u| the distance of a roller from the ring's centre, n from there to the roller, tau across it,

    delta_o = rho + R_w - R_o - h(s),   s = R_o (angle of n - psi - phi_d),   force on the roller  -Q_o (n + g tau)

where g = -h'(s) R_o/rho: at a pit the contact's normal tilts, so that its edge pushes the roller along. Likewise
at the inner race. Slip at a contact is the speed of the roller's surface over the race's, across the normal that a
pit tilts, the roller's arm being R_w - delta/2, and the friction -mu(slip) Q. No small angle is taken for u: the
linear approach q - u.e_r would do work on a closed path. Angles and turns are kept beyond their kinematic values,
so no digits are lost.

Left out: tilt, skew and axial motion of rollers, the bending of rings and cage, oil films as springs.
"""

from math import atan2, sqrt
from typing import Any, NamedTuple

from bearingsim.core.geometry.motion import elapsed
from bearingsim.core.geometry.plane import approach, place
from bearingsim.core.geometry.sides import InnerSide, OuterSide, frame, sign, totals
from bearingsim.core.jit import add, jit
from bearingsim.core.laws.damping.interface import damping_bound, normal_force, stiffness_bound
from bearingsim.core.laws.friction.interface import mu, steepest
from bearingsim.core.laws.friction.lag import lagged, rub
from bearingsim.core.layout import (
    ACCELERATION,
    APART_I,
    APART_O,
    COS,
    DELTA_I,
    DELTA_O,
    EPS,
    EPS_A,
    EPS_V,
    F_I,
    F_O,
    F_X,
    F_X_I,
    F_Y,
    F_Y_I,
    INVERSE_MASS,
    LANES,
    M_R,
    M_RING,
    M_T,
    N_R,
    N_T,
    PHI_C,
    POSITION,
    PSI,
    PUSH_R,
    PUSH_T,
    Q_I,
    Q_O,
    RHO_I,
    RHO_O,
    ROW,
    SIN,
    SLIP_I,
    SLIP_O,
    SPIN,
    SPIN_A,
    SPIN_V,
    T_I,
    T_O,
    TILT_I,
    TILT_O,
    TORQUE,
    V_I,
    V_O,
    VELOCITY,
    A,
    Q,
    V,
)
from bearingsim.core.models.extremes import keep_forces
from bearingsim.core.models.interface import (
    ModelKind,
    accelerations,
    begin,
    damping_per_mass,
    freedoms,
    keep_extremes,
    linearise,
    stiffness_per_mass,
    watched,
    width,
)
from bearingsim.core.models.outer_ring import move_outer_ring
from bearingsim.core.models.planar_derivatives import differentiate
from bearingsim.core.parameters import Bearing, Support, lanes
from bearingsim.core.parts.cage import drive_cage, let_go, orbit_drag, pocket_stiffness, pockets
from bearingsim.core.parts.shaft import held_damping, held_stiffness, move_inner_ring, rotate_ring
from bearingsim.core.pits.jumps import next_cusp, next_cusp_freely
from bearingsim.core.pits.on_roller import correct_contact, outdone, standing
from bearingsim.core.pits.pairs import HALF_WIDTH, ON, ON_INNER, OUTER, RADIUS, SIDE, Pits, meeting

AT_REST = 1e-12  # m/s: slip below it is none, and friction over slip the curve's slope


class Planar(NamedTuple):
    """Parameters of the model.

    outer, inner: contact laws at the races; motion: ``geometry/motion.py``; friction: at the races
    (``laws/friction``); cage, drag: ``parts/cage.py``; shaft, bracket: ``parts/shaft.py``; gravity: m/s^2 along
    e_0, on rollers and cage (a ring's weight is part of its load); lag: of friction, s (``friction/lag.py``).
    """

    bearing: Bearing
    support: Support
    outer: Any
    inner: Any
    pits: Pits
    motion: Any
    friction: Any
    cage: Any
    drag: Any
    shaft: Any
    bracket: Any
    gravity: float
    lag: float = 0.0


@width.register(Planar)
def _width(model):
    return 2 * ROW + LANES + lanes(model.bearing)


@watched.register(Planar)
def _watched(model):
    return model.bearing.Z


next_cusp.register(Planar)(next_cusp_freely)


@standing.register(Planar)
def _standing(model, d, t, y):
    """From where rollers, rings and cage are, and the rows that ``approach`` fills."""
    b, head = model.bearing, model.pits.head[d]
    time, _, _ = elapsed(model.motion, t)
    turned = b.omega_c * time + y[POSITION + PHI_C]
    own, outer = head[ON] >= 0.0, head[SIDE] == OUTER
    roll = turned - (b.omega_c - b.omega_b) * time - (y[SPIN + int(head[ON])] if own else 0.0)
    j, s = meeting(model.pits, d, b.theta_0 + turned, b.omega_i * time, roll, b.Z)
    tilted = atan2(y[N_T + j], y[N_R + j]) if outer else atan2(y[M_T + j], y[M_R + j])
    return j, s + head[RADIUS] * (y[EPS + j] + tilted - (y[POSITION + PSI] if outer and not own else 0.0))


@jit
def over_pits(model, t, omega_i, spin, y):
    """Correct the contact of each roller that stands over a pit: force, tilt of the normal, torques.

    spin: a roller's nominal spin (rad/s). Returns the torque (N m) of the pits on the outer ring.
    """
    pits = model.pits
    torque = 0.0
    for d in range(len(pits.head)):
        on, radius = pits.head[d, ON], pits.head[d, RADIUS]
        own, outer = on >= 0.0, pits.head[d, SIDE] == OUTER
        j, s = standing(model, d, t, y)
        if abs(s) < pits.head[d, HALF_WIDTH] and not outdone(model, d, j, s, t, y):
            turning = y[VELOCITY + PSI]
            if own:
                turning = spin + y[SPIN_V + j]
            elif on == ON_INNER:
                turning = omega_i
            if outer:
                sideways = tilt_contact(OuterSide(), model.outer, pits, d, j, s, turning, y)
                torque -= 0.0 if own else sideways * radius
            else:
                sideways = tilt_contact(InnerSide(), model.inner, pits, d, j, s, turning, y)
            if own:
                y[TORQUE + j] -= sideways * radius
    return torque


@jit
def tilt_contact(side, law, pits, d, j, s, turning, y):
    """Correct one contact, whose pit turns at ``turning`` (rad/s), and tilt its normal.

    Returns the sideways part (N) of its force.
    """
    (_, _, rho, across, apart), (_, _, rate, _, tilt), radius = frame(side), totals(side), pits.head[d, RADIUS]
    y[apart + j] = sign(side) * y[rate + j]
    speed = radius * (y[across + j] / y[rho + j] - turning)
    sideways = correct_contact(side, law, pits, d, j, s, speed, y)
    y[tilt + j] = sideways * radius / y[rho + j]
    return sideways


@jit
def push_rollers(model, omega_cage, omega_i, spin, y, n):
    """Slip, friction and drag of every roller: fills PUSH_R, PUSH_T, TORQUE and the cells of both rings."""
    b, friction, drag, g = model.bearing, model.friction, model.drag, model.gravity
    R_w, middle, psi_v = b.R_w, 0.5 * (b.R_o + b.R_i), y[VELOCITY + PSI]
    along, across = model.lag * (1.0 / b.m_r + R_w * R_w / b.I_r), model.lag * (1.0 / b.m_r - R_w * R_w / b.I_r)
    f_x, f_y, torque, i_x, i_y = 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(n):
        c, s = y[COS + j], y[SIN + j]
        real = b.m_r * y[INVERSE_MASS + j]  # 1, and 0 in a padded lane
        beta_v = spin + y[SPIN_V + j]
        theta_v = omega_cage + y[EPS_V + j]
        u = R_w * abs(theta_v - beta_v)  # surfaces through a contact that moves with the roller's centre

        arm_o, arm_i = R_w - 0.5 * y[DELTA_O + j], R_w - 0.5 * y[DELTA_I + j]
        lean_o = y[TILT_O + j] / max(y[Q_O + j], 1e-300)  # of the normal against n, in a pit; its sine and cosine
        lean_i = y[TILT_I + j] / max(y[Q_I + j], 1e-300)
        cos_o, cos_i = 1.0 / sqrt(1.0 + lean_o * lean_o), 1.0 / sqrt(1.0 + lean_i * lean_i)
        sin_o, sin_i = lean_o * cos_o, lean_i * cos_i
        on_o, on_i = y[RHO_O + j] * cos_o + arm_o, y[RHO_I + j] * cos_i - arm_i  # arms on the rings
        s_o = y[T_O + j] * cos_o + y[APART_O + j] * sin_o + beta_v * arm_o - psi_v * on_o
        s_i = y[T_I + j] * cos_i - y[APART_I + j] * sin_i - beta_v * arm_i - omega_i * on_i
        y[SLIP_O + j], y[SLIP_I + j] = s_o, s_i
        s_o += AT_REST if s_o > 0.0 else -AT_REST
        s_i += AT_REST if s_i > 0.0 else -AT_REST
        k_o, k_i = mu(friction, s_o, u) * y[Q_O + j] / s_o, mu(friction, s_i, u) * y[Q_I + j] / s_i
        f_o, f_i = rub(k_o, k_i, s_o, s_i, along, across)

        along_n, across_n = -y[Q_O + j] - f_o * sin_o, y[TILT_O + j] - f_o * cos_o
        o_r = along_n * y[N_R + j] - across_n * y[N_T + j]
        o_t = along_n * y[N_T + j] + across_n * y[N_R + j]
        along_n, across_n = y[Q_I + j] + f_i * sin_i, y[TILT_I + j] - f_i * cos_i
        i_r = along_n * y[M_R + j] - across_n * y[M_T + j]
        i_t = along_n * y[M_T + j] + across_n * y[M_R + j]
        y[F_O + j], y[F_I + j] = f_o, f_i
        torque = add(torque, real * f_o * on_o)

        weight = g * b.m_r
        y[PUSH_R + j] = o_r + i_r + weight * c
        y[PUSH_T + j] = o_t + i_t - weight * s + orbit_drag(drag, theta_v * (middle + y[Q + j]))
        y[TORQUE + j] += f_i * arm_i - f_o * arm_o
        f_x = add(f_x, -o_r * c + o_t * s)
        f_y = add(f_y, -o_r * s - o_t * c)
        i_x = add(i_x, -i_r * c + i_t * s)
        i_y = add(i_y, -i_r * s - i_t * c)
    y[F_X], y[F_Y], y[F_X_I], y[F_Y_I] = f_x, f_y, i_x, i_y
    return torque


@jit
def move_rollers(model, omega_cage, alpha_cage, alpha_spin, y, n):
    """q'' = r theta'^2 + F_r/m,  theta'' = (F_theta/m - 2 q' theta')/r,  spin'' = M/I."""
    b, cage = model.bearing, model.cage
    middle = 0.5 * (b.R_o + b.R_i)
    for j in range(n):
        per_mass = y[INVERSE_MASS + j]
        real = b.m_r * per_mass
        r, theta_v = middle + y[Q + j], omega_cage + y[EPS_V + j]
        y[A + j] = real * r * theta_v * theta_v + per_mass * y[PUSH_R + j]
        theta_a = (per_mass * y[PUSH_T + j] - 2.0 * y[V + j] * theta_v) / r
        y[EPS_A + j] = let_go(cage, real * (theta_a - alpha_cage))
        y[SPIN_A + j] = let_go(cage, real * (y[TORQUE + j] / b.I_r - alpha_spin))


@accelerations.register(Planar)
def _accelerations(model, t, y):
    b = model.bearing
    n = lanes(b)
    time, rate, growth = elapsed(model.motion, t)
    theta_i, omega_i = b.omega_i * time, b.omega_i * rate
    omega_cage = b.omega_c * rate + y[VELOCITY + PHI_C]
    spin = (b.omega_c - b.omega_b) * rate
    place(b.theta_0 + b.omega_c * time + y[POSITION + PHI_C], y, n)
    approach(OuterSide(), b, omega_cage, y, n)
    approach(InnerSide(), b, omega_cage, y, n)
    for j in range(n):
        y[TORQUE + j] = 0.0
        y[Q_O + j] = normal_force(model.outer, y[DELTA_O + j], y[V_O + j])
        y[Q_I + j] = normal_force(model.inner, y[DELTA_I + j], y[V_I + j])
    torque = 0.0
    if len(model.pits.head) > 0:
        torque = over_pits(model, t, omega_i, spin, y)
    y[M_RING] = torque + push_rollers(model, omega_cage, omega_i, spin, y, n)
    pockets(model.cage, model, omega_cage, spin, y, n)
    alpha_cage = drive_cage(model.cage, model, omega_cage, omega_i, b.omega_c * growth, y)
    y[ACCELERATION + PHI_C] = alpha_cage - b.omega_c * growth
    move_rollers(model, omega_cage, alpha_cage, (b.omega_c - b.omega_b) * growth, y, n)
    move_outer_ring(model, y)
    rotate_ring(model.bracket, y)
    move_inner_ring(model.shaft, model, theta_i, omega_i, b.omega_i * growth, y)


@begin.register(Planar)
def _begin(model, t, y):
    accelerations(model, t, y)


keep_extremes.register(Planar)(keep_forces)


@stiffness_per_mass.register(Planar)
def _stiffness_per_mass(model, y, j):
    """The roller's between its races, or of its pocket, or of what holds the rings: the largest."""
    outer = stiffness_bound(model.outer, max(y[DELTA_O + j], 0.0), y[V_O + j])
    inner = stiffness_bound(model.inner, max(y[DELTA_I + j], 0.0), y[V_I + j])
    held = max(held_stiffness(model.shaft), held_stiffness(model.bracket))
    return max(y[INVERSE_MASS + j] * (outer + inner), held, pocket_stiffness(model.cage, y[INVERSE_MASS + j]))


@damping_per_mass.register(Planar)
def _damping_per_mass(model, y, j):
    """Radial damping, or that of what holds the rings, or of friction on slip (see ``rub``): the largest."""
    outer = damping_bound(model.outer, max(y[DELTA_O + j], 0.0), y[V_O + j])
    inner = damping_bound(model.inner, max(y[DELTA_I + j], 0.0), y[V_I + j])
    b = model.bearing
    pressed = max(y[Q_O + j], y[Q_I + j]) * 2.0 * b.R_w * b.R_w / b.I_r
    rubbing = steepest(model.friction, b.R_w * b.omega_b) * pressed
    held = max(held_damping(model.shaft), held_damping(model.bracket))
    return max(y[INVERSE_MASS + j] * (outer + inner), held, lagged(rubbing, model.lag))


@freedoms.register(Planar)
def _freedoms(model):
    return 3, 8


@linearise.register(Planar)
def _linearise(model, t, y):
    differentiate(model, t, y)


KIND = ModelKind(Planar, per_crossing=100)
