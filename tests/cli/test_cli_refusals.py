"""Refusals of the command line: one sentence, printed once."""

import errno
import re

import pytest
from typer.testing import CliRunner

from bearingsim.cli.app import app
from bearingsim.cli.group import error_text
from tests.scenes.commands import STUDY, type_


@pytest.mark.parametrize("speed", ["0 rpm", "-1800 rpm"])
def test_freq_needs_a_turning_shaft(speed):
    assert (
        f"expected a rotation speed above zero, such as `1800 rpm`, got `{speed}`"
        in (type_("freq", "nf308", "--speed", speed, code=2)[1])
    )


def test_missing_folder_is_reported(study_folder, done):
    expected = "there is no folder nodir\n"
    assert type_("new", "nodir/x.yaml", code=2)[1] == f"nodir/x.yaml: {expected}"
    assert type_("export", done, "--features", "nodir/g.csv", code=2)[1] == f"nodir/g.csv: {expected}"


def test_results_folder_must_not_be_a_file(study_folder):
    _, stderr = type_("run", "small.yaml", "--out", "small.yaml", code=2)
    assert stderr == f"{study_folder / 'small.yaml'} is a file: use a folder, such as --out results/small\n"


@pytest.mark.parametrize(
    ("number", "message"),
    [
        (errno.EACCES, "here/plan.json: you are not allowed to read or write here"),
        (errno.EROFS, "here/plan.json: the disk is read-only: name a path on another disk"),
        (errno.EIO, "here/plan.json: what the system says"),
    ],
)
def test_system_errors_are_sentences(number, message):
    assert error_text(OSError(number, "what the system says", "here/plan.json")) == message


def test_a_full_disk_is_named():
    message = error_text(OSError(errno.ENOSPC, "what the system says", "here/plan.json"))
    assert re.match(
        r"the disk \S+ is full \(\d+ kB are left\); plan\.json in \S+ cannot be written: free some space", message
    )


def test_message_is_printed_once_with_traceback(study_folder):
    (study_folder / "wrong.yaml").write_text(STUDY.replace("1800 rpm", "1800"))
    stderr = CliRunner().invoke(app, ["check", "wrong.yaml", "-v"]).stderr
    assert "load_study" in stderr
    assert stderr.count("speed: expected a rotation speed") == 1


def test_quick_without_quick_section_is_reported(study_folder):
    (study_folder / "whole.yaml").write_text(STUDY.partition("quick:")[0])
    assert "has no `quick:` section" in type_("check", "whole.yaml", "--quick")[1]
    assert type_("check", "small.yaml", "--quick")[1] == ""
