"""Layouts of the JSON files of a results folder."""

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bearingsim import selection, store
from bearingsim.runner import run
from bearingsim.simulation.trial import Trial
from bearingsim.store import layouts
from bearingsim.store.regular import Unreadable
from bearingsim.store.sealed import read_json, write_json
from tests.scenes.fake_studies import ENGINE, FakeStudy

UNKNOWN_ID = "0123456789abcdef"
FIGURE = {
    "y": ["velocity@BPFO"],
    "x": "defect.width",
    "by": [],
    "panels": [],
    "where": {},
    "title": None,
    "log": [],
}
DESIGN = {"kind": "morris", "n": 1, "seed": 1, "paths": ["defect.width"], "ranges": [[1e-3, 2e-3]]}
CHOICE = {"candidate": "ring", "model": "ring", "why": "near enough", "error": {"velocity@BPFO": 0.01}}
TRIAL = {"passes": 4, "turns": 4, "repeats": False, "lines": {"velocity@BPFO": [[1.0, 0.0]] * 4}}
TRIAL |= {"powers": {}, "forces": [1.0] * 4}


@pytest.fixture(scope="module")
def plan() -> dict[str, Any]:
    study: Any = FakeStudy()
    return store.make_plan(study, study.jobs())


def replaced(plan: dict[str, Any], path: str, value: Any) -> dict[str, Any]:
    copied = copy.deepcopy(plan)
    *parents, key = (int(word) if word.isdecimal() else word for word in path.split("/"))
    node: Any = copied
    for word in parents:
        node = node[word]
    node[key] = value
    return copied


def is_valid(plan: dict[str, Any]) -> bool:
    """Check if a plan is accepted."""
    try:
        layouts.check_plan(plan)
    except Unreadable:
        return False
    return True


def test_expanded_study_is_a_valid_plan(plan: dict[str, Any]) -> None:
    ids = [entry["job"] for entry in plan["jobs"]]
    designs = [DESIGN | {"ids": ids[:2]}, DESIGN | {"ids": ["x"]}]
    valid = [plan, plan | {"figures": [FIGURE], "of another version": [1]}, plan | {"design": designs[0]}]
    assert all(map(is_valid, valid))
    assert not is_valid(plan | {"design": designs[1]})


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("study", "../../x"),
        ("study", "a/b"),
        ("study", ".."),
        ("study", "x\n"),
        ("study", 1),
        ("quick", "no"),
        ("units", {"load\x1b[2J": "N"}),
        ("units", []),
        ("jobs", []),
        ("jobs", {}),
        ("jobs/0/job", "../../../../etc/x"),
        ("jobs/0/job", "0123456789ABCDEF"),
        ("jobs/0/healthy", "x"),
        ("jobs/0/healthy", UNKNOWN_ID),
        ("jobs/0/swept", {"load": [1.0]}),
        ("jobs/0/swept", {"x" * 300: 1.0}),
        ("jobs/0/twin", None),
        ("figures", [{"x": "load"}]),
        ("figures", [FIGURE | {"y": "velocity@BPFO"}]),
        ("overrides", {"load": 1}),
        ("notes", "all is well"),
        ("design", DESIGN | {"ids": [UNKNOWN_ID]}),
        ("design", DESIGN | {"ids": []} | {"ranges": []}),
        ("design", DESIGN | {"ids": [], "kind": "grid"}),
        ("variations", [{"of": UNKNOWN_ID, "what": "damping", "value": 1.0, "job": UNKNOWN_ID}]),
        ("accuracy", {"within": 0.1}),
        ("accuracy", {"within": 0.1, "of": [], "jobs": {"../x": {}}, "curves": [], "audits": []}),
        (
            "accuracy",
            {"within": 0.1, "of": [], "jobs": {}, "curves": [], "audits": [{"of": UNKNOWN_ID, "job": UNKNOWN_ID}]},
        ),
    ],
)
def test_invalid_plan_is_refused_with_the_location(plan: dict[str, Any], path: str, value: Any) -> None:
    with pytest.raises(Unreadable, match=f"{path.split('/')[0]}|other entries"):
        layouts.check_plan(replaced(plan, path, value))


