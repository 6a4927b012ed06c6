"""Results as an xarray Dataset, over jobs or over a grid of the swept values."""

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


def build_dataset(
    plan: Mapping[str, Any],
    table: "pd.DataFrame",
    is_feature: Callable[[str], bool],
    read_series: Callable[[str], Series],
    jobs: Sequence[str] | None,
    grid: bool,
) -> "xr.Dataset":
    """Build the dataset of ``Results.to_xarray``, from the plan and the table. Raises ResultsError.

    is_feature: checks if a column is a feature; read_series: reads the series of a job.
    """
    try:
        import xarray as xr
    except ModuleNotFoundError:
        raise ResultsError("to_xarray needs the package xarray: pip install xarray h5netcdf") from None
    rows = table.set_index("job")
    unknown = sorted(set(jobs or ()) - set(rows.index))
    if unknown:
        raise ResultsError(f"unknown jobs: {', '.join(unknown)}")
    selected = rows if jobs is None else rows.loc[list(dict.fromkeys(jobs))]
    if grid:
        selected = selected.loc[[job for job in selected.index if job in _cases(plan)]]
    included = selected[selected["status"] == "done"] if grid or jobs is None else selected
    swept = [path for path in swept_paths(plan) if path in rows]
    columns = {
        str(name): ("job", included[name].to_numpy(), _attributes(str(name), name in swept))
        for name in included.columns
        if name in swept or is_feature(str(name))
    }
    series = _stack({str(job): read_series(str(job)) for job in included.index})
    data = xr.Dataset({**columns, **series}, coords={"job": included.index.to_numpy(object)})
    data = data.set_coords(sorted(swept)).assign_attrs(study=plan["study"])
    return _arrange_on_grid(data, selected[swept]) if grid else data


def swept_paths(plan: Mapping[str, Any]) -> list[str]:
    """List the swept paths of a plan in the order of the sweep."""
    return list(dict.fromkeys(path for entry in plan["jobs"] for path in entry["swept"]))


def _cases(plan: Mapping[str, Any]) -> set[str]:
    """Return the ids of the cases: jobs that are not computed for comparison only."""
    return {entry["job"] for entry in plan["jobs"] if not (entry["twin"] or entry.get("variation"))}


def _attributes(name: str, swept: bool) -> dict[str, str]:
    return parameter_attributes(name) if swept else feature_attributes(name)


def _stack(series: dict[str, Series]) -> dict[str, Any]:
    """Stack channels to arrays (job, time); return them and the time axis as variables for xarray.

    A channel is NaN for jobs that have not recorded it: for example, a healthy baseline has no slices.
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


def _arrange_on_grid(data: "xr.Dataset", cases: "pd.DataFrame") -> "xr.Dataset":
    """Replace the dimension of the jobs by a grid of the swept values; jobs that are not done are NaN.

    cases: swept values (columns) by job. Raises ResultsError unless the cases form a full grid.
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
    indices = tuple(np.array([positions[str(job)] for job in data["job"].values], int).reshape(-1, len(axes)).T)
    variables = {
        name: (_dimensions(variable.dims, axes), _fill_grid(variable.values, indices, shape), variable.attrs)
        for name, variable in data.variables.items()
        if "job" in variable.dims and name not in cases
    }
    coordinates: dict[Hashable, Any] = {path: (path, list(values)) for path, values in axes.items()}
    for path, dimensions in dependent.items():
        values = dict(zip(cases[dimensions].itertuples(index=False, name=None), cases[path], strict=True))
        grid = [values[point] for point in product(*(axes[axis] for axis in dimensions))]
        coordinates[path] = (dimensions, np.array(grid).reshape([len(axes[axis]) for axis in dimensions]))
    described = {name: (*item, parameter_attributes(str(name))) for name, item in coordinates.items()}
    time = {"time": data["time"]} if "time" in data.variables else {}
    return xr.Dataset(variables, coords=described | time, attrs=data.attrs)


def _axes(cases: "pd.DataFrame") -> tuple[dict[str, dict[Any, int]], dict[str, list[str]]]:
    """Return the values of each dimension with their indices, and the dimensions that determine dependent paths.

    A path is dependent if each combination of values of other paths has only one value of it, as in a `zip` or
    `derived`. Of paths that determine each other, the first in the order of the sweep is a dimension.
    """
    values = {str(path): {value: i for i, value in enumerate(dict.fromkeys(cases[path]))} for path in cases}
    swept = [path for path in values if len(values[path]) > 1]
    dimensions = _remove_dependent(cases, swept, [])
    dependent = {path: _remove_dependent(cases, dimensions, [path]) for path in swept if path not in dimensions}
    return {path: values[path] for path in values if path not in dependent}, dependent


def _remove_dependent(cases: "pd.DataFrame", paths: Sequence[str], targets: Sequence[str]) -> list[str]:
    """Remove paths, beginning with the last, as long as the remaining ones determine the removed one.

    targets: paths to be determined instead of the removed one; empty for none. Paths determine others if adding
    these does not increase the number of combinations of values.
    """
    remaining = list(paths)
    for path in reversed(paths):
        others = [other for other in remaining if other != path]
        determined = [*others, *(targets or [path])]
        if others and _count_combinations(cases, others) == _count_combinations(cases, determined):
            remaining = others
    return remaining


def _count_combinations(cases: "pd.DataFrame", paths: Sequence[str]) -> int:
    """Count the different combinations of values of some paths."""
    return len(cases[list(paths)].drop_duplicates())


def _dimensions(dims: Sequence[Hashable], axes: Mapping[str, Any]) -> tuple[Hashable, ...]:
    return tuple(name for dim in dims for name in (axes if dim == "job" else (dim,)))


def _fill_grid(values: np.ndarray, indices: tuple[np.ndarray, ...], shape: tuple[int, ...]) -> np.ndarray:
    """Return values (jobs, ...) on a grid (*shape, ...); points without a job are NaN, or empty strings.

    indices: index of each job (jobs,) along each dimension of the grid.
    """
    is_number = np.issubdtype(values.dtype, np.number)
    dtype = np.result_type(values.dtype, np.float32) if is_number else object
    grid = np.full(shape + values.shape[1:], np.nan if is_number else "", dtype)
    grid[indices] = values
    return grid
