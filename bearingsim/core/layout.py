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

The names of rows are offsets: ``y[Q + j]`` is roller j's radial position, ``y[POSITION + X]`` the ring's.
"""

import numpy as np

from bearingsim.core.jit import jit

VECTOR = 8  # doubles in the widest vector register
LANES = 8  # where a row's lanes begin; before them the shared coordinates
MAX_ROLLERS = 104
ROW = LANES + MAX_ROLLERS
STATE = 6 * ROW

X, Y, PSI = 0, 1, 2  # shared coordinates in a state: the ring's centre (m) and rotation (rad)
PHI_C, X_C, Y_C = 3, 4, 5  # the cage's rotation beyond its kinematic one (rad), its centre (m)
X_I, Y_I = 6, 7  # the inner ring's centre (m)
Z, Z_C, Z_I = (3 * ROW + n for n in range(3))  # along the bearing's axis: outer ring, cage, inner ring (m)
LEAN_X, LEAN_X_C, LEAN_X_I = (4 * ROW + n for n in range(3))  # components of their axes along e_0 (1)
LEAN_Y, LEAN_Y_C, LEAN_Y_I = (5 * ROW + n for n in range(3))  # and along e_90
POSITION, VELOCITY, ACCELERATION = 0 * STATE, 1 * STATE, 2 * STATE

Q, V, A = (block + LANES for block in (POSITION, VELOCITY, ACCELERATION))  # rollers, radially (m)
EPS, EPS_V, EPS_A = (row + ROW for row in (Q, V, A))  # angle from the centre of the own pocket (rad)
SPIN, SPIN_V, SPIN_A = (row + 2 * ROW for row in (Q, V, A))  # rotation beyond the kinematic one (rad)
AXIAL, AXIAL_V, AXIAL_A = (row + 3 * ROW for row in (Q, V, A))  # rollers, along the bearing's axis (m)
AXIS_X, AXIS_X_V, AXIS_X_A = (row + 4 * ROW for row in (Q, V, A))  # component of the own axis along e_0 (1)
AXIS_Y, AXIS_Y_V, AXIS_Y_A = (row + 5 * ROW for row in (Q, V, A))  # and along e_90

_FIRST = 3 * STATE
COS_0, SIN_0, INVERSE_MASS = (_FIRST + n * ROW for n in range(3))  # constants of a lane: angle at theta_c = 0, 1/m
COS, SIN = (_FIRST + n * ROW for n in range(3, 5))  # of the roller's angle now
DELTA_O, V_O, Q_O = (_FIRST + n * ROW for n in range(5, 8))  # outer contact: approach, its rate, force
DELTA_I, V_I, Q_I = (_FIRST + n * ROW for n in range(8, 11))  # inner contact
SLIP_O, SLIP_I, Q_P = (_FIRST + n * ROW for n in range(11, 14))  # slip speeds (m/s), force of the pocket (N)
TILT_O, TILT_I = (_FIRST + n * ROW for n in range(14, 16))  # tangential force on the roller, in a pit (N)
Q_MAX, OVERRUN, OVERRUN_MAX = (_FIRST + n * ROW for n in range(16, 19))  # largest Q_O; seconds over the step limit
Q_I_MAX, Q_P_MAX = (_FIRST + n * ROW for n in range(19, 21))  # largest Q_I and |Q_P|
WORK = _FIRST + 21 * ROW  # rows a model may use within an evaluation
# (the equilibrium uses some of these rows before a motion begins: ``models/equilibrium.py``)
PC, PS, CE, SE = (WORK + n * ROW for n in range(4))  # direction of a roller's pocket; cos and sin of EPS
# outer contact: normal along e_r, e_theta; distance from the ring's centre (m); speed across the normal (m/s)
N_R, N_T, RHO_O, T_O = (WORK + n * ROW for n in range(4, 8))
M_R, M_T, RHO_I, T_I = (WORK + n * ROW for n in range(8, 12))  # the same of the inner contact
PUSH_R, PUSH_T, TORQUE = (WORK + n * ROW for n in range(12, 15))  # on a roller: along e_r, e_theta (N), spin (N m)
F_O, F_I = (WORK + n * ROW for n in range(15, 17))  # friction at the two contacts (N)
APART_O, APART_I = (WORK + n * ROW for n in range(17, 19))  # rates of RHO_O, RHO_I of rollers over a pit (m/s)
# cells, not rows: forces (N) and torques (N m) on ring, cage and inner ring
F_X, F_Y, M_RING, F_X_C, F_Y_C, M_C, F_X_I, F_Y_I = range(WORK + 19 * ROW, WORK + 19 * ROW + 8)
F_Z, M_X, M_Y, F_Z_C, M_X_C, M_Y_C, F_Z_I, M_X_I, M_Y_I = range(WORK + 19 * ROW + 8, WORK + 19 * ROW + 17)
WORKS = 20
LINEAR = WORK + WORKS * ROW  # rows that ``linearise`` may use, within one call
LINEARS = 86
STAGE = LINEAR + LINEARS * ROW  # states a method may use, between evaluations
STAGES = 56
LOADED = STAGE + STAGES * STATE  # one cell: rollers that carry load
# cells of a method: the step it stands in, from and to (s), the length it will try next (s); why it cannot go on
# (``core/outcomes.py``; 0 while it can) and the body concerned; steps taken and refused, evaluations of the model,
# Newton iterations; crossings of pits seen
T_START, T_END, H_NEXT, FAILED, FAILED_BODY, TAKEN, REFUSED, EVALUATED, ITERATED, CROSSED = range(
    LOADED + 1, LOADED + 11
)
# the time it stops at next (s), the length of the step taken last (s) and its error; dense output complete?
NEXT_STOP, H_TAKEN, LAST_ERROR, DENSE = range(LOADED + 11, LOADED + 15)
# of each of the first pits' meetings: 1 + the number of the roller that stands in it, 0: none; rollers seen in it
MET, CROSSINGS = LOADED + 2 * VECTOR, LOADED + 2 * VECTOR + ROW
BURDEN = LOADED + 2 * VECTOR + 2 * ROW  # part of the method's step limit that each watched body takes up

# what forces and torques accelerate a roller by, and (cells) the bodies of the shared coordinates X to Y_I (1/kg,
# 1/(kg m^2)); how the place (m) and velocity (m/s) of each roller, as a body sees it, change along e_r, e_theta;
# what follows, of force along e_r, e_theta (N) and torque (N m) on it, and on these shared coordinates
PER_R, PER_T, PER_M, MOBILITY, P_R, P_T, W_R, W_T, CHANGE_R, CHANGE_T, CHANGE_M, CHANGE_SHARED = (
    LINEAR + LANES + n * ROW for n in range(12)
)
BY_OUTER, BY_INNER, BY_POCKET = (LINEAR + LANES + n * ROW for n in (19, 43, 67))  # rows of contacts
WRENCHES = LINEAR + 4 * ROW  # in ``spatial``: matrices of each roller (``parts/wrench.py``)

# a matrix of the arrow's shape (``methods/arrow.py``): rows of the rollers' own blocks, of what the border does to
# a roller, of what a roller does to the border; cells of the border's own block
MOST_OWN, MOST_BORDER = 6, 17  # coordinates of a roller, and shared ones
OWN_BLOCK, FROM_BORDER, TO_BORDER = 0, MOST_OWN * MOST_OWN * ROW, MOST_OWN * (MOST_OWN + MOST_BORDER) * ROW
BORDER_BLOCK = MOST_OWN * (MOST_OWN + 2 * MOST_BORDER) * ROW
ARROW_SIZE = BORDER_BLOCK + -(-MOST_BORDER * (MOST_BORDER + 2) // ROW) * ROW
BY_POSITION = LOADED + 2 * VECTOR + 3 * ROW  # d(acceleration)/d(position)
BY_VELOCITY = BY_POSITION + ARROW_SIZE  # d(acceleration)/d(velocity)
SYSTEM = BY_VELOCITY + ARROW_SIZE  # the matrix that a method solves with
SIZE = SYSTEM + ARROW_SIZE

# what only ``spatial`` has: rows of a roller
_SPACE = SIZE + LANES
# its axis along e_r, e_theta, e_z, and the rates of these; speed about the axis (rad/s); surface speed (m/s)
TILT, SKEW, UPRIGHT, TILT_V, SKEW_V, UPRIGHT_V, OMEGA, ROLLING = (_SPACE + n * ROW for n in range(8))
PUSH_Z, TURN_R, TURN_T, TURN_Z = (_SPACE + n * ROW for n in range(8, 12))  # force (N), moment (N m) on a roller
SHIFT_SKEW = _SPACE + 12 * ROW  # change of the skew's rate within the lag (rad/s)
# a roller in its pocket: distance from the middle (m), its rate (m/s), slip along the wall and the axis (m/s), in
# the roller's middle and their growth along it (IN_*); relative turning about the cage's axis and radius (rad/s)
GAP, GAP_V, WALL, WALL_Z, IN_GAP, IN_GAP_V, IN_WALL, IN_WALL_Z = (_SPACE + n * ROW for n in range(13, 21))
SPINS, SWINGS = (_SPACE + n * ROW for n in range(21, 23))
N_W, N_RAD, N_AX, H_W, H_RAD, H_AX, C_AX, C_RAD = (_SPACE + n * ROW for n in range(23, 31))  # sums over slices
Q_F = _SPACE + 31 * ROW  # force of the flanges on a roller along the bearing's axis (N)
TILT_MAX, LINE_MAX = (_SPACE + n * ROW for n in range(32, 34))  # largest |tilt| (rad) and line load (N/m)
RUB_F, RUB_P = (_SPACE + n * ROW for n in range(34, 36))  # friction over slip, flanges and pocket (N s/m)
_SPACE_ROWS = 36

# rows of one side of a roller (add ``OUTER_SIDE`` or ``INNER_SIDE``); see core/parts/races_in_space.py
OUTER_SIDE = SIZE + _SPACE_ROWS * ROW + LANES
RING_R, RING_T = (n * ROW for n in range(2))  # the ring's axis along e_r, e_theta
APART_R, APART_T, APART_Z, ALONG_R, ALONG_T, ALONG_Z = (n * ROW for n in range(2, 8))
MOVES_R, MOVES_T, MOVES_Z, TURNS_R, TURNS_T, TURNS_Z = (n * ROW for n in range(8, 14))
ROLLS, DRIFT, DRIFTS, SWAY_R, SWAY_T, SWAY_Z = (n * ROW for n in range(14, 20))
G_R, G_T, G_Z, H_R, H_T, H_Z, TWIST, BEND_R, BEND_T, BEND_Z = (n * ROW for n in range(20, 30))
K_0, K_1, K_2, KS_0, KS_1, KS_Z = (n * ROW for n in range(30, 36))  # sums of friction over slip, for the lag
K_ARM, K_R, K_T, K_Z, SHIFT, SHIFT_Z, OVER = (n * ROW for n in range(36, 43))  # ...; over a pit?
# of the slice at hand: force, approach, its rate; slips along the race and the axis, friction over slip; n, rho
LOAD, APPROACH, CLOSING, SLIP_T, SLIP_Z, KAPPA, OUT_R, OUT_T, OUT_Z, FAR = (n * ROW for n in range(43, 53))
# and what it feels of a pit: depth (m), tangent of the normal's tilt, 1 - its cosine, stiffness lost, own?
SINK, LEAN, BENT, LOST, OWN = (n * ROW for n in range(53, 58))
SIDE_ROWS = 58
INNER_SIDE = OUTER_SIDE + SIDE_ROWS * ROW

SLICES = SIZE + (_SPACE_ROWS + 2 * SIDE_ROWS) * ROW
LOAD_O, LOAD_I, APPROACH_O, APPROACH_I = range(4)  # rows of a slice: force (N), approach (m) at the two races
SLICE_ROWS = 4


@jit
def own_block(matrix, i, k):
    """Where the lanes of d(coordinate i of a roller)/d(its coordinate k) begin, in the arrow at ``matrix``."""
    return matrix + OWN_BLOCK + (i * MOST_OWN + k) * ROW + LANES


@jit
def from_border(matrix, i, k):
    """The lanes of d(coordinate i of a roller)/d(shared coordinate k)."""
    return matrix + FROM_BORDER + (i * MOST_BORDER + k) * ROW + LANES


@jit
def to_border(matrix, k, i):
    """The lanes of d(shared coordinate k)/d(coordinate i of a roller)."""
    return matrix + TO_BORDER + (k * MOST_OWN + i) * ROW + LANES


@jit
def border_block(matrix, k, m):
    """The cell of d(shared coordinate k)/d(shared coordinate m)."""
    return matrix + BORDER_BLOCK + k * MOST_BORDER + m


@jit
def shared_cell(k):
    """Where shared coordinate ``k`` (0 to 16) stands in a block of the state: X to Y_I, then those of ``spatial``.

    8, 9, 10: Z, Z_C, Z_I; 11, 12, 13: LEAN_X, LEAN_X_C, LEAN_X_I; 14, 15, 16: LEAN_Y, LEAN_Y_C, LEAN_Y_I.
    """
    return k if k < LANES else (3 + (k - LANES) // 3) * ROW + (k - LANES) % 3


@jit
def slice_row(k, i):
    """Where the lanes of row ``i`` of slice ``k`` begin."""
    return SLICES + (k * SLICE_ROWS + i) * ROW + LANES


def buffer(Z: int, m_r: float, slices: int = 0) -> np.ndarray:
    """A zeroed buffer with the lane constants of Z evenly spaced rollers of mass ``m_r`` (kg).

    slices: how many a roller is cut into, in ``spatial``; 0 in models that know of none. ``m_r`` = 0 (models whose
    rollers have no mass) leaves the rollers' inverse mass 0: their lanes stand still.
    """
    y = np.zeros(SLICES + slices * SLICE_ROWS * ROW if slices else SIZE)
    angle = 2.0 * np.pi * np.arange(Z) / Z
    y[COS_0 : COS_0 + Z] = np.cos(angle)
    y[SIN_0 : SIN_0 + Z] = np.sin(angle)
    y[INVERSE_MASS : INVERSE_MASS + Z] = 1.0 / m_r if m_r > 0.0 else 0.0
    return y
