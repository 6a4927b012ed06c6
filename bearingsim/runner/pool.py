"""Computation of units of work, in this process or in a pool that is restarted when a worker dies."""

import os
import re
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from itertools import takewhile
from pathlib import Path
from typing import Any

from bearingsim.errors import UserError
from bearingsim.runner.stopping import (
    check_shared_memory,
    defer_signals,
    flag_for_workers,
    ignore_signals,
    stop_requested,
)
from bearingsim.runner.work import Outcome, Work, compute, die_with_parent
from bearingsim.store import Failure, log, take_suspects

RESTARTS_WITHOUT_PROGRESS = 3
"""Number of worker deaths without a result in between that ends the run."""
ADVICE = "no job counts as failed; run again, with fewer --jobs if memory was short"


class RepeatedWorkerDeaths(UserError):
    """Worker processes die repeatedly, and no single job can be the cause."""


class DeathCounter:
    """Count of worker deaths since the last result: the third in a row cannot be due to a single job."""

    def __init__(self, root: Path, activity: str) -> None:
        """Set the count to zero.

        root: folder of the journal; activity: activity of the workers, for messages.
        """
        self.root, self.activity, self.count = root, activity, 0

    def add(self, death: BrokenProcessPool, suspects: Iterable[str] = ()) -> None:
        """Count a death; suspects: jobs running then. Raises RepeatedWorkerDeaths at the third in a row."""
        self.count += 1
        cause = _exit_codes(death)
        log(self.root, "worker died", exit=cause, suspects=sorted(suspects))
        if self.count == RESTARTS_WITHOUT_PROGRESS:
            count_text = f"{RESTARTS_WITHOUT_PROGRESS} times without finishing a job"
            raise RepeatedWorkerDeaths(
                f"worker processes died {self.activity} {count_text} ({cause}): {ADVICE}"
            ) from death

    def reset(self) -> None:
        """Reset the count after a result."""
        self.count = 0


def compute_outcomes(works: Sequence[Work], workers: int) -> Generator[Outcome, None, None]:
    """Compute units of work and yield the outcome of each, in order of completion.

    One worker means this process; several are always separate processes, even for one unit. The death of a worker
    ends the pool, and any of the running jobs may be the cause. They are therefore repeated at the end, one at a
    time, and a job whose worker dies again becomes a failure. Raises RepeatedWorkerDeaths after three deaths
    without a result in between.
    """
    if workers == 1 or not works:
        yield from _compute_serially(works)
        return
    pending, suspect_works = list(works), list[Work]()
    deaths = DeathCounter(works[0].root, "at work")
    while pending:
        finished_units: set[str] = set()
        try:
            for outcome in _compute_in_pool(pending, workers):
                finished_units.add(outcome.unit)
                deaths.reset()
                yield outcome
            pending = []
        except BrokenProcessPool as death:
            pending = [work for work in pending if work.unit not in finished_units]
            suspect_ids = take_suspects(pending[0].root, [work.unit for work in pending])
            stored_ids = _stored_ids(pending)
            for outcome in _stored_outcomes(pending, stored_ids):
                deaths.reset()
                yield outcome
            suspect_ids -= stored_ids
            deaths.add(death, suspect_ids)
            suspect_works += [work.subset([job]) for work in pending for job in _job_ids(work) & suspect_ids]
            remaining = (work.subset(_job_ids(work) - suspect_ids - stored_ids) for work in pending)
            pending = [work for work in remaining if work.jobs]
    yield from _compute_one_by_one(suspect_works, deaths, workers)


def _stored_ids(works: Sequence[Work]) -> set[str]:
    """Return the stored jobs of units whose outcomes were lost with the pool."""
    others = works[0].others
    return set() if others is None else others.list_jobs() & {job.id for work in works for job in work.jobs}


def _stored_outcomes(works: Sequence[Work], stored_ids: set[str]) -> Iterator[Outcome]:
    """Yield an outcome for each unit with stored jobs, whose CPU times are unknown."""
    for work in works:
        done = tuple(job.id for job in work.jobs if job.id in stored_ids)
        if done:
            yield Outcome(work.unit, done, ())


def _compute_serially(works: Sequence[Work]) -> Iterator[Outcome]:
    """Compute units of work in this process, one after another; failures count over all units."""
    failed = 0
    # A generator, because `failed` increases while it is evaluated.
    arguments = ((replace(work, max_failures=work.max_failures - failed),) for work in works)
    for outcome in map_unordered(compute, arguments, workers=1):
        failed += len(outcome.failed)
        yield outcome


