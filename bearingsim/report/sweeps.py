"""Charts of sweeps: features over a parameter, with a control for each parameter that is not on an axis."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from bearingsim.plots import PlotError, labels, select
from bearingsim.plots.axes import axis_label, is_baseline_hidden
from bearingsim.plots.features import SweepContent, complete_sweep
from bearingsim.plots.overlay import FigureData, position_on_x
from bearingsim.plots.points import curve_rows, order_of, points_of
from bearingsim.plots.style import SEQUENCE_FROM
from bearingsim.plots.units import FeatureScale, choose_feature_scale
from bearingsim.report.charts import OPEN_SYMBOLS, Axis, Chart, Control, Curve, Panel, round_values, style_curves
from bearingsim.study.measured_values import same

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.store import Results
    from bearingsim.study import Figure

COLUMNS = ("y", "low", "high", "error", "healthy")
"""Columns of a panel with a number per point."""
MARKS = {"done": "", "failed": "×", "missing": "|"}
"""Marks of jobs on the x axis, by their state."""
NAMES = {
    "healthy": "healthy bearing (dashed)",
    "error": "bars: error bound of model, step and scatter",
    "chaotic": "circle: chaotic response, with a standard error over 0.5 % or unknown",
    "failed": "×: failed job",
    "missing": "|: job not computed yet",
}
"""Explanations of marks, by column or state."""


def group_alike(figures: Sequence["Figure"]) -> list[list["Figure"]]:
    """Group figures that differ only in `where` and title, because they share a chart."""
    groups: dict[str, list[Figure]] = {}
    for figure in figures:
        groups.setdefault(repr(replace(figure, where={}, title=None)), []).append(figure)
    return list(groups.values())


def prepare_unfiltered(results: "Results", figure: "Figure") -> tuple["Figure", SweepContent]:
    """Return a figure without its `where`, and its completion, because a chart has controls instead of `where`.

    Raises PlotError.
    """
    rows, unfiltered = select.case_rows(results), replace(figure, where={})
    if figure.kind == "phase":
        unfiltered = replace(
            unfiltered, y=select.phase_names(figure.y) if figure.y else select.default_phases(results)
        )
        rows = select.with_defect_phases(results, rows)
    return unfiltered, complete_sweep(results, unfiltered, rows)


def make_sweep_chart(results: "Results", leading: "Figure", unfiltered: "Figure", complete: SweepContent) -> Chart:
    """Make the chart of a figure; it starts with the setting of ``leading``.

    unfiltered, complete: from ``prepare_unfiltered``.
    """
    figure, rows, units = complete.figure, complete.rows, results.plan["units"]
    by = tuple(path for path in figure.by if path in unfiltered.by) or _default_by(figure, rows)
    paths = [path for path in (*figure.panels, *figure.by) if path not in by]
    rows = _drop_unbegun(rows, _controls(figure, paths, rows, units)[1])
    complete = complete._replace(rows=rows)
    controls, keys = _controls(figure, paths, rows, units)
    combinations = sorted(set(keys))
    start = keys[_first(rows, leading.where, units)]
    ranks = _ranks(figure, by, rows, units)
    points = _Points(by, list(ranks), combinations, dict(zip(rows.index, keys, strict=True)))
    panels = [_panel(figure, name, complete, units, points) for name in figure.y]
    measured = _add_measured(results, complete, points, panels)
    present = {key for panel in panels for key in panel.columns} | points.states()
    names = {key: text for key, text in NAMES.items() if key in present}
    if "healthy" in names and is_baseline_hidden(figure, rows):
        names["healthy"] += ", about zero"
    bands = select.spread_texts(results, rows)
    numeric = select.is_numeric(select.distinct_values(rows, figure.x))
    return Chart(
        title=leading.title if leading.title and not leading.where else title_of(figure),
        kind="line" if numeric and figure.kind != "phase" else "points",  # a phase wraps
        axes=[x_axis(figure, figure.x, rows, units)],
        panels=panels,
        curves=[
            *style_curves(ranks, bool(by) and select.is_numeric(select.distinct_values(rows, by[0]))),
            *measured,
        ],
        controls=[replace(control, start=start[i]) for i, control in enumerate(controls)],
        combinations=[list(key) for key in combinations],
        x=[points.x],
        points=points.columns(),
        caption=", ".join(text for text in complete.caption if text not in bands),
        names={"band": " ".join(bands).replace("bands and bars", "shaded")} | names if bands else names,
        shades=[],
        marks=[],
    )


def _default_by(figure: "Figure", rows: "pd.DataFrame") -> tuple[str, ...]:
    """Choose the curves of a figure that names none: the values of the path with the fewest, if they are few."""
    paths = sorted(figure.by, key=lambda path: len(select.distinct_values(rows, path)))
    return tuple(path for path in paths[:1] if len(select.distinct_values(rows, path)) < SEQUENCE_FROM)


def title_of(figure: "Figure") -> str:
    """Describe a figure over a path: `RMS velocity over load`."""
    initial, *others = map(labels.feature_text, figure.y)
    return f"{' and '.join([initial, *map(labels.in_sentence, others)])} over {labels.name_text(figure.x)}"


def x_axis(figure: "Figure", path: str, rows: "pd.DataFrame", units: Mapping[str, str]) -> Axis:
    """Return the x axis of a figure over a path, with words if its values are words."""
    distinct = select.distinct_values(rows, path)
    numeric = select.is_numeric(distinct)
    words = [] if numeric else [labels.value_text(path, value, units) for value in distinct]
    label = axis_label(labels.name_text(path), select.x_unit(path, rows, units))
    return Axis(label, words, numeric and "x" in figure.log)


# Controls


def _controls(
    figure: "Figure", paths: Sequence[str], rows: "pd.DataFrame", units: Mapping[str, str]
) -> tuple[list[Control], list[tuple[int, ...]]]:
    """Make a control for each path and those tied to it; also return the settings of each row."""
    controls, columns = [], []
    followers = list(select.undrawn_paths(figure, rows, units))
    for tied in _group_tied(paths, rows):
        group = [*tied, *(path for path, leader in followers if leader in tied)]
        values = [tuple(row) for row in rows[group].itertuples(index=False)]
        numeric = select.is_numeric(select.distinct_values(rows, group[0]))
        distinct = sorted(set(values), key=lambda key: key[0]) if numeric else list(dict.fromkeys(values))
        texts = [_setting(group, key, units) for key in distinct]
        name = " and ".join(map(labels.name_text, group))
        controls.append(Control(name[:1].upper() + name[1:], texts, 0, numeric))
        columns.append([distinct.index(key) for key in values])
    return controls, list(zip(*columns, strict=True)) if columns else [()] * len(rows)


def _drop_unbegun(rows: "pd.DataFrame", keys: Sequence[tuple[int, ...]]) -> "pd.DataFrame":
    """Drop the rows of settings in which no job is done or failed yet, unless that leaves none."""
    begun = {key for key, status in zip(keys, rows["status"], strict=True) if status != "missing"}
    return rows[[key in begun for key in keys]] if begun else rows


def _first(rows: "pd.DataFrame", where: Mapping[str, str], units: Mapping[str, str]) -> int:
    """Return the number of the first row with the values of ``where``; 0 without such a row."""
    if not where:
        return 0
    try:
        return list(rows.index).index(select.matching_rows(rows, where, units).index[0])
    except PlotError:
        return 0


def _group_tied(paths: Sequence[str], rows: "pd.DataFrame") -> list[list[str]]:
    """Group paths that `zip` or `derived` ties: each value of one determines that of another."""
    groups: list[list[str]] = []
    for path in paths:
        tied = next((group for group in groups if rows.groupby(group)[path].nunique().max() <= 1), None)
        if tied is None:
            groups.append([path])
        else:
            tied.append(path)
    return groups


def _setting(group: Sequence[str], values: Sequence[Any], units: Mapping[str, str]) -> str:
    return ", ".join(labels.value_text(path, value, units) for path, value in zip(group, values, strict=True))


# Points


def _ranks(
    figure: "Figure", by: tuple[str, ...], rows: "pd.DataFrame", units: Mapping[str, str]
) -> dict[str, tuple[int, int]]:
    """Return the ranks of a curve's values on the first path and on the others, by the name of the curve."""
    leading_ranks: dict[str, int] = {}
    other_ranks: dict[str, int] = {}
    ranks: dict[str, tuple[int, int]] = {}
    for leading, other, curve in curve_rows(replace(figure, by=by), rows, units, order_of(figure, rows)):
        rank = (
            leading_ranks.setdefault(leading, len(leading_ranks)),
            other_ranks.setdefault(other, len(other_ranks)),
        )
        if len(curve):
            ranks[", ".join(filter(None, [leading, other]))] = rank
    return ranks


