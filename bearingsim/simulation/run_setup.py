"""Setup of a run: a case ready for integration, its monitor, and the failures that stop it, with advice."""

from dataclasses import dataclass
from math import nan
from typing import Any

from bearingsim import assemble
from bearingsim.catalogue import MODELS, simplest_model
from bearingsim.config import Case
from bearingsim.config.rules import hierarchy
from bearingsim.core import outcomes
from bearingsim.core.advance import Monitor
from bearingsim.core.models.interface import monitored_bodies
from bearingsim.simulation import choice, time_grid
from bearingsim.simulation.limits import APPROACH_MARGIN, ENERGY_MARGIN, Limits
from bearingsim.simulation.rounding import NO_ROUNDING, Rounding
from bearingsim.simulation.rounding_bounds import rounding_of
from bearingsim.simulation.settling import resolve_settling


class SimulationError(Exception):
    """Failure of a run, with its reason, advice, and time (s into the run, None before its start)."""

    def __init__(self, reason: str, advice: str, time: float | None = None) -> None:
        super().__init__(f"{reason}; {advice}")
        self.reason, self.advice, self.time = reason, advice, time

    def __reduce__(self) -> tuple:
        return SimulationError, (self.reason, self.advice, self.time)


class MethodFailure(SimulationError):
    """Failure of a method or its step; another one may succeed.

    alternative: text on another method, appended to the advice; method_advice: advice without this text.
    """

    def __init__(self, reason: str, advice: str, time: float | None = None, alternative: str = "") -> None:
        super().__init__(reason, advice + alternative, time)
        self.method_advice = advice


class StepRefused(MethodFailure):
    """Refusal of a method whose shortest step is not accurate enough."""


class TooSlow(MethodFailure):
    """Failure due to excessive CPU time, which a shorter step would increase."""


class TooCostly(MethodFailure):
    """End of an attempt whose cost exceeds that of the next one.

    step_fraction: fraction of the automatic step at which it would be continued; periodic: whether the response
    may still be periodic; regular: whether the motion is known not to be chaotic.
    """

    def __init__(self, reason: str, step_fraction: float, periodic: bool, regular: bool) -> None:
        super().__init__(reason, "name a `method`")
        self.step_fraction, self.periodic, self.regular = step_fraction, periodic, regular


class TooChaotic(SimulationError):
    """Refusal of a chaotic record that is too short for an RMS within 1 %; duration: advised duration (s)."""

    def __init__(self, reason: str, advice: str, duration: float = nan) -> None:
        super().__init__(reason, advice)
        self.duration = duration


@dataclass(frozen=True)
class Setup:
    """Case ready for integration: named method, time grid, parameters of the core and step limits.

    step_fraction: ratio to the case's own step or the automatic step; max_cpu: CPU time (s) allowed for the steps,
    if they are automatic; rounding: bounds of the motion of rings due to rounding.
    """

    case: Case
    step_fraction: float
    grid: time_grid.Grid
    limits: Limits
    model: Any
    method: Any
    monitor: Monitor
    max_cpu: float
    rounding: Rounding = NO_ROUNDING


def set_up(case: Case, step_fraction: float = 1.0, max_cpu: float | None = None) -> Setup:
    """Prepare a case with a named method; max_cpu: allowed CPU time (s). Raises ``Refused``."""
    case = resolve_settling(case)
    grid, limits = time_grid.make_grid(case, step_fraction, max_cpu or 0.0), choice.limits(case)
    time_grid.refuse_too_large(case, grid)
    kind = assemble.method_kind(case)
    lag = kind.lag * grid.step
    model = assemble.with_friction_lag(assemble.model(case), lag)
    if not assemble.is_adaptive(case):
        model = assemble.align_with_cusp(model, grid.steps_per_pass, kind.cusp)
    return Setup(
        case,
        step_fraction,
        grid,
        limits,
        model,
        assemble.method(case, grid.step, step_fraction),
        make_monitor(grid, limits),
        max_cpu or time_grid.MAX_CPU,
        rounding_of(case, model, grid.step, grid.rate),
    )


MAX_EVALUATIONS = 2e4  # model evaluations of an adaptive method after which it returns early to read the clock


