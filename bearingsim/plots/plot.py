"""`bearingsim plot`: which figures, drawn and written where."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bearingsim.plots.labels import PlotError

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure as Canvas

    from bearingsim.store import Results
    from bearingsim.study import Figure

__all__ = ["FORMATS", "KINDS", "drawn", "plot"]

KINDS = ("sweep", "phase", "series", "spectrum")
FORMATS = ("png", "svg", "pdf")


def plot(
    results: "Results",
    kind: str = "sweep",
    x: str | None = None,
    by: Sequence[str] = (),
    y: Sequence[str] = (),
    jobs: Sequence[str] = (),
    file_format: str = "png",
    out: Path | None = None,
) -> list[Path]:
    """Draw figures of a study into ``out`` (default: its ``figures`` folder); return the files.

    kind: `sweep` features against swept paths (x, by and y instead of what the study names), `phase` the same
    for the line's phase, `series` and `spectrum` of some jobs (ids). Raises PlotError, ResultsError.
    """
    import matplotlib as mpl

    from bearingsim.plots.style import RC

    folder = out or results.path / "figures"
    with mpl.rc_context(RC):  # type: ignore[arg-type]
        sheets = drawn(results, kind, x, by, y, jobs)
        folder.mkdir(parents=True, exist_ok=True)
        return [_written(canvas, folder / f"{name}.{file_format}") for name, canvas in sheets]


def drawn(
    results: "Results",
    kind: str = "sweep",
    x: str | None = None,
    by: Sequence[str] = (),
    y: Sequence[str] = (),
    jobs: Sequence[str] = (),
) -> list[tuple[str, "Canvas"]]:
    """The figures of ``plot`` with their names, not written anywhere."""
    if kind in ("series", "spectrum"):
        return _of_jobs(results, kind, jobs)
    return _of_table(results, kind, x, by, y)


def _written(canvas: "Canvas", path: Path) -> Path:
    canvas.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None)
    return path


def _of_table(
    results: "Results", kind: str, x: str | None, by: Sequence[str], y: Sequence[str]
) -> list[tuple[str, "Canvas"]]:
    from bearingsim.plots import select, sweep
    from bearingsim.plots.caption import fixed_values

    rows, units = select.case_rows(results), results.plan["units"]
    if kind == "phase":
        rows = select.with_defect_phase(results, rows)
    sheets = []
    for number, wanted in enumerate(_wanted(results, rows, kind, x, by, y), 1):
        figure, part = select.completed(wanted, rows, units)
        caption = fixed_values(results, part, {figure.x, *figure.by, *figure.panels})
        sheets.append((_name(number, figure), sweep.draw(figure, part, units, caption)))
    return sheets


def _wanted(
    results: "Results", rows: "pd.DataFrame", kind: str, x: str | None, by: Sequence[str], y: Sequence[str]
) -> "list[Figure]":
    """The figures asked for: the study's own, with what was said on the command line instead."""
    from dataclasses import replace

    from bearingsim.plots import select
    from bearingsim.study import Figure

    found = [Figure(y=select.default_y(rows), x=x)] if x else select.planned(results, rows)
    changes: dict[str, Any] = {"by": tuple(by)} if by else {}
    if y or kind == "phase":
        changes["y"] = tuple(y) or select.PHASES
    changed = [replace(figure, **changes) for figure in found]
    return [figure for number, figure in enumerate(changed) if figure not in changed[:number]]


def _name(number: int, figure: "Figure") -> str:
    """`fig1-velocity-bpfo-vs-defect-length`."""
    words = f"fig{number} {figure.y[0]} vs {figure.x}".lower()
    return "-".join("".join(c if c.isalnum() else " " for c in words).split())


def _of_jobs(results: "Results", kind: str, jobs: Sequence[str]) -> list[tuple[str, "Canvas"]]:
    from bearingsim.plots import series

    chosen = list(jobs) or series.some_jobs(results)
    if not chosen:
        raise PlotError("no job is done yet: there is nothing to draw")
    draw = series.draw_spectrum if kind == "spectrum" else series.draw_series
    return [(kind, draw(results, chosen))]
