"""Functions of every model, dispatched on the type of its parameters."""

from typing import Any, NamedTuple

import numpy as np

from bearingsim.core.jit import generic


class ModelKind(NamedTuple):
    """Properties of a model's code; its other properties are in the catalogue.

    parameters: its ``NamedTuple``; per_crossing: steps per crossing of the narrowest defect if the step is
    automatic.
    """

    parameters: type
    per_crossing: int


@generic
def state_width(model: Any) -> int:
    """Return the number of cells, counted from the first of a block of the state, up to the last that the model
    uses."""


@generic(inline="late", otherwise=0)
def harmonics(model: Any) -> int:
    """Return the padded number of harmonics of the outer ring (``parts/bending.py``), cosine and sine counted as
    one."""


@generic
def accelerations(model: Any, t: float, y: np.ndarray) -> None:
    """Fill the acceleration and contact rows of ``y`` from its position and velocity rows at time ``t`` (s)."""


@generic
def begin(model: Any, t: float, y: np.ndarray) -> None:
    """Complete a buffer in which rollers and ring are in static equilibrium at ``t`` (s), before the first
    step."""


@generic
def update_extremes(model: Any, y: np.ndarray) -> None:
    """Update the running maxima with the state in ``y`` at the end of a step; count the loaded rollers."""


@generic(inline="late", otherwise=0.0)
def race_deflection_at(model: Any, y: np.ndarray, j: int) -> float:
    """Return the outward displacement (m) of a flexible outer race at roller ``j``."""


@generic(otherwise=None)
def read_sensor(model: Any, y: np.ndarray) -> None:
    """Fill the cells SENSOR, SENSOR_V and SENSOR_A, which are recorded but not part of the state."""


@generic(inline="late")
def stiffness_per_mass(model: Any, y: np.ndarray, j: int) -> float:
    """Return the stiffness over mass (1/s^2) of monitored body ``j`` in the present state."""


@generic(inline="late")
def damping_per_mass(model: Any, y: np.ndarray, j: int) -> float:
    """Return the damping over mass (1/s) of monitored body ``j`` in the present state."""


@generic
def monitored_bodies(model: Any) -> int:
    """Return the number of bodies whose step limit is monitored: the rollers, in their lanes, or the ring
    alone."""


@generic
def degrees_of_freedom(model: Any) -> tuple[int, int]:
    """Return the number of coordinates of a roller (0 to 6) and of shared coordinates (up to 17) of the model.

    Coordinate i of a roller is row i of a state; shared ones are numbered as in ``layout.shared_cell``.
    """


@generic
def linearise(model: Any, t: float, y: np.ndarray) -> None:
    """Fill the arrow matrices POSITION_JACOBIAN and VELOCITY_JACOBIAN, the derivatives of the accelerations at
    the state in ``y``.

    The coordinates are the model's, except that each roller's angle is absolute (EPS plus the cage's PHI_C), so
    that a roller depends only on its own and the shared coordinates. Requires the rows filled by ``accelerations``
    for this state.
    """


def register_solved_model(parameters: type) -> None:
    """Register a model that is solved, not integrated: ``begin`` does nothing, and no body limits the step."""
    begin.register(parameters)(lambda model, t, y: None)
    monitored_bodies.register(parameters)(lambda model: 0)
    stiffness_per_mass.register(parameters)(lambda model, y, j: 0.0)
    damping_per_mass.register(parameters)(lambda model, y, j: 0.0)
