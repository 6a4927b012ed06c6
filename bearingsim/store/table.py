"""Table of a study: parameters, features, status and unit of each job, in ``study.h5`` and ``results.csv``.

The table is built from ``plan.json``, the units and the stored failures, so it can be deleted and rebuilt. Rows of
unchanged units are read from ``study.h5``.
"""

import hashlib
import warnings
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bearingsim.config.names import read_band
from bearingsim.errors import DamageWarning
from bearingsim.store import regular
from bearingsim.store.checked_units import Rows, check_units
from bearingsim.store.columns import GROUPS, TEXT, read_columns, write_columns, write_jobs
from bearingsim.store.files import DiskFull, lock, write_text
from bearingsim.store.journal import Failure, read_failures
from bearingsim.store.layouts import check_plan
from bearingsim.store.names import sort_features
from bearingsim.store.nearness import error_bounds
from bearingsim.store.own_files import FAILURES, UNITS
from bearingsim.store.provenance import study_digest
from bearingsim.store.sealed import UNREADABLE, create_hdf5, open_hdf5, read_json, write_json
from bearingsim.store.spread import variation_errors
from bearingsim.text.spreadsheets import csv_text

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.study import Job, Study

JOB_COLUMNS = ("status", "reason", "healthy", "unit", "stamp")
"""Text columns of a frame outside the groups of ``columns.py``."""
STUDY_FILE, CSV_FILE = "study.yaml", "results.csv"
OWN_FILE = "own_study_file"
"""Entry of a plan: True if ``study.yaml`` in the folder is the user's study file, False if it is a copy."""
DIGESTS = ("fingerprint", "csv")
"""Digests stored in ``study.h5``: of the sources of the table, and of ``results.csv``."""


def write_plan(root: Path, study: "Study", jobs: Iterable["Job"], notes: Sequence[str] = ()) -> dict[str, Any]:
    """Write ``study.yaml`` (unless the study was read from there) and ``plan.json``; return the plan."""
    is_own_file = study.path is not None and Path(study.path).resolve() == (root / STUDY_FILE).resolve()
    plan = make_plan(study, jobs, notes) | {OWN_FILE: is_own_file}
    if not is_own_file:
        write_text(root / STUDY_FILE, study.text)
    write_json(root / "plan.json", plan)
    return plan


def make_plan(study: "Study", jobs: Iterable["Job"], notes: Sequence[str] = ()) -> dict[str, Any]:
    """Return the expansion of a study as plain data, such as its name, overrides, figures and jobs.

    notes: remarks on the study.
    """
    from bearingsim.core import MODEL_VERSION

    return {
        "study": study.name,
        "file": str(study.path) if study.path else None,
        "text": study.text,
        "overrides": dict(study.overrides),
        "quick": bool(study.quick),
        "model_version": MODEL_VERSION,
        "made_of": study_digest(study.files, study.overrides, bool(study.quick)),
        "notes": list(notes),
        "units": dict(study.units),
        "figures": [asdict(figure) for figure in study.figures],
        "measured": [asdict(entry) for entry in study.measured],
        "jobs": [
            {
                "job": job.id,
                "healthy": job.healthy,
                "twin": job.is_baseline,
                "variation": job.is_variation,
                "swept": dict(job.swept),
            }
            for job in jobs
        ],
        "design": None if study.design is None else asdict(study.design),
        "assumptions": list(study.assumptions),
        "accuracy": _accuracy(study),
        "nothing_uncertain": study.uncertainty == () and not study.left_out,
        "variations": [
            {"of": variation.of, "what": variation.what, "value": variation.value, "job": variation.job.id}
            for variation in study.variations()
        ],
    }


