"""Computation of units of work by the workers of a dask scheduler, on machines without a shared disk.

``delivery.py`` runs on the workers. Only this process writes into the results folder. The models are chosen
beforehand, so each case is sent with its model.
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
    IMPORT_STATEMENT,
    Delivery,
    InstallationMismatch,
    Parcel,
    WorkerFailed,
    deliver,
    installation,
    refuse_installation,
    refuse_threads,
    required_installation,
    stop,
)
from bearingsim.runner.handshake import SchedulerUnreachable, call_with_timeout, connect
from bearingsim.runner.pool import RESTARTS_WITHOUT_PROGRESS, RepeatedWorkerDeaths
from bearingsim.runner.stopping import defer_signals, stop_requested
from bearingsim.runner.work import Outcome, Work
from bearingsim.text.terminal import say

UNITS_PER_WORKER, MIN_UNITS = 4, 16
"""Numbers of units in progress, per worker and at least in total, so that no worker waits for its next unit."""
MAX_BATCH_UNITS, MAX_BATCH_BYTES = 64, 64e6
"""Number of units, and size (bytes) of their series, that end a batch fetched through the scheduler."""
WRITER_THREADS = 8
"""Number of threads that write unit files."""
POLL_S, WORKER_CHECK_S = 0.2, 2.0
"""Intervals (s) between checks for results or for the first worker, and between counts of the workers."""
SCHEDULER_TIMEOUT_S, WORKER_TIMEOUT_S = 20.0, 300.0
"""Deadlines (s) for an answer of the scheduler, and of the workers, which may have to import the program first."""
ADVICE = (
    "no job counts as failed; the workers' logs may show the reason, and the workers may need more memory"
    " (`dask worker --memory-limit`)"
)


@contextmanager
def connect_cluster(address: str) -> Iterator["Cluster"]:
    """Connect to the workers of the scheduler at ``tcp://HOST:PORT``.

    Raises SchedulerUnreachable if the scheduler does not answer in time.
    """
    with connect(address) as client:
        yield Cluster(client, address)


class KilledWork(NamedTuple):
    """Unit of work whose worker at ``address`` died."""

    work: Work
    address: str


class Cluster:
    """Workers of a scheduler during one run; workers may join and leave."""

    def __init__(self, client: Client, address: str) -> None:
        """Set up the run. Raises InstallationMismatch if this process uses several threads for linear algebra."""
        self.client, self.address, self.run_id, self.requirements = (
            client,
            address,
            token_hex(8),
            required_installation(),
        )
        self.finished: SimpleQueue[Future] = SimpleQueue()
        self.lost_futures: list[Future] = []
        self.checked_at, self.worker_count, self.has_no_workers = 0.0, 0, False
        self.deaths, self.key_numbers = 0, count()

    def wait_for_workers(self) -> int:
        """Wait for a worker, and return the number of workers.

        Raises InstallationMismatch if the installation of a worker differs from that of this process.
        """
        with self._convert_errors():
            while not self.worker_count:
                self._update_workers()
                time.sleep(POLL_S)
            for address, threads in call_with_timeout(SCHEDULER_TIMEOUT_S, self.client.nthreads).items():
                refuse_threads(address, threads)
            self._run_on_all(asyncio.to_thread, exec, IMPORT_STATEMENT, {})
            for address, versions in self._run_on_all(installation).items():
                refuse_installation(address, versions, self.requirements)
        return self.worker_count

    @property
    def workers(self) -> int:
        """Number of workers; 1 if there are none."""
        return max(1, self.worker_count)

    def outcomes(self, works: Sequence[Work]) -> Generator[Outcome, None, None]:
        """Compute units of work on the workers, store the results, and yield the outcomes in order of completion.

        If a worker dies, each job of its unit is repeated at the end, alone on a worker, because any of them may
        be the cause. A job whose worker dies again becomes a failure. Raises RepeatedWorkerDeaths if too many
        workers die without a result in between, SchedulerUnreachable, InstallationMismatch, WorkerFailed.
        """
        if not works:
            return
        suspects: list[Work] = []
        marker = store.start_marker(works[0].root, works[0].unit)  # so that the folder cannot be cleared
        with defer_signals(), self._convert_errors(), marker:
            for result in self._compute(works, max_in_progress=None):
                if isinstance(result, Outcome):
                    yield result
                else:
                    suspects += [result.work.subset([job.id]) for job in result.work.jobs]
            yield from self._compute_alone(suspects)

    def _compute_alone(self, suspects: Sequence[Work], one_by_one: bool = False) -> Iterator[Outcome]:
        """Compute jobs whose worker died, each alone on a worker.

        If a worker dies to which several were assigned, any may be the cause, so these are repeated one by one.
        """
        failures: list[Outcome] = []
        ambiguous: list[Work] = []
        while suspects and not stop_requested():
            size = 1 if one_by_one else self.workers
            batch, suspects = suspects[:size], suspects[size:]
            killed: list[KilledWork] = []
            for result in self._compute(batch, max_in_progress=size):
                if isinstance(result, Outcome):
                    yield from failures
                    failures.clear()
                    yield result
                else:
                    killed.append(result)
            per_worker = Counter(death.address for death in killed)
            failures += [_failed_outcome(death) for death in killed if per_worker[death.address] == 1]
            ambiguous += [death.work for death in killed if per_worker[death.address] > 1]
        yield from failures
        if ambiguous:
            yield from self._compute_alone(ambiguous, one_by_one=True)

    def _compute(self, works: Iterable[Work], max_in_progress: int | None) -> "Iterator[Outcome | KilledWork]":
        """Submit units, and yield the result of each.

        max_in_progress: largest number of submitted units; None chooses it from the number of workers.
        """
        pending, submitted, stopping = iter(works), dict[Future, Work](), False
        while True:
            updated = self._update_workers()
            if not stop_requested():
                free_slots = (max_in_progress or max(MIN_UNITS, UNITS_PER_WORKER * self.workers)) - len(submitted)
                submitted |= self._submit(list(islice(pending, max(free_slots, 0))))
            elif updated or not stopping:
                stopping = True
                self._stop(submitted)
            if not submitted:
                return
            yield from self._collect(submitted)

    def _submit(self, works: Sequence[Work]) -> dict[Future, Work]:
        if not works:
            return {}
        parcels = [
            Parcel(pickle.dumps(_strip(work)), _scans(work), self.run_id, self.requirements) for work in works
        ]
        # The scheduler queues the tasks of one group, whose keys begin with the same string.
        keys = [(f"bearingsim-{self.run_id}", next(self.key_numbers)) for _ in works]
        with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1 GB"}):  # scans are large
            futures = self.client.map(deliver, parcels, key=keys, pure=False, retries=0)
        for future in futures:
            future.add_done_callback(self.finished.put)
        return dict(zip(futures, works, strict=True))

    def _stop(self, submitted: dict[Future, Work]) -> None:
        """Request all workers to start no more jobs, and cancel units that have not been started."""
        with suppress(TimeoutError):  # repeated after the next ``_update_workers``
            call_with_timeout(SCHEDULER_TIMEOUT_S, partial(self.client.run, stop, self.run_id, on_error="ignore"))
        active_keys = {
            key for keys in call_with_timeout(SCHEDULER_TIMEOUT_S, self.client.processing).values() for key in keys
        }
        holders = call_with_timeout(SCHEDULER_TIMEOUT_S, partial(self.client.who_has, list(submitted)))
        active_keys |= {key for key, workers in holders.items() if workers}  # finished, but not fetched
        unstarted = [future for future in submitted if future.key not in active_keys]
        if unstarted:
            call_with_timeout(SCHEDULER_TIMEOUT_S, partial(self.client.cancel, unstarted))
        for future in unstarted:
            del submitted[future]

    def _collect(self, submitted: dict[Future, Work]) -> "Iterator[Outcome | KilledWork]":
        """Fetch and store finished units; yield their outcomes, and the units whose worker died.

        Both are removed from ``submitted``.
        """
        statuses = {future: future.status for future in self._finished_futures(submitted)}
        if "cancelled" in statuses.values():  # the connection to the scheduler is lost
            raise CommClosedError
        self.lost_futures += [future for future, status in statuses.items() if status not in ("finished", "error")]
        deliveries = self._fetch([future for future, status in statuses.items() if status == "finished"])
        for future, delivery in deliveries.items():
            _refuse_unsent_jobs(submitted[future], delivery)
        files = [
            (work.root, *file)
            for future, work in [(future, submitted.pop(future)) for future in deliveries]
            for file in deliveries[future].files.items()
        ]
        if files:
            with ThreadPoolExecutor(WRITER_THREADS) as threads:  # the time is spent waiting for fsync
                list(threads.map(store.store_unit, *zip(*files, strict=True)))
        for delivery in deliveries.values():
            self.deaths = 0
            yield delivery.outcome
        killed = [
            KilledWork(submitted.pop(future), self._dead_worker(future))
            for future, status in statuses.items()
            if status == "error"
        ]
        if killed:
            self._count_deaths(killed)
        yield from killed

    def _finished_futures(self, submitted: Mapping[Future, Work]) -> list[Future]:
        """Return finished and lost units, at most a batch; wait up to POLL_S for the first one."""
        batch: list[Future] = []
        size = 0.0
        with suppress(Empty):
            while len(batch) < MAX_BATCH_UNITS and size < MAX_BATCH_BYTES:
                future = self.finished.get(timeout=0.0 if batch else POLL_S)
                if future in submitted:  # not cancelled
                    batch.append(future)
                    size += submitted[future].bytes
        return batch

    def _fetch(self, futures: Sequence[Future]) -> dict[Future, Delivery]:
        """Fetch results, except those lost with their worker, which the scheduler recomputes.

        ``Client.gather`` is not used, because it would wait for the recomputation.
        """
        pending = {future.key: future for future in futures}
        while pending:
            gather = partial(self.client.sync, self.client.scheduler.gather, keys=list(pending))
            response = call_with_timeout(WORKER_TIMEOUT_S, gather)
            if response["status"] == "OK":
                return {pending[key]: delivery for key, delivery in response["data"].items()}
            self.lost_futures += [pending.pop(key) for key in response["keys"]]
        return {}

    def _dead_worker(self, future: Future) -> str:
        """Return the address of the worker that died while computing a unit. Raises any other error of the unit.

        Errors of unpickling become InstallationMismatch.
        """
        error = future.exception()
        if isinstance(error, KilledWorker):
            return str(error.last_worker.address)
        if isinstance(error, (ImportError, AttributeError)) and not isinstance(error, UserError):
            raise InstallationMismatch(
                f"a worker cannot load a unit ({error}); install the same bearingsim there"
            ) from error
        raise error

    def _count_deaths(self, killed: Sequence[KilledWork]) -> None:
        """Count deaths of workers. Raises RepeatedWorkerDeaths if too many died since the last result."""
        for death in killed:
            suspects = sorted(job.id for job in death.work.jobs)
            store.log(death.work.root, "worker died", worker=death.address, suspects=suspects)
        self.deaths += len({death.address for death in killed})
        if self.deaths >= RESTARTS_WITHOUT_PROGRESS * self.workers:
            raise RepeatedWorkerDeaths(f"{self.deaths} workers died without finishing a job: {ADVICE}")

    def _update_workers(self) -> bool:
        """Update the number of workers, at most every WORKER_CHECK_S; return True after an update.

        Reports if there are no workers. Units that were lost with a worker are put back in the queue, because the
        scheduler has them recomputed.
        """
        if time.monotonic() - self.checked_at < WORKER_CHECK_S:
            return False
        self.worker_count = len(call_with_timeout(SCHEDULER_TIMEOUT_S, self.client.nthreads))
        self.checked_at = time.monotonic()
        if not self.worker_count and not self.has_no_workers:
            message = (
                f"waiting for workers at {self.address} (`dask worker {self.address} --nthreads 1` starts one)"
            )
            say(message, err=True)
        self.has_no_workers = not self.worker_count
        while self.lost_futures:
            self.finished.put(self.lost_futures.pop())
        return True

    def _run_on_all(self, function: Callable, *arguments: Any) -> dict[str, Any]:
        """Call a function on each worker; return the results by address, without those of lost workers.

        Raises InstallationMismatch if the function fails, WorkerFailed if a worker does not answer in time.
        """
        try:
            answers = call_with_timeout(
                WORKER_TIMEOUT_S, partial(self.client.run, function, *arguments, on_error="return")
            )
        except TimeoutError:
            message = f"some of {self.worker_count} workers do not respond within {WORKER_TIMEOUT_S:.0f} s"
            raise WorkerFailed(f"{message}; stop those with stalled logs") from None
        for address, answer in answers.items():
            if isinstance(answer, Exception) and not isinstance(answer, OSError):  # an OSError is a lost worker
                raise InstallationMismatch(f"worker {address} cannot load bearingsim: {answer}")
        return {address: answer for address, answer in answers.items() if not isinstance(answer, OSError)}

    @contextmanager
    def _convert_errors(self) -> Iterator[None]:
        """Convert errors due to a lost scheduler to SchedulerUnreachable."""
        try:
            yield
        except Exception as error:
            is_lost = self.client.status != "running" or isinstance(error, (CommClosedError, TimeoutError))
            if isinstance(error, UserError) or not is_lost:
                raise
            timed_out = isinstance(error, TimeoutError)
            state = f"the scheduler at {self.address} " + ("does not respond" if timed_out else "is gone")
            effect = "finished units are stored, running ones are lost"
            advice = "restart it and its workers, then run the command again"
            raise SchedulerUnreachable(f"{state}: {effect}; {advice}") from error


def _failed_outcome(killed: KilledWork) -> Outcome:
    (job,) = killed.work.jobs
    failure = store.Failure(
        job=job.id,
        reason="its worker died",
        advice=f"the log of {killed.address} may show the reason; if memory was short, try a shorter duration",
        attempts=2,
    )
    return Outcome(unit=killed.work.unit, done=(), failed=(failure,))


def _refuse_unsent_jobs(work: Work, delivery: Delivery) -> None:
    """Raise WorkerFailed if the outcome of a delivery contains jobs that were not sent."""
    outcome = delivery.outcome
    if not {*outcome.done, *(failure.job for failure in outcome.failed)} <= {job.id for job in work.jobs}:
        raise WorkerFailed(f"unit {work.unit} returned from its worker with jobs that were not sent")


def _strip(work: Work) -> Work:
    """Return the work to be sent to a worker: without ``others``, and with shortened paths of scans."""
    jobs = tuple(replace(job, case=store.with_short_paths(job.case)) for job in work.jobs)
    return replace(work, others=None, jobs=jobs)


def _scans(work: Work) -> dict[str, bytes]:
    """Read the scans required by a unit of work from the results folder; return their contents by file name."""
    return store.read_scans(work.root, [job.case for job in work.jobs])
