"""From a case to the core's parameters: the one place where configuration meets physics.

Imports numba (through the core), so import it only where something is computed.
"""

from functools import lru_cache
from math import ceil, log2, pi
from typing import Any

import numpy as np

from bearingsim.assemble import bending, contacts, free, geometry, pits, scales, space
from bearingsim.assemble.rest import bracket_anchor, static_model
from bearingsim.catalogue import EXPLICIT, METHODS, MODELS, call, code
from bearingsim.config import Case
from bearingsim.config.sections.contact import Undamped as NoDamping
from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from bearingsim.core.geometry.motion import steady
from bearingsim.core.geometry.slices import ZETA
from bearingsim.core.laws.damping.undamped import Undamped
from bearingsim.core.methods.interface import MethodKind
from bearingsim.core.models import spatial
from bearingsim.core.models.equilibrium import find_in_time, find_rest, rest_from_scratch
from bearingsim.core.models.interface import ModelKind
from bearingsim.core.models.rest_in_space import mean_rest_in_space, rest_in_space
from bearingsim.core.models.static import Static
from bearingsim.core.parameters import Support
from bearingsim.core.parts.bending import Stiff
from bearingsim.core.pits.pairs import ANGLE, CARRIER, CUSP, ON_OUTER, RADIUS, Pits
from bearingsim.errors import UserError

__all__ = [
    "adaptive",
    "aligned_with_cusp",
    "empty_buffer",
    "find_equilibrium",
    "healthy",
    "kind",
    "kind_of_method",
    "kind_of_model",
    "method",
    "method_kind",
    "model",
    "outer_forces",
    "start",
    "static_model",
    "with_friction_lag",
]

PARAMETER_BUILDERS: dict[str, Any] = {
    "bearing": geometry.bearing,
    "support": lambda case: support(case),
    "outer": contacts.outer,
    "inner": contacts.inner,
    "pits": lambda case: pits_of_case(case),
    "bending": lambda case: bending_of_case(case),
    "motion": free.motion,
    "friction": free.friction,
    "cage": free.cage,
    "drag": free.drag,
    "shaft": free.shaft,
    "bracket": free.bracket,
    "gravity": free.gravity,
    "slices": space.slices,
    "L_w": space.roller_length,
    "I_t": space.roller_inertia_across,
    "mount_o": space.outer_mount,
    "mount_i": space.inner_mount,
    "flanges": space.flanges,
    "cage_z": space.cage_in_space,
}
"""How each field of a model's parameters is made."""


def kind(case: Case) -> ModelKind:
    """What belongs to the code of the case's model."""
    return kind_of_model(case.model)


def kind_of_model(name: str) -> ModelKind:
    """What belongs to the code of a model."""
    found: ModelKind = code(f"{MODELS[name].module}:KIND", ModelKind)
    return found


def kind_of_method(name: str) -> MethodKind:
    """What belongs to the code of a method that a case can name."""
    found: MethodKind = code(f"{METHODS[name].module}:KIND", MethodKind)
    return found


def method_kind(case: Case) -> MethodKind:
    """What belongs to the code of the case's method, which must be named, or of its model's own."""
    if case.method is not None:
        return kind_of_method(case.method)
    found: MethodKind = code(f"{MODELS[case.model].own_method}:KIND", MethodKind)
    return found


def adaptive(case: Case) -> bool:
    """Whether the case's method, which must be named, chooses its own steps."""
    return case.method is not None and METHODS[case.method].adaptive


def model(case: Case) -> Any:
    """The core's model of the case, its bracket anchored where the healthy bearing rests on average.

    So the load is what the bearing carries: a bracket anchored anywhere else would take a share of it.
    Raises ``NoEquilibrium`` if the healthy bearing finds no equilibrium.
    """
    known = MODELS[case.model]
    if known.build:
        return call(known.build, case, support(case))
    return _made_by_field(bearing_of(case))


