"""Assembly of the core's parameters from a case: the only link between configuration and physics.

It imports numba (through the core), so import it only for computations.
"""

from functools import lru_cache
from math import ceil, log2, pi
from typing import Any

import numpy as np

from bearingsim.assemble import bending, contacts, defects, form, free, geometry, scales, space
from bearingsim.assemble.anchor import bracket_anchor
from bearingsim.assemble.reduced import bearing_of, healthy_case, static_case
from bearingsim.assemble.rest import static_model
from bearingsim.assemble.rest_in_space import equilibrium_in_space
from bearingsim.catalogue import METHODS, MODELS, call, code
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from bearingsim.core.defects.pairs import ANGLE, CARRIER, CUSP, ON_OUTER, RADIUS, Defects
from bearingsim.core.geometry.motion import is_steady
from bearingsim.core.geometry.slices import ZETA
from bearingsim.core.laws.damping.undamped import Undamped
from bearingsim.core.laws.friction.curves import Frictionless
from bearingsim.core.methods.interface import MethodKind
from bearingsim.core.models.equilibrium import solve_equilibrium, solve_in_cpu_time, solve_initial_equilibrium
from bearingsim.core.models.interface import ModelKind
from bearingsim.core.models.spatial import Spatial
from bearingsim.core.models.spatial_equilibrium import solve_spatial_equilibrium
from bearingsim.core.models.static import Static
from bearingsim.core.parameters import Support
from bearingsim.core.parts.bending import RigidRing
from bearingsim.errors import UserError

__all__ = [
    "align_with_cusp",
    "bearing_of",
    "empty_buffer",
    "find_equilibrium",
    "healthy_case",
    "is_adaptive",
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
    "without_friction",
]

PARAMETER_BUILDERS: dict[str, Any] = {
    "bearing": geometry.bearing,
    "support": lambda case: support(case),
    "outer": contacts.outer,
    "inner": contacts.inner,
    "rate_division": contacts.rate_division,
    "defects": lambda case: defects_of_case(case),
    "bending": lambda case: bending_of_case(case),
    "form": form.form,
    "motion": free.motion,
    "friction": free.friction,
    "cage": free.cage,
    "drag": free.drag,
    "shaft": free.shaft,
    "bracket": free.bracket,
    "gravity": free.gravity,
    "slices": space.slices,
    "L_w": contacts.roller_length,
    "I_t": space.roller_inertia_across,
    "mount_o": space.outer_mount,
    "mount_i": space.inner_mount,
    "flanges": space.flanges,
    "cage_z": space.cage_in_space,
}
"""Builder of each field of a model's parameters, a function of the case."""


def kind(case: Case) -> ModelKind:
    """Return the classes and functions of the case's model."""
    return kind_of_model(case.model)


def kind_of_model(name: str) -> ModelKind:
    """Return the classes and functions of a model."""
    loaded: ModelKind = code(f"{MODELS[name].module}:KIND", ModelKind)
    return loaded


def kind_of_method(name: str) -> MethodKind:
    """Return the classes and functions of an integration method by its name."""
    loaded: MethodKind = code(f"{METHODS[name].module}:KIND", MethodKind)
    return loaded


def method_kind(case: Case) -> MethodKind:
    """Return the classes and functions of the case's method (not `auto`), or of its model's own method."""
    if case.method is not None:
        return kind_of_method(case.method)
    loaded: MethodKind = code(f"{MODELS[case.model].own_method}:KIND", MethodKind)
    return loaded


def is_adaptive(case: Case) -> bool:
    """Check if the case's method (not `auto`) controls its own step."""
    return case.method is not None and METHODS[case.method].adaptive


def model(case: Case) -> Any:
    """Assemble the core's model of the case.

    The bracket is anchored at the mean equilibrium of the healthy bearing; anchored elsewhere it would carry a
    part of the load. Raises ``NoEquilibrium`` if the healthy bearing has no equilibrium.
    """
    entry = MODELS[case.model]
    if entry.build:
        return call(entry.build, case, support(case))
    return _build_model(bearing_of(case))


@lru_cache(maxsize=64)
def _build_model(case: Case) -> Any:
    """Build the core's model, cached: its arrays are read-only by convention."""
    parameters = kind(case).parameters
    model_parameters = parameters(**{name: PARAMETER_BUILDERS[name](case) for name in _builder_fields(parameters)})
    return static_model(model_parameters) if isinstance(model_parameters, Static) else model_parameters


def _builder_fields(parameters: Any) -> list[str]:
    """List the fields of a model's parameters that are built from a case."""
    fields = [
        name for name in parameters._fields if name not in parameters._field_defaults or name in PARAMETER_BUILDERS
    ]
    unknown = [name for name in fields if name not in PARAMETER_BUILDERS]
    if unknown:
        raise UserError(
            f"{parameters.__name__} needs `{unknown[0]}`, but there is no builder: {', '.join(PARAMETER_BUILDERS)}"
        )
    return fields


def defects_of_case(case: Case) -> Defects:
    """Build the case's defects, with the slices of the model's rollers if the model has any."""
    return defects.packed_defects(case, space.slices(case).table[:, ZETA] if MODELS[case.model].sliced else None)


def bending_of_case(case: Case) -> Any:
    """Build the bending of the case's outer ring; if there is a carrier, the bracket acts on it."""
    if case.rig.ring is None:
        return RigidRing()
    ring = bending.ring_parameters(case)
    if bending.has_carrier(case.rig):
        bracket = case.rig.bracket_stiffness, case.rig.bracket_damping, *bracket_anchor(case)
        ring = ring._replace(bracket=bracket)
    return bending.build_bending(ring)


