"""`bearingsim plot`: selection, drawing and writing of figures."""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bearingsim.plots.labels import PlotError, PlotWarning

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure as Canvas

    from bearingsim.store import Results
    from bearingsim.study import Figure

DEFECT, LOAD, RING, DESIGN = "pit", "load", "ring", "design"
JOB_KINDS = ("series", "spectrum", "envelope", "roller", LOAD, DEFECT, RING)
KINDS = ("sweep", "phase", DESIGN, *JOB_KINDS)
ALL = "all"
UNUSED_OPTIONS = {
    **dict.fromkeys(("sweep", "phase"), ("span",)),
    DESIGN: ("x", "panels", "span"),
    **dict.fromkeys(JOB_KINDS, ("x", "by", "panels", "span")),
    **dict.fromkeys(("series", LOAD), ("x", "by", "panels")),
    **dict.fromkeys((DEFECT, RING), ("x", "y", "by", "panels", "span")),
}
"""Options that a kind of figure does not accept, by kind."""
MAX_NAMED = 4  # largest number of jobs in the name of a file
FORMATS = ("png", "svg", "pdf")
FIGURES = "figures"
"""Folder of a study's figures, within its results."""
MARK = b"made by bearingsim"
"""Mark in the metadata of every figure; files with it may be replaced."""
MADE_BY = {
    "png": {"Software": MARK.decode()},
    "svg": {"Creator": MARK.decode(), "Date": None},
    "pdf": {"Creator": MARK.decode()},
}


def plot(
    results: "Results",
    kind: str = "sweep",
    x: str | None = None,
    jobs: Sequence[str] = (),
    file_format: str = "png",
    out: Path | None = None,
    **changes: Any,
) -> list[Path]:
    """Draw figures of a study into ``out`` (default: its ``figures`` folder); return the files.

    kind: of the table, `sweep` (features against swept paths), `phase` (phases of lines) or `design` (a feature
    against each parameter of a design); of ``jobs`` (ids, or `all`), `series`, `spectrum`, `envelope` (spectrum of
    the squared envelope), `roller` (channels over its angle), `load` (along a roller), `pit` (defects to scale) or
    `ring` (outer ring in static equilibrium).
    x, changes: override the study; changes are y (features, or channels of jobs), by, panels (lists), where (paths
    and values) and span (s; of a series or load).
    Raises PlotError, ResultsError; warns (PlotWarning) of a figure left out.
    """
    from bearingsim.plots.style import drawing

    folder = out or results.path / FIGURES
    with drawing():
        sheets = drawn(results, kind, x, jobs, **changes)
        folder.mkdir(parents=True, exist_ok=True)
        return [written(canvas, folder / f"{name}.{file_format}", results) for name, canvas in sheets]


def drawn(
    results: "Results", kind: str = "sweep", x: str | None = None, jobs: Sequence[str] = (), **changes: Any
) -> list[tuple[str, "Canvas"]]:
    """Draw the figures of ``plot`` without writing them; return pairs of name and figure."""
    _check_changes(kind, {"x": x, **changes})
    if not jobs or list(jobs) == [ALL]:  # loading a named job raises its own error
        _check_done(results)
    if kind in JOB_KINDS:
        return _job_figures(results, kind, jobs, changes)
    if kind == DESIGN or (kind == "sweep" and _shows_design(results, x, changes)):
        return _design_figures(results, changes)
    return _table_figures(results, kind, x, changes)


def _check_done(results: "Results") -> None:
    """Raise PlotError, with the reason of a failed job, if no job is done."""
    if (results.table()["status"] == "done").any():
        return
    failures = list(results.failures().values())
    failed = f": {len(failures)} failed, one for this: {failures[0].reason}" if failures else ""
    raise PlotError(f"no job is done, so there is nothing to draw{failed}")


def written(canvas: "Canvas", path: Path, results: "Results") -> Path:
    """Write a figure in the format of the file's suffix; return the file.

    Raises PlotError instead of replacing a file that is not a figure of this program.
    """
    from bearingsim.plots.style import take_literally
    from bearingsim.store import write_bytes

    take_literally(canvas)
    drawing, kind = BytesIO(), path.suffix.removeprefix(".").lower()
    canvas.savefig(drawing, format=kind, metadata=MADE_BY[kind])
    if path.parent.resolve() != results.path.resolve() / FIGURES and not _is_replaceable(path):
        raise PlotError(f"{path} is not a figure of this program; use another --out, or move the file")
    write_bytes(path, drawing.getvalue())
    return path


