"""Figures of the documentation: each has a command that makes it."""

from benchmarks.figures import FIGURES, SOURCES


def test_each_committed_figure_has_a_command_and_each_command_a_figure():
    committed = {path.relative_to(FIGURES).as_posix() for path in FIGURES.rglob("*.png")}
    assert committed
    assert committed == set(SOURCES)
    assert all(source.command for source in SOURCES.values())