def support(case: Case) -> Support:
    """Return load and bracket on the case's ring, zero if they act on a carrier."""
    if bending.has_carrier(case.rig):
        return Support(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    x_0, y_0 = ring_anchor(case)
    return Support(case.load, case.load_across, case.rig.bracket_stiffness, case.rig.bracket_damping, x_0, y_0)


def ring_anchor(case: Case) -> tuple[float, float]:
    """Compute the anchor (m, m) of a bracket on the ring; form moves it in space as in the plane."""
    if not space.unevenly_loaded(case):
        return bracket_anchor(case)
    smooth = static_case(case).model_copy(update={"surfaces": None})
    anchor = equilibrium_in_space(smooth)
    if case.surfaces is None:
        return anchor.x, anchor.y
    moved, unmoved = bracket_anchor(static_case(case)), bracket_anchor(smooth)
    return anchor.x + moved[0] - unmoved[0], anchor.y + moved[1] - unmoved[1]


def align_with_cusp(model: Any, steps_per_pass: int, fraction: float) -> Any:
    """Shift the model's rollers so that they meet the cusp of the first defect a ``fraction`` of a step after the
    start of a step.

    The cusp is the kink of the roller path, where the damping force jumps; its position within a step determines
    whether the error is of first or second order (docs/steps.md). The rollers are shifted forwards by less than a
    step. Only the first of several defects is aligned, and only on the outer race at a steady speed; other cusps
    lie anywhere in a step, and their error averages out.
    """
    if "defects" not in model._fields or not is_steady(model):
        return model
    defects = model.defects
    if len(defects.head) == 0 or defects.head[0, CARRIER] != ON_OUTER:
        return model
    b, pass_angle = model.bearing, 2.0 * pi / model.bearing.Z
    angle = defects.head[0, ANGLE] + defects.head[0, CUSP] / defects.head[0, RADIUS]
    steps = (b.theta_0 - angle) / pass_angle * steps_per_pass  # an integer if a step starts at the cusp
    shift = ceil(steps + fraction) - fraction - steps
    return model._replace(bearing=b._replace(theta_0=float(b.theta_0 + shift * pass_angle / steps_per_pass)))


def with_friction_lag(model: Any, lag: float) -> Any:
    """Return the model with friction lagged by ``lag`` (s), so that friction does not limit the step."""
    return model._replace(lag=lag) if "lag" in model._fields else model


def without_friction(model: Any) -> Any:
    """Return the model without friction between rollers and races."""
    return model._replace(friction=Frictionless()) if "friction" in model._fields else model


def start(case: Case, model: Any) -> tuple[np.ndarray, float]:
    """Return a buffer at t = 0 in static equilibrium, accelerations filled in, and the residual force (N).

    With a free cage and a seed, the rollers start at random positions in their pockets.
    """
    y, residual = empty_buffer(model), 0.0
    if MODELS[case.model].loaded:
        residual = find_equilibrium(model, 0.0, y, from_scratch=True)
        if MODELS[case.model].slips:  # in other models these cells may hold the harmonics of a flexible ring
            y[lay.EPS : lay.EPS + model.bearing.Z] = free.initial_pocket_angles(case)
        start_at_rest(model, 0.0, y)
    return y, residual


def find_equilibrium(model: Any, t: float, y: np.ndarray, from_scratch: bool = False) -> float:
    """Find the static equilibrium at ``t`` (s), from the one in ``y`` or from scratch; return the residual force
    (N).
    """
    residual = solve_in_cpu_time(
        solve_initial_equilibrium if from_scratch else solve_equilibrium, static_model(model), t, y
    )
    return solve_spatial_equilibrium(undamped(model), t, y) if isinstance(model, Spatial) else float(residual)


def undamped(model: Any) -> Any:
    """Return the model with undamped contacts: same equilibrium, compiled once for all damping laws."""
    return model._replace(outer=Undamped(model.outer.stiffness), inner=Undamped(model.inner.stiffness))


def empty_buffer(model: Any) -> np.ndarray:
    """Allocate a zeroed state buffer for the model."""
    return lay.buffer(model.bearing.Z, model.bearing.m_r, slices_of(model))


def slices_of(model: Any) -> int:
    """Return the number of slices of a roller; 0 for a model without slices."""
    return len(model.slices.table) if "slices" in model._fields else 0


def outer_forces(model: Any, y: np.ndarray) -> np.ndarray:
    """Return the outer contact force (N) of each roller, (Z,), from the buffer."""
    return y[lay.Q_O : lay.Q_O + model.bearing.Z]


def method(case: Case, h: float, step_ratio: float = 1.0) -> Any:
    """Build the core's method of the case for step ``h`` (s), ``step_ratio`` times the normal step.

    At half the step an adaptive method uses a tenth of its default tolerance; a tolerance set by the case is kept.
    """
    parameters: Any = method_kind(case).parameters
    default_tolerance = METHODS[case.method].tolerance if case.method is not None else None
    if default_tolerance is None:
        return parameters(h)
    scaled_tolerance = step_ratio ** log2(10.0) * default_tolerance
    tolerance = scaled_tolerance if case.tolerance == "auto" else case.tolerance
    start_model = model(case)
    full_speed_model = start_model if case.ramp is None else model(scales.full_speed_case(case))
    return parameters(*scales.tolerances(case, start_model, full_speed_model, h, tolerance))
