"""Computing units of work by the workers of a dask scheduler, on other machines, with no disk in common.

What a worker does is in ``delivery.py``. Only this process writes into the results folder. A worker never chooses:
a case travels with its model.
"""

import asyncio
import pickle
import time
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import partial
from itertools import count, islice
from queue import Empty, SimpleQueue
from secrets import token_hex
from typing import Any, NamedTuple

import dask.config
from distributed import Client, Future, KilledWorker
from distributed.comm.core import CommClosedError

from bearingsim import store
from bearingsim.errors import UserError
from bearingsim.runner.delivery import (
    LOADING,
    Delivery,
    OtherInstallation,
    Parcel,
    WorkerFailed,
    deliver,
    installation,
    needed,
    refuse_installation,
    refuse_threads,
    stop,
)
from bearingsim.runner.handshake import SchedulerGone, client_of, within
from bearingsim.runner.pool import RESTARTS_WITHOUT_PROGRESS, WorkersDie
from bearingsim.runner.stopping import asked, heeding
from bearingsim.runner.work import Outcome, Work
from bearingsim.text.terminal import say

__all__ = ["Cluster", "SchedulerGone", "joined"]

EACH, LEAST = 4, 16
"""Units that are under way for each worker, and at least: what is on its way keeps none waiting."""
BATCH, BATCH_BYTES = 64, 64e6
"""Units, and bytes of their series, that are fetched at once: they pass through the scheduler."""
SEALING = 8
"""Files that are written at a time."""
WAITING_S, LOOK_S = 0.2, 2.0
"""Between looks whether something has come back, or the first worker; and at who works."""
ANSWER_S, WORKERS_S = 20.0, 300.0
"""How long a scheduler may take to answer a question; workers, the first of which load the program."""
ADVICE = (
    "no job is blamed; the workers' logs may tell why, and the workers may need more memory"
    " (`dask worker --memory-limit`)"
)


@contextmanager
def joined(address: str) -> Iterator["Cluster"]:
    """The workers of the scheduler at ``tcp://HOST:PORT``. Raises SchedulerGone if none answers there in time."""
    with client_of(address) as client:
        yield Cluster(client, address)


class Killed(NamedTuple):
    """The worker at ``address`` died, and had the work."""

    work: Work
    address: str


