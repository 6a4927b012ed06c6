"""`bearingsim bench`, the chart of speed against accuracy."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from bearingsim.cli.opening import short_path
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    from bearingsim.bench.plan import Settings


def show(study: Path | None, scenes: Sequence[str], quick: bool, folder: Path | None, jobs: int) -> None:
    """Compute, draw and print the chart of speed against accuracy."""
    if study is not None and scenes:
        raise typer.BadParameter("name a study or built-in scenes, not both", param_hint="--scene")
    default_folder = "bench-chart-quick" if quick else "bench-chart"
    target = folder or Path("results") / (f"bench-{study.stem}" if study is not None else default_folder)
    for file in chart(study, scenes, quick, target, jobs):
        say(short_path(file))


def chart(
    study: Path | None,
    names: Sequence[str],
    quick: bool,
    folder: Path,
    jobs: int,
    others: "Mapping[str, Settings] | None" = None,
    left_out: Mapping[str, str] | None = None,
) -> list[Path]:
    """Compute the missing rows of a chart and return its files.

    others, left_out: as of ``bench.table.compute``.
    """
    from bearingsim.bench import plan, report, scene, table
    from bearingsim.bench.errors import with_errors
    from bearingsim.cli.screen import print_table
    from bearingsim.plots import speed_accuracy

    scenes = (
        scene.load_scenes(study, quick) if study is not None else scene.own(names or plan.scenes_of(quick), quick)
    )
    rows = table.compute(scenes, folder, quick, jobs, others, dict(left_out or {}))
    parts = [
        report.Part(
            entry.name,
            entry.title,
            with_errors([row for row in rows if row["scene"] == entry.name]),
            entry.reference.duration,
        )
        for entry in scenes
    ]
    print_table(report.HEADS, [report.line_of(part) for part in parts], text_columns=len(report.HEADS))
    files = [table.written([row for part in parts for row in part.rows], folder / "chart.csv")]
    files += [speed_accuracy.draw(part.rows, part.title, folder / report.figure_name(part)) for part in parts]
    return [*files, report.write(parts, folder), folder / table.ABOUT]
