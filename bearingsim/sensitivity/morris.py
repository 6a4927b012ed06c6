"""Elementary effects after Morris: screening of parameters with few jobs.

An elementary effect is what one step of one parameter does to a feature, over the length of the step. A step is
counted in the unit cube: an effect is in the feature's unit for the whole range of the parameter.

- mu, the mean of the effects of a parameter: which way it acts.
- mu*, the mean of their magnitudes: how much it matters, also where effects cancel.
- sigma, their standard deviation: how much that depends on where the others are, or on itself.

Morris, Technometrics 33 (1991) 161-174; mu*: Campolongo, Cariboni and Saltelli, Environmental Modelling & Software
22 (2007) 1509-1518. They rank; they are no shares of a variance.
"""

from typing import NamedTuple

import numpy as np

from bearingsim.sensitivity.intervals import Array, Estimate, estimate


class Effects(NamedTuple):
    """mu, mu* and sigma of d parameters, in the feature's unit over the whole range."""

    mean: Estimate
    magnitude: Estimate
    spread: Estimate


def elementary(points: Array, values: Array) -> Array:
    """Compute the elementary effects (n, d) of trajectories: points (n, d + 1, d) in the unit cube, values (n, d +
    1).

    Each step of a trajectory changes one parameter, and each parameter changes once.
    """
    steps, changes = np.diff(points, axis=1), np.diff(values, axis=1)
    moved = np.argmax(steps != 0.0, axis=1)  # (n, d): the step that moves each parameter
    lengths = np.take_along_axis(steps, moved[:, None, :], axis=1)[:, 0, :]
    return np.asarray(np.take_along_axis(changes, moved, axis=1) / lengths)


def of_trajectories(points: Array, values: Array) -> Effects:
    """Compute mu, mu* and sigma of trajectories as in ``elementary``, with intervals."""
    statistics = estimate(_statistics, elementary(points, values))
    return Effects(*(Estimate(*(ends[row] for ends in statistics)) for row in range(3)))


def _statistics(effects: Array) -> Array:
    return np.stack([effects.mean(axis=0), np.abs(effects).mean(axis=0), effects.std(axis=0, ddof=1)])
