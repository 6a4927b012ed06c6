"""Selection of rows for a figure, and their grouping into curves."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from bearingsim.config import CHANNELS, FEATURES
from bearingsim.config.names import read_band
from bearingsim.figure_kinds import KINDS
from bearingsim.plots.labels import COST, NONE, PlotError, format_quantity, swept_text, unit_of, value_text
from bearingsim.plots.lines import fundamental_lines, may_slip, races_of_all
from bearingsim.study import Figure, dimension, restore_figure
from bearingsim.study.figures import LIST_OF_NAMES, whole_name_hint
from bearingsim.study.uncertainty import PARAMETER_KINDS, group_by_kind
from bearingsim.text.units import UnitError, parse, suggestion

if TYPE_CHECKING:
    import pandas as pd

    from bearingsim.store import Results

HEALTHY_PHASE = "-healthy.phase"
MAX_CURVES = 9  # largest number of curves in a panel of an automatic figure
MAX_LISTED = 20  # largest number of values, or of valid words, that a message lists
MAX_NEAREST = 4  # largest number of numbers near a wrong one that a message lists
DEFAULT_JOBS = 3  # number of jobs in a figure of signals without a selection


def case_rows(results: "Results") -> "pd.DataFrame":
    """Select the rows of the table that are cases of the study, without healthy baselines."""
    table, baselines = results.table(), {entry["job"] for entry in results.plan["jobs"] if entry["twin"]}
    return table[~table["job"].isin(baselines)].reset_index(drop=True)


def design_paths(results: "Results") -> tuple[str, ...]:
    """Return the paths of the study's design; empty without one."""
    design = results.plan.get("design")
    return tuple(design["paths"]) if design else ()


def scattered_paths(figure: Figure, rows: "pd.DataFrame", design: Sequence[str]) -> list[str]:
    """List the paths of a design that vary freely along a figure's curves, whose points then form no lines."""
    return varied_paths(rows, [path for path in design if path not in (figure.x, *figure.by, *figure.panels)])


def varied_paths(rows: "pd.DataFrame", paths: Sequence[str]) -> list[str]:
    """List the paths with more than one value in the rows."""
    return [path for path in paths if path in rows and rows[path].nunique() > 1]


def distinct_values(rows: "pd.DataFrame", path: str) -> list[Any]:
    """List the distinct values of a path: numbers ascending, words in the order of the study."""
    distinct = list(dict.fromkeys(rows[path].dropna()))
    return sorted(distinct) if is_numeric(distinct) else distinct


def is_numeric(distinct: Sequence[Any]) -> bool:
    """Check if all values are numbers."""
    return all(isinstance(value, int | float) for value in distinct)


def planned_figures(results: "Results", rows: "pd.DataFrame", kind: str | None = None) -> list[Figure]:
    """List the figures of the study, of ``kind`` if given, that can be drawn; automatic ones if there are none."""
    swept = list(results.plan["units"])
    named = map(restore_figure, results.plan["figures"])
    figures = [
        figure for figure in named if kind in (None, figure.kind) or (kind == "phase" and not _is_signal(figure))
    ]
    drawable = [
        replace(
            f,
            by=_select_swept(f.by, swept),
            panels=_select_swept(f.panels, swept),
            where=_select_swept_items(f.where, swept),
        )
        for f in figures
        if _is_signal(f) or f.kind == "design" or f.x in varied_paths(rows, swept)
    ]
    return drawable or automatic_figures(results, rows)


def _is_signal(figure: Figure) -> bool:
    return KINDS[figure.kind].of_jobs


def _select_swept(paths: Sequence[str], swept: Sequence[str]) -> tuple[str, ...]:
    return tuple(path for path in paths if path in swept)


def _select_swept_items(where: Mapping[str, str], swept: Sequence[str]) -> dict[str, str]:
    return {path: text for path, text in where.items() if path in swept}


