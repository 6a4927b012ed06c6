"""Layout of the flat buffer of a simulation; each row is declared once, with unit, owners and lifetime.

A loop over rollers is vectorised only if the compiler can prove that rows do not overlap and that no index is
negative. It can prove this if all rows lie in one buffer at constant offsets and loops start from zero. (With
separate arrays the run-time checks for overlap cost as much as the computation; a loop from 8 stays scalar.) A row
contains the shared coordinates (ring, cage, inner ring), then one lane per roller, padded to the vector width.
Padded lanes have cos = sin = 0 and an inverse mass of 0, so they do not affect the result.

A state (positions, velocities, accelerations) is a block of six rows, one for each coordinate of a roller:
radial position, angle, spin, axial position, and two components of its axis. The shared coordinates precede the
lanes: those in the plane in the first row, those of ``spatial`` in the last three. Simpler models use fewer rows.

A buffer with slices ends with the rows of ``spatial``: those of a roller, of each of its two sides, and of each
slice (``slice_row``).

The names of rows are offsets: ``y[lay.RADIAL + j]`` is roller j's radial position, ``y[lay.POSITION + lay.X]`` the
ring's, with ``from bearingsim.core import layout as lay``. ``rows.py`` describes declarations and rejects
overlaps; ``free_rows`` lists the rows that a model may still declare. The owners:

``all``          every model and method
``bent``         static equilibrium of a flexible ring; ``bent-search``: its Newton step, which overwrites the
                 springs' forces
``rest``         static equilibrium of rollers and ring in the plane
``linearise``    analytic Jacobian of ``planar``; ``differences``: Jacobian by finite differences
``adaptive``     every adaptive method
other names      the model or method of this name
"""

from functools import partial

import numpy as np

from bearingsim.core.jit import jit
from bearingsim.core.rows import ALL_OWNERS, DECLARED, declare

VECTOR_WIDTH = 8  # doubles in the widest vector register
FIRST_LANE = 8  # first lane of a row; the shared coordinates precede it
MAX_ROLLERS = 104
ROW = FIRST_LANE + MAX_ROLLERS
STATE = 6 * ROW

rows = partial(declare, step=ROW, size=MAX_ROLLERS)  # lanes of rollers
full_rows = partial(declare, step=ROW, size=ROW)
cells = partial(declare, step=1, size=1)
states = partial(declare, step=STATE, size=STATE)
FLEXIBLE_RING = "ring rollers bent"  # owners of rows of a flexible ring
BODIES = "planar spatial linearise differences rest"  # owners of coordinates beyond the radial ones

# the state: positions (m, rad), velocities (m/s, rad/s), accelerations (m/s^2, rad/s^2)
POSITION, VELOCITY, ACCELERATION = BLOCKS = 0 * STATE, 1 * STATE, 2 * STATE
# rollers: radial position; angle from the pocket's centre, rotation in addition to the kinematic one, axial
# position, components of the roller's axis along e_0 and e_90
RADIAL, RADIAL_V, RADIAL_A = declare(
    FIRST_LANE, "m, m/s, m/s^2", f"rollers {BODIES}", "run", size=MAX_ROLLERS, step=STATE
)
EPS, SPIN, AXIAL, AXIS_X, AXIS_Y = rows(RADIAL + ROW, "rad, rad, m, 1, 1", BODIES, "run")
EPS_V, SPIN_V, AXIAL_V, AXIS_X_V, AXIS_Y_V = rows(RADIAL_V + ROW, "rad/s, rad/s, m/s, 1/s, 1/s", BODIES, "run")
EPS_A, SPIN_A, AXIAL_A, AXIS_X_A, AXIS_Y_A = rows(
    RADIAL_A + ROW, "rad/s^2, rad/s^2, m/s^2, 1/s^2, 1/s^2", BODIES, "run"
)
# shared coordinates, relative to a block; units are those of POSITION. The ring's centre and rotation; the cage's
# rotation in addition to the kinematic one, and its centre; the inner ring's centre
X, Y, PSI, PHI_C, X_C, Y_C, X_I, Y_I = cells(0, "m, m, rad, rad, m, m, m, m", "all", "run", bases=BLOCKS)
# axial positions of outer ring, cage, inner ring; components of their axes along e_0 and e_90
Z, Z_C, Z_I = cells(3 * ROW, "m", BODIES, "run", count=3, bases=BLOCKS)
RING_TILT_X, CAGE_TILT_X, INNER_TILT_X = cells(4 * ROW, "1", BODIES, "run", count=3, bases=BLOCKS)
RING_TILT_Y, CAGE_TILT_Y, INNER_TILT_Y = cells(5 * ROW, "1", BODIES, "run", count=3, bases=BLOCKS)
# cosine and sine amplitudes of a flexible ring's harmonics, in models whose rollers move only radially
MODES_C, MODES_S = full_rows(ROW, "m", FLEXIBLE_RING, "run", count=2, bases=BLOCKS)

