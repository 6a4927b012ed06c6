"""`bearingsim export`: features and series in files that other programs read."""

from collections.abc import Callable, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from bearingsim.errors import UserError
from bearingsim.text.spreadsheets import csv_text

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.store import Results, Series

__all__ = ["STDOUT", "check", "features", "series"]


def features(results: "Results", path: Path | None, file_format: str | None, force: bool) -> Path:
    """Write the table of jobs (swept values and features in SI) to csv or parquet; return the file.

    force: in place of a file that is there. Raises UserError for one without it.
    """
    made: dict[str, Callable[[pd.DataFrame], bytes]] = {
        "csv": lambda table: csv_text(table).encode(),
        "parquet": _parquet,
    }
    target = path or Path(f"{results.plan['study']}-features.{file_format or 'csv'}")
    make = made[_suffix(target, tuple(made))]
    _refuse_existing(target, force)
    _write(target, make(results.table()))
    return target


def series(
    results: "Results", jobs: Sequence[str], path: Path | None, file_format: str | None, force: bool
) -> Path:
    """Write the recorded series (SI) of some jobs to csv or mat; return the file.

    force: in place of a file that is there. Raises UserError for one without it, ResultsError.
    """
    target = path or Path(f"{results.plan['study']}-series.{file_format or 'csv'}")
    suffix = _suffix(target, ("csv", "mat"))
    _refuse_existing(target, force)
    found = {job: results.series(job) for job in jobs}
    empty = [job for job, one in found.items() if not one.channels]
    if empty:
        raise UserError(f"job {empty[0]} has no series: the study says `record: []`")
    _write(target, _csv(found) if suffix == "csv" else _mat(found, results.parameters()))
    return target


STDOUT = Path("-")
"""The file that stands for stdout, which gets csv."""


def check(features: Path | None, jobs: Sequence[str], out: Path | None, file_format: str | None) -> None:
    """Refuse a file of series without a job, two tables on one stdout, and any format there but csv."""
    if out is not None and not jobs:
        raise UserError("`--out` is the file of series: name a job with `--series`, or say `--features FILE`")
    if features == out == STDOUT:
        raise UserError("--features - and --out -: one of them can go to stdout, name a file for the other")
    if STDOUT in (features, out) and file_format not in (None, "csv"):
        raise UserError(f"stdout gets csv, not {file_format}: leave `--format` out, or name a file")


def _refuse_existing(target: Path, force: bool) -> None:
    if not force and target != STDOUT and (target.exists() or target.is_symlink()):
        raise UserError(f"{target} exists already: name another file, or say --force to replace it")


def _write(target: Path, content: bytes) -> None:
    """Write a file, or stdout."""
    from bearingsim.store import write_bytes

    if target == STDOUT:
        typer.echo(content, nl=False)
    else:
        write_bytes(target, content)


def _suffix(path: Path, known: tuple[str, ...]) -> str:
    """The format that a file's name asks for. Raises UserError for another, or where there is no folder."""
    if path == STDOUT:
        return "csv"
    suffix = path.suffix.removeprefix(".").lower()
    if suffix not in known:
        raise UserError(f"{path}: expected a name that ends in .{' or .'.join(known)}")
    if not path.parent.is_dir():
        raise UserError(f"{path}: there is no folder {path.parent}")
    return suffix


def _parquet(table: "pd.DataFrame") -> bytes:
    """Return the content of a parquet file. Raises UserError without pyarrow, or with one too old for pandas."""
    try:
        content: bytes = table.to_parquet(None, engine="pyarrow", index=False)
    except ImportError:
        raise UserError(
            "parquet needs pyarrow: `pip install 'bearingsim[parquet]'`, or name a .csv file"
        ) from None
    return content


def _csv(found: "dict[str, Series]") -> bytes:
    """One time column, one column per channel (and job, if there are several); units in the heads."""
    import numpy as np
    import pandas as pd

    first = next(iter(found.values()))
    if not all(np.array_equal(one.time, first.time) for one in found.values()):
        raise UserError("the jobs have different time axes: write them to .mat, or one by one")
    columns: dict[str, Any] = {"time [s]": first.time}
    for job, one in found.items():
        before = f"{job}/" if len(found) > 1 else ""
        columns |= {f"{before}{name} [{one.units[name]}]": values for name, values in one.channels.items()}
    return csv_text(pd.DataFrame(columns)).encode()


def _mat(found: "dict[str, Series]", parameters: "pd.DataFrame") -> bytes:
    """One struct per job, `job_<id>`: time, channels, their units, the job's parameters (SI, or words)."""
    from scipy.io import savemat

    structs = {
        f"job_{job}": {
            **_fields({"time": one.time} | one.channels),
            "units": _fields({"time": "s"} | one.units),
            "parameters": _fields(parameters.loc[job].replace("", None).dropna().to_dict()),
        }
        for job, one in found.items()
    }
    file: Any = BytesIO()
    savemat(file, structs, oned_as="column", long_field_names=True)
    return bytes(file.getvalue())


def _fields(named: Mapping[Any, Any]) -> dict[str, Any]:
    """Dots of names as underscores: what MATLAB takes as the name of a field."""
    return {str(name).replace(".", "_"): value for name, value in named.items()}
