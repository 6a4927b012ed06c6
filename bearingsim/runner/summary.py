"""Summary of a run: numbers of jobs, time, failures grouped by reason, and statements on the results."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bearingsim.store import Failure


@dataclass(frozen=True)
class FailureGroup:
    """Failures of one kind: reason and advice of the first, and ids of all jobs."""

    reason: str
    advice: str
    jobs: tuple[str, ...]

    def __str__(self) -> str:
        advice = f" ({self.advice})" if self.advice else ""
        count = f"{len(self.jobs)} job" + ("s" if len(self.jobs) > 1 else "")
        return f"{count} failed: {self.reason}{advice}, for example {self.jobs[0]}"


def group_failures(failures: Iterable["Failure"]) -> tuple[FailureGroup, ...]:
    """Group failures whose reasons differ only in numbers, largest group first."""
    ordered = sorted(failures, key=lambda failure: (failure_kind(failure.reason), failure.job))
    groups = [list(group) for _, group in groupby(ordered, key=lambda failure: failure_kind(failure.reason))]
    kinds = [
        FailureGroup(group[0].reason, group[0].advice, tuple(failure.job for failure in group)) for group in groups
    ]
    return tuple(sorted(kinds, key=lambda group: -len(group.jobs)))


def failure_kind(reason: str) -> str:
    """Return a reason with `#` in place of its numbers, so that failures of one kind compare equal."""
    return re.sub(r"[-+]?\d[\d.]*(e[-+]?\d+)?", "#", reason)


@dataclass(frozen=True)
class Findings:
    """Statements on results.

    withdrawn: on accuracies refuted by audits; accuracy: on the accuracy of the results; assumptions: names of the
    assumptions; details: printed only on request.
    """

    withdrawn: tuple[str, ...] = ()
    accuracy: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    assumptions: tuple[str, ...] = ()
    details: tuple[str, ...] = ()

    @property
    def statements(self) -> tuple[str, ...]:
        """All statements except the names of assumptions."""
        return (*self.withdrawn, *self.accuracy, *self.warnings, *self.details)


@dataclass(frozen=True)
class RunSummary:
    """Result of a run.

    planned, resumed, done: numbers of jobs requested, done by earlier runs, and done by this run; seconds: elapsed
    time (s); start_cpu_s: CPU time (s) of the workers for imports and compilation; cpu_s: their CPU time (s) after
    that; integrator_cpu_s: part of ``cpu_s`` spent in the integrator; interrupted: signal number, or 0; notes: on
    earlier results and repairs; findings: statements on the results, None if the run ended before its jobs.
    """

    study: str
    folder: Path
    planned: int
    resumed: int
    done: int
    failures: tuple[FailureGroup, ...]
    seconds: float
    start_cpu_s: float = 0.0
    cpu_s: float = 0.0
    integrator_cpu_s: float = 0.0
    interrupted: int = 0
    notes: tuple[str, ...] = ()
    findings: Findings | None = None

    @property
    def failed(self) -> int:
        """Number of jobs that failed, now or in an earlier run."""
        return sum(len(group.jobs) for group in self.failures)

    @property
    def missing(self) -> int:
        """Number of planned jobs that are neither done nor failed."""
        return self.planned - self.resumed - self.done - self.failed

    @property
    def integrator_share(self) -> float:
        """Share of the workers' CPU time after start-up spent in the integrator; NaN if nothing was computed."""
        return self.integrator_cpu_s / self.cpu_s if self.cpu_s > 0 else float("nan")

    @property
    def exit_code(self) -> int:
        """Exit code: 0 if all jobs are done, 1 if some failed or are missing, 128 + signal if interrupted."""
        return 128 + self.interrupted if self.interrupted else int(self.failed > 0 or self.missing > 0)

    def __str__(self) -> str:
        return "\n".join([self.headline, *self.events, *self.details])

    @property
    def headline(self) -> str:
        """Study, numbers of jobs and time, as `small: 8 of 8 jobs done in 3.2 s, 2 of them already stored`."""
        done = self.done + self.resumed
        counts = {"of them already stored": self.resumed, "failed": self.failed, "left": self.missing}
        parts = [f"{count} {name}" for name, count in counts.items() if count]
        line = (
            f"{self.study}: {done} of {self.planned} job{'s' * (self.planned != 1)} done in {self.seconds:.1f} s"
        )
        return ", ".join([line, *parts])

    @property
    def events(self) -> tuple[str, ...]:
        """Failures, and notes on earlier results."""
        return (*map(str, self.failures), *self.notes)

    @property
    def statements(self) -> tuple[str, ...]:
        """All statements on the results."""
        return () if self.findings is None else self.findings.statements

    @property
    def details(self) -> tuple[str, ...]:
        """All statements on the results, and the share of CPU time spent in the integrator."""
        if not self.cpu_s > 0.0:
            return self.statements
        return (
            *self.statements,
            f"CPU time of the workers: {self.start_cpu_s:.1f} s to start, {self.cpu_s:.1f} s to compute"
            f" ({self.integrator_share:.0%} of which in the time integration)",
        )


class Interrupted(KeyboardInterrupt):
    """Interruption of a run; finished jobs are stored. summary: of the run; number: signal number."""

    def __init__(self, summary: RunSummary) -> None:
        advice = f"results so far: {summary.folder}; run the same command to continue"
        super().__init__(
            "\n".join([f"interrupted: {summary.headline}", *summary.events, *summary.statements, advice])
        )
        self.summary, self.number = summary, summary.interrupted
