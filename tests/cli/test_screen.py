"""Tables on narrow terminals."""

import math
import re

import pandas as pd
import pytest

from bearingsim.cli import exporting, screen, tables
from bearingsim.store import open_results
from tests.scenes.commands import type_


@pytest.fixture
def terminal(monkeypatch):
    """Return a function that makes stdout a terminal of some width."""

    def set_width(width):
        for module in (screen, tables):
            monkeypatch.setattr(module, "terminal_width", lambda: width)

    return set_width


def rows_of(text):
    """Return headers and cells of a printed table, without blank lines and rules."""
    return [line.split() for line in text.splitlines() if line.strip(" ─")]


def jobs_of(text):
    """Return the cells of the job rows."""
    return [line for line in rows_of(text) if re.fullmatch("[0-9a-f]{8}", line[0])]


@pytest.mark.parametrize("width", [20, 60, 80, 120])
def test_a_narrow_terminal_crops_no_cell(done, terminal, width):
    wide_rows = jobs_of(type_("show", done, "--all")[0])
    terminal(width)
    narrow_rows = jobs_of(type_("show", done, "--all")[0])
    for wide_row, narrow_row in zip(wide_rows, narrow_rows, strict=True):
        assert narrow_row[:4] == wide_row[:4]  # job, load, model
        assert narrow_row[-2:] == wide_row[-2:]  # status, seconds
        assert set(narrow_row) <= set(wide_row)


def test_headings_are_stacked_before_columns_are_omitted(done, terminal):
    wide = len(type_("show", done, "--all")[0].splitlines()[2])
    terminal(wide - 1)
    stdout, _ = type_("show", done, "--all")
    assert "too wide" not in stdout
    assert max(map(len, stdout.splitlines())) < wide
    assert {"velocity@BPFO", "-healthy", "(µm/s)", ".rms"} <= {word for row in rows_of(stdout)[:3] for word in row}


def test_show_lists_columns_that_do_not_fit(done, terminal):
    terminal(64)
    stdout, _ = type_("show", done, "--all")
    assert max(map(len, stdout.splitlines()[:9])) <= 64
    assert "outer_force" not in stdout.splitlines()[0]
    hidden = "velocity@BPFO-healthy (µm/s), velocity.rms (µm/s), outer_force.max (N)"
    hidden += (
        ", error.start, error.start.rms, error.start.force, step_error.line, step_error.rms, step_error.record"
    )
    assert f"9 columns do not fit 64 characters: {hidden} (`--columns NAME`" in " ".join(stdout.split())


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


@pytest.mark.parametrize("accuracy", [False, True])
def test_show_fits_80_columns_without_a_terminal(done, monkeypatch, capsys, accuracy):
    results = open_results(done)
    if accuracy:
        results.table()  # cached: the results themselves have no bounds
        monkeypatch.setattr("bearingsim.runner.promises.withdrawals", lambda *_: [])
        results.plan["accuracy"] = {"notes": ["a note of many words " * 8]}
    tables.show_jobs(results, [], failed=False, as_json=False)
    stdout = capsys.readouterr().out
    lines = stdout.splitlines()
    count = next(number for number, line in enumerate(lines) if " jobs: " in line)
    assert max(map(len, lines[:count])) <= 80  # remarks stay whole in a pipe, for scripts that search them
    assert {"load", "model", "status"} <= {word for row in rows_of(stdout)[:3] for word in row}
    assert ("error" in stdout.splitlines()[0]) == accuracy


def test_heads_of_exported_csv_have_units():
    table = pd.DataFrame({"job": ["a"], "speed": [60.0 * math.pi], "defect.angle": [0.1], "velocity.rms": [1.0]})
    exported = exporting._with_units(table, {"speed": "rpm", "defect.angle": "deg"})
    assert list(exported) == ["job", "speed (rpm)", "defect.angle (rad)", "velocity.rms (m/s)"]
    assert exported["speed (rpm)"][0] == 1800.0  # without errors of rounding
    assert exported["defect.angle (rad)"][0] == 0.1