class Cluster:
    """The workers of a scheduler, as they come and go, for one run."""

    def __init__(self, client: Client, address: str) -> None:
        """Raises OtherInstallation if this process is not as a worker must be."""
        self.client, self.address, self.run, self.installed = client, address, token_hex(8), needed()
        self.landed: SimpleQueue[Future] = SimpleQueue()
        self.lost: list[Future] = []
        self.looked, self.count, self.deaths, self.alone, self.number = 0.0, 0, 0, False, count()

    def assembled(self) -> int:
        """How many workers there are, once there is one. Raises OtherInstallation for one that does not fit."""
        with self._reached():
            while not self.count:
                self._look()
                time.sleep(WAITING_S)
            for address, threads in within(ANSWER_S, self.client.nthreads).items():
                refuse_threads(address, threads)
            self._told(asyncio.to_thread, exec, LOADING, {})
            for address, found in self._told(installation).items():
                refuse_installation(address, found, self.installed)
        return self.count

    @property
    def workers(self) -> int:
        """How many there are; 1 while there is none."""
        return max(1, self.count)

    def outcomes(self, works: Sequence[Work]) -> Generator[Outcome, None, None]:
        """Let units of work be computed; seal what comes back, and yield what became of each, as they come.

        A worker that dies names no culprit among the jobs that it was given: these are computed once more at the
        end, each alone on its worker, and one whose worker dies again becomes a failure. Raises WorkersDie if that
        goes on with nothing finished between, SchedulerGone, OtherInstallation, WorkerFailed.
        """
        if not works:
            return
        suspects: list[Work] = []
        marker = store.start_marker(works[0].root, works[0].unit)  # nobody clears the folder meanwhile
        with heeding(), self._reached(), marker:
            for found in self._computed(works, at_once=None):
                if isinstance(found, Outcome):
                    yield found
                else:
                    suspects += [found.work.only([job.id]) for job in found.work.jobs]
            yield from self._apart(suspects)

    def _apart(self, suspects: Sequence[Work], one_by_one: bool = False) -> Iterator[Outcome]:
        """Compute jobs whose worker died, each on a worker of its own; what had company there is tried again."""
        blamed: list[Outcome] = []
        again: list[Work] = []
        while suspects and not asked():
            size = 1 if one_by_one else self.workers
            now, suspects = suspects[:size], suspects[size:]
            killed: list[Killed] = []
            for found in self._computed(now, at_once=size):
                if isinstance(found, Outcome):
                    yield from blamed
                    blamed.clear()
                    yield found
                else:
                    killed.append(found)
            beside = Counter(one.address for one in killed)
            blamed += [_blamed(one) for one in killed if beside[one.address] == 1]
            again += [one.work for one in killed if beside[one.address] > 1]
        yield from blamed
        if again:
            yield from self._apart(again, one_by_one=True)

    def _computed(self, works: Iterable[Work], at_once: int | None) -> "Iterator[Outcome | Killed]":
        """What became of units, a bounded number of which is under way; at_once: that, or as suits the workers."""
        waiting, flying, stopping = iter(works), dict[Future, Work](), False
        while True:
            looked = self._look()
            if not asked():
                room = (at_once or max(LEAST, EACH * self.workers)) - len(flying)
                flying |= self._sent(list(islice(waiting, max(room, 0))))
            elif looked or not stopping:
                stopping = True
                self._stop(flying)
            if not flying:
                return
            yield from self._received(flying)

    def _sent(self, works: Sequence[Work]) -> dict[Future, Work]:
        if not works:
            return {}
        parcels = [Parcel(pickle.dumps(_short(work)), _scans(work), self.run, self.installed) for work in works]
        names = [(f"bearingsim-{self.run}", next(self.number)) for _ in works]  # of one group: they queue up
        with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1 GB"}):  # scans are large
            futures = self.client.map(deliver, parcels, key=names, pure=False, retries=0)
        for future in futures:
            future.add_done_callback(self.landed.put)
        return dict(zip(futures, works, strict=True))

    def _stop(self, flying: dict[Future, Work]) -> None:
        """Let no worker begin anything more, nor one that has come since; take back what none has."""
        with suppress(TimeoutError):  # who does not answer is told again
            within(ANSWER_S, partial(self.client.run, stop, self.run, on_error="ignore"))
        held = {key for keys in within(ANSWER_S, self.client.processing).values() for key in keys}
        places = within(ANSWER_S, partial(self.client.who_has, list(flying)))
        held |= {key for key, workers in places.items() if workers}  # done since
        left = [one for one in flying if one.key not in held]
        if left:
            within(ANSWER_S, partial(self.client.cancel, left))
        for one in left:
            del flying[one]

    def _received(self, flying: dict[Future, Work]) -> "Iterator[Outcome | Killed]":
        """What has come back, and is no longer under way."""
        done = {one: one.status for one in self._landed(flying)}
        if "cancelled" in done.values():  # by the client, which has lost the scheduler
            raise CommClosedError
        self.lost += [one for one, status in done.items() if status not in ("finished", "error")]  # died just now
        fetched = self._fetched([one for one, status in done.items() if status == "finished"])
        for one, delivery in fetched.items():
            _refuse_others(flying[one], delivery)
        files = [
            (work.root, *file)
            for one, work in [(one, flying.pop(one)) for one in fetched]
            for file in fetched[one].files.items()
        ]
        if files:
            with ThreadPoolExecutor(SEALING) as threads:  # a disk says only after a while that it has a file
                list(threads.map(store.take_unit, *zip(*files, strict=True)))
        for delivery in fetched.values():
            self.deaths = 0
            yield delivery.outcome
        killed = [Killed(flying.pop(one), self._death(one)) for one, status in done.items() if status == "error"]
        if killed:
            self._count_deaths(killed)
        yield from killed

    def _landed(self, flying: Mapping[Future, Work]) -> list[Future]:
        """Units that are back, or will not come: a batch of them, none if nothing happens for a while."""
        found: list[Future] = []
        size = 0.0
        with suppress(Empty):
            while len(found) < BATCH and size < BATCH_BYTES:
                one = self.landed.get(timeout=0.0 if found else WAITING_S)
                if one in flying:  # and not taken back
                    found.append(one)
                    size += flying[one].bytes
        return found

    def _fetched(self, done: Sequence[Future]) -> dict[Future, Delivery]:
        """What workers gave back. Who dies before has worked in vain, and the scheduler has it done anew.

        Not by ``Client.gather``, which waits until that is done.
        """
        wanted = {one.key: one for one in done}
        while wanted:
            gather = partial(self.client.sync, self.client.scheduler.gather, keys=list(wanted))
            answer = within(WORKERS_S, gather)
            if answer["status"] == "OK":
                return {wanted[key]: delivery for key, delivery in answer["data"].items()}
            self.lost += [wanted.pop(key) for key in answer["keys"]]
        return {}

    def _death(self, future: Future) -> str:
        """The address of the worker that died of a unit; raises what else is the matter."""
        error = future.exception()
        if isinstance(error, KilledWorker):
            return str(error.last_worker.address)
        if isinstance(error, (ImportError, AttributeError)) and not isinstance(error, UserError):
            raise OtherInstallation(
                f"a worker cannot load a unit ({error}): is the same bearingsim there?"
            ) from error
        raise error

    def _count_deaths(self, killed: Sequence[Killed]) -> None:
        """Raises WorkersDie if too many have died since something was finished."""
        for one in killed:
            suspects = sorted(job.id for job in one.work.jobs)
            store.log(one.work.root, "worker died", worker=one.address, suspects=suspects)
        self.deaths += len({one.address for one in killed})
        if self.deaths >= RESTARTS_WITHOUT_PROGRESS * self.workers:
            raise WorkersDie(f"{self.deaths} workers died at work, with nothing finished between: {ADVICE}")

    def _look(self) -> bool:
        """See now and then who works, and say so when nobody does; whether it was time to.

        What was lost with a worker is then looked at again, too.
        """
        if time.monotonic() - self.looked < LOOK_S:
            return False
        self.count, self.looked = len(within(ANSWER_S, self.client.nthreads)), time.monotonic()
        if not self.count and not self.alone:
            told = (
                f"no worker is at {self.address}: waiting (`dask worker {self.address} --nthreads 1` starts one)"
            )
            say(told, err=True)
        self.alone = not self.count
        while self.lost:
            self.landed.put(self.lost.pop())
        return True

    def _told(self, function: Callable, *arguments: Any) -> dict[str, Any]:
        """What a function gives on each worker, by address; who dies meanwhile is left out.

        Raises OtherInstallation where it fails.
        """
        try:
            told = within(WORKERS_S, partial(self.client.run, function, *arguments, on_error="return"))
        except TimeoutError:
            silent = f"of {self.count} workers some do not answer within {WORKERS_S:.0f} s"
            raise WorkerFailed(f"{silent}: end those whose logs stand still") from None
        for address, found in told.items():
            if isinstance(found, Exception) and not isinstance(found, OSError):  # which a lost worker is
                raise OtherInstallation(f"worker {address} cannot load bearingsim: {found}")
        return {address: found for address, found in told.items() if not isinstance(found, OSError)}

    @contextmanager
    def _reached(self) -> Iterator[None]:
        """Say it by name if the scheduler is lost."""
        try:
            yield
        except Exception as error:
            lost = self.client.status != "running" or isinstance(error, (CommClosedError, TimeoutError))
            if isinstance(error, UserError) or not lost:
                raise
            silent = isinstance(error, TimeoutError)
            lost = f"the scheduler at {self.address} " + ("does not answer" if silent else "is gone")
            kept = "what has come back is stored, what was under way is not"
            advice = "start it and its workers, and give the command again"
            raise SchedulerGone(f"{lost}: {kept}; {advice}") from error


def _blamed(killed: Killed) -> Outcome:
    (job,) = killed.work.jobs
    failure = store.Failure(
        job=job.id,
        reason="its worker died",
        advice=f"the log of {killed.address} may tell why; if memory was short, try a shorter duration",
        attempts=2,
    )
    return Outcome(unit=killed.work.unit, done=(), failed=(failure,))


def _refuse_others(work: Work, delivery: Delivery) -> None:
    """Raises WorkerFailed if a delivery tells of jobs that were not sent."""
    outcome = delivery.outcome
    if not {*outcome.done, *(one.job for one in outcome.failed)} <= {job.id for job in work.jobs}:
        raise WorkerFailed(f"unit {work.unit} came back from its worker with jobs that were not sent")


def _short(work: Work) -> Work:
    """The work as it travels: scans are named as results name them, for a worker has another working folder."""
    jobs = tuple(replace(job, case=store.with_short_paths(job.case)) for job in work.jobs)
    return replace(work, others=None, jobs=jobs)


def _scans(work: Work) -> dict[str, bytes]:
    """The scans that a work needs, by the names under which the results folder keeps them."""
    return store.kept_scans(work.root, [job.case for job in work.jobs])
