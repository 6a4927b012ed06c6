"""Unit files: immutable HDF5 files, each with the series, parameters and features of one or more jobs.

``time`` (float64, s) and ``job`` (ids) are dimension scales of the root, and each channel is a float32 dataset
(job, time). ``parameters``, ``features`` and ``info`` are datasets (job, name) in SI (``columns.py``). The
provenance is stored in attributes and in the group ``provenance``. xarray (h5netcdf), ncdump, h5web and MATLAB can
open the files.
"""

import hashlib
import io
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
from numpy.typing import NDArray

from bearingsim.errors import UserError
from bearingsim.hdf5 import Hdf5
from bearingsim.store.columns import GROUPS, TEXT, Value, make_columns, read_columns, write_columns, write_jobs
from bearingsim.store.files import write_bytes
from bearingsim.store.names import channel_attributes, channel_unit, flat_parameters
from bearingsim.store.own_files import UNITS
from bearingsim.store.regular import Unreadable
from bearingsim.store.sealed import UNREADABLE, hdf5_in_memory, open_hdf5, open_sealed, open_unverified
from bearingsim.text.html import table_html
from bearingsim.text.terminal import is_line

if TYPE_CHECKING:
    from bearingsim.simulation.record import Record
    from bearingsim.study import Job

CHUNK_BYTES = 1 << 16  # bytes; largest size of a chunk with several short jobs
ATTRIBUTES = ("overrides", "model_version", "platform", "python", "packages", "git_commit")
"""Attributes of a unit that describe its computation."""
MAX_CHUNK_SAMPLES = 1 << 18  # largest number of samples of a job in a chunk


class DamagedUnit(UserError):
    """A unit file is damaged, or its jobs do not match its name."""


@dataclass(frozen=True)
class Series(Mapping[str, NDArray[np.float32]]):
    """Recorded series of one job, a mapping of its channels.

    time: (n,) in s; channels: (n,) in SI, by name; units: by name of the channel.
    """

    time: NDArray[np.float64]
    channels: dict[str, NDArray[np.float32]]
    units: dict[str, str]

    def __getitem__(self, channel: str) -> NDArray[np.float32]:
        return self.channels[channel]

    def __iter__(self) -> Iterator[str]:
        return iter(self.channels)

    def __len__(self) -> int:
        return len(self.channels)

    def _repr_html_(self) -> str:
        """Return a summary for notebooks."""
        ends = f", {self.time[0]:.6g} to {self.time[-1]:.6g} s" if len(self.time) else ""
        ranges = {
            name: f"{np.min(values):.4g} to {np.max(values):.4g}" if len(values) else "-"
            for name, values in self.channels.items()
        }
        rows = [(name, f"{text} {self.units[name]}".strip()) for name, text in ranges.items()]
        return table_html("Series", [("time", f"{len(self.time)} samples{ends}"), *rows])


def unit_name(jobs: Iterable[str]) -> str:
    """Return the name of the unit with some jobs: the first 16 hex digits of SHA-256 over the sorted ids."""
    return hashlib.sha256("\n".join(sorted(jobs)).encode()).hexdigest()[:16]


def unit_names(root: Path) -> set[str]:
    """Return the names of the units in a results folder."""
    return {path.stem for path in UNITS.find(root)}


def unit_path(root: Path, unit: str) -> Path:
    """Return the path of a unit in a results folder."""
    return root / "units" / unit[:2] / f"{unit}.h5"


# Writing


def write_units(root: Path, done: Sequence[tuple["Job", "Record"]], provenance: Mapping[str, Value]) -> list[Path]:
    """Write the records of some jobs, one file per time axis and set of channels; return the paths."""
    return [_write(unit_path(root, unit), content) for unit, content in seal_units(done, provenance)]


def _write(path: Path, content: bytes) -> Path:
    write_bytes(path, content)
    return path