# constants and results of each roller, after the three blocks of the state
_ROLLER_ROWS = 3 * STATE
COS_0, SIN_0, INVERSE_MASS = rows(_ROLLER_ROWS, "1, 1, 1/kg", "all", "constant")  # angle at theta_c = 0
COS, SIN = rows(_ROLLER_ROWS + 3 * ROW, "1", "all", "evaluation", count=2)  # current angle
# contacts with the outer and the inner race: approach, its rate, force
DELTA_O, V_O, Q_O, DELTA_I, V_I, Q_I = rows(_ROLLER_ROWS + 5 * ROW, "m, m/s, N", "all", "evaluation", count=2)
# slips at the races, force of the pocket, tangential forces on the roller over a defect
SLIP_O, SLIP_I, Q_P, DEFECT_FORCE_O, DEFECT_FORCE_I = rows(
    _ROLLER_ROWS + 11 * ROW, "m/s, m/s, N, N, N", "all", "evaluation"
)
# largest Q_O; uninterrupted time over the step limit, and its largest value; largest Q_I and |Q_P|
Q_O_MAX, OVERRUN, OVERRUN_MAX, Q_I_MAX, Q_P_MAX = rows(_ROLLER_ROWS + 16 * ROW, "N, s, s, N, N", "all", "run")

# WORK: rows of one evaluation of the model
WORK, WORK_ROWS = _ROLLER_ROWS + 21 * ROW, 21
PLANE = "planar linearise"  # owners of rows of a contact in the plane
# direction of a roller's pocket; cos and sin of EPS
COS_POCKET, SIN_POCKET, COS_EPS, SIN_EPS = rows(WORK, "1", f"{PLANE} spatial", "evaluation", count=4)
# outer and inner contact: normal along e_r, e_theta; distance from the ring's centre; speed perpendicular to the
# normal
NORMAL_O_R, NORMAL_O_T, RHO_O, TANGENTIAL_V_O = rows(WORK + 4 * ROW, "1, 1, m, m/s", PLANE, "evaluation")
NORMAL_I_R, NORMAL_I_T, RHO_I, TANGENTIAL_V_I = rows(WORK + 8 * ROW, "1, 1, m, m/s", PLANE, "evaluation")
# force on a roller along e_r and e_theta, torque about its axis
FORCE_R, FORCE_T, TORQUE = rows(WORK + 12 * ROW, "N, N, N m", f"{PLANE} spatial", "evaluation")
# outward deflection of a flexible outer race at each roller, and its rate along the roller's path
DEFLECTION, DEFLECTION_V = rows(WORK + 7 * ROW, "m, m/s", FLEXIBLE_RING, "evaluation")
# friction at the two contacts; rates of RHO_O, RHO_I of rollers over a defect
FRICTION_O, FRICTION_I, RHO_V_O, RHO_V_I = rows(WORK + 15 * ROW, "N, N, m/s, m/s", PLANE, "evaluation")
# forces and torques on outer ring, cage and inner ring, in the plane and out of it; M_INNER: torque on the inner
# ring about its axis
F_X, F_Y, M_RING, F_X_C, F_Y_C, M_C, F_X_I, F_Y_I = cells(
    WORK + 19 * ROW, "N, N, N m, N, N, N m, N, N", "all", "evaluation"
)
F_Z, M_X, M_Y, F_Z_C, M_X_C, M_Y_C, F_Z_I, M_X_I, M_Y_I = cells(
    F_Y_I + 1, "N, N m, N m", "all", "evaluation", count=3
)
(M_INNER,) = cells(M_Y_I + 1, "N m", "all", "evaluation")
LOADS = 18  # cells from F_X to M_INNER
# radial motion of a flexible ring at its sensor
SENSOR, SENSOR_V, SENSOR_A = cells(WORK + 19 * ROW + MAX_ROLLERS, "m, m/s, m/s^2", "all", "evaluation")
(DEFECT_TORQUE,) = rows(WORK + 20 * ROW, "N m", PLANE, "evaluation")  # on a roller, due to its own defects
SPRINGS_X, SPRINGS_Y = cells(WORK + 20 * ROW + MAX_ROLLERS, "N", FLEXIBLE_RING, "evaluation", count=2)

