"""Run of a study: missing jobs are computed and stored."""

import signal
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import AbstractContextManager, closing, contextmanager, nullcontext, suppress
from dataclasses import dataclass, replace
from functools import partial
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bearingsim import cpu_time, store
from bearingsim.errors import UserError
from bearingsim.runner import beside
from bearingsim.runner.bounds import Affordable, affordable, ended_early, refuse_bounds
from bearingsim.runner.commands import command
from bearingsim.runner.findings import Findings, findings
from bearingsim.runner.packing import Cost, fewer, fitting, pack, shard_of
from bearingsim.runner.pool import outcomes
from bearingsim.runner.progress import compiling
from bearingsim.runner.progress import progress as shown_progress
from bearingsim.runner.select import NoChoices, Stopped, selected
from bearingsim.runner.stopping import ending, flag_for_workers
from bearingsim.runner.summary import Interrupted, RunSummary, grouped
from bearingsim.runner.work import BEARINGSIM, Engine, Outcome, Work, load
from bearingsim.text.patience import Patience, patient
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.runner.cluster import Cluster
    from bearingsim.study import Job, Study


LEAST_PART = 0.1
"""Least size of the compressed series, as a part of their bytes, for the check of disk space."""


def run(
    study: "Study",
    out: str | Path | None = None,
    jobs: int | None = None,
    fresh: bool = False,
    retry_failed: bool = False,
    shard: tuple[int, int] = (1, 1),
    verify: bool = False,
    progress: bool | None = None,
    engine: Engine = BEARINGSIM,
    max_failures: float = inf,
    max_cpu: float = inf,
    scheduler: str | None = None,
) -> RunSummary:
    """Compute the jobs of a study that are not stored yet, into ``out``.

    out: default ``results/<study>``, of a quick study ``results/<study>-quick``.

    jobs: worker processes (default: the CPUs); 1 computes in this process. fresh: throw stored results away
    first. retry_failed: try failed jobs again. shard: ``(k, n)`` computes share k of n. verify: read every
    stored byte against its checksum before trusting it. progress: False shows none. max_failures: failed jobs
    after which no more are begun. max_cpu: CPU time (s) of a job: a job with a larger estimate is left out, a job
    that exceeds it fails; neither bound is part of a job's id, because neither changes a result. scheduler:
    ``tcp://HOST:PORT`` of a dask scheduler, whose workers compute the jobs; this process still chooses the models.

    Raises Interrupted (with the summary; finished jobs are stored), ValueError for contradictory options,
    store.FolderInUse, WorkersDie, ScanError before any computation if a scan's file is missing or has changed, and
    OSError if the folder cannot be written.
    """
    started = time.perf_counter()
    root = store.results_folder(study.name, study.quick, out)
    notes = [*study.notes, *load(engine.notes)(study.cases())]  # now: files that it reads may go
    workers, joined = _workers(jobs), _joined(scheduler)
    refuse_bounds(max_failures, max_cpu)
    shard_of([], shard)  # a share that does not exist is refused before models are tried
    if fresh and workers > 1 and joined is None:
        flag_for_workers()  # without shared memory it raises, before anything is thrown away
    with _prepared(root, study, fresh, shard, progress):
        before = store.holdings(root).sealed if study.goal is not None else None  # trials may do some jobs, too
        try:
            reach = partial(_reach, joined)
            study = selected(study, root, workers, engine, alone=shard == (1, 1), shown=progress, begin=reach)
        except Stopped as stop:
            raise Interrupted(_before_jobs(study, root, stop, time.perf_counter() - started)) from None
        every = study.jobs()
        ours = shard_of(every, shard)
        store.keep_scans(root, [job.case for job in every])
        earlier = store.planned_jobs(root)
        written = store.write_plan(root, study, every, notes)
        plan = _plan(root, ours, retry_failed, verify, before)
        store.log(root, "run", study=study.name, jobs=len(ours), resumed=plan.resumed, shard=list(shard))
        tally = _Tally(root, command("run", study, root, "--retry-failed"), plan.failures, max_failures)
        interrupted, bounds = 0, (engine, max_failures, max_cpu, plan.held.units)
        try:
            if plan.todo and joined is not None:
                with joined() as cluster:  # first: estimating what the jobs take may compile code
                    todo = affordable(plan.todo, _costs(engine, plan.todo, max_cpu), max_cpu, progress)
                    notes += todo.notes
                    works = _works(root, study, todo, cluster.assembled(), *bounds)
                    _compute(works, cluster.outcomes(works), tally, progress)
            elif plan.todo:
                with patient(progress) as patience:
                    patience.begin("estimating what the jobs take")
                    todo = affordable(plan.todo, _costs(engine, plan.todo, max_cpu), max_cpu, progress)
                    notes += [*todo.notes, *fewer(todo.costs, workers)]
                    workers = fitting(todo.costs, workers)
                    works = _works(root, study, todo, workers, *bounds)
                    _warm(root, engine, todo.jobs, patience)
                _compute(works, outcomes(works, workers), tally, progress)
        except KeyboardInterrupt as stop:
            interrupted = getattr(stop, "number", signal.SIGINT)
        store.sweep(root)
        store.build_table(root, plan.held.rows)
        frame = store.own_frame(root, written, plan.held.rows)
    seconds = time.perf_counter() - started
    left_out = len((earlier & plan.held.sealed) - {job.id for job in every})
    status = frame["status"].loc[[job.id for job in ours]]
    if tally.full and (status == "missing").any():
        notes.insert(0, ended_early(tally.failed, max_failures))
    all_notes = (*_notes(left_out, plan.held.damaged), *beside.notes(root, written, tally.elsewhere), *notes)
    of_results = findings(written, frame)
    summary = tally.summary(study.name, status, plan.resumed, seconds, interrupted, all_notes, of_results)
    store.log(root, "interrupted" if interrupted else "end", done=summary.done, failed=summary.failed)
    if interrupted:
        raise Interrupted(summary)
    return summary