def automatic_figures(results: "Results", rows: "pd.DataFrame") -> list[Figure]:
    """Make a figure over each swept numeric path, with all other paths as curves and panels.

    Raises PlotError if nothing is swept.
    """
    units = results.plan["units"]
    paths = varied_paths(rows, list(units))
    numbers = [path for path in paths if is_numeric(distinct_values(rows, path))]
    if not paths:
        raise PlotError("the study sweeps no parameter to plot against (try `--kind spectrum`)")
    return [arrange_figure(results, x, rows) for x in numbers or paths[:1]]


def arrange_figure(results: "Results", x: str, rows: "pd.DataFrame") -> Figure:
    """Make a figure over x with other paths as curves; if these are too many, one path becomes panels."""
    units = results.plan["units"]
    joined_paths = category_paths(x, [], rows, units)
    leading = [x, *(path for path in design_paths(results) if path != x)]
    paths = [path for path in varied_paths(rows, list(units)) if path not in (*joined_paths, *leading)]
    others = [path for path in paths if not follows(path, leading, rows)]
    ordered = sorted(others, key=lambda path: len(distinct_values(rows, path)))
    curves = rows.groupby(list(others)).ngroups if others else 1
    panels = tuple(ordered[:1]) if curves > MAX_CURVES and len(ordered) > 1 else ()
    curves_of = tuple(path for path in others if path not in panels)
    return Figure(y=default_y(results, rows), x=x, by=curves_of, panels=panels)


def done_jobs(rows: "pd.DataFrame") -> list[str]:
    """List the ids of the finished cases in the rows."""
    return list(rows[rows["status"] == "done"]["job"])


def some_jobs(rows: "pd.DataFrame") -> list[str]:
    """List the ids of ``DEFAULT_JOBS`` finished cases that are evenly spaced in the rows."""
    done = done_jobs(rows)
    return (
        list(dict.fromkeys(done[round(i * (len(done) - 1) / (DEFAULT_JOBS - 1))] for i in range(DEFAULT_JOBS)))
        if done
        else []
    )


def follows(path: str, leading: Sequence[str], rows: "pd.DataFrame") -> bool:
    """Check if a path has a single value for each combination of values of other paths."""
    return set(leading) <= set(rows) and bool(rows.groupby(list(leading))[path].nunique().max() <= 1)


def default_y(results: "Results", rows: "pd.DataFrame") -> tuple[str, ...]:
    """Choose the features of a figure: the amplitude at the fundamental line of each kind of defect.

    If all defects are of one kind, also its change from the healthy baseline; for healthy bearings with cage slip,
    also the slip.
    """
    parameters = results.parameters()
    lines = [f"velocity@{line}" for line in fundamental_lines(parameters)]
    features = [*lines, f"{lines[0]}-healthy"] if len(lines) == 1 else lines
    if may_slip(parameters) and not races_of_all(parameters):
        features.append("cage.slip.mean")
    return tuple(name for name in features if name in rows and rows[name].notna().any()) or (lines[0],)


def default_phases(results: "Results") -> tuple[str, ...]:
    """Return the phase of the first defect line and that of its change from the healthy baseline."""
    line = f"velocity@{fundamental_lines(results.parameters())[0]}"
    return f"{line}.phase", f"{line}{HEALTHY_PHASE}"


def with_defect_phases(results: "Results", rows: "pd.DataFrame") -> "pd.DataFrame":
    """Add the phase (rad) of the change of each line from the healthy baseline, the defect's contribution."""
    import numpy as np
    import pandas as pd

    table = results.table().set_index("job")
    lines = [str(name).removesuffix(".phase") for name in table if str(name).endswith(".phase")]
    columns = {}
    for line in lines:
        amplitude = table[line] * np.exp(1j * table[f"{line}.phase"])
        baseline = amplitude.reindex(rows["healthy"]).to_numpy()
        columns[f"{line}{HEALTHY_PHASE}"] = np.angle(amplitude.reindex(rows["job"]).to_numpy() - baseline)
    return pd.concat([rows, pd.DataFrame(columns, index=rows.index)], axis=1)


