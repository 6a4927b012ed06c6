"""`bearingsim plot`: selection, drawing and writing of figures."""

import importlib
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bearingsim.figure_kinds import KINDS, VIEW_KEYS, View, check_options, is_set, parse_view
from bearingsim.plots.labels import PlotError, PlotWarning
from bearingsim.plots.sheet import ALL, Sheet, file_words
from bearingsim.study import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

    from bearingsim.store import Results

FORMATS = ("png", "svg", "pdf")
FIGURES = "figures"
"""Folder of a study's figures, within its results."""
MARK = b"made by bearingsim"
"""Mark in the metadata of every figure; outside the study's folder of figures only files with it are replaced."""
METADATA = {
    "png": {"Software": MARK.decode()},
    "svg": {"Creator": MARK.decode(), "Date": None},
    "pdf": {"Creator": MARK.decode()},
}
LISTS = ("y", "by", "panels", "log")
"""Options that are lists; ``where`` maps paths to values, ``x`` is one path, all others belong to ``View``."""

DrawFunction = Callable[["Results", Figure, Sequence[str]], list[Sheet]]


def plot(
    results: "Results",
    kind: str | None = None,
    jobs: Sequence[str] = (),
    file_format: str = "png",
    out: Path | None = None,
    **options: Any,
) -> list[Path]:
    """Draw figures into ``out`` (default: the study's folder `figures`); return the files.

    kind: a name in ``figure_kinds.KINDS``; None for the figures of the study, or one for each swept path. jobs:
    job ids, for figures of signals, or `all`; by default those selected by ``where``, without it some jobs, those
    with measured signals first. options:
    keys of a figure, which replace those of the study: lists y, by, panels and log; x; where (paths and values);
    and those of ``figure_kinds.View`` as texts, such as range="0 Hz..2 kHz".
    Raises PlotError, OptionError, ResultsError; warns (PlotWarning) of a figure that is skipped.
    """
    from bearingsim.plots.style import drawing

    folder = out or results.path / FIGURES
    with drawing():
        sheets = draw_figures(results, kind, jobs, **options)
        folder.mkdir(parents=True, exist_ok=True)
        return [write_figure(canvas, folder / f"{name}.{file_format}", results) for name, canvas in sheets]


def draw_figures(
    results: "Results", kind: str | None = None, jobs: Sequence[str] = (), **options: Any
) -> list[tuple[str, "Canvas"]]:
    """Draw the figures of ``plot`` without writing them; return pairs of name and figure.

    Warns of figures of the study that cannot be drawn, and of unfinished jobs that a figure omits; raises the
    first error if no figure can be drawn.
    """
    options = {key: value for key, value in options.items() if is_set(value)}
    if not jobs or list(jobs) == [ALL]:  # loading a named job raises its own error
        _check_done(results)
    figures = requested_figures(results, kind, options)
    if jobs and not any(KINDS[figure.kind].of_jobs for figure in figures):
        raise PlotError(f"a {figures[0].kind} shows all cases: omit `--job`, or choose a `--kind` of signals")
    numbered = kind is None or not KINDS[kind].of_jobs
    sheets: list[tuple[str, Canvas]] = []
    problems = []
    is_only_design = [figure.kind for figure in figures].count("design") == 1
    for number, figure in enumerate(figures, 1):
        is_numbered = numbered and not (figure.kind == "design" and is_only_design)
        prefix = f"{'plot' if options else 'fig'}{number}" if is_numbered else ""
        try:
            _warn_of_unfinished(results, figure, jobs)
            for sheet in draw(results, figure, jobs):
                named = "y" in options and sheet.words[0] == options["y"][0]
                words = [*options["y"], *sheet.words[1:]] if named else sheet.words
                sheets.append((slug([prefix, *words, *_option_words(options)]), sheet.canvas))
        except PlotError as error:
            problems.append((number, error))
    if not sheets:
        raise problems[0][1]
    for number, problem in problems:
        warnings.warn(f"figure {number} skipped: {problem}", PlotWarning, stacklevel=2)
    return sheets


def draw(results: "Results", figure: Figure, jobs: Sequence[str] = ()) -> list[Sheet]:
    """Draw one figure; jobs: as of ``plot``. Raises PlotError."""
    kind = KINDS[figure.kind]
    module, name = kind.draw.split(".")
    function: DrawFunction = getattr(importlib.import_module(f"bearingsim.plots.{module}"), name)
    ids = jobs_of(results, figure, jobs) if kind.of_jobs else []
    sheets = function(results, figure, ids)
    if list(jobs) != [ALL]:
        return sheets
    named, all_words = file_words(figure, ids), file_words(figure, [ALL])
    return [sheet._replace(words=all_words) if sheet.words == named else sheet for sheet in sheets]


def _check_done(results: "Results") -> None:
    """Raise PlotError, with the reason of a failed job, if no job is done."""
    if (results.table()["status"] == "done").any():
        return
    failures = list(results.failures().values())
    failed = f": {len(failures)} failed, the first with: {failures[0].reason}" if failures else ""
    raise PlotError(f"no job is done, so there is nothing to draw{failed}")


# Requested figures