def _before_jobs(study: "Study", root: Path, stop: Stopped, seconds: float) -> RunSummary:
    """Summarise a run that was interrupted during the trials of models, some of which are results of jobs."""
    jobs = {job.id for job in study.jobs()}
    sealed = store.holdings(root).sealed
    return RunSummary(
        study=study.name,
        folder=root,
        planned=len(jobs),
        resumed=len(jobs & sealed),
        done=0,
        failures=(),
        seconds=seconds,
        start_cpu_s=0.0,
        cpu_s=0.0,
        integrator_cpu_s=0.0,
        interrupted=stop.number,
        notes=(stop.what,),
    )


def with_models(study: "Study", out: str | Path | None, jobs: int | None, try_them: bool) -> "Study":
    """Return the study with the models chosen in its results folder; unchanged if any case has no choice.

    try_them: make the choice, and store it there.
    """
    root = store.results_folder(study.name, study.quick, out)
    with _prepared(root, study) if try_them else nullcontext(), suppress(NoChoices):
        return selected(study, root, _workers(jobs), BEARINGSIM, alone=try_them)
    return study


def _notes(left_out: int, damaged: Sequence[str]) -> Iterator[str]:
    """Yield notes on earlier results in the folder: jobs outside the plan, damaged files."""
    if left_out:
        jobs = f"{left_out} job{'s' * (left_out > 1)}"
        stay = "results stay in units/ (a run of the earlier plan brings them back)"
        yield f"out of the table, for not being in this plan: {jobs} of the earlier one; {stay}"
    if damaged:
        files = f"1 damaged file ({damaged[0]})" if len(damaged) == 1 else f"{len(damaged)} damaged files"
        yield f"{files} found and set aside as .damaged: what they held is computed again"


def _workers(requested: int | None) -> int:
    """Return the requested number of worker processes, or the number of CPUs. Raises ValueError below 1."""
    from joblib import cpu_count

    if requested is not None and requested < 1:
        raise ValueError(f"expected at least 1 worker process, got {requested}")
    return requested or int(cpu_count())


