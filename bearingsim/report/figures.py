"""Figures of the page: charts of those that it can draw, pictures by matplotlib of all."""

import base64
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from io import BytesIO
from typing import TYPE_CHECKING

from bearingsim.errors import UserError
from bearingsim.figure_kinds import KINDS
from bearingsim.plots import PlotError, select
from bearingsim.plots.plot import draw, jobs_of, requested_figures
from bearingsim.plots.style import disable_invalid_math, drawing
from bearingsim.report import signals
from bearingsim.report.charts import Chart
from bearingsim.report.designs import make_design_chart
from bearingsim.report.influence import Influence, describe_influences
from bearingsim.report.sweeps import group_alike, make_sweep_chart, prepare_unfiltered
from bearingsim.study import Figure
from bearingsim.study.design import BLOCK_DESIGNS

if TYPE_CHECKING:
    from bearingsim.store import Results

SIGNALS = ("series", "envelope")
"""Kinds of figures that show a job's signal on the page."""
MAX_SVG_BYTES, PNG_DPI = 400_000, 130
"""Size (bytes) of an SVG, such as that of many spectra, above which a PNG is stored instead; its resolution."""
MAX_CHART_ROWS = 10_000
"""Largest number of jobs in a chart; browsers draw more points too slowly."""


@dataclass(frozen=True)
class Picture:
    """Figure as a picture: title, and its data as a URL; fallback: with JavaScript, a chart replaces it."""

    title: str
    address: str
    fallback: bool


@dataclass
class Figures:
    """Charts, pictures and influences of parameters, and the omitted figures with their reasons."""

    charts: list[Chart] = field(default_factory=list)
    pictures: list[Picture] = field(default_factory=list)
    influences: list[Influence] = field(default_factory=list)
    omissions: list[str] = field(default_factory=list)


def collect(results: "Results", jobs: Sequence[str]) -> Figures:
    """Make the figures of a study, and those of the signals of some jobs (by default of one).

    Raises PlotError and ResultsError for a named job without a signal.
    """
    content = Figures()
    try:
        figures = requested_figures(results)
    except PlotError:  # nothing is swept
        figures = []
    rows = len(select.case_rows(results))
    if rows > MAX_CHART_ROWS and figures:
        text = f"{rows} jobs are too many for charts: `bearingsim plot` draws them, with `--where` a part of them"
        content.omissions.append(text)
        figures = []
    for group in group_alike(figures):
        _add(content, results, group)
    _add_signals(content, results, figures, jobs)
    design = results.plan["design"]
    if design and design["kind"] in BLOCK_DESIGNS:
        try:
            features = [name for figure in figures for name in figure.features]
            content.influences += describe_influences(
                results, list(dict.fromkeys(features)) or select.default_y(results, results.table())
            )
        except UserError as error:
            content.omissions.append(f"no sensitivity: {error}")
    return content


def _add(content: Figures, results: "Results", group: Sequence[Figure]) -> None:
    """Add figures that differ in `where` and title only: a chart, if their kind has one, and pictures."""
    try:
        charts = list(_charts(results, group))
        content.charts += charts
        for figure in group:
            content.pictures += _pictures(results, figure, fallback=bool(charts))
    except PlotError as error:
        content.omissions.append(f"figure of {', '.join(group[0].y) or group[0].kind}: {error}")


def _charts(results: "Results", group: Sequence[Figure]) -> Iterator[Chart]:
    leading = group[0]
    if leading.kind in signals.KINDS:
        for figure in group:
            yield from signals.make_signal_charts(results, figure, jobs_of(results, figure))
    elif leading.kind == "design":
        yield make_design_chart(results, leading)
    elif not KINDS[leading.kind].of_jobs:
        unfiltered, complete = prepare_unfiltered(results, leading)
        if complete.scattered:
            yield make_design_chart(results, leading)
        else:
            yield make_sweep_chart(results, leading, unfiltered, complete)


def _pictures(results: "Results", figure: Figure, fallback: bool) -> Iterator[Picture]:
    with drawing():
        for sheet in draw(results, figure):
            disable_invalid_math(sheet.canvas)
            drawings = {kind: BytesIO() for kind in ("svg", "png")}
            sheet.canvas.savefig(drawings["svg"], format="svg", metadata={"Date": None})
            kind = "svg" if drawings["svg"].tell() <= MAX_SVG_BYTES else "png"
            if kind == "png":
                sheet.canvas.savefig(drawings["png"], format="png", dpi=PNG_DPI)
            data = base64.b64encode(drawings[kind].getvalue()).decode()
            address = f"data:image/{'svg+xml' if kind == 'svg' else kind};base64,{data}"
            yield Picture(figure.title or " ".join(sheet.words), address, fallback)


# Signals


def _add_signals(content: Figures, results: "Results", figures: Sequence[Figure], jobs: Sequence[str]) -> None:
    """Add signal and envelope spectrum of jobs; by default of the one with the largest feature of the figures."""
    if not jobs and any(figure.kind in SIGNALS for figure in figures):
        return
    try:
        for job in jobs or [largest_case(results, figures)]:
            for kind in SIGNALS:
                content.charts += signals.make_signal_charts(results, Figure(y=(), x="", kind=kind), [job])
    except PlotError as error:
        if jobs:
            raise
        content.omissions.append(f"signal of a job: {error}")


def largest_case(results: "Results", figures: Sequence[Figure]) -> str:
    """Return the id of the finished case with the largest value of the first feature of the figures."""
    rows = select.case_rows(results)
    rows = rows[rows["status"] == "done"]
    if rows.empty:
        raise PlotError("no case is done")
    names = [name for figure in figures for name in figure.features if name in rows]
    name = next(iter([*names, *select.default_y(results, rows)]))
    values = rows[name].abs() if name in rows and rows[name].notna().any() else rows["seconds"].abs()
    return str(rows["job"].iloc[int(values.fillna(-1.0).to_numpy().argmax())])
