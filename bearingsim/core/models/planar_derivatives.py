"""The derivatives of ``planar``'s accelerations: exact, column by column.

A column is what follows from one unit of one coordinate, of all rollers at once (each feels itself and the shared
coordinates only) or of one that is shared. How the rollers' places and velocities change, as the body they touch
sees it, is laid in the rows P and W; the contacts answer (``parts/races.py``, ``parts/cage_slopes.py``); the
answers are the column. Forces keep their direction in space while e_r and e_theta turn with the roller: that, and
what its own motion does, is added at the end, with the springs of the shared coordinates.

Friction counts without lag (``friction.rub``): implicit methods have none.
"""

from bearingsim.core.geometry.motion import elapsed
from bearingsim.core.geometry.sides import InnerSide, OuterSide
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
from bearingsim.core.parameters import lanes
from bearingsim.core.parts.cage import let_go, orbit_drag
from bearingsim.core.parts.cage_slopes import (
    cage_mobility,
    guide_change,
    land_drag_slope,
    orbit_drag_slope,
    pocket_change,
    pocket_slopes,
)
from bearingsim.core.parts.races import contact_slopes, race_change, rubbing_slopes, slopes_over_pits
from bearingsim.core.parts.shaft import held_damping, held_stiffness, mobility

RADIAL, ORBIT, SPIN = range(3)  # a roller's coordinates
SHARED = 8
CAGE, INNER = 3, 6  # where the cage's shared coordinates begin, and the inner ring's


@jit
def still(low, high, y, n):
    """Nothing moves, nothing changes, in the shared coordinates ``low`` to before ``high`` neither."""
    for j in range(n):
        y[P_R + j], y[P_T + j], y[W_R + j], y[W_T + j] = 0.0, 0.0, 0.0, 0.0
        y[CHANGE_R + j], y[CHANGE_T + j], y[CHANGE_M + j] = 0.0, 0.0, 0.0
    for k in range(low, high):
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
def keep_shared(matrix, m, low, high, m_r, y, n):
    """Write it into the column of the shared coordinate ``m``, which ``low`` to before ``high`` feel."""
    for j in range(n):
        y[from_border(matrix, RADIAL, m) + j] = y[PER_R + j] * y[CHANGE_R + j]
    for j in range(n):
        y[from_border(matrix, ORBIT, m) + j] = y[PER_T + j] * y[CHANGE_T + j]
    for j in range(n):
        y[from_border(matrix, SPIN, m) + j] = y[PER_M + j] * y[CHANGE_M + j]
    for k in range(SHARED):
        y[border_block(matrix, k, m)] = 0.0
    for k in range(low, high):
        total = 0.0
        for j in range(n):
            total = add(total, y[INVERSE_MASS + j] * y[CHANGE_SHARED + k * ROW + j])
        y[border_block(matrix, k, m)] = m_r * y[MOBILITY + k] * total


@jit
def move_rollers(i, place, speed, middle, omega_cage, y, n):
    """Every roller's coordinate ``i`` changes by ``place`` (m, rad), its rate by ``speed`` (m/s, rad/s).

    A velocity r' e_r + r theta' e_theta changes with r and, as its directions turn, with theta too.
    """
    out = 1.0 if i == RADIAL else 0.0
    orbit = 1.0 if i == ORBIT else 0.0
    for j in range(n):
        r, v, theta_v = middle + y[Q + j], y[V + j], omega_cage + y[EPS_V + j]
        y[P_R + j], y[P_T + j] = place * out, place * orbit * r
        y[W_R + j] = speed * out - place * orbit * r * theta_v
        y[W_T + j] = speed * orbit * r + place * (out * theta_v + orbit * v)


@jit
def move_body(axis, place, speed, y, n):
    """A body moves along e_0 (axis 0) or e_90 (1) by ``place`` (m), ``speed`` (m/s): as it sees it, rollers do."""
    for j in range(n):
        c, s = y[COS + j], y[SIN + j]
        r, t = (-s, -c) if axis else (-c, s)
        y[P_R + j], y[P_T + j], y[W_R + j], y[W_T + j] = place * r, place * t, speed * r, speed * t


@jit
def by_rollers(model, omega_cage, omega_i, spin, y, n):
    """The columns of the rollers' own coordinates and velocities."""
    b, ring_v = model.bearing, y[VELOCITY + PSI]
    middle = 0.5 * (b.R_o + b.R_i)
    for i in range(3):
        for matrix, place, speed in ((BY_POSITION, 1.0, 0.0), (BY_VELOCITY, 0.0, 1.0)):
            roll, roll_v = (place, speed) if i == SPIN else (0.0, 0.0)
            orbit_v = speed if i == ORBIT else 0.0
            still(0, SHARED, y, n)
            move_rollers(i, place, speed, middle, omega_cage, y, n)
            race_change(OuterSide(), spin, ring_v, roll, roll_v, orbit_v, 0.0, 0.0, y, n)
            race_change(InnerSide(), spin, omega_i, roll, roll_v, orbit_v, 0.0, 0.0, y, n)
            pocket_change(model.cage, b.R_w, omega_cage, roll_v, 0.0, 0.0, y, n)
            keep_own(matrix, i, b.m_r, y, n)


@jit
def by_ring(side, omega_ring, spin, m_r, low, high, y, n):
    """The columns of a ring's centre; ``low`` to before ``high``: its shared coordinates."""
    for axis in range(2):
        for matrix, place, speed in ((BY_POSITION, 1.0, 0.0), (BY_VELOCITY, 0.0, 1.0)):
            still(low, high, y, n)
            move_body(axis, place, speed, y, n)
            race_change(side, spin, omega_ring, 0.0, 0.0, 0.0, 0.0, 0.0, y, n)
            keep_shared(matrix, low + axis, low, high, m_r, y, n)


@jit
def by_turn(model, spin, y, n):
    """The columns of the outer ring's angle, with which its pits turn, and of its speed."""
    for matrix, place, speed in ((BY_POSITION, 1.0, 0.0), (BY_VELOCITY, 0.0, 1.0)):
        still(X, CAGE, y, n)
        race_change(OuterSide(), spin, y[VELOCITY + PSI], 0.0, 0.0, 0.0, place, speed, y, n)
        keep_shared(matrix, PSI, X, CAGE, model.bearing.m_r, y, n)


@jit
def by_cage(model, omega_cage, y, n):
    """The columns of the cage's angle and centre, in the order of its shared coordinates."""
    for k in range(CAGE, INNER):
        for matrix, place, speed in ((BY_POSITION, 1.0, 0.0), (BY_VELOCITY, 0.0, 1.0)):
            turn, turn_v = (place, speed) if k == PHI_C else (0.0, 0.0)
            still(CAGE, INNER, y, n)
            if k != PHI_C:
                move_body(k - X_C, place, speed, y, n)
            pocket_change(model.cage, model.bearing.R_w, omega_cage, 0.0, turn, turn_v, y, n)
            keep_shared(matrix, k, CAGE, INNER, model.bearing.m_r, y, n)


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
    by_ring(OuterSide(), y[VELOCITY + PSI], spin, b.m_r, X, CAGE, y, n)
    by_turn(model, spin, y, n)
    by_cage(model, omega_cage, y, n)
    by_ring(InnerSide(), omega_i, spin, b.m_r, INNER, SHARED, y, n)
    by_own_motion(model, omega_cage, y, n)
    guide_change(model.cage, omega_cage, omega_i, y)
    by_springs(model, y)