def with_spread(results: "Results", rows: "pd.DataFrame", features: Sequence[str]) -> "pd.DataFrame":
    """Add columns ``least NAME``, ``largest NAME`` (SI) and ``chaotic NAME`` for features with an uncertainty."""
    import pandas as pd

    spreads = {name: results.spread(name) for name in features}
    columns = {
        f"{end} {name}": spread[end].reindex(rows["job"]).to_numpy()
        for name, spread in spreads.items()
        for end in ("least", "largest", "chaotic")
        if len(spread)
    }
    return pd.concat([rows, pd.DataFrame(columns, index=rows.index)], axis=1)


def with_baselines(results: "Results", rows: "pd.DataFrame", figure: Figure) -> "pd.DataFrame":
    """Add columns ``baseline NAME`` (SI), the features of the healthy bearing, unless the figure omits them.

    Phases and changes from the healthy bearing have none.
    """
    if figure.view.healthy == "off" or "healthy" not in rows:
        return rows
    table = results.table().set_index("job")
    names = [name for name in figure.y if name in table and name in FEATURES and is_level(name)]
    return rows.assign(**{f"baseline {name}": table[name].reindex(rows["healthy"]).to_numpy() for name in names})


def is_level(name: str) -> bool:
    """Check if a feature has a level for the healthy bearing: not for a phase or a change from healthy."""
    return not name.endswith((".phase", "-healthy", "-scatter"))


def spread_texts(results: "Results", rows: "pd.DataFrame") -> list[str]:
    """Describe the uncertainty bands of a figure, if it has any: `bands and bars: damping 0.5 to 10 µs`."""
    ends = [name for name in rows if str(name).startswith("least ")]
    if not ends:
        return []
    drawn = set(rows["job"])
    tried = group_by_kind(
        (variation["what"], variation["value"]) for variation in results.variations if variation["of"] in drawn
    )
    band = " and ".join(
        (f"{what} ({text})" if PARAMETER_KINDS[what].choices else f"{what} {format_quantity(text)}")
        for what, text in ((what, PARAMETER_KINDS[what].range_text(values)) for what, values in tried.items())
    )
    chaotic = any((rows[name] == True).any() for name in rows if str(name).startswith("chaotic "))  # noqa: E712
    varied_rows = rows[rows["job"].isin({variation["of"] for variation in results.variations})]
    unknown = int((varied_rows[ends].isna().any(axis=1) & (varied_rows["status"] == "done")).sum())
    exception = f", range unknown in {unknown} of {len(varied_rows)} cases" if unknown else ""
    scatter = ", in part chaotic (with standard errors)" if chaotic else ""
    return [f"bands and bars: {band}{exception}{scatter}"]


def complete_figure(
    figure: Figure, rows: "pd.DataFrame", units: Mapping[str, str], design: Sequence[str] = ()
) -> tuple[Figure, "pd.DataFrame"]:
    """Return a figure with all remaining varied paths as curves, and its rows.

    design: paths that vary together, which are not used for curves. Raises PlotError for a path or feature missing
    from the results.
    """
    paths = (figure.x, *figure.by, *figure.panels)
    for path in paths:
        _check(path, units, "swept path")
        if paths.count(path) > 1:
            raise PlotError(f"`{path}` can be only one of x axis, curves and panels")
    for name in figure.y:
        _check(name, list(filter(is_drawable, map(str, rows))), "feature")
    rows = matching_rows(rows, figure.where, units)
    joined_paths = category_paths(figure.x, (*figure.by, *figure.panels), rows, units)
    x, rows = _as_categories(joined_paths, rows, units)
    by = list(figure.by)
    free = scattered_paths(figure, rows, design)
    for path in varied_paths(
        rows, [path for path in units if path not in (*joined_paths, *by, *figure.panels, *free)]
    ):
        if rows.groupby([x, *free, *by, *figure.panels])[path].nunique().max() > 1:
            by.append(path)
    return replace(figure, x=x, by=tuple(by)), rows


