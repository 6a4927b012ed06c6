"""Results in a folder that cannot be written: read, summarised and drawn elsewhere."""

import os
from pathlib import Path

import pytest

from tests.scenes.commands import type_

RESULTS = Path("results/small")


@pytest.fixture
def read_only(study_folder, monkeypatch):
    """Make the results of the study read-only, also for root, whom permissions do not bind."""
    type_("run", "small.yaml", "--jobs", "1")
    access, root = os.access, RESULTS.resolve()

    def refused(path, mode, **options):
        is_inside = Path(path).resolve().is_relative_to(root)
        return not (is_inside and mode & os.W_OK) and access(path, mode, **options)

    monkeypatch.setattr(os, "access", refused)
    before = sorted(root.rglob("*"))
    yield
    assert sorted(root.rglob("*")) == before


@pytest.mark.parametrize("options", [(), ("--verify",)], ids=["again", "verified"])
def test_finished_run_is_summarised(read_only, options):
    stdout = type_("run", "small.yaml", "--jobs", "1", "--out", RESULTS, *options)[0]
    assert "8 of 8 jobs done" in stdout
    assert "velocity@BPFO (159 Hz): " in stdout


def test_missing_jobs_need_another_folder(read_only):
    stderr = type_("run", "small.yaml", "--out", RESULTS, "--set", "speed=1700 rpm", code=2)[1]
    text = " ".join(stderr.split())
    assert f"{RESULTS} is read-only for you and lacks 8 of 8 jobs: copy it and name the copy by `--out`" in text


@pytest.mark.parametrize(
    ("command", "remedy"), [("plot", "--out figures"), ("report", "--out page.html")], ids=["plot", "report"]
)
def test_files_are_written_elsewhere(read_only, command, remedy):
    stderr = type_(command, RESULTS, code=2)[1]
    assert f"results/small is read-only for you: name another path, as in `{remedy}`" in stderr
    assert type_(command, *remedy.split(), RESULTS)[0]


def test_table_is_shown(read_only):
    assert "8 jobs: 8 done" in type_("show", RESULTS)[0]
