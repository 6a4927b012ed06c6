"""Defect crossings, counted during a run and computed from the angles.

A run in which fewer crossings were counted than computed has stepped over a defect.
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
    """Implement ``count_crossings`` for models with defects; pairs beyond the ``lay.ROW`` first are not
    counted."""
    for d in range(min(len(model.defects.head), lay.ROW)):
        j, s = roller_at_defect(model, d, t, y)
        roller_number = j + 1.0 if abs(s) < model.defects.head[d, HALF_WIDTH] else 0.0  # 0: no roller
        if roller_number != y[lay.ROLLER_IN_DEFECT + d]:
            y[lay.PAIR_CROSSINGS + d] += 1.0 if roller_number > 0.0 else 0.0
            y[lay.DEFECT_CROSSINGS] += 1.0 if roller_number > 0.0 else 0.0
            y[lay.ROLLER_IN_DEFECT + d] = roller_number


@generic(otherwise=count_defect_crossings)
def count_crossings(model: Any, t: float, y: np.ndarray) -> None:
    """Count the rollers that have entered a defect since the last call, in the state ``y`` at time ``t`` (s)."""


def relative_passages(model: Any, d: int, t: float, y: np.ndarray) -> float:
    """Return the relative rotation of rollers and defect of pair ``d`` at time ``t`` (s), in roller passages (1).

    It is computed from the angles in ``y``.
    """
    b, carrier = model.bearing, int(model.defects.head[d, CARRIER])
    equivalent_time = float(kinematic_times(model, np.array([t]))[0])
    slip = float(y[lay.POSITION + lay.PHI_C])
    if carrier >= 0:
        return (b.omega_b * equivalent_time + slip - float(y[lay.SPIN + carrier])) / (2.0 * np.pi)
    angle = (
        b.theta_0
        + b.omega_c * equivalent_time
        + slip
        - (b.omega_i * equivalent_time if carrier == ON_INNER else 0.0)
    )
    return angle * b.Z / (2.0 * np.pi)


def count_missed_crossings(model: Any, t: float, initial_passages: list[float], y: np.ndarray) -> int:
    """Return the number of crossings that a run did not count.

    initial_passages: ``relative_passages`` of every pair at the start of the run. One crossing per pair may be
    missing, because the ends of the run may cut a crossing.
    """
    missed = 0
    for d in range(min(len(model.defects.head), lay.ROW)):
        passages = abs(relative_passages(model, d, t, y) - initial_passages[d])
        missed += max(0, floor(passages) - 1 - int(y[lay.PAIR_CROSSINGS + d]))
    return missed
