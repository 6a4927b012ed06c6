"""`bearingsim bench`: the chart of speed against accuracy."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from bearingsim.cli.opening import near
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    from bearingsim.bench.plan import Settings

__all__ = ["chart", "show"]


def show(study: Path | None, scenes: Sequence[str], quick: bool, folder: Path | None, jobs: int) -> None:
    """Compute, draw and tell."""
    if study is not None and scenes:
        raise typer.BadParameter("name a study or scenes of the program, not both", param_hint="--scene")
    usual = "bench-chart-quick" if quick else "bench-chart"
    target = folder or Path("results") / (f"bench-{study.stem}" if study is not None else usual)
    for file in chart(study, scenes, quick, target, jobs):
        say(near(file))


def chart(
    study: Path | None,
    names: Sequence[str],
    quick: bool,
    folder: Path,
    jobs: int,
    others: "Mapping[str, Settings] | None" = None,
    left_out: Mapping[str, str] | None = None,
) -> list[Path]:
    """The files of a chart: what is not there yet is computed. others, left_out: as of ``bench.table.compute``."""
    from bearingsim.bench import plan, report, scene, table
    from bearingsim.bench.errors import with_errors
    from bearingsim.cli.screen import print_table
    from bearingsim.plots import speed_accuracy

    chosen = scene.of_file(study, quick) if study is not None else scene.own(names or plan.scenes_of(quick), quick)
    rows = table.compute(chosen, folder, quick, jobs, others, dict(left_out or {}))
    parts = [
        report.Part(
            one.name,
            one.title,
            with_errors([row for row in rows if row["scene"] == one.name]),
            one.reference.duration,
        )
        for one in chosen
    ]
    print_table(report.HEADS, [report.line_of(part) for part in parts], words=len(report.HEADS))
    files = [table.written([row for part in parts for row in part.rows], folder / "chart.csv")]
    files += [speed_accuracy.draw(part.rows, part.title, folder / report.figure_name(part)) for part in parts]
    return [*files, report.write(parts, folder), folder / table.ABOUT]
