"""Where everything lies in the one flat buffer that a simulation works on.

A loop over rollers keeps its vector lanes only if the compiler can see that rows do not overlap; it sees it
when all rows lie in one buffer at constant offsets (with separate arrays the run-time overlap checks cost as
much as the work). So positions, velocities, accelerations and scratch rows share the buffer ``y``. Each row is
``ROW`` long: the ring's coordinates first, then one lane per roller, padded to the vector width. Padded lanes
have cos = sin = 0 and an inverse mass of 0: they compute, and change nothing.
"""

import numpy as np

MAX_ROLLERS = 64
LANES = 8  # the first roller's place in a row; 0 and 1 are the ring's x and y
ROW = LANES + MAX_ROLLERS
VECTOR = 8  # doubles in the widest vector register

X, Y = 0, 1

Q, V, A = 0 * ROW, 1 * ROW, 2 * ROW  # position, velocity, acceleration
COS_0, SIN_0, INVERSE_MASS = 3 * ROW, 4 * ROW, 5 * ROW  # constants of a lane: angle at theta_c = 0, 1/m
COS, SIN = 6 * ROW, 7 * ROW  # of the roller's angle now
DELTA_O, V_O, Q_O = 8 * ROW, 9 * ROW, 10 * ROW  # outer contact: approach, its rate, force
DELTA_I, V_I, Q_I = 11 * ROW, 12 * ROW, 13 * ROW  # inner contact
Q_MAX, OVERRUN, OVERRUN_MAX = 14 * ROW, 15 * ROW, 16 * ROW  # running maximum of Q_O; seconds over the step limit
STAGE = 17 * ROW  # rows a method may use, STAGES of them
STAGES = 6
SIZE = (17 + STAGES) * ROW


def padded(Z: int) -> int:
    """Lanes used for Z rollers: the next multiple of the vector width."""
    return -(-Z // VECTOR) * VECTOR


def buffer(Z: int, m_r: float, m_o: float) -> np.ndarray:
    """A zeroed buffer (SIZE,) with the lane constants of Z evenly spaced rollers of mass ``m_r`` (kg).

    ``m_r`` = 0 (models whose rollers have no mass) leaves the rollers' inverse mass 0: their lanes stand still.
    """
    y = np.zeros(SIZE)
    angle = 2.0 * np.pi * np.arange(Z) / Z
    y[COS_0 + LANES : COS_0 + LANES + Z] = np.cos(angle)
    y[SIN_0 + LANES : SIN_0 + LANES + Z] = np.sin(angle)
    y[INVERSE_MASS + LANES : INVERSE_MASS + LANES + Z] = 1.0 / m_r if m_r > 0.0 else 0.0
    y[INVERSE_MASS + X] = y[INVERSE_MASS + Y] = 1.0 / m_o
    return y
