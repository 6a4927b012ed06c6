"""Defect crossings, counted during a run and computed from the angles. A run that counted fewer than computed has
stepped over a defect.
"""

from math import floor
from typing import Any

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.defects.on_roller import roller_at_defect
from bearingsim.core.defects.pairs import CARRIER, HALF_WIDTH, ON_INNER
from bearingsim.core.geometry.motion import kinematic_times
from bearingsim.core.jit import generic


def count_defect_crossings(model, t, y):
    """Implement ``count_crossings`` for models with defects; pairs beyond the length of a row are not counted."""
    for d in range(min(len(model.defects.head), lay.ROW)):
        j, s = roller_at_defect(model, d, t, y)
        roller = j + 1.0 if abs(s) < model.defects.head[d, HALF_WIDTH] else 0.0
        if roller != y[lay.ROLLER_IN_DEFECT + d]:
            y[lay.PAIR_CROSSINGS + d] += 1.0 if roller > 0.0 else 0.0
            y[lay.DEFECT_CROSSINGS] += 1.0 if roller > 0.0 else 0.0
            y[lay.ROLLER_IN_DEFECT + d] = roller


@generic(otherwise=count_defect_crossings)
def count_crossings(model: Any, t: float, y: np.ndarray) -> None:
    """Count the rollers that have entered a defect since the last call, in the state ``y`` at time ``t`` (s)."""


def passages(model: Any, d: int, t: float, y: np.ndarray) -> float:
    """Return the rotation of roller-defect pair ``d`` at time ``t`` (s), in roller passages, from the angles in
    ``y``."""
    b, carrier = model.bearing, int(model.defects.head[d, CARRIER])
    time = float(kinematic_times(model, np.array([t]))[0])
    slip = float(y[lay.POSITION + lay.PHI_C])
    if carrier >= 0:
        return (b.omega_b * time + slip - float(y[lay.SPIN + carrier])) / (2.0 * np.pi)
    angle = b.theta_0 + b.omega_c * time + slip - (b.omega_i * time if carrier == ON_INNER else 0.0)
    return angle * b.Z / (2.0 * np.pi)


def missed_crossings(model: Any, t: float, initial_passages: list[float], y: np.ndarray) -> int:
    """Return the number of crossings that a run did not count since ``initial_passages`` (``passages`` of pairs).

    One crossing per pair may be missing, because the ends of the run may cut a crossing.
    """
    missed = 0
    for d in range(min(len(model.defects.head), lay.ROW)):
        count = abs(passages(model, d, t, y) - initial_passages[d])
        missed += max(0, floor(count) - 1 - int(y[lay.PAIR_CROSSINGS + d]))
    return missed
