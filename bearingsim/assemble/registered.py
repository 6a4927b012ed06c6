"""Checks that model, method, laws and features of a case, possibly from extensions, are complete."""

from collections.abc import Iterator
from typing import Any

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
    monitored,
    state_width,
    stiffness_per_mass,
    update_extremes,
)
from bearingsim.errors import UserError

DAMPING = (normal_force, stiffness_bound, damping_bound), (derivatives,)
STIFFNESS = (elastic, tangent), (curvature,)
FRICTION = (mu, mu_derivative_bound), (mu_derivative,)
"""Functions of a kind of law that every method needs, and derivatives that implicit methods need."""
MODEL = (
    (state_width, begin, update_extremes, monitored, stiffness_per_mass, damping_per_mass, count_crossings),
    (linearise, degrees_of_freedom),
)
METHOD = (step, stability_ratio), ()


def missing_functions(case: Case, implicit: bool) -> Iterator[str]:
    """List messages on functions missing in model, method and laws of a case; ``implicit``: also derivatives."""
    model: Any = assemble.kind(case).parameters
    contact, damping = case.contact, case.contact.damping
    yield from _missing(f"model `{case.model}`", model, MODEL, implicit)
    if "defects" not in model._fields and model not in count_crossings.types:
        yield f"the model `{case.model}` has neither `defects` nor a `count_crossings` of its own"
    if not MODELS[case.model].own_method and not accelerations.supports(model):
        yield f"the model `{case.model}` has no `accelerations`"
    if case.method not in (None, AUTO):
        method = assemble.kind_of_method(str(case.method)).parameters
        yield from _missing(f"method `{case.method}`", method, METHOD, implicit)
    law = contacts.outer(case)
    yield from _missing(f"stiffness law `{contact.elastic_law}`", type(law.stiffness), STIFFNESS, implicit)
    yield from _missing(f"damping law `{getattr(damping, 'law', '')}`", type(law), DAMPING, implicit)
    if case.friction is not None:
        name = getattr(case.friction, "law", "")
        yield from _missing(f"friction law `{name}`", type(free.friction(case)), FRICTION, implicit)


def _missing(owner: str, kind: type, functions: tuple[tuple[Any, ...], ...], implicit: bool) -> Iterator[str]:
    required, implicit_functions = functions
    for function in (*required, *(implicit_functions if implicit else ())):
        if not function.supports(kind):
            yield f"the {owner} lacks `{function.__name__}`"


def check_features() -> None:
    """Raise UserError if a feature of an extension does not load, or was registered too late to be declared."""
    for feature in FEATURES.values():
        if not callable(code(feature.compute)):
            raise UserError(f"feature `{feature.name}`: `{feature.compute}` is not a function")
        if feature.name not in DECLARED:
            raise UserError(
                f"feature `{feature.name}` is not declared; register it in the module of its entry point"
            )
