"""A run with nothing left to do is told by its plan, and by nothing else that may have changed."""

from importlib import import_module
from pathlib import Path

import pytest

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


def repeated(*words):
    """What a second run says, and whether it made the cases of the study."""
    made, usual = [], running.make_plan

    def planned(*given):
        made.append(True)
        return usual(*given)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(running, "make_plan", planned)
        said, _ = type_("run", "told.yaml", "--jobs", 1, *words)
    return said, bool(made)


def test_a_second_run_says_what_the_first_said(folder):
    first, made = repeated("--verify")
    second, quick = repeated()
    assert (made, quick) == (True, False)
    assert [line for line in first.splitlines() if "CPU" not in line][1:] == second.splitlines()[1:]
    assert "4 of 4 jobs done" in second


@pytest.mark.parametrize(
    ("file", "old", "new"), [("told.yaml", "1800 rpm", "1700 rpm"), ("mine.yaml", "12 mm", "12.1 mm")]
)
def test_a_file_that_has_changed_is_read(folder, file, old, new):
    path = folder / file
    path.write_text(path.read_text().replace(old, new))
    said, made = repeated()
    assert made
    assert "4 of 4 jobs done" in said


def test_a_file_that_would_be_found_first_is_seen(folder):
    (folder / "told.yaml").write_text(STUDY.replace("mine.yaml", "nf308"))
    assert repeated()[1]
    assert not repeated()[1]
    (folder / "configs" / "bearings").mkdir(parents=True)
    (folder / "configs" / "bearings" / "nf308.yaml").write_text(NF308)
    assert repeated()[1]


def test_what_is_asked_otherwise_is_computed(folder):
    assert repeated("--set", "speed=900 rpm")[1]
    assert not repeated("--set", "speed=900 rpm")[1]
    assert repeated()[1]


def test_a_result_that_is_missing_is_computed(folder):
    unit = next((folder / "results" / "told" / "units").rglob("*.h5"))
    unit.unlink()
    said, made = repeated()
    assert made
    assert "4 jobs" in said


def test_a_program_that_is_being_changed_says_nothing(folder, monkeypatch):
    monkeypatch.setattr(provenance, "_commit", lambda: "0123-dirty")
    assert repeated()[1]
    assert repeated()[1]
