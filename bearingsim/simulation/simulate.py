"""Simulation of a case, from integration to time series and features."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import floor, inf, isnan, nan, sqrt
from typing import NamedTuple, TypeVar

import numpy as np

from bearingsim import assemble, cpu_time, extensions
from bearingsim.catalogue import MODELS
from bearingsim.config import Case, dataset_names
from bearingsim.config.names import NO_VALUE, STEP_ACCURACY
from bearingsim.core import layout as lay
from bearingsim.core.geometry.motion import kinematic_times
from bearingsim.errors import Refused
from bearingsim.simulation import accuracy, channels, choice, recording, step_check, time_grid, trial
from bearingsim.simulation.accuracy import StandardErrors
from bearingsim.simulation.channels import CAGE_ANGLE, FEATURE_CELLS
from bearingsim.simulation.comparison import fault_lines
from bearingsim.simulation.features import band_features, extension_features, features, refuse_undeclared
from bearingsim.simulation.integration import Run, StepUsage, integrate, step_usage
from bearingsim.simulation.recording import RawRecord
from bearingsim.simulation.refinement import refine_periodic, refine_step
from bearingsim.simulation.repetition import may_be_periodic, may_repeat, searches_for_period
from bearingsim.simulation.run_setup import (
    MethodFailure,
    Setup,
    SimulationError,
    StepRefused,
    TooCostly,
    TooSlow,
    set_up,
)
from bearingsim.simulation.settling import has_free_cage
from bearingsim.simulation.spectral_lines import lines_of_passes, reason_unresolved
from bearingsim.simulation.start_error import StartErrors, start_errors
from bearingsim.simulation.step_check import StepCheck
from bearingsim.simulation.sufficiency import Inspections
from bearingsim.simulation.trial import ReferenceValues, Trial

T = TypeVar("T")

__all__ = ["Record", "SimulationError", "simulate", "try_out"]


@dataclass(frozen=True)
class Record:
    """Record of a simulation, in SI.

    time: (n,) s from the start of the record (after settling); series: (n,) arrays by dataset name
    (``ring.velocity.x``); features: numbers by name (``velocity@BPFO``); info: facts on the computation (step,
    number of steps, CPU seconds, limits, cage angle at the start of the record).
    """

    time: np.ndarray
    series: dict[str, np.ndarray]
    features: dict[str, float]
    info: dict[str, float | int | str]

    @property
    def displacement(self) -> np.ndarray:
        """Displacement of the ring (n, 2), m: along and across the load line."""
        return self._pair("ring.displacement")

    @property
    def velocity(self) -> np.ndarray:
        """Velocity of the ring (n, 2), m/s: along and across the load line."""
        return self._pair("ring.velocity")

    @property
    def acceleration(self) -> np.ndarray:
        """Acceleration of the ring (n, 2), m/s^2: along and across the load line."""
        return self._pair("ring.acceleration")

    @property
    def error(self) -> dict[str, float]:
        """Standard error of the amplitude of each line, from its scatter between ball passes."""
        ending = "-scatter"
        return {k.removesuffix(ending): v for k, v in self.features.items() if k.endswith(ending)}

    def _pair(self, channel: str) -> np.ndarray:
        names = dataset_names(channel)
        if names[0] not in self.series:
            raise KeyError(f"{channel} was not recorded: add it to `record`")
        return np.stack([self.series[name] for name in names], axis=1)


class Usage(NamedTuple):
    """CPU time (s) and integrator steps of this process so far."""

    cpu_s: float
    step_usage: StepUsage

    @classmethod
    def now(cls) -> "Usage":
        """Return the current CPU time and number of steps."""
        return cls(cpu_time.now(), step_usage())


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
    return _record(inspections, raw, check, start)


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
        return trial.read_trial(setup, refined_raw, requested, passes, turn), _record(
            inspections, refined_raw, check, start
        )
    raw, passes = _trial_run(inspections, requested, passes, turn, reference_values, may_end, begun)
    result = trial.read_trial(setup, raw, requested, passes, turn)
    if not (needs_record and inspections.complete_record(raw, may_end)):
        return result, None
    if check is None:
        check = step_check.verify_step(setup if result.repeats else inspections.shortest_setup, raw)
    return result, _record(inspections, raw, check, start)


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


def _record(inspections: Inspections, raw: RawRecord, check: StepCheck, start: Usage) -> Record:
    """Return the record of a run."""
    full_setup, setup = inspections.setup, inspections.setup_of_record(raw)
    case = setup.case
    rows = channels.requested_rows(case, raw.cells)
    samples = recording.sample_rows(case, setup.grid, raw, rows)
    instants = np.arange(time_grid.samples(case)) / case.sampling
    series = channels.series(case, setup.model, samples, raw.cells[rows], case.settle_s + instants)
    pass_lines = lines_of_passes(case, setup.model, setup.grid, raw)
    values = features(case, setup.model, setup.grid, raw, pass_lines) | band_features(
        case, setup.model, setup.grid, raw
    )
    is_random = _is_random(setup, raw, check.chaotic)
    errors = no_errors = StandardErrors(nan, nan)
    if is_random or check.chaotic:
        errors = accuracy.standard_errors(case, setup.model, setup.grid, raw, pass_lines)
    values |= _check_features(
        check, _pass_ratio(inspections.shortest_setup, setup), errors if check.chaotic else no_errors
    )
    resolved = [line for line in fault_lines(case) if not isnan(values[f"velocity@{line}"])]
    values |= _start_features(start_errors(setup, raw, errors if is_random else no_errors, resolved))
    if case.step_check == "strict" and not (check.chaotic or has_free_cage(case) or case.ramp is not None):
        _refuse_start_error(case, [values["error.start"], values["error.start.rms"]])
    extension_values, reasons = extension_features(case, instants, series)
    unresolved = [line for line in fault_lines(case) if line not in resolved]
    reasons |= {f"{NO_VALUE}velocity@{line}": reason_unresolved(case, line) for line in unresolved}
    refuse_undeclared(values | extension_values)
    return Record(
        time=instants,
        series=series,
        features=values | extension_values,
        info=_info(full_setup, raw, inspections.record_errors(raw)) | reasons | _usage_info(start),
    )


def _usage_info(start: Usage) -> dict[str, float | int | str]:
    """Return the CPU time (s) of a job and the steps of all its runs, step check included."""
    now = Usage.now()
    return {
        "cpu_s": now.cpu_s - start.cpu_s,
        "steps_taken": now.step_usage.steps - start.step_usage.steps,
        "integrator_cpu_s": now.step_usage.cpu_s - start.step_usage.cpu_s,
    }


def _refuse_start_error(case: Case, errors: Sequence[float]) -> None:
    """Raise SimulationError if a strict check requires a smaller or a known error due to the initial transient."""
    if isnan(sum(errors)):
        raise SimulationError(
            "the record is too short to show whether the run has settled",
            "use a longer `duration`, or use `step_check: true`",
        )
    if max(errors) > STEP_ACCURACY:
        raise SimulationError(
            f"line or RMS is off by {max(errors):.1%}, because the record is short or has not settled after"
            f" {case.settle_s:.2g} s",
            "use a longer `duration` or `settle`, or use `step_check: true`",
        )


def _pass_ratio(checked: Setup, record: Setup) -> float:
    """Return the ratio of a record's ball passes to those of the shortest record, whose step was checked."""
    return recording.whole_passes(record.case, record.grid) / recording.whole_passes(checked.case, checked.grid)


