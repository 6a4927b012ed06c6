"""Simulation of a case by one attempt after another, until a result passes its checks."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import inf
from typing import TypeVar

from bearingsim import extensions
from bearingsim.config import Case
from bearingsim.errors import Refused
from bearingsim.simulation import choice, recording, step_check, trial
from bearingsim.simulation.integration import Run, integrate
from bearingsim.simulation.record import Record, Usage, make_record
from bearingsim.simulation.recording import RawRecord
from bearingsim.simulation.refinement import refine_periodic, refine_step
from bearingsim.simulation.repetition import may_repeat, searches_for_period
from bearingsim.simulation.run_setup import MethodFailure, SimulationError, StepRefused, TooCostly, TooSlow, set_up
from bearingsim.simulation.step_check import StepCheck
from bearingsim.simulation.sufficiency import Inspections
from bearingsim.simulation.trial import ReferenceValues, Trial

T = TypeVar("T")

__all__ = ["Record", "SimulationError", "simulate", "try_out"]


def simulate(case: Case) -> Record:
    """Compute one case. Raises ``SimulationError`` if the run is refused or stopped.

    An automatic step is an estimate, so it is checked (``step_check``), and the run is monitored throughout. If it
    fails, shorter steps are tried, and then (with `method: auto`) other methods.
    """
    start = Usage.now()
    return _first_sound_attempt(case, lambda attempt: _simulate(attempt, start))


def try_out(
    case: Case,
    requested: Sequence[str],
    passes: int,
    turn: float = 0.0,
    reference_values: ReferenceValues | None = None,
) -> tuple[Trial, Record | None]:
    """Return the first ball passes of a case, to compare its model with others (``trial.py``).

    requested: features; passes: number of ball passes compared; turn: period (s) of the slowest defect, of this
    case or of the faulty one whose healthy counterpart it is, into which the passes are divided (0 if no defect
    turns). The whole record is returned as well if the trial completes it (periodic, or `until` reached), unless
    `step_check` is strict or false. Raises like ``simulate``.
    """
    start = Usage.now()
    return _first_sound_attempt(
        case, lambda attempt: _try_out(attempt, requested, passes, turn, start, reference_values)
    )


def _first_sound_attempt(case: Case, compute: Callable[[choice.Attempt], T]) -> T:
    """Make the attempts at a case, always the cheapest next; return the first result that passes its checks."""
    extensions.raise_if_broken()
    failures: dict[str, SimulationError] = {}
    queue = _attempts(case)
    while queue:
        queue.sort(key=lambda attempt: attempt.price)
        attempt = queue.pop(0)
        try:
            return compute(attempt._replace(limit=queue[0].price + choice.MIN_SAVING if queue else inf))
        except TooCostly as error:
            regular = attempt.regular or error.regular
            queue.append(attempt.repriced(error.step_fraction, error.periodic))
            queue = [other._replace(regular=regular) for other in queue]
        except MethodFailure as error:
            failures[str(attempt.case.method)] = error.with_traceback(None)  # its frames refer to the whole record
            if isinstance(error, StepRefused) and attempt.regular:  # unless it is chaotic after all
                queue.append(attempt._replace(regular=False))
            elif not isinstance(error, TooSlow | StepRefused) and (shorter := attempt.shorter()) is not None:
                queue.append(shorter)
        except Refused as error:  # too many steps; an earlier failure of longer steps is more informative
            failures.setdefault(str(attempt.case.method), SimulationError(error.reason, error.advice))
    raise _combined_error(list(failures.values()))


def _attempts(case: Case) -> list[choice.Attempt]:
    try:
        return choice.attempts(case)
    except Refused as error:
        raise SimulationError(error.reason, error.advice) from error


def _combined_error(errors: list[SimulationError]) -> SimulationError:
    """Combine the errors of all attempted methods: all reasons, with the advice and time of the first."""
    reasons = list(dict.fromkeys(error.reason for error in errors))
    main_error = errors[0]
    advice = (
        main_error.method_advice
        if isinstance(main_error, MethodFailure) and len(errors) > 1
        else main_error.advice
    )
    return SimulationError("; ".join(reasons), advice, main_error.time)


def _simulate(attempt: choice.Attempt, start: Usage) -> Record:
    """Compute a case by one attempt."""
    case = attempt.case
    if case.checks_step and choice.has_automatic_step(case):
        setup, refined_raw, check, begun = refine_step(attempt)
        inspections = Inspections(setup)
        raw = integrate(setup, inspector=inspections, begun=begun) if refined_raw is None else refined_raw
    else:
        inspections, raw, check = _unrefined(attempt)
    if case.step_check == "strict":
        step_check.refuse_short_record(inspections.setup, check)
    return make_record(inspections, raw, check, start)


def _unrefined(attempt: choice.Attempt) -> tuple[Inspections, RawRecord, StepCheck]:
    """Compute a case at its own step, or at an unchecked automatic step."""
    case = attempt.case
    setup = set_up(case, attempt.step_fraction)
    inspections = Inspections(setup)
    if not searches_for_period(setup.case):
        check = step_check.verify_step(inspections.shortest_setup)
        return inspections, integrate(setup, inspector=inspections), check
    until_periodic = replace(setup, case=setup.case.model_copy(update={"periodic": True}))
    raw = integrate(until_periodic, patience=attempt.patience, inspector=inspections)
    check = step_check.verify_step(
        until_periodic if raw.repetition.period > 0 else inspections.shortest_setup, raw
    )
    if not case.periodic and raw.repetition.period > 0:
        del raw  # frees its memory before the full run
        raw = integrate(setup, inspector=inspections)  # at the step checked on a period
    return inspections, raw, check


def _try_out(
    attempt: choice.Attempt,
    requested: Sequence[str],
    passes: int,
    turn: float,
    start: Usage,
    reference_values: ReferenceValues | None,
) -> tuple[Trial, Record | None]:
    """Compute the first passes of a case by one attempt, and its record if the passes complete it."""
    case = attempt.case
    needs_record = case.step_check not in ("strict", False)
    setup, refined_raw, check, begun = set_up(case, attempt.step_fraction), None, None, None
    may_end = reference_values is not None and trial.may_become_record(setup.case)
    if needs_record and case.checks_step and choice.has_automatic_step(case) and (may_end or may_repeat(case)):
        refinement = refine_step(attempt) if may_end else refine_periodic(attempt)
        if refinement is not None:
            setup, refined_raw, check, begun = refinement
    inspections = Inspections(setup)
    if refined_raw is not None and check is not None:
        return trial.read_trial(setup, refined_raw, requested, passes, turn), make_record(
            inspections, refined_raw, check, start
        )
    raw, passes = _trial_run(inspections, requested, passes, turn, reference_values, may_end, begun)
    result = trial.read_trial(setup, raw, requested, passes, turn)
    if not (needs_record and inspections.complete_record(raw, may_end)):
        return result, None
    if check is None:
        check = step_check.verify_step(setup if result.repeats else inspections.shortest_setup, raw)
    return result, make_record(inspections, raw, check, start)


def _trial_run(
    inspections: Inspections,
    requested: Sequence[str],
    passes: int,
    turn: float,
    reference_values: ReferenceValues | None,
    may_end: bool,
    begun: Run | None,
) -> tuple[RawRecord, int]:
    """Return the run of a trial, and the number of its ball passes that are compared, at most ``passes``."""
    setup = inspections.setup
    if may_end and reference_values is not None:
        inspection = trial.record_inspection(setup, inspections, requested, passes, turn, reference_values)
        raw = integrate(setup, inspector=inspection, begun=begun)
        record_setup = inspections.setup_of_record(raw)
        return raw, min(passes, recording.whole_passes(record_setup.case, record_setup.grid))
    short_passes = min(passes, trial.most_passes(setup.case))
    early_end = (
        None if reference_values is None else trial.early_inspection(setup, requested, turn, reference_values)
    )
    raw = integrate(setup, max_passes=trial.last_pass(setup, short_passes), inspector=early_end)
    if early_end is not None and raw.repetition.computed in early_end.passes:
        return raw, trial.INSPECTION_TURNS * raw.Z
    return raw, passes if raw.repetition.period > 0 else short_passes
