"""The derivatives of ``planar``'s accelerations: exact, column by column.

A column is what follows from one unit of one coordinate, of all rollers at once (each feels itself and the shared
coordinates only) or of one that is shared. How the rollers' places and velocities change, as the body they touch
sees it, is laid in the rows P and W; the contacts answer (``core/race_slopes.py``, ``core/cage_slopes.py``); the
answers are the column. Forces keep their direction in space while e_r and e_theta turn with the roller: that, and
what its own motion does, is added at the end, with the springs of the shared coordinates.

Friction counts without lag (``friction.rub``): implicit methods have none.
"""

from bearingsim.core.cage import let_go, orbit_drag
from bearingsim.core.cage_slopes import (
    cage_mobility,
    guide_change,
    land_drag_slope,
    orbit_drag_slope,
    pocket_change,
    pocket_slopes,
)
from bearingsim.core.jit import add, jit
from bearingsim.core.layout import (
    BY_POSITION,
    BY_VELOCITY,
    CHANGE_M,
    CHANGE_R,
    CHANGE_SHARED,
    CHANGE_T,
    COS,
    EPS_V,
    INVERSE_MASS,
    MOBILITY,
    P_R,
    P_T,
    PER_M,
    PER_R,
    PER_T,
    PHI_C,
    PSI,
    PUSH_R,
    PUSH_T,
    ROW,
    SIN,
    VELOCITY,
    W_R,
    W_T,
    X_C,
    X_I,
    Y_C,
    Y_I,
    Q,
    V,
    X,
    Y,
    border_block,
    from_border,
    own_block,
    to_border,
)
from bearingsim.core.motion import elapsed
from bearingsim.core.parameters import lanes
from bearingsim.core.race_slopes import contact_slopes, race_change, rubbing_slopes, slopes_over_pits
from bearingsim.core.shaft import held_damping, held_stiffness, mobility
from bearingsim.core.sides import InnerSide, OuterSide

RADIAL, ORBIT, SPIN = range(3)  # a roller's coordinates
SHARED = 8


@jit
def still(y, n):
    """Nothing moves, nothing changes."""
    for j in range(n):
        y[P_R + j], y[P_T + j], y[W_R + j], y[W_T + j] = 0.0, 0.0, 0.0, 0.0
        y[CHANGE_R + j], y[CHANGE_T + j], y[CHANGE_M + j] = 0.0, 0.0, 0.0
    for k in range(SHARED):
        for j in range(n):
            y[CHANGE_SHARED + k * ROW + j] = 0.0


@jit
def mobilities(model, y, n):
    """What forces and torques accelerate the rollers by, and the bodies of the shared coordinates."""
    b, cage, m_o = model.bearing, model.cage, model.bearing.m_o
    middle, held = 0.5 * (b.R_o + b.R_i), let_go(cage, 1.0)
    for j in range(n):
        per_mass = y[INVERSE_MASS + j]
        y[PER_R + j], y[PER_T + j] = per_mass, held * per_mass / (middle + y[Q + j])
        y[PER_M + j] = held * (b.m_r / b.I_r) * per_mass
    turning, moving = cage_mobility(cage)
    y[MOBILITY + X], y[MOBILITY + Y], y[MOBILITY + PSI] = 1.0 / m_o, 1.0 / m_o, mobility(model.bracket)
    y[MOBILITY + PHI_C], y[MOBILITY + X_C], y[MOBILITY + Y_C] = turning, moving, moving
    y[MOBILITY + X_I], y[MOBILITY + Y_I] = mobility(model.shaft), mobility(model.shaft)


@jit
def keep_own(matrix, i, m_r, y, n):
    """Write what changes into the column of the rollers' coordinate ``i``."""
    for j in range(n):
        y[own_block(matrix, RADIAL, i) + j] = y[PER_R + j] * y[CHANGE_R + j]
    for j in range(n):
        y[own_block(matrix, ORBIT, i) + j] = y[PER_T + j] * y[CHANGE_T + j]
    for j in range(n):
        y[own_block(matrix, SPIN, i) + j] = y[PER_M + j] * y[CHANGE_M + j]
    for k in range(SHARED):
        share = m_r * y[MOBILITY + k]  # times the inverse mass: none of a padded lane
        for j in range(n):
            y[to_border(matrix, k, i) + j] = share * y[INVERSE_MASS + j] * y[CHANGE_SHARED + k * ROW + j]


@jit
def keep_shared(matrix, m, m_r, y, n):
    """Write it into the column of the shared coordinate ``m``, there summed over the rollers."""
    for j in range(n):
        y[from_border(matrix, RADIAL, m) + j] = y[PER_R + j] * y[CHANGE_R + j]
    for j in range(n):
        y[from_border(matrix, ORBIT, m) + j] = y[PER_T + j] * y[CHANGE_T + j]
    for j in range(n):
        y[from_border(matrix, SPIN, m) + j] = y[PER_M + j] * y[CHANGE_M + j]
    for k in range(SHARED):
        total = 0.0
        for j in range(n):
            total = add(total, y[INVERSE_MASS + j] * y[CHANGE_SHARED + k * ROW + j])
        y[border_block(matrix, k, m)] = m_r * y[MOBILITY + k] * total


