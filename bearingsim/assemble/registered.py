"""Checks that the model, method and laws of a case, and all features, have the functions that they need."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from bearingsim import assemble
from bearingsim.assemble import contacts, free
from bearingsim.catalogue import AUTO, FEATURES, MODELS, code
from bearingsim.config import FEATURES as DECLARED
from bearingsim.config import Case
from bearingsim.core.defects.crossings import count_crossings
from bearingsim.core.laws.damping.interface import damping_bound, derivatives, normal_force, stiffness_bound
from bearingsim.core.laws.friction.interface import mu, mu_derivative, mu_derivative_bound
from bearingsim.core.laws.stiffness.interface import curvature, elastic, tangent
from bearingsim.core.methods.interface import stability_ratio, step
from bearingsim.core.models.interface import (
    accelerations,
    begin,
    damping_per_mass,
    degrees_of_freedom,
    linearise,
    monitored_bodies,
    state_width,
    stiffness_per_mass,
    update_extremes,
)
from bearingsim.errors import UserError


class Functions(NamedTuple):
    """Functions to register for a type: those ``required`` by every method, and those only by implicit ones."""

    required: tuple[Any, ...]
    implicit: tuple[Any, ...] = ()


DAMPING_FUNCTIONS = Functions((normal_force, stiffness_bound, damping_bound), (derivatives,))
STIFFNESS_FUNCTIONS = Functions((elastic, tangent), (curvature,))
FRICTION_FUNCTIONS = Functions((mu, mu_derivative_bound), (mu_derivative,))
MODEL_FUNCTIONS = Functions(
    (state_width, begin, update_extremes, monitored_bodies, stiffness_per_mass, damping_per_mass, count_crossings),
    (linearise, degrees_of_freedom),
)
METHOD_FUNCTIONS = Functions((step, stability_ratio))


def missing_functions(case: Case, implicit: bool) -> Iterator[str]:
    """Yield a message for each function that model, method or a law of a case lacks.

    implicit: True if the functions that only implicit methods need are required, too.
    """
    model_type: Any = assemble.model_kind(case).parameters
    contact, damping = case.contact, case.contact.damping
    yield from _missing(f"model `{case.model}`", model_type, MODEL_FUNCTIONS, implicit)
    if "defects" not in model_type._fields and model_type not in count_crossings.types:
        yield f"the model `{case.model}` has neither `defects` nor a `count_crossings` of its own"
    if not MODELS[case.model].own_method and not accelerations.supports(model_type):
        yield f"the model `{case.model}` has no `accelerations`"
    if case.method not in (None, AUTO):
        method_type = assemble.kind_of_method(str(case.method)).parameters
        yield from _missing(f"method `{case.method}`", method_type, METHOD_FUNCTIONS, implicit)
    law = contacts.build_outer_law(case)
    yield from _missing(
        f"stiffness law `{contact.elastic_law}`", type(law.stiffness), STIFFNESS_FUNCTIONS, implicit
    )
    yield from _missing(f"damping law `{getattr(damping, 'law', '')}`", type(law), DAMPING_FUNCTIONS, implicit)
    if case.friction is not None:
        name = getattr(case.friction, "law", "")
        yield from _missing(
            f"friction law `{name}`", type(free.build_friction(case)), FRICTION_FUNCTIONS, implicit
        )


def _missing(owner: str, kind: type, functions: Functions, implicit: bool) -> Iterator[str]:
    """Yield a message for each function that is not registered for the type ``kind``."""
    for function in (*functions.required, *(functions.implicit if implicit else ())):
        if not function.supports(kind):
            yield f"the {owner} lacks `{function.__name__}`"


def check_features() -> None:
    """Raise UserError if the function of a feature cannot be loaded, or if a feature was registered too late.

    Features are declared when the configuration is imported; those registered later are missing there.
    """
    for feature in FEATURES.values():
        if not callable(code(feature.compute)):
            raise UserError(f"feature `{feature.name}`: `{feature.compute}` is not a function")
        if feature.name not in DECLARED:
            raise UserError(
                f"feature `{feature.name}` is not declared; register it in the module of its entry point"
            )