def _accuracy(study: "Study") -> dict[str, Any] | None:
    """Return accuracy, chosen models, curves and audits as plain data; None for a study without `accuracy`."""
    goal, selection = study.goal, study.selection
    if goal is None or selection is None:
        return None
    jobs = {job: choice._asdict() for job, choice in selection.jobs.items()}
    return {
        "within": goal.within,
        "of": list(goal.of),
        "jobs": jobs,
        "curves": [{"feature": feature, "jobs": list(curve_jobs)} for feature, curve_jobs in selection.curves],
        "audits": [{"of": audit.of, "job": audit.job.id} for audit in selection.audits],
        "notes": list(selection.notes),
    }


def read_plan(root: Path) -> dict[str, Any]:
    """Read the plan of a folder. Raises one of UNREADABLE if it is missing or damaged.

    The entry `design` is None in plans of earlier versions, which had no designs.
    """
    plan = {"design": None} | read_json(root / "plan.json")
    check_plan(plan)
    return plan


def read_study_text(root: Path) -> str:
    """Read the study file in a folder, which may have been edited since the run.

    Raises one of UNREADABLE if it is missing or not text.
    """
    return regular.read_regular(root / STUDY_FILE).decode()


def job_frame(root: Path) -> "pd.DataFrame":
    """Return the data of each planned job, indexed by id.

    Columns: ``parameters/...``, ``features/...``, ``info/...``, ``status`` (done, failed, missing), ``reason``,
    ``healthy`` (id of the healthy case), ``unit``. The frame is read from ``study.h5`` if that is up to date and
    ``results.csv`` exists; otherwise both are rebuilt, and written if possible.
    """
    fingerprint = _fingerprint(root)
    stored = read_frame(root)
    has_csv = (root / CSV_FILE).is_file()
    if stored is not None and stored.attrs["fingerprint"] == fingerprint and has_csv:
        return stored
    with suppress(OSError, DiskFull):
        return build_table(root)
    return _make_frame(root, read_plan(root), stored, {}, read_failures(root))


def plan_frame(root: Path, plan: Mapping[str, Any], rows: Rows) -> "pd.DataFrame":
    """Return the frame of ``job_frame`` for a plan that may differ from the one in the folder.

    rows: rows of units that have been read, by unit.
    """
    return _make_frame(root, plan, read_frame(root), rows, read_failures(root)).sort_index(axis=1)


def build_table(root: Path, rows: Rows | None = None) -> "pd.DataFrame":
    """Build ``study.h5`` and ``results.csv`` of a folder; return the frame of ``job_frame``.

    Nothing is written if both are up to date. rows: rows of units that have been read, by unit. Warns of
    unreadable files.
    """
    with lock(root):
        fingerprint = _fingerprint(root)
        stored = read_frame(root)
        digests = {"fingerprint": fingerprint, "csv": _digest(root / CSV_FILE)}
        if stored is not None and stored.attrs == digests:
            return stored
        plan = read_plan(root)
        frame = _make_frame(root, plan, stored, rows or {}, read_failures(root))
        write_text(root / CSV_FILE, csv_text(table(plan, frame)))
        _write_frame(root, frame, fingerprint)
    return frame.sort_index(axis=1)


def rows_of(plan: Mapping[str, Any]) -> list[dict[str, Any]]:
    """List the jobs of a plan with a row in its table: all except variations and audits."""
    return [entry for entry in plan["jobs"] if not entry.get("variation")]


