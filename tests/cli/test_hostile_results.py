"""Malicious results folders: commands that read one stay inside, within bounds, and print no control characters.

The digests of an attack are valid, so that nothing in the folder counts as damaged.
"""

import json
import multiprocessing
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.scenes import hostile_results
from tests.scenes.hostile_results import ATTACKS, SECRET, make, run_attack

MAX_MEMORY = 500e6
TIMEOUT_S = 120.0

Forked = Callable[..., None]


@pytest.fixture(scope="module")
def forked() -> Forked:
    """Return a function that runs another in a process that has already imported the program."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([hostile_results.__name__])

    def run(function: Callable[..., None], *arguments: Any) -> None:
        process = context.Process(target=function, args=arguments)
        process.start()
        process.join(TIMEOUT_S)
        if process.is_alive():
            process.kill()
            pytest.fail("it hangs")
        assert process.exitcode == 0

    return run


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory, forked: Forked) -> Path:
    work = tmp_path_factory.mktemp("hostile") / "work"
    forked(make, work)
    return work


def outside_files(work: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (work / "outside").iterdir() if path.name != "unit.h5"}


@pytest.mark.parametrize("name", ATTACKS)
def test_hostile_results_stay_within_folder_and_limits(
    name: str, results: Path, forked: Forked, tmp_path: Path
) -> None:
    work = tmp_path / "work"
    shutil.copytree(results, work)
    before = outside_files(work)
    forked(run_attack, name, work)
    observed = json.loads((work / "seen.json").read_text())
    for entry in observed["seen"]:
        assert entry["error"] == repr(""), entry
        assert entry["code"] in (0, 1, 2), entry
        for text in (entry["out"], entry["err"]):
            assert text.replace("\n", "").isprintable(), entry
            assert str(SECRET)[:5] not in text, entry
            assert "rm -rf" not in text, entry
            assert "Traceback" not in text, entry
    assert observed["opened"] == []
    assert outside_files(work) == before
    assert observed["memory"] < MAX_MEMORY
    written_files = [path for path in work.glob("*.csv") if path.name != "scan.csv"]
    for path in (*written_files, *(path for path in (work / "merged").rglob("*") if path.is_file())):
        content = path.read_bytes()
        assert str(SECRET)[:5].encode() not in content, path
        assert np.float32(SECRET).tobytes() not in content, path
        if path.suffix == ".csv":
            assert b"\n=" not in content, path
            assert b",=" not in content, path
            assert b'"=' not in content, path
