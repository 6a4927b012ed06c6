"""`bearingsim export`: features and series in files that other programs read."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bearingsim.errors import UserError

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.store import Results, Series

__all__ = ["features", "series"]


def features(results: "Results", path: Path | None, file_format: str | None) -> Path:
    """Write the table of jobs (swept values and features in SI) to csv or parquet; return the file."""
    writers: dict[str, Callable[[pd.DataFrame, Path], Any]] = {
        "csv": lambda table, file: table.to_csv(file, index=False),
        "parquet": lambda table, file: table.to_parquet(file, index=False),
    }
    target = path or Path(f"{results.plan['study']}-features.{file_format or 'csv'}")
    write = writers[_suffix(target, tuple(writers))]
    write(results.table(), target)
    return target


def series(results: "Results", jobs: Sequence[str], path: Path | None, file_format: str | None) -> Path:
    """Write the recorded series (SI) of some jobs to csv or mat; return the file. Raises ResultsError."""
    target = path or Path(f"{results.plan['study']}-series.{file_format or 'csv'}")
    suffix = _suffix(target, ("csv", "mat"))
    found = {job: results.series(job) for job in jobs}
    empty = [job for job, one in found.items() if not one.channels]
    if empty:
        raise UserError(f"job {empty[0]} has no series: the study says `record: []`")
    if suffix == "csv":
        _to_csv(found, target)
    else:
        _to_mat(found, results.parameters(), target)
    return target


def _suffix(path: Path, known: tuple[str, ...]) -> str:
    """The format that a file's name asks for. Raises UserError for another, or where there is no folder."""
    suffix = path.suffix.removeprefix(".").lower()
    if suffix not in known:
        raise UserError(f"{path}: expected a name that ends in .{' or .'.join(known)}")
    if not path.parent.is_dir():
        raise UserError(f"{path}: there is no folder {path.parent}")
    return suffix


def _to_csv(found: "dict[str, Series]", path: Path) -> None:
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
    pd.DataFrame(columns).to_csv(path, index=False)


def _to_mat(found: "dict[str, Series]", parameters: "pd.DataFrame", path: Path) -> None:
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
    savemat(path, structs, oned_as="column", long_field_names=True)


def _fields(named: Mapping[Any, Any]) -> dict[str, Any]:
    """Dots of names as underscores: what MATLAB takes as the name of a field."""
    return {str(name).replace(".", "_"): value for name, value in named.items()}
