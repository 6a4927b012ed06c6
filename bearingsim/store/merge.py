"""Merge of several results folders of one study, from shards or from runs on other machines.

All files are checked before any is copied, and the source folders are only read. Files are copied unchanged, so
that an interrupted merge can be repeated, and repeating a complete merge changes nothing.
"""

import json
from collections import defaultdict
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from bearingsim.errors import UserError
from bearingsim.store.choices import read_choices, read_plans, write_choices
from bearingsim.store.files import copy, refuse_links, remove_leftovers, write_bytes
from bearingsim.store.folder import claim_results
from bearingsim.store.journal import Failure, clear_failure, log, read_failures
from bearingsim.store.own_files import TRIALS, UNITS
from bearingsim.store.regular import Unreadable, digest, read_regular
from bearingsim.store.results import Results, open_results
from bearingsim.store.scans import check_scans, copy_scans
from bearingsim.store.sealed import UNREADABLE, read_json, write_json
from bearingsim.store.table import OWN_FILE, STUDY_FILE, build_table
from bearingsim.store.units import DamagedUnit, check_unit, result_digests, unit_path

RUN_ENTRIES = {"file", "text", OWN_FILE, "made_of", "notes"}
"""Entries of a plan that may differ between runs of one study."""
REPORTED_FIRST = ("study", "model_version", "quick", "overrides", "jobs")
"""Entries of a plan whose differences are reported first."""
MAX_QUOTED_LENGTH = 60
"""Largest number of characters of a value quoted in a message."""


class Unmergeable(UserError):
    """Folders with different plans or contradictory results."""


@dataclass(frozen=True)
class MergeSummary:
    """Result of a merge.

    folders, copied, existing: numbers of merged folders, of copied units, and of units present before; jobs:
    number of jobs of the plan by status.
    """

    folders: int
    copied: int
    existing: int
    jobs: dict[str, int]

    def __str__(self) -> str:
        units = f"{self.copied} unit{'s' * (self.copied != 1)} copied" + (
            f", {self.existing} there before" if self.existing else ""
        )
        jobs = ", ".join(f"{count} {status}" for status, count in self.jobs.items() if count)
        job_count = sum(self.jobs.values())
        return f"{self.folders} folder{'s' * (self.folders > 1)} merged: {units}; {jobs} of {job_count} jobs"


def merge(folders: Sequence[Path], out: Path) -> MergeSummary:
    """Copy the results of some folders into ``out``, and build its table.

    ``out`` may already contain results of the same plan. Results of a job in several folders must be bitwise equal
    in features, time and channels; CPU time, date and host may differ. Raises Unmergeable if results differ, and
    for different studies, plans or versions of the model; DamagedUnit, ScanError, DamagedChoices and ResultsError
    for damaged files. All of these are raised before anything is copied.
    """
    _refuse_out_among(folders, out)
    sources = [out, *folders] if (out / "plan.json").is_file() else list(folders)
    results = [open_results(folder) for folder in sources]
    for other in results[1:]:
        _refuse_other_plan(results[0], other)
    units = {folder: UNITS.find(folder) for folder in (out, *folders)}
    sealed = _check_units([path for paths in units.values() for path in paths])
    scans = [path for folder in folders for path in check_scans(folder)]
    choices, plans = _merge_choices([out, *folders] if out.is_dir() else folders)
    study_file = None if out in sources else _read_study_file(folders[0])
    claim_results(out, results[0].plan["study"], results[0].plan["quick"])
    refuse_links(out)
    remove_leftovers(out)
    if study_file is not None:
        write_bytes(out / STUDY_FILE, study_file)
        write_json(out / "plan.json", results[0].plan | {OWN_FILE: False})
    if choices != read_choices(out):
        write_choices(out, choices, plans)
    copy_scans(scans, out)
    for folder in folders:
        _copy_trials(folder, out)
    # In reverse order, so that of units with the same name that of the first folder is copied.
    new_units = {path.stem: path for folder in reversed(folders) for path in units[folder]}
    for path in units[out]:
        new_units.pop(path.stem, None)
    for name, path in sorted(new_units.items()):
        copy(path, unit_path(out, name))
    _merge_failures(folders, out, sealed)
    status = build_table(out)["status"]
    if new_units:
        log(out, "merged", folders=[str(folder) for folder in folders], units=len(new_units))
    counts = {name: int((status == name).sum()) for name in ("done", "failed", "missing")}
    return MergeSummary(len(folders), len(new_units), len(units[out]), counts)


def _refuse_out_among(folders: Sequence[Path], out: Path) -> None:
    if any(folder.resolve() == out.resolve() for folder in folders):
        raise Unmergeable(f"{out} is one of the merged folders; use another one")


# Plans


def _read_study_file(folder: Path) -> bytes:
    """Read the study file of a folder. Raises Unmergeable if it is missing or a link."""
    try:
        return read_regular(folder / STUDY_FILE)
    except FileNotFoundError:
        advice = "run the study there again, which writes it; finished jobs are kept"
        raise Unmergeable(f"{folder} has no {STUDY_FILE}: {advice}") from None
    except Unreadable as error:
        raise Unmergeable(f"{folder / STUDY_FILE}: {error}") from None


def _refuse_other_plan(results: Results, other: Results) -> None:
    """Raise Unmergeable if the plans of two folders differ in an entry other than ``RUN_ENTRIES``."""
    differing = {
        name
        for name in {*results.plan, *other.plan} - RUN_ENTRIES
        if _entry_text(results, name) != _entry_text(other, name)
    }
    for name in [*REPORTED_FIRST, *sorted(differing)]:
        if name in differing:
            difference = _describe_plan_difference(name, results.plan, other.plan)
            raise Unmergeable(
                f"{results.path} and {other.path} contain results of two plans: {difference}"
                + (" (run the same study file in both; finished jobs are kept)" if name != "study" else "")
            )