@dataclass
class _Points:
    """Columns of points that all panels share; the first panel fills them.

    by: paths of the curves; curves: their names; combinations: computed settings; keys: setting of each row;
    owner: number of the curve of a measured point, by the number of the point.
    """

    by: tuple[str, ...]
    curves: list[str]
    combinations: list[tuple[int, ...]]
    keys: dict[Any, tuple[int, ...]]
    x: list[float | None] = field(default_factory=list)
    curve: list[int] = field(default_factory=list)
    combination: list[int] = field(default_factory=list)
    job: list[str] = field(default_factory=list)
    mark: list[str] = field(default_factory=list)
    owner: dict[int, int] = field(default_factory=dict)

    def columns(self) -> dict[str, list[Any]]:
        """Return the columns; `owner` only if measured points belong to curves."""
        shared: dict[str, list[Any]] = {
            "curve": self.curve, "combination": self.combination, "job": self.job, "mark": self.mark
        }  # fmt: skip
        if self.owner:
            shared["owner"] = [self.owner.get(number) for number in range(len(self.x))]
        return shared

    def curve_of(self, values: Mapping[Any, Any], units: Mapping[str, str]) -> int:
        """Return the number of the curve at the values of a row."""
        texts = (labels.swept_text({path: values[path]}, units) for path in self.by)
        return self.curves.index(", ".join(filter(None, texts)))

    def states(self) -> set[str]:
        """Return the states of jobs without a value."""
        return {state for state, mark in MARKS.items() if mark and mark in self.mark}