def table(plan: Mapping[str, Any], frame: "pd.DataFrame") -> "pd.DataFrame":
    """Return one row per case and per healthy baseline.

    Columns: ``job``, swept paths (SI), features, status, reason, seconds, healthy, unit. Variations
    (``store/spread.py``) and audits have no rows; they contribute to the `error` columns.
    """
    import pandas as pd

    entries = rows_of(plan)
    # Computed from all jobs, including those without a row.
    ranges, bounds = variation_errors(plan, frame), error_bounds(plan, frame)
    frame = frame.loc[[entry["job"] for entry in entries]]
    swept = pd.DataFrame([entry["swept"] for entry in entries], index=frame.index)
    features = frame.filter(regex="^features/").rename(columns=lambda name: name.partition("/")[2])
    features = pd.concat([features, ranges.reindex(frame.index)], axis=1)
    features = features[sort_features(features.columns)]
    models_chosen = (plan.get("accuracy") or {"jobs": {}})["jobs"]
    if models_chosen:
        names = [models_chosen[job]["model"] if job in models_chosen else "" for job in frame.index]
        models = pd.DataFrame({"model": names})
        # The part `error.start` of `error` replaces the feature of this name, the relative error of the line.
        features = features.drop(columns=bounds.columns, errors="ignore")
        features = pd.concat([models.set_index(frame.index), bounds.reindex(frame.index), features], axis=1)
    seconds = frame["info/cpu_s"] if "info/cpu_s" in frame else pd.Series(np.nan, frame.index)
    states = pd.DataFrame({"status": frame["status"], "reason": frame["reason"], "seconds": seconds})
    jobs = pd.DataFrame({"job": frame.index}, index=frame.index)
    further_columns = [features, states, frame[["healthy", "unit"]]]
    swept = swept.drop(columns={name for columns in (jobs, *further_columns) for name in columns}, errors="ignore")
    return pd.concat([jobs, swept, *further_columns], axis=1).reset_index(drop=True)


def info(frame: "pd.DataFrame") -> "pd.DataFrame":
    """Return the solver statistics of the finished jobs, indexed by job; frame: from ``job_frame``."""
    done = frame[frame["status"] == "done"]
    return done.filter(regex="^info/").rename(columns=lambda name: name.partition("/")[2])


# Construction of the frame


def _make_frame(
    root: Path,
    plan: Mapping[str, Any],
    table_rows: "pd.DataFrame | None",
    rows: Rows,
    failures: Mapping[str, Failure],
) -> "pd.DataFrame":
    import pandas as pd

    ids = [entry["job"] for entry in plan["jobs"]]
    stored = _collect(root, table_rows, rows, ids).reindex(ids)
    stored = stored.drop(columns=[name for name in stored if _is_unset(str(name), stored[name])])
    done = stored["unit"].notna()
    reasons = pd.Series({job: failure.reason for job, failure in failures.items()}, dtype=object)
    reason = reasons.reindex(stored.index).where(~done)
    status = np.where(done, "done", np.where(reason.notna(), "failed", "missing"))
    healthy = [entry["healthy"] for entry in plan["jobs"]]
    states = pd.DataFrame({"reason": reason, "status": status, "healthy": healthy}, index=stored.index)
    frame = pd.concat([stored, states], axis=1)  # inserting columns one by one is slow
    text_columns = frame.select_dtypes(exclude="number").columns
    frame = frame.fillna(dict.fromkeys(text_columns, "")).astype(dict.fromkeys(text_columns, str))
    return pd.concat([frame, healthy_differences(frame)], axis=1)


def _is_unset(name: str, values: "pd.Series[Any]") -> bool:
    """Check if a parameter or band feature has no value, because its column is from jobs of an earlier plan."""
    is_optional = name.startswith("parameters/") or read_band(name.removeprefix("features/")) is not None
    return is_optional and values.dtype.kind == "f" and bool(values.isna().all())


def _collect(root: Path, table_rows: "pd.DataFrame | None", rows: Rows, ids: Sequence[str]) -> "pd.DataFrame":
    """Collect the rows of some jobs from the intact units; a job in several units is taken from the first.

    Units without any of the jobs add no columns.
    """
    import pandas as pd

    checked = check_units(UNITS.find(root), table_rows, rows)
    for path, reason in checked.damaged.items():
        text = f"{path} cannot be read ({reason}); its jobs count as missing. Run the study again."
        warnings.warn(text, DamageWarning, stacklevel=2)
    empty = {name: pd.Series(dtype=object) for name in ("unit", "stamp")}
    frames = [pd.DataFrame(empty, index=pd.Index([], name="job")), *checked.rows.values()]
    if table_rows is not None:
        unchanged_rows = table_rows[table_rows["unit"].isin(checked.in_table)].drop(
            columns=["status", "reason", "healthy"]
        )
        frames.append(unchanged_rows.loc[:, ~unchanged_rows.columns.str.endswith("-healthy")])
    planned = set(ids)  # `isin` would hash all ids again for each unit
    frames = [frame.loc[[job in planned for job in frame.index]] for frame in frames]
    intact_rows = pd.concat([frame for frame in frames if len(frame)] or frames[:1])
    return intact_rows[~intact_rows.index.duplicated()]