def _check_features(check: StepCheck, pass_ratio: float, chaos_errors: StandardErrors) -> dict[str, float]:
    """Return a step check as features.

    pass_ratio: ratio of ball passes in the record to those of the record whose step was checked; chaos_errors:
    standard errors of a chaotic record, otherwise NaN.
    """
    return {
        "step_error.line": check.bound(check.line),
        "step_error.rms": check.bound(check.rms),
        "step_error.force": check.bound(check.force),
        "step_error.record": check.bound(check.record),
        "chaotic": nan if check is step_check.UNCHECKED else float(check.chaotic),
        "rms_scatter": nan if check is step_check.UNCHECKED else check.scatter / sqrt(pass_ratio),
        "standard_error.line": chaos_errors.line,
        "standard_error.rms": chaos_errors.rms,
    }


def _info(setup: Setup, raw: RawRecord, reached: StandardErrors) -> dict[str, float | int | str]:
    """Return facts on the computation of a run; record_errors: of a record with `until`, else NaN."""
    case, grid, y = setup.case, setup.grid, raw.y
    steps = raw.repetition.computed * grid.steps_per_pass
    adaptive = assemble.is_adaptive(case)
    return {
        "method": case.method or "",
        "step_s": grid.step,
        "step_part": setup.step_fraction,
        "settle_s": case.settle_s,
        "passes": grid.passes,
        "passes_computed": raw.repetition.computed,
        "period_passes": raw.repetition.period,
        "last_difference": raw.repetition.difference,
        "standard_error_line": reached.line,
        "standard_error_rms": reached.rms,
        "steps": steps,
        "tolerance": float(setup.method.rtol) if adaptive else float("nan"),
        "own_steps": int(y[lay.STEPS_TAKEN]) if adaptive else steps,
        "own_steps_refused": int(y[lay.STEPS_REJECTED]),
        "newton_iterations": int(y[lay.NEWTON_ITERATIONS]),
        **_damping(setup),
        "step_limit_at_rest_s": setup.limits.at_rest,
        "step_limit_at_impact_s": setup.limits.at_impact,
        "longest_overrun_s": float(y[lay.OVERRUN_MAX : lay.OVERRUN_MAX + setup.model.bearing.Z].max()),
        "crossings": int(y[lay.DEFECT_CROSSINGS]),
        "cage_angle_start_rad": _cage_angle(setup, raw),
    }


