"""Totals of a run: jobs done by earlier runs, outcomes of units of work, and the summary."""

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bearingsim import store
from bearingsim.errors import UserError
from bearingsim.runner.findings import findings
from bearingsim.runner.summary import Findings, RunSummary, group_failures
from bearingsim.runner.work import Outcome
from bearingsim.study import read_outline

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.runner.select import TrialsInterrupted
    from bearingsim.study import Job, Study


@dataclass(frozen=True)
class Plan:
    """Plan of a run.

    pending: jobs to compute; resumed: number of jobs done by earlier runs; failures: earlier failures of jobs
    without a result, by id; holdings: contents of the results folder.
    """

    pending: list["Job"]
    resumed: int
    failures: dict[str, store.Failure]
    holdings: store.Holdings


def make_plan(
    root: Path, jobs: Sequence["Job"], retry_failed: bool, verify: bool, stored_before: set[str] | None
) -> Plan:
    """Determine the jobs to compute; remove failures of jobs that have been computed since.

    Such a failure remains if a run is killed after it has stored the job, but before it removes the failure. It
    would prevent the repetition of the job if its unit were damaged later. stored_before: ids of the jobs stored
    when the run began, None if no trials may have added some since.
    """
    holdings = store.read_holdings(root, verify)
    for job in holdings.failures.keys() & holdings.sealed:
        store.clear_failure(root, job)
    remaining = [job for job in jobs if job.id not in holdings.sealed]
    ids = {job.id for job in remaining}
    failures = {job: failure for job, failure in holdings.failures.items() if job in ids}
    pending = remaining if retry_failed else [job for job in remaining if job.id not in failures]
    resumed = [
        job for job in jobs if job.id in holdings.sealed and (stored_before is None or job.id in stored_before)
    ]
    return Plan(pending, len(resumed), failures, holdings)


@dataclass
class Tally:
    """Running total of the outcomes, which also stores failures and logs each unit in the journal.

    failures: of jobs without a result, by id; failed: number of jobs that failed in this run.
    """

    root: Path
    command: str
    failures: dict[str, store.Failure]
    max_failures: float = inf
    failed: int = 0
    done_by_others: int = 0
    start_cpu_s: float = 0.0
    cpu_s: float = 0.0
    integrator_cpu_s: float = 0.0

    @property
    def has_reached_limit(self) -> bool:
        """True if the number of jobs failed in this run has reached ``max_failures``."""
        return self.failed >= self.max_failures

    def add(self, outcome: Outcome) -> None:
        """Add the outcome of a unit of work."""
        self.failed += len(outcome.failed)
        self.done_by_others += len(outcome.done_by_others)
        self.start_cpu_s += outcome.start_cpu_s
        self.cpu_s += outcome.cpu_s
        self.integrator_cpu_s += outcome.integrator_cpu_s
        for job in (*outcome.done, *outcome.done_by_others):
            if self.failures.pop(job, None) is not None:
                store.clear_failure(self.root, job)
        for failure in outcome.failed:
            self._add_failure(failure)
        counts = {"done": len(outcome.done), "failed": len(outcome.failed)}
        unit = store.unit_name(outcome.done) if outcome.done else outcome.unit  # without failed jobs
        store.log(self.root, "unit", unit=unit, **counts, seconds=round(outcome.seconds, 3))

    def summary(
        self,
        study: str,
        status: "pd.Series[str]",
        resumed: int,
        seconds: float,
        interrupted: int,
        notes: tuple[str, ...],
        statements: Findings,
    ) -> RunSummary:
        """Summarise the run; status: of each requested job, from the table, with which the counts then agree."""
        return RunSummary(
            study=study,
            folder=self.root,
            planned=len(status),
            resumed=resumed,
            done=int((status == "done").sum()) - resumed,
            failures=group_failures(
                self.failures[job] for job in status.index[status == "failed"] if job in self.failures
            ),
            seconds=seconds,
            start_cpu_s=self.start_cpu_s,
            cpu_s=self.cpu_s,
            integrator_cpu_s=self.integrator_cpu_s,
            interrupted=interrupted,
            notes=notes,
            findings=statements,
        )

    def _add_failure(self, failure: store.Failure) -> None:
        earlier = self.failures.get(failure.job)
        attempts = failure.attempts + (earlier.attempts if earlier else 0)
        completed = replace(failure, attempts=attempts, command=self.command, when=store.now())
        self.failures[failure.job] = completed
        completed.write(self.root)


