"""Choice of a case's method and automatic step, and attempts at its computation.

The method is the cheapest, by its step limit and its cost per step, at the step where the error of the defect's
amplitude is about 1 %. Only methods of fixed step can end a run at its first period, so velocity Verlet is usually
the cheapest for a response that may be periodic. The cost of an attempt increases if its step is refused, or if no
ball pass repeats another. The next attempt is always the cheapest.
"""

from functools import lru_cache
from math import inf
from typing import NamedTuple

from bearingsim import assemble
from bearingsim.assemble.registered import check_features, missing_functions
from bearingsim.catalogue import AUTO, EXPLICIT, METHODS, MODELS
from bearingsim.config import Case
from bearingsim.errors import Refused
from bearingsim.simulation.limits import LONGEST_STEP, Limits, longest_step, step_limits
from bearingsim.simulation.pricing import Cost, coefficient, estimate_cost
from bearingsim.simulation.repetition import may_repeat
from bearingsim.simulation.settling import has_free_cage, refuse_unsettled, resolve_settling

STEP_FRACTIONS = (1.0, 0.5, 0.25, 0.125)
"""Fractions of the automatic step, tried in this order; an adaptive method has a tenth of the tolerance
at half of it."""
ADAPTIVE_MARGIN, IMPLICIT_MARGIN = 1.2, 2.0
"""Safety factors on the estimated cost of explicit adaptive methods, with steps limited by stability, and of
implicit methods, with steps limited by accuracy."""
MIN_SAVING = 0.2
"""CPU time (s) that another method must save over a shorter step, for its own setup and pilots. Chosen on 400
random scenes, tested on 200 others (docs/evidence/speed.md)."""


class Choice(NamedTuple):
    """Method of a case, and the reason for it in words.

    costs: estimated CPU time (s) by suitable method, sorted by this time multiplied by ``cost_margin``.
    """

    method: str | None
    reason: str
    costs: dict[str, float]


class Attempt(NamedTuple):
    """Case with a named method, and the fraction of the automatic step (or tolerance) to use.

    cost: estimated CPU time (s), multiplied by ``cost_margin``; limit: cost above which this attempt is stopped
    and the next one made first; periodic: whether the response may still be periodic; regular: whether an attempt
    has shown that the motion is not chaotic.
    """

    case: Case
    step_fraction: float
    cost: float = 0.0
    limit: float = inf
    periodic: bool = True
    regular: bool = False

    @property
    def max_search_passes(self) -> int:
        """Ball passes after which a run without a period is stopped as too costly; 0 for never."""
        case = self.case
        if self.limit == inf or not (self.periodic and case.until is None and may_repeat(case)):
            return 0
        search_passes, estimate = int(coefficient("patience")), _method_cost(case)
        remaining_cost = estimate.non_periodic - search_passes * estimate.one_pass
        return (
            search_passes
            if self.limit < cost_margin(str(case.method)) * remaining_cost / self.step_fraction
            else 0
        )

    def at_step(self, step_fraction: float, periodic: bool) -> "Attempt":
        """Return the attempt at a fraction of the automatic step, with its cost.

        With `until` a response that is not periodic has the cost of one that is, since its length is unknown.
        periodic: whether the response may still be periodic.
        """
        cost_at_step = _method_cost(self.case.model_copy(update={"periodic": True}))
        is_short = periodic or self.case.until is not None
        seconds = cost_at_step.total if is_short else cost_at_step.non_periodic
        cost = cost_margin(str(self.case.method)) * seconds / step_fraction
        return self._replace(step_fraction=step_fraction, cost=cost, periodic=periodic)

    def shorter(self) -> "Attempt | None":
        """Return the attempt with the next shorter step, and its cost; None if there is no shorter step."""
        fractions = STEP_FRACTIONS if has_automatic_step(self.case) else (1.0,)
        shorter = next((fraction for fraction in fractions if fraction < self.step_fraction), None)
        if shorter is None:
            return None
        return self._replace(step_fraction=shorter, cost=self.cost * self.step_fraction / shorter)


def resolve(case: Case) -> Case:
    """Return the case with the chosen method and time in place of `method: auto` and `settle: auto`."""
    method = choose_method(case).method
    return resolve_settling(case if method == case.method else with_method(case, method))


def limits(case: Case) -> Limits:
    """Return the step limits of a case, for its own or the chosen method."""
    return step_limits(resolve(case))


def with_method(case: Case, method: str | None) -> Case:
    """Return the case with the given method."""
    return case.model_copy(update={"method": method})


def attempts(case: Case) -> list[Attempt]:
    """List an attempt by each method for a case. Raises ``Refused`` if the step check is strict and the run would
    not settle.
    """
    preferred = resolve(case)
    refuse_unsettled(preferred)
    costs = {name: cost_margin(name) * seconds for name, seconds in choose_method(case).costs.items()}
    return [
        Attempt(with_method(preferred, name), 1.0, costs.get(str(name), 0.0)) for name in candidate_methods(case)
    ]


def has_automatic_step(case: Case) -> bool:
    """Check if the program chooses the step of a case and may shorten it (or tighten its tolerance)."""
    return case.automatic and case.tolerance == "auto"


def candidate_methods(case: Case) -> list[str | None]:
    """List the methods for a case, each used if the previous ones fail; only its own method if it is refused."""
    try:
        preferred = choose_method(case).method
    except Refused:
        return [case.method]
    others = alternatives(with_method(case, preferred)) if case.method == AUTO and case.automatic else []
    return [preferred, *others]


