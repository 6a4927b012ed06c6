"""Charts of features: the figures of a study as data, with a control for each parameter off their axes."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

from bearingsim.plots import labels, select
from bearingsim.plots.axes import axis_label
from bearingsim.plots.features import Prepared, prepared
from bearingsim.plots.points import Points, curve_rows, order_of, points_of
from bearingsim.plots.style import SEQUENCE_FROM
from bearingsim.plots.units import FeatureScale, feature_scale

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.store import Results
    from bearingsim.study import Figure

DIGITS = 6
"""Significant digits of the numbers in a page."""
COLUMNS = ("y", "low", "high", "error", "healthy")
"""Numbers of a point in a panel."""


@dataclass(frozen=True)
class Control:
    """Control of a chart: name of one parameter, or of several that vary together; a text per setting.

    start: index of the first setting shown; ordered: the settings are numbers.
    """

    name: str
    options: list[str]
    start: int
    ordered: bool


@dataclass(frozen=True)
class Axis:
    """Axis: label with unit; words of categories, empty for numbers; logarithmic; of a phase in degrees."""

    label: str
    words: list[str]
    log: bool = False
    phase: bool = False


@dataclass(frozen=True)
class Panel:
    """Axes of one feature: y axis, short name, unit, and columns of the points, of ``COLUMNS`` and `chaotic`."""

    axis: Axis
    name: str
    unit: str
    columns: dict[str, list[Any]]


@dataclass(frozen=True)
class Chart:
    """Interactive figure: axes, a panel per feature, curves, controls, and the points of all settings.

    combinations: computed settings, an index per control; points: columns common to all panels, with the indices
    of a point's combination and curve; lines: whether the points of a curve are joined; ordered: whether curves
    are shades of a scale.
    """

    title: str
    x: Axis
    panels: list[Panel]
    curves: list[dict[str, Any]]
    controls: list[Control]
    combinations: list[list[int]]
    points: dict[str, list[Any]]
    caption: str
    band: str
    lines: bool
    ordered: bool

    def data(self) -> dict[str, Any]:
        """Return the chart as plain data for JSON."""
        return asdict(self)


def rounded(values: Iterable[float]) -> list[float | None]:
    """Round numbers to ``DIGITS``; None for NaN and infinity, which JSON does not have."""
    return [float(f"{value:.{DIGITS}g}") if math.isfinite(value) else None for value in values]


def charts_of(results: "Results", figures: Sequence["Figure"]) -> list[Chart]:
    """Make the charts of sweeps and phases; figures that differ in `where` and title only share one.

    Raises PlotError for a figure that cannot be drawn.
    """
    rows = select.case_rows(results)
    groups: dict[str, list[Figure]] = {}
    for figure in figures:
        groups.setdefault(repr(replace(figure, where={}, title=None)), []).append(figure)
    return [chart_of(results, group, rows) for group in groups.values()]


def chart_of(results: "Results", group: Sequence["Figure"], rows: "pd.DataFrame") -> Chart:
    """Make the chart of figures that differ in `where` and title only; it starts with the first."""
    leading, units = group[0], results.plan["units"]
    wanted = replace(leading, where={})
    if leading.kind == "phase":
        wanted = replace(wanted, y=select.phases(leading.y) if leading.y else select.default_phases(results))
        rows = select.with_defect_phases(results, rows)
    complete = prepared(results, wanted, rows)
    figure = complete.figure
    by = tuple(path for path in figure.by if path in wanted.by) or _default_by(figure, complete.rows)
    paths = [path for path in (*figure.panels, *figure.by) if path not in by]
    controls, keys = _controls(figure, paths, complete.rows, units)
    combinations = sorted(set(keys))
    first = keys[list(complete.rows.index).index(_first_row(complete.rows, leading.where, units))]
    curves = _curves(figure, by, complete.rows, units)
    table = _Table(curves, combinations, dict(zip(complete.rows.index, keys, strict=True)))
    ordered = bool(by) and select.is_numeric(select.values(complete.rows, by[0]))
    return Chart(
        title=leading.title if leading.title and not leading.where else _title(figure),
        x=_x_axis(figure, complete.rows, units),
        panels=[_panel(figure, name, by, complete, units, table) for name in figure.y],
        curves=[{"name": name, "colour": colour, "dash": dash} for name, (colour, dash) in curves.items()],
        controls=[replace(control, start=first[i]) for i, control in enumerate(controls)],
        combinations=[list(key) for key in combinations],
        points=table.columns,
        caption=", ".join(complete.caption),
        band=next((text for text in complete.caption if text.startswith("bands and bars")), ""),
        lines=not complete.scattered and select.is_numeric(select.values(complete.rows, figure.x)),
        ordered=ordered and len({colour for colour, _ in curves.values()}) >= SEQUENCE_FROM,
    )


def _default_by(figure: "Figure", rows: "pd.DataFrame") -> tuple[str, ...]:
    """Choose the curves of a figure that names none: the values of the path with the fewest, if they are few."""
    paths = sorted(figure.by, key=lambda path: len(select.values(rows, path)))
    return tuple(path for path in paths[:1] if len(select.values(rows, path)) < SEQUENCE_FROM)


def _title(figure: "Figure") -> str:
    return f"{' and '.join(map(labels.feature_text, figure.y))} over {labels.name_text(figure.x)}"


def _x_axis(figure: "Figure", rows: "pd.DataFrame", units: Mapping[str, str]) -> Axis:
    distinct = select.values(rows, figure.x)
    numeric = select.is_numeric(distinct)
    words = [] if numeric else [labels.value_text(figure.x, value, units) for value in distinct]
    label = axis_label(labels.name_text(figure.x), select.x_unit(figure.x, rows, units))
    return Axis(label, words, numeric and "x" in figure.log)


# Controls


def _controls(
    figure: "Figure", paths: Sequence[str], rows: "pd.DataFrame", units: Mapping[str, str]
) -> tuple[list[Control], list[tuple[int, ...]]]:
    """Make a control for each path, with those that move along with it; return the settings of each row, too."""
    controls, columns = [], []
    followers = list(select.moving_along(figure, rows, units))
    for group in _tied(paths, rows):
        group = [*group, *(path for path, leader in followers if leader in group)]
        settings = [tuple(row) for row in rows[group].itertuples(index=False)]
        distinct = sorted(set(settings), key=_sort_key) if _numeric(rows, group) else list(dict.fromkeys(settings))
        texts = [_setting(group, values, units) for values in distinct]
        name = " and ".join(map(labels.name_text, group))
        controls.append(Control(name[:1].upper() + name[1:], texts, 0, _numeric(rows, group)))
        columns.append([distinct.index(values) for values in settings])
    return controls, list(zip(*columns, strict=True)) if columns else [()] * len(rows)


def _tied(paths: Sequence[str], rows: "pd.DataFrame") -> list[list[str]]:
    """Group paths by `zip` and `derived`: those with one value per value of another join it."""
    groups: list[list[str]] = []
    for path in paths:
        tied = next((group for group in groups if rows.groupby(group)[path].nunique().max() <= 1), None)
        if tied is None:
            groups.append([path])
        else:
            tied.append(path)
    return groups


def _numeric(rows: "pd.DataFrame", group: Sequence[str]) -> bool:
    return select.is_numeric(select.values(rows, group[0]))


def _sort_key(values: tuple[Any, ...]) -> tuple[Any, ...]:
    return tuple((isinstance(value, str), value) for value in values)


def _setting(group: Sequence[str], values: Sequence[Any], units: Mapping[str, str]) -> str:
    return ", ".join(labels.value_text(path, value, units) for path, value in zip(group, values, strict=True))


def _first_row(rows: "pd.DataFrame", where: Mapping[str, str], units: Mapping[str, str]) -> Any:
    return (select.matching(rows, where, units) if where else rows).index[0]


# Points


def _curves(
    figure: "Figure", by: tuple[str, ...], rows: "pd.DataFrame", units: Mapping[str, str]
) -> dict[str, tuple[int, int]]:
    """Number the colours (values of the first path) and dashes (of the others) of all curves, by name."""
    order = order_of(figure, rows)
    ranks: tuple[dict[str, int], dict[str, int]] = ({}, {})
    curves: dict[str, tuple[int, int]] = {}
    for colour_text, line_text, curve in curve_rows(replace(figure, by=by), rows, units, order):
        colour, dash = (
            rank.setdefault(text, len(rank)) for rank, text in zip(ranks, (colour_text, line_text), strict=True)
        )
        if len(curve):
            curves[_name(colour_text, line_text)] = (colour, dash)
    return curves


def _name(colour_text: str, line_text: str) -> str:
    return ", ".join(filter(None, [colour_text, line_text]))


class _Table:
    """Columns of points that all panels share, filled once."""

    def __init__(
        self, curves: Iterable[str], combinations: Sequence[tuple[int, ...]], keys: Mapping[Any, Any]
    ) -> None:
        self.curves = {name: number for number, name in enumerate(curves)}
        self.combinations = {key: number for number, key in enumerate(combinations)}
        self.keys = keys
        self.columns: dict[str, list[Any]] = {}


def _panel(
    figure: "Figure",
    name: str,
    by: tuple[str, ...],
    complete: Prepared,
    units: Mapping[str, str],
    table: _Table,
) -> Panel:
    """Collect the points of one feature, curve by curve as in the figure: error bounds refer to whole curves."""
    rows = complete.rows
    scale = feature_scale(name, float(rows[name].abs().max()), figure.view)
    columns: dict[str, list[Any]] = {key: [] for key in (*COLUMNS, "chaotic")}
    common: dict[str, list[Any]] = {"x": [], "curve": [], "combination": [], "job": [], "status": []}
    panel = select.splits(rows, figure.panels, units)
    for _, _, curve in (
        drawn for _, part in panel for drawn in curve_rows(figure, part, units, order_of(figure, rows))
    ):
        if curve.empty:
            continue
        points = points_of(figure, name, curve, rows, units, scale.factor)
        text = ", ".join(filter(None, (labels.described({path: curve[path].iloc[0]}, units) for path in by)))
        _extend(columns, common, points)
        common["curve"] += [table.curves[text]] * len(curve)
        common["combination"] += [table.combinations[table.keys[index]] for index in curve.index]
    table.columns = common
    return _made(figure, name, scale, columns)


def _extend(columns: dict[str, list[Any]], common: dict[str, list[Any]], points: Points) -> None:
    for key in COLUMNS:
        columns[key] += rounded(getattr(points, key))
    columns["chaotic"] += [int(value) for value in points.chaotic]
    common["x"] += rounded(points.x)
    common["job"] += [job[:8] for job in points.jobs]
    common["status"] += points.status


def _made(figure: "Figure", name: str, scale: FeatureScale, columns: dict[str, list[Any]]) -> Panel:
    """Make a panel without the columns that have no value."""
    phase = name.endswith(".phase")
    axis = Axis(axis_label(labels.feature_text(name), scale.unit), [], "y" in figure.log and not phase, phase)
    shown = {key: column for key, column in columns.items() if key == "y" or any(column)}
    return Panel(axis, name, scale.unit.replace(labels.NO_BREAK, " "), shown)
