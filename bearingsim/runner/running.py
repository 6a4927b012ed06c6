"""Run of a study: computation and storage of the missing jobs."""

import signal
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import AbstractContextManager, closing, contextmanager, nullcontext, suppress
from dataclasses import dataclass
from functools import partial
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from bearingsim import store
from bearingsim.errors import UserError
from bearingsim.runner.commands import command
from bearingsim.runner.findings import findings
from bearingsim.runner.packing import (
    AffordableJobs,
    check_limits,
    cost_text,
    early_end_note,
    estimate_costs,
    pack,
    select_affordable,
    select_shard,
    worker_note,
    workers_in_memory,
)
from bearingsim.runner.pool import compute_outcomes
from bearingsim.runner.progress import compilation_callback
from bearingsim.runner.progress import progress as shown_progress
from bearingsim.runner.select import MissingChoices, TrialsInterrupted, choose_models
from bearingsim.runner.stopping import flag_for_workers, stop_switch
from bearingsim.runner.summary import Interrupted, RunSummary
from bearingsim.runner.tally import (
    Plan,
    Tally,
    interrupted_summary,
    make_plan,
    other_run_notes,
    summary_of_read_only,
)
from bearingsim.runner.work import BEARINGSIM, Engine, OtherRuns, Outcome, Work, load
from bearingsim.text.announcer import Announcer, announcer
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    from bearingsim.runner.cluster import Cluster
    from bearingsim.study import Job, Study


MIN_COMPRESSION = 0.1
"""Smallest expected ratio of compressed to uncompressed size of the series, for the check of disk space."""


@dataclass(frozen=True)
class Options:
    """Options of a run. They do not change results, so they are not part of a job id.

    fresh: delete stored results first. retry_failed: compute failed jobs again. shard: ``(k, n)`` computes shard k
    of n. verify: check all stored units against their checksums, including those in the table. progress: False to
    show none. engine: import paths of the solver. max_failures: number of failed jobs after which no more are
    started. max_cpu: limit of the CPU time (s) of a job; a job with a larger estimate is skipped, a job that
    exceeds the limit fails. scheduler: ``tcp://HOST:PORT`` of a dask scheduler whose workers compute the jobs; the
    models are still chosen by this process.

    Raises ValueError for contradictory options.
    """

    fresh: bool = False
    retry_failed: bool = False
    shard: tuple[int, int] = (1, 1)
    verify: bool = False
    progress: bool | None = None
    engine: Engine = BEARINGSIM
    max_failures: float = inf
    max_cpu: float = inf
    scheduler: str | None = None

    def __post_init__(self) -> None:
        check_limits(self.max_failures, self.max_cpu)
        select_shard([], self.shard)
        if self.fresh and self.shard != (1, 1):
            raise ValueError("a fresh start would delete the results of other shards: remove the folder first")


class _Setting(NamedTuple):
    """Folder, study, options and number of worker processes of a run.

    connect: function that connects to a scheduler, None for a run without one.
    """

    root: Path
    study: "Study"
    options: Options
    workers: int
    connect: "Callable[[], AbstractContextManager[Cluster]] | None"


