"""Core parameters for the tests of the mechanics, built from a case with a few words."""

from typing import Any

import numpy as np

from bearingsim import assemble
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.advance import RING_MOTION, Monitor, NoSamples, advance_and_sample, start_at_rest
from bearingsim.core.models.equilibrium import solve_initial_equilibrium
from bearingsim.core.outcomes import SUCCESS

INNER_DEFECT, ROLLER_DEFECT = {"race": "inner"}, {"race": "roller"}  # of a defect: what carries it
ROWS = np.array([*RING_MOTION, lay.Q_O, lay.Q_I])  # the ring's motion, and the first roller's forces
SLOT = {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "0.05 mm"}


CHI = {"law": "hunt-crossley", "chi": "50 s/m"}
"""The damping under which the numbers of most tests were found; continuous at touch-down, unlike the default."""


def case(**fields: Any) -> Case:
    """The NF308 at 1800 rpm and 150 N in `rollers`, healthy unless a defect is given, its step taken unproven.

    Its contacts are damped by ``CHI`` unless `contact` says otherwise.
    """
    base = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "model": "rollers", "step_check": False}
    contact = fields.get("contact", {})
    damping = {"contact": {"damping": CHI} | contact} if isinstance(contact, dict) else {}
    return Case.model_validate(base | fields | damping)


NEGLIGIBLE = {"harmonics": [{"order": 2, "amplitude": "1e-6 nm"}]}


def on_all_elements(surfaces: dict[str, Any]) -> dict[str, Any]:
    """``surfaces`` with negligible waves on the other elements, so that all share one type, compiled once."""
    rollers = NEGLIGIBLE | surfaces.get("rollers", {})
    return {"outer": NEGLIGIBLE, "inner": NEGLIGIBLE} | surfaces | {"rollers": rollers}


def light_rollers(factor: float) -> dict[str, Any]:
    """Return fields of an NF308 whose inertia is that of a light material (the ring's mass is given)."""
    default = case()
    material = default.bearing.material.model_copy(update={"density": factor * default.bearing.material.density})
    bearing = default.bearing.model_copy(update={"material": material})
    return {"bearing": bearing, "rig": {"ring_mass": f"{assemble.geometry.ring_mass(default)} kg"}}


def weightless(model: Any) -> Any:
    """The model with rollers that nothing presses outwards, as in closed forms of the load's distribution."""
    return model._replace(bearing=model.bearing._replace(m_r=0.0))


def at_rest(model: Any, t: float = 0.0) -> np.ndarray:
    """A buffer with the model at static equilibrium."""
    y = assemble.empty_buffer(model)
    assert solve_initial_equilibrium(assemble.static_model(model), t, y) <= 1e-8 * model.support.F
    start_at_rest(model, t, y)
    return y


def advance_recorded(
    method: Any, model: Any, monitor: Monitor, start: int, y: np.ndarray, rows: np.ndarray, out: np.ndarray
) -> tuple[int, int, int]:
    """``advance`` by the code that simulates a case: compiled once for both, if ``out`` is laid out as there.

    That is as a part of a larger array, so that its rows do not follow each other.
    """
    columns = np.empty((out.shape[0], out.shape[1] + 1))[:, 1:]
    result = advance_and_sample(method, model, monitor, start, y, rows, columns, NoSamples())
    out[:] = columns
    return result


def drive(model: Any, method: Any, steps: int, y: np.ndarray | None = None, patience: float = 1.0) -> np.ndarray:
    """Recording (len(PLACES), steps) from rest, or from ``y``."""
    y = at_rest(model) if y is None else y
    out = np.empty((len(ROWS), steps))
    steps_taken, outcome, _ = advance_recorded(method, model, Monitor(8, patience), 0, y, ROWS, out)
    assert (steps_taken, outcome) == (steps, SUCCESS)
    return out
