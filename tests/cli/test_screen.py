"""Tables on narrow terminals."""

import re

import pytest

from bearingsim.cli import screen, tables
from tests.scenes.commands import type_


@pytest.fixture
def terminal(monkeypatch):
    """Return a function that makes stdout a terminal of some width."""

    def set_width(width):
        for module in (screen, tables):
            monkeypatch.setattr(module, "terminal_width", lambda: width)

    return set_width


def rows_of(text):
    """Return heads and cells of a printed table, without blank lines and rules."""
    return [line.split() for line in text.splitlines() if line.strip(" ─")]


def jobs_of(text):
    """Return the cells of the job rows."""
    return [line for line in rows_of(text) if re.fullmatch("[0-9a-f]{8}", line[0])]


@pytest.mark.parametrize("width", [20, 60, 80, 120])
def test_a_narrow_terminal_crops_no_cell(done, terminal, width):
    wide_rows = jobs_of(type_("show", done)[0])
    terminal(width)
    narrow_rows = jobs_of(type_("show", done)[0])
    for wide_row, narrow_row in zip(wide_rows, narrow_rows, strict=True):
        assert narrow_row[:4] == wide_row[:4]  # job, load, model
        assert narrow_row[-2:] == wide_row[-2:]  # status, seconds
        assert set(narrow_row) <= set(wide_row)


def test_headings_are_stacked_before_columns_are_omitted(done, terminal):
    wide = len(type_("show", done)[0].splitlines()[2])
    terminal(wide - 1)
    stdout, _ = type_("show", done)
    assert "too wide" not in stdout
    assert max(map(len, stdout.splitlines())) < wide
    assert {"velocity@BPFO", "-healthy", "(µm/s)", ".rms"} <= {word for row in rows_of(stdout)[:3] for word in row}


def test_show_lists_columns_that_do_not_fit(done, terminal):
    terminal(64)
    stdout, _ = type_("show", done)
    assert max(map(len, stdout.splitlines()[:9])) <= 64
    assert "outer_force" not in stdout.splitlines()[0]
    hidden = "velocity@BPFO-healthy (µm/s), velocity.rms (µm/s), outer_force.max (N)"
    hidden += (
        ", error.start, error.start.rms, error.start.force, step_error.line, step_error.rms, step_error.record"
    )
    assert f"9 columns too wide for the terminal: {hidden} (`--columns NAME`" in stdout


def test_requested_columns_are_all_printed(done, terminal):
    terminal(20)
    stdout, _ = type_("show", done, "--columns", "velocity.rms", "--columns", "outer_force.max")
    assert stdout.splitlines()[0].split() == ["job", "velocity.rms", "(µm/s)", "outer_force.max", "(N)"]


def test_long_texts_are_folded(terminal, capsys):
    terminal(40)
    screen.print_table(
        ["", "what", "order"], [["FTF", "turns of the cage, and some more words", "1.25"]], text_columns=2
    )
    stdout = capsys.readouterr().out
    assert max(map(len, stdout.splitlines())) <= 40
    assert "1.25" in stdout