def requested_figures(
    results: "Results", kind: str | None = None, options: Mapping[str, Any] = {}
) -> list[Figure]:
    """List the figures of the study, or those of one ``kind``, with the options of the command.

    Raises PlotError if nothing is swept, OptionError for an option that the kind does not have.
    """
    from bearingsim.plots import select

    named_paths = [*options.get("where", ()), *options.get("by", ()), *options.get("panels", ())]
    select.check_swept(results, [*named_paths, *filter(None, [options.get("x")])])
    if kind is not None and KINDS[kind].of_jobs:
        return [_apply_options(Figure(y=(), x="", kind=kind), options)]
    rows = select.case_rows(results)
    has_design = bool(select.design_paths(results))
    named = options.get("x") or results.plan["figures"] or options.get("panels")
    if kind == "design" or (kind in (None, "sweep") and has_design and not named):
        return [_apply_options(Figure(y=(), x="", kind="design"), options)]
    if options.get("x"):
        figures = [select.arrange_figure(results, options["x"], rows)]
    else:
        figures = select.planned_figures(results, rows, kind)
    if kind == "phase":
        figures = [replace(figure, kind="phase", y=(), log=(), view=View()) for figure in figures]
    changed = [_apply_options(figure, options) for figure in figures]
    return [figure for number, figure in enumerate(changed) if figure not in changed[:number]]


def _apply_options(figure: Figure, options: Mapping[str, Any]) -> Figure:
    """Apply options to a figure; a path used for curves is removed from the panels, and vice versa.

    Raises OptionError for an option that the kind of figure does not have.
    """
    check_options(figure.kind, options)
    by = tuple(path for path in figure.by if path not in options.get("panels", ()))
    panels = tuple(path for path in figure.panels if path not in options.get("by", ()))
    fields: dict[str, Any] = {"by": by, "panels": panels}
    fields |= {key: tuple(options[key]) for key in LISTS if key in options}
    fields |= {"where": dict(options["where"])} if "where" in options else {}
    fields |= {"x": options["x"]} if "x" in options else {}
    view = parse_view(figure.kind, {"log": fields.get("log", figure.log), **options})
    changed = {name: getattr(view, name) for name, key in VIEW_KEYS.items() if key in options}
    return replace(figure, view=replace(figure.view, **changed), **fields)


def jobs_of(results: "Results", figure: Figure, jobs: Sequence[str] = ()) -> list[str]:
    """List the jobs of a figure of signals: the named or selected ones, else some, with measured signals first.

    Raises PlotError if none of them is done.
    """
    from bearingsim.plots import select
    from bearingsim.plots.overlay import signal_points

    named = [] if list(jobs) == [ALL] else list(jobs)
    if named and figure.where:
        raise PlotError("named jobs cannot be filtered; use either `--job` or `--where`")
    rows = select.matching_rows(select.case_rows(results), figure.where, results.plan["units"])
    with_signal = [job for job in select.done_jobs(rows) if any(signal_points(results, job))][
        : select.DEFAULT_JOBS
    ]
    chosen = named or (
        select.done_jobs(rows) if _shows_all(figure, jobs) else with_signal or select.some_jobs(rows)
    )
    if not chosen:
        raise PlotError("none of these jobs is done")
    return chosen


def _shows_all(figure: Figure, jobs: Sequence[str]) -> bool:
    """Check if a figure of signals shows all selected jobs, unless jobs are named."""
    return bool(jobs or figure.by or figure.kind == "waterfall")


def _warn_of_unfinished(results: "Results", figure: Figure, jobs: Sequence[str]) -> None:
    """Warn of selected cases that a figure of signals omits because they are not done."""
    from bearingsim.plots import select

    if KINDS[figure.kind].of_jobs and _shows_all(figure, jobs) and list(jobs) in ([], [ALL]):
        rows = select.matching_rows(select.case_rows(results), figure.where, results.plan["units"])
        if omitted := len(rows) - len(select.done_jobs(rows)):
            text = f"{figure.kind} without {omitted} of {len(rows)} cases, which failed or are not computed yet"
            warnings.warn(text, PlotWarning, stacklevel=3)


# Files


def _option_words(options: Mapping[str, Any]) -> list[str]:
    """List the words of a file name that describe the options of the command, apart from x and y."""
    words = []
    for key, value in options.items():
        if key == "where":
            words += ["where", *(f"{path} {text.replace('-', 'minus ')}" for path, text in value.items())]
        elif key in LISTS:
            words += [key, *value] if key != "y" else []
        elif key != "x":
            words += [key, *([] if value is True else [str(value).replace("..", " to ").replace("-", "minus ")])]
    return words


def slug(words: Sequence[str]) -> str:
    """Join words to a file name: `fig1-velocity-bpfo`."""
    return "-".join("".join(c if c.isalnum() else " " for c in " ".join(words).lower()).split())


def write_figure(canvas: "Canvas", path: Path, results: "Results") -> Path:
    """Write a figure in the format of the file's suffix; return the file.

    Raises PlotError instead of replacing a file that is not a figure of bearingsim, outside the study's folder.
    """
    from bearingsim.plots.style import disable_invalid_math
    from bearingsim.store import write_bytes

    disable_invalid_math(canvas)
    buffer, kind = BytesIO(), path.suffix.removeprefix(".").lower()
    canvas.savefig(buffer, format=kind, metadata=METADATA[kind])
    if path.parent.resolve() != results.path.resolve() / FIGURES and not is_replaceable(path):
        raise PlotError(f"{path} exists and is not a figure of bearingsim; use another --out, or move the file")
    write_bytes(path, buffer.getvalue())
    return path


def is_replaceable(path: Path) -> bool:
    """Check if a path does not exist, or is a figure of bearingsim."""
    if path.is_symlink() or not path.is_file():
        return not path.is_symlink() and not path.exists()
    return MARK in path.read_bytes()
