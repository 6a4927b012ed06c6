"""Record of a run: time series, features, and information on its computation."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import floor, isnan, nan, sqrt
from typing import NamedTuple

import numpy as np

from bearingsim import assemble, cpu_time
from bearingsim.catalogue import MODELS
from bearingsim.config import Case, dataset_names
from bearingsim.config.names import NO_VALUE, QUIET_LINE, STEP_ACCURACY
from bearingsim.core import layout as lay
from bearingsim.core.geometry.motion import kinematic_times
from bearingsim.simulation import accuracy, channels, recording, step_check, time_grid
from bearingsim.simulation.accuracy import StandardErrors
from bearingsim.simulation.channels import CAGE_ANGLE, FEATURE_CELLS, MOTION
from bearingsim.simulation.comparison import fault_lines
from bearingsim.simulation.features import (
    compute_band_features,
    compute_extension_features,
    compute_features,
    refuse_undeclared,
)
from bearingsim.simulation.integration import StepUsage, step_usage
from bearingsim.simulation.recording import RawRecord
from bearingsim.simulation.repetition import may_be_periodic
from bearingsim.simulation.rounding import notable
from bearingsim.simulation.run_setup import Setup, SimulationError
from bearingsim.simulation.settling import has_free_cage
from bearingsim.simulation.spectral_lines import amplitudes_by_pass, reason_unresolved
from bearingsim.simulation.start_error import StartErrors, estimate_start_errors
from bearingsim.simulation.step_check import StepCheck
from bearingsim.simulation.sufficiency import Inspections


@dataclass(frozen=True)
class Record:
    """Record of a simulation, in SI.

    time: (n,) s from the start of the record (after settling); series: (n,) arrays by dataset name
    (``ring.velocity.x``); features: numbers by name (``velocity@BPFO``); info: entries on the computation
    (step, number of steps, CPU time, limits, cage angle at the start of the record).
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
        """Standard error of each line's amplitude, from its scatter between ball passes."""
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


def make_record(inspections: Inspections, raw: RawRecord, check: StepCheck, start_usage: Usage) -> Record:
    """Make the record of a run.

    check: its step check; start_usage: usage of the process before the first attempt. Raises SimulationError if
    the step check is strict and the error due to the initial transient too large or unknown.
    """
    full_setup, setup = inspections.setup, inspections.setup_of_record(raw)
    case = setup.case
    rows = channels.requested_rows(case, raw.cells)
    samples = recording.sample_rows(case, setup.grid, raw, rows)
    instants = np.arange(time_grid.sample_count(case)) / case.sampling
    series = channels.read_channels(case, setup.model, samples, raw.cells[rows], case.settle_s + instants)
    pass_amplitudes = amplitudes_by_pass(case, setup.model, setup.grid, raw)
    values = compute_features(case, setup.model, setup.grid, raw, pass_amplitudes) | compute_band_features(
        case, setup.model, setup.grid, raw
    )
    is_random = _is_random(case, check.chaotic)
    errors = no_errors = StandardErrors(nan, nan)
    if is_random or check.chaotic:
        errors = accuracy.estimate_standard_errors(case, setup.model, setup.grid, raw, pass_amplitudes)
    values |= _check_features(
        check, _pass_ratio(inspections.shortest_setup, setup), errors if check.chaotic else no_errors
    )
    resolved = [line for line in fault_lines(case) if not isnan(values[f"velocity@{line}"])]
    values |= _start_features(estimate_start_errors(setup, raw, errors if is_random else no_errors, resolved))
    values |= _rounding_features(setup, values)
    if case.step_check == "strict" and not (check.chaotic or has_free_cage(case) or case.ramp is not None):
        _refuse_start_error(case, [values["error.start"], values["error.start.rms"]])
    extension_values, reasons = compute_extension_features(case, instants, series)
    unresolved = [line for line in fault_lines(case) if line not in resolved]
    reasons |= {f"{NO_VALUE}velocity@{line}": reason_unresolved(case, line) for line in unresolved}
    refuse_undeclared(values | extension_values)
    return Record(
        time=instants,
        series=series,
        features=values | extension_values,
        info=_info(full_setup, raw, inspections.record_errors(raw)) | reasons | _usage_info(start_usage),
    )