def run(study: "Study", out: str | Path | None = None, jobs: int | None = None, **options: Any) -> RunSummary:
    """Compute the jobs of a study that are not stored yet; options: the fields of ``Options``.

    out: results folder, by default ``results/<study>``, or ``results/<study>-quick`` for a quick study. jobs:
    number of worker processes, by default that of CPUs; 1 computes in this process. A folder that cannot be
    written is summarised if it has all jobs.

    Raises Interrupted (with the summary; finished jobs are stored), ValueError for contradictory options,
    store.FolderInUse, RepeatedWorkerDeaths, ScanError if the file of a scan is missing or has changed,
    ReadOnlyFolder if the folder cannot be written and lacks jobs, and other OSErrors.
    """
    started, run_options = time.perf_counter(), Options(**options)
    root = store.results_folder(study.name, study.quick, out)
    if not store.is_writable(root) and not run_options.fresh:
        return summary_of_read_only(with_models(study, out, jobs, run_trials=False), root, started)
    # Notes are collected before files from which they are read may be removed.
    notes = [*study.notes, *load(run_options.engine.notes)(study.cases())]
    workers, connect = _count_workers(jobs), _make_connector(run_options.scheduler)
    if run_options.fresh:  # an error must not occur after results are deleted
        _test_workers(workers, connect)
    with _prepare(root, study, run_options):
        # Jobs that trials compute below count as done by this run.
        stored_before = store.read_holdings(root).sealed if study.goal is not None else None
        setting = _choose_models(_Setting(root, study, run_options, workers, connect), started)
        study, all_jobs = setting.study, setting.study.jobs()
        own_jobs = select_shard(all_jobs, run_options.shard)
        store.store_scans(root, [job.case for job in all_jobs])
        earlier_jobs = store.planned_jobs(root)
        plan_entries = store.write_plan(root, study, all_jobs, notes)
        plan = make_plan(root, own_jobs, run_options.retry_failed, run_options.verify, stored_before)
        store.log(
            root, "run", study=study.name, jobs=len(own_jobs), resumed=plan.resumed, shard=list(run_options.shard)
        )
        tally = Tally(root, command("run", study, root, "--retry-failed"), plan.failures, run_options.max_failures)
        interrupted = 0
        try:
            if plan.pending:
                _compute(setting, plan, tally, notes)
        except KeyboardInterrupt as interruption:
            interrupted = getattr(interruption, "number", signal.SIGINT)
        store.remove_leftovers(root)
        store.build_table(root, plan.holdings.rows)
        frame = store.plan_frame(root, plan_entries, plan.holdings.rows)
    seconds = time.perf_counter() - started
    unplanned = len((earlier_jobs & plan.holdings.sealed) - {job.id for job in all_jobs})
    status = frame["status"].loc[[job.id for job in own_jobs]]
    if tally.has_reached_limit and (status == "missing").any():
        notes.insert(0, early_end_note(tally.failed, run_options.max_failures))
    all_notes = (
        *_folder_notes(unplanned, plan.holdings.damaged),
        *other_run_notes(root, plan_entries, tally.done_by_others),
        *notes,
    )
    summary = tally.summary(
        study.name, status, plan.resumed, seconds, interrupted, all_notes, findings(plan_entries, frame)
    )
    store.log(root, "interrupted" if interrupted else "end", done=summary.done, failed=summary.failed)
    if interrupted:
        raise Interrupted(summary)
    return summary


def _choose_models(setting: _Setting, started: float) -> _Setting:
    """Choose the models of a study with `accuracy`. Raises Interrupted."""
    root, study, options, workers, connect = setting
    try:
        test_connection = partial(_test_connection, connect)
        is_unsharded = options.shard == (1, 1)
        study_with_models = choose_models(
            study,
            root,
            workers,
            options.engine,
            run_trials=is_unsharded,
            shown=options.progress,
            before_trials=test_connection,
        )
    except TrialsInterrupted as interruption:
        raise Interrupted(interrupted_summary(study, root, interruption, time.perf_counter() - started)) from None
    return setting._replace(study=study_with_models)


def _compute(setting: _Setting, plan: Plan, tally: Tally, notes: list[str]) -> None:
    """Compute the remaining jobs on the workers of a scheduler or in processes of this machine."""
    root, _, options, workers, connect = setting

    def affordable_jobs() -> AffordableJobs:
        estimates = estimate_costs(load(options.engine.estimate), plan.pending, options.max_cpu)
        return select_affordable(plan.pending, estimates, options.max_cpu, options.progress)

    if connect is not None:
        with connect() as cluster:  # before the slow estimates, which may compile code
            affordable = affordable_jobs()
            notes += affordable.notes
            workers = cluster.wait_for_workers()
            works = _make_works(setting, affordable, workers, plan.holdings.units)
            _announce_cost(affordable, workers, options.progress)
            _track(works, cluster.outcomes(works), tally, options.progress)
        return
    with announcer(options.progress) as announcements:
        announcements.begin("estimating the cost of the jobs")
        affordable = affordable_jobs()
        notes += [*affordable.notes, *worker_note(affordable.costs, workers)]
        workers = workers_in_memory(affordable.costs, workers)
        works = _make_works(setting, affordable, workers, plan.holdings.units)
        _warm(root, options.engine, affordable.jobs, announcements)
    _announce_cost(affordable, workers, options.progress)
    _track(works, compute_outcomes(works, workers), tally, options.progress)


def _announce_cost(affordable: AffordableJobs, workers: int, shown: bool | None) -> None:
    """Print the estimated cost of the remaining jobs; shown: False to print nothing."""
    jobs = len(affordable.jobs)
    if jobs and shown is not False:
        cost = cost_text([job.case for job in affordable.jobs], affordable.costs, workers)
        say(f"{jobs} job{'s' * (jobs > 1)}: about {cost}", err=True)


def with_models(
    study: "Study", out: str | Path | None, jobs: int | None, run_trials: bool, engine: Engine = BEARINGSIM
) -> "Study":
    """Return the study with the models chosen in its results folder; unchanged if a case has no chosen model.

    run_trials: choose missing models by trials, and store the choice.
    """
    root = store.results_folder(study.name, study.quick, out)
    with _prepare(root, study, Options()) if run_trials else nullcontext(), suppress(MissingChoices):
        return choose_models(study, root, _count_workers(jobs), engine, run_trials=run_trials)
    return study