# JACOBIAN_WORK: rows of one call of ``linearise``, also used by models without an analytic Jacobian
JACOBIAN_WORK, JACOBIAN_WORK_ROWS = WORK + WORK_ROWS * ROW, 86
# ACCELERANCE: acceleration per unit of force or torque, of a roller's radius, angle and spin, and (cells) of the
# shared coordinates X to Y_I. D: changes per unit of a coordinate, of a roller's position and velocity relative to
# a body along e_r and e_theta, of force and torque on the roller, and of its loads on these shared coordinates (a
# row each)
linearise_rows = partial(rows, owners="linearise", lifetime="linearise")
ACCELERANCE_R, ACCELERANCE_T, ACCELERANCE_SPIN, ACCELERANCE_SHARED = linearise_rows(
    JACOBIAN_WORK + FIRST_LANE, "1/kg, 1/(kg m), 1/(kg m^2), 1/kg"
)
D_POSITION_R, D_POSITION_T, D_VELOCITY_R, D_VELOCITY_T = linearise_rows(ACCELERANCE_SHARED + ROW, "m, m, m/s, m/s")
D_FORCE_R, D_FORCE_T, D_TORQUE = linearise_rows(D_VELOCITY_T + ROW, "N, N, N m")
D_FORCE_SHARED = linearise_rows(D_TORQUE + ROW, "N", count=FIRST_LANE)[0]
# rows of contacts: ``parts/races.py``, ``parts/cage_derivatives.py``
OUTER_CONTACT, INNER_CONTACT, POCKET_CONTACT = (JACOBIAN_WORK + FIRST_LANE + n * ROW for n in (19, 43, 67))
# loads of each roller on the cells F_X to M_INNER
ROLLER_LOADS = full_rows(
    JACOBIAN_WORK + 18 * ROW, "N", "ring rollers planar spatial differences", "evaluation", count=LOADS
)[0]
# differences (``models/differences.py``): the reference state; its ROLLER_LOADS; cells of their sums, then 1 for
# each shared coordinate that loads accelerate
(REFERENCE_STATE,) = declare(JACOBIAN_WORK, "m", "differences", "linearise", size=3 * STATE, step=0)
REFERENCE_ROLLER_LOADS = full_rows(JACOBIAN_WORK + 36 * ROW, "N", "differences", "linearise", count=LOADS)[0]
(REFERENCE_LOADS,) = full_rows(JACOBIAN_WORK + 54 * ROW, "N", "differences", "linearise")
# flexible ring: cosine and sine of n times the angle of the first roller for each harmonic n; amplitudes and their
# rates in the frame of the rollers; generalised forces of the rollers on the amplitudes
PHASE_C, PHASE_S, AMPLITUDE_C, AMPLITUDE_S, AMPLITUDE_V_C, AMPLITUDE_V_S, ROLLER_FORCE_C, ROLLER_FORCE_S = (
    full_rows(JACOBIAN_WORK + 54 * ROW, "1, 1, m, m, m/s, m/s, N, N", f"{FLEXIBLE_RING} bent-search", "evaluation")
)
# springs around the ring: generalised forces on the amplitudes; compression, its rate and force of each spring
SPRING_FORCE_C, SPRING_FORCE_S = full_rows(JACOBIAN_WORK + 71 * ROW, "N", FLEXIBLE_RING, "evaluation", count=2)
MAX_SPRINGS = 4 * ROW
COMPRESSION, COMPRESSION_V, SPRING_FORCE = declare(
    JACOBIAN_WORK + 73 * ROW,
    "m, m/s, N",
    f"{FLEXIBLE_RING} bent-search",
    "evaluation",
    size=MAX_SPRINGS,
    step=MAX_SPRINGS,
)

