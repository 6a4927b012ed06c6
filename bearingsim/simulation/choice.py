"""Choice of a case's method and automatic step, and the attempts that follow if a run fails.

The method is the cheapest within 1 % of the defect's line, by the limits of its step and the cost of a step. A
response that may be periodic is stepped by velocity Verlet until it is. If it is not after some ball passes, and
another method needs less CPU time for the whole run than Verlet for the rest, that one takes over.
"""

from collections.abc import Iterator
from functools import lru_cache
from math import inf
from typing import NamedTuple

from bearingsim import assemble
from bearingsim.assemble.registered import missing, refuse_features
from bearingsim.catalogue import AUTO, EXPLICIT, METHODS, MODELS
from bearingsim.config import Case
from bearingsim.errors import Refused
from bearingsim.simulation.limits import LONGEST, Limits, step_limits
from bearingsim.simulation.pricing import Cost, cost, price
from bearingsim.simulation.repetition import may_repeat
from bearingsim.simulation.settling import refuse_unsettled, settled

STEP_PARTS = (1.0, 0.5, 0.25, 0.125)
"""Fractions of the automatic step that are tried in turn; half the step goes with a tenth of the tolerance."""
ADAPTIVE_MARGIN, IMPLICIT_MARGIN = 1.2, 2.0
"""Safety factors on the estimated cost of explicit adaptive methods, whose steps stability bounds, and of implicit
ones, whose steps accuracy bounds."""


class Choice(NamedTuple):
    """Method of a case, the reason in words, and prices (CPU s) of suitable methods in the order of ``margin``.

    patience: ball passes after which a response that is not periodic is left to the next method; 0: never.
    """

    method: str | None
    why: str
    prices: dict[str, float]
    patience: int = 0


class Attempt(NamedTuple):
    """Case with its method named, and the fraction of the automatic step (or tolerance) to take.

    patience: as of ``Choice``.
    """

    case: Case
    part: float
    patience: int = 0


def resolved(case: Case) -> Case:
    """Return the case with a method instead of `auto`, and with a time to settle in."""
    method = choice(case).method
    return settled(case if method == case.method else with_method(case, method))


def limits(case: Case) -> Limits:
    """Return the limits of the case's step, for its own or the chosen method."""
    return step_limits(resolved(case))


def with_method(case: Case, method: str | None) -> Case:
    """Return the case with a method of that name."""
    return case.model_copy(update={"method": method})


def attempts(case: Case) -> Iterator[Attempt]:
    """Yield the attempts in turn: shorter automatic steps, then (with `auto`) other methods.

    If the first method was left for lack of a period, it comes again last, without patience. Raises ``Refused`` if
    the step check is strict and the run would not settle.
    """
    preferred, patience = resolved(case), choice(case).patience
    refuse_unsettled(preferred)
    parts = STEP_PARTS if has_automatic_step(case) else (1.0,)
    for part in parts:
        yield Attempt(preferred, part, patience)
    for name in tried(case)[1:]:
        yield from (Attempt(with_method(preferred, name), part) for part in parts)
    if patience > 0:
        yield from (Attempt(preferred, part) for part in parts)


def has_automatic_step(case: Case) -> bool:
    """Check if the program chooses the step of a case, and may shorten it (or its tolerance)."""
    return case.automatic and case.tolerance == "auto"


def tried(case: Case) -> list[str | None]:
    """List the methods to compute a case with, each if those before fail; the case's own if it is refused."""
    try:
        preferred = choice(case).method
    except Refused:
        return [case.method]
    others = alternatives(with_method(case, preferred)) if case.method == AUTO and case.automatic else []
    return [preferred, *others]


def alternatives(case: Case) -> list[str]:
    """List the other automatic methods that can step the case, the cheapest first; none if it has no method."""
    if case.method is None:
        return []
    return [name for name in choice(with_method(case, AUTO)).prices if name != case.method]


