"""Content of the page of a study: what was studied, the results, their accuracy, and how they were computed."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

from bearingsim.catalogue import DESCRIPTIONS
from bearingsim.plots import labels
from bearingsim.plots.caption import SMALL_UNITS, ring_values
from bearingsim.report.charts import Chart
from bearingsim.report.columns import Column, column_of, main_features, status_texts
from bearingsim.report.figures import Figures, Picture, collect
from bearingsim.report.headline import Result, feature_results
from bearingsim.report.influence import Influence
from bearingsim.report.measured import MeasuredTable, make_measured_tables
from bearingsim.report.statements import FailedJob, assumption_texts, list_failures, plain
from bearingsim.report.studied import Fact, describe_subject, study_facts
from bearingsim.store import feature_bounds
from bearingsim.text.numbers import significant, span

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.store import Results

MAX_ROWS = 2000
"""Largest number of rows of the table; 100 000 rows take 20 MB."""
MAX_TEXT = 200_000
"""Largest number of characters of the study file that are shown."""


@dataclass(frozen=True)
class Table:
    """Table of the jobs: columns, a flag for each one with numbers, and the number of all jobs."""

    columns: list[Column]
    numeric: list[bool]
    total: int

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """Rows of cells."""
        return list(zip(*(cells for _, cells in self.columns), strict=True))

    def shortened(self, rows: int) -> "Table":
        """Return the table with its first rows only."""
        return Table([(header, cells[:rows]) for header, cells in self.columns], self.numeric, self.total)

    @property
    def omissions(self) -> list[str]:
        """Description of the omitted rows, if there are any."""
        omitted = self.total - len(self.rows)
        return [f"{omitted} of {self.total} rows of the table: results.csv has all"] if omitted else []


@dataclass(frozen=True)
class Page:
    """Content of the page.

    subject: bearing, defect and figures in words; varied: uncertain parameters that the study varies;
    counts: numbers of jobs by status; complete: True if no job is missing; written: time of writing; studied:
    fixed and varied parameters; measured: measured and simulated features; omissions: omitted parts other than
    rows of the table, with reasons; computed: facts on the computation; text: the study file; changes: overrides
    of the command line.
    """

    study: str
    subject: str
    varied: list[str]
    counts: str
    complete: bool
    written: str
    quick: bool
    studied: list[Fact]
    results: list[Result]
    accuracy: list[str]
    warnings: list[str]
    charts: list[Chart]
    pictures: list[Picture]
    influences: list[Influence]
    omissions: list[str]
    table: Table
    assumptions: list[str]
    failures: list[FailedJob]
    measured: list[MeasuredTable]
    computed: list[Fact]
    text: str
    changes: str


def make_page(results: "Results", jobs: Sequence[str] = ()) -> Page:
    """Collect the content of the page; jobs: ids of those whose signals are shown.

    Raises ResultsError for a folder that cannot be read, PlotError for a job without a signal.
    """
    from bearingsim.runner.findings import LARGEST_STEP_ERRORS, findings
    from bearingsim.store import job_frame, now

    table = results.table()
    end_of_run = findings(results.plan, job_frame(results.path))
    done = bool((table["status"] == "done").any())
    figures = collect(results, jobs) if done else Figures()
    assumptions = assumption_texts(results) if done else list(results.plan.get("assumptions", ()))
    headlines = list(feature_results(results)) if done else []
    return Page(
        study=results.plan["study"],
        subject=describe_subject(results),
        varied=list(dict.fromkeys(variation["what"].replace("_", " ") for variation in results.variations)),
        counts=_counts(results.frame["status"]),
        complete=bool((results.frame["status"] != "missing").all()),
        written=f"Written {now()[:16].replace('T', ' ')} UTC.",
        quick=bool(results.plan["quick"]),
        studied=list(study_facts(results)),
        results=headlines,
        accuracy=[
            with_symbols(plain(text))
            for text in [*end_of_run.withdrawn, *end_of_run.accuracy]
            if not (text.startswith(LARGEST_STEP_ERRORS) and any(result.error for result in headlines))
        ],
        warnings=[with_symbols(plain(text)) for text in end_of_run.warnings],
        charts=figures.charts,
        pictures=figures.pictures,
        influences=figures.influences,
        omissions=figures.omissions,
        table=_table(results, table),
        assumptions=[with_symbols(plain(text)) for text in assumptions if text not in end_of_run.warnings],
        failures=list_failures(results),
        measured=make_measured_tables(results),
        computed=list(_computed(results)),
        text=_study_text(results),
        changes=" ".join(f"{path}={value}" for path, value in results.plan["overrides"].items()),
    )


def with_symbols(text: str) -> str:
    """Replace `u` by `µ` in the units of a statement, as in figures."""
    return re.sub(r"(?<=\d )u(?=[ms]\b)", "µ", text)


def _counts(status: "pd.Series[str]") -> str:
    """Count the planned jobs that are done, failed and missing, variations and audits included, as `run` does."""
    states, total = Counter(status), len(status)
    words = {"failed": "failed", "missing": "not computed yet"}
    others = [f"{states[state]} {text}" for state, text in words.items() if states[state]]
    return ", ".join([f"{states['done']} of {total} job{'s' * (total != 1)} done", *others])


def _table(results: "Results", table: "pd.DataFrame") -> Table:
    """Choose the columns of the table: swept paths, features of the figures, error bound and state of a job."""
    rows = table[:MAX_ROWS]
    paths = [path for path in results.plan["units"] if path in table]
    names = list(dict.fromkeys([*paths, *(name for name in main_features(results, table) if name in table)]))
    described = [_in_words(results, column_of(results, rows, name), name, rows) for name in names]
    columns = [("job", [job[:8] for job in rows["job"]]), *described]
    numeric = [False, *(rows[name].dtype.kind == "f" for name in names)]
    if results.plan.get("accuracy") is not None:
        bounds = feature_bounds(results.plan, results.frame).max(axis=1).reindex(rows["job"])
        columns.append(("error bound (%)", [significant(100.0 * bound, 2) for bound in bounds]))
        numeric.append(True)
    return Table([*columns, ("status", status_texts(rows))], [*numeric, False], len(table))


def _in_words(results: "Results", column: Column, name: str, rows: "pd.DataFrame") -> Column:
    """Return a swept parameter's column with its name in words, and `healthy` in cells without a defect."""
    if name not in results.plan["units"]:
        return column
    healthy_jobs = {entry["job"] for entry in results.plan["jobs"] if entry["twin"]}
    is_healthy = rows["job"].isin(healthy_jobs) & name.startswith("defect")
    cells = [
        "healthy" if healthy and cell in ("", "none") else cell
        for cell, healthy in zip(column[1], is_healthy, strict=True)
    ]
    return labels.name_text(name), cells


