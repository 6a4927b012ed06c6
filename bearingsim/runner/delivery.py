"""What a worker of a dask scheduler does: it gets a unit of work as a value, and gives back the files of it."""

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
from bearingsim.runner.stopping import heed
from bearingsim.runner.work import Outcome, Work, compute
from bearingsim.store.provenance import versions

if TYPE_CHECKING:
    from bearingsim.simulation.simulate import Record
    from bearingsim.store.columns import Value
    from bearingsim.study import Job

__all__ = [
    "LOADING",
    "Delivery",
    "OtherInstallation",
    "Parcel",
    "WorkerFailed",
    "deliver",
    "installation",
    "needed",
    "refuse_installation",
    "refuse_threads",
    "stop",
]

LOADING = "import bearingsim.runner.delivery"
"""What takes seconds at first, and so is done beside the thread in which a worker says that it is alive."""
SOURCES = (".py", ".csv")


class OtherInstallation(UserError):
    """A worker would not compute what this process computes, or not as it is meant to."""


class WorkerFailed(UserError):
    """A worker cannot go on, for a reason that lies in its machine."""


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


def deliver(parcel: Parcel) -> Delivery:
    """In a worker: compute a unit. Raises OtherInstallation, WorkerFailed, and what is a bug."""
    worker = get_worker()
    refuse_threads(worker.address, worker.state.nthreads)
    refuse_installation(worker.address, installation(), parcel.installed)
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


_stops: defaultdict[str, threading.Event] = defaultdict(threading.Event)
"""In a worker, by run: whether it has been asked to stop."""


def stop(run: str) -> None:
    """In a worker: of this run nothing more is begun."""
    _stops[run].set()


# What must be the same


@cache
def installation() -> dict[str, str]:
    """What must be the same wherever jobs of one study are computed, by its name. Raises BrokenExtension."""
    from bearingsim.catalogue import extension_digest
    from bearingsim.core import MODEL_VERSION

    extensions.refuse_broken()
    threads = {os.environ.get(name, "not limited") for name in blas_threads.NAMES}
    return {
        "Python": platform.python_version(),
        **versions(),
        "model version": str(MODEL_VERSION),
        "sources of bearingsim": _sources(),
        "extensions": extension_digest(),
        "threads of linear algebra": " or ".join(sorted(threads)),
    }


def needed() -> dict[str, str]:
    """What a worker must have: what is here, and one thread for linear algebra.

    Raises OtherInstallation if several are asked for here, where models are chosen.
    """
    here = " and ".join(f"{name}={count}" for name, count in blas_threads.several().items())
    if here:
        raise OtherInstallation(
            f"{here} is set here, and workers take one thread (with more, sums are rounded otherwise): unset it"
        )
    return installation() | {"threads of linear algebra": "1"}


def _sources() -> str:
    """First 12 hex digits of SHA-256 over the program: a checkout may have changed while its version has not."""
    package, digest = Path(__file__).parents[1], hashlib.sha256()
    for path in sorted(path for path in package.rglob("*") if path.suffix in SOURCES):
        digest.update(path.relative_to(package).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()[:12]


def refuse_installation(address: str, there: Mapping[str, str], here: Mapping[str, str]) -> None:
    """Raises OtherInstallation if a worker differs."""
    names = dict.fromkeys((*here, *there))
    other = ", ".join(
        f"{name} {there.get(name, 'absent')} in place of {here.get(name, 'none')}"
        for name in names
        if there.get(name) != here.get(name)
    )
    if other:
        raise OtherInstallation(
            f"worker {address}: {other} (a worker has all as it is where `bearingsim run` is given)"
        )


def refuse_threads(address: str, threads: int) -> None:
    """Raises OtherInstallation if a worker would compute several units in one process."""
    if threads != 1:
        raise OtherInstallation(
            f"worker {address} has {threads} threads, and a job takes a process: start it by"
            f" `dask worker --nthreads 1 --nworkers {threads}`"
        )
