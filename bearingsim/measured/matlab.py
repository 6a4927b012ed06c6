"""MAT files: v5 by SciPy, v7.3, which are HDF5, by h5py."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from bearingsim.hdf5 import Hdf5
from bearingsim.measured.arrays import content_of
from bearingsim.measured.content import Content, MeasuredError

MAX_DEPTH = 6
"""Deepest nesting of structs that is searched."""
HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"


def read_mat(path: Path, most: float) -> Content:
    """Read a MAT file of any version; most: largest memory (bytes) of an array."""
    with path.open("rb") as file:
        beginning = file.read(8192)
    if _is_hdf5(beginning):
        return read_hdf5(path, most)
    from scipy.io import loadmat

    arrays: dict[str, np.ndarray] = {}
    texts: dict[str, str] = {}
    variables = loadmat(str(path), simplify_cells=True)
    for name, value in _leaves("", {name: v for name, v in variables.items() if not name.startswith("__")}):
        if isinstance(value, str):
            texts[name] = value
        elif isinstance(value, np.ndarray | int | float) and np.asarray(value).dtype.kind in "fiubc":
            arrays[name] = np.asarray(value)
    return content_of(path, arrays, texts)


def _is_hdf5(beginning: bytes) -> bool:
    """Check if a file is HDF5, which begins at byte 0, 512, 1024 or a further power of 2."""
    return any(beginning[offset : offset + 8] == HDF5_SIGNATURE for offset in (0, 512, 1024, 2048, 4096))


def _leaves(prefix: str, value: Any, depth: int = 0) -> Iterator[tuple[str, Any]]:
    """Yield the values of nested structs with their paths, `a.b`."""
    if isinstance(value, dict) and depth < MAX_DEPTH:
        for name, entry in value.items():
            yield from _leaves(f"{prefix}.{name}" if prefix else str(name), entry, depth + 1)
    else:
        yield prefix, value


def read_hdf5(path: Path, most: float) -> Content:
    """Read an HDF5 file: a MAT file v7.3, whose arrays are transposed, or a unit of stored results.

    Units of datasets are their attributes `units` or `unit`.
    """
    arrays: dict[str, np.ndarray] = {}
    texts: dict[str, str] = {}
    with path.open("rb") as stream, Hdf5(stream, most) as file:
        if "job" in file and "time" in file:
            return _unit(path, file)
        for name in _datasets(file, ""):
            if name.startswith("#") or file.has_attribute("MATLAB_empty", name):  # whose data are its shape
                continue
            key = name.replace("/", ".")
            unit = next(
                (attribute for attribute in ("units", "unit") if file.has_attribute(attribute, name)), None
            )
            if unit is not None:
                texts[f"{key}.unit"] = str(file.attribute(unit, name, variable=True))
            if file.attribute("MATLAB_class", name, variable=True) == "char":
                texts[key] = "".join(map(chr, file.numbers(name).ravel()[:80]))
            elif file.has_numbers(name):
                arrays[key] = file.numbers(name).T
    return content_of(path, arrays, texts)


def _datasets(file: Hdf5, group: str, depth: int = 0) -> Iterator[str]:
    """Yield the paths of the datasets in a group."""
    for name in file.names(group):
        path = f"{group}/{name}" if group else name
        if not file.is_group(path):
            yield path
        elif depth < MAX_DEPTH and not name.startswith("#"):
            yield from _datasets(file, path, depth + 1)


def _unit(path: Path, file: Hdf5) -> Content:
    """Return the series of the jobs of a unit of stored results, `<job>/<channel>`."""
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
        raise MeasuredError(path, "is a unit of results without series: its study has `record: []`")
    return content_of(path, arrays, texts)
