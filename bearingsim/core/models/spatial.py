"""``spatial``: every body with its six coordinates; sliced rollers that tilt, skew and move along the axis.

As ``planar``. Besides, each roller moves along the bearing's axis and turns about two more; so do the rings and
the cage where they are free to. A roller's contact with a race is the sum over its slices
(``parts/races_in_space.py``). Its axis moves as that of a symmetric top (``geometry/orientation.py``). In
components along e_r, e_theta, e_z of its own angle,

    q'' = r theta'^2 + F_r/m,  theta'' = (F_theta/m - 2 q' theta')/r,  z'' = F_z/m
    omega' = M.a/I_a,  a'' = [(M - I_a omega a') x a]/I_t - |a'|^2 a

Where nothing leans, and no pit tilts, all that is new stays zero and the rest is ``planar`` to rounding.

Left out: the bending of rollers, rings and cage; that a tilted slice is an ellipse in the contact's plane
(R_w (1 - cos tilt): 3 nm at 1 mrad); the moments of a cage's guide; oil films as springs.
"""

from typing import Any, NamedTuple

from bearingsim.core.geometry.motion import elapsed
from bearingsim.core.geometry.orientation import body_at, tip, upright, winding
from bearingsim.core.geometry.plane import place
from bearingsim.core.geometry.sides import InnerSide, OuterSide
from bearingsim.core.geometry.slices import DROP, WEIGHT, ZETA, Slices
from bearingsim.core.jit import jit
from bearingsim.core.laws.damping.interface import damping_bound, stiffness_bound
from bearingsim.core.laws.friction.interface import steepest
from bearingsim.core.laws.friction.lag import lagged
from bearingsim.core.layout import (
    ACCELERATION,
    APPROACH_I,
    APPROACH_O,
    AXIAL_A,
    AXIS_X,
    AXIS_X_A,
    AXIS_X_V,
    AXIS_Y,
    AXIS_Y_A,
    AXIS_Y_V,
    COS,
    EPS_A,
    EPS_V,
    F_X,
    F_X_I,
    F_Y,
    F_Y_I,
    F_Z,
    F_Z_I,
    INNER_SIDE,
    INVERSE_MASS,
    LANES,
    LEAN_X,
    LEAN_X_I,
    LEAN_Y,
    LEAN_Y_I,
    M_C,
    M_RING,
    M_X,
    M_X_C,
    M_X_I,
    M_Y,
    M_Y_C,
    M_Y_I,
    OMEGA,
    OUTER_SIDE,
    PHI_C,
    POSITION,
    PSI,
    PUSH_R,
    PUSH_T,
    PUSH_Z,
    Q_I,
    Q_O,
    ROLLING,
    ROW,
    RUB_F,
    RUB_P,
    SIN,
    SKEW,
    SKEW_V,
    SPIN_A,
    SPIN_V,
    TILT,
    TILT_MAX,
    TILT_V,
    TURN_R,
    TURN_T,
    TURN_Z,
    UPRIGHT,
    UPRIGHT_V,
    V_I,
    V_O,
    VELOCITY,
    X_I,
    Z_I,
    A,
    Q,
    V,
    X,
    Z,
    slice_row,
)
from bearingsim.core.models.extremes import keep_largest_forces
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
from bearingsim.core.models.spatial_derivatives import differentiate_in_space
from bearingsim.core.parameters import Bearing, Support, lanes
from bearingsim.core.parts.cage import drive_cage, let_go, orbit_drag, pocket_stiffness
from bearingsim.core.parts.cage_in_space import axial_stiffness, cage_body, lean_cage, pockets_in_space
from bearingsim.core.parts.flanges import flange_stiffness, guide_axially
from bearingsim.core.parts.mounts import hold, mount_damping, mount_stiffness, move_mounted
from bearingsim.core.parts.races_in_space import (
    add_up,
    clear,
    face,
    gather,
    keep_line_load,
    keep_slice,
    press,
    relax,
    rub,
    stand,
)
from bearingsim.core.parts.shaft import held_damping, held_stiffness, move_inner_ring, rotate_ring
from bearingsim.core.pits.jumps import next_cusp, next_cusp_freely
from bearingsim.core.pits.on_roller import standing
from bearingsim.core.pits.on_slices import find_pits, leave_pits, met_at, over_pits, seen_at
from bearingsim.core.pits.pairs import OUTER, RADIUS, SIDE, Pits


