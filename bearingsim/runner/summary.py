"""What a run comes to: counts, time, and failures grouped by reason."""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from math import ceil, inf
from pathlib import Path
from typing import TYPE_CHECKING

from bearingsim.store import NOTABLE, Failure, is_one_draw, relative_error

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.runner.findings import Findings

__all__ = ["FailureGroup", "Interrupted", "RunSummary", "chaos", "grouped", "kind_of", "step_errors", "unsettled"]


@dataclass(frozen=True)
class FailureGroup:
    """Failures of one kind: the reason and advice of the first, and all their jobs."""

    reason: str
    advice: str
    jobs: tuple[str, ...]

    def __str__(self) -> str:
        advice = f" ({self.advice})" if self.advice else ""
        count = f"{len(self.jobs)} job" + ("s" if len(self.jobs) > 1 else "")
        return f"{count} failed: {self.reason}{advice}, for example {self.jobs[0]}"


def grouped(failures: Iterable[Failure]) -> tuple[FailureGroup, ...]:
    """Group failures whose reasons differ in numbers at most, largest group first."""
    ordered = sorted(failures, key=lambda failure: (kind_of(failure.reason), failure.job))
    groups = [list(group) for _, group in groupby(ordered, key=lambda failure: kind_of(failure.reason))]
    found = [FailureGroup(g[0].reason, g[0].advice, tuple(failure.job for failure in g)) for g in groups]
    return tuple(sorted(found, key=lambda group: -len(group.jobs)))


LINE_AND_RMS = ("velocity@BPFO", "velocity.rms")
FEW = 2  # features that a line has room for


def chaos(frame: "pd.DataFrame", drawn: Sequence[str] = (), notable: float = NOTABLE) -> Iterator[str]:
    """Yield how well the results of chaotic jobs are known, and what would tell more.

    frame: of ``store.build_table``; drawn: features that are looked at; notable: standard error, relative, over
    which it is told.
    """
    import pandas as pd

    table = frame.filter(regex="^features/").rename(columns=lambda name: name.partition("/")[2])
    names = [name for name in drawn or LINE_AND_RMS if name in table]
    if not names or "chaotic" not in table:
        return
    errors = pd.DataFrame(
        {name: relative_error(table, name).where(is_one_draw(table, name, notable), 0.0) for name in names}
    )
    unknown = errors.isna() | (errors == inf)
    known = errors.mask(unknown, 0.0)
    if (known.to_numpy() > 0.0).any():
        worst = float(known.to_numpy().max())
        longer = f"{ceil((worst / notable) ** 2)} times the `duration` for {100.0 * notable:.2g} %"
        yield f"{_of_jobs(known > 0.0)} chaotic, known to {100.0 * worst:.2g} %; {longer}"
    if unknown.to_numpy().any():
        yield f"{_of_jobs(unknown)} chaotic, standard error unknown; a longer `duration` may tell"


def _of_jobs(flags: "pd.DataFrame") -> str:
    """`velocity.rms in 2 of 8 jobs`; flags: of jobs by features."""
    names = [str(name) for name in flags if flags[name].any()]
    more = f" and {len(names) - FEW} more" if len(names) > FEW else ""
    return f"{', '.join(names[:FEW])}{more} in {flags.any(axis=1).sum()} of {len(flags)} jobs:"


LESS_SURE = {
    "step_error.force": "the largest force",
    "step_error.record": "RMS of what else is recorded",
}


def step_errors(frame: "pd.DataFrame") -> Iterator[str]:
    """What is to be known of jobs whose line and RMS hold, but not all else."""
    from bearingsim.simulation.step_check import ACCURACY  # imports the core, which takes a second

    for name, what in LESS_SURE.items():
        if f"features/{name}" not in frame:
            continue
        said = frame[f"features/{name}"]
        error = said[(frame["features/chaotic"] == 0.0) & (said > ACCURACY)]
        if len(error):
            jobs = f"{len(error)} job{'s' * (len(error) > 1)}"
            yield f"{jobs}: {what} may be off by up to {100.0 * error.max():.2g} % (`{name}`)"


def unsettled(frame: "pd.DataFrame") -> Iterator[str]:
    """Jobs whose start still moves line or RMS by more than 1 %, other than by chance."""
    from bearingsim.simulation.step_check import ACCURACY

    columns = [name for name in ("features/error.start", "features/error.start.rms") if name in frame]
    if not columns:
        return
    by_chance = frame.filter(items=["features/standard_error.line", "features/cage.slip.mean"]).notna().any(axis=1)
    errors = frame.loc[~by_chance, columns].max(axis=1)
    errors = errors[errors > ACCURACY]
    if len(errors):
        jobs = f"{len(errors)} jobs have" if len(errors) > 1 else "1 job has"
        yield (
            f"{jobs} not settled: line or RMS is off by up to {100.0 * errors.max():.2g} % (`error.start`);"
            " take `settle: auto`, or a longer one"
        )


