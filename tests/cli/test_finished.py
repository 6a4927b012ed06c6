"""Repeated runs of a finished study, recognised by its plan, unless a file or option has changed."""

from importlib import import_module
from pathlib import Path

import pytest

from bearingsim.store import open_results
from tests.scenes.commands import type_

provenance = import_module("bearingsim.store.provenance")
running = import_module("bearingsim.runner.running")
NF308 = (Path(__file__).parents[2] / "configs" / "bearings" / "nf308.yaml").read_text(encoding="utf-8")
STUDY = """\
study: told
bearing: mine.yaml
model: static
speed: 1800 rpm
duration: 60 ms
record: []
defect: {race: outer, shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 5 um}
sweep: {load: [150 N, 300 N]}
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(provenance, "_commit", lambda: "")
    (tmp_path / "mine.yaml").write_text(NF308)
    (tmp_path / "told.yaml").write_text(STUDY)
    assert "4 of 4 jobs done" in type_("run", "told.yaml", "--jobs", 1)[0]
    return tmp_path


def run_again(*options):
    """Run the study again; return stdout, and whether the cases of the study were built."""
    calls, make_plan = [], running.make_plan

    def recorded_plan(*arguments):
        calls.append(True)
        return make_plan(*arguments)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(running, "make_plan", recorded_plan)
        stdout, _ = type_("run", "told.yaml", "--jobs", 1, *options)
    return stdout, bool(calls)


def test_second_run_prints_the_same_summary(folder):
    verified, planned = run_again("--verify")
    repeat, replanned = run_again()
    assert (planned, replanned) == (True, False)
    assert [line for line in verified.splitlines() if "CPU" not in line][1:] == repeat.splitlines()[1:]
    assert "4 of 4 jobs done" in repeat


@pytest.mark.parametrize(
    ("file", "old", "new"), [("told.yaml", "1800 rpm", "1700 rpm"), ("mine.yaml", "12 mm", "12.1 mm")]
)
def test_changed_input_is_recomputed(folder, file, old, new):
    path = folder / file
    path.write_text(path.read_text().replace(old, new))
    stdout, is_planned = run_again()
    assert is_planned
    assert "4 of 4 jobs done" in stdout


def test_new_file_earlier_on_search_path_is_noticed(folder):
    (folder / "told.yaml").write_text(STUDY.replace("mine.yaml", "nf308"))
    assert run_again()[1]
    assert not run_again()[1]
    (folder / "configs" / "bearings").mkdir(parents=True)
    (folder / "configs" / "bearings" / "nf308.yaml").write_text(NF308)
    assert run_again()[1]


def test_changed_options_are_recomputed(folder):
    assert run_again("--set", "speed=900 rpm")[1]
    assert not run_again("--set", "speed=900 rpm")[1]
    assert run_again()[1]


def test_missing_result_is_computed(folder):
    unit = next((folder / "results" / "told" / "units").rglob("*.h5"))
    unit.unlink()
    stdout, is_planned = run_again()
    assert is_planned
    assert "4 jobs" in stdout


def test_modified_source_tree_is_recomputed(folder, monkeypatch):
    monkeypatch.setattr(provenance, "_commit", lambda: "0123-dirty")
    assert run_again()[1]
    assert run_again()[1]


def test_order_of_assignments_is_noticed(folder):
    """A rig named after its stiffness replaces the stiffness, before it keeps the set one."""
    assignments = ("--set", "rig.bracket_stiffness=2e7 N/m"), ("--set", "rig=bvt5")
    for options, stiffness in ((assignments[0] + assignments[1], 1e7), (assignments[1] + assignments[0], 2e7)):
        run_again(*options)
        parameters = open_results(folder / "results" / "told").parameters()
        assert set(parameters["rig.bracket_stiffness"]) == {stiffness}