@jit
def answer(model, omega_cage, omega_i, spin, roll, roll_v, orbit_v, y, n):
    """What follows for all contacts of rollers that move."""
    race_change(OuterSide(), spin, y[VELOCITY + PSI], roll, roll_v, orbit_v, 0.0, 0.0, y, n)
    race_change(InnerSide(), spin, omega_i, roll, roll_v, orbit_v, 0.0, 0.0, y, n)
    pocket_change(model.cage, model.bearing.R_w, omega_cage, roll_v, 0.0, 0.0, y, n)


@jit
def by_rollers(model, omega_cage, omega_i, spin, y, n):
    """The columns of the rollers' own coordinates."""
    m_r, middle = model.bearing.m_r, 0.5 * (model.bearing.R_o + model.bearing.R_i)
    still(y, n)
    for j in range(n):
        y[P_R + j], y[W_T + j] = 1.0, omega_cage + y[EPS_V + j]
    answer(model, omega_cage, omega_i, spin, 0.0, 0.0, 0.0, y, n)
    keep_own(BY_POSITION, RADIAL, m_r, y, n)
    still(y, n)
    for j in range(n):
        y[W_R + j] = 1.0
    answer(model, omega_cage, omega_i, spin, 0.0, 0.0, 0.0, y, n)
    keep_own(BY_VELOCITY, RADIAL, m_r, y, n)
    still(y, n)
    for j in range(n):
        r = middle + y[Q + j]
        y[P_T + j], y[W_R + j], y[W_T + j] = r, -r * (omega_cage + y[EPS_V + j]), y[V + j]
    answer(model, omega_cage, omega_i, spin, 0.0, 0.0, 0.0, y, n)
    keep_own(BY_POSITION, ORBIT, m_r, y, n)
    still(y, n)
    for j in range(n):
        y[W_T + j] = middle + y[Q + j]
    answer(model, omega_cage, omega_i, spin, 0.0, 0.0, 1.0, y, n)
    keep_own(BY_VELOCITY, ORBIT, m_r, y, n)
    still(y, n)
    if len(model.pits.head) > 0:  # one of a roller turns with it
        answer(model, omega_cage, omega_i, spin, 1.0, 0.0, 0.0, y, n)
    keep_own(BY_POSITION, SPIN, m_r, y, n)
    still(y, n)
    answer(model, omega_cage, omega_i, spin, 0.0, 1.0, 0.0, y, n)
    keep_own(BY_VELOCITY, SPIN, m_r, y, n)


@jit
def move_away(place_r, place_t, axis, y, n):
    """Lay in rows how rollers move as a body sees them that moves by one unit along e_0 (axis 0) or e_90 (1)."""
    for j in range(n):
        c, s = y[COS + j], y[SIN + j]
        y[place_r + j], y[place_t + j] = (-s, -c) if axis else (-c, s)


@jit
def by_ring(side, omega_ring, spin, m_r, first, y, n):
    """The columns of where a ring's centre is and how it moves; ``first``: its shared coordinate."""
    for axis in range(2):
        still(y, n)
        move_away(P_R, P_T, axis, y, n)
        race_change(side, spin, omega_ring, 0.0, 0.0, 0.0, 0.0, 0.0, y, n)
        keep_shared(BY_POSITION, first + axis, m_r, y, n)
        still(y, n)
        move_away(W_R, W_T, axis, y, n)
        race_change(side, spin, omega_ring, 0.0, 0.0, 0.0, 0.0, 0.0, y, n)
        keep_shared(BY_VELOCITY, first + axis, m_r, y, n)


@jit
def by_outer_s_turn(model, spin, y, n):
    """The columns of the outer ring's angle (a pit turns with it) and of its speed."""
    m_r, turning = model.bearing.m_r, y[VELOCITY + PSI]
    still(y, n)
    if len(model.pits.head) > 0:
        race_change(OuterSide(), spin, turning, 0.0, 0.0, 0.0, 1.0, 0.0, y, n)
    keep_shared(BY_POSITION, PSI, m_r, y, n)
    still(y, n)
    race_change(OuterSide(), spin, turning, 0.0, 0.0, 0.0, 0.0, 1.0, y, n)
    keep_shared(BY_VELOCITY, PSI, m_r, y, n)