OF_A_RUN = {"method": EXPLICIT, "step": "auto", "tolerance": "auto", "step_check": True, "periodic": True}
OF_A_RUN |= {"duration": 1.0, "settle": 0.0}
"""Fields that say how, and how long, a bearing is computed, each with some value."""


def bearing_of(case: Case) -> Case:
    """The case without what does not touch its bearing, so that all ways to compute it share its parameters."""
    return case.model_copy(update=OF_A_RUN)


@lru_cache(maxsize=64)
def _made_by_field(case: Case) -> Any:
    """The core's model, made once for all that ask for it: nobody writes into its arrays."""
    parameters = kind(case).parameters
    found = parameters(**{name: PARAMETER_BUILDERS[name](case) for name in _made(parameters)})
    return static_model(found) if isinstance(found, Static) else found


def _made(parameters: Any) -> list[str]:
    """The fields of a model's parameters that are made from a case."""
    made = [name for name in parameters._fields if name not in parameters._field_defaults]
    unknown = [name for name in made if name not in PARAMETER_BUILDERS]
    if unknown:
        raise UserError(
            f"{parameters.__name__} asks for `{unknown[0]}`, which nobody makes: {', '.join(PARAMETER_BUILDERS)}"
        )
    return made


def pits_of_case(case: Case) -> Pits:
    """The case's pits, cut along the roller as its model cuts rollers."""
    return pits.packed_pits(case, space.slices(case).table[:, ZETA] if MODELS[case.model].sliced else None)


def bending_of_case(case: Case) -> Any:
    """The bending of the case's outer ring; its carrier, if there is one, is held by the bracket."""
    if case.rig.ring is None:
        return Stiff()
    found = bending.of_ring(case)
    if bending.has_carrier(case.rig):
        bracket = case.rig.bracket_stiffness, case.rig.bracket_damping, *bracket_anchor(case)
        found = found._replace(bracket=bracket)
    return bending.made(found)