@lru_cache(maxsize=1 << 17)
def choice(case: Case) -> Choice:
    """Return the cheapest method within 1 % of the defect's line. Raises ``Refused`` like ``limits``.

    A case with `periodic: false` gets the method of the periodic run that it is to check.
    """
    _refuse_incomplete(case)
    if case.method != AUTO:
        return Choice(case.method, "the case says so" if case.method else f"{case.model} has no method", {})
    able = [name for name in METHODS if METHODS[name].automatic and can_step(case, name)]
    if case.tolerance != "auto":  # only those that keep one
        able = [name for name in able if METHODS[name].adaptive]
    periodic = settled(case).model_copy(update={"periodic": True})
    costs = {name: _cost(with_method(periodic, name)) for name in able}
    safe = sorted(able, key=lambda name: margin(name) * costs[name].whole)
    prices = {name: costs[name].whole for name in safe}
    if EXPLICIT not in prices:
        return Choice(safe[0], "the cheapest of those that keep a tolerance", prices)
    if safe[0] != EXPLICIT:
        return Choice(safe[0], _saving(safe[0], prices, step_limits(with_method(case, EXPLICIT))), prices)
    if not may_repeat(with_method(periodic, EXPLICIT)):
        return Choice(EXPLICIT, "no other method would take much less CPU time", prices)
    return Choice(EXPLICIT, "the response may be periodic", prices, _patience(case, costs))


def margin(name: str) -> float:
    """Return the safety factor on a method's estimated cost."""
    return IMPLICIT_MARGIN if METHODS[name].implicit else ADAPTIVE_MARGIN if METHODS[name].adaptive else 1.0


def _patience(case: Case, costs: dict[str, Cost]) -> int:
    """Return the ball passes after which another method is cheaper for the whole run than Verlet for the rest."""
    others = [margin(name) * estimate.whole for name, estimate in costs.items() if name != EXPLICIT]
    patience = int(price("patience"))
    rest = costs[EXPLICIT].at_most - patience * costs[EXPLICIT].one_pass
    return patience if case.periodic and case.until is None and min(others, default=inf) < rest else 0


def can_step(case: Case, name: str) -> bool:
    """Check if a method can step the case's model: an implicit one needs its derivatives.

    Friction is steep and would set the steps of an explicit adaptive method; methods of fixed step lag it.
    """
    if METHODS[name].implicit:
        return case.rig.ring is None and not any(missing(case, implicit=True))
    return not METHODS[name].adaptive or not MODELS[case.model].slips or is_frictionless(case)


def is_frictionless(case: Case) -> bool:
    """Check if a case whose model has friction is without any."""
    on_races = getattr(case.friction, "law", "none") != "none"
    return not on_races and (case.cage is None or case.cage.motion == "kinematic")


def _refuse_incomplete(case: Case) -> None:
    """Raise ``Refused`` if laws or model lack a function that the method calls, UserError for features."""
    refuse_features()
    implicit = case.method not in (None, AUTO) and METHODS[str(case.method)].implicit
    lacking = next(missing(case, implicit), "")
    if lacking:
        why = f", which {case.method} solves with" if implicit else ""
        advice = "take an explicit method, or register it" if implicit else "register it (docs/extending.md)"
        raise Refused(lacking + why, advice)


def _saving(chosen: str, prices: dict[str, float], limits: Limits) -> str:
    saved = prices[EXPLICIT] / prices[chosen]
    return f"explicit steps are limited to {1e6 * limits.at_impact:.2g} us: about {saved:.2g} times the CPU time"


def _cost(case: Case) -> Cost:
    """Return the cost of a case, its method named, at its own step or the automatic one."""
    return cost(case, automatic_step(case, step_limits(case)) if case.step == "auto" else case.step)


RECORDED_PER_CROSSING, RECORDED_PER_PERIOD = 25, 4
"""Recorded instants of an adaptive method over a defect, and in a period of contacts that ring."""


def automatic_step(case: Case, limits: Limits) -> float:
    """Return the step (s) measured to keep the defect's line within about 1 % (docs/steps.md).

    For an adaptive method, which controls its own error, the time between recorded instants.
    """
    model, method = assemble.kind(case), assemble.method_kind(case)
    if assemble.adaptive(case):
        rings = 1.0 / limits.contact_frequency / RECORDED_PER_PERIOD if limits.damping_ratio < 1.0 else inf
        return min(limits.crossing / RECORDED_PER_CROSSING, rings, LONGEST)
    seen = min(limits.crossing / model.per_crossing, LONGEST)
    if MODELS[case.model].memoryless:
        return seen
    return min(seen, method.fraction * limits.at_impact, 1.0 / limits.contact_frequency / method.per_period)
