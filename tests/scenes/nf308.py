"""Core parameters for the tests of the mechanics, built from a case with a few words."""

from typing import Any

import numpy as np

from bearingsim import assemble
from bearingsim.config import Case
from bearingsim.core.advance import RING, Watch, advance
from bearingsim.core.layout import Q_I, Q_O
from bearingsim.core.models.equilibrium import rest_from_scratch
from bearingsim.core.models.interface import begin
from bearingsim.core.outcomes import FINE

ON_INNER_RACE, ON_A_ROLLER = {"race": "inner"}, {"race": "roller"}  # of a defect: what carries it
PLACES = np.array([*RING, Q_O, Q_I])  # the ring's motion, and the first roller's forces
SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}


def case(**given: Any) -> Case:
    """The NF308 at 1800 rpm and 150 N in `rollers`, healthy unless a defect is given, its step taken unproven."""
    base = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "model": "rollers", "step_check": False}
    return Case.model_validate(base | given)


def light_rollers(factor: float) -> dict[str, Any]:
    """Fields of a case: the NF308 of a material so light that only the rollers tell (the ring's mass is given)."""
    usual = case()
    material = usual.bearing.material.model_copy(update={"density": factor * usual.bearing.material.density})
    bearing = usual.bearing.model_copy(update={"material": material})
    return {"bearing": bearing, "rig": {"ring_mass": f"{assemble.geometry.ring_mass(usual)} kg"}}


def at_rest(model: Any, t: float = 0.0) -> np.ndarray:
    """A buffer with the model at static equilibrium."""
    y = assemble.empty_buffer(model)
    assert rest_from_scratch(assemble.statics(model), t, y) <= 1e-8 * model.support.F
    begin(model, t, y)
    return y


def drive(model: Any, method: Any, steps: int, y: np.ndarray | None = None, patience: float = 1.0) -> np.ndarray:
    """Recording (len(PLACES), steps) from rest, or from ``y``."""
    y = at_rest(model) if y is None else y
    out = np.empty((len(PLACES), steps))
    taken, outcome, _ = advance(method, model, Watch(8, patience), 0, y, PLACES, out)
    assert (taken, outcome) == (steps, FINE)
    return out
