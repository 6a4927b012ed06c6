"""`bearingsim export`: table of features as csv or parquet, time series as csv or mat."""

from collections.abc import Callable, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from bearingsim.errors import UserError
from bearingsim.text.spreadsheets import csv_text
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.store import Results, Series


TABLE_FORMATS, SERIES_FORMATS = ("csv", "parquet"), ("csv", "mat")


def choose_files(
    results: "Results",
    features: Path | None,
    jobs: Sequence[str],
    out: Path | None,
    file_format: str | None,
    force: bool,
) -> tuple[Path | None, Path | None]:
    """Return the files of the table and of the series; None for one that is not written.

    force: replace existing files. Raises UserError for an existing file without it, for another format, and for
    one file for both, because the series would replace the table.
    """
    study = results.plan["study"]
    table = features or (None if jobs else Path(f"{study}-features.{file_format or 'csv'}"))
    series = out or Path(f"{study}-series.{file_format or 'csv'}") if jobs else None
    if table and series and table.resolve() == series.resolve():
        raise UserError(f"{series} is named for the table and for the time series; name two files")
    for path, formats in ((table, TABLE_FORMATS), (series, SERIES_FORMATS)):
        if path is not None:
            _suffix(path, formats)
            _refuse_existing(path, force)
    return table, series


def write_features(results: "Results", target: Path) -> None:
    """Write the table of jobs to csv or parquet (`-`: to stdout).

    Values are in SI; csv has headers with units, and swept speeds in the unit of the study.
    """
    writers: dict[str, Callable[[pd.DataFrame], bytes]] = {
        "csv": lambda table: csv_text(_with_units(table, results.plan["units"])).encode(),
        "parquet": _to_parquet,
    }
    write = writers[_suffix(target, TABLE_FORMATS)]
    _write(target, write(results.table()))


def write_series(results: "Results", jobs: Sequence[str], target: Path) -> None:
    """Write the recorded series (SI) of some jobs to csv or mat (`-`: to stdout).

    Raises UserError for a job without series, and ResultsError for an unknown or unfinished job.
    """
    series_by_job = {job: results.series(job) for job in jobs}
    empty_jobs = [job for job, job_series in series_by_job.items() if not job_series.channels]
    if empty_jobs:
        raise UserError(f"job {empty_jobs[0]} has no series because the study has `record: []`")
    write = _to_csv if _suffix(target, SERIES_FORMATS) == "csv" else _to_mat
    _write(target, write(series_by_job, results))


def finished_jobs(results: "Results") -> list[str]:
    """Return the finished jobs of the table, and report the number of others on stderr.

    Raises UserError if no job is finished.
    """
    status = results.table().set_index("job")["status"]
    jobs = [job for job in results.jobs if status[job] == "done"]
    if not jobs:
        has_failed = bool((status == "failed").any())
        advice = "`bearingsim show --failed` lists failures" if has_failed else "repeat `bearingsim run`"
        raise UserError(f"no job is done: {advice}")
    if len(jobs) < len(results.jobs):
        say(f"{len(results.jobs) - len(jobs)} of {len(results.jobs)} jobs omitted, because not done", err=True)
    return jobs


STDOUT = Path("-")
"""Path that means stdout, to which only csv is written."""


def check_options(features: Path | None, jobs: Sequence[str], out: Path | None, file_format: str | None) -> None:
    """Raise UserError for a series file without jobs, two tables on stdout, or a format other than csv there."""
    if out is not None and not jobs:
        raise UserError("`--out` is for time series; name a job with `--series`, or use `--features FILE`")
    if features == out == STDOUT:
        raise UserError("--features - and --out -: only one can go to stdout; name a file for the other")
    if STDOUT in (features, out) and file_format not in (None, "csv"):
        raise UserError(f"only csv can go to stdout, not {file_format}; omit `--format`, or name a file")


def _refuse_existing(target: Path, force: bool) -> None:
    if not force and target != STDOUT and (target.exists() or target.is_symlink()):
        raise UserError(f"{target} exists; name another file, or use --force to overwrite it")


def _write(target: Path, content: bytes) -> None:
    """Write to a file or stdout."""
    from bearingsim.store import write_bytes

    if target == STDOUT:
        typer.echo(content, nl=False)
    else:
        write_bytes(target, content)