def seal_units(
    done: Sequence[tuple["Job", "Record"]], provenance: Mapping[str, Value]
) -> Iterator[tuple[str, bytes]]:
    """Yield name and content, with its checksum, of each unit file for the records of some jobs."""
    ordered = sorted(done, key=lambda pair: (_shape_key(pair[1]), pair[0].id))
    for _, group in groupby(ordered, key=lambda pair: _shape_key(pair[1])):
        yield _seal_unit(list(group), provenance)


def store_unit(root: Path, unit: str, content: bytes) -> Path:
    """Check a unit received from another machine, and write it unchanged; return its path. Raises DamagedUnit."""
    path = unit_path(root, unit)
    try:
        with open_sealed(io.BytesIO(content)) as file:
            _check(path, file)
    except UNREADABLE as error:
        raise DamagedUnit(f"{path.name}, as received: {error}") from error
    return _write(path, content)


def _shape_key(record: "Record") -> tuple[bytes, tuple[str, ...]]:
    """Return a key that is equal for records with the same time axis and channels."""
    names = tuple(sorted(record.series))
    return (np.asarray(record.time, np.float64).tobytes() if names else b""), names


def _seal_unit(done: Sequence[tuple["Job", "Record"]], provenance: Mapping[str, Value]) -> tuple[str, bytes]:
    ids, contents = [job.id for job, _ in done], list[bytes]()
    with hdf5_in_memory(contents.append) as file:
        jobs = write_jobs(file, ids)
        _write_series(file, jobs, [record for _, record in done])
        write_columns(file, jobs, "parameters", make_columns([flat_parameters(job.case) for job, _ in done]))
        write_columns(file, jobs, "features", make_columns([record.features for _, record in done]))
        write_columns(file, jobs, "info", make_columns([record.info for _, record in done]))
        _write_provenance(file, provenance)
    return unit_name(ids), contents[0]


def _write_series(file: h5py.File, jobs: h5py.Dataset, records: Sequence["Record"]) -> None:
    reference = records[0]
    if not reference.series:
        return
    time = file.create_dataset("time", data=np.asarray(reference.time, np.float64), fletcher32=True)
    time.make_scale("time")
    time.attrs.update(units="s", long_name="time")
    for name in sorted(reference.series):
        data = np.stack([np.asarray(record.series[name], np.float32) for record in records])
        channel = file.create_dataset(
            name, data=data, chunks=_chunks(*data.shape), compression="gzip", shuffle=True, fletcher32=True
        )
        channel.dims[0].attach_scale(jobs)
        channel.dims[1].attach_scale(time)
        channel.attrs.update(channel_attributes(name))


