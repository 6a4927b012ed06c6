"""Assembly of the core's parameters from a case: the only link between configuration and physics.

It imports numba through the core, so other modules import it only where they compute.
"""

from functools import lru_cache
from math import ceil, log2, pi
from typing import Any

import numpy as np

from bearingsim.assemble import bending, contacts, defects, form, free, geometry, scales, space
from bearingsim.assemble.anchor import bracket_anchor
from bearingsim.assemble.reduced import bearing_case, healthy_case, static_case
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
from bearingsim.core.models.interface import ModelKind
from bearingsim.core.models.mean_equilibrium import solve_at
from bearingsim.core.models.spatial import Spatial
from bearingsim.core.models.spatial_equilibrium import solve_spatial_equilibrium
from bearingsim.core.models.static import Static
from bearingsim.core.parameters import Support
from bearingsim.core.parts.bending import RigidRing
from bearingsim.errors import UserError

__all__ = [
    "align_with_cusp",
    "bearing_case",
    "empty_buffer",
    "find_equilibrium",
    "healthy_case",
    "is_adaptive",
    "kind_of_method",
    "kind_of_model",
    "method",
    "method_kind",
    "model",
    "model_kind",
    "outer_forces",
    "start",
    "static_model",
    "with_friction_lag",
    "without_friction",
]

PARAMETER_BUILDERS: dict[str, Any] = {
    "bearing": geometry.build_bearing,
    "support": lambda case: build_support(case),
    "outer": contacts.build_outer_law,
    "inner": contacts.build_inner_law,
    "rate_division": contacts.build_rate_division,
    "defects": lambda case: build_defects(case),
    "bending": lambda case: build_ring_bending(case),
    "form": form.build_form,
    "motion": free.build_motion,
    "friction": free.build_friction,
    "cage": free.build_cage,
    "drag": free.build_drag,
    "shaft": free.build_shaft,
    "bracket": free.build_bracket,
    "gravity": free.gravity,
    "slices": space.build_slices,
    "L_w": contacts.roller_length,
    "I_t": space.transverse_roller_inertia,
    "mount_o": space.build_outer_mount,
    "mount_i": space.build_inner_mount,
    "flanges": space.build_flanges,
    "cage_z": space.build_cage_in_space,
}
"""Builders of the fields of a model's parameters, by field; each is a function of the case."""


def model_kind(case: Case) -> ModelKind:
    """Return the classes and functions of the case's model."""
    return kind_of_model(case.model)


def kind_of_model(name: str) -> ModelKind:
    """Return the classes and functions of a model."""
    loaded: ModelKind = code(f"{MODELS[name].module}:KIND", ModelKind)
    return loaded


def kind_of_method(name: str) -> MethodKind:
    """Return the classes and functions of an integration method."""
    loaded: MethodKind = code(f"{METHODS[name].module}:KIND", MethodKind)
    return loaded


def method_kind(case: Case) -> MethodKind:
    """Return the classes and functions of the case's method, or of its model's integrator if it has no method.

    `auto` must have been resolved.
    """
    if case.method is not None:
        return kind_of_method(case.method)
    loaded: MethodKind = code(f"{MODELS[case.model].own_method}:KIND", MethodKind)
    return loaded


def is_adaptive(case: Case) -> bool:
    """Check if the case's method adapts its step; `auto` must have been resolved."""
    return case.method is not None and METHODS[case.method].adaptive


def model(case: Case) -> Any:
    """Assemble the core's model of the case.

    The bracket is anchored at the mean equilibrium position of the healthy bearing, because it would carry part
    of the load if it were anchored elsewhere. Raises ``NoEquilibrium`` if the healthy bearing has no equilibrium.
    """
    entry = MODELS[case.model]
    if entry.build:
        return call(entry.build, case, build_support(case))
    return _build_model(bearing_case(case))


@lru_cache(maxsize=64)
def _build_model(case: Case) -> Any:
    """Build the core's model. It is cached, so callers must not modify its arrays."""
    parameters = model_kind(case).parameters
    model_parameters = parameters(**{name: PARAMETER_BUILDERS[name](case) for name in _builder_fields(parameters)})
    return static_model(model_parameters) if isinstance(model_parameters, Static) else model_parameters


def _builder_fields(parameters: Any) -> list[str]:
    """List the fields of a model's parameters that are built from a case.

    Raises UserError for a field without builder or default value.
    """
    fields = [
        name for name in parameters._fields if name not in parameters._field_defaults or name in PARAMETER_BUILDERS
    ]
    unknown = [name for name in fields if name not in PARAMETER_BUILDERS]
    if unknown:
        raise UserError(
            f"{parameters.__name__} needs `{unknown[0]}`, which has no builder; available:"
            f" {', '.join(PARAMETER_BUILDERS)}"
        )
    return fields


def build_defects(case: Case) -> Defects:
    """Pack the case's defects, with one group per slice if the model divides rollers into slices."""
    return defects.pack_case_defects(
        case, space.build_slices(case).table[:, ZETA] if MODELS[case.model].sliced else None
    )