class Spatial(NamedTuple):
    """Parameters of the model: those of ``Planar``, then

    slices: how a roller is cut (``geometry/slices.py``); L_w: its length (m); I_t: its moment of inertia about a
    diameter (kg m^2); mount_o, mount_i: of the rings (``parts/mounts.py``); flanges: ``parts/flanges.py``; cage_z:
    ``parts/cage_in_space.py``; lag: of friction, s.
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
    slices: Slices
    L_w: float
    I_t: float
    mount_o: Any
    mount_i: Any
    flanges: Any
    cage_z: Any
    lag: float = 0.0


@width.register(Spatial)
def _width(model):
    return 5 * ROW + LANES + lanes(model.bearing)


@watched.register(Spatial)
def _watched(model):
    return model.bearing.Z


@jit
def orient(spin, omega_cage, R_w, y, n):
    """Every roller's axis along e_r, e_theta and e_z, its rate, and the speed about it."""
    for j in range(n):
        c, s = y[COS + j], y[SIN + j]
        a_x, a_y, w_x, w_y = y[AXIS_X + j], y[AXIS_Y + j], y[AXIS_X_V + j], y[AXIS_Y_V + j]
        a_z = upright(a_x, a_y)
        y[TILT + j], y[SKEW + j], y[UPRIGHT + j] = a_x * c + a_y * s, a_y * c - a_x * s, a_z
        y[TILT_V + j], y[SKEW_V + j] = w_x * c + w_y * s, w_y * c - w_x * s
        y[UPRIGHT_V + j] = -(a_x * w_x + a_y * w_y) / a_z
        y[OMEGA + j] = spin + y[SPIN_V + j] + winding(a_x, a_y, a_z, w_x, w_y)
        y[ROLLING + j] = R_w * abs(omega_cage + y[EPS_V + j] - y[OMEGA + j])


@jit
def weigh(model, omega_cage, y, n):
    """What acts on every roller but contacts: gravity and the oil that it ploughs through."""
    weight, middle = model.gravity * model.bearing.m_r, 0.5 * (model.bearing.R_o + model.bearing.R_i)
    for j in range(n):
        speed = (omega_cage + y[EPS_V + j]) * (middle + y[Q + j])
        y[PUSH_R + j] = weight * y[COS + j]
        y[PUSH_T + j] = -weight * y[SIN + j] + orbit_drag(model.drag, speed)
        y[PUSH_Z + j] = 0.0
        y[TURN_R + j], y[TURN_T + j], y[TURN_Z + j] = 0.0, 0.0, 0.0


@jit
def touch_races(model, t, steep, outer, inner, omega_cage, y, n):
    """The contacts of the rollers' slices with both races: fills the sums of both sides.

    steep: 1.0, or 0.0 where pits are not to tilt the normal (at rest).
    """
    b, table = model.bearing, model.slices.table
    face(OuterSide(), b, outer, omega_cage, y, n)
    face(InnerSide(), b, inner, omega_cage, y, n)
    met = find_pits(model, t, outer.a_z, inner.a_z, y) if len(model.pits.head) > 0 else 0
    clear(OuterSide(), y, n)
    clear(InnerSide(), y, n)
    for k in range(len(table)):
        zeta, weight, drop = table[k, ZETA], table[k, WEIGHT], table[k, DROP]
        if met > 0:
            over_pits(model, t, k, steep, outer.a_z, inner.a_z, y)
        stand(OuterSide(), b, outer, zeta, drop, y, n)
        stand(InnerSide(), b, inner, zeta, drop, y, n)
        press(OuterSide(), model.outer, model.friction, weight, y, n)
        press(InnerSide(), model.inner, model.friction, weight, y, n)
        add_up(OuterSide(), b, outer, zeta, weight, drop, y, n)
        add_up(InnerSide(), b, inner, zeta, weight, drop, y, n)
        keep_slice(slice_row(k, 0), y, n)
    if met > 0:
        leave_pits(model, y)
    relax(model.lag, b.m_r, b.I_r, model.I_t, b.R_w, y, n)
    rub(OuterSide(), outer, y, n)
    rub(InnerSide(), inner, y, n)


@jit
def pass_on(bearing, outer, inner, y, n):
    """Add the sums of both sides to what acts on the rollers, and fill the rings' cells.

    Returns the moment (N m) about e_z on the inner ring.
    """
    y[F_X], y[F_Y], y[F_Z], y[M_X], y[M_Y], y[M_RING] = gather(OuterSide(), bearing, outer, y, n)
    y[F_X_I], y[F_Y_I], y[F_Z_I], y[M_X_I], y[M_Y_I], turn = gather(InnerSide(), bearing, inner, y, n)
    return turn


