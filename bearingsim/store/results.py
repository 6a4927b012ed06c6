"""Access to a results folder: table of its jobs, series of a job, and all data as a dataset of xarray."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bearingsim.errors import ResultsError
from bearingsim.store.arrays import build_dataset, swept_paths
from bearingsim.store.files import refuse_links
from bearingsim.store.journal import Failure, read_failures
from bearingsim.store.measured import MeasuredSet, measured_sets
from bearingsim.store.names import parameter_attributes
from bearingsim.store.sealed import UNREADABLE
from bearingsim.store.spread import spread
from bearingsim.store.table import info, job_frame, read_plan, rows_of, table
from bearingsim.store.units import Series, read_series, unit_path
from bearingsim.text.html import describe_values, quantity, table_html

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def open_results(path: str | Path) -> "Results":
    """Open the results folder of a study.

    Raises ResultsError if the folder has no plan or a damaged one, and LinkInFolder if a subfolder is a link.
    """
    results = Results(Path(path))
    plan = results.path / "plan.json"
    if not plan.is_file():
        default = Path("results") / results.path.name
        has_default = (default / plan.name).is_file()
        advice = f"did you mean {default}?" if has_default else "write them with `bearingsim run STUDY`"
        reason = "no plan.json" if results.path.exists() else "there is no such folder"
        raise ResultsError(f"{results.path} contains no results of a study ({reason}): {advice}")
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
    """Results of a study, read on first access and cached, so that later changes of the folder have no effect."""

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
    def frame(self) -> "pd.DataFrame":
        """Data of each planned job, indexed by id: parameters, features, info, status, in SI (not a copy)."""
        return job_frame(self.path)

    @cached_property
    def _table(self) -> "pd.DataFrame":
        return table(self.plan, self.frame)

    @cached_property
    def _parameters(self) -> "pd.DataFrame":
        done = self.frame[self.frame["status"] == "done"]
        return done.filter(regex="^parameters/").rename(columns=lambda name: name.partition("/")[2])

    def table(self) -> "pd.DataFrame":
        """Return one row per job, in SI.

        Columns: ``job``, swept paths, features, status, reason, seconds, healthy, unit.
        """
        return self._table.copy()

    @cached_property
    def measured(self) -> list[MeasuredSet]:
        """Measured features of the study, each with the simulated one."""
        return measured_sets(self.plan, self._table)

    def parameters(self) -> "pd.DataFrame":
        """Return all resolved parameters of the finished jobs in SI, indexed by job."""
        return self._parameters.copy()

    def info(self) -> "pd.DataFrame":
        """Return the solver statistics of finished jobs (step, CPU time, error estimates), indexed by job."""
        return info(self.frame)

    def values(self, feature: str) -> "pd.Series[float]":
        """Return a feature (SI) of the finished jobs, variations included, by job; empty if none has it."""
        import pandas as pd

        return self.frame.get(f"features/{feature}", pd.Series(dtype=float)).copy()

    def spread(self, feature: str, quantity: str | None = None) -> "pd.DataFrame":
        """Return ``least`` and ``largest`` (SI) of a feature over the variations of `uncertainty:`, by job.

        quantity: the varied quantity, None for all. NaN where a standard error is unknown.
        """
        return spread(self.plan, self.frame, feature, quantity)

    def failures(self) -> dict[str, Failure]:
        """Return the planned jobs that failed, by id, with reason, advice and traceback."""
        status = self.frame["status"]
        return {job: failure for job, failure in read_failures(self.path).items() if status.get(job) == "failed"}

    def series(self, job: str) -> Series:
        """Read the recorded series of a job. Raises ResultsError for an unknown or unfinished job."""
        if job not in self.frame.index:
            raise ResultsError(f"no job {job} in {self.path}")
        row = self.frame.loc[job]
        if row["status"] != "done":
            raise ResultsError(f"job {job} has no series: {row['reason'] or 'not computed yet'}")
        return read_series(unit_path(self.path, str(row["unit"])), job)

    def to_xarray(self, jobs: Sequence[str] | None = None, grid: bool = False) -> "xr.Dataset":
        """Return series, features and swept values of finished jobs over ``job`` and ``time``.

        jobs: ids of the jobs, by default of all; grid: True for a dimension for each swept path instead of
        ``job``, without healthy baselines. Paths that are determined by others, as in a `zip` or `derived`, are
        then coordinates along these, and jobs that are not done are NaN. Loads all series into memory. Raises
        ResultsError if xarray is missing, a named job is unknown or (without a grid) not done, time axes differ,
        or the grid of cases is not full.
        """
        return build_dataset(self.plan, self._table, self.has_feature, self.series, jobs, grid)

    def has_feature(self, name: str) -> bool:
        """Check if any job has a feature."""
        return f"features/{name}" in self.frame

    def _repr_html_(self) -> str:
        """Return a summary for notebooks."""
        rows = [("folder", str(self.path)), ("jobs", _counts(self.frame["status"]))]
        table = self._table
        for path in filter(table.__contains__, swept_paths(self.plan)):
            values = list(dict.fromkeys(table[path].dropna()))
            unit = parameter_attributes(path).get("units", "")
            rows.append((path, describe_values(values, partial(quantity, unit=unit))))
        rows.append(("content", "table(), parameters(), info(), series(job), failures(), to_xarray()"))
        return table_html(f"Results of {self.plan['study']}", rows)


def _counts(status: "pd.Series[str]") -> str:
    """Format the numbers of jobs by status: `12 done, 1 failed`."""
    return ", ".join(f"{count} {name}" for name, count in status.value_counts().items())
