"""Access to a results folder: table of its jobs, series of a job, all data for xarray."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bearingsim.errors import UserError
from bearingsim.store.files import refuse_links
from bearingsim.store.journal import Failure, read_failures
from bearingsim.store.names import channel_attributes, feature_attributes, parameter_attributes
from bearingsim.store.sealed import UNREADABLE
from bearingsim.store.spread import spread
from bearingsim.store.table import info, job_frame, read_plan, rows_of, table
from bearingsim.store.units import Series, read_series, unit_path

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


class ResultsError(UserError):
    """A folder contains no results, or not the requested ones."""


def open_results(path: str | Path) -> "Results":
    """Open the results folder of a study.

    Raises ResultsError if the folder has no plan or a damaged one, and LinkInFolder if a subfolder is a link.
    """
    results = Results(Path(path))
    plan = results.path / "plan.json"
    if not plan.is_file():
        raise ResultsError(f"{results.path} holds no results of a study (it has no plan.json)")
    refuse_links(results.path)
    try:
        results.plan  # noqa: B018
    except PermissionError:
        raise
    except UNREADABLE as error:
        raise ResultsError(f"{plan} is damaged or of another version: run the study again ({error})") from None
    return results


def results_folder(name: str, quick: bool, out: str | Path | None) -> Path:
    """Return the results folder of a study: ``out``, or ``results/<study>`` (``-quick`` for a quick study)."""
    default = Path("results") / (f"{name}-quick" if quick else name)
    return Path(default if out is None else out).resolve()


def planned_jobs(root: Path) -> set[str]:
    """Return the ids of the jobs of the plan in a folder; an empty set without an intact plan."""
    try:
        return set(open_results(root).planned)
    except ResultsError:
        return set()


@dataclass(frozen=True)
class Results:
    """Results of a study at the time of the first access: they are read once and cached."""

    path: Path

    @cached_property
    def plan(self) -> dict[str, Any]:
        """Expanded study: its name, overrides, units of swept paths, figures and jobs."""
        return read_plan(self.path)

    @cached_property
    def jobs(self) -> tuple[str, ...]:
        """Ids of the rows of ``table()``: cases, then healthy baselines."""
        return tuple(entry["job"] for entry in rows_of(self.plan))

    @cached_property
    def planned(self) -> tuple[str, ...]:
        """Ids of all jobs of the plan: ``jobs``, then variations and audits."""
        return tuple(entry["job"] for entry in self.plan["jobs"])

    @cached_property
    def variations(self) -> list[dict[str, Any]]:
        """Variations by `uncertainty:`, with keys `of` (nominal job), `what`, `value` (SI), `job` (variation)."""
        return list(self.plan.get("variations", ()))

    @cached_property
    def _frame(self) -> "pd.DataFrame":
        return job_frame(self.path)

    @cached_property
    def _table(self) -> "pd.DataFrame":
        return table(self.plan, self._frame)

    @cached_property
    def _parameters(self) -> "pd.DataFrame":
        done = self._frame[self._frame["status"] == "done"]
        return done.filter(regex="^parameters/").rename(columns=lambda name: name.partition("/")[2])

    def table(self) -> "pd.DataFrame":
        """Return one row per job, in SI.

        Columns: ``job``, swept paths, features, status, reason, seconds, healthy, unit.
        """
        return self._table.copy()

    def parameters(self) -> "pd.DataFrame":
        """Return all resolved parameters of the finished jobs in SI, indexed by job."""
        return self._parameters.copy()

    def info(self) -> "pd.DataFrame":
        """Return the solver statistics of finished jobs (step, CPU time, error estimates), indexed by job."""
        return info(self._frame)

    def spread(self, feature: str) -> "pd.DataFrame":
        """Return ``least`` and ``largest`` (SI) of a feature over the variations of `uncertainty:`, by job."""
        return spread(self.plan, self._frame, feature)

    def failures(self) -> dict[str, Failure]:
        """Return the planned jobs that failed, by id, with reason, advice and traceback."""
        status = self._frame["status"]
        return {job: failure for job, failure in read_failures(self.path).items() if status.get(job) == "failed"}

    def series(self, job: str) -> Series:
        """Read the recorded series of a job. Raises ResultsError for an unknown or unfinished job."""
        if job not in self._frame.index:
            raise ResultsError(f"no job {job} in {self.path}")
        row = self._frame.loc[job]
        if row["status"] != "done":
            raise ResultsError(f"job {job} has no series: {row['reason'] or 'not computed yet'}")
        return read_series(unit_path(self.path, str(row["unit"])), job)

    def to_xarray(self, jobs: Sequence[str] | None = None) -> "xr.Dataset":
        """Return series, features and swept values of finished jobs (or some of them) over ``job`` and ``time``.

        Loads all series into memory. Raises ResultsError if xarray is missing, a job is unknown, or time axes
        differ.
        """
        try:
            import xarray as xr
        except ModuleNotFoundError:
            raise ResultsError("to_xarray needs the package xarray: pip install xarray h5netcdf") from None
        rows = self.table().set_index("job")
        unknown = sorted(set(jobs or ()) - set(rows.index))
        if unknown:
            raise ResultsError(f"no row of the table: {', '.join(unknown)}")
        done_rows = rows[rows["status"] == "done"] if jobs is None else rows.loc[list(jobs)]
        swept = {path for entry in self.plan["jobs"] for path in entry["swept"]}
        columns = {
            name: ("job", done_rows[name].to_numpy(), _attributes(name, name in swept))
            for name in done_rows.columns
            if name in swept or f"features/{name}" in self._frame
        }
        series = _stack({job: self.series(job) for job in done_rows.index})
        data = xr.Dataset({**columns, **series}, coords={"job": done_rows.index.to_numpy(object)})
        data = data.set_coords(sorted(swept))
        return data.assign_attrs(study=self.plan["study"])


def _attributes(name: str, swept: bool) -> dict[str, str]:
    return parameter_attributes(name) if swept else feature_attributes(name)


def _stack(series: dict[str, Series]) -> dict[str, Any]:
    """Stack channels to arrays (job, time), and return them with the time axis as variables for xarray."""
    if not series:
        return {}
    reference = next(iter(series.values()))
    if not all(np.array_equal(signals.time, reference.time) for signals in series.values()):
        raise ResultsError("the jobs have different time axes; select jobs of one duration and sampling")
    stacked = {
        name: (
            ("job", "time"),
            np.stack([signals.channels[name] for signals in series.values()]),
            channel_attributes(name),
        )
        for name in reference.channels
    }
    return {"time": ("time", reference.time, {"units": "s"}), **stacked}
