"""Where everything lies in the one flat buffer that a simulation works on.

A loop over rollers keeps its vector lanes only if the compiler can see that rows do not overlap and that no
index is negative; it sees both when all rows lie in one buffer at constant offsets and loops count from zero
(with separate arrays the run-time overlap checks cost as much as the work; a loop from 8 stays scalar). A row
holds the shared coordinates (ring, cage, inner ring), then one lane per roller, padded to the vector width.
Padded lanes have cos = sin = 0 and an inverse mass of 0: they compute, and change nothing.

A state (positions, velocities, accelerations) is a block of six rows, one for each coordinate of a roller:
radial, angle, spin, axial, and two components of its axis. The shared coordinates stand before the lanes: those of
the plane in the first row, those that only ``spatial`` knows in the last three. Models that know less use less.

Behind everything else, and only in a buffer made for slices, lie the rows of ``spatial``: those of a roller, of
each of its two sides, and of each slice (``slice_row``).

The names of rows are offsets: ``y[lay.RADIAL + j]`` is roller j's radial position, ``y[lay.POSITION + lay.X]`` the
ring's, with ``from bearingsim.core import layout as lay``.
"""

import numpy as np

from bearingsim.core.jit import jit

VECTOR_WIDTH = 8  # doubles in the widest vector register
FIRST_LANE = 8  # where a row's lanes begin; before them the shared coordinates
MAX_ROLLERS = 104
ROW = FIRST_LANE + MAX_ROLLERS
STATE = 6 * ROW

X, Y, PSI = 0, 1, 2  # shared coordinates in a state: the ring's centre (m) and rotation (rad)
PHI_C, X_C, Y_C = 3, 4, 5  # the cage's rotation beyond its kinematic one (rad), its centre (m)
X_I, Y_I = 6, 7  # the inner ring's centre (m)
Z, Z_C, Z_I = (3 * ROW + n for n in range(3))  # along the bearing's axis: outer ring, cage, inner ring (m)
RING_TILT_X, CAGE_TILT_X, INNER_TILT_X = (4 * ROW + n for n in range(3))  # components of their axes along e_0 (1)
RING_TILT_Y, CAGE_TILT_Y, INNER_TILT_Y = (5 * ROW + n for n in range(3))  # and along e_90
POSITION, VELOCITY, ACCELERATION = 0 * STATE, 1 * STATE, 2 * STATE
# how far the outer ring bends (m): amplitudes of its harmonics, of cosine and of sine; where nothing but the
# radial motion of the rollers is known, since rollers have these rows elsewhere
MODES_C, MODES_S = ROW, 2 * ROW

# rollers, radially (m)
RADIAL, RADIAL_V, RADIAL_A = (block + FIRST_LANE for block in (POSITION, VELOCITY, ACCELERATION))
# angle from the centre of the own pocket (rad)
EPS, EPS_V, EPS_A = (row + ROW for row in (RADIAL, RADIAL_V, RADIAL_A))
# rotation beyond the kinematic one (rad)
SPIN, SPIN_V, SPIN_A = (row + 2 * ROW for row in (RADIAL, RADIAL_V, RADIAL_A))
# rollers, along the bearing's axis (m)
AXIAL, AXIAL_V, AXIAL_A = (row + 3 * ROW for row in (RADIAL, RADIAL_V, RADIAL_A))
# component of the own axis along e_0 (1)
AXIS_X, AXIS_X_V, AXIS_X_A = (row + 4 * ROW for row in (RADIAL, RADIAL_V, RADIAL_A))
AXIS_Y, AXIS_Y_V, AXIS_Y_A = (row + 5 * ROW for row in (RADIAL, RADIAL_V, RADIAL_A))  # and along e_90

