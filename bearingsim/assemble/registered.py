"""Whether the laws of a case bring all that a run calls: another package's may have forgotten something."""

from collections.abc import Iterator
from typing import Any

from bearingsim.assemble import contacts, free
from bearingsim.config import Case
from bearingsim.core.laws.damping.interface import damping_bound, normal_force, slopes, stiffness_bound
from bearingsim.core.laws.friction.interface import mu, mu_slope, steepest
from bearingsim.core.laws.stiffness.interface import curvature, elastic, tangent

DAMPING = (normal_force, stiffness_bound, damping_bound), (slopes,)
STIFFNESS = (elastic, tangent), (curvature,)
FRICTION = (mu, steepest), (mu_slope,)
"""Of each kind of law: what every method calls, and the derivatives that an implicit one solves with."""


def missing(case: Case, implicit: bool) -> Iterator[str]:
    """What the case's laws do not register, in words; ``implicit``: of derivatives too."""
    contact, damping = case.contact, case.contact.damping
    law = contacts.outer(case)
    yield from _missing(f"stiffness law `{contact.elastic_law}`", law.stiffness, STIFFNESS, implicit)
    yield from _missing(f"damping law `{getattr(damping, 'law', '')}`", law, DAMPING, implicit)
    if case.friction is not None:
        yield from _missing(
            f"friction law `{getattr(case.friction, 'law', '')}`", free.friction(case), FRICTION, implicit
        )


def _missing(what: str, law: Any, called: tuple[tuple[Any, ...], ...], implicit: bool) -> Iterator[str]:
    always, solved_with = called
    for function in (*always, *(solved_with if implicit else ())):
        if not function.serves(type(law)):
            yield f"the {what} has no `{function.__name__}`"