def support(case: Case) -> Support:
    """Load and bracket of the case's ring: none where they act on a carrier."""
    if bending.has_carrier(case.rig):
        return Support(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    x_0, y_0 = anchor_in_space(_at_rest(case)) if space.unevenly_loaded(case) else bracket_anchor(case)
    return Support(case.load, case.load_across, case.rig.bracket_stiffness, case.rig.bracket_damping, x_0, y_0)


def healthy(case: Case) -> Case:
    """The case without what does not touch its load at rest, so that many cases share one."""
    same = {"defects": (), "record": (), "sampling": 1e4, "excitation": "envelope", "seed": 0}
    return case.model_copy(update=OF_A_RUN | same)


def _at_rest(case: Case) -> Case:
    """The healthy case without what only motion and its bracket know; what chooses compiled code is kept."""
    still = {
        "start_angle": 0.0,
        "antialias": True,
        "rig": case.rig.model_copy(update=OF_A_BRACKET),
        "contact": case.contact.model_copy(update={"damping": NoDamping()}),
    }
    return healthy(case).model_copy(update=still)


OF_A_BRACKET = {"bracket_stiffness": 0.0, "bracket_damping": 0.0, "sensor_angle": 0.0}
"""Fields of a rig that do not touch where a ring rests that is held by its load alone."""


@lru_cache(maxsize=256)
def anchor_in_space(case: Case) -> tuple[float, float]:
    """Mean place (m, m) over a ball pass of a ring whose rollers are loaded unevenly along their length."""
    free_ring = Support(case.load, case.load_across, 0.0, 0.0, 0.0, 0.0)
    parts = {name: PARAMETER_BUILDERS[name](case) for name in _made(spatial.Spatial) if name != "support"}
    bearing = undamped(spatial.Spatial(support=free_ring, **parts))
    y = empty_buffer(bearing)
    find_in_time(rest_from_scratch, static_model(bearing), 0.0, y)
    rest = mean_rest_in_space(bearing, y)
    return rest.x, rest.y


def aligned_with_cusp(model: Any, steps_per_pass: int, cusp: float) -> Any:
    """The model with the cusp of its first pit ``cusp`` of a step after a step's start.

    At the cusp the damping force jumps; where in a step it does so decides whether the error is of first or of
    second order (docs/steps.md). The rollers start less than a step further on. Of several pits only the first
    is in step, and only on the outer race at a steady speed: elsewhere cusps fall anywhere in a step, and the
    error averages out.
    """
    if "pits" not in model._fields or not steady(model):
        return model
    found = model.pits
    if len(found.head) == 0 or found.head[0, CARRIER] != ON_OUTER:
        return model
    b, pass_angle = model.bearing, 2.0 * pi / model.bearing.Z
    place = found.head[0, ANGLE] + found.head[0, CUSP] / found.head[0, RADIUS]
    steps = (b.theta_0 - place) / pass_angle * steps_per_pass  # whole when the cusp is met
    ahead = ceil(steps + cusp) - cusp - steps
    return model._replace(bearing=b._replace(theta_0=float(b.theta_0 + ahead * pass_angle / steps_per_pass)))


def with_friction_lag(model: Any, lag: float) -> Any:
    """The model with friction that acts no faster than within ``lag`` (s), so that it limits no step of it."""
    return model._replace(lag=lag) if "lag" in model._fields else model


def start(case: Case, model: Any) -> tuple[np.ndarray, float]:
    """A buffer at t = 0 at static equilibrium, accelerations filled in; and the force left over (N).

    With a free cage and a seed, the rollers begin anywhere in their pockets.
    """
    y, residual = empty_buffer(model), 0.0
    if MODELS[case.model].loaded:
        residual = find_equilibrium(model, 0.0, y, from_scratch=True)
        y[lay.EPS : lay.EPS + model.bearing.Z] = (
            free.initial_pocket_angles(case) if MODELS[case.model].slips else 0.0
        )
        start_at_rest(model, 0.0, y)
    return y, residual


def find_equilibrium(model: Any, t: float, y: np.ndarray, from_scratch: bool = False) -> float:
    """Put rings and rollers at rest at time ``t`` (s), near a rest or from scratch; the force left over (N)."""
    left = find_in_time(rest_from_scratch if from_scratch else find_rest, static_model(model), t, y)
    return rest_in_space(undamped(model), t, y) if isinstance(model, spatial.Spatial) else float(left)


def undamped(model: Any) -> Any:
    """The model with contacts that only spring: at rest they are the same, and compiled once for all damping."""
    return model._replace(outer=Undamped(model.outer.stiffness), inner=Undamped(model.inner.stiffness))


def empty_buffer(model: Any) -> np.ndarray:
    """A zeroed state buffer for the model."""
    return lay.buffer(model.bearing.Z, model.bearing.m_r, slices_of(model))


def slices_of(model: Any) -> int:
    """How many slices a roller of the model is cut into; 0 of a model that cuts none."""
    return len(model.slices.table) if "slices" in model._fields else 0


def outer_forces(model: Any, y: np.ndarray) -> np.ndarray:
    """Outer contact force (N) of each roller, (Z,), as the buffer has it."""
    return y[lay.Q_O : lay.Q_O + model.bearing.Z]


def method(case: Case, h: float, part: float = 1.0) -> Any:
    """The core's method of the case with step ``h`` (s), which is ``part`` of what it would be.

    With half of it an adaptive method takes a tenth of its own tolerance; one that the case gives stays.
    """
    parameters: Any = method_kind(case).parameters
    usual = METHODS[case.method].tolerance if case.method is not None else None
    if usual is None:
        return parameters(h)
    own = part ** log2(10.0) * usual
    tolerance = own if case.tolerance == "auto" else case.tolerance
    first = model(case)
    fastest = first if case.ramp is None else model(scales.at_full_speed(case))
    return parameters(*scales.tolerances(case, first, fastest, h, tolerance))