@jit
def by_cage(model, omega_cage, y, n):
    """The columns of the cage's angle, centre and motion."""
    cage, R_w, m_r = model.cage, model.bearing.R_w, model.bearing.m_r
    still(y, n)
    pocket_change(cage, R_w, omega_cage, 0.0, 1.0, 0.0, y, n)
    keep_shared(BY_POSITION, PHI_C, m_r, y, n)
    still(y, n)
    pocket_change(cage, R_w, omega_cage, 0.0, 0.0, 1.0, y, n)
    keep_shared(BY_VELOCITY, PHI_C, m_r, y, n)
    for axis in range(2):
        still(y, n)
        move_away(P_R, P_T, axis, y, n)
        pocket_change(cage, R_w, omega_cage, 0.0, 0.0, 0.0, y, n)
        keep_shared(BY_POSITION, X_C + axis, m_r, y, n)
        still(y, n)
        move_away(W_R, W_T, axis, y, n)
        pocket_change(cage, R_w, omega_cage, 0.0, 0.0, 0.0, y, n)
        keep_shared(BY_VELOCITY, X_C + axis, m_r, y, n)


@jit
def by_own_motion(model, omega_cage, y, n):
    """What turning directions do, and own motion: q'' = r theta'^2 + F_r/m, theta'' = (F_t/m - 2 q' theta')/r."""
    b, held = model.bearing, let_go(model.cage, 1.0)
    middle = 0.5 * (b.R_o + b.R_i)
    for j in range(n):
        r, v, theta_v, real = middle + y[Q + j], y[V + j], omega_cage + y[EPS_V + j], b.m_r * y[INVERSE_MASS + j]
        drag, slope = orbit_drag(model.drag, r * theta_v), orbit_drag_slope(model.drag, r * theta_v)
        coriolis, per_r, per_t = held * real * 2.0 / r, y[PER_R + j], y[PER_T + j]
        y[own_block(BY_POSITION, RADIAL, RADIAL) + j] += real * theta_v * theta_v
        y[own_block(BY_POSITION, RADIAL, ORBIT) + j] += per_r * (y[PUSH_T + j] - drag)
        y[own_block(BY_POSITION, ORBIT, ORBIT) + j] -= per_t * y[PUSH_R + j]
        grows = per_t * (slope * theta_v - y[PUSH_T + j] / r) + coriolis * v * theta_v / r
        y[own_block(BY_POSITION, ORBIT, RADIAL) + j] += grows
        y[own_block(BY_VELOCITY, RADIAL, ORBIT) + j] += real * 2.0 * r * theta_v
        y[own_block(BY_VELOCITY, ORBIT, RADIAL) + j] -= coriolis * theta_v
        y[own_block(BY_VELOCITY, ORBIT, ORBIT) + j] += per_t * slope * r - coriolis * v


@jit
def by_springs(model, y):
    """What holds the rings, and the oil between cage and land."""
    support, m_o = model.support, model.bearing.m_o
    for k, K, C in (
        (X, support.k_b / m_o, support.c_b / m_o),
        (Y, support.k_b / m_o, support.c_b / m_o),
        (PSI, held_stiffness(model.bracket), held_damping(model.bracket)),
        (PHI_C, 0.0, -y[MOBILITY + PHI_C] * land_drag_slope(model.drag)),
        (X_I, held_stiffness(model.shaft), held_damping(model.shaft)),
        (Y_I, held_stiffness(model.shaft), held_damping(model.shaft)),
    ):
        y[border_block(BY_POSITION, k, k)] -= K
        y[border_block(BY_VELOCITY, k, k)] -= C


@jit
def differentiate(model, t, y):
    """``linearise`` of ``planar``, from the rows that ``accelerations`` filled."""
    b = model.bearing
    n = lanes(b)
    _, rate, _ = elapsed(model.motion, t)
    omega_i, spin = b.omega_i * rate, (b.omega_c - b.omega_b) * rate
    omega_cage = b.omega_c * rate + y[VELOCITY + PHI_C]
    mobilities(model, y, n)
    contact_slopes(OuterSide(), model.outer, y, n)
    contact_slopes(InnerSide(), model.inner, y, n)
    if len(model.pits.head) > 0:
        slopes_over_pits(OuterSide(), model.outer, model, t, omega_cage, omega_i, spin, y)
        slopes_over_pits(InnerSide(), model.inner, model, t, omega_cage, omega_i, spin, y)
    rubbing_slopes(OuterSide(), model.friction, b.R_w, omega_cage, spin, y, n)
    rubbing_slopes(InnerSide(), model.friction, b.R_w, omega_cage, spin, y, n)
    pocket_slopes(model.cage, model, omega_cage, spin, y, n)

    by_rollers(model, omega_cage, omega_i, spin, y, n)
    by_ring(OuterSide(), y[VELOCITY + PSI], spin, b.m_r, X, y, n)
    by_outer_s_turn(model, spin, y, n)
    by_cage(model, omega_cage, y, n)
    by_ring(InnerSide(), omega_i, spin, b.m_r, X_I, y, n)
    by_own_motion(model, omega_cage, y, n)
    guide_change(model.cage, omega_cage, omega_i, y)
    by_springs(model, y)