def make_monitor(grid: time_grid.Grid, limits: Limits) -> Monitor:
    """Make a monitor that checks the motion at least every quarter of a contact period and defect crossing."""
    overrun_limit = 0.5 / limits.contact_frequency if limits.contact_frequency > 0.0 else 1.0
    stride = int(min(overrun_limit, limits.crossing / 2.0) / (2.0 * grid.step))
    return Monitor(
        min(32, max(1, stride)), overrun_limit, limits.approach_bound, limits.energy_bound, MAX_EVALUATIONS
    )


STOP_REASONS = {
    outcomes.STEP_LIMIT_EXCEEDED: "{body} exceeded the step limit for longer than an impact lasts",
    outcomes.NOT_FINITE: "the motion of the ring diverged (not finite)",
    outcomes.TOO_DEEP: "contact deformation of {body} exceeds {approach_bound:.3g} um, {APPROACH_MARGIN:.0f} times"
    " what load, closing speed and defects explain",
    outcomes.TOO_MUCH_ENERGY: "kinetic energy exceeds {energy_bound:.3g} J, {ENERGY_MARGIN:.0f} times"
    " what load, closing speed and defects explain",
    outcomes.STEP_TOO_SMALL: "the step of {method} became too short",
    outcomes.NEWTON_FAILED: "the Newton iteration of {method} did not converge for {body}",
    outcomes.TOO_MANY_STEPS: "{method} takes too many steps between two samples",
    outcomes.CROSSINGS_MISSED: "steps are too long for {count} crossings of defects",
    outcomes.TOO_SLOW: "{method} used {hours:.2g} h of CPU time",
}
"""Reasons why a run was stopped, by its outcome."""


def run_failure(setup: Setup, outcome: int, body: int, t: float) -> MethodFailure:
    """Make the failure of a run stopped at ``t`` (s), with advice; body: its number, or that of crossings."""
    reason = STOP_REASONS[outcome].format(
        body=body_name(setup.model, body),
        count=body,
        method=setup.case.method,
        approach_bound=1e6 * setup.monitor.approach_bound,
        energy_bound=setup.monitor.energy_bound,
        hours=setup.max_cpu / 3600.0,
        APPROACH_MARGIN=APPROACH_MARGIN,
        ENERGY_MARGIN=ENERGY_MARGIN,
    )
    failure_type = TooSlow if outcome == outcomes.TOO_SLOW else MethodFailure
    methods = choice.alternatives(setup.case)
    alternative = f", or `method: {methods[0]}`" if methods and not needs_roller_mass(setup, outcome) else ""
    return failure_type(f"{reason}, {1e3 * t:.4g} ms into the run", advise(setup, outcome), t, alternative)


def needs_roller_mass(setup: Setup, outcome: int) -> bool:
    """Check if a method fails because the damping force of a massless roller jumps."""
    has_stalled = outcome in (outcomes.STEP_TOO_SMALL, outcomes.NEWTON_FAILED, outcomes.TOO_MANY_STEPS)
    return has_stalled and not MODELS[setup.case.model].has_inertia and setup.case.contact.jumps


def advise(setup: Setup, outcome: int) -> str:
    """Return advice on a step, tolerance, model or duration with which the run may succeed."""
    adaptive = assemble.is_adaptive(setup.case)
    if outcome == outcomes.TOO_SLOW:
        return "use a shorter `duration`" + ("" if adaptive else ", or set `step`")
    if needs_roller_mass(setup, outcome):
        return f"use `model: {simplest_model('roller inertia')}`: {hierarchy.NEEDS_ROLLER_MASS}"
    if not adaptive:
        return f"use a step under {1e6 * setup.grid.step / 2:.2g} us"
    too_tight = outcome in (outcomes.STEP_TOO_SMALL, outcomes.TOO_MANY_STEPS)
    return f"use a {'looser' if too_tight else 'tighter'} `tolerance` than {setup.method.rtol:.2g}"


def body_name(model: Any, body: int) -> str:
    """Return the name of a monitored body."""
    return f"roller {body + 1}" if monitored_bodies(model) > 1 and body >= 0 else "the ring"


def nested_types(value: Any) -> Any:
    """Return the nested types of parameters, which determine the compiled code; exponents of laws may be types."""
    return (type(value), *map(nested_types, value)) if isinstance(value, tuple) else type(value)