@jit
def move_rollers(model, omega_cage, alpha_cage, alpha_spin, y, n):
    """Newton's equations for the centre of every roller, Euler's for its axis and the turning about it."""
    b, cage = model.bearing, model.cage
    middle = 0.5 * (b.R_o + b.R_i)
    for j in range(n):
        per_mass = y[INVERSE_MASS + j]
        real = b.m_r * per_mass
        r, theta_v = middle + y[Q + j], omega_cage + y[EPS_V + j]
        y[A + j] = real * r * theta_v * theta_v + per_mass * y[PUSH_R + j]
        theta_a = (per_mass * y[PUSH_T + j] - 2.0 * y[V + j] * theta_v) / r
        y[EPS_A + j] = let_go(cage, real * (theta_a - alpha_cage))
        y[AXIAL_A + j] = let_go(cage, per_mass * y[PUSH_Z + j])

        a_r, a_t, a_z = y[TILT + j], y[SKEW + j], y[UPRIGHT + j]
        w_r, w_t, w_z = y[TILT_V + j], y[SKEW_V + j], y[UPRIGHT_V + j]
        M_r, M_t, M_z = y[TURN_R + j], y[TURN_T + j], y[TURN_Z + j]
        l_r, l_t = tip(M_r, M_t, M_z, b.I_r * y[OMEGA + j], model.I_t, a_r, a_t, a_z, w_r, w_t, w_z)
        carried = 2.0 * w_r * theta_v + a_r * alpha_cage  # of an axis that a cage keeps from skewing
        l_r, l_t = real * l_r, real * (carried + let_go(cage, l_t - carried))
        c, s = y[COS + j], y[SIN + j]
        y[AXIS_X_A + j], y[AXIS_Y_A + j] = l_r * c - l_t * s, l_r * s + l_t * c
        bent, area = 1.0 + a_z, w_r * a_t - a_r * w_t
        wound = (l_r * a_t - a_r * l_t) / bent - area * w_z / (bent * bent)
        omega_a = (M_r * a_r + M_t * a_t + M_z * a_z) / b.I_r
        y[SPIN_A + j] = let_go(cage, real * (omega_a - wound - alpha_spin))


@accelerations.register(Spatial)
def _accelerations(model, t, y):
    b = model.bearing
    n = lanes(b)
    time, rate, growth = elapsed(model.motion, t)
    theta_i, omega_i = b.omega_i * time, b.omega_i * rate
    omega_cage = b.omega_c * rate + y[VELOCITY + PHI_C]
    spin = (b.omega_c - b.omega_b) * rate
    outer = body_at(y, X, Z, LEAN_X, LEAN_Y, y[VELOCITY + PSI])
    inner = body_at(y, X_I, Z_I, LEAN_X_I, LEAN_Y_I, omega_i)
    cage = cage_body(model.cage_z, omega_cage, y)

    place(b.theta_0 + b.omega_c * time + y[POSITION + PHI_C], y, n)
    orient(spin, omega_cage, b.R_w, y, n)
    weigh(model, omega_cage, y, n)
    touch_races(model, t, 1.0, outer, inner, omega_cage, y, n)
    guide_axially(model.flanges, model, outer, inner, y, n)
    turn = pass_on(b, outer, inner, y, n)
    pockets_in_space(model.cage, model, cage, omega_cage, spin, y, n)

    wound = lean_cage(model.cage_z, model.cage, cage, y)
    y[M_C] = y[M_X_C] * cage.a_x + y[M_Y_C] * cage.a_y + y[M_C] * cage.a_z
    taken = move_mounted(model.mount_o, outer, y[F_Z], y[M_X], y[M_Y], y[M_RING], y, Z, LEAN_X, LEAN_Y)
    y[M_RING] = y[M_X] * outer.a_x + y[M_Y] * outer.a_y + y[M_RING] * outer.a_z - taken
    move_mounted(model.mount_i, inner, y[F_Z_I], y[M_X_I], y[M_Y_I], turn, y, Z_I, LEAN_X_I, LEAN_Y_I)

    alpha_cage = drive_cage(model.cage, model, omega_cage, omega_i, b.omega_c * growth, y) - wound
    y[ACCELERATION + PHI_C] = alpha_cage - b.omega_c * growth
    move_rollers(model, omega_cage, alpha_cage, (b.omega_c - b.omega_b) * growth, y, n)
    move_outer_ring(model, y)
    rotate_ring(model.bracket, y)
    move_inner_ring(model.shaft, model, theta_i, omega_i, b.omega_i * growth, y)


@jit
def hold_rings(model, y):
    """Put the rings where they are held."""
    hold(model.mount_o, y, Z, LEAN_X, LEAN_Y)
    hold(model.mount_i, y, Z_I, LEAN_X_I, LEAN_Y_I)


