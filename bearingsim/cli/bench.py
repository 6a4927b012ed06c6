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
    for file in draw_chart(study, scenes, quick, target, jobs):
        say(short_path(file))


def draw_chart(
    study: Path | None,
    names: Sequence[str],
    quick: bool,
    folder: Path,
    jobs: int,
    peers: "Mapping[str, Settings] | None" = None,
    missing_peers: Mapping[str, str] | None = None,
) -> list[Path]:
    """Compute the missing rows of a chart and return its files.

    peers, missing_peers: as of ``bench.table.compute``.
    """
    from bearingsim.bench import plan, report, scene, table
    from bearingsim.bench.errors import with_errors
    from bearingsim.cli.screen import print_table
    from bearingsim.plots import speed_accuracy

    scenes = (
        scene.load_scenes(study, quick)
        if study is not None
        else scene.built_in_scenes(names or plan.default_scenes(quick), quick)
    )
    rows = table.compute(scenes, folder, quick, jobs, peers, dict(missing_peers or {}))
    sections = [
        report.Section(
            entry.name,
            entry.title,
            with_errors([row for row in rows if row["scene"] == entry.name]),
            entry.reference.duration,
        )
        for entry in scenes
    ]
    print_table(
        report.HEADERS, [report.summary_row(section) for section in sections], text_columns=len(report.HEADERS)
    )
    files = [table.write_csv([row for section in sections for row in section.rows], folder / "chart.csv")]
    files += [
        speed_accuracy.draw(section.rows, section.title, folder / report.figure_name(section))
        for section in sections
    ]
    return [*files, report.write(sections, folder), folder / table.PROVENANCE_FILE]
