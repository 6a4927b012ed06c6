"""The rollers that cross pits, counted as a run sees them, and as many as the angles say.

A run that has seen fewer has stepped over one.
"""

from math import floor
from typing import Any

import numpy as np

from bearingsim.core.geometry.motion import elapsed_times
from bearingsim.core.jit import generic
from bearingsim.core.layout import CROSSED, CROSSINGS, MET, PHI_C, POSITION, ROW, SPIN
from bearingsim.core.pits.on_roller import standing
from bearingsim.core.pits.pairs import HALF_WIDTH, ON, ON_INNER


def spot_in_meetings(model, t, y):
    """``spot`` of models with pits; of the first meetings, as many as a row has room for."""
    for d in range(min(len(model.pits.head), ROW)):
        j, s = standing(model, d, t, y)
        there = j + 1.0 if abs(s) < model.pits.head[d, HALF_WIDTH] else 0.0
        if there != y[MET + d]:
            y[CROSSINGS + d] += 1.0 if there > 0.0 else 0.0
            y[CROSSED] += 1.0 if there > 0.0 else 0.0
            y[MET + d] = there


@generic(otherwise=spot_in_meetings)
def spot(model: Any, t: float, y: np.ndarray) -> None:
    """Count the rollers that stand newly over a pit at time ``t`` (s), the state being that in ``y``."""


def turned(model: Any, d: int, t: float, y: np.ndarray) -> float:
    """How far meeting ``d`` has turned at time ``t`` (s), in rollers that pass, from the angles in ``y``."""
    b, on = model.bearing, int(model.pits.head[d, ON])
    time = float(elapsed_times(model, np.array([t]))[0])
    slip = float(y[POSITION + PHI_C])
    if on >= 0:
        return (b.omega_b * time + slip - float(y[SPIN + on])) / (2.0 * np.pi)
    past = b.theta_0 + b.omega_c * time + slip - (b.omega_i * time if on == ON_INNER else 0.0)
    return past * b.Z / (2.0 * np.pi)


def missed(model: Any, t: float, before: list[float], y: np.ndarray) -> int:
    """Crossings that the angles have made since they were ``before`` (of each meeting), but the run has not seen.

    One at either end of the run is as may be.
    """
    unseen = 0
    for d in range(min(len(model.pits.head), ROW)):
        passed = abs(turned(model, d, t, y) - before[d])
        unseen += max(0, floor(passed) - 1 - int(y[CROSSINGS + d]))
    return unseen
