"""Charts of designs: a point per job, over any of the parameters, coloured by any of them."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from bearingsim.plots import labels, select
from bearingsim.plots.design import compute_trend, is_logarithmic
from bearingsim.plots.features import complete_design
from bearingsim.plots.points import points_of
from bearingsim.plots.units import choose_feature_scale
from bearingsim.report.charts import SYMBOLS, Axis, Chart, Control, Curve, Panel, list_settings, round_values
from bearingsim.report.sweeps import MARKS, NAMES, make_panel, x_axis

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.store import Results
    from bearingsim.study import Figure

PLAIN = "none"
"""Setting of the colour control by which no parameter colours the points."""


def make_design_chart(results: "Results", figure: "Figure") -> Chart:
    """Make the chart of a design: a panel per feature, controls for the x axis and the colour.

    Raises PlotError without a design.
    """
    rows, units = select.case_rows(results), results.plan["units"]
    completed = replace(figure, y=figure.y or select.default_y(results, rows), kind="design")
    paths, complete, part, caption = complete_design(results, completed, rows)
    coloured = [*paths, *select.varied_paths(part, [path for path in units if path not in paths])]
    axes = [_axis(complete, path, part, results) for path in paths]
    start = paths.index(figure.x) if figure.x in paths else 0
    names = [labels.name_text(path) for path in paths]
    x = [points_of(replace(complete, x=path), completed.y[0], part, part, units).x for path in paths]
    panels = [_panel(complete, name, part, results, x) for name in completed.y]
    present = {key for panel in panels for key in panel.columns} | set(part["status"])
    controls = [
        Control("Over", names, start, ordered=False),
        Control("Colour", [PLAIN, *(_scale_text(path, part, units) for path in coloured)], 0, ordered=False),
    ]
    return Chart(
        title=completed.title or " and ".join(map(labels.feature_text, completed.y)),
        kind="design",
        axes=axes,
        panels=panels,
        curves=[Curve("", "curve0", (), SYMBOLS[0])],
        controls=controls,
        combinations=list_settings([len(control.options) for control in controls]),
        x=[round_values(column) for column in x],
        points={"job": [job[:8] for job in part["job"]], "mark": [MARKS[status] for status in part["status"]]},
        caption=", ".join(caption),
        names={key: text for key, text in NAMES.items() if key in present},
        shades=[_shares(part, path) for path in coloured],
        marks=[],
    )


def _axis(figure: "Figure", path: str, rows: "pd.DataFrame", results: "Results") -> Axis:
    values = list(rows[path])
    log = select.is_numeric(values) and ("x" in figure.log or is_logarithmic(values))
    return x_axis(replace(figure, x=path, log=("x",) if log else ()), path, rows, results.plan["units"])


def _panel(figure: "Figure", name: str, rows: "pd.DataFrame", results: "Results", x: list[list[float]]) -> Panel:
    scale = choose_feature_scale(name, float(rows[name].abs().max()), figure.view)
    points = points_of(figure, name, rows, rows, results.plan["units"], scale.factor)
    columns: dict[str, list[Any]] = {
        "y": round_values(points.y),
        "chaotic": [int(value) for value in points.chaotic],
    }
    groups = [compute_trend(column, points.y) for column in x]
    trends = [
        [round_values(row) for row in zip(group.x, group.low, group.median, group.high, strict=True)]
        if group
        else []
        for group in groups
    ]
    return make_panel(figure, name, scale, columns, trends)


def _scale_text(path: str, rows: "pd.DataFrame", units: dict[str, str]) -> str:
    """Describe the scale of a colour: `load, violet 150 N to green 300 N`."""
    distinct = select.distinct_values(rows, path)
    low, high = (labels.value_text(path, value, units) for value in (distinct[0], distinct[-1]))
    return f"{labels.name_text(path)}: violet {low} to green {high}"


def _shares(rows: "pd.DataFrame", path: str) -> list[float | None]:
    """Return the positions of a path's values from the smallest (0) to the largest (1); words are equidistant."""
    distinct = select.distinct_values(rows, path)
    if not select.is_numeric(distinct):
        return round_values(distinct.index(value) / max(1, len(distinct) - 1) for value in rows[path])
    low, high = distinct[0], distinct[-1]
    return round_values((value - low) / (high - low) for value in rows[path])
