"""Which method steps a case: the cheapest that holds 1 %, by the limits of its step and by what a step costs."""

from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

from bearingsim.assemble.registered import missing
from bearingsim.catalogue import AUTO, EXPLICIT, METHODS
from bearingsim.config import Case
from bearingsim.errors import Refused
from bearingsim.simulation.automatic_step import automatic_step
from bearingsim.simulation.limits import Limits, step_limits
from bearingsim.simulation.prices import per_second

SHORTENED = (1.0, 0.5, 0.25, 0.125)
"""Parts of an automatic step that are tried in turn; with half of it goes a tenth of the tolerance."""
FAVOUR = 3.0  # what an implicit method must save: an explicit one's price is certain, its own an estimate


class Choice(NamedTuple):
    """A method for a case, why in words, and what each able one would cost (CPU s), the cheapest first."""

    method: str | None
    why: str
    prices: dict[str, float]


class Attempt(NamedTuple):
    """One way to compute a case: its method named, and the part of the automatic step (or tolerance) to take."""

    case: Case
    part: float


def resolved(case: Case) -> Case:
    """The case with a method instead of `auto`."""
    found = choice(case).method
    return case if found == case.method else using(case, found)


def limits(case: Case) -> Limits:
    """What the case's step must respect, by the method that it is given or chosen."""
    return step_limits(resolved(case))


def using(case: Case, method: str | None) -> Case:
    """The case with a method of that name."""
    return case.model_copy(update={"method": method})


def attempts(case: Case) -> Iterator[Attempt]:
    """What to try in turn until a run proves right: shorter automatic steps, then (with `auto`) other methods."""
    first = resolved(case)
    parts = SHORTENED if case.automatic and case.tolerance == "auto" else (1.0,)
    for part in parts:
        yield Attempt(first, part)
    if case.method == AUTO and case.automatic:
        for name in alternatives(first):
            yield from (Attempt(using(case, name), part) for part in parts)


def alternatives(case: Case) -> list[str]:
    """Other methods of the automatic set that can step the case, the cheapest first; none if it has no method."""
    if case.method is None:
        return []
    return [name for name in choice(using(case, AUTO)).prices if name != case.method]


@lru_cache(maxsize=1024)
def choice(case: Case) -> Choice:
    """The cheapest method that holds 1 % of the fault's line. Raises ``Refused`` like ``limits``.

    DOP853 costs what Verlet does where contacts are soft and little damped, and is kept for what Verlet fails at.
    """
    _refuse_incomplete(case)
    if case.method != AUTO:
        return Choice(case.method, "the case says so" if case.method else f"{case.model} has no method", {})
    able = [name for name in METHODS if METHODS[name].automatic and can(case, name)]
    if case.tolerance != "auto":  # only those that keep one
        able = [name for name in able if METHODS[name].adaptive]
    prices = dict(sorted(((name, _integration(using(case, name))) for name in able), key=lambda pair: pair[1]))
    found = step_limits(using(case, EXPLICIT))
    if EXPLICIT not in prices:
        return Choice(next(iter(prices)), "the cheapest of those that keep a tolerance", prices)
    implicit = [name for name in prices if METHODS[name].implicit]
    chosen = implicit[0] if implicit and FAVOUR * prices[implicit[0]] < prices[EXPLICIT] else EXPLICIT
    return Choice(chosen, _reason(chosen, prices, found), prices)


def can(case: Case, name: str) -> bool:
    """Whether a method can step the case's model: an implicit one needs its derivatives."""
    return not METHODS[name].implicit or not any(missing(case, implicit=True))


def _refuse_incomplete(case: Case) -> None:
    """Raise ``Refused`` if laws, or the model, do not bring what the case's method calls."""
    implicit = case.method not in (None, AUTO) and METHODS[str(case.method)].implicit
    found = next(missing(case, implicit), "")
    if found:
        why = f", which {case.method} solves with" if implicit else ""
        advice = "take an explicit method, or register it" if implicit else "register it (docs/extending.md)"
        raise Refused(found + why, advice)


def _reason(chosen: str, prices: dict[str, float], found: Limits) -> str:
    if chosen == EXPLICIT:
        return "no implicit method would take less than a third of its CPU time"
    saved = prices[EXPLICIT] / prices[chosen]
    return f"explicit steps are limited to {1e6 * found.at_impact:.2g} us: about {saved:.0f} times the CPU time"


def _integration(case: Case) -> float:
    """CPU time (s) of all steps of a case whose method is named, at the automatic step."""
    return (case.settle + case.duration) * per_second(case, automatic_step(case, step_limits(case)))
