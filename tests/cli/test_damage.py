"""Results that are damaged or do not belong together: what the user is told."""

import shutil

import pytest

from tests.scenes.commands import type_


@pytest.mark.parametrize("text", ["", "{}", "[]", "junk", '{"study": "a", "jobs": [1]}', "\udcff"])
@pytest.mark.parametrize("command", ["show", "plot", "export"])
def test_a_damaged_plan_is_told_with_its_remedy(tmp_path, command, text):
    (tmp_path / "plan.json").write_bytes(text.encode(errors="surrogateescape"))
    _, told = type_(command, tmp_path, code=2)
    assert f"{tmp_path / 'plan.json'} is damaged or of another version: run the study again" in told


def test_the_newest_sound_results_are_taken(done, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(done, "results/small")
    (tmp_path / "results" / "torn").mkdir()
    (tmp_path / "results" / "torn" / "plan.json").write_text("{")
    said, told = type_("show")
    assert "8 jobs: 8 done" in said
    assert "results/torn/plan.json is damaged" in told
