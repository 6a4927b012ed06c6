"""When the force on a roller jumps next: at the cusp of an envelope, or where a pulse begins or ends.

At a cusp the slope of a roller's path falls, so its closing rate and with it the damping force jump; under a pulse
the approach itself jumps. A step that looks across loses its order there, so adaptive methods stop on these places.
The places lie in the head of each meeting (``core/defects.py``), found when it is built (``jumps_of``).
"""

from math import inf, pi
from typing import Any

import numpy as np

from bearingsim.core.defects import FIRST_JUMP, JUMPS, ON, RADIUS, sliding
from bearingsim.core.jit import generic, jit
from bearingsim.core.pit_contact import standing


@generic
def next_cusp(model: Any, t: float, y: np.ndarray) -> float:
    """Time (s) of the next jump of a force, from ``t`` (s) on; inf where there is none.

    Of rollers that move freely it is a prediction from the state in ``y``, which falls short until it is near.
    """


@jit
def way_to_jump(pits, d, s, forwards, spacing):
    """Way (m) from ``s`` to the next jump of meeting ``d``, contacts following each other at ``spacing`` (m).

    forwards: whether s grows.
    """
    least = inf
    for k in range(int(pits.head[d, JUMPS])):
        way = pits.head[d, FIRST_JUMP + k] - s
        way = way if forwards else -way
        least = min(least, way - spacing * np.floor(way / spacing))
    return least


def next_cusp_evenly(model, t, y):
    """``next_cusp`` of rollers that stand evenly spaced and turn without slip: exact."""
    pits, b = model.pits, model.bearing
    soonest = inf
    for d in range(len(pits.head)):
        speed = sliding(pits, d, b)
        if speed != 0.0 and pits.head[d, JUMPS] > 0.0:
            spacing = 2.0 * pi * pits.head[d, RADIUS] / (1 if pits.head[d, ON] >= 0.0 else b.Z)
            _, s = standing(model, d, t, y)
            soonest = min(soonest, t + way_to_jump(pits, d, s, speed > 0.0, spacing) / abs(speed))
    return soonest