def _entry_text(results: Results, name: str) -> str:
    """Return an entry of a plan as JSON, without the parts that may differ between runs of one study."""
    value = results.plan.get(name)
    if name == "accuracy" and value:  # the notes mention the plan of each choice, which depends on the run
        value = {key: entry for key, entry in value.items() if key != "notes"}
    if name == "measured" and value:  # the folder of the study may differ between machines
        value = [entry | {"points": [_without_folder(point) for point in entry["points"]]} for entry in value]
    return json.dumps(value, sort_keys=True)


def _without_folder(point: dict[str, Any]) -> dict[str, Any]:
    """Return a measured point with the name of its signal's file instead of the path."""
    signal = point.get("signal")
    return point if signal is None else point | {"signal": signal | {"path": Path(signal["path"]).name}}


def _describe_plan_difference(name: str, plan: dict[str, Any], other: dict[str, Any]) -> str:
    """Describe the difference of two plans in one entry, with both values if they are short."""
    if name == "jobs":
        jobs, other_jobs = ({entry["job"] for entry in entries["jobs"]} for entries in (plan, other))
        if jobs != other_jobs:
            return (
                f"{len(jobs - other_jobs)} jobs are only in the first, {len(other_jobs - jobs)} only in the second"
            )
        return "their jobs have other swept values"
    texts = [json.dumps(entries.get(name)) for entries in (plan, other)]
    values = f" ({texts[0]} and {texts[1]})" if max(map(len, texts)) <= MAX_QUOTED_LENGTH else ""
    return f"`{name}` differs{values}"


# Units


def _check_units(paths: Sequence[Path]) -> set[str]:
    """Check the units at all paths; return the ids of their jobs.

    Raises DamagedUnit, and Unmergeable if a job has different results in two units.
    """
    units = defaultdict[str, list[Path]](list)
    for path in paths:
        for job in _check_unit(path):
            units[job].append(path)
    shared = defaultdict[tuple[Path, Path], list[str]](list)
    for job, unit_paths in units.items():
        for other in unit_paths[1:]:
            shared[unit_paths[0], other].append(job)
    for (unit, other), jobs in shared.items():
        if unit.name != other.name or digest(unit) != digest(other):
            _refuse_other_results(unit, other, jobs)
    return set(units)


def _check_unit(path: Path) -> list[str]:
    """Check a unit, and return the ids of its jobs. Raises DamagedUnit with advice."""
    try:
        return check_unit(path)
    except DamagedUnit as damage:
        advice = "run the study there again with --verify to recompute damaged results"
        raise DamagedUnit(f"{path.parent}/{damage} ({advice})") from None


def _refuse_other_results(unit: Path, other: Path, jobs: Sequence[str]) -> None:
    """Raise Unmergeable if one of the jobs has different results in two units."""
    digests, other_digests = result_digests(unit, jobs), result_digests(other, jobs)
    for job in jobs:
        for name in sorted({*digests[job], *other_digests[job]}):
            value, other_value = digests[job].get(name), other_digests[job].get(name)
            if value != other_value:
                raise Unmergeable(
                    f"job {job} has other results in {unit} and in {other}:"
                    f" {_describe_difference(name, value, other_value)}"
                    " (by another processor, or other packages? Leave a folder out, or remove one of the units)"
                )


def _describe_difference(name: str, *contents: bytes | None) -> str:
    """Describe the difference of a quantity of a job between two units, with both values if they are numbers.

    contents: from ``result_digests``, None for a unit without the quantity.
    """
    if any(content is None for content in contents):
        return f"only one has `{name}`"
    if all(content is not None and len(content) == 8 for content in contents):
        values = [float(np.frombuffer(content)[0]) for content in contents if content is not None]
        return f"`{name}` is {values[0]!r} and {values[1]!r}"
    return f"`{name}` differs"


# Choices, trials and failures


def _copy_trials(source: Path, root: Path) -> None:
    """Copy the trials of another results folder, except existing and unreadable files.

    Files of the same name contain trials of the same cases, so an existing file is kept without comparison.
    """
    for path in TRIALS.find(source):
        target = root / path.relative_to(source)
        with suppress(*UNREADABLE):
            read_json(path)
            if not target.exists():
                write_bytes(target, read_regular(path))


def _merge_choices(folders: Sequence[Path]) -> tuple[dict[str, Any], dict[str, str]]:
    """Return the choices of all folders, and the plan of each choice, by key.

    Raises DamagedChoices, and Unmergeable if two folders have different choices for a case.
    """
    choices: dict[str, Any] = {}
    plans: dict[str, str] = {}
    origin: dict[str, Path] = {}
    for folder in folders:
        for name, choice in read_choices(folder).items():
            if choices.setdefault(name, choice) != choice:
                paths = f"{origin[name] / 'choices.json'} and {folder / 'choices.json'}"
                raise Unmergeable(f"{paths} chose different models for a case; omit one of the folders")
            origin.setdefault(name, folder)
        plans = read_plans(folder) | plans
    return choices, plans


def _merge_failures(folders: Sequence[Path], out: Path, sealed: set[str]) -> None:
    """Store the latest failure of each job without a result, and delete the failures of finished jobs."""
    stored = read_failures(out)
    for job in stored.keys() & sealed:
        clear_failure(out, job)
    latest: dict[str, Failure] = {}
    for failure in chain.from_iterable(read_failures(folder).values() for folder in (out, *folders)):
        if failure.job not in sealed and (failure.job not in latest or failure.when > latest[failure.job].when):
            latest[failure.job] = failure
    for job, failure in latest.items():
        if stored.get(job) != failure:
            failure.write(out)
