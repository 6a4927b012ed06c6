"""Computing units of work by the workers of a dask scheduler, on other machines, with no disk in common.

A worker gets a unit as a value, computes it, and gives back the bytes of the files that are to hold it. Only this
process writes into the results folder. A worker never chooses: a case travels with its model.
"""

import asyncio
import hashlib
import os
import pickle
import platform
import socket
import sys
import threading
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import cache
from itertools import count, islice
from pathlib import Path
from queue import Empty, SimpleQueue
from secrets import token_hex
from typing import TYPE_CHECKING, Any

from distributed import Client, Future, KilledWorker, SchedulerPlugin, get_worker
from distributed.comm.core import CommClosedError

from bearingsim import store
from bearingsim.errors import UserError
from bearingsim.runner.pool import RESTARTS_WITHOUT_PROGRESS, WorkersDie
from bearingsim.runner.stopping import asked, heed, heeding
from bearingsim.runner.work import Outcome, Work, compute
from bearingsim.store.provenance import versions

if TYPE_CHECKING:
    from distributed import Scheduler

    from bearingsim.simulation.simulate import Record
    from bearingsim.store.columns import Value
    from bearingsim.study import Job

__all__ = ["Cluster", "OtherInstallation", "SchedulerGone", "installation", "joined"]

EACH, LEAST = 4, 16
"""Units that are under way for each worker, and at least: what is on its way keeps none waiting."""
BATCH, BATCH_BYTES = 64, 64e6
"""Units, and bytes of their series, that are fetched at once: they pass through the scheduler."""
SEALING = 8
"""Files that are written at a time."""
WAITING_S, LOOK_S = 0.2, 2.0
"""Between looks whether something has come back, or the first worker; and at who works."""
JOINING_S = 30.0
"""How long a scheduler may take to answer."""
CLOSING_S = 3.0
THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")
LOADING = "import bearingsim.runner.cluster"
"""What takes seconds at first, and so is done beside the thread in which a worker says that it is alive."""
SOURCES = (".py", ".csv")
ADVICE = "no job is blamed; their logs may tell why, and they may need more memory (`dask worker --memory-limit`)"


class OtherInstallation(UserError):
    """A worker would not compute what this process computes, or not as it is meant to."""


class SchedulerGone(UserError):
    """Nobody answers where the scheduler was."""


class WorkerFailed(UserError):
    """A worker cannot go on, for a reason that lies in its machine."""


# On a worker


@dataclass(frozen=True)
class Parcel:
    """What a worker is sent: the work, pickled; the scans that its cases name, by digest; whose run it belongs to;
    and what must be installed there."""

    work: bytes
    scans: Mapping[str, bytes]
    run: str
    installed: Mapping[str, str]


@dataclass(frozen=True)
class Delivery:
    """What a worker gives back: what became of a unit, and the unit files that hold it, by name."""

    outcome: Outcome
    files: Mapping[str, bytes]


@cache
def installation() -> dict[str, str]:
    """What must be the same wherever jobs of one study are computed, by its name."""
    from bearingsim.catalogue import extension_digest
    from bearingsim.core import MODEL_VERSION

    threads = {os.environ.get(name, "any number of") for name in THREADS}
    return {
        "Python": platform.python_version(),
        **versions(),
        "model version": str(MODEL_VERSION),
        "sources of bearingsim": _sources(),
        "extensions": extension_digest(),
        "threads of linear algebra": " or ".join(sorted(threads)),
    }


def needed() -> dict[str, str]:
    """What a worker must have: what is here, and one thread, for with more sums are rounded otherwise."""
    return installation() | {"threads of linear algebra": "1"}