def _is_random(setup: Setup, raw: RawRecord, chaotic: bool) -> bool:
    """Check if line and RMS may scatter at random, and the record has enough ball passes to show it."""
    has_enough_passes = len(recording.windows(setup.case, setup.grid, raw, reach=0).index) >= accuracy.MIN_PASSES
    return has_enough_passes and (chaotic or may_be_periodic(setup.case) or has_free_cage(setup.case))


def _start_features(errors: StartErrors) -> dict[str, float]:
    """Return the relative errors of a record due to the start-up transient."""
    return {"error.start": errors.line, "error.start.rms": errors.rms, "error.start.force": errors.force}


def _damping(setup: Setup) -> dict[str, float]:
    """Return the damping of the contacts; NaN if the model has none (``config/rules/damping.py``)."""
    limits = setup.limits
    values = {
        "damping_time_s": limits.damping_time,
        "damping_ratio": limits.damping_ratio,
        "crossing_s": limits.crossing,
    }
    return values if "damping" in MODELS[setup.case.model].abilities else dict.fromkeys(values, nan)


def _cage_angle(setup: Setup, raw: RawRecord) -> float:
    """Return the angle (rad) of the first roller's pocket at the start of the record, cage slip included."""
    bearing, position = setup.model.bearing, setup.case.settle_s * setup.grid.fine_rate
    before, after = raw.read(floor(position), 2, np.array([FEATURE_CELLS.index(CAGE_ANGLE)]))[0]
    slip = before + (position - floor(position)) * (after - before)
    (time,) = kinematic_times(setup.model, np.array([setup.case.settle_s]))
    return float(bearing.theta_0 + bearing.omega_c * time + slip)
