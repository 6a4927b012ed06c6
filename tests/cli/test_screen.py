"""Tables on narrow terminals."""

import re

import pytest

from bearingsim.cli import screen, tables
from tests.scenes.commands import type_


@pytest.fixture
def terminal(monkeypatch):
    """Makes stdout a terminal of some width."""

    def of_width(width):
        for module in (screen, tables):
            monkeypatch.setattr(module, "terminal_width", lambda: width)

    return of_width


def rows_of(said):
    """Heads and cells of a printed table, blank lines and rules left out."""
    return [line.split() for line in said.splitlines() if line.strip(" ─")]


def jobs_of(said):
    """The cells of the lines of jobs."""
    return [line for line in rows_of(said) if re.fullmatch("[0-9a-f]{8}", line[0])]


@pytest.mark.parametrize("width", [20, 60, 80, 120])
def test_a_narrow_terminal_crops_no_cell(done, terminal, width):
    whole = jobs_of(type_("show", done)[0])
    terminal(width)
    narrow = jobs_of(type_("show", done)[0])
    for line, kept in zip(whole, narrow, strict=True):
        assert kept[:4] == line[:4]  # job, load, model
        assert kept[-2:] == line[-2:]  # status, seconds
        assert set(kept) <= set(line)


def test_heads_are_stacked_before_a_column_is_left_out(done, terminal):
    wide = len(type_("show", done)[0].splitlines()[2])
    terminal(wide - 1)
    said, _ = type_("show", done)
    assert "too wide" not in said
    assert max(map(len, said.splitlines())) < wide
    assert {"velocity@BPFO", "-healthy", "(µm/s)", ".rms"} <= {word for row in rows_of(said)[:3] for word in row}


def test_show_tells_what_does_not_fit(done, terminal):
    terminal(64)
    said, _ = type_("show", done)
    assert max(map(len, said.splitlines()[:9])) <= 64
    assert "outer_force" not in said.splitlines()[0]
    left = "velocity@BPFO-healthy (µm/s), velocity.rms (µm/s), outer_force.max (N)"
    left += ", error.start, error.start.rms, error.start.force, step_error.line, step_error.rms, step_error.record"
    assert f"9 columns too wide for the terminal: {left} (`--columns NAME`" in said


def test_columns_asked_for_are_all_printed(done, terminal):
    terminal(20)
    said, _ = type_("show", done, "--columns", "velocity.rms", "--columns", "outer_force.max")
    assert said.splitlines()[0].split() == ["job", "velocity.rms", "(µm/s)", "outer_force.max", "(N)"]


def test_long_texts_are_folded(terminal, capsys):
    terminal(40)
    screen.print_table(
        ["", "what", "order"], [["FTF", "turns of the cage, and some more words", "1.25"]], text_columns=2
    )
    said = capsys.readouterr().out
    assert max(map(len, said.splitlines())) <= 40
    assert "1.25" in said