def _sources() -> str:
    """First 12 hex digits of SHA-256 over the program: a checkout may have changed while its version has not."""
    package, digest = Path(__file__).parents[1], hashlib.sha256()
    for path in sorted(path for path in package.rglob("*") if path.suffix in SOURCES):
        digest.update(path.relative_to(package).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()[:12]


def differences(there: Mapping[str, str], here: Mapping[str, str]) -> str:
    """What is not the same, in words; empty if nothing is."""
    names = dict.fromkeys((*here, *there))
    return ", ".join(
        f"{name} {there.get(name, 'absent')} in place of {here.get(name, 'none')}"
        for name in names
        if there.get(name) != here.get(name)
    )


def _refuse(address: str, there: Mapping[str, str], here: Mapping[str, str]) -> None:
    """Raises OtherInstallation if a worker differs."""
    other = differences(there, here)
    if other:
        raise OtherInstallation(
            f"worker {address}: {other} (a worker has all as it is where `bearingsim run` is given)"
        )


_stops: defaultdict[str, threading.Event] = defaultdict(threading.Event)
"""In a worker, by run: whether it has been asked to stop."""


def stop(run: str) -> None:
    """In a worker: of this run nothing more is begun."""
    _stops[run].set()


def deliver(parcel: Parcel) -> Delivery:
    """In a worker: compute a unit. Raises OtherInstallation, WorkerFailed, and what is a bug."""
    worker = get_worker()
    _refuse(worker.address, installation(), parcel.installed)
    heed(_stops[parcel.run])
    work: Work = pickle.loads(parcel.work)
    folder, files = Path(worker.local_directory), dict[str, bytes]()
    made_by = {**work.provenance, "host": socket.gethostname(), "platform": platform.platform()}

    def seal(_: Path, done: "Sequence[tuple[Job, Record]]", provenance: "Mapping[str, Value]") -> None:
        files.update(store.sealed_units(done, provenance))

    try:
        with _brought(parcel.scans, folder):
            return Delivery(compute(replace(work, root=folder, provenance=made_by), seal), files)
    except (UserError, OSError) as error:  # its disk is full
        raise WorkerFailed(f"worker {worker.address}: {error}") from None


@contextmanager
def _brought(scans: Mapping[str, bytes], folder: Path) -> Iterator[None]:
    """Scans that came with the work lie in a folder, and are found there."""
    from bearingsim.config.scan.file import BROUGHT

    for name, content in scans.items():
        path = folder / "scans" / name
        if not path.exists():
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(content)
        BROUGHT[path.stem] = path
    try:
        yield
    finally:
        BROUGHT.clear()


# At the scheduler


def back_at_first_death() -> SchedulerPlugin:
    """By it a unit whose worker dies comes back at once: it is not handed on to kill the next.

    A class made here travels whole, and so the scheduler needs no bearingsim.
    """

    class BackAtFirstDeath(SchedulerPlugin):
        name = "bearingsim"
        idempotent = True  # one serves all runs

        def update_graph(self, scheduler: "Scheduler", **told: Any) -> None:
            for key in told["tasks"]:
                if isinstance(key, tuple) and str(key[0]).startswith(
                    "bearingsim-"
                ):  # as if it had died as often as it may
                    scheduler.tasks[key].suspicious = scheduler.allowed_failures

    return BackAtFirstDeath()


# Here


@contextmanager
def joined(address: str) -> Iterator["Cluster"]:
    """The workers of the scheduler at ``tcp://HOST:PORT``. Raises SchedulerGone if nobody answers there."""
    try:
        client = Client(address, timeout=JOINING_S, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:  # no such scheme, no certificates
        advice = "`dask scheduler` starts one, and tells its address"
        raise SchedulerGone(f"no scheduler answers at {address} ({error}): {advice}") from None
    try:
        yield Cluster(client, address)
    finally:
        with suppress(TimeoutError):  # who is gone says no goodbye
            client.close(timeout=CLOSING_S)


class Killed(Exception):
    """The worker at ``address`` died, and had the unit."""

    def __init__(self, work: Work, address: str) -> None:
        super().__init__(work, address)
        self.work, self.address = work, address


class Cluster:
    """The workers of a scheduler, as they come and go, for one run."""

    def __init__(self, client: Client, address: str) -> None:
        """Take on the workers that are there. Raises OtherInstallation for one that does not fit."""
        self.client, self.address, self.run, self.installed = client, address, token_hex(8), needed()
        self.landed: SimpleQueue[Future] = SimpleQueue()
        self.looked, self.count, self.deaths, self.alone, self.number = 0.0, 0, 0, False, count()
        with self._reached():
            self._check()
            client.register_plugin(back_at_first_death())

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
            self._look()
            if not asked():
                room = (at_once or max(LEAST, EACH * self.workers)) - len(flying)
                flying |= self._sent(list(islice(waiting, max(room, 0))))
            elif not stopping:
                stopping = True
                self._run(stop, self.run)
            if not flying:
                return
            yield from self._received(flying)

    def _sent(self, works: Sequence[Work]) -> dict[Future, Work]:
        if not works:
            return {}
        parcels = [Parcel(pickle.dumps(_short(work)), _scans(work), self.run, self.installed) for work in works]
        names = [(f"bearingsim-{self.run}", next(self.number)) for _ in works]  # of one group: they queue up
        futures = self.client.map(deliver, parcels, key=names, pure=False, retries=0)
        for future in futures:
            future.add_done_callback(self.landed.put)
        return dict(zip(futures, works, strict=True))

    def _received(self, flying: dict[Future, Work]) -> "Iterator[Outcome | Killed]":
        """What has come back, and is no longer under way."""
        done = self._landed(flying)
        fetched = dict(self._fetched([one for one in done if one.status == "finished"]))
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
        killed = [Killed(flying.pop(one), self._death(one)) for one in done if one.status == "error"]
        if killed:
            self._count_deaths(killed)
        yield from killed

    def _landed(self, flying: Mapping[Future, Work]) -> list[Future]:
        """Units that are back, or will not come: a batch of them, none if nothing happens for a while."""
        found: list[Future] = []
        size = 0.0
        with suppress(Empty):
            while len(found) < BATCH and size < BATCH_BYTES:
                found.append(self.landed.get(timeout=0.0 if found else WAITING_S))
                size += flying[found[-1]].bytes
        if any(one.status in ("cancelled", "lost") for one in found):
            raise CommClosedError
        return found

    def _fetched(self, done: list[Future]) -> Iterator[tuple[Future, Delivery]]:
        """What workers gave back. Who dies before has worked in vain, and the scheduler has it done anew."""
        if not done:
            return
        found = self.client.gather({one.key: one for one in done}, errors="skip")
        for future in done:
            if future.key in found:
                yield future, found[future.key]
            else:
                future.add_done_callback(self.landed.put)

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

    def _look(self) -> None:
        """See now and then who works, and say so when nobody does."""
        if time.monotonic() - self.looked < LOOK_S:
            return
        self.count, self.looked = len(self.client.nthreads()), time.monotonic()
        if not self.count and not self.alone:
            told = (
                f"no worker is at {self.address}: waiting (`dask worker {self.address} --nthreads 1` starts one)"
            )
            print(told, file=sys.stderr, flush=True)
        self.alone = not self.count

    def _check(self) -> None:
        """Wait for the first worker. Raises OtherInstallation, if one does not fit."""
        while not self.count:
            self._look()
            time.sleep(WAITING_S)
        for address, threads in self.client.nthreads().items():
            if threads != 1:
                raise OtherInstallation(
                    f"worker {address} has {threads} threads, and a job takes a process: start it by"
                    f" `dask worker --nthreads 1 --nworkers {threads}`"
                )
        for address, found in self._run(asyncio.to_thread, exec, LOADING, {}).items():
            if isinstance(found, Exception):
                raise OtherInstallation(f"worker {address} cannot load bearingsim: {found}")
        for address, found in self._run(installation).items():
            _refuse(address, found, self.installed)

    def _run(self, function: Callable, *arguments: Any) -> dict[str, Any]:
        """What a function gives on each worker, or the error, by address."""
        return self.client.run(function, *arguments, on_error="return")

    @contextmanager
    def _reached(self) -> Iterator[None]:
        """Say it by name if the scheduler is lost."""
        try:
            yield
        except Exception as error:
            lost = self.client.status != "running" or isinstance(error, (CommClosedError, TimeoutError))
            if isinstance(error, UserError) or not lost:
                raise
            told = (
                f"the scheduler at {self.address} is gone: what has come back is stored, what was under way is not"
            )
            raise SchedulerGone(f"{told}; start it and its workers, and give the command again") from error


def _blamed(killed: Killed) -> Outcome:
    (job,) = killed.work.jobs
    failure = store.Failure(
        job=job.id,
        reason="its worker died",
        advice=f"the log of {killed.address} may tell why; if memory was short, try a shorter duration",
        attempts=2,
    )
    return Outcome(unit=killed.work.unit, done=(), failed=(failure,))


def _short(work: Work) -> Work:
    """The work as it travels: scans are named as results name them, for a worker has another working folder."""
    return replace(work, jobs=tuple(replace(job, case=store.with_short_paths(job.case)) for job in work.jobs))


def _scans(work: Work) -> dict[str, bytes]:
    """The scans that a work needs, by the names under which the results folder keeps them."""
    return store.kept_scans(work.root, [job.case for job in work.jobs])
