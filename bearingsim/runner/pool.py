"""Computing units of work, in this process or in a pool that survives the death of its workers."""

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
from bearingsim.runner.shared_memory import in_shared_memory
from bearingsim.runner.stopping import asked, flag_for_workers, heeding, ignoring
from bearingsim.runner.work import Outcome, Work, compute, die_with_parent
from bearingsim.store import Failure, log, take_suspects

__all__ = ["Deaths", "WorkersDie", "outcomes", "spread"]

RESTARTS_WITHOUT_PROGRESS = 3
ADVICE = "no job is blamed; run again, with fewer --jobs if memory was short"


class WorkersDie(UserError):
    """Worker processes die, and it is not for one job."""


class Deaths:
    """Deaths of workers since something was last finished: of the third no job is the cause."""

    def __init__(self, root: Path, doing: str) -> None:
        """root: whose journal tells of them; doing: what they were doing, in words."""
        self.root, self.doing, self.count = root, doing, 0

    def add(self, death: BrokenProcessPool, suspects: Iterable[str] = ()) -> None:
        """Take one in; suspects: jobs in hand then. Raises WorkersDie if it is one too many."""
        self.count += 1
        cause = _exit_codes(death)
        log(self.root, "worker died", exit=cause, suspects=sorted(suspects))
        if self.count == RESTARTS_WITHOUT_PROGRESS:
            often = f"{RESTARTS_WITHOUT_PROGRESS} times, with nothing finished between"
            raise WorkersDie(f"worker processes died {self.doing} {often} ({cause}): {ADVICE}") from death

    def end(self) -> None:
        """Something was finished."""
        self.count = 0


def outcomes(works: Sequence[Work], workers: int) -> Generator[Outcome, None, None]:
    """Compute units of work and yield what became of each, as they come.

    One worker means this process; more are always other processes, even for one unit. A worker that dies takes
    the pool with it and names no culprit: the jobs that were running then are computed at the end, one at a time,
    and the one that dies alone becomes a failure. Raises WorkersDie if nothing is finished between three deaths.
    """
    if workers == 1 or not works:
        yield from _in_turn(works)
        return
    waiting, suspected = list(works), list[Work]()
    deaths = Deaths(works[0].root, "at work")
    while waiting:
        returned: set[str] = set()
        try:
            for outcome in _in_pool(waiting, workers):
                returned.add(outcome.unit)
                deaths.end()
                yield outcome
            waiting = []
        except BrokenProcessPool as death:
            waiting = [work for work in waiting if work.unit not in returned]
            suspects = take_suspects(waiting[0].root, [work.unit for work in waiting])
            deaths.add(death, suspects)
            suspected += [work.only([job]) for work in waiting for job in _ids(work) & suspects]
            remaining = (work.only(_ids(work) - suspects) for work in waiting)
            waiting = [work for work in remaining if work.jobs]
    yield from _one_by_one(suspected, deaths, workers)


def _in_turn(works: Sequence[Work]) -> Iterator[Outcome]:
    """Compute units of work in this process, one after another: of the failures that end a run all count."""
    failed = 0
    given = ((replace(work, max_failures=work.max_failures - failed),) for work in works)  # made as each begins
    for outcome in spread(compute, given, workers=1):
        failed += len(outcome.failed)
        yield outcome


def _one_by_one(works: Sequence[Work], deaths: Deaths, workers: int) -> Iterator[Outcome]:
    """Compute jobs with nothing beside them: a death names its culprit, unless it is one of three in a row."""
    blamed: list[Outcome] = []
    for work in takewhile(lambda _: not asked(), works):
        try:
            outcome = next(iter(list(_in_pool([work], workers))))
        except BrokenProcessPool as death:
            take_suspects(work.root, [work.unit])
            deaths.add(death, _ids(work))
            blamed.append(_blamed(work, death))
            continue
        deaths.end()
        yield from blamed
        blamed.clear()
        yield outcome
    yield from blamed


def _blamed(work: Work, death: BrokenProcessPool) -> Outcome:
    failure = Failure(
        job=work.jobs[0].id,
        reason=f"the worker process died: {_exit_codes(death)}",
        advice="if it was killed for memory, try fewer workers (--jobs) or a shorter duration",
        attempts=2,
    )
    return Outcome(unit=work.unit, done=(), failed=(failure,))


def _ids(work: Work) -> set[str]:
    return {job.id for job in work.jobs}


def _in_pool(works: Sequence[Work], workers: int) -> Generator[Outcome, None, None]:
    """Outcomes in the order of completion. Raises BrokenProcessPool when a worker dies; all are dead then."""
    yield from spread(compute, [(work,) for work in works], max(2, min(workers, len(works))))


def spread(function: Callable, arguments: Iterable[tuple], workers: int) -> Generator[Any, None, None]:
    """What a function makes of each tuple of arguments, as it is done, by so many processes: one is this one.

    Raises Signalled, once what was in hand is done, if the program has been asked to stop meanwhile.
    """
    with heeding():
        if workers == 1:
            # Not `map`, which a StopIteration from within would end in silence.
            for given in _until_asked(arguments):
                yield function(*given)
        else:
            yield from _by_workers(function, arguments, workers)


def _by_workers(function: Callable, arguments: Iterable[tuple], workers: int) -> Generator[Any, None, None]:
    from joblib import Parallel, delayed, parallel_config

    given_them = (os.getpid(), flag_for_workers())
    with parallel_config("loky", inner_max_num_threads=1, initializer=die_with_parent, initargs=given_them):
        pool = Parallel(n_jobs=workers, return_as="generator_unordered", batch_size=1, max_nbytes=None)
    with in_shared_memory(), ignoring():
        results = pool(delayed(function)(*given) for given in _until_asked(arguments))
    try:
        yield from results
    finally:
        with warnings.catch_warnings():  # left early on purpose: joblib would say so
            warnings.simplefilter("ignore")
            results.close()


def _until_asked(arguments: Iterable[tuple]) -> Iterator[tuple]:
    """Nothing more is begun once the program has been asked to stop."""
    return takewhile(lambda _: not asked(), arguments)


def _exit_codes(death: BrokenProcessPool) -> str:
    """What loky tells of dead workers, such as ``SIGKILL(-9)``."""
    found = re.search(r"\{(.+?)\}", str(death))
    return found[1] if found else type(death).__name__
