"""Models roller by roller: each says what acts on one roller and what all rollers share, and is evaluated here.

What a model gives, in the order in which it is called:

    shared              what all rollers share, from the state at the time
    load_roller         the forces on one roller, and what it does to rings and cage
    accelerate_shared   the sum of that over the rollers, and what it makes of rings and cage
    accelerate_roller   one roller's acceleration, by its own forces and what rings and cage do

The first of the two loops over rollers also moves them, before their forces, and the second after: how, a method
says by its type (``drift``, ``kick``). So a step is one passage, whatever the model.
"""

from typing import Any, NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.jit import absent, generic, inlined
from bearingsim.core.models.interface import accelerations, degrees_of_freedom, harmonics, state_width
from bearingsim.core.parameters import lanes


@generic(inline="late")
def shared(model: Any, t: float, y: np.ndarray) -> Any:
    """Return the numbers that all rollers share at time ``t`` (s): positions of rings and cage, and what turns
    with time."""


@generic(inline="late")
def load_roller(model: Any, common: Any, y: np.ndarray, j: int) -> None:
    """Fill the contact rows of roller ``j``, and of its ``layout.roller_load`` those that the model sums.

    common: from ``shared``. The rollers are lanes of one loop: no branches, nothing of another roller.
    """


@generic(inline="late")
def accelerate_shared(model: Any, common: Any, t: float, y: np.ndarray) -> Any:
    """Correct the rollers that stand over a defect, sum up, and accelerate rings and cage.

    Returns what the rollers' own acceleration needs of it, as numbers.
    """


@generic(inline="late")
def accelerate_roller(model: Any, common: Any, felt: Any, y: np.ndarray, j: int) -> None:
    """Write the acceleration of roller ``j``; felt: from ``accelerate_shared``. A lane, as in ``load_roller``."""


@absent
class Still(NamedTuple):
    """The state stays as it is, and is evaluated there."""


@generic(inline="late", absent=None)
def drift(motion: Any, y: np.ndarray, i: int) -> None:
    """Take coordinate ``i`` of the state to where it is evaluated."""


@generic(inline="late", absent=None)
def kick(motion: Any, y: np.ndarray, i: int) -> None:
    """Take the velocity of coordinate ``i`` on, by its acceleration there."""


def as_a_whole(model, motion, t, y):
    """Implement ``evaluate`` for a model that computes its ``accelerations`` only as a whole."""
    n = state_width(model)
    for i in range(n):
        drift(motion, y, i)
    accelerations(model, t, y)
    for i in range(n):
        kick(motion, y, i)


@generic(inline="late", otherwise=as_a_whole)
def evaluate(model: Any, motion: Any, t: float, y: np.ndarray) -> None:
    """Drift, fill the rows that ``accelerations`` fills at time ``t`` (s), and kick."""


ROWS = tuple(i * lay.ROW + lay.FIRST_LANE for i in range(6))
"""First lanes of a roller's coordinates in a block of the state."""


@inlined
def drift_roller(motion, own, y, j):
    """Apply ``drift`` to the ``own`` coordinates of roller ``j``, one by one, because a loop over rows costs
    vector lanes."""
    if own > 0:
        drift(motion, y, ROWS[0] + j)
    if own > 1:
        drift(motion, y, ROWS[1] + j)
        drift(motion, y, ROWS[2] + j)
    if own > 3:
        drift(motion, y, ROWS[3] + j)
        drift(motion, y, ROWS[4] + j)
        drift(motion, y, ROWS[5] + j)


@inlined
def kick_roller(motion, own, y, j):
    """Apply ``kick`` to the ``own`` coordinates of roller ``j``."""
    if own > 0:
        kick(motion, y, ROWS[0] + j)
    if own > 1:
        kick(motion, y, ROWS[1] + j)
        kick(motion, y, ROWS[2] + j)
    if own > 3:
        kick(motion, y, ROWS[3] + j)
        kick(motion, y, ROWS[4] + j)
        kick(motion, y, ROWS[5] + j)


@inlined
def drift_harmonics(model, motion, y):
    """Apply ``drift`` to the amplitudes of a bent outer ring."""
    for i in range(harmonics(model)):
        drift(motion, y, lay.MODES_C + i)
    for i in range(harmonics(model)):
        drift(motion, y, lay.MODES_S + i)


@inlined
def kick_harmonics(model, motion, y):
    """Apply ``kick`` to the amplitudes of a bent outer ring."""
    for i in range(harmonics(model)):
        kick(motion, y, lay.MODES_C + i)
    for i in range(harmonics(model)):
        kick(motion, y, lay.MODES_S + i)


@inlined
def load_rollers(model, motion, common, y, n):
    """Run the first loop over rollers."""
    own, _ = degrees_of_freedom(model)
    for j in range(n):
        drift_roller(motion, own, y, j)
        load_roller(model, common, y, j)


@inlined
def accelerate_rollers(model, motion, common, felt, y, n):
    """Run the second loop over rollers."""
    own, _ = degrees_of_freedom(model)
    for j in range(n):
        accelerate_roller(model, common, felt, y, j)
        kick_roller(motion, own, y, j)


def roller_by_roller(model, motion, t, y):
    """Implement ``evaluate`` for a model whose functions are those above."""
    n, (_, coordinates) = lanes(model.bearing), degrees_of_freedom(model)
    for k in range(coordinates):
        drift(motion, y, lay.shared_cell(k))
    drift_harmonics(model, motion, y)
    common = shared(model, t, y)
    load_rollers(model, motion, common, y, n)
    felt = accelerate_shared(model, common, t, y)
    for k in range(coordinates):
        kick(motion, y, lay.shared_cell(k))
    kick_harmonics(model, motion, y)
    accelerate_rollers(model, motion, common, felt, y, n)


def accelerations_by_roller(model, t, y):
    """Implement ``accelerations`` for such a model."""
    evaluate(model, Still(), t, y)


def register_roller_model(parameters: type) -> None:
    """Register a model that gives ``shared``, ``load_roller``, ``accelerate_shared`` and ``accelerate_roller``."""
    evaluate.register(parameters)(roller_by_roller)
    accelerations.register(parameters)(accelerations_by_roller)
