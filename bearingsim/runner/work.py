"""Units of work, and their computation in a worker process."""

import ctypes
import importlib
import os
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bearingsim import cpu_time, store
from bearingsim.errors import UserError
from bearingsim.runner.stopping import init_worker, stop_requested
from bearingsim.store import DiskFull, Failure, full_disk_errors, start_marker, unit_name, write_units
from bearingsim.store.columns import Value

if TYPE_CHECKING:
    from bearingsim.simulation.record import Record
    from bearingsim.study import Job


PR_SET_PDEATHSIG = 1  # option of prctl(2) that sets the signal sent to this process when its parent dies
POLL_S = 2.0  # s; interval between checks of the parent where prctl is not available


@dataclass(frozen=True)
class Engine:
    """Import paths ``module:function`` of the functions of a solver.

    simulate: computes a case; estimate: estimates its cost; warm: compiles the code beforehand; try_out: computes
    the first ball passes of a case; notes: remarks on all cases; compiling: estimates the CPU time of compilation.
    """

    simulate: str = "bearingsim.simulation:simulate"
    estimate: str = "bearingsim.simulation.time_grid:estimate"
    warm: str = "bearingsim.simulation:compile_solvers"
    try_out: str = "bearingsim.simulation:run_trial"
    notes: str = "bearingsim.config.scan.notes:notes"
    compiling: str = "bearingsim.simulation.pricing:compile_time"


BEARINGSIM = Engine()

Seal = Callable[[Path, Sequence[tuple["Job", "Record"]], Mapping[str, Value]], object]
"""Callback that stores records: results folder, jobs with their records, provenance."""


LISTING_INTERVAL_S = 0.5
"""Shortest time (s) between two listings of the units in the folder."""


@dataclass
class OtherRuns:
    """Other runs in a folder, and the jobs that they have stored since this run began.

    known_units: names of the units in the folder when the jobs were planned. Units that this run has stored since
    count as well, which has no effect because their jobs are not started again (``pool.compute_outcomes``).
    """

    root: Path
    known_units: frozenset[str]
    _jobs: set[str] = field(default_factory=set, init=False)
    _checked_at: float = field(default=-LISTING_INTERVAL_S, init=False)

    def has_stored(self, job: str) -> bool:
        """Check if another run has stored a job; the list of units is at most LISTING_INTERVAL_S old."""
        if time.monotonic() - self._checked_at >= LISTING_INTERVAL_S:
            self._jobs = self.list_jobs()
            self._checked_at = time.monotonic()
        return job in self._jobs

    def list_jobs(self) -> set[str]:
        """List the jobs that this and other runs have stored since this run began."""
        units = store.unit_names(self.root) - self.known_units
        return {name for unit in units for name in _read_job_ids(store.unit_path(self.root, unit))}


@dataclass(frozen=True)
class Work:
    """Unit of work: jobs that one worker computes and stores together.

    root: results folder; seconds: estimated CPU time (s) of each job; bytes: size of all series; max_cpu: limit of
    the CPU time (s) of a job; max_failures: number of failed jobs after which no more are started; others: other
    runs in the folder; spent: CPU time (s) used by the estimate of each job, by id.
    """

    root: Path
    jobs: tuple["Job", ...]
    seconds: tuple[float, ...]
    engine: Engine
    provenance: Mapping[str, Value]
    bytes: float = 0.0
    max_cpu: float = inf
    max_failures: float = inf
    others: OtherRuns | None = None
    spent: Mapping[str, float] = field(default_factory=dict)

    @property
    def unit(self) -> str:
        """Name of the unit, which depends on its jobs."""
        return unit_name(job.id for job in self.jobs)

    def subset(self, ids: Iterable[str]) -> "Work":
        """Return the part of the work with the jobs of these ids."""
        job_ids = set(ids)
        pairs = [pair for pair in zip(self.jobs, self.seconds, strict=True) if pair[0].id in job_ids]
        return replace(self, jobs=tuple(job for job, _ in pairs), seconds=tuple(cost for _, cost in pairs))


