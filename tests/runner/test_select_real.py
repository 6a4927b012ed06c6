"""Models chosen by the real engine: choices and results do not depend on interruptions and processes.

CPU times in `info`, the unit of a job, provenance and journals are not compared.
"""

import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from bearingsim import selection, store
from bearingsim.runner import RunSummary, run, with_models
from bearingsim.runner.work import Engine
from bearingsim.store.table import job_frame
from bearingsim.study import Study, load_study

ROOT = Path(__file__).parents[2]
TEXT = """\
study: real
bearing: nf308
rig: bvt5
speed: 1800 rpm
load: 150 N
defect: {race: inner, shape: rectangular, length: 12 mm, width: 0.4 mm, depth: 50 um}
duration: 0.25 s
settle: 50 ms
friction: none
record: [ring.velocity]
accuracy: {within: 30 %, of: [velocity.rms, velocity@BPFI-healthy]}
sweep:
  defect.race: [outer, inner]
  defect.width: [0.2 mm, 0.8 mm]
  clearance: [0 um, 10 um]
figures:
  - {y: [velocity.rms, velocity@BPFI-healthy], x: defect.width, by: [clearance, defect.race]}
"""
"""Study whose motion is periodic for a defect in the outer race, and uses two models for the inner race."""
ENGINE = Engine(compiling="tests.scenes.trials:compiling")
"""Engine with a compilation cost of zero, because otherwise no other model would pay for eight short cases."""
TIMES = ["info/cpu_s", "info/integrator_cpu_s", "unit", "stamp"]

KILLED_RUN = """\
import os, signal, sys
from bearingsim import simulation
from bearingsim.runner import run
from bearingsim.runner.work import Engine
from bearingsim.study import load_study

study, out, what, left = sys.argv[1], sys.argv[2], sys.argv[3], [int(sys.argv[4])]
plain = getattr(simulation, what)

def dying(*of):
    left[0] -= 1
    if left[0] < 0:
        os.kill(os.getpid(), signal.SIGKILL)
    return plain(*of)

setattr(simulation, what, dying)
free = Engine(compiling="tests.scenes.trials:compiling")
run(load_study(study), out, jobs=1, progress=False, engine=free)
"""


def load_real(folder: Path) -> Study:
    path = folder / "real.yaml"
    path.write_text(TEXT)
    return load_study(path)


def compute(folder: Path, out: Path, **options: Any) -> RunSummary:
    defaults: dict[str, Any] = {"jobs": 1, "progress": False, "engine": ENGINE}
    return run(load_real(folder), out, **defaults | options)


@pytest.fixture(scope="module")
def complete(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Compute the study without interruption in one process."""
    folder = tmp_path_factory.mktemp("whole")
    assert compute(folder, folder / "out").failed == 0
    return folder / "out"


def run_and_kill(folder: Path, out: Path, function: str, count: int) -> None:
    """Run the study, and kill the process after ``count`` calls of ``function``."""
    load_real(folder)
    arguments = [sys.executable, "-c", KILLED_RUN, str(folder / "real.yaml"), str(out), function, str(count)]
    assert subprocess.run(arguments, cwd=ROOT, check=False).returncode == -signal.SIGKILL


def assert_equal(first_path: Path, second_path: Path) -> None:
    """Compare the choices byte by byte, the order of the jobs, and their series, features and parameters."""
    assert (first_path / "choices.json").read_bytes() == (second_path / "choices.json").read_bytes()
    first, second = store.open_results(first_path), store.open_results(second_path)
    assert first.plan["accuracy"] == second.plan["accuracy"]
    assert first.jobs == second.jobs
    first_frame, second_frame = (job_frame(path).drop(columns=TIMES) for path in (first_path, second_path))
    assert (first_frame["status"] == "done").all()
    pd.testing.assert_frame_equal(first_frame, second_frame, check_exact=True)
    for job in first.jobs:
        first_series, second_series = first.series(job), second.series(job)
        assert first_series.channels.keys() == second_series.channels.keys()
        assert np.array_equal(first_series.time, second_series.time)
        assert all(np.array_equal(first_series[name], second_series[name]) for name in first_series.channels)
    assert not [path for path in second_path.rglob("*") if path.suffix in (".part", ".started", ".damaged")]


def test_each_case_has_its_model(complete: Path) -> None:
    """Otherwise the other tests would compare little."""
    choices = store.read_choices(complete).values()
    assert Counter(choice.candidate for choice in choices) == {"reference": 4, "rollers": 2, "ring": 2}


def test_two_workers_compute_the_same_results(complete: Path, tmp_path: Path) -> None:
    compute(tmp_path, tmp_path / "out", jobs=2)
    assert_equal(complete, tmp_path / "out")


def test_pilots_and_shards_compute_the_same_results(complete: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    with_models(load_real(tmp_path), out, 1, run_trials=True, engine=ENGINE)
    assert (out / "choices.json").read_bytes() == (complete / "choices.json").read_bytes()
    for number in (3, 1, 2):
        compute(tmp_path, out, shard=(number, 3))
    assert_equal(complete, out)


def test_run_killed_during_trials_computes_the_same_results(complete: Path, tmp_path: Path) -> None:
    """The run is killed at an early and at a later trial."""
    out = tmp_path / "out"
    for count in (3, 9):
        run_and_kill(tmp_path, out, "run_trial", count)
        assert not (out / "choices.json").exists()
        assert selection.read_trials(out)
    compute(tmp_path, out)
    assert_equal(complete, out)


def test_run_killed_during_jobs_computes_the_same_results(complete: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    for count in (2, 4):
        run_and_kill(tmp_path, out, "simulate", count)
        assert (out / "choices.json").read_bytes() == (complete / "choices.json").read_bytes()
        assert not (job_frame(out)["status"] == "done").all()
    compute(tmp_path, out)
    assert_equal(complete, out)


def test_killed_run_with_two_workers_computes_the_same_results(complete: Path, tmp_path: Path) -> None:
    """The parent is killed after the first trials, and again after the plan has been written."""
    out = tmp_path / "out"
    path = load_real(tmp_path).path
    code = "from bearingsim.runner import run; from bearingsim.study import load_study; import sys"
    code += "; from bearingsim.runner.work import Engine\n"
    code += f"run(load_study(sys.argv[1]), sys.argv[2], jobs=2, progress=False, engine={ENGINE!r})"
    conditions: list[Callable[[], bool]] = [
        lambda: len(selection.read_trials(out)) > 3,
        lambda: (out / "plan.json").exists(),
    ]
    for has_begun in conditions:
        process = subprocess.Popen([sys.executable, "-c", code, path, str(out)], cwd=ROOT)
        end = time.monotonic() + 120.0
        while not has_begun() and process.poll() is None:
            assert time.monotonic() < end
            time.sleep(0.02)
        process.kill()
        assert process.wait() == -signal.SIGKILL
    compute(tmp_path, out, jobs=2)
    assert_equal(complete, out)
