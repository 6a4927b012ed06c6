"""Charts of signals of single jobs: channels over time, spectra, envelope spectra."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from bearingsim.plots import labels, lines
from bearingsim.plots.grid import Content, DrawnCurve, legend_names
from bearingsim.plots.marks import share_lines
from bearingsim.plots.recorded import Job
from bearingsim.plots.series import series_of
from bearingsim.plots.spectra import spectra_of
from bearingsim.plots.units import Scale
from bearingsim.report.charts import (
    COLOURS,
    DASHES,
    Axis,
    Chart,
    Curve,
    Panel,
    round_positions,
    round_values,
    style_curves,
)
from bearingsim.study import Figure

if TYPE_CHECKING:
    from bearingsim.store import Results

KINDS = {"series": "Signal", "spectrum": "Spectrum", "envelope": "Envelope spectrum"}
"""Kinds of figures of signals that have charts, and their titles."""
MAX_POINTS = 2000
"""Largest number of points of a curve; longer ones are reduced to the extremes of equal parts."""


def make_signal_charts(results: "Results", figure: Figure, jobs: Sequence[str]) -> list[Chart]:
    """Make a chart per job (or row of the figure) and channel. Raises PlotError, ResultsError."""
    if figure.kind == "series":
        content, _, _ = series_of(results, figure, jobs)
    else:
        content = spectra_of(results, figure, jobs)
    return [
        _chart(figure, content, title, records, label, scale, row)
        for label, scale, rows in content.columns
        for title, records, row in zip(content.titles, content.jobs, rows, strict=True)
    ]


def _chart(
    figure: Figure,
    content: Content,
    title: str,
    records: Sequence[Job],
    label: str,
    scale: Scale,
    drawn: Sequence[DrawnCurve],
) -> Chart:
    names = legend_names(drawn)
    reduced = [reduce(curve.points[0], scale.to_axis(curve.points[1])) for curve in drawn]
    counts = [len(x) for x, _ in reduced]
    shortened = max(len(curve.points[0]) for curve in drawn) > MAX_POINTS
    texts = (
        [*content.caption, f"reduced to the extremes of {MAX_POINTS // 2} parts"] if shortened else content.caption
    )
    marked = figure.kind != "series" and share_lines(records)
    highest = max(float(curve.points[0][-1]) for curve in drawn)
    healthy = Curve("healthy", "faint", (), "none")
    curves = style_curves({name: (number, 0) for number, name in enumerate(names)}, ordered=False)
    return Chart(
        title=figure.title or ": ".join(filter(None, [KINDS[figure.kind], title])),
        kind="signal",
        axes=[Axis(content.x_label, [], "x" in figure.log)],
        panels=[
            Panel(
                Axis(label, [], "y" in figure.log),
                "",
                scale.unit.replace(labels.NO_BREAK, " "),
                {"y": [value for _, y in reduced for value in round_values(y)]},
                [],
            )
        ],
        curves=[
            replace(healthy, name=curve.name)
            if part.is_healthy
            else replace(curve, dash=DASHES[number // COLOURS % len(DASHES)])
            for number, (curve, part) in enumerate(zip(curves, drawn, strict=True))
        ],
        controls=[],
        combinations=[[]],
        x=[[value for x, _ in reduced for value in round_positions(x)]],
        points={
            "curve": [number for number, count in enumerate(counts) for _ in range(count)],
            "combination": [0] * sum(counts),
        },
        caption=", ".join(texts),
        names={},
        shades=[],
        marks=_marks(records[0], highest) if marked else [],
    )


def _marks(job: Job, highest: float) -> list[tuple[float, str]]:
    """List frequencies (Hz) and names of the spectral lines of a job's defects; sidebands have no name."""
    return [
        (
            float(f"{mark.frequency:.6g}"),
            "" if mark.side and mark.number else f"{mark.name} {mark.frequency:.4g} Hz",
        )
        for mark in lines.marks(job.parameters, highest)
        if mark.frequency <= highest
    ]


def reduce(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Reduce a curve (n,) to the minimum and maximum of equal parts, with at most ``MAX_POINTS`` points."""
    if len(x) <= MAX_POINTS:
        return x, y
    parts = np.array_split(np.arange(len(x)), MAX_POINTS // 2)
    retained = np.unique([part[pick(y[part])] for part in parts for pick in (np.argmin, np.argmax)])
    return x[retained], y[retained]