def healthy_differences(frame: "pd.DataFrame") -> "pd.DataFrame":
    """Compute the change of features from the healthy case, by job; NaN without a healthy case.

    It is ``|A - A_healthy|`` of the complex amplitudes A for each spectral line with a phase, and the difference
    of the values for features of a band, which have no phase.
    """
    import pandas as pd

    names = [str(name) for name in frame.columns if str(name).startswith("features/")]
    lines = [name.removesuffix(".phase") for name in names if name.endswith(".phase")]
    differences = {}
    for line in lines:
        amplitude = frame[line] * np.exp(1j * frame[f"{line}.phase"])
        baseline = amplitude.reindex(frame["healthy"]).to_numpy()
        differences[f"{line}-healthy"] = np.abs(amplitude.to_numpy() - baseline)
    for name in frame.columns:
        if read_band(str(name).removeprefix("features/")) is not None:
            baseline = frame[name].reindex(frame["healthy"]).to_numpy()
            differences[f"{name}-healthy"] = frame[name].to_numpy() - baseline
    return pd.DataFrame(differences, index=frame.index)


# study.h5


def _fingerprint(root: Path) -> str:
    """Return the digest of the plan, and of names, sizes and times of units and failures: the table's sources."""
    states = []
    for path in (*UNITS.find(root), *FAILURES.find(root)):
        with suppress(FileNotFoundError):  # another run has removed the failure, or renamed a damaged unit
            status = path.lstat()
            states.append(f"{path.name} {status.st_size} {status.st_mtime_ns}")
    listing = "\n".join(states)
    return hashlib.sha256(regular.read_regular(root / "plan.json") + listing.encode()).hexdigest()


def _digest(path: Path) -> str:
    try:
        return regular.digest(path)
    except (OSError, regular.Unreadable):
        return ""


def _write_frame(root: Path, frame: "pd.DataFrame", fingerprint: str) -> None:
    with create_hdf5(root / "study.h5") as file:
        jobs = write_jobs(file, list(frame.index))
        for name in JOB_COLUMNS:
            column = file.create_dataset(name, data=frame[name].to_numpy(object), dtype=TEXT)
            column.dims[0].attach_scale(jobs)
        for group in GROUPS:
            names = [name for name in frame.columns if name.startswith(f"{group}/")]
            columns = {name.partition("/")[2]: _column(frame[name]) for name in names}
            write_columns(file, jobs, group, columns)
        digests = (fingerprint, _digest(root / CSV_FILE))
        file.attrs.update({name: np.bytes_(digest) for name, digest in zip(DIGESTS, digests, strict=True)})


def _column(values: "pd.Series[Any]") -> NDArray[Any]:
    if values.dtype.kind in "fiub":
        return values.to_numpy(np.float64)
    return values.astype(str).to_numpy(object)


def read_frame(root: Path, groups: Sequence[str] = tuple(GROUPS)) -> "pd.DataFrame | None":
    """Read the frame in ``study.h5`` (or some groups of columns); None if the file is missing or damaged."""
    import pandas as pd

    try:
        with open_hdf5(root / "study.h5") as file:
            file.check_size("its columns", file.cost("job", *JOB_COLUMNS))
            columns = read_columns(file, groups) | {name: file.texts(name) for name in JOB_COLUMNS}
            digests = {name: file.attribute(name) for name in DIGESTS}
    except UNREADABLE:
        return None
    frame = pd.DataFrame(columns).set_index("job")
    frame = frame.sort_index(axis=1)
    frame.attrs.update(digests)
    return frame