@begin.register(Spatial)
def _begin(model, t, y):
    hold_rings(model, y)
    accelerations(model, t, y)


@keep_extremes.register(Spatial)
def _keep_extremes(model, y):
    n = lanes(model.bearing)
    keep_largest_forces(y, n)
    for j in range(n):
        y[TILT_MAX + j] = max(y[TILT_MAX + j], abs(y[TILT + j]))
    for k in range(len(model.slices.table)):
        keep_line_load(slice_row(k, 0), model.slices.table[k, WEIGHT] * model.L_w, y, n)


next_cusp.register(Spatial)(next_cusp_freely)


@standing.register(Spatial)
def _standing(model, d, t, y):
    """Of a roller's middle, from where rollers, rings and cage are and the rows that ``face`` fills."""
    head, middle = model.pits.head[d], 0.5 * (model.bearing.R_o + model.bearing.R_i)
    outer = head[SIDE] == OUTER
    leans = (LEAN_X, LEAN_Y) if outer else (LEAN_X_I, LEAN_Y_I)
    b_z = upright(y[leans[0]], y[leans[1]])
    j, s = met_at(model, d, t, y)
    return j, s + head[RADIUS] * seen_at(OUTER_SIDE if outer else INNER_SIDE, middle, b_z, 0.0, y, j)[0]


@jit
def along_slices(model, y, j):
    """Stiffness (N/m) and damping (N s/m) of a roller's contacts, and against tilting (N m/rad, N m s/rad)."""
    k, c, k_tilt, c_tilt = 0.0, 0.0, 0.0, 0.0
    for i in range(len(model.slices.table)):
        zeta, weight = model.slices.table[i, ZETA], model.slices.table[i, WEIGHT]
        o = max(y[slice_row(i, APPROACH_O) + j], 0.0)
        p = max(y[slice_row(i, APPROACH_I) + j], 0.0)
        stiff = weight * (
            stiffness_bound(model.outer, o, y[V_O + j]) + stiffness_bound(model.inner, p, y[V_I + j])
        )
        damp = weight * (damping_bound(model.outer, o, y[V_O + j]) + damping_bound(model.inner, p, y[V_I + j]))
        k, c = k + stiff, c + damp
        k_tilt, c_tilt = k_tilt + zeta * zeta * stiff, c_tilt + zeta * zeta * damp
    return k, c, k_tilt, c_tilt


@stiffness_per_mass.register(Spatial)
def _stiffness_per_mass(model, y, j):
    """The roller's between its races, radially or tilting, of pocket, flange, rings: the largest."""
    per_mass = y[INVERSE_MASS + j]
    k, _, k_tilt, _ = along_slices(model, y, j)
    held = max(held_stiffness(model.shaft), held_stiffness(model.bracket))
    mounted = max(mount_stiffness(model.mount_o), mount_stiffness(model.mount_i))
    pocket = max(pocket_stiffness(model.cage, per_mass), axial_stiffness(model.cage_z, model.cage, per_mass))
    flange = flange_stiffness(model.flanges, per_mass, 1.0 / model.I_t, model.bearing.R_w)
    return max(per_mass * k, k_tilt / model.I_t, held, mounted, pocket, flange)


@damping_per_mass.register(Spatial)
def _damping_per_mass(model, y, j):
    """Radial or tilting damping, or that of what holds the rings, or of friction on slip: the largest.

    Friction on flanges and pockets has no lag and acts in all these directions, so it adds to what damps the
    roller: as it is now, for it always slips.
    """
    b, half, per_mass = model.bearing, 0.5 * model.L_w, y[INVERSE_MASS + j]
    _, c, _, c_tilt = along_slices(model, y, j)
    pressed = max(y[Q_O + j], y[Q_I + j]) * max(2.0 * b.R_w * b.R_w / b.I_r, 2.0 * b.R_w * b.R_w / model.I_t)
    rubbing = steepest(model.friction, b.R_w * b.omega_b) * pressed
    held = max(held_damping(model.shaft), held_damping(model.bracket))
    mounted = max(mount_damping(model.mount_o), mount_damping(model.mount_i))
    loose = per_mass + b.R_w * b.R_w / b.I_r + half * half / model.I_t  # 1/kg: slip of an end's rim per impulse
    of_roller = max(per_mass * c, c_tilt / model.I_t, lagged(rubbing, model.lag))
    return max(of_roller + (y[RUB_F + j] + y[RUB_P + j]) * loose, held, mounted)


@freedoms.register(Spatial)
def _freedoms(model):
    return 6, 17


@linearise.register(Spatial)
def _linearise(model, t, y):
    differentiate_in_space(model, t, y)


KIND = ModelKind(Spatial, per_crossing=100)
