"""One run, timed: a row of what it found and what it took, or why it failed."""

from dataclasses import replace
from math import nan
from typing import Any

from bearingsim.bench import outside
from bearingsim.bench.plan import AUTOMATIC, JOB, JUDGE, Run, Setting
from bearingsim.catalogue import METHODS
from bearingsim.config import Case
from bearingsim.errors import Refused
from bearingsim.simulation import limits as case_limits
from bearingsim.simulation import simulate
from bearingsim.simulation.automatic_step import automatic_step
from bearingsim.simulation.settling import settled
from bearingsim.simulation.simulate import Record, SimulationError, warm

IN_FULL = {"periodic": False, "step_check": False}
CHEAP = 0.3  # s: what takes less is timed twice, and the least counts
QUANTITIES = ("line", "rms", "force")
"""What is compared: the fault's line (m/s), the RMS of the velocity (m/s), the largest outer force (N)."""
COLUMNS = (
    *("key", "scene", "variant", "model", "role", "method", "setting", "step_s", "tolerance"),
    *("cpu_per_s", *QUANTITIES, "chaotic", "period_passes", "failure", "reason"),
)
"""Of the rows. ``cpu_per_s``: CPU time for a second that is simulated: of what is integrated; of a job, of all."""

Row = dict[str, Any]


def rows(run: Run) -> list[Row]:
    """What became of a run: one row; of the automatic choice a second one, its method and step in full."""
    if run.case is None:
        return [_failed(run, "refused", run.refused)]
    try:
        if run.method in outside.SOLVERS:
            return [_by_other(run, run.case)]
        return _job(run, run.case) if run.role == JOB else [_in_full(run, asked(run, run.case))]
    except (Refused, SimulationError) as error:
        late = getattr(error, "time", None) is not None
        return [_failed(run, "stopped" if late else "refused", str(error))]
    except outside.GaveUp as error:
        return [_failed(run, "gave up", str(error))]


def asked(run: Run, case: Case) -> Case:
    """The case with a run's method and setting, in full."""
    case = case.model_copy(update=IN_FULL | {"method": run.method or None})
    if run.method and METHODS[run.method].adaptive:
        return case.model_copy(update={"step": "auto", "tolerance": run.setting.tolerance})
    usual = automatic_step(case, case_limits.step_limits(case))
    return case.model_copy(update={"step": run.setting.step * usual, "tolerance": "auto"})


def _job(run: Run, case: Case) -> list[Row]:
    """A case as a user gets it, then what it chose in full."""
    case = case.model_copy(update={"step": "auto", "tolerance": "auto"})
    warm([case])
    record = simulate(case)
    seconds = _cpu(case, record, "cpu_s")
    took = [_row(run, record, seconds / (settled(case).settle + case.duration))]
    if case.method is None:
        full = _in_full(replace(run, role=AUTOMATIC), case.model_copy(update=IN_FULL))
        return [*took, full | {"key": run.key}]
    method = str(record.info["method"])
    same = {"method": method, "step": float(record.info["step_s"])}
    if METHODS[method].adaptive:
        same = {"method": method, "tolerance": float(record.info["tolerance"])}
    chosen = replace(run, role=AUTOMATIC, method=method)
    full = _in_full(chosen, case.model_copy(update=IN_FULL | same))
    return [*took, full | {"key": run.key, "chaotic": took[0]["chaotic"]}]


def _in_full(run: Run, case: Case) -> Row:
    """A case whose step or tolerance is given."""
    warm([case])
    record = simulate(case)
    rate = case.bearing.ball_pass_frequency(case.speed)
    once = run.role == JUDGE  # its time is nobody's
    seconds = float(record.info["integrator_cpu_s"]) if once else _cpu(case, record, "integrator_cpu_s")
    return _row(run, record, seconds / (float(record.info["passes"]) / rate))


def _cpu(case: Case, record: Record, name: str) -> float:
    """CPU time of a run (s), the least of two if it is short."""
    first = float(record.info[name])
    return first if first > CHEAP else min(first, float(simulate(case).info[name]))


def _row(run: Run, record: Record, cpu_per_s: float) -> Row:
    found, info = record.features, record.info
    adaptive = run.role != JOB and bool(info["method"]) and METHODS[str(info["method"])].adaptive
    return _about(run) | {
        "method": info["method"] or "",
        "step_s": nan if adaptive else float(info["step_s"]),
        "tolerance": float(info["tolerance"]),
        "cpu_per_s": cpu_per_s,
        **_values(run, found),
        "chaotic": found.get("chaotic", nan),
        "period_passes": int(info["period_passes"]),
    }


def _by_other(run: Run, case: Case) -> Row:
    """A case by a solver of another package."""
    found, cpu, simulated = outside.solve(case, outside.SOLVERS[run.method], run.setting.tolerance)
    return _about(run) | {
        "tolerance": run.setting.tolerance,
        "cpu_per_s": cpu / simulated,
        **_values(run, found),
    }


def _values(run: Run, found: dict[str, float]) -> Row:
    return dict(zip(QUANTITIES, (found[run.line], found["velocity.rms"], found["outer_force.max"]), strict=True))


def _about(run: Run) -> Row:
    """A row that says of which run it is, and nothing yet of what became of it."""
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
    """A setting as the plan has it: a part of the automatic step, or a tolerance."""
    if setting.step == setting.step:
        return f"{setting.step:g} of the step"
    return f"{setting.tolerance:g}" if setting.tolerance == setting.tolerance else ""


def _failed(run: Run, failure: str, reason: str) -> Row:
    return _about(run) | {"failure": failure, "reason": reason, "tolerance": run.setting.tolerance}


def ready(run: Run) -> str:
    """Compile (or load) what a run needs; its model."""
    if run.case is None:
        return run.model
    try:
        if run.method in outside.SOLVERS:
            short = run.case.model_copy(update={"duration": 0.01, "settle": 0.0})
            outside.solve(short, outside.SOLVERS[run.method], 1e-3)
        else:
            warm([run.case if run.role == JOB else asked(run, run.case)])
    except (Refused, SimulationError, outside.GaveUp):
        pass  # its row will say so
    return run.model
