"""Completion by the shell: names of studies, bearings, figures, features and jobs, without the simulation."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from bearingsim.cli.opening import find_results
from bearingsim.config.names import CHANNELS, FEATURES
from bearingsim.figure_kinds import KINDS
from bearingsim.shipped import shipped_studies
from tests.cli.test_start_up import COMPUTING

CODE = f"""
import sys
from bearingsim.cli import main
sys.argv = ["bearingsim"]
try:
    main()
finally:
    assert not {COMPUTING!r} & set(sys.modules), {COMPUTING!r} & set(sys.modules)
"""


def complete(line: str) -> list[str]:
    """Return bash's completions of the last word of a line."""
    words = line.split(" ")
    variables = {"_BEARINGSIM_COMPLETE": "complete_bash", "COMP_WORDS": line, "COMP_CWORD": str(len(words) - 1)}
    process = subprocess.run(
        [sys.executable, "-c", CODE], env=os.environ | variables, capture_output=True, text=True, check=False
    )
    assert (process.returncode, process.stderr) == (0, "")
    return process.stdout.split()


def test_names_of_the_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert {"new", "plot"} <= {*complete("bearingsim ")}
    assert complete("bearingsim new --from sp") == [name for name in shipped_studies() if name.startswith("sp")]
    assert complete("bearingsim freq nu20") == ["nu204", "nu205", "nu206", "nu209"]
    assert complete("bearingsim plot --kind ") == list(KINDS)
    assert complete("bearingsim plot --y ") == [*FEATURES, *CHANNELS]
    assert complete("bearingsim plot --job ") == []  # no results here


def test_jobs_of_the_results(done: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    jobs = sorted(find_results(done).planned)
    monkeypatch.chdir("/")
    assert sorted(complete(f"bearingsim plot {done} --job ")) == jobs
    monkeypatch.chdir(done.parents[1])
    assert complete(f"bearingsim export --series {jobs[0][:6]}") == jobs[:1]


@pytest.mark.parametrize("plan", ["", "[]", '{"jobs": [1]}', '{"jobs": [{"job": "\\u001b[2J$(id)"}]}'])
def test_damaged_results_complete_nothing(tmp_path: Path, plan: str) -> None:
    (tmp_path / "plan.json").write_text(plan)
    assert complete(f"bearingsim plot {tmp_path} --job ") == []