def is_drawable(column: str) -> bool:
    """Check if a column of the table can be drawn on the y axis."""
    return column in FEATURES or column == COST or column.endswith(HEALTHY_PHASE)


def category_paths(x: str, drawn: Sequence[str], rows: "pd.DataFrame", units: Mapping[str, str]) -> list[str]:
    """List the paths that form a common category with the words on x, for example those tied to it by `zip`.

    Paths are tied if not all combinations of their words occur. ``drawn``: paths of curves and panels.
    """
    if x not in rows or is_numeric(distinct_values(rows, x)):
        return [x]
    others = [path for path in varied_paths(rows, list(units)) if path != x and path not in drawn]
    words = [path for path in others if not is_numeric(distinct_values(rows, path))]
    count = rows[x].nunique()
    return [x, *(path for path in words if rows.groupby([x, path]).ngroups < count * rows[path].nunique())]


def _as_categories(
    paths: Sequence[str], rows: "pd.DataFrame", units: Mapping[str, str]
) -> tuple[str, "pd.DataFrame"]:
    """Merge paths into one, whose column has the joined words: `envelope, ring` for `excitation, model`."""
    if len(paths) == 1:
        return paths[0], rows
    texts = [category(paths, row, units) for row in rows[list(paths)].to_dict("records")]
    return ", ".join(paths), rows.assign(**{", ".join(paths): texts})


def category(paths: Sequence[str], row: Mapping[Any, Any], units: Mapping[str, str]) -> str:
    """Join the words of some paths to one category; words for `none` are omitted."""
    return ", ".join(text for path in paths if (text := value_text(path, row[path], units)) != NONE)


def matching_rows(rows: "pd.DataFrame", where: Mapping[str, str], units: Mapping[str, str]) -> "pd.DataFrame":
    """Select the rows with the values ``where`` of swept paths. Raises PlotError for no match or unknown paths.

    A value that no row has selects those that tables and figures print like it, as values of a design are rounded.
    """
    for path, text in where.items():
        _check(path, units, "swept path")
        is_selected = _matches(rows[path], path, text)
        if not is_selected.any():
            is_selected = _matches(rows[path].map(lambda value, of=path: _printed(of, value, units)), path, text)
        if not is_selected.any() and len(rows):
            raise PlotError(f"no case has {_describe_filter(where)} ({_other_values(rows, path, text, units)})")
        rows = rows[is_selected]
    if rows.empty:
        raise PlotError(f"no case has {_describe_filter(where)}")
    return rows


def _printed(path: str, value: Any, units: Mapping[str, str]) -> Any:
    """Return the value (SI) of the text that is printed for a number; other values unchanged."""
    if not is_numeric([value]) or value != value:
        return value
    printed = _read(path, value_text(path, value, units))
    return value if printed is None else printed


def _other_values(rows: "pd.DataFrame", path: str, text: str, units: Mapping[str, str]) -> str:
    """List the values of a path, of many numbers the nearest to ``text``: `values: 150 N, 300 N`."""
    distinct, value = distinct_values(rows, path), _read(path, text)
    if len(distinct) > MAX_LISTED and is_numeric(distinct) and value is not None:
        nearest = sorted(sorted(distinct, key=lambda other: abs(other - value))[:MAX_NEAREST])
        return f"nearest: {', '.join(value_text(path, other, units) for other in nearest)}"
    texts = [value_text(path, other, units) for other in distinct[:MAX_LISTED]]
    return f"values: {', '.join(texts)}{', ...' * (len(distinct) > MAX_LISTED)}"


def _read(path: str, text: str) -> float | None:
    """Read the number (SI) of a path from its text; None for a word."""
    unit_kind = dimension(path)
    try:
        return parse(text, unit_kind) if unit_kind else float(text)  # seeds have no unit
    except (UnitError, ValueError):
        return None