_FIRST = 3 * STATE
COS_0, SIN_0, INVERSE_MASS = (_FIRST + n * ROW for n in range(3))  # constants of a lane: angle at theta_c = 0, 1/m
COS, SIN = (_FIRST + n * ROW for n in range(3, 5))  # of the roller's angle now
DELTA_O, V_O, Q_O = (_FIRST + n * ROW for n in range(5, 8))  # outer contact: approach, its rate, force
DELTA_I, V_I, Q_I = (_FIRST + n * ROW for n in range(8, 11))  # inner contact
SLIP_O, SLIP_I, Q_P = (_FIRST + n * ROW for n in range(11, 14))  # slip speeds (m/s), force of the pocket (N)
# tangential force on the roller, in a pit (N)
PIT_FORCE_O, PIT_FORCE_I = (_FIRST + n * ROW for n in range(14, 16))
# largest Q_O; seconds over the step limit
Q_O_MAX, OVERRUN, OVERRUN_MAX = (_FIRST + n * ROW for n in range(16, 19))
Q_I_MAX, Q_P_MAX = (_FIRST + n * ROW for n in range(19, 21))  # largest Q_I and |Q_P|
WORK = _FIRST + 21 * ROW  # rows a model may use within an evaluation
# (the equilibrium uses some of these rows before a motion begins: ``models/equilibrium.py``)
# direction of a roller's pocket; cos and sin of EPS
COS_POCKET, SIN_POCKET, COS_EPS, SIN_EPS = (WORK + n * ROW for n in range(4))
# outer contact: normal along e_r, e_theta; distance from the ring's centre (m); speed across the normal (m/s)
NORMAL_O_R, NORMAL_O_T, RHO_O, TANGENTIAL_V_O = (WORK + n * ROW for n in range(4, 8))
# the same of the inner contact
NORMAL_I_R, NORMAL_I_T, RHO_I, TANGENTIAL_V_I = (WORK + n * ROW for n in range(8, 12))
# on a roller: along e_r, e_theta (N), spin (N m)
FORCE_R, FORCE_T, TORQUE = (WORK + n * ROW for n in range(12, 15))
# how far the outer race is bent outwards at each roller (m), and how fast that grows as the roller goes on (m/s)
BEND, BEND_V = (WORK + n * ROW for n in range(7, 9))
FRICTION_O, FRICTION_I = (WORK + n * ROW for n in range(15, 17))  # friction at the two contacts (N)
RHO_V_O, RHO_V_I = (WORK + n * ROW for n in range(17, 19))  # rates of RHO_O, RHO_I of rollers over a pit (m/s)
# cells, not rows: forces (N) and torques (N m) on ring, cage and inner ring
F_X, F_Y, M_RING, F_X_C, F_Y_C, M_C, F_X_I, F_Y_I = range(WORK + 19 * ROW, WORK + 19 * ROW + 8)
F_Z, M_X, M_Y, F_Z_C, M_X_C, M_Y_C, F_Z_I, M_X_I, M_Y_I = range(WORK + 19 * ROW + 8, WORK + 19 * ROW + 17)
M_INNER = WORK + 19 * ROW + 17  # about the axis, on the inner ring (N m)
LOADS = 18  # cells from F_X to M_INNER
# cells: radial motion of a ring that bends where its sensor sits: place (m), velocity (m/s), acceleration (m/s^2)
SENSOR, SENSOR_V, SENSOR_A = range(WORK + 19 * ROW + MAX_ROLLERS, WORK + 19 * ROW + MAX_ROLLERS + 3)  # no lane
PIT_TORQUE = WORK + 20 * ROW  # of the pits of a roller, on itself (N m)
WORK_ROWS = 21
JACOBIAN_WORK = WORK + WORK_ROWS * ROW  # rows that ``linearise`` may use, within one call
JACOBIAN_WORK_ROWS = 86
STAGE = JACOBIAN_WORK + JACOBIAN_WORK_ROWS * ROW  # states a method may use, between evaluations
STAGE_STATES = 56
LOADED_ROLLERS = STAGE + STAGE_STATES * STATE  # one cell: rollers that carry load
# cells of a method: the step it stands in, from and to (s), the length it will try next (s); why it cannot go on
# (``core/outcomes.py``; 0 while it can) and the body concerned; steps taken and refused, evaluations of the model,
# Newton iterations; crossings of pits seen
(
    T_START,
    T_END,
    H_NEXT,
    FAILED,
    FAILED_BODY,
    STEPS_TAKEN,
    STEPS_REJECTED,
    EVALUATIONS,
    NEWTON_ITERATIONS,
    PIT_CROSSINGS,
) = range(LOADED_ROLLERS + 1, LOADED_ROLLERS + 11)
# the time it stops at next (s), the length of the step taken last (s) and its error; dense output complete?
NEXT_STOP, H_TAKEN, LAST_ERROR, DENSE_READY = range(LOADED_ROLLERS + 11, LOADED_ROLLERS + 15)
CPU_END = (
    LOADED_ROLLERS + 15
)  # cell: this thread's CPU time (s) at which compiled loops end, 0: never (``clock.py``)
# of each of the first pits' roller-pit pairs: 1 + the number of the roller that stands in it, 0: none; rollers
# seen in it
ROLLER_IN_PIT, PAIR_CROSSINGS = LOADED_ROLLERS + 2 * VECTOR_WIDTH, LOADED_ROLLERS + 2 * VECTOR_WIDTH + ROW
# part of the method's step limit that each monitored body takes up
STEP_RATIO = LOADED_ROLLERS + 2 * VECTOR_WIDTH + 2 * ROW
APPROACH_NOW = STEP_RATIO + ROW  # larger approach of each roller to a race without pits, as the monitor looks (m)
# forces Q_O, Q_I, |Q_P| (N) at the start and at the end of an adaptive method's step
FORCES_AT_START, FORCES_AT_END = APPROACH_NOW + ROW, APPROACH_NOW + 4 * ROW

