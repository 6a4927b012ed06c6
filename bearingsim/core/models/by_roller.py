"""Evaluation of models that are defined by functions of one roller and of quantities common to all rollers.

A model provides, in the order of the calls:

    shared_quantities   quantities common to all rollers, from time and state
    load_roller         forces on one roller, and its loads on rings and cage
    accelerate_shared   sums of these loads, and accelerations of rings and cage
    accelerate_roller   acceleration of one roller

The first of the two loops over rollers also updates positions (``drift``), before the forces; the second also
updates velocities (``kick``), after the accelerations. The type of the argument ``method`` selects both updates,
so they need no loops of their own; ``NoUpdate`` omits them.
"""

from typing import Any, NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.jit import absent, generic, inlined
from bearingsim.core.models.interface import accelerations, degrees_of_freedom, harmonics, state_width
from bearingsim.core.parameters import lanes


@generic(inline="late")
def shared_quantities(model: Any, t: float, y: np.ndarray) -> Any:
    """Return the quantities common to all rollers at time ``t`` (s): positions of rings and cage, speeds and
    angles."""


@generic(inline="late")
def load_roller(model: Any, common: Any, y: np.ndarray, j: int) -> None:
    """Fill the contact rows of roller ``j``, and its lane of the rows ``layout.roller_load`` that the model sums.

    common: result of ``shared_quantities``. The loop over rollers is vectorised, so an implementation must have no
    branches and must not use data of other rollers.
    """


@generic(inline="late")
def accelerate_shared(model: Any, common: Any, t: float, y: np.ndarray) -> Any:
    """Correct the contact forces over defects, sum the loads, and write the accelerations of rings and cage.

    Returns the accelerations that ``accelerate_roller`` needs.
    """


@generic(inline="late")
def accelerate_roller(model: Any, common: Any, body_acceleration: Any, y: np.ndarray, j: int) -> None:
    """Write the acceleration of roller ``j``, in a vectorised loop like ``load_roller``.

    body_acceleration: result of ``accelerate_shared``.
    """


@absent
class NoUpdate(NamedTuple):
    """Placeholder for a method: evaluate the given state without drift and kick."""


@generic(inline="late", absent=None)
def drift(method: Any, y: np.ndarray, i: int) -> None:
    """Advance position and velocity of cell ``i`` of the state to the point of evaluation."""


@generic(inline="late", absent=None)
def kick(method: Any, y: np.ndarray, i: int) -> None:
    """Update the velocity of cell ``i`` with its acceleration."""


def evaluate_at_once(model, method, t, y):
    """Implement ``evaluate`` for a model that computes all its ``accelerations`` in one call."""
    n = state_width(model)
    for i in range(n):
        drift(method, y, i)
    accelerations(model, t, y)
    for i in range(n):
        kick(method, y, i)


@generic(inline="late", otherwise=evaluate_at_once)
def evaluate(model: Any, method: Any, t: float, y: np.ndarray) -> None:
    """Apply ``drift``, fill the rows that ``accelerations`` fills at time ``t`` (s), and apply ``kick``."""


COORDINATE_ROWS = tuple(i * lay.ROW + lay.FIRST_LANE for i in range(6))
"""First lanes of a roller's coordinates in a block of the state."""


@inlined
def drift_roller(method, roller_dof, y, j):
    """Apply ``drift`` to the ``roller_dof`` (0, 1, 3 or 6) coordinates of roller ``j``, unrolled because a loop
    over rows prevents vectorisation."""
    if roller_dof > 0:
        drift(method, y, COORDINATE_ROWS[0] + j)
    if roller_dof > 1:
        drift(method, y, COORDINATE_ROWS[1] + j)
        drift(method, y, COORDINATE_ROWS[2] + j)
    if roller_dof > 3:
        drift(method, y, COORDINATE_ROWS[3] + j)
        drift(method, y, COORDINATE_ROWS[4] + j)
        drift(method, y, COORDINATE_ROWS[5] + j)


@inlined
def kick_roller(method, roller_dof, y, j):
    """Apply ``kick`` to the ``roller_dof`` (0, 1, 3 or 6) coordinates of roller ``j``."""
    if roller_dof > 0:
        kick(method, y, COORDINATE_ROWS[0] + j)
    if roller_dof > 1:
        kick(method, y, COORDINATE_ROWS[1] + j)
        kick(method, y, COORDINATE_ROWS[2] + j)
    if roller_dof > 3:
        kick(method, y, COORDINATE_ROWS[3] + j)
        kick(method, y, COORDINATE_ROWS[4] + j)
        kick(method, y, COORDINATE_ROWS[5] + j)


@inlined
def drift_harmonics(model, method, y):
    """Apply ``drift`` to the amplitudes of a flexible outer ring."""
    for i in range(harmonics(model)):
        drift(method, y, lay.MODES_C + i)
    for i in range(harmonics(model)):
        drift(method, y, lay.MODES_S + i)


@inlined
def kick_harmonics(model, method, y):
    """Apply ``kick`` to the amplitudes of a flexible outer ring."""
    for i in range(harmonics(model)):
        kick(method, y, lay.MODES_C + i)
    for i in range(harmonics(model)):
        kick(method, y, lay.MODES_S + i)


@inlined
def load_rollers(model, method, common, y, n):
    """Run the first loop over rollers: drift and loads."""
    roller_dof, _ = degrees_of_freedom(model)
    for j in range(n):
        drift_roller(method, roller_dof, y, j)
        load_roller(model, common, y, j)


@inlined
def accelerate_rollers(model, method, common, body_acceleration, y, n):
    """Run the second loop over rollers: accelerations and kick."""
    roller_dof, _ = degrees_of_freedom(model)
    for j in range(n):
        accelerate_roller(model, common, body_acceleration, y, j)
        kick_roller(method, roller_dof, y, j)


def evaluate_by_roller(model, method, t, y):
    """Implement ``evaluate`` for a model that has the four functions of the module's docstring."""
    n, (_, shared_dof) = lanes(model.bearing), degrees_of_freedom(model)
    for k in range(shared_dof):
        drift(method, y, lay.shared_cell(k))
    drift_harmonics(model, method, y)
    common = shared_quantities(model, t, y)
    load_rollers(model, method, common, y, n)
    body_acceleration = accelerate_shared(model, common, t, y)
    for k in range(shared_dof):
        kick(method, y, lay.shared_cell(k))
    kick_harmonics(model, method, y)
    accelerate_rollers(model, method, common, body_acceleration, y, n)


def accelerations_by_roller(model, t, y):
    """Implement ``accelerations`` for a model that has the four functions of the module's docstring."""
    evaluate(model, NoUpdate(), t, y)


def register_roller_model(parameters: type) -> None:
    """Register a model with ``shared_quantities``, ``load_roller``, ``accelerate_shared`` and
    ``accelerate_roller``."""
    evaluate.register(parameters)(evaluate_by_roller)
    accelerations.register(parameters)(accelerations_by_roller)