def _usage_info(start_usage: Usage) -> dict[str, float | int | str]:
    """Return the CPU time (s) of a job, and steps and CPU time of all its runs, step check included."""
    now = Usage.now()
    return {
        "cpu_s": now.cpu_s - start_usage.cpu_s,
        "steps_taken": now.step_usage.steps - start_usage.step_usage.steps,
        "integrator_cpu_s": now.step_usage.cpu_s - start_usage.step_usage.cpu_s,
    }


def _refuse_start_error(case: Case, errors: Sequence[float]) -> None:
    """Raise SimulationError if an error by the initial transient is unknown or too large for a strict check."""
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


def _pass_ratio(checked_setup: Setup, record_setup: Setup) -> float:
    """Return the ratio of a record's ball passes to those of the shortest record, whose step was checked."""
    return recording.whole_passes(record_setup.case, record_setup.grid) / recording.whole_passes(
        checked_setup.case, checked_setup.grid
    )


def _check_features(check: StepCheck, pass_ratio: float, chaos_errors: StandardErrors) -> dict[str, float]:
    """Return the results of a step check as features.

    pass_ratio: ratio of ball passes in the record to those of the record whose step was checked; chaos_errors:
    standard errors of a chaotic record, otherwise NaN.
    """
    return {
        **{f"step_error.{name}": error for name, error in check.step_errors.items()},
        "chaotic": nan if check is step_check.UNCHECKED else float(check.chaotic),
        "rms_scatter": nan if check is step_check.UNCHECKED else check.scatter / sqrt(pass_ratio),
        "standard_error.line": chaos_errors.line,
        "standard_error.rms": chaos_errors.rms,
    }


def _rounding_features(setup: Setup, values: Mapping[str, float]) -> dict[str, float]:
    """Return the bounds of the motion due to rounding, and the relative errors that they change.

    A velocity within rounding is zero: a relative error of the step has no meaning (NaN), and nothing is left to
    settle (0). A larger one is uncertain by the rounding, relative to ``QUIET_LINE`` of the RMS for a quiet line.
    Crest factor and kurtosis of a quantity within rounding are NaN, as those of a constant one.
    """
    rounding, rms = setup.rounding, values["velocity.rms"]
    bounds = {f"{quantity}.rounding": bound for quantity, bound in zip(MOTION, rounding, strict=True)}
    for quantity in (name for name in MOTION if values[f"{name}.rms"] <= bounds[f"{name}.rounding"]):
        bounds |= {f"{quantity}.crest": nan, f"{quantity}.kurtosis": nan}
    if rms <= rounding.velocity:
        relative = {"step_error.line": nan, "step_error.rms": nan, "error.start": 0.0, "error.start.rms": 0.0}
    elif notable(rounding.velocity, rms) == 0.0:
        return bounds
    else:
        lines = [values[f"velocity@{line}"] for line in fault_lines(setup.case)]
        line = max(QUIET_LINE * rms, min((line for line in lines if line == line), default=0.0))
        shares = {"step_error.line": rounding.velocity / line, "step_error.rms": rounding.velocity / rms}
        relative = {name: max(values[name], value) for name, value in shares.items()}  # NaN if unchecked
    return bounds | {name: error for name, error in relative.items() if not isnan(values[name])}


def _info(setup: Setup, raw: RawRecord, record_errors: StandardErrors) -> dict[str, float | int | str]:
    """Return the entries on the computation of a run; record_errors: of a record with `until`, else NaN."""
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
        "standard_error_line": record_errors.line,
        "standard_error_rms": record_errors.rms,
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


def _is_random(case: Case, chaotic: bool) -> bool:
    """Check if amplitudes, RMS and largest force may scatter at random between ball passes."""
    return chaotic or may_be_periodic(case) or has_free_cage(case)


def _start_features(errors: StartErrors) -> dict[str, float]:
    """Return the relative errors of a record due to the initial transient as features."""
    return {"error.start": errors.line, "error.start.rms": errors.rms, "error.start.force": errors.force}


def _damping(setup: Setup) -> dict[str, float]:
    """Return damping time, damping ratio and crossing time; NaN without damping (``config/rules/damping.py``)."""
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
