"""Summary of a run: counts, time, and failures grouped by reason."""

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
    """Group failures whose reasons differ only in numbers, largest group first."""
    ordered = sorted(failures, key=lambda failure: (kind_of(failure.reason), failure.job))
    groups = [list(group) for _, group in groupby(ordered, key=lambda failure: kind_of(failure.reason))]
    kinds = [FailureGroup(g[0].reason, g[0].advice, tuple(failure.job for failure in g)) for g in groups]
    return tuple(sorted(kinds, key=lambda group: -len(group.jobs)))


LINE_AND_RMS = ("velocity@BPFO", "velocity.rms")
FEW = 2  # features named in a line; the rest are counted


def chaos(frame: "pd.DataFrame", drawn: Sequence[str] = (), notable: float = NOTABLE) -> Iterator[str]:
    """Yield the standard error of the results of chaotic jobs, and the duration that would reduce it.

    frame: of ``store.build_table``; drawn: features of the figures; notable: relative standard error above which
    it is reported.
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
    bounded = errors.mask(unknown, 0.0)
    if (bounded.to_numpy() > 0.0).any():
        worst = float(bounded.to_numpy().max())
        longer = f"{ceil((worst / notable) ** 2)} times the `duration` for {100.0 * notable:.2g} %"
        yield f"{_of_jobs(bounded > 0.0)} chaotic, known to {100.0 * worst:.2g} %; {longer}"
    if unknown.to_numpy().any():
        yield f"{_of_jobs(unknown)} chaotic, standard error unknown; a longer `duration` may tell"


def _of_jobs(flags: "pd.DataFrame") -> str:
    """Format features with their number of jobs, as `velocity.rms in 2 of 8 jobs:`; flags: jobs by features."""
    names = [str(name) for name in flags if flags[name].any()]
    more = f" and {len(names) - FEW} more" if len(names) > FEW else ""
    return f"{', '.join(names[:FEW])}{more} in {flags.any(axis=1).sum()} of {len(flags)} jobs:"


LESS_SURE = {
    "step_error.force": "the largest force",
    "step_error.record": "RMS of what else is recorded",
}


def step_errors(frame: "pd.DataFrame") -> Iterator[str]:
    """Yield step errors above the limit in quantities other than line and RMS."""
    from bearingsim.simulation.step_check import ACCURACY  # imports the core, which takes a second

    for name, what in LESS_SURE.items():
        if f"features/{name}" not in frame:
            continue
        values = frame[f"features/{name}"]
        error = values[(frame["features/chaotic"] == 0.0) & (values > ACCURACY)]
        if len(error):
            jobs = f"{len(error)} job{'s' * (len(error) > 1)}"
            yield f"{jobs}: {what} may be off by up to {100.0 * error.max():.2g} % (`{name}`)"


def unsettled(frame: "pd.DataFrame") -> Iterator[str]:
    """Yield the jobs whose initial transient changes line or RMS by more than 1 %, except by chance."""
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
    """Yield the numbers of periodic and non-periodic responses; ``info``: of finished jobs, a row each."""
    if "period_passes" not in info:
        return
    checked = info[info["period_passes"].notna()]
    repeating = checked[checked["period_passes"] > 0]
    if len(repeating):
        passes = _span(repeating["passes_computed"], "{:.0f}")
        yield (
            f"{len(repeating)} of {len(checked)} responses are periodic: {passes} of"
            f" {_span(repeating['passes'], '{:.0f}')} ball passes computed (`periodic: false` computes all)"
        )
    ended = checked[(checked["period_passes"] == 0) & (checked["passes_computed"] < checked["passes"])]
    if len(ended):
        passes = _span(ended["passes_computed"], "{:.0f}")
        yield f"{len(ended)} of {len(checked)} jobs were accurate enough after {passes} ball passes"
    others = checked[(checked["passes_computed"] == checked["passes"]) & (checked["last_difference"] > 0.0)]
    if len(others):
        yield (
            f"{len(others)} of {len(checked)} responses are not periodic: successive passes differ by"
            f" {_span(100.0 * others['last_difference'], '{:.2g}')} % of the range (`last_difference`)"
        )


def _span(values: "pd.Series[float]", form: str) -> str:
    low, high = form.format(values.min()), form.format(values.max())
    return low if low == high else f"{low} to {high}"


def kind_of(reason: str) -> str:
    """Replace the numbers of a reason by `#`, so that failures of one kind compare equal."""
    return re.sub(r"[-+]?\d[\d.]*(e[-+]?\d+)?", "#", reason)


@dataclass(frozen=True)
class RunSummary:
    """Result of a run: numbers of jobs planned, done before and done now, failures; times in s.

    ``interrupted``: number of the signal, or 0.
    ``start_cpu_s`` is the workers' CPU time for imports and compilation, ``cpu_s`` their CPU time after that and
    ``integrator_cpu_s`` the part of it inside the integrator; ``notes``: lines on earlier results and on repairs;
    ``findings``: statements on the results, None before there are any.
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
        """0 all done, 1 some failed or left, 128 plus the number of the signal if interrupted: 130 by Ctrl-C."""
        return 128 + self.interrupted if self.interrupted else int(self.failed > 0 or self.missing > 0)

    def __str__(self) -> str:
        return "\n".join([self.headline, *self.happened, *self.details])

    @property
    def headline(self) -> str:
        """First line of the summary, as `small: 8 of 8 jobs done in 3.2 s, 2 of them before`."""
        done = self.done + self.resumed
        counts = {"of them before": self.resumed, "failed": self.failed, "left": self.missing}
        parts = [f"{count} {name}" for name, count in counts.items() if count]
        line = (
            f"{self.study}: {done} of {self.planned} job{'s' * (self.planned != 1)} done in {self.seconds:.1f} s"
        )
        return ", ".join([line, *parts])

    @property
    def happened(self) -> tuple[str, ...]:
        """Failures, and notes on earlier results."""
        return (*map(str, self.failures), *self.notes)

    @property
    def details(self) -> tuple[str, ...]:
        """All statements on the results, and the share of CPU time spent in the integrator."""
        texts = () if self.findings is None else self.findings.everything
        if not self.cpu_s > 0.0:
            return texts
        apart = f"{self.start_cpu_s:.1f} s of start-up apart"
        return (
            *texts,
            f"{self.integrator_share:.0%} of the workers' CPU time, {apart}, went into the runs' steps",
        )


class Interrupted(KeyboardInterrupt):
    """Interruption of a run, with its summary; results up to then are stored."""

    def __init__(self, summary: RunSummary) -> None:
        advice = f"results so far: {summary.folder}; run the same command to continue"
        super().__init__(f"interrupted: {summary}\n{advice}")
        self.summary, self.number = summary, summary.interrupted
