"""Which method steps a case: the cheapest that holds 1 %, by the limits of its step and by what a step costs.

A motion that may repeat itself is stepped by Verlet's method until it does. If it has not done so after some ball
passes, and another method would take less for all of the run than Verlet's for the rest, that one takes over.
"""

from collections.abc import Iterator
from functools import lru_cache
from math import inf
from typing import NamedTuple

from bearingsim.assemble.registered import missing, refuse_features
from bearingsim.catalogue import AUTO, EXPLICIT, METHODS, MODELS
from bearingsim.config import Case
from bearingsim.errors import Refused
from bearingsim.simulation.automatic_step import automatic_step
from bearingsim.simulation.cost import Cost, cost
from bearingsim.simulation.limits import Limits, step_limits
from bearingsim.simulation.prices import price
from bearingsim.simulation.repetition import may_repeat
from bearingsim.simulation.settling import refuse_unsettled, settled

STEP_PARTS = (1.0, 0.5, 0.25, 0.125)
"""Parts of an automatic step that are tried in turn; with half of it goes a tenth of the tolerance."""
ADAPTIVE_MARGIN, IMPLICIT_MARGIN = 1.2, 2.0
"""How many times its estimate an adaptive method may cost: more where accuracy bounds its steps, not stability."""


class Choice(NamedTuple):
    """A method for a case, why in words, and what each able one would cost (CPU s), in the order of ``margin``.

    patience: ball passes after which a motion that does not repeat itself is left to the next method; 0 if it is
    not.
    """

    method: str | None
    why: str
    prices: dict[str, float]
    patience: int = 0


class Attempt(NamedTuple):
    """One way to compute a case: its method named, and the part of the automatic step (or tolerance) to take.

    patience: as of ``Choice``.
    """

    case: Case
    part: float
    patience: int = 0


def resolved(case: Case) -> Case:
    """Return the case with a method instead of `auto`, and with a time to settle in."""
    found = choice(case).method
    return settled(case if found == case.method else with_method(case, found))


def limits(case: Case) -> Limits:
    """Return what the case's step must respect, by the method that it is given or chosen."""
    return step_limits(resolved(case))


def with_method(case: Case, method: str | None) -> Case:
    """Return the case with a method of that name."""
    return case.model_copy(update={"method": method})


def attempts(case: Case) -> Iterator[Attempt]:
    """What to try in turn until a run proves right: shorter automatic steps, then (with `auto`) other methods.

    At last the first method without its patience, if it was left for that. Raises ``Refused`` if the step check is
    strict and the run would not settle.
    """
    first, patience = resolved(case), choice(case).patience
    refuse_unsettled(first)
    parts = STEP_PARTS if case.automatic and case.tolerance == "auto" else (1.0,)
    for part in parts:
        yield Attempt(first, part, patience)
    for name in tried(case)[1:]:
        yield from (Attempt(with_method(first, name), part) for part in parts)
    if patience > 0:
        yield from (Attempt(first, part) for part in parts)


def tried(case: Case) -> list[str | None]:
    """List the methods to compute a case with, each if those before fail; its own word if it is refused."""
    try:
        first = choice(case).method
    except Refused:
        return [case.method]
    others = alternatives(with_method(case, first)) if case.method == AUTO and case.automatic else []
    return [first, *others]


def alternatives(case: Case) -> list[str]:
    """Other methods of the automatic set that can step the case, the cheapest first; none if it has no method."""
    if case.method is None:
        return []
    return [name for name in choice(with_method(case, AUTO)).prices if name != case.method]


@lru_cache(maxsize=1 << 17)
def choice(case: Case) -> Choice:
    """Return the cheapest method that holds 1 % of the fault's line. Raises ``Refused`` like ``limits``.

    `periodic: false` is given the method that it is to check.
    """
    _refuse_incomplete(case)
    if case.method != AUTO:
        return Choice(case.method, "the case says so" if case.method else f"{case.model} has no method", {})
    able = [name for name in METHODS if METHODS[name].automatic and can_step(case, name)]
    if case.tolerance != "auto":  # only those that keep one
        able = [name for name in able if METHODS[name].adaptive]
    as_usual = settled(case).model_copy(update={"periodic": True})
    costs = {name: _cost(with_method(as_usual, name)) for name in able}
    safe = sorted(able, key=lambda name: margin(name) * costs[name].whole)
    prices = {name: costs[name].whole for name in safe}
    if EXPLICIT not in prices:
        return Choice(safe[0], "the cheapest of those that keep a tolerance", prices)
    if safe[0] != EXPLICIT:
        return Choice(safe[0], _saving(safe[0], prices, step_limits(with_method(case, EXPLICIT))), prices)
    if not may_repeat(with_method(as_usual, EXPLICIT)):
        return Choice(EXPLICIT, "no other method would take much less CPU time", prices)
    return Choice(EXPLICIT, "the response may be periodic", prices, _patience(case, costs))


def margin(name: str) -> float:
    """Return how many times its estimate a method may cost."""
    return IMPLICIT_MARGIN if METHODS[name].implicit else ADAPTIVE_MARGIN if METHODS[name].adaptive else 1.0


def _patience(case: Case, costs: dict[str, Cost]) -> int:
    """Ball passes after which another method would take less for all of the run than Verlet's for the rest."""
    others = [margin(name) * one.whole for name, one in costs.items() if name != EXPLICIT]
    patience = int(price("patience"))
    rest = costs[EXPLICIT].at_most - patience * costs[EXPLICIT].one_pass
    return patience if case.periodic and case.until is None and min(others, default=inf) < rest else 0


def can_step(case: Case, name: str) -> bool:
    """Check if a method can step the case's model: an implicit one needs its derivatives.

    Friction is steep: at its rate the steps of an explicit adaptive method would go, others let it lag.
    """
    if METHODS[name].implicit:
        return case.rig.ring is None and not any(missing(case, implicit=True))
    return not METHODS[name].adaptive or not MODELS[case.model].slips or is_frictionless(case)


def is_frictionless(case: Case) -> bool:
    """Check if nothing rubs in a case whose model knows of friction."""
    on_races = getattr(case.friction, "law", "none") != "none"
    return not on_races and (case.cage is None or case.cage.motion == "kinematic")


def _refuse_incomplete(case: Case) -> None:
    """Raise ``Refused`` if laws or model do not bring what the case's method calls, UserError for features."""
    refuse_features()
    implicit = case.method not in (None, AUTO) and METHODS[str(case.method)].implicit
    found = next(missing(case, implicit), "")
    if found:
        why = f", which {case.method} solves with" if implicit else ""
        advice = "take an explicit method, or register it" if implicit else "register it (docs/extending.md)"
        raise Refused(found + why, advice)


def _saving(chosen: str, prices: dict[str, float], found: Limits) -> str:
    saved = prices[EXPLICIT] / prices[chosen]
    return f"explicit steps are limited to {1e6 * found.at_impact:.2g} us: about {saved:.2g} times the CPU time"


def _cost(case: Case) -> Cost:
    """Return what a case whose method is named takes at its own step, or the automatic one."""
    return cost(case, automatic_step(case, step_limits(case)) if case.step == "auto" else case.step)
