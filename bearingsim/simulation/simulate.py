"""Simulation of a case by successive attempts, until a result passes its checks."""

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

__all__ = ["Record", "SimulationError", "run_trial", "simulate"]


def simulate(case: Case) -> Record:
    """Compute a case. Raises ``SimulationError`` if the run is refused or stopped.

    An automatic step is an estimate, so it is checked (``step_check``), and the run is monitored throughout. If it
    fails, shorter steps are tried and, with `method: auto`, other methods, the cheapest next.
    """
    start = Usage.now()
    return _first_valid_result(case, lambda attempt: _attempt_simulation(attempt, start))


def run_trial(
    case: Case,
    requested: Sequence[str],
    passes: int,
    revolution_time: float = 0.0,
    reference_values: ReferenceValues | None = None,
) -> tuple[Trial, Record | None]:
    """Compute the first ball passes of a case, to compare its model with others (``trial.py``).

    requested: features; passes: number of ball passes compared; revolution_time: period (s) of the slowest defect,
    of this case or of the faulty one whose healthy counterpart it is, into which the passes are divided (0 if no
    defect rotates); reference_values: values from which the trial may differ so far that it ends early. The whole
    record is returned as well if the trial completes it (periodic, or `until` reached), unless `step_check` is
    strict or false. Raises like ``simulate``.
    """
    start = Usage.now()
    return _first_valid_result(
        case, lambda attempt: _attempt_trial(attempt, requested, passes, revolution_time, start, reference_values)
    )


def _first_valid_result(case: Case, compute: Callable[[choice.Attempt], T]) -> T:
    """Make the attempts at a case, the cheapest next; return the first result that passes its checks.

    compute: function of an attempt. Raises ``SimulationError`` with all reasons if every attempt fails.
    """
    extensions.raise_if_broken()
    failures: dict[str, SimulationError] = {}
    queue = _list_attempts(case)
    while queue:
        queue.sort(key=lambda attempt: attempt.cost)
        attempt = queue.pop(0)
        try:
            return compute(attempt._replace(limit=queue[0].cost + choice.MIN_SAVING if queue else inf))
        except TooCostly as error:
            regular = attempt.regular or error.regular
            queue.append(attempt.at_step(error.step_fraction, error.periodic))
            queue = [other._replace(regular=regular) for other in queue]
        except MethodFailure as error:
            # the frames of a traceback would keep the whole record in memory
            failures[str(attempt.case.method)] = error.with_traceback(None)
            if isinstance(error, StepRefused) and attempt.regular:  # the motion may be chaotic after all
                queue.append(attempt._replace(regular=False))
            elif not isinstance(error, TooSlow | StepRefused) and (shorter := attempt.shorter()) is not None:
                queue.append(shorter)
        except Refused as error:  # too many steps; a failure at longer steps is more informative
            failures.setdefault(str(attempt.case.method), SimulationError(error.reason, error.advice))
    raise _combined_error(list(failures.values()))


def _list_attempts(case: Case) -> list[choice.Attempt]:
    """List the attempts at a case. Raises ``SimulationError`` if the case is refused."""
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


def _attempt_simulation(attempt: choice.Attempt, start: Usage) -> Record:
    """Compute the record of a case by one attempt."""
    case = attempt.case
    if case.checks_step and choice.has_automatic_step(case):
        setup, refined_record, check, partial_run = refine_step(attempt)
        inspections = Inspections(setup)
        raw = (
            integrate(setup, inspector=inspections, partial_run=partial_run)
            if refined_record is None
            else refined_record
        )
    else:
        inspections, raw, check = _run_unrefined(attempt)
    if case.step_check == "strict":
        step_check.refuse_short_record(inspections.setup, check)
    return make_record(inspections, raw, check, start)


def _run_unrefined(attempt: choice.Attempt) -> tuple[Inspections, RawRecord, StepCheck]:
    """Compute a case at its own step, or at an unchecked automatic step."""
    case = attempt.case
    setup = set_up(case, attempt.step_fraction)
    inspections = Inspections(setup)
    if not searches_for_period(setup.case):
        check = step_check.verify_step(inspections.shortest_setup)
        return inspections, integrate(setup, inspector=inspections), check
    periodic_setup = replace(setup, case=setup.case.model_copy(update={"periodic": True}))
    raw = integrate(periodic_setup, max_search_passes=attempt.max_search_passes, inspector=inspections)
    check = step_check.verify_step(
        periodic_setup if raw.repetition.period > 0 else inspections.shortest_setup, raw
    )
    if not case.periodic and raw.repetition.period > 0:
        del raw  # frees its memory before the full run
        raw = integrate(setup, inspector=inspections)  # at the step checked on a period
    return inspections, raw, check


def _attempt_trial(
    attempt: choice.Attempt,
    requested: Sequence[str],
    passes: int,
    revolution_time: float,
    start: Usage,
    reference_values: ReferenceValues | None,
) -> tuple[Trial, Record | None]:
    """Compute the trial of a case by one attempt, and its record if the trial completes it."""
    case = attempt.case
    needs_record = case.step_check not in ("strict", False)
    setup, refined_record, check, partial_run = set_up(case, attempt.step_fraction), None, None, None
    may_end = reference_values is not None and trial.may_become_record(setup.case)
    if needs_record and case.checks_step and choice.has_automatic_step(case) and (may_end or may_repeat(case)):
        refinement = refine_step(attempt) if may_end else refine_periodic(attempt)
        if refinement is not None:
            setup, refined_record, check, partial_run = refinement
    inspections = Inspections(setup)
    if refined_record is not None and check is not None:
        return trial.read_trial(setup, refined_record, requested, passes, revolution_time), make_record(
            inspections, refined_record, check, start
        )
    raw, passes = _trial_run(
        inspections, requested, passes, revolution_time, reference_values, may_end, partial_run
    )
    result = trial.read_trial(setup, raw, requested, passes, revolution_time)
    if not (needs_record and inspections.complete_record(raw, may_end)):
        return result, None
    if check is None:
        check = step_check.verify_step(setup if result.is_periodic else inspections.shortest_setup, raw)
    return result, make_record(inspections, raw, check, start)


def _trial_run(
    inspections: Inspections,
    requested: Sequence[str],
    passes: int,
    revolution_time: float,
    reference_values: ReferenceValues | None,
    may_end: bool,
    partial_run: Run | None,
) -> tuple[RawRecord, int]:
    """Return the run of a trial, and the number of its ball passes that are compared, at most ``passes``."""
    setup = inspections.setup
    if may_end and reference_values is not None:
        inspection = trial.record_inspection(
            setup, inspections, requested, passes, revolution_time, reference_values
        )
        raw = integrate(setup, inspector=inspection, partial_run=partial_run)
        record_setup = inspections.setup_of_record(raw)
        return raw, min(passes, recording.whole_passes(record_setup.case, record_setup.grid))
    short_passes = min(passes, trial.max_trial_passes(setup.case))
    early_end = (
        None
        if reference_values is None
        else trial.early_inspection(setup, requested, revolution_time, reference_values)
    )
    raw = integrate(setup, max_passes=trial.last_pass(setup, short_passes), inspector=early_end)
    if early_end is not None and raw.repetition.computed in early_end.passes:
        return raw, trial.INSPECTION_REVOLUTIONS * raw.Z
    return raw, passes if raw.repetition.period > 0 else short_passes
