"""Plan of a study, and its table."""

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from bearingsim import selection, store
from bearingsim.runner.findings import findings
from bearingsim.selection import Choice
from bearingsim.selection.choices import choice_key
from bearingsim.store import layouts
from bearingsim.store.regular import Unreadable
from bearingsim.store.sealed import write_json
from bearingsim.store.table import healthy_differences
from tests.scenes.fake_studies import PROVENANCE, FakeCase, FakeJob, FakeStudy, case_id, record_of
from tests.scenes.study_text import Write
from tests.scenes.trials import TEXT, accuracy_study


def test_plan_names_the_chosen_models(write: Write) -> None:
    study = accuracy_study(write)
    choices = {choice_key(study, case): Choice("static", "static", "near enough", {}) for case in study.cases()}
    chosen = selection.apply_choices(study, choices)
    plan = json.loads(json.dumps(store.make_plan(chosen, chosen.jobs())))
    layouts.check_plan(plan)
    accuracy = plan["accuracy"]
    assert accuracy["within"] == 0.05
    assert [choice["model"] for choice in accuracy["jobs"].values()] == 3 * ["static"]
    assert accuracy["curves"][0]["jobs"] == list(accuracy["jobs"])
    assert {audit["of"] for audit in accuracy["audits"]} <= set(accuracy["jobs"])
    assert store.make_plan(study, [])["accuracy"] is None


@pytest.mark.parametrize(("text", "nothing"), [("", False), ("uncertainty: none\n", True)])
def test_plan_states_whether_nothing_is_uncertain(write: Write, text: str, nothing: bool) -> None:
    assert store.make_plan(accuracy_study(write, TEXT + text), [])["nothing_uncertain"] is nothing


def test_table_has_each_part_of_the_error_once() -> None:
    """`error.start` is a feature of each result, and a part of the error of a study with `accuracy`."""
    choice = {"model": "ring", "why": "", "error": {"velocity@BPFO": 0.01}}
    jobs = [{"job": name, "swept": {"load": load}, "variation": False} for name, load in (("a", 1.0), ("b", 2.0))]
    accuracy = {
        "within": 0.05,
        "of": ["velocity@BPFO"],
        "jobs": {"a": choice, "b": choice},
        "curves": [],
        "audits": [],
    }
    columns = {
        "features/velocity@BPFO": [1.0, 2.0],
        "features/error.start": [0.02, 0.03],
        "healthy": "",
        "unit": "u",
    }
    frame = pd.DataFrame(columns | {"status": "done", "reason": ""}, index=pd.Index(["a", "b"], name="job"))
    table = store.table.table({"jobs": jobs, "accuracy": accuracy, "assumptions": []}, frame)
    assert table.columns.is_unique
    assert table["model"].tolist() == ["ring", "ring"]
    assert table["error.start"].tolist() == [0.02, 0.03]
    assert table["error.model"].tolist() == pytest.approx([0.01, 0.01])
    assert table["error"].tolist() == pytest.approx([0.03, 0.04])


def test_error_bar_of_a_chaotic_result_includes_its_scatter_once() -> None:
    """The feature `error.start` includes the scatter, the part of the error only the excess over it."""
    accuracy = {"within": 0.05, "of": ["velocity@BPFO"], "curves": [], "audits": []}
    accuracy |= {"jobs": {"a": {"model": "ring", "why": "", "error": {}}}}
    columns = {"velocity@BPFO": 2.0, "velocity@BPFO-scatter": 0.04, "chaotic": 1.0, "error.start": 0.03}
    frame = pd.DataFrame([columns], index=pd.Index(["a"], name="job")).add_prefix("features/")
    frame = frame.assign(healthy="", unit="u", status="done", reason="")
    plan = {"jobs": [{"job": "a", "swept": {}, "variation": False}], "accuracy": accuracy, "assumptions": []}
    table = store.table.table(plan, frame)
    assert table["error.start"].tolist() == pytest.approx([0.03 - 0.04 / 2.0])
    assert store.feature_bounds(plan, frame)["velocity@BPFO"].tolist() == pytest.approx([0.03])
    assert table["error"].tolist() == pytest.approx([0.03])


def test_swept_values_replace_no_column_of_the_table() -> None:
    """A plan that is not of this program may name a path like a column."""
    jobs = [{"job": "a", "swept": {"load": 1.0, "status": "swept", "velocity.rms": 2.0}}]
    frame = pd.DataFrame(
        {"features/velocity.rms": [1e-3], "healthy": "", "unit": "u", "status": "done", "reason": ""}, index=["a"]
    )
    table = store.table.table({"jobs": jobs}, frame)
    assert table.columns.is_unique
    assert (table["load"][0], table["status"][0], table["velocity.rms"][0]) == (1.0, "done", 1e-3)


