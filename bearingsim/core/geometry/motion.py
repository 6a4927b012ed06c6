"""Rotation of the inner ring at constant or linearly changing speed. All kinematic speeds are proportional to
it."""

from typing import Any, NamedTuple

import numpy as np

from bearingsim.core.jit import generic


class Steady(NamedTuple):
    """Constant speed ``Bearing.omega_i``."""


class Ramp(NamedTuple):
    """Linear change of speed from ``Bearing.omega_i`` to ``ratio`` times that at ``T`` (s), then constant
    speed."""

    ratio: float
    T: float


@generic
def kinematic_time(motion: Any, t: float) -> tuple[float, float, float]:
    """Return the equivalent time (s) at the initial speed, its first derivative (1) and its second (1/s).

    In the equivalent time the ring would rotate by the same angle at its initial speed. Angles are omega_i times
    this time, speeds omega_i times its first derivative; at constant speed the results are t, 1, 0.
    """


@kinematic_time.register(Steady)
def _kinematic_time_steady(motion, t):
    return t, 1.0, 0.0


@kinematic_time.register(Ramp)
def _kinematic_time_ramp(motion, t):
    ramp_rate = (motion.ratio - 1.0) / motion.T
    ramp_time = min(t, motion.T)
    time_after = t - ramp_time
    acceleration = ramp_rate if t < motion.T else 0.0
    return (
        ramp_time + 0.5 * ramp_rate * ramp_time * ramp_time + motion.ratio * time_after,
        1.0 + ramp_rate * ramp_time,
        acceleration,
    )


def model_motion(model: Any) -> Any:
    """Return the motion of a model, ``Steady`` if the model has no field for it."""
    return getattr(model, "motion", Steady())


def is_steady(model: Any) -> bool:
    """Check if the model's speed never changes."""
    return isinstance(model_motion(model), Steady)


def kinematic_times(model: Any, time: np.ndarray) -> np.ndarray:
    """Return the equivalent time of ``kinematic_time`` (n,), s, at each ``time`` (n,), s."""
    motion = model_motion(model)
    return time if isinstance(motion, Steady) else np.array([kinematic_time(motion, t)[0] for t in time.tolist()])


def speed_factor(model: Any, time: np.ndarray) -> Any:
    """Return the speed at each ``time`` (n,), s, over the speed at t = 0; the number 1.0 at a steady speed."""
    motion = model_motion(model)
    return 1.0 if isinstance(motion, Steady) else np.array([kinematic_time(motion, t)[1] for t in time.tolist()])