def interrupted_summary(
    study: "Study", root: Path, interruption: "TrialsInterrupted", seconds: float
) -> RunSummary:
    """Summarise a run that was interrupted during the trials of models; trials may have stored some jobs."""
    jobs = {job.id for job in study.jobs()}
    sealed = store.read_holdings(root).sealed
    return RunSummary(
        study=study.name,
        folder=root,
        planned=len(jobs),
        resumed=len(jobs & sealed),
        done=0,
        failures=(),
        seconds=seconds,
        interrupted=interruption.number,
        notes=(interruption.state,),
    )


def completed_summary(
    path: Path, out: Path | None, overrides: Mapping[str, str], quick: bool
) -> RunSummary | None:
    """Summarise a completed study without expanding it; None if jobs are missing or the plan may be out of date.

    The stored plan is up to date if files, overrides, program and working folder are unchanged. Plans of studies
    with `accuracy` are always expanded again.
    """
    started = time.perf_counter()
    study_outline = read_outline(path, overrides, quick)
    if study_outline is None or study_outline.quick != quick:
        return None
    root = store.results_folder(study_outline.name, quick, out)
    try:
        plan = store.read_plan(root)
        digest = store.study_digest(study_outline.files, study_outline.overrides, quick)
        is_unchanged = digest != "" and digest == plan["made_of"] and plan["accuracy"] is None
        frame = store.job_frame(root) if is_unchanged else None
    except store.UNREADABLE:
        return None
    if frame is None or not (frame["status"] == "done").all():
        return None
    return _summary_of_stored(root, plan, frame, started)


class ReadOnlyFolder(UserError):
    """Jobs of a study are missing in a results folder that cannot be written."""


def summary_of_read_only(study: "Study", root: Path, started: float) -> RunSummary:
    """Summarise a study whose jobs are all stored in a folder that cannot be written.

    study: with its models chosen; started: ``time.perf_counter()`` at the start. Raises ReadOnlyFolder if the plan
    or the results of the folder are not those of the study, or jobs are missing.
    """
    jobs = [job.id for job in study.jobs()]
    try:
        plan = store.read_plan(root)
        frame = store.job_frame(root)
    except store.UNREADABLE:
        plan, frame = {"jobs": []}, None
    done = set() if frame is None else set(frame.index[frame["status"] == "done"])
    if frame is None or {entry["job"] for entry in plan["jobs"]} != set(jobs) or not done.issuperset(jobs):
        count = sum(job not in done for job in jobs)
        missing = f"lacks {count} of {len(jobs)} jobs" if count else "has the plan of another study"
        raise ReadOnlyFolder(
            f"{root} is read-only for you and {missing}: copy it and name the copy by `--out`, or make it writable"
            f" (`chmod -R u+w {root}`)"
        )
    return _summary_of_stored(root, plan, frame, started)


def _summary_of_stored(root: Path, plan: Mapping[str, Any], frame: "pd.DataFrame", started: float) -> RunSummary:
    return RunSummary(
        study=plan["study"],
        folder=root,
        planned=len(frame),
        resumed=len(frame),
        done=0,
        failures=(),
        seconds=time.perf_counter() - started,
        notes=tuple(plan["notes"]),
        findings=findings(plan, frame),
    )


def other_run_notes(root: Path, plan: Mapping[str, Any], count: int) -> Iterator[str]:
    """Yield notes on other runs in the folder; plan: of this run; count: number of its jobs done by other runs."""
    if count:
        jobs = f"{count} jobs were" if count > 1 else "1 job was"
        yield f"{jobs} computed by another run in this folder"
    planned = store.planned_jobs(root)
    own_jobs = {entry["job"] for entry in plan["jobs"]}
    if planned != own_jobs:
        difference = (
            f"lacks {len(own_jobs - planned)} of this run's {len(own_jobs)} jobs"
            if own_jobs - planned
            else "has more jobs"
        )
        yield (
            f"another run has replaced the plan of this folder; its table {difference}"
            "; results are kept (repeat this command to restore its table)"
        )