# what forces and torques accelerate a roller by, and (cells) the bodies of the shared coordinates X to Y_I (1/kg,
# 1/(kg m^2)); how the place (m) and velocity (m/s) of each roller, as a body sees it, change along e_r, e_theta;
# what follows, of force along e_r, e_theta (N) and torque (N m) on it, and on these shared coordinates
(
    MOBILITY_R,
    MOBILITY_T,
    MOBILITY_SPIN,
    MOBILITY_SHARED,
    D_POSITION_R,
    D_POSITION_T,
    D_VELOCITY_R,
    D_VELOCITY_T,
    D_FORCE_R,
    D_FORCE_T,
    D_TORQUE,
    D_FORCE_SHARED,
) = (JACOBIAN_WORK + FIRST_LANE + n * ROW for n in range(12))
# rows of contacts
OUTER_CONTACT, INNER_CONTACT, POCKET_CONTACT = (JACOBIAN_WORK + FIRST_LANE + n * ROW for n in (19, 43, 67))
# of differences (``models/differences.py``): the state about which they are taken (three blocks), rows of what
# each roller adds to the cells F_X to M_INNER, now and there; cells: their sums there, whether a coordinate moves
HERE, ROLLER_LOADS, ROLLER_LOADS_HERE, LOADS_HERE = (JACOBIAN_WORK + n * ROW for n in (0, 18, 36, 54))

# of a ring that bends: cosine and sine of each harmonic's angle as the first roller has it; amplitudes (m), and
# their rates (m/s), as the rollers see them; forces (N) on the amplitudes, as the rollers make them
TURN_C, TURN_S, SEEN_C, SEEN_S, SEEN_V_C, SEEN_V_S, PUSH_C, PUSH_S = (
    JACOBIAN_WORK + n * ROW for n in range(54, 62)
)
# forces (N) on the amplitudes by springs around the ring; of each spring: how far it is pressed (m), how fast
# (m/s), its force (N), of up to 4 ROW springs
PULL_C, PULL_S = (JACOBIAN_WORK + n * ROW for n in range(71, 73))
PRESSED, PRESSED_V, SPRING_FORCE = (JACOBIAN_WORK + n * ROW for n in range(73, 85, 4))
MAX_SPRINGS = 4 * ROW
# cells: what the springs do to the ring's centre (N)
SPRINGS_X, SPRINGS_Y = range(WORK + 20 * ROW + MAX_ROLLERS, WORK + 20 * ROW + MAX_ROLLERS + 2)

