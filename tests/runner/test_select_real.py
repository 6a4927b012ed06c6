"""Models chosen by the real engine: what is chosen and stored does not depend on how the work went on.

What differs by nature is left out: CPU times in `info`, the unit that a job lies in, provenance, journals.
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
"""A motion with a defect in the outer race repeats itself; with one in the inner race two models are taken."""
ENGINE = Engine(compiling="tests.scenes.trials:compiling")
"""The engine, whose compiling costs nothing: for eight short cases no model would be worth it."""
TIMES = ["info/cpu_s", "info/integrator_cpu_s", "unit", "stamp"]

DIES = """\
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


def study(folder: Path) -> Study:
    path = folder / "real.yaml"
    path.write_text(TEXT)
    return load_study(path)


def compute(folder: Path, out: Path, **options: Any) -> RunSummary:
    given: dict[str, Any] = {"jobs": 1, "progress": False, "engine": ENGINE}
    return run(study(folder), out, **given | options)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The study, computed in one go in one process."""
    folder = tmp_path_factory.mktemp("whole")
    assert compute(folder, folder / "out").failed == 0
    return folder / "out"


def killed(folder: Path, out: Path, what: str, lasts: int) -> None:
    """A run that dies at such a call, after so many that go well."""
    study(folder)
    words = [sys.executable, "-c", DIES, str(folder / "real.yaml"), str(out), what, str(lasts)]
    assert subprocess.run(words, cwd=ROOT, check=False).returncode == -signal.SIGKILL


def assert_same(one: Path, other: Path) -> None:
    """Choices, byte for byte; jobs in their order; series, features, parameters, what else is known of each."""
    assert (one / "choices.json").read_bytes() == (other / "choices.json").read_bytes()
    first, second = store.open_results(one), store.open_results(other)
    assert first.plan["accuracy"] == second.plan["accuracy"]
    assert first.jobs == second.jobs
    left, right = (job_frame(path).drop(columns=TIMES) for path in (one, other))
    assert (left["status"] == "done").all()
    pd.testing.assert_frame_equal(left, right, check_exact=True)
    for job in first.jobs:
        a, b = first.series(job), second.series(job)
        assert a.channels.keys() == b.channels.keys()
        assert np.array_equal(a.time, b.time)
        assert all(np.array_equal(a[name], b[name]) for name in a.channels)
    assert not [path for path in other.rglob("*") if path.suffix in (".part", ".started", ".damaged")]


def test_each_case_takes_what_holds_for_it(whole: Path) -> None:
    """Else the other tests would compare little."""
    choices = store.read_choices(whole).values()
    assert Counter(one.candidate for one in choices) == {"reference": 4, "rollers": 2, "ring": 2}


def test_two_workers_come_to_the_same(whole: Path, tmp_path: Path) -> None:
    compute(tmp_path, tmp_path / "out", jobs=2)
    assert_same(whole, tmp_path / "out")


def test_pilots_and_shards_come_to_the_same(whole: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    with_models(study(tmp_path), out, 1, run_trials=True, engine=ENGINE)
    assert (out / "choices.json").read_bytes() == (whole / "choices.json").read_bytes()
    for number in (3, 1, 2):
        compute(tmp_path, out, shard=(number, 3))
    assert_same(whole, out)


def test_a_run_killed_while_models_are_tried_comes_to_the_same(whole: Path, tmp_path: Path) -> None:
    """By its first trials, then by further ones."""
    out = tmp_path / "out"
    for lasts in (3, 9):
        killed(tmp_path, out, "try_out", lasts)
        assert not (out / "choices.json").exists()
        assert selection.read_trials(out)
    compute(tmp_path, out)
    assert_same(whole, out)


def test_a_run_killed_while_jobs_are_computed_comes_to_the_same(whole: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    for lasts in (2, 4):
        killed(tmp_path, out, "simulate", lasts)
        assert (out / "choices.json").read_bytes() == (whole / "choices.json").read_bytes()
        assert not (job_frame(out)["status"] == "done").all()
    compute(tmp_path, out)
    assert_same(whole, out)


def test_two_workers_that_are_killed_come_to_the_same(whole: Path, tmp_path: Path) -> None:
    """The process that leads them is killed as trials appear, and again as units do."""
    out = tmp_path / "out"
    path = study(tmp_path).path
    code = "from bearingsim.runner import run; from bearingsim.study import load_study; import sys"
    code += "; from bearingsim.runner.work import Engine\n"
    code += f"run(load_study(sys.argv[1]), sys.argv[2], jobs=2, progress=False, engine={ENGINE!r})"
    moments: list[Callable[[], bool]] = [
        lambda: len(selection.read_trials(out)) > 3,
        lambda: (out / "plan.json").exists(),
    ]
    for moment in moments:
        process = subprocess.Popen([sys.executable, "-c", code, path, str(out)], cwd=ROOT)
        end = time.monotonic() + 120.0
        while not moment() and process.poll() is None:
            assert time.monotonic() < end
            time.sleep(0.02)
        process.kill()
        assert process.wait() == -signal.SIGKILL
    compute(tmp_path, out, jobs=2)
    assert_same(whole, out)