def _joined(scheduler: str | None) -> "Callable[[], AbstractContextManager[Cluster]] | None":
    """Return a function that joins the workers of a scheduler, None without one.

    Raises UserError if the package for it is missing.
    """
    if scheduler is None:
        return None
    try:
        from bearingsim.runner.cluster import joined
    except ModuleNotFoundError as error:
        raise UserError(f"--scheduler needs `{error.name}`: pip install 'bearingsim[cluster]'") from None
    return partial(joined, scheduler)


def _reach(joined: "Callable[[], AbstractContextManager[Cluster]] | None") -> None:
    """Connect to the scheduler once, so that a wrong address is reported before models are tried."""
    if joined is not None:
        with joined():
            pass


@contextmanager
def _prepared(
    root: Path, study: "Study", fresh: bool = False, shard: tuple[int, int] = (1, 1), shown: bool | None = None
) -> Iterator[None]:
    """Claim the folder, clear it if requested, and mark it as in use until leaving."""
    if fresh and shard != (1, 1):
        raise ValueError("a fresh start would throw away the other shards' results: remove the folder first")
    store.claim_results(root, study.name, bool(study.quick), fresh)
    store.refuse_links(root)
    store.refuse_users_study(root, study)
    store.sweep(root)
    thrown_away = store.discard(root, study.name) if fresh else ""
    if thrown_away and shown is not False:
        say(thrown_away, err=True)
    with store.in_use(root):
        store.claim_results(root, study.name, bool(study.quick))  # again: until now another run could clear it
        yield


@dataclass(frozen=True)
class _Plan:
    """Jobs to compute, number of jobs done by earlier runs, failures that are not tried again.

    held: contents of the folder, of this study or another.
    """

    todo: list["Job"]
    resumed: int
    failures: dict[str, store.Failure]
    held: store.Holdings


def _plan(root: Path, jobs: Sequence["Job"], retry_failed: bool, verify: bool, before: set[str] | None) -> _Plan:
    """Plan the jobs to compute.

    before: ids of the jobs sealed when this run began, if trials have sealed some since.
    """
    held = store.holdings(root, verify)
    left = [job for job in jobs if job.id not in held.sealed]
    ids = {job.id for job in left}
    failures = {job: failure for job, failure in held.failures.items() if job in ids}
    todo = left if retry_failed else [job for job in left if job.id not in failures]
    resumed = [job for job in jobs if job.id in held.sealed and (before is None or job.id in before)]
    return _Plan(todo, len(resumed), failures, held)


@dataclass
class _Tally:
    """Running total of outcomes; writes failures and the journal as they arrive."""

    root: Path
    command: str
    failures: dict[str, store.Failure]
    max_failures: float = inf
    failed: int = 0
    elsewhere: int = 0
    start_cpu_s: float = 0.0
    cpu_s: float = 0.0
    integrator_cpu_s: float = 0.0

    @property
    def full(self) -> bool:
        """True if the number of jobs failed in this run has reached its bound."""
        return self.failed >= self.max_failures

    def add(self, outcome: Outcome) -> None:
        """Add an outcome."""
        self.failed += len(outcome.failed)
        self.elsewhere += len(outcome.elsewhere)
        self.start_cpu_s += outcome.start_cpu_s
        self.cpu_s += outcome.cpu_s
        self.integrator_cpu_s += outcome.integrator_cpu_s
        for job in (*outcome.done, *outcome.elsewhere):
            if self.failures.pop(job, None) is not None:
                store.clear_failure(self.root, job)
        for failure in outcome.failed:
            self._add_failure(failure)
        facts = {"done": len(outcome.done), "failed": len(outcome.failed)}
        unit = store.unit_name(outcome.done) if outcome.done else outcome.unit  # as it was sealed
        store.log(self.root, "unit", unit=unit, **facts, seconds=round(outcome.seconds, 3))

    def summary(
        self,
        study: str,
        status: "pd.Series[str]",
        resumed: int,
        seconds: float,
        interrupted: int,
        notes: tuple[str, ...],
        of_results: Findings,
    ) -> RunSummary:
        """Summarise the run; status: of each requested job, as in the table, so that both counts agree."""
        return RunSummary(
            study=study,
            folder=self.root,
            planned=len(status),
            resumed=resumed,
            done=int((status == "done").sum()) - resumed,
            failures=grouped(
                self.failures[job] for job in status.index[status == "failed"] if job in self.failures
            ),
            seconds=seconds,
            start_cpu_s=self.start_cpu_s,
            cpu_s=self.cpu_s,
            integrator_cpu_s=self.integrator_cpu_s,
            interrupted=interrupted,
            notes=notes,
            findings=of_results,
        )

    def _add_failure(self, failure: store.Failure) -> None:
        before = self.failures.get(failure.job)
        attempts = failure.attempts + (before.attempts if before else 0)
        completed = replace(failure, attempts=attempts, command=self.command, when=store.now())
        self.failures[failure.job] = completed
        completed.write(self.root)