def _folder_notes(unplanned: int, damaged: Sequence[str]) -> Iterator[str]:
    """Yield notes on earlier results in the folder: jobs outside the plan, and damaged files."""
    if unplanned:
        jobs = f"{unplanned} job{'s' * (unplanned > 1)}"
        verb = "is" if unplanned == 1 else "are"
        yield f"{jobs} of an earlier plan {verb} not in the table; the results stay in units/"
    if damaged:
        files = f"1 damaged file ({damaged[0]})" if len(damaged) == 1 else f"{len(damaged)} damaged files"
        yield f"{files} renamed to .damaged; the results are computed again"


def _count_workers(requested: int | None) -> int:
    """Return the requested number of worker processes, or the number of CPUs. Raises ValueError below 1."""
    from joblib import cpu_count

    if requested is not None and requested < 1:
        raise ValueError(f"expected at least 1 worker process, got {requested}")
    return requested or int(cpu_count())


def _make_connector(scheduler: str | None) -> "Callable[[], AbstractContextManager[Cluster]] | None":
    """Return a function that connects to the workers of a scheduler; None without a scheduler.

    Raises UserError if a required package is missing.
    """
    if scheduler is None:
        return None
    try:
        from bearingsim.runner.cluster import connect_cluster
    except ModuleNotFoundError as error:
        raise UserError(f"--scheduler needs `{error.name}`: pip install 'bearingsim[cluster]'") from None
    return partial(connect_cluster, scheduler)


def _test_connection(connect: "Callable[[], AbstractContextManager[Cluster]] | None") -> None:
    """Connect to the scheduler once, to report a wrong address before anything is computed or deleted."""
    if connect is not None:
        with connect():
            pass


def _test_workers(workers: int, connect: "Callable[[], AbstractContextManager[Cluster]] | None") -> None:
    """Check that workers can be reached or started. Raises SchedulerUnreachable, NoSharedMemory."""
    _test_connection(connect)
    if connect is None and workers > 1:
        flag_for_workers()


@contextmanager
def _prepare(root: Path, study: "Study", options: Options) -> Iterator[None]:
    """Claim the folder, clear it for a fresh start, and mark it as in use within the context."""
    store.claim_results(root, study.name, bool(study.quick), options.fresh)
    store.refuse_links(root)
    store.refuse_own_study_file(root, study)
    store.remove_leftovers(root)
    message = store.discard(root, study.name) if options.fresh else ""
    if message and options.progress is not False:
        say(message, err=True)
    with store.in_use(root):
        store.claim_results(root, study.name, bool(study.quick))  # again, because another run could clear it
        yield


def _make_works(
    setting: _Setting, affordable: AffordableJobs, workers: int, known_units: frozenset[str]
) -> list[Work]:
    """Pack the remaining jobs into units of work; known_units: units in the folder when the jobs were planned.

    Raises DiskFull if the disk has too little space even for well compressed series.
    """
    root, options, provenance = setting.root, setting.options, store.provenance(setting.study)
    units = pack(affordable.jobs, affordable.costs, workers)
    others = OtherRuns(root, known_units)
    works = [
        Work(
            root,
            tuple(affordable.jobs[i] for i in unit),
            tuple(affordable.costs[i].seconds for i in unit),
            options.engine,
            provenance,
            sum(affordable.costs[i].bytes for i in unit),
            options.max_cpu,
            options.max_failures,
            others,
            {affordable.jobs[i].id: affordable.costs[i].spent for i in unit},
        )
        for unit in units
    ]
    store.check_free_space(root, MIN_COMPRESSION * sum(work.bytes for work in works))
    return works


def _warm(root: Path, engine: Engine, affordable: Sequence["Job"], announcements: Announcer) -> None:
    """Compile before workers start. Errors are only logged, because the jobs raise them again."""
    try:
        load(engine.warm)([job.case for job in affordable], compilation_callback(announcements))
    except Exception as error:
        store.log(root, "warm-up failed", reason=f"{type(error).__name__}: {error}")


def _track(
    works: Sequence[Work], outcomes: Generator[Outcome, None, None], tally: Tally, shown: bool | None
) -> None:
    """Add the outcome of each unit of work to the tally on completion, and show the progress."""
    estimates = {job.id: seconds for work in works for job, seconds in zip(work.jobs, work.seconds, strict=True)}
    display = shown_progress(shown, len(estimates), sum(estimates.values()))
    with display as report, stop_switch() as stop, closing(outcomes) as results:
        for outcome in results:
            tally.add(outcome)
            if tally.has_reached_limit:
                stop()
            done = (*outcome.done, *outcome.done_by_others)
            ids = [*done, *(failure.job for failure in outcome.failed)]
            report(len(done), len(outcome.failed), sum(estimates[job] for job in ids))