def build_ring_bending(case: Case) -> Any:
    """Build the bending of the case's outer ring, with the bracket if it acts on a carrier around the ring."""
    if case.rig.ring is None:
        return RigidRing()
    ring = bending.ring_parameters(case)
    if bending.has_carrier(case.rig):
        bracket = case.rig.bracket_stiffness, case.rig.bracket_damping, *bracket_anchor(case)
        ring = ring._replace(bracket=bracket)
    return bending.build_bending(ring)


def build_support(case: Case) -> Support:
    """Build load and bracket on the case's ring, both zero if they act on a carrier around it."""
    if bending.has_carrier(case.rig):
        return Support(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    x_0, y_0 = ring_anchor(case)
    return Support(case.load, case.load_across, case.rig.bracket_stiffness, case.rig.bracket_damping, x_0, y_0)


def ring_anchor(case: Case) -> tuple[float, float]:
    """Compute the anchor (m, m) of a bracket on the ring.

    If rollers are loaded unevenly along their length, the anchor is that of the smooth bearing in space, plus the
    shift by the form of the surfaces in the plane.
    """
    if not space.unevenly_loaded(case):
        return bracket_anchor(case)
    smooth = static_case(case).model_copy(update={"surfaces": None})
    anchor = equilibrium_in_space(smooth)
    if case.surfaces is None:
        return anchor.x, anchor.y
    planar, smooth_planar = bracket_anchor(static_case(case)), bracket_anchor(smooth)
    return anchor.x + planar[0] - smooth_planar[0], anchor.y + planar[1] - smooth_planar[1]


def align_with_cusp(model: Any, steps_per_pass: int, fraction: float) -> Any:
    """Rotate the model's rollers so that they meet a defect's cusp a ``fraction`` of a step after a step begins.

    The cusp is the kink of the roller path, where the damping force jumps; its position within a step determines
    whether the error is of first or second order (docs/steps.md). The rotation is forwards, by less than a step.
    It aligns the first defect only, and only if that is on the outer race and the speed is steady. Other cusps lie
    anywhere within a step, and their errors average out.
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
    """Return the model with friction evaluated at the slip after ``lag`` (s), so that it does not limit the step.

    See ``core/laws/friction/lag.py``. A model without slip is returned unchanged.
    """
    return model._replace(lag=lag) if "lag" in model._fields else model


def without_friction(model: Any) -> Any:
    """Return the model without friction between rollers and races; a model without slip is returned unchanged."""
    return model._replace(friction=Frictionless()) if "friction" in model._fields else model


def start(case: Case, model: Any) -> tuple[np.ndarray, float]:
    """Fill a state buffer at t = 0 with the static equilibrium and its accelerations; return it and the residual
    force (N).

    With a free cage and a seed, the rollers start at random positions in their pockets. If the rollers of the
    model carry no load, the buffer is zero.
    """
    y, residual = empty_buffer(model), 0.0
    if MODELS[case.model].loaded:
        residual = find_equilibrium(model, 0.0, y, from_scratch=True)
        if MODELS[case.model].slips:  # other models may store harmonics of a flexible ring in these cells
            y[lay.EPS : lay.EPS + model.bearing.Z] = free.initial_pocket_angles(case)
        start_at_rest(model, 0.0, y)
    return y, residual


def find_equilibrium(model: Any, t: float, y: np.ndarray, from_scratch: bool = False) -> float:
    """Solve for the static equilibrium at ``t`` (s) into the buffer ``y``; return the residual force (N).

    The solution starts from the equilibrium in ``y`` unless ``from_scratch`` is true.
    """
    residual = solve_at(static_model(model), t, y, from_scratch)
    return solve_spatial_equilibrium(without_damping(model), t, y) if isinstance(model, Spatial) else residual


def without_damping(model: Any) -> Any:
    """Return the model with undamped contacts.

    Its equilibrium is the same, but is compiled only once for all damping laws.
    """
    return model._replace(outer=Undamped(model.outer.stiffness), inner=Undamped(model.inner.stiffness))


def empty_buffer(model: Any) -> np.ndarray:
    """Allocate a zeroed state buffer for the model."""
    return lay.make_buffer(model.bearing.Z, model.bearing.m_r, slice_count(model))


def slice_count(model: Any) -> int:
    """Count the slices of a roller; 0 for a model without slices."""
    return len(model.slices.table) if "slices" in model._fields else 0


def outer_forces(model: Any, y: np.ndarray) -> np.ndarray:
    """Return the outer contact force (N) of each roller, (Z,), from the buffer."""
    return y[lay.Q_O : lay.Q_O + model.bearing.Z]


def method(case: Case, h: float, step_ratio: float = 1.0) -> Any:
    """Build the core's method of the case for step ``h`` (s), which is ``step_ratio`` times the normal step.

    The default tolerance of an adaptive method is multiplied by step_ratio^log2(10), which is a tenth at half the
    step. A tolerance that the case specifies is not changed.
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
