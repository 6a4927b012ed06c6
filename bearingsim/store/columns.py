"""Columns over the jobs of a file: parameters, features, and solver statistics.

The numeric columns of a group are stored in one float64 dataset (job, name), such as ``features``. The scale of
its second dimension, ``feature``, contains the names, and ``feature_units`` the units. The text columns are stored
in a second dataset, ``feature_text``.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from bearingsim.hdf5 import Hdf5
from bearingsim.store.names import feature_attributes, parameter_attributes
from bearingsim.store.regular import Unreadable
from bearingsim.text.terminal import is_line

TEXT = h5py.string_dtype()
GROUPS = {"parameters": "parameter", "features": "feature", "info": "fact"}
"""Name of the second dimension of each group."""
ATTRIBUTES = {"parameters": parameter_attributes, "features": feature_attributes}
"""Functions that return the units of a column, by group; the columns of ``info`` have none."""

Value = float | int | str
Row = Mapping[str, Value]


def make_columns(rows: Sequence[Row]) -> dict[str, NDArray[Any]]:
    """Convert one mapping per job into one array per name: float64, or strings if any value is a string.

    A missing value becomes NaN, or the empty string.
    """
    names = dict.fromkeys(name for row in rows for name in row)
    return {name: _make_column([row.get(name) for row in rows]) for name in names}


def _make_column(values: Sequence[Value | None]) -> NDArray[Any]:
    if any(isinstance(value, str) for value in values):
        return np.array(["" if value is None else str(value) for value in values], object)
    return np.array([math.nan if value is None else value for value in values], np.float64)


def write_jobs(file: h5py.File, ids: Sequence[str]) -> h5py.Dataset:
    """Write the dimension ``job``, a scale with the job ids; return it."""
    jobs = file.create_dataset("job", data=np.array(ids, object), dtype=TEXT)
    jobs.make_scale("job")
    jobs.attrs["long_name"] = "job id"
    return jobs


def write_columns(
    file: h5py.File, jobs: h5py.Dataset, group: str, columns_by_name: Mapping[str, NDArray[Any]]
) -> None:
    """Write a group of columns over ``job``, sorted by name."""
    names = sorted(columns_by_name)
    number_names = [name for name in names if columns_by_name[name].dtype != object]
    text_names = [name for name in names if columns_by_name[name].dtype == object]
    dimension = GROUPS[group]
    if number_names:
        scale = _write_table(
            file,
            jobs,
            group,
            dimension,
            np.stack([columns_by_name[name] for name in number_names], axis=1),
            number_names,
        )
        if group in ATTRIBUTES:
            unit_texts = [ATTRIBUTES[group](name).get("units", "") for name in number_names]
            units = file.create_dataset(f"{dimension}_units", data=unit_texts, dtype=TEXT)
            units.dims[0].attach_scale(scale)
    if text_names:
        texts = _encode(np.stack([columns_by_name[name] for name in text_names], axis=1))
        _write_table(file, jobs, f"{dimension}_text", f"{dimension}_text_name", texts, text_names)


def _write_table(
    file: h5py.File, jobs: h5py.Dataset, name: str, dimension: str, values: NDArray[Any], names: Sequence[str]
) -> h5py.Dataset:
    """Write a dataset (job, name) with its scales; return the scale of the names."""
    table = file.create_dataset(name, data=values, compression="gzip", compression_opts=1, shuffle=True)
    scale = file.create_dataset(dimension, data=names, dtype=TEXT)
    scale.make_scale(dimension)
    table.dims[0].attach_scale(jobs)
    table.dims[1].attach_scale(scale)
    return scale


def _encode(texts: NDArray[Any]) -> NDArray[np.bytes_]:
    """Encode strings as UTF-8 of fixed length, because gzip does not compress variable-length strings."""
    encoded = np.char.encode(texts.astype(str), "utf-8")
    return encoded.astype(h5py.string_dtype(length=max(encoded.dtype.itemsize, 1)))


def read_columns(file: Hdf5, groups: Sequence[str] = tuple(GROUPS)) -> dict[str, NDArray[Any]]:
    """Read the columns over ``job`` of a unit or of the table: ``job``, ``features/velocity@BPFO`` ...

    Raises one of UNREADABLE for a damaged file, and for columns that do not have one value per job.
    """
    tables = [name for group in groups for name in _table_names(file, group)]
    file.check_size("the sum of its columns", file.cost("job", *tables))
    jobs = file.texts("job")
    by_name = {f"{group}/{name}": column for group in groups for name, column in _read_group(file, group)}
    for name, column in by_name.items():
        if column.shape != jobs.shape:
            raise Unreadable(f"{name} has {len(column)} rows, not {len(jobs)}")
        if column.dtype == object and name.startswith("features/"):
            raise Unreadable(f"{name} contains no numbers")
        if not is_line(name):
            raise Unreadable(f"{name!a} is not a column name")
    return {"job": jobs} | by_name


def _table_names(file: Hdf5, group: str) -> list[str]:
    """Return the names of the existing datasets of a group: numbers, then strings."""
    return [name for name in (group, f"{GROUPS[group]}_text") if name in file]


def _read_group(file: Hdf5, group: str) -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield name and values of each column of a group."""
    dimension = GROUPS[group]
    for table in _table_names(file, group):
        if table == group:
            yield from zip(file.texts(dimension), file.numbers(group).T, strict=True)
        else:
            yield from zip(file.texts(f"{dimension}_text_name"), file.texts(table).T, strict=True)
