"""What a figure is made of: the rows of the table that belong to it, and how they split into curves."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from bearingsim.config import FEATURES
from bearingsim.plots.labels import PlotError, described, unit_of
from bearingsim.study import Figure, dimension
from bearingsim.units import UnitError, parse, suggestion

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.store import Results

__all__ = [
    "arranged",
    "automatic",
    "case_rows",
    "completed",
    "default_y",
    "is_numeric",
    "matching",
    "phases",
    "planned",
    "splits",
    "values",
    "varied",
    "with_defect_phase",
    "x_unit",
]

LINE = "velocity@BPFO"
PHASES = (f"{LINE}.phase", f"{LINE}-healthy.phase")
MOST_CURVES = 9  # in one panel of an automatic figure


def case_rows(results: "Results") -> "pd.DataFrame":
    """The rows of the table that are cases of the study, not the healthy twins they are compared with."""
    table, twins = results.table(), {entry["job"] for entry in results.plan["jobs"] if entry["twin"]}
    return table[~table["job"].isin(twins)].reset_index(drop=True)


def varied(rows: "pd.DataFrame", paths: Sequence[str]) -> list[str]:
    """The paths that take more than one value in the rows."""
    return [path for path in paths if path in rows and rows[path].nunique() > 1]


def values(rows: "pd.DataFrame", path: str) -> list[Any]:
    """The values of a path: numbers ascending, words in the order of the study."""
    found = list(dict.fromkeys(rows[path].dropna()))
    return sorted(found) if is_numeric(found) else found


def is_numeric(found: Sequence[Any]) -> bool:
    """Whether all values are numbers."""
    return all(isinstance(value, int | float) for value in found)


def planned(results: "Results", rows: "pd.DataFrame") -> list[Figure]:
    """The figures that the study names, less those whose x it no longer sweeps; automatic ones if none."""
    swept = list(results.plan["units"])
    named = [_figure(entry) for entry in results.plan["figures"]]
    drawable = [
        replace(f, by=_known(f.by, swept), panels=_known(f.panels, swept), where=_known_items(f.where, swept))
        for f in named
        if f.x in varied(rows, swept)
    ]
    return drawable or automatic(results, rows)


def _figure(entry: Mapping[str, Any]) -> Figure:
    lists = {key: tuple(entry[key]) for key in ("y", "by", "panels", "log")}
    return Figure(x=entry["x"], where=dict(entry["where"]), title=entry["title"], **lists)


def _known(paths: Sequence[str], swept: Sequence[str]) -> tuple[str, ...]:
    return tuple(path for path in paths if path in swept)


def _known_items(where: Mapping[str, str], swept: Sequence[str]) -> dict[str, str]:
    return {path: text for path, text in where.items() if path in swept}


def automatic(results: "Results", rows: "pd.DataFrame") -> list[Figure]:
    """A figure for each swept number on x in turn, everything else as curves and panels.

    Raises PlotError where nothing is swept.
    """
    units = results.plan["units"]
    paths = varied(rows, list(units))
    numbers = [path for path in paths if is_numeric(values(rows, path))]
    if not paths:
        raise PlotError("the study sweeps nothing: there is no parameter to plot against (try `--kind spectrum`)")
    return [arranged(x, rows, units) for x in numbers or paths[:1]]


def arranged(x: str, rows: "pd.DataFrame", units: Mapping[str, str]) -> Figure:
    """A figure over x, other paths as curves, that with the fewest values as panels if curves are too many."""
    others = [path for path in varied(rows, list(units)) if path != x and not _follows(path, x, rows)]
    ordered = sorted(others, key=lambda path: len(values(rows, path)))
    curves = rows.groupby(list(others)).ngroups if others else 1
    panels = tuple(ordered[:1]) if curves > MOST_CURVES and len(ordered) > 1 else ()
    return Figure(y=default_y(rows), x=x, by=tuple(path for path in others if path not in panels), panels=panels)


def _follows(path: str, x: str, rows: "pd.DataFrame") -> bool:
    """Whether a path has one value for each x: it moves together with it."""
    return x in rows and bool(rows.groupby(x)[path].nunique().max() <= 1)


def default_y(rows: "pd.DataFrame") -> tuple[str, ...]:
    """The line at BPFO, and what of it the defect has made."""
    known = (name for name in (LINE, f"{LINE}-healthy") if name in rows and rows[name].notna().any())
    return tuple(known) or (LINE,)


def with_defect_phase(results: "Results", rows: "pd.DataFrame") -> "pd.DataFrame":
    """The rows with the phase (rad) of the line less the healthy twin's: what the defect alone adds."""
    import numpy as np

    if not set(PHASES[:1]) <= set(rows):
        raise PlotError("no job is done yet: there is no phase to draw")
    table = results.table().set_index("job")
    lines = table[LINE] * np.exp(1j * table[f"{LINE}.phase"])
    twin = lines.reindex(rows["healthy"]).to_numpy()
    return rows.assign(**{PHASES[1]: np.angle(lines.reindex(rows["job"]).to_numpy() - twin)})


