"""Where everything lies in the one flat buffer that a simulation works on.

A loop over rollers keeps its vector lanes only if the compiler can see that rows do not overlap and that no
index is negative; it sees both when all rows lie in one buffer at constant offsets and loops count from zero
(with separate arrays the run-time overlap checks cost as much as the work; a loop from 8 stays scalar). A state
row holds the ring's coordinates, then one lane per roller, padded to the vector width. Padded lanes have
cos = sin = 0 and an inverse mass of 0: they compute, and change nothing.

The names of rows are offsets: ``y[Q + j]`` is roller j's position, ``y[POSITION + X]`` the ring's.
"""

import numpy as np

VECTOR = 8  # doubles in the widest vector register
LANES = 8  # where a row's lanes begin; before them the ring's coordinates
MAX_ROLLERS = 64
ROW = LANES + MAX_ROLLERS

X, Y = 0, 1  # the ring's coordinates in a state row
POSITION, VELOCITY, ACCELERATION = 0 * ROW, 1 * ROW, 2 * ROW  # state rows, from the ring's x on
Q, V, A = POSITION + LANES, VELOCITY + LANES, ACCELERATION + LANES  # the rollers' part of them

COS_0, SIN_0, INVERSE_MASS = 3 * ROW, 4 * ROW, 5 * ROW  # constants of a lane: angle at theta_c = 0, 1/m
COS, SIN = 6 * ROW, 7 * ROW  # of the roller's angle now
DELTA_O, V_O, Q_O = 8 * ROW, 9 * ROW, 10 * ROW  # outer contact: approach, its rate, force
DELTA_I, V_I, Q_I = 11 * ROW, 12 * ROW, 13 * ROW  # inner contact
Q_MAX, OVERRUN, OVERRUN_MAX = 14 * ROW, 15 * ROW, 16 * ROW  # largest Q_O so far; seconds over the step limit
STAGE = 17 * ROW  # rows a method may use
STAGES = 6
SIZE = (17 + STAGES) * ROW


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
