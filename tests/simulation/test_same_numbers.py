"""Reproducibility: the same results in another process and in plain Python."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bearingsim.config import Case
from bearingsim.simulation.simulate import simulate
from tests.scenes.short_cases import FORCES, RING, SLOT, case

ROOT = Path(__file__).parents[2]


def fingerprint(test_case: Case) -> str:
    result = simulate(test_case)
    digest = hashlib.sha256(repr(sorted(result.features.items())).encode())
    for name, series in sorted(result.series.items()):
        digest.update(name.encode() + series.tobytes())
    return digest.hexdigest()


def run_in_new_process(code: str, **environment: str) -> str:
    """Return the output of a new process."""
    env = os.environ | environment | {"PYTHONPATH": str(ROOT)}
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], env=env, capture_output=True, text=True, timeout=240
    )
    assert run.returncode == 0, run.stderr
    return run.stdout.strip()


def test_same_case_gives_identical_results() -> None:
    test_case = case(model="rollers", defect=SLOT, record=RING + FORCES)
    digest = fingerprint(test_case)
    assert fingerprint(test_case) == digest
    fields = "model='rollers', defect=SLOT, record=RING + FORCES"
    code = f"from tests.simulation.test_same_numbers import *; print(fingerprint(case({fields})))"
    assert run_in_new_process(code) == digest
    assert fingerprint(test_case.model_copy(update={"load": test_case.load * (1 + 1e-15)})) != digest


THREE = {  # small and fast, so that plain Python computes two ball passes, which lines of rotating defects require
    "name": "three",
    "rollers": 3,
    "roller_diameter": "12 mm",
    "roller_length": "12 mm",
    "pitch_diameter": "65 mm",
    "bore": "40 mm",
    "outside_diameter": "90 mm",
    "width": "23 mm",
}
FAST = {"bearing": THREE, "speed": "12000 rpm", "settle": "0 ms", "sampling": "1500 Hz", "clearance": "-2 um"} | {
    "step_check": False  # the same code again, which would take most of the time
}


def numbers(**fields: Any) -> list[float]:
    result = simulate(case(**(FAST | {"duration": 2.001 / 244.6} | fields)))
    return [result.features[n] for n in sorted(result.features) if "scatter" not in n and "kurtosis" not in n]


DEFECT_RACES: list[dict[str, Any]] = [{}, {"race": "inner"}, {"race": "roller", "roller": 2}]
DAMPED = {"contact": {"damping": {"chi": 5.0}}}
FIELDS = [DAMPED | {"defect": SLOT | {"width": "3 mm"} | race} for race in DEFECT_RACES]


@pytest.fixture(scope="module")
def plain() -> list[list[float]]:
    """Return the features of each of ``FIELDS``, computed in plain Python by one process."""
    code = "from tests.simulation.test_same_numbers import *; "
    code += "print([[x.hex() for x in numbers(**fields)] for fields in FIELDS])"
    return [[float.fromhex(x) for x in row] for row in eval(run_in_new_process(code, NUMBA_DISABLE_JIT="1"))]


@pytest.mark.parametrize("n", range(len(FIELDS)), ids=["outer race", "inner race", "roller"])
def test_plain_python_gives_the_same_numbers(n: int, plain: list[list[float]]) -> None:
    assert plain[n] == pytest.approx(numbers(**FIELDS[n]), rel=1e-12, nan_ok=True)
    # lines too near each other are nan, two standard errors of a motion that is not chaotic, three of its start
    assert np.isfinite(plain[n]).sum() >= 48