def completed(figure: Figure, rows: "pd.DataFrame", units: Mapping[str, str]) -> tuple[Figure, "pd.DataFrame"]:
    """The rows of a figure, and the figure with every path that still varies among its curves.

    Raises PlotError for a path or feature that the results do not have.
    """
    paths = (figure.x, *figure.by, *figure.panels)
    for path in paths:
        _check(path, units, "swept path")
        if paths.count(path) > 1:
            raise PlotError(f"`{path}` can be only one of x axis, curves and panels")
    for name in figure.y:
        _check(name, [column for column in rows if column in FEATURES or column in PHASES], "feature")
    rows = matching(rows, figure.where, units)
    by = list(figure.by)
    for path in varied(rows, [path for path in units if path not in (figure.x, *by, *figure.panels)]):
        if rows.groupby([figure.x, *by, *figure.panels])[path].nunique().max() > 1:
            by.append(path)
    return replace(figure, by=tuple(by)), rows


def matching(rows: "pd.DataFrame", where: Mapping[str, str], units: Mapping[str, str]) -> "pd.DataFrame":
    """The rows whose swept paths have the values written. Raises PlotError for an unknown path, or if none has."""
    for path, text in where.items():
        _check(path, units, "swept path")
        rows = rows[_matches(rows[path], path, text)]
    if rows.empty:
        raise PlotError(f"no case has {', '.join(f'{path} {text}' for path, text in where.items())}")
    return rows


def phases(features: Sequence[str]) -> tuple[str, ...]:
    """The phases of some lines, each named by its line or its phase. Raises PlotError for what has no phase."""
    found = tuple(f"{name.removesuffix('.phase')}.phase" for name in features)
    for name, phase in zip(features, found, strict=True):
        if phase not in FEATURES and phase not in PHASES:
            raise PlotError(f"`{name}` has no phase: expected a line such as `{LINE}`")
    return found


def _check(word: str, known: Any, what: str) -> None:
    if word not in known:
        advice = suggestion(word, list(known)) or f"there are: {', '.join(known) or 'none'}"
        raise PlotError(f"no {what} `{word}` in these results ({advice})")


def _matches(column: "pd.Series[Any]", path: str, text: str) -> "pd.Series[bool]":
    """Which values of a swept column are the one written as ``text``."""
    known = dimension(path)
    try:
        value = parse(text, known) if known else None
    except UnitError:
        value = None
    if value is None:
        return column == text
    return (column - value).abs() <= 1e-9 * abs(value) + 1e-300


def splits(
    rows: "pd.DataFrame", paths: Sequence[str], units: Mapping[str, str]
) -> Iterator[tuple[str, "pd.DataFrame"]]:
    """The rows for each combination of some paths' values, with its text; all of them if there are no paths."""
    if not paths:
        yield "", rows
        return
    for value in values(rows, paths[0]):
        part = rows[rows[paths[0]] == value]
        for text, inner in splits(part, paths[1:], units):
            yield ", ".join(filter(None, [described({paths[0]: value}, units), text])), inner


def x_unit(path: str, rows: "pd.DataFrame", units: Mapping[str, str]) -> str:
    """The unit of the x axis; empty for words."""
    return unit_of(path, units) if is_numeric(values(rows, path)) else ""