@dataclass(frozen=True)
class Outcome:
    """Outcome of a unit of work.

    done: ids of the stored jobs; done_by_others: ids of jobs stored by another run; seconds: elapsed time;
    start_cpu_s: CPU time (s) of imports and of compilation or loading its cache; cpu_s: CPU time (s) after that;
    integrator_cpu_s: the part of ``cpu_s`` spent in the integrator.
    """

    unit: str
    done: tuple[str, ...]
    failed: tuple[Failure, ...]
    seconds: float = 0.0
    start_cpu_s: float = 0.0
    cpu_s: float = 0.0
    integrator_cpu_s: float = 0.0
    done_by_others: tuple[str, ...] = ()


def load(path: str) -> Callable[..., Any]:
    """Import the function at the path ``module:function``."""
    module, _, name = path.partition(":")
    function: Callable[..., Any] = getattr(importlib.import_module(module), name)
    return function


def compute(work: Work, seal: Seal = write_units) -> Outcome:
    """Simulate the jobs of a unit, store their records by ``seal``, and return the outcome with the failures.

    If a stop is requested, the finished jobs are stored. Only errors that concern the whole study are raised, such
    as DiskFull or a bug outside the simulation.
    """
    if stop_requested():
        return Outcome(work.unit, (), ())
    started = time.perf_counter()
    start_cpu_s = _start_up(work)
    cpu_before = time.process_time()
    done: list[tuple[Job, Record]] = []
    failed: list[Failure] = []
    done_by_others: list[str] = []
    simulate, unit = load(work.engine.simulate), work.unit
    with start_marker(work.root, unit) as record_job:
        for job in work.jobs:
            if stop_requested() or len(failed) >= work.max_failures:
                break
            if work.others is not None and work.others.has_stored(job.id):
                done_by_others.append(job.id)
                continue
            record_job(job.id)
            limit = cpu_time.at_most(work.max_cpu, work.spent.get(job.id, 0.0))
            try:
                with full_disk_errors(work.root / unit), limit:  # a full disk is not a failure of the job
                    done.append((job, simulate(job.case)))
            except DiskFull:
                raise
            except KeyboardInterrupt:  # no handler of ``stopping.py`` is set
                seal(work.root, done, work.provenance)
                raise
            except Exception as error:
                failed.append(_failure(job.id, error))
        seal(work.root, done, work.provenance)
    return Outcome(
        unit=unit,
        done=tuple(job.id for job, _ in done),
        failed=tuple(failed),
        done_by_others=tuple(done_by_others),
        seconds=time.perf_counter() - started,
        start_cpu_s=start_cpu_s,
        cpu_s=time.process_time() - cpu_before,
        integrator_cpu_s=sum(float(record.info.get("integrator_cpu_s", 0.0)) for _, record in done),
    )


def _start_up(work: Work) -> float:
    """Import and compile the code of the jobs; return the CPU time (s).

    Errors are ignored, because the job raises and reports them again.
    """
    start = time.process_time()
    with suppress(Exception):
        load(work.engine.warm)([job.case for job in work.jobs])
    return time.process_time() - start


def _failure(job: str, error: Exception) -> Failure:
    """Convert an exception to a Failure; those of the simulation have the attributes reason, advice and time."""
    text = str(error).strip().partition("\n")[0]
    kind = "" if isinstance(error, UserError) else f"{type(error).__name__}: "
    return Failure(
        job=job,
        reason=str(getattr(error, "reason", "") or f"{kind}{text}".rstrip(": ")),
        advice=str(getattr(error, "advice", "") or ""),
        time=getattr(error, "time", None),
        traceback="".join(traceback.format_exception(error)),
    )


def die_with_parent(parent: int, flag: Any) -> None:
    """Set up a worker to end when its parent process dies, and to stop when the event of the parent is set."""
    init_worker(flag)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    else:
        threading.Thread(target=_watch_parent, args=(parent,), daemon=True).start()
    if os.getppid() != parent:  # the parent died before the request was made
        os._exit(1)


def _watch_parent(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(POLL_S)
    os._exit(1)


@cache
def _read_job_ids(path: Path) -> list[str]:
    """Read the ids of the jobs of a unit, which never change; return an empty list if it cannot be read."""
    try:
        return store.read_job_ids(path)
    except store.DamagedUnit:
        return []