# a matrix of the arrow's shape (``methods/arrow.py``): rows of the rollers' own blocks, of what the border does to
# a roller, of what a roller does to the border; cells of the border's own block
MAX_OWN, MAX_SHARED = 6, 17  # coordinates of a roller, and shared ones
DIAGONAL_BLOCK, BORDER_COLUMN, BORDER_ROW = 0, MAX_OWN * MAX_OWN * ROW, MAX_OWN * (MAX_OWN + MAX_SHARED) * ROW
CORNER_BLOCK = MAX_OWN * (MAX_OWN + 2 * MAX_SHARED) * ROW
ARROW_SIZE = CORNER_BLOCK + -(-MAX_SHARED * (MAX_SHARED + 2) // ROW) * ROW
POSITION_JACOBIAN = LOADED_ROLLERS + 11 * ROW  # d(acceleration)/d(position)
VELOCITY_JACOBIAN = POSITION_JACOBIAN + ARROW_SIZE  # d(acceleration)/d(velocity)
SYSTEM = VELOCITY_JACOBIAN + ARROW_SIZE  # the matrix that a method solves with
BUFFER_SIZE = SYSTEM + ARROW_SIZE

# what only ``spatial`` has: rows of a roller
_SPACE = BUFFER_SIZE + FIRST_LANE
# its axis along e_r, e_theta, e_z, and the rates of these; speed about the axis (rad/s); surface speed (m/s)
TILT, SKEW, AXIS_Z, TILT_V, SKEW_V, AXIS_Z_V, OMEGA, ROLLING_SPEED = (_SPACE + n * ROW for n in range(8))
# force (N), moment (N m) on a roller
FORCE_Z, MOMENT_R, MOMENT_T, MOMENT_Z = (_SPACE + n * ROW for n in range(8, 12))
SKEW_V_CHANGE = _SPACE + 12 * ROW  # change of the skew's rate within the lag (rad/s)
# a roller in its pocket: distance from the middle (m), its rate (m/s), slip along the wall and the axis (m/s), in
# the roller's middle and their growth along it (*_SLOPE); relative turning about the cage's axis and radius
# (rad/s)
(
    POCKET_OFFSET,
    POCKET_OFFSET_V,
    POCKET_SLIP,
    POCKET_SLIP_Z,
    POCKET_OFFSET_SLOPE,
    POCKET_OFFSET_V_SLOPE,
    POCKET_SLIP_SLOPE,
    POCKET_SLIP_Z_SLOPE,
) = (_SPACE + n * ROW for n in range(13, 21))
POCKET_OMEGA_Z, POCKET_OMEGA_R = (_SPACE + n * ROW for n in range(21, 23))
# sums over slices
(
    POCKET_FORCE_W,
    POCKET_FORCE_R,
    POCKET_FORCE_Z,
    POCKET_ZETA_FORCE_W,
    POCKET_ZETA_FORCE_R,
    POCKET_ZETA_FORCE_Z,
    POCKET_COUPLE_Z,
    POCKET_COUPLE_R,
) = (_SPACE + n * ROW for n in range(23, 31))
Q_F = _SPACE + 31 * ROW  # force of the flanges on a roller along the bearing's axis (N)
TILT_MAX, LINE_LOAD_MAX = (_SPACE + n * ROW for n in range(32, 34))  # largest |tilt| (rad) and line load (N/m)
KAPPA_F, KAPPA_P = (_SPACE + n * ROW for n in range(34, 36))  # friction over slip, flanges and pocket (N s/m)
_SPACE_ROWS = 36

# rows of one side of a roller (add ``OUTER_SIDE`` or ``INNER_SIDE``); see core/parts/races_in_space.py
OUTER_SIDE = BUFFER_SIZE + _SPACE_ROWS * ROW + FIRST_LANE
RING_AXIS_R, RING_AXIS_T = (n * ROW for n in range(2))  # the ring's axis along e_r, e_theta
OFFSET_R, OFFSET_T, OFFSET_Z, DIRECTION_R, DIRECTION_T, DIRECTION_Z = (n * ROW for n in range(2, 8))
OFFSET_V_R, OFFSET_V_T, OFFSET_V_Z, DIRECTION_V_R, DIRECTION_V_T, DIRECTION_V_Z = (n * ROW for n in range(8, 14))
ROLL_SPEED, AXIAL_SLIP, AXIAL_SLIP_SLOPE, AXIAL_SLIP_ARM_R, AXIAL_SLIP_ARM_T, AXIAL_SLIP_ARM_Z = (
    n * ROW for n in range(14, 20)
)
(
    CONTACT_FORCE_R,
    CONTACT_FORCE_T,
    CONTACT_FORCE_Z,
    CONTACT_ZETA_FORCE_R,
    CONTACT_ZETA_FORCE_T,
    CONTACT_ZETA_FORCE_Z,
    COUPLE_AXIAL,
    COUPLE_R,
    COUPLE_T,
    COUPLE_Z,
) = (n * ROW for n in range(20, 30))
# sums of friction over slip, for the lag
KAPPA_0, KAPPA_1, KAPPA_2, KAPPA_SLIP_0, KAPPA_SLIP_1, KAPPA_SLIP_Z = (n * ROW for n in range(30, 36))
# ...; over a pit?
KAPPA_ARM, KAPPA_R, KAPPA_T, KAPPA_Z, SLIP_CHANGE, SLIP_CHANGE_Z, PIT_REACH = (n * ROW for n in range(36, 43))
# of a pit, as the slice at hand feels it: depth (m), tangent of the normal's tilt, 1 - its cosine, stiffness lost;
# is it the roller's own?
ROLLER_DROP, NORMAL_SLOPE, NORMAL_VERSINE, STIFFNESS_LOSS, OWN_PIT = (n * ROW for n in range(43, 48))
SIDE_ROWS = 48
INNER_SIDE = OUTER_SIDE + SIDE_ROWS * ROW

SLICES = BUFFER_SIZE + (_SPACE_ROWS + 2 * SIDE_ROWS) * ROW
LOAD_O, LOAD_I, APPROACH_O, APPROACH_I = range(4)  # rows of a slice: force (N), approach (m) at the two races
SLICE_ROWS = 4


@jit
def diagonal_block(matrix, i, k):
    """Where the lanes of d(coordinate i of a roller)/d(its coordinate k) begin, in the arrow at ``matrix``."""
    return matrix + DIAGONAL_BLOCK + (i * MAX_OWN + k) * ROW + FIRST_LANE


@jit
def border_column(matrix, i, k):
    """The lanes of d(coordinate i of a roller)/d(shared coordinate k)."""
    return matrix + BORDER_COLUMN + (i * MAX_SHARED + k) * ROW + FIRST_LANE


@jit
def border_row(matrix, k, i):
    """The lanes of d(shared coordinate k)/d(coordinate i of a roller)."""
    return matrix + BORDER_ROW + (k * MAX_OWN + i) * ROW + FIRST_LANE


@jit
def corner_block(matrix, k, m):
    """The cell of d(shared coordinate k)/d(shared coordinate m)."""
    return matrix + CORNER_BLOCK + k * MAX_SHARED + m


@jit
def shared_cell(k):
    """Where shared coordinate ``k`` (0 to 16) stands in a block of the state: X to Y_I, then those of ``spatial``.

    8, 9, 10: Z, Z_C, Z_I; 11, 12, 13: RING_TILT_X, CAGE_TILT_X, INNER_TILT_X; 14, 15, 16: RING_TILT_Y,
    CAGE_TILT_Y, INNER_TILT_Y.
    """
    return k if k < FIRST_LANE else (3 + (k - FIRST_LANE) // 3) * ROW + (k - FIRST_LANE) % 3


@jit
def roller_load(cell):
    """Where the lanes of ROLLER_LOADS begin that belong to one of the cells F_X to M_INNER."""
    return ROLLER_LOADS + (cell - F_X) * ROW + FIRST_LANE


@jit
def slice_row(k, i):
    """Where the lanes of row ``i`` of slice ``k`` begin."""
    return SLICES + (k * SLICE_ROWS + i) * ROW + FIRST_LANE


def lane_of(places: np.ndarray) -> np.ndarray:
    """Which roller's lane (from 0) each of ``places`` of the buffer lies in; -1 for what is shared."""
    of_contacts = (places >= COS_0) & (places < LOADED_ROLLERS)  # rows whose lanes stand first
    lane = places % ROW - np.where(of_contacts, 0, FIRST_LANE)
    return np.where((lane >= 0) & (lane < MAX_ROLLERS), lane, -1)


def buffer(Z: int, m_r: float, slices: int = 0) -> np.ndarray:
    """A zeroed buffer with the lane constants of Z evenly spaced rollers of mass ``m_r`` (kg).

    slices: how many a roller is cut into, in ``spatial``; 0 in models that know of none. ``m_r`` = 0 (models whose
    rollers have no mass) leaves the rollers' inverse mass 0: their lanes stand still.
    """
    y = np.zeros(SLICES + slices * SLICE_ROWS * ROW if slices else BUFFER_SIZE)
    angle = 2.0 * np.pi * np.arange(Z) / Z
    y[COS_0 : COS_0 + Z] = np.cos(angle)
    y[SIN_0 : SIN_0 + Z] = np.sin(angle)
    y[INVERSE_MASS : INVERSE_MASS + Z] = 1.0 / m_r if m_r > 0.0 else 0.0
    return y