def alternatives(case: Case) -> list[str]:
    """List the other automatic methods that can integrate the case, cheapest first; empty without a method."""
    if case.method is None:
        return []
    try:
        costs = choose_method(with_method(case, AUTO)).costs
    except Refused:  # no automatic method with a tolerance suits the case
        return []
    return [name for name in costs if name != case.method]


@lru_cache(maxsize=1 << 17)
def choose_method(case: Case) -> Choice:
    """Choose the cheapest method with about 1 % error of the defect's amplitude. Raises ``Refused`` like
    ``limits``.

    A case with `periodic: false` gets the same method as with `periodic: true`, to make the results comparable.
    """
    _refuse_missing_functions(case)
    if case.method != AUTO:
        return Choice(case.method, "given by the case" if case.method else f"{case.model} has no method", {})
    suitable = [name for name in METHODS if METHODS[name].automatic and is_suitable(case, name)]
    if case.tolerance != "auto":  # only methods with a tolerance
        suitable = [name for name in suitable if METHODS[name].adaptive]
        if not suitable:
            raise Refused(
                "no automatic method with a `tolerance` can integrate this case",
                "omit `tolerance`, or name a `method`",
            )
    # if no method accepts the step of the case, it is refused later
    suitable = [name for name in suitable if _accepts_step(case, name)] or suitable
    periodic = resolve_settling(case).model_copy(update={"periodic": True})
    cost_of = {name: _method_cost(with_method(periodic, name)) for name in suitable}
    by_cost = sorted(suitable, key=lambda name: cost_margin(name) * cost_of[name].total)
    costs = {name: cost_of[name].total for name in by_cost}
    if EXPLICIT not in costs:
        reason = "with a tolerance" if case.tolerance != "auto" else "whose limit the step does not exceed"
        return Choice(by_cost[0], f"the cheapest method {reason}", costs)
    if by_cost[0] != EXPLICIT:
        return Choice(
            by_cost[0], _speedup_text(by_cost[0], costs, step_limits(with_method(case, EXPLICIT))), costs
        )
    if not may_repeat(with_method(periodic, EXPLICIT)):
        return Choice(EXPLICIT, "no other method needs much less CPU time", costs)
    return Choice(EXPLICIT, "the response may be periodic", costs)


def cost_margin(name: str) -> float:
    """Return the safety factor on a method's estimated cost."""
    return IMPLICIT_MARGIN if METHODS[name].implicit else ADAPTIVE_MARGIN if METHODS[name].adaptive else 1.0


def is_suitable(case: Case, name: str) -> bool:
    """Check if a method suits the model of a case.

    An implicit method needs the derivatives of the model. An explicit adaptive method is excluded with a free
    cage, because the stiff friction of cage and rollers would limit its steps; methods of fixed step apply it with
    a lag.
    """
    if METHODS[name].implicit:
        if case.surfaces is not None and MODELS[case.model].slips:
            return False
        return case.rig.ring is None and not any(missing_functions(case, implicit=True))
    return not METHODS[name].adaptive or not has_free_cage(case)


def _accepts_step(case: Case, name: str) -> bool:
    """Check if a method accepts the step of a case; all accept an automatic step."""
    return case.step == "auto" or case.step <= longest_step(step_limits(with_method(case, name)))


def _refuse_missing_functions(case: Case) -> None:
    """Raise ``Refused`` if laws or model lack a function that the method calls; UserError for invalid features."""
    check_features()
    implicit = case.method not in (None, AUTO) and METHODS[str(case.method)].implicit
    problem = next(missing_functions(case, implicit), "")
    if problem:
        purpose = f", which {case.method} needs" if implicit else ""
        advice = "use an explicit method, or register it" if implicit else "register it (docs/extending.md)"
        raise Refused(problem + purpose, advice)


def _speedup_text(chosen: str, costs: dict[str, float], limits: Limits) -> str:
    speedup = costs[EXPLICIT] / costs[chosen]
    return f"explicit steps are limited to {1e6 * limits.at_impact:.2g} us: about {speedup:.2g} times the CPU time"


def _method_cost(case: Case) -> Cost:
    """Return the cost of a case with a named method, at its own step or the automatic one."""
    return estimate_cost(case, automatic_step(case, step_limits(case)) if case.step == "auto" else case.step)


RECORDED_PER_CROSSING, RECORDED_PER_PERIOD = 25, 4
"""Recorded instants of an adaptive method per defect crossing, and per period of the contacts' vibration."""
STEPS_PER_UNDULATION = 40
"""Automatic steps per undulation of a surface: Verlet's error of an acceleration is (2 pi/40)^2/12 = 0.2 %."""


def automatic_step(case: Case, limits: Limits) -> float:
    """Return the step (s) at which the defect's amplitude is accurate to about 1 % (measured, docs/steps.md).

    For an adaptive method, which controls its own error, this is the interval between recorded instants.
    """
    model, method, undulation_step = (
        assemble.model_kind(case),
        assemble.method_kind(case),
        limits.wave / STEPS_PER_UNDULATION,
    )
    if assemble.is_adaptive(case):
        vibration_step = (
            1.0 / limits.contact_frequency / RECORDED_PER_PERIOD if limits.damping_ratio < 1.0 else inf
        )
        return min(limits.crossing / RECORDED_PER_CROSSING, vibration_step, undulation_step, LONGEST_STEP)
    crossing_step = min(limits.crossing / model.per_crossing, undulation_step, LONGEST_STEP)
    if MODELS[case.model].memoryless:
        return crossing_step
    return min(
        crossing_step, method.fraction * limits.at_impact, 1.0 / limits.contact_frequency / method.per_period
    )