def _chunks(jobs: int, samples: int) -> tuple[int, int]:
    """Return the shape (jobs, samples) of a chunk: of one job, or of several short jobs up to CHUNK_BYTES."""
    width = max(1, min(samples, MAX_CHUNK_SAMPLES))
    return min(jobs, max(1, CHUNK_BYTES // (4 * width))), width


def _write_provenance(file: h5py.File, provenance: Mapping[str, Value]) -> None:
    """Write multi-line strings, such as the text of the study, as datasets, and other values as attributes."""
    group = file.require_group("provenance")
    for name, value in provenance.items():
        if isinstance(value, str) and "\n" in value:
            group.create_dataset(name, data=value, dtype=TEXT)
        else:
            file.attrs[name] = value
    file.attrs["status"] = "complete"


# Reading


@contextmanager
def open_unit(path: Path) -> Iterator[Hdf5]:
    """Open a unit after checking its digest, name, completeness and shapes.

    Raises DamagedUnit, also for read errors within the context.
    """
    try:
        with open_hdf5(path) as file:
            _check(path, file)
            yield file
    except PermissionError:  # the file is not damaged
        raise
    except UNREADABLE as error:
        raise DamagedUnit(f"{path.name}: {error}") from error


def read_unit(path: Path) -> dict[str, NDArray[Any]]:
    """Read the columns over ``job`` of a unit. Raises DamagedUnit."""
    with open_unit(path) as file:
        return read_columns(file)


def check_unit(path: Path) -> list[str]:
    """Check a unit, and return the ids of its jobs. Raises DamagedUnit."""
    with open_unit(path) as file:
        return list(file.texts("job"))


def read_job_ids(path: Path) -> list[str]:
    """Read the ids of the jobs of a unit without checking its digest. Raises DamagedUnit."""
    try:
        with open_unverified(path) as file:
            return list(file.texts("job"))
    except UNREADABLE as error:
        raise DamagedUnit(f"{path.name}: {error}") from error


def result_digests(path: Path, jobs: Collection[str]) -> dict[str, dict[str, bytes]]:
    """Return the bytes of the features, and digests of time and channels, of some jobs of a unit, by job and name.

    They differ if the values are not bitwise equal. Date, host and CPU time are not included. Raises DamagedUnit.
    """
    with open_unit(path) as file:
        features = read_columns(file, ("features",))
        rows = {job: row for row, job in enumerate(features.pop("job")) if job in jobs}
        names = _channels(file)
        time = {"time": _digest(file.numbers("time"))} if names else {}
        return {
            job: time
            | {name: _digest(file.numbers(name, row)) for name in names}
            | {
                name.partition("/")[2]: _bytes(column[row])
                for name, column in features.items()
                if _has_value(column[row])
            }
            for job, row in rows.items()
        }


def _has_value(value: float | str) -> bool:
    """Return True unless a feature is missing, that is NaN or an empty string."""
    return value == value and value != ""


def _bytes(value: Any) -> bytes:
    return value.encode() if isinstance(value, str) else np.float64(value).tobytes()


def _digest(values: NDArray[Any]) -> bytes:
    return hashlib.sha256(values.tobytes()).digest()


def _check(path: Path, file: Hdf5) -> None:
    """Raise Unreadable for an incomplete unit, ids that do not match its name, or channels of another shape."""
    ids = list(file.texts("job"))
    if not file.has_attribute("status"):  # written last
        raise Unreadable("not marked complete")
    if unit_name(ids) != path.stem:
        raise Unreadable("its job ids do not match its name")
    for name in _channels(file):
        expected_shape = (len(ids), *file.shape("time"))
        if file.shape(name) != expected_shape:
            raise Unreadable(f"{name} has shape {file.shape(name)}, not {expected_shape}")


def _channels(file: Hdf5) -> list[str]:
    """List the recorded channels. Raises Unreadable for an invalid channel name."""
    columns = (*GROUPS, *(f"{item}_text" for item in GROUPS.values()))
    series = [name for name in file.names() if name not in columns and not file.is_group(name)]
    channels = [name for name in series if len(file.shape(name)) == 2]
    for name in channels:
        if not is_line(name):
            raise Unreadable(f"{name!a} is not a channel name")
    return channels


def read_provenance(path: Path) -> dict[str, str]:
    """Read the attributes of a unit: versions, commit, platform and so on. Raises DamagedUnit."""
    with open_unit(path) as file:
        return {name: str(file.attribute(name, variable=True)) for name in ATTRIBUTES if file.has_attribute(name)}


def read_series(path: Path, job: str) -> Series:
    """Read the series of one job from its unit. Raises DamagedUnit, and KeyError for an unknown job."""
    with _add_advice(path), open_unit(path) as file:
        ids = list(file.texts("job"))
        if job in ids:
            return _read_channels(file, ids.index(job), len(ids))
    raise KeyError(f"{path.name} does not contain job {job}")


def _read_channels(file: Hdf5, row: int, rows: int) -> Series:
    """Read the series of the job at a row; rows: number of jobs in the unit."""
    names = _channels(file)
    if not names:
        return Series(np.empty(0), {}, {})
    file.check_size("the series of a job", file.cost("time") + file.cost(*names) / rows)
    channels = {name: file.numbers(name, row) for name in names}
    return Series(file.numbers("time"), channels, {name: channel_unit(name) for name in names})


@contextmanager
def _add_advice(path: Path) -> Iterator[None]:
    """Add folder and advice to the message of a DamagedUnit raised within the context."""
    try:
        yield
    except DamagedUnit as damage:
        advice = "run the study again with --verify to recompute damaged results"
        raise DamagedUnit(f"{path.parent}/{damage} ({advice})") from None