def _panel(
    figure: "Figure", name: str, complete: SweepContent, units: Mapping[str, str], shared: _Points
) -> Panel:
    """Collect the points of a feature by curves, as in the figure, because error bounds refer to whole curves."""
    rows = complete.rows
    scale = choose_feature_scale(name, float(rows[name].abs().max()), figure.view)
    columns: dict[str, list[Any]] = {key: [] for key in (*COLUMNS, "chaotic")}
    is_first, order = not shared.x, order_of(figure, rows)
    for _, part in select.split_rows(rows, figure.panels, units):
        for _, _, curve in curve_rows(figure, part, units, order):
            if curve.empty:
                continue
            points = points_of(figure, name, curve, rows, units, scale.factor)
            for key in COLUMNS:
                columns[key] += round_values(getattr(points, key))
            columns["chaotic"] += [int(value) for value in points.chaotic]
            if is_first:
                shared.curve += [shared.curve_of(curve.iloc[0].to_dict(), units)] * len(curve)
                shared.combination += [shared.combinations.index(shared.keys[index]) for index in curve.index]
                shared.x += round_values(points.x)
                shared.job += [job[:8] for job in points.jobs]
                shared.mark += [MARKS[state] for state in points.status]
    return make_panel(figure, name, scale, columns)


def _add_measured(
    results: "Results", complete: SweepContent, shared: _Points, panels: Sequence[Panel]
) -> list[Curve]:
    """Add the measured points to the columns of each setting to which they belong; return a curve per source."""
    figure, rows, units = complete.figure, complete.rows, results.plan["units"]
    data = FigureData(figure, rows, units)
    curves: list[Curve] = []
    factors = {
        panel.name: choose_feature_scale(panel.name, float(rows[panel.name].abs().max()), figure.view).factor
        for panel in panels
    }
    for number, entry in enumerate(results.measured):
        count = len(shared.x)
        for combination, key in enumerate(shared.combinations):
            part = rows[[shared.keys[index] == key for index in rows.index]]
            drawn = part.drop_duplicates(list(shared.by)) if shared.by else part[:1]
            members = {shared.curve_of(row, units): row for row in drawn.to_dict("records")}
            for point in entry.points:
                x = position_on_x(data, part, point)
                values = {name: value for name, value in point["features"].items() if name in factors}
                if x is None or not values:
                    continue
                owners = _curves_at(members, point["parameters"], shared.by)
                if len(owners) == 1:
                    shared.owner[len(shared.x)] = owners[0]
                shared.x += round_values([x])
                shared.curve.append(len(shared.curves) + len(curves))
                shared.combination.append(combination)
                shared.job.append("")
                shared.mark.append("")
                for panel in panels:
                    value = values.get(panel.name)
                    scaled = None if value is None else entry.scaled(panel.name, value) * factors[panel.name]
                    for column, cells in panel.columns.items():
                        cells.append(0 if column == "chaotic" else None)
                    if scaled is not None:
                        panel.columns["y"][-1] = round_values([scaled])[0]
        if len(shared.x) > count:
            curves.append(Curve(entry.legend, "ink", (), [*OPEN_SYMBOLS][number % len(OPEN_SYMBOLS)], True))
    return curves


def _curves_at(
    members: Mapping[int, Mapping[Any, Any]], parameters: Mapping[str, float | str], by: Sequence[str]
) -> list[int]:
    """List the curves at the parameters of a measured point; members: a row of each curve, by its number."""
    settings = {path: value for path, value in parameters.items() if path in by}
    return [
        number
        for number, row in members.items()
        if all(same(row[path], value) for path, value in settings.items())
    ]


def make_panel(
    figure: "Figure",
    name: str,
    scale: FeatureScale,
    columns: dict[str, list[Any]],
    trends: Sequence[list[list[float | None]]] = (),
) -> Panel:
    """Make a panel without the columns that have no value."""
    is_phase = name.endswith(".phase")
    axis = Axis(
        axis_label(labels.feature_text(name), scale.unit), [], "y" in figure.log and not is_phase, is_phase
    )
    shown = {
        key: column
        for key, column in columns.items()
        if key == "y" or any(value is not None if key != "chaotic" else value for value in column)
    }
    return Panel(axis, name, scale.unit.split(",")[0].replace(labels.NO_BREAK, " "), shown, list(trends))