def _suffix(path: Path, formats: tuple[str, ...]) -> str:
    """Return the format of a file by its suffix.

    Raises UserError for a format that is not in ``formats``, or a missing folder.
    """
    if path == STDOUT:
        return "csv"
    suffix = path.suffix.removeprefix(".").lower()
    if suffix not in formats:
        raise UserError(f"{path}: expected a name that ends in .{' or .'.join(formats)}")
    if not path.parent.is_dir():
        raise UserError(f"{path}: there is no folder {path.parent}")
    return suffix


def _with_units(table: "pd.DataFrame", units: Mapping[str, str]) -> "pd.DataFrame":
    """Add units to the headers, and convert swept speeds from rad/s to the unit of the study."""
    from bearingsim.plots import labels

    headers, converted = {}, table.copy(deep=False)
    for name in map(str, table):
        unit = labels.table_unit(name, units)
        if name in units and unit and table[name].dtype.kind == "f":
            converted[name] = [_rounded(labels.to_unit(name, value, unit)) for value in table[name]]
        headers[name] = f"{name} ({unit})" if unit else name
    return converted.rename(columns=headers)


def _rounded(value: float) -> float:
    """Round a converted value to 12 digits, which removes rounding errors: 1800 rpm, not 1799.9999999999998."""
    return float(f"{value:.12g}")


def _to_parquet(table: "pd.DataFrame") -> bytes:
    """Return the content of a parquet file. Raises UserError if pyarrow is missing or too old for pandas.

    A column that mixes numbers and words, such as a clearance of `C3` and 10 um, is written as text, as in csv.
    """
    mixed: dict[str, list[Any]] = {
        str(name): [str(value) if isinstance(value, float) and value == value else value for value in table[name]]
        for name in table
        if table[name].dtype == object
    }
    try:
        content: bytes = table.assign(**mixed).to_parquet(None, engine="pyarrow", index=False)
    except ImportError:
        raise UserError(
            "parquet needs pyarrow: `pip install 'bearingsim[parquet]'`, or name a .csv file"
        ) from None
    return content


def _to_csv(series_by_job: "dict[str, Series]", results: "Results") -> bytes:
    """Return csv with a column of time, and for each job a column per channel and one of the instantaneous speed.

    Headers contain the unit, and the job if there are several. Raises UserError for jobs with different time axes.
    """
    import numpy as np
    import pandas as pd

    from bearingsim.plots.lines import speeds

    reference = next(iter(series_by_job.values()))
    if not all(np.array_equal(job_series.time, reference.time) for job_series in series_by_job.values()):
        raise UserError("the jobs have different time axes; export them to .mat, or one at a time")
    columns: dict[str, Any] = {"time [s]": reference.time}
    parameters, info = results.parameters(), results.info()
    for job, job_series in series_by_job.items():
        prefix = f"{job}/" if len(series_by_job) > 1 else ""
        columns |= {
            f"{prefix}{name} [{job_series.units[name]}]": values for name, values in job_series.channels.items()
        }
        speed = speeds(parameters.loc[job].to_dict(), info.loc[job].to_dict(), job_series.time)
        rpm = 30.0 / np.pi * speed
        columns[f"{prefix}speed [rpm]"] = list(map(_rounded, rpm))
    return csv_text(pd.DataFrame(columns)).encode()


def _to_mat(series_by_job: "dict[str, Series]", results: "Results") -> bytes:
    """Return a mat file with a struct per job, `job_<id>`: time, channels, units, parameters (SI, or text)."""
    from scipy.io import savemat

    from bearingsim.store.names import as_number

    parameters = results.parameters()
    structs = {
        f"job_{job}": {
            **_fields({"time": job_series.time} | job_series.channels),
            "units": _fields({"time": "s"} | job_series.units),
            "parameters": _fields(
                {
                    path: as_number(str(path), value)
                    for path, value in parameters.loc[job].replace("", None).dropna().to_dict().items()
                }
            ),
        }
        for job, job_series in series_by_job.items()
    }
    file: Any = BytesIO()
    savemat(file, structs, oned_as="column", long_field_names=True)
    return bytes(file.getvalue())


def _fields(entries: Mapping[Any, Any]) -> dict[str, Any]:
    """Replace dots in names by underscores, because MATLAB allows no dots in field names."""
    return {str(name).replace(".", "_"): value for name, value in entries.items()}
