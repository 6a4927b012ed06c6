"""Computation of a unit of work in a dask worker, which receives the unit and returns the unit files."""

import hashlib
import os
import pickle
import platform
import socket
import threading
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from distributed import get_worker

from bearingsim import blas_threads, extensions, store
from bearingsim.errors import UserError
from bearingsim.runner.stopping import set_stop_flag
from bearingsim.runner.work import Outcome, Work, compute
from bearingsim.store.provenance import versions

if TYPE_CHECKING:
    from bearingsim.simulation.record import Record
    from bearingsim.store.columns import Value
    from bearingsim.study import Job

IMPORT_STATEMENT = "import bearingsim.runner.delivery"
"""Slow import, run in a thread so that the event loop of the worker continues to send its heartbeat."""
SOURCE_SUFFIXES = (".py", ".csv")  # suffixes of the files of the package that influence results


class InstallationMismatch(UserError):
    """A worker's installation or configuration differs from that of this process."""


class WorkerFailed(UserError):
    """A worker cannot continue because of a problem on its machine."""


@dataclass(frozen=True)
class Parcel:
    """Message to a worker: pickled work, scans of its cases by file name, id of the run, required installation."""

    work: bytes
    scans: Mapping[str, bytes]
    run: str
    requirements: Mapping[str, str]


@dataclass(frozen=True)
class Delivery:
    """Message from a worker: outcome of a unit, and its unit files by name."""

    outcome: Outcome
    files: Mapping[str, bytes]


def deliver(parcel: Parcel) -> Delivery:
    """Compute a unit in a worker. Raises InstallationMismatch, WorkerFailed, and errors due to bugs."""
    worker = get_worker()
    refuse_threads(worker.address, worker.state.nthreads)
    refuse_installation(worker.address, installation(), parcel.requirements)
    set_stop_flag(_stop_events[parcel.run])
    work: Work = pickle.loads(parcel.work)
    folder, files = Path(worker.local_directory), dict[str, bytes]()
    host_provenance = {**work.provenance, "host": socket.gethostname(), "platform": platform.platform()}

    def seal(_: Path, done: "Sequence[tuple[Job, Record]]", provenance: "Mapping[str, Value]") -> None:
        files.update(store.seal_units(done, provenance))

    try:
        with _provide_scans(parcel.scans, folder):
            return Delivery(compute(replace(work, root=folder, provenance=host_provenance), seal), files)
    except (UserError, OSError) as error:  # for example, its disk is full
        raise WorkerFailed(f"worker {worker.address}: {error}") from None


@contextmanager
def _provide_scans(scans: Mapping[str, bytes], folder: Path) -> Iterator[None]:
    """Store the scans sent with the work in a folder, and let cases read them from there."""
    from bearingsim.config.scan.file import TRANSFERRED_FILES

    for name, content in scans.items():
        path = folder / "scans" / name
        if not path.exists():
            store.write_bytes(path, content)  # atomically, because later units use the file if it exists
        TRANSFERRED_FILES[path.stem] = path
    try:
        yield
    finally:
        TRANSFERRED_FILES.clear()


_stop_events: defaultdict[str, threading.Event] = defaultdict(threading.Event)
"""Stop requests in this worker, by run."""


def stop(run: str) -> None:
    """Stop a run in this worker, so that no more of its jobs are started."""
    _stop_events[run].set()


# Comparison of installations


@cache
def installation() -> dict[str, str]:
    """Return by name the versions and settings that must agree on all machines that compute a study.

    Raises BrokenExtension.
    """
    from bearingsim.catalogue import extension_digest
    from bearingsim.core import MODEL_VERSION

    extensions.raise_if_broken()
    threads = {os.environ.get(name, "not limited") for name in blas_threads.VARIABLES}
    return {
        "Python": platform.python_version(),
        **versions(),
        "model version": str(MODEL_VERSION),
        "sources of bearingsim": _sources(),
        "extensions": extension_digest(),
        "threads of linear algebra": " or ".join(sorted(threads)),
    }


def required_installation() -> dict[str, str]:
    """Return the installation required of a worker: that of this process, with one thread for linear algebra.

    Raises InstallationMismatch if this process, which chooses the models, is set to use several threads.
    """
    settings = " and ".join(f"{name}={count}" for name, count in blas_threads.changed_variables().items())
    if settings:
        raise InstallationMismatch(
            f"{settings} is set, but workers use one thread to keep results reproducible; unset it"
        )
    return installation() | {"threads of linear algebra": "1"}


def _sources() -> str:
    """Return the first 12 hex digits of SHA-256 over the sources, which may differ between equal versions."""
    package, digest = Path(__file__).parents[1], hashlib.sha256()
    for path in sorted(path for path in package.rglob("*") if path.suffix in SOURCE_SUFFIXES):
        digest.update(path.relative_to(package).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()[:12]


def refuse_installation(address: str, present: Mapping[str, str], required: Mapping[str, str]) -> None:
    """Raise InstallationMismatch if the installation of a worker differs from the required one."""
    names = dict.fromkeys((*required, *present))
    differences = ", ".join(
        f"{name} {present.get(name, 'absent')} instead of {required.get(name, 'none')}"
        for name in names
        if present.get(name) != required.get(name)
    )
    if differences:
        raise InstallationMismatch(
            f"worker {address}: {differences} (workers need the same packages as `bearingsim run`)"
        )


def refuse_threads(address: str, threads: int) -> None:
    """Raise InstallationMismatch if a worker has several threads: it would run several units in one process."""
    if threads != 1:
        raise InstallationMismatch(
            f"worker {address} has {threads} threads, but each job needs a process; start it by"
            f" `dask worker --nthreads 1 --nworkers {threads}`"
        )