# STAGE: states that a method keeps between evaluations, declared by the methods
STAGE, STAGE_STATES = JACOBIAN_WORK + JACOBIAN_WORK_ROWS * ROW, 56

# addends of a sum over the cells of a state or of up to seven sums over lanes, valid until they are summed
# (``sums.py``)
ADDEND_ROWS = 7
ADDENDS = full_rows(STAGE + STAGE_STATES * STATE, "unit of the sum", "all", "evaluation", count=ADDEND_ROWS)[0]

# cells of a run: number of rollers that carry load
(LOADED_ROLLERS,) = cells(ADDENDS + ADDEND_ROWS * ROW, "1", "all", "run")
# cells of a method: start and end of the current step, length of the next trial step; outcome
# (``core/outcomes.py``; 0: no failure) and the body concerned; steps accepted and rejected, evaluations of the
# model, Newton iterations; crossings of defects
T_START, T_END, H_NEXT, FAILED, FAILED_BODY = cells(LOADED_ROLLERS + 1, "s, s, s, 1, 1", "all", "run")
STEPS_TAKEN, STEPS_REJECTED, EVALUATIONS, NEWTON_ITERATIONS, DEFECT_CROSSINGS = cells(
    FAILED_BODY + 1, "1", "all", "run", count=5
)
# time of the next stop (end of a step that may not be passed), length of the last step and its error; 1 if dense
# output is complete
NEXT_STOP, H_TAKEN, LAST_ERROR, DENSE_READY = cells(LOADED_ROLLERS + 11, "s, s, 1, 1", "all", "run")
# CPU time at which compiled loops end, 0: never (``clock.py``)
(CPU_END,) = cells(LOADED_ROLLERS + 15, "s", "all", "run")
# largest forces Q_O, Q_I, |Q_P| of any roller in this ball pass at the ends of an adaptive method's steps; unlike
# Q_O_MAX, they exclude recorded instants
(LARGEST_AT_ENDS,) = cells(LOADED_ROLLERS + 2 * VECTOR_WIDTH, "N", "adaptive", "run", count=3)[:1]
# for each roller-defect pair (up to ROW): 1 + index of the roller over the defect, or 0; number of crossings. For
# each monitored body: step over the method's step limit. For each roller: larger approach to an undamaged race
ROLLER_IN_DEFECT, PAIR_CROSSINGS, STEP_RATIO, APPROACH_NOW = full_rows(
    LOADED_ROLLERS + 3 * VECTOR_WIDTH, "1, 1, 1, m", "all", "run"
)
# forces Q_O, Q_I, |Q_P| at the start and at the end of an adaptive method's step
FORCES_AT_START, FORCES_AT_END = full_rows(APPROACH_NOW + ROW, "N", "adaptive", "run", count=6)[::3]