def test_damaged_plan_is_refused(tmp_path: Path) -> None:
    study: Any = FakeStudy()
    plan = store.write_plan(tmp_path, study, study.jobs())
    assert store.read_plan(tmp_path)["study"] == "fake"
    write_json(tmp_path / "plan.json", plan | {"jobs": {}})
    with pytest.raises(Unreadable, match=r"^jobs"):
        store.read_plan(tmp_path)


def test_changes_from_healthy_of_a_line_and_of_a_band() -> None:
    """A line changes by the distance of complex amplitudes, a band by the difference of its values."""
    columns = {
        "healthy": ["intact", "absent", None],
        "features/velocity@BPFO": [5.0, 1.0, 3.0],
        "features/velocity@BPFO.phase": [0.0, 0.0, np.pi / 3.0],
        "features/acceleration.rms@2000-10000Hz": [7.0, 1.0, 4.0],
    }
    changes = healthy_differences(pd.DataFrame(columns, index=["damaged", "alone", "intact"]))
    line, band = "features/velocity@BPFO-healthy", "features/acceleration.rms@2000-10000Hz-healthy"
    assert list(changes) == [line, band]
    assert changes[line].iloc[0] == pytest.approx(np.sqrt(5.0**2 + 3.0**2 - 5.0 * 3.0))
    assert changes[band].iloc[0] == 3.0
    assert changes.iloc[1:].isna().all(axis=None)


class WavyCase(FakeCase):
    """Case with waviness and friction."""

    def model_dump(self) -> dict[str, Any]:
        harmonics = [{"order": 5.0, "amplitude": 1e-6}]
        return super().model_dump() | {
            "surfaces": {"outer": {"harmonics": harmonics, "spectrum": {"shape": "steep"}}},
            "friction": {"law": "coulomb"},
        }


@pytest.mark.parametrize("was_planned", [False, True])
def test_jobs_outside_the_plan_have_no_effect_on_the_table(tmp_path: Path, was_planned: bool) -> None:
    """A study was computed with waviness and a band, then edited: its folder keeps both results."""
    study, case = FakeStudy(), WavyCase(9e-3)
    jobs, wavy, record = study.jobs(), FakeJob(case_id(case), case, {}, None), record_of(case)
    record.features["velocity.rms@10-1000Hz"] = 1e-3
    store.write_plan(tmp_path / "new", study, jobs)  # type: ignore[arg-type]
    store.write_units(tmp_path / "new", [(job, record_of(job.case)) for job in jobs], PROVENANCE)
    expected = store.build_table(tmp_path / "new")
    root = tmp_path / "edited"
    store.write_plan(root, study, [*jobs, wavy] if was_planned else jobs)  # type: ignore[arg-type, list-item]
    store.write_units(root, [(wavy, record)], PROVENANCE)  # type: ignore[list-item]
    store.write_units(root, [(job, record_of(job.case)) for job in jobs], PROVENANCE)
    assert ("features/velocity.rms@10-1000Hz" in store.build_table(root)) == was_planned
    plan = store.write_plan(root, study, jobs)  # type: ignore[arg-type]
    frame = store.build_table(root)
    names = frame.columns[(frame.notna() & (frame != "")).any()]
    assert set(names) <= set(expected)
    assert not {name for name in set(frame) - set(expected) if frame[name].dtype.kind == "f"}
    assert "smooth surfaces" in findings(plan, frame).assumptions
    results = store.open_results(root)
    assert list(results.table()) == list(store.open_results(tmp_path / "new").table())
    assert not results.has_feature("velocity.rms@10-1000Hz")


def test_folder_and_study_may_have_names_that_are_no_utf8(tmp_path: Path) -> None:
    """As on a disk that was written with Latin-1 names."""
    root = tmp_path / os.fsdecode(b"caf\xe9")
    study = FakeStudy(path=root / "fake.yaml")
    store.write_plan(root, study, study.jobs())  # type: ignore[arg-type]
    store.Failure(study.jobs()[0].id, "no reason", command=f"bearingsim run {root}").write(root)
    store.log(root, "merged", folders=[str(root)])
    results = store.open_results(root)
    assert Path(results.plan["file"]).parts[-2:] == ("caf?", "fake.yaml")
    assert list(results.failures()) == [study.jobs()[0].id]
    (journal,) = root.glob("journal-*.jsonl")
    assert json.loads(journal.read_text())["folders"] == [str(tmp_path / "caf?")]
