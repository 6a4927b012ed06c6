"""Results as a dataset of xarray, over jobs or over a grid of the swept values."""

from collections.abc import Callable, Hashable, Mapping, Sequence
from itertools import product
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np

from bearingsim.errors import ResultsError
from bearingsim.store.names import channel_attributes, feature_attributes, parameter_attributes
from bearingsim.store.units import Series

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def dataset(
    plan: Mapping[str, Any],
    table: "pd.DataFrame",
    is_feature: Callable[[str], bool],
    read: Callable[[str], Series],
    jobs: Sequence[str] | None,
    grid: bool,
) -> "xr.Dataset":
    """Return the dataset of ``Results.to_xarray``; read: reads the series of a job. Raises ResultsError."""
    try:
        import xarray as xr
    except ModuleNotFoundError:
        raise ResultsError("to_xarray needs the package xarray: pip install xarray h5netcdf") from None
    rows = table.set_index("job")
    unknown = sorted(set(jobs or ()) - set(rows.index))
    if unknown:
        raise ResultsError(f"no row of the table: {', '.join(unknown)}")
    selected = rows if jobs is None else rows.loc[list(dict.fromkeys(jobs))]
    if grid:
        selected = selected.loc[[job for job in selected.index if job in _cases(plan)]]
    done = selected[selected["status"] == "done"] if jobs is None else selected
    swept = [path for path in swept_paths(plan) if path in rows]
    columns = {
        str(name): ("job", done[name].to_numpy(), _attributes(str(name), name in swept))
        for name in done.columns
        if name in swept or is_feature(str(name))
    }
    series = _stack({str(job): read(str(job)) for job in done.index})
    data = xr.Dataset({**columns, **series}, coords={"job": done.index.to_numpy(object)})
    data = data.set_coords(sorted(swept)).assign_attrs(study=plan["study"])
    return _on_grid(data, selected[swept]) if grid else data


def swept_paths(plan: Mapping[str, Any]) -> list[str]:
    """List the swept paths of a plan in the order of the sweep."""
    return list(dict.fromkeys(path for entry in plan["jobs"] for path in entry["swept"]))


def _cases(plan: Mapping[str, Any]) -> set[str]:
    """Return the ids of the cases: jobs that are not computed for comparison only."""
    return {entry["job"] for entry in plan["jobs"] if not (entry["twin"] or entry.get("variation"))}


def _attributes(name: str, swept: bool) -> dict[str, str]:
    return parameter_attributes(name) if swept else feature_attributes(name)


def _stack(series: dict[str, Series]) -> dict[str, Any]:
    """Stack channels to arrays (job, time), and return them with the time axis as variables for xarray.

    A channel that a job has not recorded is NaN there: a healthy baseline has no slices.
    """
    if not series:
        return {}
    recorded = [job_series for job_series in series.values() if job_series.channels]
    time = recorded[0].time if recorded else np.empty(0)
    if not all(np.array_equal(job_series.time, time) for job_series in recorded):
        raise ResultsError("the jobs have different time axes; select jobs of one duration and sampling")
    absent = np.full(len(time), np.nan, np.float32)
    stacked = {
        name: (
            ("job", "time"),
            np.stack([job_series.channels.get(name, absent) for job_series in series.values()]),
            channel_attributes(name),
        )
        for name in dict.fromkeys(name for job_series in recorded for name in job_series.channels)
    }
    return {"time": ("time", time, {"units": "s"}), **stacked}


def _on_grid(data: "xr.Dataset", cases: "pd.DataFrame") -> "xr.Dataset":
    """Spread the jobs of a dataset over the grid of the swept values ``cases``; jobs that are not done are NaN.

    Raises ResultsError unless the cases form a full grid.
    """
    import xarray as xr

    axes, dependent = _axes(cases)
    shape = tuple(len(values) for values in axes.values())
    positions = {job: tuple(axes[path][cases.at[job, path]] for path in axes) for job in cases.index}
    count = len(set(positions.values()))
    if not count == len(positions) == prod(shape):
        sizes = ", ".join(f"`{path}` {len(values)}" for path, values in axes.items())
        raise ResultsError(
            f"the cases do not form a full grid: values of {sizes}; cases {len(positions)}, "
            f"{count} of {prod(shape)} combinations; use to_xarray() without `grid`"
        )
    order = tuple(np.array([positions[str(job)] for job in data["job"].values], int).reshape(-1, len(axes)).T)
    variables = {
        name: (_dimensions(variable.dims, axes), _spread(variable.values, order, shape), variable.attrs)
        for name, variable in data.variables.items()
        if "job" in variable.dims and name not in cases
    }
    coordinates: dict[Hashable, Any] = {path: (path, list(values)) for path, values in axes.items()}
    for path, leading in dependent.items():
        values = dict(zip(cases[leading].itertuples(index=False, name=None), cases[path], strict=True))
        grid = [values[point] for point in product(*(axes[axis] for axis in leading))]
        coordinates[path] = (leading, np.array(grid).reshape([len(axes[axis]) for axis in leading]))
    described = {name: (*item, parameter_attributes(str(name))) for name, item in coordinates.items()}
    time = {"time": data["time"]} if "time" in data.variables else {}
    return xr.Dataset(variables, coords=described | time, attrs=data.attrs)


def _axes(cases: "pd.DataFrame") -> tuple[dict[str, dict[Any, int]], dict[str, list[str]]]:
    """Return the values of each dimension with their positions, and the dimensions from which other paths follow.

    A path follows from others if each combination of their values has one value of it, as in a `zip` or `derived`.
    Of paths that follow from each other the first in the order of the sweep is a dimension.
    """
    values = {str(path): {value: i for i, value in enumerate(dict.fromkeys(cases[path]))} for path in cases}
    swept = [path for path in values if len(values[path]) > 1]
    leading = _reduced(cases, swept, [])
    dependent = {path: _reduced(cases, leading, [path]) for path in swept if path not in leading}
    return {path: values[path] for path in values if path not in dependent}, dependent


def _reduced(cases: "pd.DataFrame", paths: Sequence[str], targets: Sequence[str]) -> list[str]:
    """Remove paths, last ones first, as long as the others determine them, or the ``targets`` if given.

    Paths determine others if the latter add no combination of values.
    """
    remaining = list(paths)
    for path in reversed(paths):
        others = [other for other in remaining if other != path]
        if others and _count(cases, others) == _count(cases, [*others, *(targets or [path])]):
            remaining = others
    return remaining


def _count(cases: "pd.DataFrame", paths: Sequence[str]) -> int:
    """Count the different combinations of values of some paths."""
    return len(cases[list(paths)].drop_duplicates())


def _dimensions(dims: Sequence[Hashable], axes: Mapping[str, Any]) -> tuple[Hashable, ...]:
    return tuple(name for dim in dims for name in (axes if dim == "job" else (dim,)))


def _spread(values: np.ndarray, order: tuple[np.ndarray, ...], shape: tuple[int, ...]) -> np.ndarray:
    """Spread values (jobs, ...) over a grid; points without a job are NaN, or empty for words."""
    is_number = np.issubdtype(values.dtype, np.number)
    dtype = np.result_type(values.dtype, np.float32) if is_number else object
    spread = np.full(shape + values.shape[1:], np.nan if is_number else "", dtype)
    spread[order] = values
    return spread