def _is_replaceable(path: Path) -> bool:
    """Check if a path is free or a figure of this program."""
    if path.is_symlink() or not path.is_file():
        return not path.is_symlink() and not path.exists()
    return MARK in path.read_bytes()


def _table_figures(
    results: "Results", kind: str, x: str | None, changes: Mapping[str, Any]
) -> list[tuple[str, "Canvas"]]:
    """Draw all figures of a sweep; warn of those that cannot be drawn, raise the first error if none can."""
    from bearingsim.plots import select

    rows = select.case_rows(results)
    if kind == "phase":
        rows = select.with_defect_phases(results, rows)
    sheets, problems = [], []
    for number, figure in enumerate(_wanted(results, rows, kind, x, changes), 1):
        try:
            canvas, figure_drawn = _sheet(results, figure, rows)
            sheets.append((_name(number, figure_drawn, x, changes), canvas))
        except PlotError as error:
            problems.append((number, error))
    if not sheets:
        raise problems[0][1]
    for number, problem in problems:
        warnings.warn(f"figure {number} left out: {problem}", PlotWarning, stacklevel=2)
    return sheets


def _shows_design(results: "Results", x: str | None, changes: Mapping[str, Any]) -> bool:
    """Check if the study has a design and neither the study nor the command names a figure."""
    from bearingsim.plots import select

    named = x or results.plan["figures"] or changes.get("panels")
    return not named and bool(select.design_paths(results))


def _design_figures(results: "Results", changes: Mapping[str, Any]) -> list[tuple[str, "Canvas"]]:
    """Draw a figure per feature, with a panel for each parameter of the design that varies."""
    from bearingsim.plots import design, select
    from bearingsim.plots.caption import band_of_record, fixed_values, varying
    from bearingsim.study import Figure

    rows, units, every = select.case_rows(results), results.plan["units"], select.design_paths(results)
    if not every:
        raise PlotError("the study sweeps no design (`lhs`, `sobol`, `saltelli`, `morris`): try `--kind sweep`")
    where, by = changes.get("where") or {}, tuple(changes.get("by") or ())
    features = tuple(changes.get("y") or select.default_y(results, rows))
    paths = [path for path in select.varied(select.matching(rows, where, units), every) if path not in by]
    if not paths:
        raise PlotError("no parameter of the design varies in these cases")
    sheets = []
    for name in features:
        wanted = Figure(y=(name,), x=paths[0], by=by, where=where)
        figure, part = select.completed(wanted, rows, units, every)
        others = {path: unit for path, unit in units.items() if path not in paths}
        fixed = fixed_values(results, part, {*paths, *figure.by})
        fixed += band_of_record(results, part, [name])
        caption = [*fixed, *varying(figure, part, others), *_design_texts(results)]
        file_name = slug([DESIGN, name, *_option_words(changes)])
        sheets.append((file_name, design.draw_paths(figure, paths, part, units, caption)))
    return sheets


def _design_texts(results: "Results") -> list[str]:
    from bearingsim.plots import design

    return [design.description(results.plan["design"]), *design.TREND]


def _sheet(results: "Results", wanted: "Figure", rows: "pd.DataFrame") -> "tuple[Canvas, Figure]":
    """Complete and draw a figure; return the canvas and the completed figure."""
    from bearingsim.plots import design, select, sweep
    from bearingsim.plots.caption import band_of_record, fixed_values, moved_along, varying

    units, together = results.plan["units"], select.design_paths(results)
    figure, part = select.completed(wanted, rows, units, together)
    caption = fixed_values(results, part, {figure.x, *select.varied(part, [*figure.by, *figure.panels])})
    caption += band_of_record(results, part, figure.y)
    if select.scattered(figure, part, together):
        caption += [*varying(figure, part, units), *_design_texts(results)]
        return design.draw(figure, part, units, caption), figure
    caption += moved_along(figure, part, units)
    if sweep.are_many(figure, part, units):
        return sweep.draw_names(figure, part, units, caption), figure
    part = select.with_spread(results, part, figure.y)
    return sweep.draw(figure, part, units, [*caption, *select.spread_texts(results, part)]), figure


def _wanted(
    results: "Results", rows: "pd.DataFrame", kind: str, x: str | None, changes: Mapping[str, Any]
) -> "list[Figure]":
    """List the requested figures: those of the study, or one over x, with the changes applied."""
    from bearingsim.plots import select

    figures = [select.arranged(results, x, rows)] if x else select.planned(results, rows)
    overrides: dict[str, Any] = {
        key: dict(value) if key == "where" else tuple(value) for key, value in changes.items() if value
    }
    if kind == "phase":
        overrides["y"] = select.phases(overrides["y"]) if "y" in overrides else select.default_phases(results)
    changed = [_changed(figure, overrides) for figure in figures]
    return [figure for number, figure in enumerate(changed) if figure not in changed[:number]]