def _describe_filter(where: Mapping[str, str]) -> str:
    return ", ".join(f"{path} {text}" for path, text in where.items())


def phase_names(features: Sequence[str]) -> tuple[str, ...]:
    """Convert names of lines or phases to names of phases. Raises PlotError for a feature without a phase."""
    names = tuple(f"{name.removesuffix('.phase')}.phase" for name in features)
    for name, phase in zip(features, names, strict=True):
        if phase.replace(HEALTHY_PHASE, ".phase") not in FEATURES:
            raise PlotError(f"`{name}` has no phase: expected a line such as `velocity@BPFO`")
    return names


def check_swept(results: "Results", paths: Sequence[str]) -> None:
    """Raise PlotError for a parameter that is fixed in the study; the message states its value."""
    parameters = results.parameters()
    for path in paths:
        column = path.replace("defect.", "defects.1.", 1) if path.startswith("defect.") else path
        if path not in results.plan["units"] and column in parameters and parameters[column].nunique() == 1:
            value = value_text(path, parameters[column].dropna().iloc[0], results.plan["units"])
            raise PlotError(f"`{path}` is fixed at {value} in this study, not swept")


def check_paths(paths: Sequence[str], units: Mapping[str, str]) -> None:
    """Raise PlotError for a path that is not swept."""
    for path in paths:
        _check(path, units, "swept path")


def _check(word: str, valid: Any, kind: str) -> None:
    if word not in valid:
        if kind == "feature" and (word in CHANNELS or word.rpartition(".")[0] in CHANNELS):
            raise PlotError(f"`{word}` is a channel, not a feature: add `--kind series` or `--kind spectrum`")
        near = suggestion(word, list(valid)) or whole_name_hint(word, list(valid))
        near = "" if word in FEATURES else near  # a feature is not a typo
        near = f"use `features: [{word.removesuffix('-healthy')}]` and run again" if read_band(word) else near
        is_long = len(valid) > MAX_LISTED
        advice = near or (LIST_OF_NAMES if is_long else f"available: {', '.join(valid) or 'none'}")
        raise PlotError(f"no {kind} `{word}` in these results ({advice})")


def _matches(column: "pd.Series[Any]", path: str, text: str) -> "pd.Series[bool]":
    """Compare a swept column, of numbers, words or both, with a value written as ``text``."""
    value = _read(path, text)
    if value is None:
        return column == text
    numbers = column.where(column.map(lambda entry: is_numeric([entry]))).astype(float)
    return (column == text) | ((numbers - value).abs() <= 1e-9 * abs(value) + 1e-300)


def undrawn_paths(figure: Figure, rows: "pd.DataFrame", units: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """Yield the varied paths that a completed figure does not draw, each with the drawn path that it follows.

    The latter is empty for a path that follows no single drawn path.
    """
    drawn = [*figure.x.split(", "), *figure.by, *figure.panels]
    for path in varied_paths(rows, [path for path in units if path not in drawn]):
        yield path, next((leader for leader in drawn if follows(path, [leader], rows)), "")


def split_rows(
    rows: "pd.DataFrame", paths: Sequence[str], units: Mapping[str, str]
) -> Iterator[tuple[str, "pd.DataFrame"]]:
    """Yield text and rows for each combination of values of some paths; all rows if there are no paths."""
    if not paths:
        yield "", rows
        return
    for value in distinct_values(rows, paths[0]):
        part = rows[rows[paths[0]] == value]
        for text, inner in split_rows(part, paths[1:], units):
            yield ", ".join(filter(None, [swept_text({paths[0]: value}, units), text])), inner


def x_unit(path: str, rows: "pd.DataFrame", units: Mapping[str, str]) -> str:
    """Return the unit of the x axis; empty for words."""
    return unit_of(path, units) if is_numeric(distinct_values(rows, path)) else ""
