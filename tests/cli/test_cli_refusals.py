"""What the command line refuses, in one sentence and once."""

import errno
import re

import pytest
from typer.testing import CliRunner

from bearingsim.cli import app
from bearingsim.cli.group import error_text
from tests.scenes.commands import STUDY, type_


@pytest.mark.parametrize("speed", ["0 rpm", "-1800 rpm"])
def test_freq_needs_a_turning_shaft(speed):
    assert (
        f"expected a rotation speed above zero, such as `1800 rpm`, got `{speed}`"
        in (type_("freq", "nf308", "--speed", speed, code=2)[1])
    )


def test_a_missing_folder_is_told(here, done):
    wanted = "there is no folder nodir\n"
    assert type_("new", "nodir/x.yaml", code=2)[1] == f"nodir/x.yaml: {wanted}"
    assert type_("export", done, "--features", "nodir/g.csv", code=2)[1] == f"nodir/g.csv: {wanted}"


def test_a_file_is_no_results_folder(here):
    _, told = type_("run", "small.yaml", "--out", "small.yaml", code=2)
    assert told == f"{here / 'small.yaml'} is a file: use a folder, such as --out results/small\n"


@pytest.mark.parametrize(
    ("number", "message"),
    [
        (errno.EACCES, "here/plan.json: you are not allowed to read or write here"),
        (errno.EROFS, "here/plan.json: the disk can only be read"),
        (errno.EIO, "here/plan.json: what the system says"),
    ],
)
def test_errors_of_the_system_are_sentences(number, message):
    assert error_text(OSError(number, "what the system says", "here/plan.json")) == message


def test_a_full_disk_is_named():
    told = error_text(OSError(errno.ENOSPC, "what the system says", "here/plan.json"))
    assert re.match(
        r"the disk \S+ is full \(\d+ kB are left\); plan\.json in \S+ cannot be written: make room", told
    )


def test_a_message_stands_once_even_with_its_traceback(here):
    (here / "wrong.yaml").write_text(STUDY.replace("1800 rpm", "1800"))
    told = CliRunner().invoke(app, ["check", "wrong.yaml", "-v"]).stderr
    assert "load_study" in told
    assert told.count("speed: expected a rotation speed") == 1


def test_quick_without_a_quick_grid_is_told(here):
    (here / "whole.yaml").write_text(STUDY.partition("quick:")[0])
    assert "has no `quick:` section" in type_("check", "whole.yaml", "--quick")[1]
    assert type_("check", "small.yaml", "--quick")[1] == ""