def _changed(figure: "Figure", overrides: dict[str, Any]) -> "Figure":
    """Apply overrides to a figure; a path used for curves is removed from the panels, and vice versa."""
    by = tuple(path for path in figure.by if path not in overrides.get("panels", ()))
    panels = tuple(path for path in figure.panels if path not in overrides.get("by", ()))
    return replace(figure, **({"by": by, "panels": panels} | overrides))


def _name(number: int, figure: "Figure", x: str | None, changes: Mapping[str, Any]) -> str:
    """Name the file of a figure, `fig1-velocity-bpfo-vs-defect-length`, including the options of the command."""
    changed = x or any(changes.values())
    y = figure.y if changes.get("y") else figure.y[:1]
    words = [f"{'plot' if changed else 'fig'}{number}", *y, "vs", figure.x]
    return slug([*words, *_option_words(changes)])


def _option_words(changes: Mapping[str, Any]) -> list[str]:
    """List the words of a file name that describe the options of the command."""
    words = [word for key in ("by", "panels") if changes.get(key) for word in (key, *changes[key])]
    where = [f"{path} {value.replace('-', 'minus ')}" for path, value in (changes.get("where") or {}).items()]
    return [*words, *(["where", *where] if where else [])]


def slug(words: Sequence[str]) -> str:
    """Join words to a file name: `fig1-velocity-bpfo`."""
    return "-".join("".join(c if c.isalnum() else " " for c in " ".join(words).lower()).split())


def _job_figures(
    results: "Results", kind: str, jobs: Sequence[str], changes: Mapping[str, Any]
) -> list[tuple[str, "Canvas"]]:
    from bearingsim.plots import line_load, select, series

    where, y = changes.get("where") or {}, tuple(changes.get("y") or ())
    named = [] if list(jobs) == [ALL] else list(jobs)
    if named and where:
        raise PlotError("named jobs cannot be filtered; use either `--job` or `--where`")
    rows = select.matching(select.case_rows(results), where, results.plan["units"])
    chosen = named or (series.done_jobs(rows) if jobs else series.some_jobs(rows))
    if not chosen:
        raise PlotError("none of these jobs is done")
    if kind == DEFECT:
        return _defect_figures(results, chosen)
    if kind == RING:
        return _ring_figures(results, chosen)
    options = {"span": changes["span"]} if changes.get("span") else {}
    name = _name_of_jobs(kind, y, [ALL] if jobs and not named else chosen)
    draw = line_load.draw_load if kind == LOAD else series.DRAW[kind]
    return [(name, draw(results, chosen, y, **options))]


def _defect_figures(results: "Results", jobs: Sequence[str]) -> list[tuple[str, "Canvas"]]:
    """Draw a figure for each distinct defect of some jobs."""
    from bearingsim.plots import defect

    return [
        (
            slug([DEFECT, sheet.jobs[0][:8], *([str(sheet.number)] if sheet.of > 1 else [])]),
            defect.draw_defect(results, sheet),
        )
        for sheet in defect.sheets(results, jobs)
    ]


def _ring_figures(results: "Results", jobs: Sequence[str]) -> list[tuple[str, "Canvas"]]:
    """Draw a figure per job with a static equilibrium; raise the first error if none has one."""
    from bearingsim.plots import ring

    sheets, problems = [], []
    for job in jobs:
        try:
            sheets.append((slug([RING, job[:8]]), ring.draw_ring(results, job)))
        except PlotError as error:
            problems.append((job, error))
    if not sheets:
        raise problems[0][1]
    for job, problem in problems:
        warnings.warn(f"job {job} left out: {problem}", PlotWarning, stacklevel=2)
    return sheets


def _check_changes(kind: str, changes: Mapping[str, Any]) -> None:
    """Raise PlotError for options that a kind of figure does not accept."""
    useless = [name for name in UNUSED_OPTIONS[kind] if changes.get(name)]
    if useless:
        how = ": its jobs are chosen by `--job` or by `--where`" if kind in JOB_KINDS else ""
        raise PlotError(f"a {kind} takes no {useless[0]}{how}")


def _name_of_jobs(kind: str, y: Sequence[str], jobs: Sequence[str]) -> str:
    more = [f"and {len(jobs) - MAX_NAMED} more"] if len(jobs) > MAX_NAMED else []
    return slug([kind, *y, *(job[:8] for job in jobs[:MAX_NAMED]), *more])