def _computed(results: "Results") -> Iterator[Fact]:
    """Yield how the results were computed: models, methods, steps, CPU time, versions."""
    from bearingsim.store import DamagedUnit, read_provenance, unit_path

    info, parameters = results.info(), results.parameters()
    if "model" in parameters and len(parameters):
        yield "Models", _tally(parameters["model"])
        yield from (
            (name, DESCRIPTIONS[name])
            for column in ("model", "contact.stiffness", "contact.damping.law")
            for name in dict.fromkeys(parameters.get(column, ()))
            if name in DESCRIPTIONS
        )
    laws = [law for law in parameters.get("friction.law", ()) if law]  # "": a model without friction
    if laws:
        yield "Friction", _tally(laws)
    ring = list(ring_values(parameters, set(), SMALL_UNITS | dict(results.plan["units"])))
    if ring:
        yield "Outer ring", ", ".join(ring)
    if "method" in info and len(info):
        yield "Methods", _tally(info["method"])
    if "step_s" in info and info["step_s"].notna().any():
        steps = 1e6 * info["step_s"]
        yield "Time step", f"{span(steps.min(), steps.max(), significant)} µs"
    if "cpu_s" in info and len(info):
        yield "CPU time", f"{significant(float(info['cpu_s'].sum()))} s for {_runs(len(info))}"
    unit = next(filter(None, results.table()["unit"]), None)
    if unit:
        with suppress(DamagedUnit, OSError):
            facts = read_provenance(unit_path(results.path, unit))
            yield from ((NAMES[name], value) for name, value in facts.items() if name in NAMES and value)


NAMES = {"packages": "Packages", "python": "Python", "platform": "Platform", "git_commit": "Commit",
         "model_version": "Version of the models"}  # fmt: skip
"""Names of the facts of ``store.read_provenance`` on the page."""


def _tally(column: Iterable[str]) -> str:
    counts = Counter(str(value) for value in column)
    return ", ".join(f"{name} ({_runs(count)})" for name, count in counts.most_common())


def _runs(count: int) -> str:
    return f"{count} run{'s' * (count != 1)}"


def _study_text(results: "Results") -> str:
    """Return the text of the study that was run; "" if there is none that can be read."""
    from bearingsim.store import UNREADABLE, read_study_text

    try:
        text = results.plan.get("text") or read_study_text(results.path)  # plans of earlier versions have no text
    except UNREADABLE:
        return ""
    return text if len(text) <= MAX_TEXT else f"{text[:MAX_TEXT]}\n# ... {len(text) - MAX_TEXT} characters omitted"