# arrow matrix (``methods/arrow.py``): rows of the rollers' diagonal blocks; rows of the border, the derivatives of
# a roller's coordinates with respect to the shared ones (columns) and the reverse (rows); cells of the corner
# block, of the shared coordinates
MAX_PER_ROLLER, MAX_SHARED = 6, 17  # largest numbers of coordinates of a roller and of shared coordinates
DIAGONAL_BLOCK, BORDER_COLUMN, BORDER_ROW = (
    0,
    MAX_PER_ROLLER * MAX_PER_ROLLER * ROW,
    MAX_PER_ROLLER * (MAX_PER_ROLLER + MAX_SHARED) * ROW,
)
CORNER_BLOCK = MAX_PER_ROLLER * (MAX_PER_ROLLER + 2 * MAX_SHARED) * ROW
ARROW_SIZE = CORNER_BLOCK + -(-MAX_SHARED * (MAX_SHARED + 2) // ROW) * ROW
# d(acceleration)/d(position), d(acceleration)/d(velocity); matrix of the equations that an implicit method solves
POSITION_JACOBIAN, VELOCITY_JACOBIAN, SYSTEM = declare(
    LOADED_ROLLERS + 11 * ROW,
    "1/s^2, 1/s, 1",
    "linearise differences ring rollers",
    "step",
    size=ARROW_SIZE,
    step=ARROW_SIZE,
)
BUFFER_SIZE = SYSTEM + ARROW_SIZE

# rows of a roller in ``spatial`` only
_SPACE, _SPACE_ROWS = BUFFER_SIZE + FIRST_LANE, 36
spatial_rows = partial(rows, owners="spatial", lifetime="evaluation")
# axis along e_r, e_theta, e_z, and its rate of change; speed about the axis; rolling speed
TILT, SKEW, AXIS_Z, TILT_V, SKEW_V, AXIS_Z_V, OMEGA, ROLLING_SPEED = spatial_rows(
    _SPACE, "1, 1, 1, 1/s, 1/s, 1/s, rad/s, m/s"
)
# axial force and moments on a roller; change of the rate of skew within the lag
FORCE_Z, MOMENT_R, MOMENT_T, MOMENT_Z, SKEW_V_CHANGE = spatial_rows(_SPACE + 8 * ROW, "N, N m, N m, N m, rad/s")
# a roller in its pocket, at the roller's centre: distance from the pocket's centre, its rate, slip along the wall
# and along the cage's axis; their derivatives along the roller (*_SLOPE); relative angular velocity about the
# cage's axis and about the pocket's radial direction
POCKET_OFFSET, POCKET_OFFSET_V, POCKET_SLIP, POCKET_SLIP_Z = spatial_rows(_SPACE + 13 * ROW, "m, m/s, m/s, m/s")
POCKET_OFFSET_SLOPE, POCKET_OFFSET_V_SLOPE, POCKET_SLIP_SLOPE, POCKET_SLIP_Z_SLOPE = spatial_rows(
    _SPACE + 17 * ROW, "1, 1/s, 1/s, 1/s"
)
POCKET_OMEGA_Z, POCKET_OMEGA_R = spatial_rows(_SPACE + 21 * ROW, "rad/s, rad/s")
# sums over slices
POCKET_FORCE_W, POCKET_FORCE_R, POCKET_FORCE_Z = spatial_rows(_SPACE + 23 * ROW, "N", count=3)
POCKET_ZETA_FORCE_W, POCKET_ZETA_FORCE_R, POCKET_ZETA_FORCE_Z = spatial_rows(_SPACE + 26 * ROW, "N m", count=3)
POCKET_COUPLE_Z, POCKET_COUPLE_R = spatial_rows(_SPACE + 29 * ROW, "N m", count=2)
(Q_F,) = spatial_rows(_SPACE + 31 * ROW, "N")  # axial force of the flanges
TILT_MAX, LINE_LOAD_MAX = rows(_SPACE + 32 * ROW, "rad, N/m", "spatial", "run")  # largest |tilt| and line load
KAPPA_F, KAPPA_P = spatial_rows(_SPACE + 34 * ROW, "N s/m", count=2)  # friction over slip: flanges, pocket

# rows of one side of a roller, relative to OUTER_SIDE or INNER_SIDE (``parts/races_in_space.py``). A relative
# offset alone lies far outside any buffer, so an index without its side raises an error or ends the process
# instead of changing data
RELATIVE = 2**40
_SIDE, SIDE_ROWS = BUFFER_SIZE + _SPACE_ROWS * ROW + FIRST_LANE, 48
OUTER_SIDE, INNER_SIDE = SIDES = _SIDE - RELATIVE, _SIDE + SIDE_ROWS * ROW - RELATIVE
side_rows = partial(spatial_rows, bases=SIDES)
# the ring's axis along e_r, e_theta; centre and direction of the contact line relative to the ring, and their
# rates
RING_AXIS_R, RING_AXIS_T = side_rows(RELATIVE, "1, 1")
OFFSET_R, OFFSET_T, OFFSET_Z, DIRECTION_R, DIRECTION_T, DIRECTION_Z = side_rows(
    RELATIVE + 2 * ROW, "m, m, m, 1, 1, 1"
)
OFFSET_V_R, OFFSET_V_T, OFFSET_V_Z, DIRECTION_V_R, DIRECTION_V_T, DIRECTION_V_Z = side_rows(
    RELATIVE + 8 * ROW, "m/s, m/s, m/s, 1/s, 1/s, 1/s"
)
ROLL_SPEED, AXIAL_SLIP, AXIAL_SLIP_SLOPE, AXIAL_SLIP_ARM_R, AXIAL_SLIP_ARM_T, AXIAL_SLIP_ARM_Z = side_rows(
    RELATIVE + 14 * ROW, "m/s, m/s, 1/s, rad/s, rad/s, rad/s"
)
# sums over slices
CONTACT_FORCE_R, CONTACT_FORCE_T, CONTACT_FORCE_Z = side_rows(RELATIVE + 20 * ROW, "N", count=3)
CONTACT_ZETA_FORCE_R, CONTACT_ZETA_FORCE_T, CONTACT_ZETA_FORCE_Z = side_rows(RELATIVE + 23 * ROW, "N m", count=3)
COUPLE_AXIAL, COUPLE_R, COUPLE_T, COUPLE_Z = side_rows(RELATIVE + 26 * ROW, "N m", count=4)
# sums of friction over slip (kappa), for the lag: moments of order 0 to 2 along the roller; kappa times the slip;
# kappa weighted by arm and by direction
KAPPA_0, KAPPA_1, KAPPA_2, KAPPA_SLIP_0, KAPPA_SLIP_1, KAPPA_SLIP_Z = side_rows(
    RELATIVE + 30 * ROW, "N s/m, N s, N m s, N, N m, N"
)
KAPPA_ARM, KAPPA_R, KAPPA_T, KAPPA_Z = side_rows(RELATIVE + 36 * ROW, "N s, N s/m, N s/m, N s/m")
# changes of the slips within the lag; position of a slice relative to a defect (values: ``defects/on_slices.py``)
SLIP_CHANGE, SLIP_CHANGE_Z, DEFECT_STATE = side_rows(RELATIVE + 40 * ROW, "m/s, m/s, 1")
# defect at the current slice: drop; tangent of the normal's tilt, and 1 - cosine of the tilt; lost fraction of the
# stiffness; 1 if the defect is on the roller, else 0
ROLLER_DROP, NORMAL_SLOPE, NORMAL_VERSINE, STIFFNESS_LOSS, ROLLER_DEFECT = side_rows(
    RELATIVE + 43 * ROW, "m, 1, 1, 1, 1"
)

# rows of a slice (``slice_row``): force (N) and approach (m) at the two races
SLICES = BUFFER_SIZE + (_SPACE_ROWS + 2 * SIDE_ROWS) * ROW
LOAD_O, LOAD_I, APPROACH_O, APPROACH_I = range(4)
SLICE_ROWS = 4


@jit
def diagonal_block(matrix, i, k):
    """Return the first lane of the entries (``i``, ``k``) of the rollers' diagonal blocks in the arrow matrix at
    ``matrix``."""
    return matrix + DIAGONAL_BLOCK + (i * MAX_PER_ROLLER + k) * ROW + FIRST_LANE


@jit
def border_column(matrix, i, k):
    """Return the first lane of the entries in row ``i`` of each roller and the column of shared coordinate
    ``k``."""
    return matrix + BORDER_COLUMN + (i * MAX_SHARED + k) * ROW + FIRST_LANE


@jit
def border_row(matrix, k, i):
    """Return the first lane of the entries in the row of shared coordinate ``k`` and column ``i`` of each
    roller."""
    return matrix + BORDER_ROW + (k * MAX_PER_ROLLER + i) * ROW + FIRST_LANE


@jit
def corner_block(matrix, k, m):
    """Return the cell of the entry in the row of shared coordinate ``k`` and the column of shared coordinate
    ``m``."""
    return matrix + CORNER_BLOCK + k * MAX_SHARED + m


@jit
def shared_cell(k):
    """Return the cell of shared coordinate ``k`` (0 to 16) in a block of the state: X to Y_I, then those of
    ``spatial``.

    8, 9, 10: Z, Z_C, Z_I; 11, 12, 13: RING_TILT_X, CAGE_TILT_X, INNER_TILT_X; 14, 15, 16: RING_TILT_Y,
    CAGE_TILT_Y, INNER_TILT_Y.
    """
    return k if k < FIRST_LANE else (3 + (k - FIRST_LANE) // 3) * ROW + (k - FIRST_LANE) % 3


@jit
def roller_load(cell):
    """Return the first lane of the row of ROLLER_LOADS for ``cell``, one of F_X to M_INNER."""
    return ROLLER_LOADS + (cell - F_X) * ROW + FIRST_LANE


@jit
def slice_row(k, i):
    """Return the first lane of row ``i`` of slice ``k``."""
    return SLICES + (k * SLICE_ROWS + i) * ROW + FIRST_LANE


def lane_of(cells: np.ndarray) -> np.ndarray:
    """Return the roller (from 0) in whose lane each of ``cells`` of the buffer lies; -1 for shared cells.

    Between COS_0 and LOADED_ROLLERS lanes must begin at a multiple of ROW. Those of ``linearise``, ``roller_load``
    and STAGE begin FIRST_LANE later, and the cells F_X to M_INNER count as lanes: none of these can be recorded.
    """
    starts_with_lanes = (cells >= COS_0) & (cells < LOADED_ROLLERS)  # rows that begin with the lanes
    lane = cells % ROW - np.where(starts_with_lanes, 0, FIRST_LANE)
    return np.where((lane >= 0) & (lane < MAX_ROLLERS), lane, -1)


def free_rows(owner: str) -> dict[str, list[int]]:
    """Return the rows that ``owner`` may declare, by the region WORK or JACOBIAN_WORK, counted from its start.

    For a new model, ``owner`` is its name and those of the models and parts whose functions it calls, separated by
    blanks. Only rows of imported modules are taken into account.
    """
    owners = {*owner.split(), ALL_OWNERS}
    occupied = {
        cell // ROW
        for declaration in DECLARED
        if owners & declaration.owners
        for begin, end in declaration.spans
        for cell in range(begin, end)
    }
    regions = {"WORK": (WORK, WORK_ROWS), "JACOBIAN_WORK": (JACOBIAN_WORK, JACOBIAN_WORK_ROWS)}
    return {
        name: [n for n in range(count) if start // ROW + n not in occupied]
        for name, (start, count) in regions.items()
    }


def aligned_zeros(size: int) -> np.ndarray:
    """Return zeros (size,), aligned so that a vector of lanes lies in one cache line.

    A vector that spans two cache lines takes longer to load and store (docs/evidence/speed.md).
    """
    padded = np.zeros(size + VECTOR_WIDTH)
    start = -(padded.ctypes.data // padded.itemsize) % VECTOR_WIDTH
    return padded[start : start + size]


def make_buffer(Z: int, m_r: float, slices: int = 0) -> np.ndarray:
    """Make a zeroed buffer with the lane constants of Z evenly spaced rollers of mass ``m_r`` (kg).

    slices: number of slices of a roller in ``spatial``; 0 in other models. With ``m_r`` = 0 (models with massless
    rollers) the rollers' inverse mass is 0 and their lanes do not move.
    """
    y = aligned_zeros(SLICES + slices * SLICE_ROWS * ROW if slices else BUFFER_SIZE)
    angle = 2.0 * np.pi * np.arange(Z) / Z
    y[COS_0 : COS_0 + Z] = np.cos(angle)
    y[SIN_0 : SIN_0 + Z] = np.sin(angle)
    y[INVERSE_MASS : INVERSE_MASS + Z] = 1.0 / m_r if m_r > 0.0 else 0.0
    return y