def repetitions(info: "pd.DataFrame") -> Iterator[str]:
    """How much was computed of jobs that repeat themselves, or might; ``info``: of finished jobs, a row each."""
    if "period_passes" not in info:
        return
    told = info[info["period_passes"].notna()]
    repeating = told[told["period_passes"] > 0]
    if len(repeating):
        passes = _span(repeating["passes_computed"], "{:.0f}")
        yield (
            f"{len(repeating)} of {len(told)} responses are periodic: {passes} of"
            f" {_span(repeating['passes'], '{:.0f}')} ball passes computed (`periodic: false` computes all)"
        )
    ended = told[(told["period_passes"] == 0) & (told["passes_computed"] < told["passes"])]
    if len(ended):
        passes = _span(ended["passes_computed"], "{:.0f}")
        yield f"{len(ended)} of {len(told)} jobs were accurate enough after {passes} ball passes"
    others = told[(told["passes_computed"] == told["passes"]) & (told["last_difference"] > 0.0)]
    if len(others):
        yield (
            f"{len(others)} of {len(told)} responses are not periodic: successive passes differ by"
            f" {_span(100.0 * others['last_difference'], '{:.2g}')} % of the range (`last_difference`)"
        )


def _span(values: "pd.Series[float]", form: str) -> str:
    low, high = form.format(values.min()), form.format(values.max())
    return low if low == high else f"{low} to {high}"


def kind_of(reason: str) -> str:
    """A reason without its numbers: the same for all that failed alike."""
    return re.sub(r"[-+]?\d[\d.]*(e[-+]?\d+)?", "#", reason)


@dataclass(frozen=True)
class RunSummary:
    """Result of a run: numbers of jobs planned, done before and done now, failures; times in s.

    ``interrupted``: number of the signal, or 0.
    ``start_cpu_s`` is what the workers took to import and compile, ``cpu_s`` their CPU time after that and
    ``integrator_cpu_s`` the part of it inside the integrator; ``notes`` tell what became of earlier results, and
    what was repaired; ``findings`` what there is to say of the results, None before there are any.
    """

    study: str
    folder: Path
    planned: int
    resumed: int
    done: int
    failures: tuple[FailureGroup, ...]
    seconds: float
    start_cpu_s: float
    cpu_s: float
    integrator_cpu_s: float
    interrupted: int = 0
    notes: tuple[str, ...] = ()
    findings: "Findings | None" = None

    @property
    def failed(self) -> int:
        """Number of jobs that failed, now or in an earlier run."""
        return sum(len(group.jobs) for group in self.failures)

    @property
    def missing(self) -> int:
        """Number of planned jobs neither done nor failed."""
        return self.planned - self.resumed - self.done - self.failed

    @property
    def integrator_share(self) -> float:
        """Share of the workers' CPU time after start-up spent in the integrator, NaN when nothing was computed."""
        return self.integrator_cpu_s / self.cpu_s if self.cpu_s > 0 else float("nan")

    @property
    def exit_code(self) -> int:
        """0 all done, 1 some failed or left, 128 and the number of the signal if interrupted: 130 by Ctrl-C."""
        return 128 + self.interrupted if self.interrupted else int(self.failed > 0 or self.missing > 0)

    def __str__(self) -> str:
        return "\n".join([self.headline, *self.happened, *self.details])

    @property
    def headline(self) -> str:
        """`small: 8 of 8 jobs done in 3.2 s, 2 of them before`."""
        done = self.done + self.resumed
        counts = {"of them before": self.resumed, "failed": self.failed, "left": self.missing}
        parts = [f"{count} {what}" for what, count in counts.items() if count]
        line = (
            f"{self.study}: {done} of {self.planned} job{'s' * (self.planned != 1)} done in {self.seconds:.1f} s"
        )
        return ", ".join([line, *parts])

    @property
    def happened(self) -> tuple[str, ...]:
        """Failures, and what became of earlier results."""
        return (*map(str, self.failures), *self.notes)

    @property
    def details(self) -> tuple[str, ...]:
        """All there is to say of the results, and where the CPU time went."""
        told = () if self.findings is None else self.findings.everything
        if not self.cpu_s > 0.0:
            return told
        apart = f"{self.start_cpu_s:.1f} s of start-up apart"
        return (*told, f"{self.integrator_share:.0%} of the workers' CPU time, {apart}, went into the runs' steps")


class Interrupted(KeyboardInterrupt):
    """A run was interrupted; what was done by then is stored. Carries the summary."""

    def __init__(self, summary: RunSummary) -> None:
        advice = f"results so far: {summary.folder}; run the same command to continue"
        super().__init__(f"interrupted: {summary}\n{advice}")
        self.summary, self.number = summary, summary.interrupted
