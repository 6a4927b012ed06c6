"""``SAMPLE=4``: which of the long tests a commit runs."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from tests import conftest

MODELS, DEFECTS = ["ring", "rollers", "planar", "spatial", "static"], ["none", "slot", "bowl"]


def items(test: str) -> list[Any]:
    """Return the cases of a test of every model and defect."""
    return [
        SimpleNamespace(
            path=Path("tests/test_a.py"),
            name=f"{test}[{model}-{defect}]",
            callspec=SimpleNamespace(params={"model": model, "defect": defect}),
        )
        for model in MODELS
        for defect in DEFECTS
    ]


@pytest.mark.parametrize("line", conftest.SAMPLED)
def test_every_sampled_test_exists(line: str) -> None:
    file, _, test = line.partition("::")
    assert f"def {test}(" in conftest.FILES[file].read_text()


def test_commits_share_all_groups_of_cases(monkeypatch: pytest.MonkeyPatch) -> None:
    """A commit runs whole groups, a quarter of them; four draws run each case once."""
    monkeypatch.setattr(conftest, "SAMPLED", {"a::test_b": "model", "a::test_c": ""})
    monkeypatch.setenv("SAMPLE", "4")
    runs = set()
    for commit in map(str, range(60)):
        monkeypatch.setattr(conftest, "commit", lambda commit=commit: commit)
        left_out = {item.name for item in conftest.left_out(items("test_b") + items("test_c"))}
        kept = [item for item in items("test_b") + items("test_c") if item.name not in left_out]
        models = {item.callspec.params["model"] for item in kept if item.name.startswith("test_b")}
        cases = frozenset(item.name for item in kept if item.name.startswith("test_c"))
        assert len(models) in (1, 2)
        assert sum(item.name.startswith("test_b") for item in kept) == 3 * len(models)
        assert len(cases) in (3, 4)
        runs.add((frozenset(models), cases))
    assert set.union(*(set(models) for models, _ in runs)) == set(MODELS)
    assert set.union(*(set(cases) for _, cases in runs)) == {item.name for item in items("test_c")}


def test_without_sample_all_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(conftest, "SAMPLED", {"a::test_b": ""})
    monkeypatch.delenv("SAMPLE", raising=False)
    assert list(conftest.left_out(items("test_b"))) == []
