"""Damaged results: messages to the user."""

import os
import shutil
from pathlib import Path

import pytest

from bearingsim.cli.opening import result_folders
from tests.scenes.commands import type_


@pytest.mark.parametrize("text", ["", "{}", "[]", "junk", '{"study": "a", "jobs": [1]}', "\udcff"])
@pytest.mark.parametrize("command", ["show", "plot", "export"])
def test_damaged_plan_is_reported_with_remedy(tmp_path, command, text):
    (tmp_path / "plan.json").write_bytes(text.encode(errors="surrogateescape"))
    _, stderr = type_(command, tmp_path, code=2)
    assert f"{tmp_path / 'plan.json'} is damaged or of another version: run the study again" in stderr


def test_files_that_a_run_removes_meanwhile_are_ignored(tmp_path, monkeypatch):
    """They are listed, but gone when their times are read."""
    monkeypatch.chdir(tmp_path)
    for folder, time in (("old", 1000.0), ("new", 2000.0)):
        plan = tmp_path / "results" / folder / "plan.json"
        plan.parent.mkdir(parents=True)
        plan.touch()
        os.utime(plan, (time, time))
    listed = Path.glob

    def listed_before_removal(folder, pattern):
        return [*listed(folder, pattern), *([folder / "plan.json.tmp"] if pattern == "*" else [])]

    monkeypatch.setattr(Path, "glob", listed_before_removal)
    assert [folder.name for folder in result_folders()] == ["new", "old"]


def test_newest_valid_results_are_used(done, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(done, "results/small")
    (tmp_path / "results" / "torn").mkdir()
    (tmp_path / "results" / "torn" / "plan.json").write_text("{")
    stdout, stderr = type_("show")
    assert "8 jobs: 8 done" in stdout
    assert "results/torn/plan.json is damaged" in stderr