def _compute_one_by_one(works: Sequence[Work], deaths: DeathCounter, workers: int) -> Iterator[Outcome]:
    """Compute jobs one at a time, so that a worker death is due to one job, unless three follow each other."""
    failures: list[Outcome] = []
    for work in takewhile(lambda _: not stop_requested(), works):
        try:
            outcome = next(iter(list(_compute_in_pool([work], workers))))
        except BrokenProcessPool as death:
            take_suspects(work.root, [work.unit])
            deaths.add(death, _job_ids(work))
            failures.append(_failed_outcome(work, death))
            continue
        deaths.reset()
        yield from failures
        failures.clear()
        yield outcome
    yield from failures


def _failed_outcome(work: Work, death: BrokenProcessPool) -> Outcome:
    failure = Failure(
        job=work.jobs[0].id,
        reason=f"the worker process died: {_exit_codes(death)}",
        advice="if it was killed for memory, try fewer workers (--jobs) or a shorter duration",
        attempts=2,
    )
    return Outcome(unit=work.unit, done=(), failed=(failure,))


def _job_ids(work: Work) -> set[str]:
    return {job.id for job in work.jobs}


def _compute_in_pool(works: Sequence[Work], workers: int) -> Generator[Outcome, None, None]:
    """Yield outcomes in order of completion. Raises BrokenProcessPool if a worker dies, which ends the pool.

    There are at least two worker processes, because one would mean this process.
    """
    yield from map_unordered(compute, [(work,) for work in works], max(2, min(workers, len(works))))


def map_unordered(function: Callable, arguments: Iterable[tuple], workers: int) -> Generator[Any, None, None]:
    """Yield the result of a function for each tuple of arguments, in order of completion.

    workers: number of processes; 1 means this process. After a signal the running calls finish, then Signalled is
    raised, also if a worker has died by then. Raises BrokenProcessPool if a worker dies before a stop is
    requested.
    """
    with defer_signals():
        if workers == 1:
            # `map` would end silently at a StopIteration raised by the function.
            for values in _until_stop(arguments):
                yield function(*values)
        else:
            try:
                yield from _map_in_workers(function, arguments, workers)
            except BrokenProcessPool:
                if not stop_requested():  # after a stop request nothing is repeated
                    raise


def _map_in_workers(function: Callable, arguments: Iterable[tuple], workers: int) -> Generator[Any, None, None]:
    from joblib import Parallel, delayed, parallel_config

    _ignore_replaced_workers()
    initargs = (os.getpid(), flag_for_workers())
    with parallel_config("loky", inner_max_num_threads=1, initializer=die_with_parent, initargs=initargs):
        pool = Parallel(n_jobs=workers, return_as="generator_unordered", batch_size=1, max_nbytes=None)
    with check_shared_memory(), ignore_signals():
        results = pool(delayed(function)(*values) for values in _until_stop(arguments))
    try:
        yield from results
    finally:
        with warnings.catch_warnings():  # joblib warns of results that are not consumed
            warnings.simplefilter("ignore")
            results.close()


def map_in_new_processes(function: Callable, arguments: Iterable[tuple], workers: int) -> Iterator[Any]:
    """Yield the result of a function for each tuple of arguments, in order of completion, from a new pool.

    For functions that compile: only the end of a process frees the memory of a compiler. After a signal the
    running calls finish, then Signalled is raised. Raises BrokenProcessPool if a process dies before.
    """
    from joblib.externals.loky import ProcessPoolExecutor, as_completed

    _ignore_replaced_workers()
    identity = (os.getpid(), flag_for_workers())
    with defer_signals():
        with check_shared_memory(), ignore_signals():
            pool = ProcessPoolExecutor(workers, initializer=die_with_parent, initargs=identity)
            calls = [pool.submit(function, *values) for values in arguments]
        try:
            for call in as_completed(calls):
                yield call.result()
                if stop_requested():
                    break
        except BrokenProcessPool:
            if not stop_requested():
                raise
        finally:
            for call in calls:
                call.cancel()
            pool.shutdown()


def _ignore_replaced_workers() -> None:
    """Ignore loky's warning that it replaces a worker whose memory has grown, which loses no result.

    Where warnings are errors, it would end the thread that collects results, and the pool would wait forever.
    """
    warnings.filterwarnings("ignore", message="A worker stopped while some jobs", category=UserWarning)


def _until_stop(arguments: Iterable[tuple]) -> Iterator[tuple]:
    """Yield arguments until a stop is requested."""
    return takewhile(lambda _: not stop_requested(), arguments)


def _exit_codes(death: BrokenProcessPool) -> str:
    """Extract the exit codes of dead workers from loky's message, such as ``SIGKILL(-9)``."""
    match = re.search(r"\{(.+?)\}", str(death))
    return match[1] if match else type(death).__name__
