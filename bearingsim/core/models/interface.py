"""The functions every model has, chosen by the type of its parameters."""

from typing import Any, NamedTuple

import numpy as np

from bearingsim.core.jit import generic


class ModelKind(NamedTuple):
    """Properties of a model's code; its other properties stand in the catalogue.

    parameters: its ``NamedTuple``; per_crossing: steps of an automatic run over the narrowest defect.
    """

    parameters: type
    per_crossing: int


@generic
def state_width(model: Any) -> int:
    """Return the entries of a row that the model's state takes (the ring's, then the lanes in use)."""


@generic(inline="late", otherwise=0)
def harmonics(model: Any) -> int:
    """Return the number of harmonics of the outer ring in a model (``parts/bending.py``), sine and cosine
    counted as one."""


@generic
def accelerations(model: Any, t: float, y: np.ndarray) -> None:
    """Fill the acceleration and contact rows of ``y`` from its position and velocity rows at time ``t`` (s)."""


@generic
def begin(model: Any, t: float, y: np.ndarray) -> None:
    """Complete a buffer whose rollers and ring are at rest at time ``t`` (s): what a first step builds on."""


@generic
def update_extremes(model: Any, y: np.ndarray) -> None:
    """Take the state of ``y``, at which a step has ended, into the running maxima; count who carries load."""


@generic(inline="late", otherwise=0.0)
def bend_at(model: Any, y: np.ndarray, j: int) -> float:
    """Return the outward displacement of the bent outer race at roller ``j``, m."""


@generic(otherwise=None)
def read_sensor(model: Any, y: np.ndarray) -> None:
    """Fill the cells that are recorded of a state and are no part of it."""


@generic(inline="late")
def stiffness_per_mass(model: Any, y: np.ndarray, j: int) -> float:
    """Return the stiffness over mass (1/s^2) of monitored body ``j`` in the present state."""


@generic(inline="late")
def damping_per_mass(model: Any, y: np.ndarray, j: int) -> float:
    """Return the damping over mass (1/s) of monitored body ``j`` as it stands now."""


@generic
def monitored(model: Any) -> int:
    """Return the number of bodies with a monitored step limit: the rollers (by lane), or the ring alone."""


@generic
def degrees_of_freedom(model: Any) -> tuple[int, int]:
    """Return the number of coordinates of a roller (0 to 6), and of shared ones (to 17), in the model's equations.

    Coordinate i of a roller is row i of a state; shared ones are counted as in ``layout.shared_cell``.
    """


@generic
def linearise(model: Any, t: float, y: np.ndarray) -> None:
    """Fill the arrows POSITION_JACOBIAN and VELOCITY_JACOBIAN: derivatives of the accelerations of the state in
    ``y``.

    The model's coordinates, but for each roller's angle, which counts absolutely (EPS plus the cage's PHI_C): so a
    roller depends on its own and the shared coordinates only. The rows that ``accelerations`` fills are those of
    this state.
    """


def solved(parameters: type) -> None:
    """Register a model that is solved, not integrated: it needs no beginning, and no body limits its step."""
    begin.register(parameters)(lambda model, t, y: None)
    monitored.register(parameters)(lambda model: 0)
    stiffness_per_mass.register(parameters)(lambda model, y, j: 0.0)
    damping_per_mass.register(parameters)(lambda model, y, j: 0.0)
