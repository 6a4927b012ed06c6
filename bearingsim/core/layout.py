"""Where everything lies in the one flat buffer that a simulation works on.

A loop over rollers keeps its vector lanes only if the compiler can see that rows do not overlap and that no
index is negative; it sees both when all rows lie in one buffer at constant offsets and loops count from zero
(with separate arrays the run-time overlap checks cost as much as the work; a loop from 8 stays scalar). A row
holds the shared coordinates (ring, cage, inner ring), then one lane per roller, padded to the vector width.
Padded lanes have cos = sin = 0 and an inverse mass of 0: they compute, and change nothing.

A state (positions, velocities, accelerations) is a block of three rows, one for each coordinate of a roller:
radial, angle, spin. The shared coordinates stand in the first. Models that know less use less of it.

The names of rows are offsets: ``y[Q + j]`` is roller j's radial position, ``y[POSITION + X]`` the ring's.
"""

import numpy as np

VECTOR = 8  # doubles in the widest vector register
LANES = 8  # where a row's lanes begin; before them the shared coordinates
MAX_ROLLERS = 64
ROW = LANES + MAX_ROLLERS
STATE = 3 * ROW

X, Y, PSI = 0, 1, 2  # shared coordinates in a state: the ring's centre (m) and rotation (rad)
PHI_C, X_C, Y_C = 3, 4, 5  # the cage's rotation beyond its kinematic one (rad), its centre (m)
X_I, Y_I = 6, 7  # the inner ring's centre (m)
POSITION, VELOCITY, ACCELERATION = 0 * STATE, 1 * STATE, 2 * STATE

Q, V, A = (block + LANES for block in (POSITION, VELOCITY, ACCELERATION))  # rollers, radially (m)
EPS, EPS_V, EPS_A = (row + ROW for row in (Q, V, A))  # angle from the centre of the own pocket (rad)
SPIN, SPIN_V, SPIN_A = (row + 2 * ROW for row in (Q, V, A))  # rotation beyond the kinematic one (rad)

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
# (the equilibrium uses some of these rows before a motion begins: ``core/equilibrium.py``)
PC, PS, CE, SE = (WORK + n * ROW for n in range(4))  # direction of a roller's pocket; cos and sin of EPS
# outer contact: normal along e_r, e_theta; distance from the ring's centre (m); speed across the normal (m/s)
N_R, N_T, RHO_O, T_O = (WORK + n * ROW for n in range(4, 8))
M_R, M_T, RHO_I, T_I = (WORK + n * ROW for n in range(8, 12))  # the same of the inner contact
PUSH_R, PUSH_T, TORQUE = (WORK + n * ROW for n in range(12, 15))  # on a roller: along e_r, e_theta (N), spin (N m)
F_O, F_I = (WORK + n * ROW for n in range(15, 17))  # friction at the two contacts (N)
APART_O, APART_I = (WORK + n * ROW for n in range(17, 19))  # rates of RHO_O, RHO_I of rollers over a pit (m/s)
# cells, not rows: forces (N) and torques (N m) on ring, cage and inner ring
F_X, F_Y, M_RING, F_X_C, F_Y_C, M_C, F_X_I, F_Y_I = range(WORK + 19 * ROW, WORK + 19 * ROW + 8)
WORKS = 20
STAGE = WORK + WORKS * ROW  # states a method may use, between evaluations
STAGES = 4
LOADED = STAGE + STAGES * STATE  # one cell: rollers that carry load
SIZE = LOADED + VECTOR


def buffer(Z: int, m_r: float) -> np.ndarray:
    """A zeroed buffer (SIZE,) with the lane constants of Z evenly spaced rollers of mass ``m_r`` (kg).

    ``m_r`` = 0 (models whose rollers have no mass) leaves the rollers' inverse mass 0: their lanes stand still.
    """
    y = np.zeros(SIZE)
    angle = 2.0 * np.pi * np.arange(Z) / Z
    y[COS_0 : COS_0 + Z] = np.cos(angle)
    y[SIN_0 : SIN_0 + Z] = np.sin(angle)
    y[INVERSE_MASS : INVERSE_MASS + Z] = 1.0 / m_r if m_r > 0.0 else 0.0
    return y
