"""Readers of MAT and HDF5 files: MAT v4 and v5 by SciPy, MAT v7.3, which is HDF5, by h5py."""

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from bearingsim.hdf5 import Hdf5
from bearingsim.measured.arrays import MIN_SAMPLES, identify_content
from bearingsim.measured.content import Content, MeasuredError

MAT5_HEADER = 128
"""Size (bytes) of the header of a MAT file v5, whose last two bytes state the order of bytes."""
COMPRESSED = 15
"""Data type of a compressed variable of a MAT file v5 (miCOMPRESSED)."""
MAX_DEPTH = 6
"""Deepest level of nested structs or groups that is searched."""
HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"


def read_mat(path: Path, max_bytes: float) -> Content:
    """Read a MAT file of any version; max_bytes: memory limit, of an array of a file of v7.3, else of all.

    Raises MeasuredError for a larger content, and for an array of structs.
    """
    with path.open("rb") as file:
        beginning = file.read(8192)
    if _is_hdf5(beginning):
        return read_hdf5(path, max_bytes)
    from scipy.io import loadmat

    size = _inflated_size(path)
    if size > max_bytes:
        raise MeasuredError(path, f"would take {size / 1e6:.3g} MB, which is not plausible for its size")
    arrays: dict[str, np.ndarray] = {}
    texts: dict[str, str] = {}
    struct_arrays: list[str] = []
    variables = loadmat(str(path), simplify_cells=True)
    for name, value in _iterate_leaves(
        "", {name: v for name, v in variables.items() if not name.startswith("__")}
    ):
        if isinstance(value, str):
            texts[name] = value
        elif isinstance(value, np.ndarray | int | float) and np.asarray(value).dtype.kind in "fiubc":
            arrays[name] = np.asarray(value)
        elif isinstance(value, list | np.ndarray) and any(isinstance(entry, dict) for entry in value):
            struct_arrays.append(name)
    if struct_arrays and not any(values.size >= MIN_SAMPLES for values in arrays.values()):
        names = " and ".join(f"`{name}`" for name in struct_arrays[:4])
        advice = "save a signal as a variable of its own, with its rate as `fs`"
        raise MeasuredError(path, f"has its signals in arrays of structs, {names}: {advice}")
    return identify_content(path, arrays, texts)


def _inflated_size(path: Path) -> int:
    """Return the size (bytes) of the variables of a MAT file v5, compressed ones as their own headers state it.

    0 for a file of v4, which is not compressed.
    """
    total = 0
    with path.open("rb") as file:
        header = file.read(MAT5_HEADER)
        order = {b"IM": "<", b"MI": ">"}.get(header[-2:])
        while order is not None and len(tag := file.read(8)) == 8:
            kind, size = struct.unpack(f"{order}II", tag)
            begin = file.tell()
            if kind == COMPRESSED:
                tag = zlib.decompressobj().decompress(file.read(min(size, 4096)), 8)
                total += struct.unpack(f"{order}II", tag)[1]
            else:
                total += size
            file.seek(begin + size)
    return total


def _is_hdf5(beginning: bytes) -> bool:
    """Check if the first 8 KiB of a file contain the signature of HDF5, at byte 0, 512, 1024, 2048 or 4096."""
    return any(beginning[offset : offset + 8] == HDF5_SIGNATURE for offset in (0, 512, 1024, 2048, 4096))


def _iterate_leaves(prefix: str, value: Any, depth: int = 0) -> Iterator[tuple[str, Any]]:
    """Yield the path, `a.b`, and the value of each field of nested structs."""
    if isinstance(value, dict) and depth < MAX_DEPTH:
        for name, entry in value.items():
            yield from _iterate_leaves(f"{prefix}.{name}" if prefix else str(name), entry, depth + 1)
    else:
        yield prefix, value


def read_hdf5(path: Path, max_bytes: float) -> Content:
    """Read an HDF5 file: a unit file of stored results, a MAT file v7.3, or another file of numeric datasets.

    The unit of a dataset, or those of its columns, are its attribute `units` or `unit`. max_bytes: memory limit of
    a dataset.
    """
    arrays: dict[str, np.ndarray] = {}
    texts: dict[str, str] = {}
    with path.open("rb") as stream, Hdf5(stream, max_bytes) as file:
        if "job" in file and "time" in file:
            return _read_unit_file(path, file)
        for name in _iterate_datasets(file, ""):
            is_empty = file.has_attribute(
                "MATLAB_empty", name
            )  # MATLAB stores the shape of an empty array as data
            if is_empty or name.startswith("#"):
                continue
            key = name.replace("/", ".")
            units = file.attribute_texts("units", name) or file.attribute_texts("unit", name)
            if len(units) == 1:
                texts[f"{key}.unit"] = units[0]
            else:
                texts |= {f"{key}.{number}.unit": unit for number, unit in enumerate(units, 1)}
            if file.attribute("MATLAB_class", name, variable=True) == "char":
                texts[key] = "".join(map(chr, file.numbers(name).ravel()[:80]))
            elif file.has_numbers(name):
                arrays[key] = file.numbers(name).T  # MATLAB reverses the order of dimensions
    return identify_content(path, arrays, texts)


def _iterate_datasets(file: Hdf5, group: str, depth: int = 0) -> Iterator[str]:
    """Yield the paths of the datasets in a group and its subgroups, except MATLAB's own groups (`#refs#`)."""
    for name in file.names(group):
        path = f"{group}/{name}" if group else name
        if not file.is_group(path):
            yield path
        elif depth < MAX_DEPTH and not name.startswith("#"):
            yield from _iterate_datasets(file, path, depth + 1)


def _read_unit_file(path: Path, file: Hdf5) -> Content:
    """Return the series of all jobs in a unit file of stored results, named `<job>/<channel>`."""
    jobs, time = [str(job) for job in file.texts("job")], file.numbers("time")
    arrays: dict[str, np.ndarray] = {"time": time}
    texts: dict[str, str] = {}
    for name in file.names():
        if not file.is_group(name) and file.shape(name) == (len(jobs), len(time)):
            unit = file.attribute("units", name, default="", variable=True)
            for row, job in enumerate(jobs):
                arrays[f"{job}/{name}"] = file.numbers(name, row)
                texts[f"{job}/{name}.unit"] = str(unit)
    if len(arrays) == 1:
        raise MeasuredError(path, "is a unit file of results without series: its study has `record: []`")
    return identify_content(path, arrays, texts)
