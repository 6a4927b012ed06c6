"""Runs in a folder with earlier results: damaged units, and jobs outside the plan."""

from dataclasses import replace
from pathlib import Path

import pytest

from bearingsim import store
from bearingsim.runner import Interrupted, run
from tests.scenes.fake_studies import ENGINE, FakeStudy


def compute(study, out, **options):
    return run(study, out, jobs=1, progress=False, engine=ENGINE, **options)


@pytest.mark.parametrize("share", [0.02, 0.1, 0.3, 0.5, 0.7, 0.9])
def test_damaged_unit_is_computed_again_and_reported(tmp_path, share):
    study = FakeStudy()
    compute(study, tmp_path)
    [path] = tmp_path.glob("units/??/*.h5")
    content = bytearray(path.read_bytes())
    start = int(share * len(content))
    content[start : start + 2000] = bytes(byte ^ 0xFF for byte in content[start : start + 2000])
    path.write_bytes(content)
    summary = compute(study, tmp_path, verify=True)
    assert summary.done == 4
    assert "1 damaged file (units/" in str(summary)
    assert set(store.open_results(tmp_path).table()["status"]) == {"done"}


@pytest.mark.parametrize("error", [OSError, KeyError, TypeError, ValueError, RuntimeError])
def test_any_read_error_counts_as_damage(tmp_path, monkeypatch, error):
    def fail(*_):
        raise error("torn")

    study = FakeStudy()
    compute(study, tmp_path)
    monkeypatch.setattr("bearingsim.store.units._check", fail)
    [path] = tmp_path.glob("units/??/*.h5")
    with pytest.raises(store.DamagedUnit, match="torn"):
        store.check_unit(path)


def test_jobs_outside_the_plan_are_reported_and_reused(tmp_path):
    wide, narrow = FakeStudy([1e-3, 2e-3, 3e-3]), FakeStudy([1e-3])
    assert "earlier plan" not in str(compute(wide, tmp_path))
    output = str(compute(narrow, tmp_path))
    assert "2 jobs of an earlier plan are not in the table" in output
    summary = compute(wide, tmp_path)
    assert (summary.done, summary.resumed) == (0, 4)
    assert "earlier plan" not in str(summary)


def test_jobs_of_one_unit_are_reused_after_a_narrower_run(tmp_path):
    """All jobs of a unit are read again, although a narrower plan contained only some of them."""
    for widths in ([1e-3, 2e-3, 3e-3], [2e-3], [1e-3, 2e-3, 3e-3]):
        compute(FakeStudy(widths), tmp_path)
        table = store.open_results(tmp_path).table()
        assert len(table) == len(widths) + 1
        assert set(table["status"]) == {"done"}
    assert len(list(tmp_path.glob("units/??/*.h5"))) == 1


def test_damaged_plan_is_replaced(tmp_path):
    compute(FakeStudy(), tmp_path)
    (tmp_path / "plan.json").write_text("{")
    assert compute(FakeStudy(), tmp_path).resumed == 4


def test_a_quick_study_has_its_own_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    compute(FakeStudy(), None)
    compute(replace(FakeStudy(), quick=True), None)
    assert sorted(path.name for path in Path("results").iterdir()) == ["fake", "fake-quick"]


def test_interruption_message_has_command_to_continue(tmp_path):
    with pytest.raises(Interrupted) as interruption:
        compute(FakeStudy(actions={1: "interrupt"}), tmp_path)
    message = str(interruption.value)
    assert message.startswith("interrupted: fake: ")
    assert f"results so far: {tmp_path}; run the same command to continue" in message