def _works(
    root: Path,
    study: "Study",
    todo: Affordable,
    workers: int,
    engine: Engine,
    max_failures: float,
    max_cpu: float,
    judged: frozenset[str],
) -> list[Work]:
    """Pack the remaining jobs into units of work; ``judged``: units in the folder when the jobs were planned.

    Raises DiskFull if the disk has too little room even for compressed series.
    """
    provenance = store.provenance(study)
    units = pack(todo.jobs, todo.costs, workers)
    others = beside.OtherRuns(root, judged)
    works = [
        Work(
            root,
            tuple(todo.jobs[i] for i in unit),
            tuple(todo.costs[i].seconds for i in unit),
            engine,
            provenance,
            sum(todo.costs[i].bytes for i in unit),
            max_cpu,
            max_failures,
            others,
            {todo.jobs[i].id: todo.costs[i].spent for i in unit},
        )
        for unit in units
    ]
    store.check_room(root, LEAST_PART * sum(work.bytes for work in works))
    return works


def _warm(root: Path, engine: Engine, todo: Sequence["Job"], patience: Patience) -> None:
    """Compile before workers start; errors are logged, and raised again by the job that needs the code."""
    try:
        load(engine.warm)([job.case for job in todo], compiling(patience))
    except Exception as error:
        store.log(root, "warm-up failed", reason=f"{type(error).__name__}: {error}")


def _costs(engine: Engine, todo: Sequence["Job"], max_cpu: float) -> list[Cost]:
    estimate = load(engine.estimate)
    return [_cost(estimate, job.case, max_cpu) for job in todo]


def _cost(estimate: Callable[[Any], Any], case: Any, max_cpu: float) -> Cost:
    """Estimate the cost of a job: zero for a refused case, whose simulation reports the reason.

    Infinite if the estimate itself takes longer than the CPU time (s) of a job.
    """
    began = cpu_time.now()
    try:
        with cpu_time.at_most(max_cpu):
            price = estimate(case)
    except cpu_time.OutOfCpuTime:
        return Cost(inf, 0.0)
    except ValueError:
        return Cost(0.0, 0.0)
    numbers = float(price.cpu_seconds), float(price.bytes), float(price.most_memory)
    return Cost(*numbers, spent=cpu_time.now() - began)


def _compute(
    works: Sequence[Work], outcomes: Generator[Outcome, None, None], tally: _Tally, shown: bool | None
) -> None:
    """Add the outcome of each unit of work to the tally as it arrives, and show the progress."""
    price = {job.id: seconds for work in works for job, seconds in zip(work.jobs, work.seconds, strict=True)}
    bar = shown_progress(shown, len(price), sum(price.values()))
    with bar as report, ending() as end, closing(outcomes) as coming:
        for outcome in coming:
            tally.add(outcome)
            if tally.full:
                end()
            done = (*outcome.done, *outcome.elsewhere)
            ids = [*done, *(failure.job for failure in outcome.failed)]
            report(len(done), len(outcome.failed), sum(price[job] for job in ids))