def test_duplicate_ids_and_incomplete_blocks_are_refused(plan: dict[str, Any]) -> None:
    with pytest.raises(Unreadable, match="twice"):
        layouts.check_plan(plan | {"jobs": [*plan["jobs"], plan["jobs"][0]]})
    ids = [entry["job"] for entry in plan["jobs"]]
    with pytest.raises(Unreadable, match="inconsistent"):
        layouts.check_plan(plan | {"design": DESIGN | {"ids": ids[:3]}})


@pytest.mark.parametrize(
    ("layout", "value"),
    [
        (layouts.Failure, {"reason": ["a"]}),
        (layouts.Failure, {"reason": "a", "time": "now"}),
        (layouts.Failure, {"attempts": 0}),
        (layouts.Choices, {"one": CHOICE | {"error": {"velocity@BPFO": "large"}}}),
        (layouts.Choices, {"one": {}}),
        (layouts.Trials, {"one": {}}),
        (layouts.Trials, {"one": TRIAL | {"lines": {"velocity@BPFO": [[1.0]]}}}),
        (layouts.Trials, {"one": TRIAL | {"passes": 1e9}}),
    ],
)
def test_invalid_entries_of_other_files_are_refused(layout: Any, value: Any) -> None:
    with pytest.raises(Unreadable):
        layouts.check(layout, value)


@pytest.mark.parametrize(
    "change",
    [
        lambda trial: {"lines": {}},
        lambda trial: {"lines": {"velocity@BPFO": []}},
        lambda trial: {"lines": {"velocity@BPFO": [[1.0, 0.0]]}},
        lambda trial: {"forces": []},
        lambda trial: {"turns": 5},
        lambda trial: {"passes": 10**12},
    ],
)
def test_inconsistent_trial_counts_as_absent(tmp_path: Path, change: Callable[[Any], Any]) -> None:
    folder, features = tmp_path / "trials", ["velocity@BPFO", "outer_force.max"]
    folder.mkdir()
    write_json(folder / f"{UNKNOWN_ID}.json", {"trials": {"one": TRIAL, "two": None}})
    assert set(selection.read_trials(tmp_path, features)) == {"one", "two"}
    write_json(folder / f"{UNKNOWN_ID}.json", {"trials": {"one": TRIAL | change(TRIAL), "two": None}})
    assert "one" not in selection.read_trials(tmp_path, features)


def test_written_trials_can_be_read(tmp_path: Path) -> None:
    lines = {"velocity@BPFO": np.array([1.0 + 2.0j])}
    selection.write_trials(
        tmp_path, UNKNOWN_ID, {"one": Trial(3, 0, True, lines, {"velocity.rms": np.ones(1)}, np.ones(3))}
    )
    assert selection.read_trials(tmp_path, ["velocity@BPFO", "velocity.rms"])["one"] is not None


@pytest.mark.parametrize(
    ("command", "is_kept"),
    [
        ("bearingsim run 'my study.yaml' --out results/x --retry-failed", True),
        ("bearingsim run x.yaml; rm -rf ~", False),
        ("bearingsim run $(id)", False),
        ("bearingsim run 'x\n rm'", False),
        ("bearingsim prune x --no-dry-run", False),
        ("rm -rf x", False),
        ("bearingsim run 'x", False),
    ],
)
def test_stored_command_is_a_run_of_this_program(tmp_path: Path, command: str, is_kept: bool) -> None:
    (tmp_path / "failed").mkdir()
    write_json(tmp_path / "failed" / f"{UNKNOWN_ID}.json", {"reason": "a", "command": command})
    assert store.read_failures(tmp_path)[UNKNOWN_ID].command == (command if is_kept else "")


def test_results_with_an_invalid_plan_are_refused_with_the_location(tmp_path: Path) -> None:
    study: Any = FakeStudy()
    run(study, tmp_path, jobs=1, progress=False, engine=ENGINE)
    write_json(tmp_path / "plan.json", read_json(tmp_path / "plan.json") | {"study": "../../x"})
    with pytest.raises(store.ResultsError, match=r"plan.json is damaged .*\(study: "):
        store.open_results(tmp_path)
