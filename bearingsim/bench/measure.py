"""Timed run: a row with its features and cost, or the reason for its failure."""

from collections.abc import Callable
from dataclasses import replace
from math import nan
from typing import Any

from bearingsim.bench import external
from bearingsim.bench.plan import AUTOMATIC, JOB, REFERENCE, Run, Setting
from bearingsim.catalogue import METHODS
from bearingsim.config import Case
from bearingsim.errors import Refused
from bearingsim.simulation import Record, SimulationError, compile_solvers, simulate
from bearingsim.simulation import limits as case_limits
from bearingsim.simulation.choice import automatic_step
from bearingsim.simulation.settling import resolve_settling

FULL_RUN = {"periodic": False, "step_check": False}
"""Settings of a full integration, without period search and step check."""
SHORT_TIME = 0.3
"""CPU time (s) below which a run is timed twice, and the smaller time kept; external solvers and reference runs
are timed once."""
QUANTITIES = ("line", "rms", "force")
"""Compared quantities: the defect line (m/s), the RMS of the velocity (m/s), the largest outer force (N)."""
COLUMNS = (
    *("key", "scene", "variant", "model", "role", "method", "setting", "step_s", "tolerance"),
    *("cpu_per_s", *QUANTITIES, "chaotic", "period_passes", "failure", "reason"),
)
"""Columns of a row. ``cpu_per_s``: CPU time of the integration, or of a whole job, per simulated second."""

Row = dict[str, Any]


def compute_rows(run: Run) -> list[Row]:
    """Compute a run; return its row, and for the automatic choice also one of its method as a ``FULL_RUN``."""
    case = run.case
    if case is None:
        return [_failed_row(run, "refused", run.refusal)]
    if run.role == JOB:
        return _unless_failed(run, lambda: _job_rows(run, case))
    if run.method in external.SOLVERS:
        return _unless_failed(run, lambda: [_solve_externally(run, case)])
    return _unless_failed(run, lambda: [_compute_fully(run, configure(run, case))])


def _unless_failed(run: Run, compute: Callable[[], list[Row]]) -> list[Row]:
    """Return the rows that a function computes for a run, or one with the reason of its failure."""
    try:
        return compute()
    except (Refused, SimulationError) as error:
        has_begun = getattr(error, "time", None) is not None
        return [_failed_row(run, "stopped" if has_begun else "refused", str(error))]
    except external.SolverStopped as error:
        return [_failed_row(run, "solver stopped", str(error))]


def configure(run: Run, case: Case) -> Case:
    """Return the case with a run's method and setting, as a ``FULL_RUN``."""
    case = case.model_copy(update=FULL_RUN | {"method": run.method or None})
    if run.method and METHODS[run.method].adaptive:
        return case.model_copy(update={"step": "auto", "tolerance": run.setting.tolerance})
    automatic_step_s = automatic_step(case, case_limits.step_limits(case))
    return case.model_copy(update={"step": run.setting.step * automatic_step_s, "tolerance": "auto"})


def _job_rows(run: Run, case: Case) -> list[Row]:
    """Compute a case with the automatic choice, then the chosen method as a ``FULL_RUN``."""
    case = case.model_copy(update={"step": "auto", "tolerance": "auto"})
    compile_solvers([case])
    record = simulate(case)
    seconds = _cpu_seconds(case, record, "cpu_s")
    job_row = _row(run, record, seconds / (resolve_settling(case).settle_s + case.duration))
    method = str(record.info["method"] or "")
    settings: dict[str, Any] = {}
    if method and METHODS[method].adaptive:
        settings = {"method": method, "tolerance": float(record.info["tolerance"])}
    elif method:
        settings = {"method": method, "step": float(record.info["step_s"])}
    full_run = replace(run, role=AUTOMATIC, method=method)
    full_case = case.model_copy(update=FULL_RUN | settings)
    (full_row,) = _unless_failed(full_run, lambda: [_compute_fully(full_run, full_case)])
    return [job_row, full_row | {"key": run.key, "chaotic": job_row["chaotic"]}]


def _compute_fully(run: Run, case: Case) -> Row:
    """Compute a case with a given step or tolerance."""
    compile_solvers([case])
    record = simulate(case)
    rate = case.bearing.ball_pass_frequency(case.speed)
    is_reference = run.role == REFERENCE  # reference runs are timed once
    seconds = (
        float(record.info["integrator_cpu_s"]) if is_reference else _cpu_seconds(case, record, "integrator_cpu_s")
    )
    return _row(run, record, seconds / (float(record.info["passes"]) / rate))


def _cpu_seconds(case: Case, record: Record, name: str) -> float:
    """Return the CPU time of a run (s), the smaller of two if it is short."""
    seconds = float(record.info[name])
    return seconds if seconds > SHORT_TIME else min(seconds, float(simulate(case).info[name]))


def _row(run: Run, record: Record, cpu_per_s: float) -> Row:
    features, info = record.features, record.info
    adaptive = run.role != JOB and bool(info["method"]) and METHODS[str(info["method"])].adaptive
    return _empty_row(run) | {
        "method": info["method"] or "",
        "step_s": nan if adaptive else float(info["step_s"]),
        "tolerance": float(info["tolerance"]),
        "cpu_per_s": cpu_per_s,
        **_values(run, features),
        "chaotic": features.get("chaotic", nan),
        "period_passes": int(info["period_passes"]),
    }


def _solve_externally(run: Run, case: Case) -> Row:
    """Compute a case with a solver of another package."""
    features, cpu_s, simulated_s = external.solve(case, external.SOLVERS[run.method], run.setting.tolerance)
    return _empty_row(run) | {
        "tolerance": run.setting.tolerance,
        "cpu_per_s": cpu_s / simulated_s,
        **_values(run, features),
    }


def _values(run: Run, features: dict[str, float]) -> Row:
    return dict(
        zip(QUANTITIES, (features[run.line], features["velocity.rms"], features["outer_force.max"]), strict=True)
    )


def _empty_row(run: Run) -> Row:
    """Return a row that names its run and has no results."""
    empty: Row = dict.fromkeys(COLUMNS, nan)
    return empty | {
        "key": run.key,
        "scene": run.scene,
        "variant": run.variant,
        "model": run.model,
        "role": run.role,
        "method": run.method,
        "setting": _setting(run.setting),
        "failure": "",
        "reason": "",
    }


def _setting(setting: Setting) -> str:
    """Format a setting as in the plan: a multiple of the automatic step, or a tolerance."""
    if setting.step == setting.step:
        return f"{setting.step:g} of the automatic step"
    return f"{setting.tolerance:g}" if setting.tolerance == setting.tolerance else ""


def _failed_row(run: Run, failure: str, reason: str) -> Row:
    return _empty_row(run) | {"failure": failure, "reason": reason, "tolerance": run.setting.tolerance}


def compile_run(run: Run) -> str:
    """Compile (or load) the code of a run; return its model."""
    if run.case is None:
        return run.model
    try:
        if run.method in external.SOLVERS:
            short_case = run.case.model_copy(update={"duration": 0.01, "settle": 0.0})
            external.solve(short_case, external.SOLVERS[run.method], 1e-3)
        else:
            compile_solvers([run.case if run.role == JOB else configure(run, run.case)])
    except (Refused, SimulationError, external.SolverStopped):
        pass  # reported in the row of the run
    return run.model
