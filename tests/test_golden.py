"""Numbers that must not change unless MODEL_VERSION does: a stored result is taken for what it would be today."""

import pytest

from bearingsim.core import MODEL_VERSION
from bearingsim.simulation import simulate
from tests.scenes import SLOT, case

SHORT = {"duration": "80 ms", "settle": "30 ms"}
GOLDEN_VERSION = 1  # the MODEL_VERSION whose numbers these are
WIDE = SLOT | {"shape": "circular", "length": "6 mm", "angle": "10 deg"}
GROOVE = SLOT | {"shape": "triangular", "depth": "5 um", "angle": "-20 deg"}
KRAEMER = {"stiffness": "iso16281", "damping": "kraemer"}
RAW = {"load": "300 N", "clearance": "5 um", "antialias": False}
SCENES = {
    "rollers": {"model": "rollers", "defect": SLOT},
    "ring": {"model": "ring", "method": "rk4", "contact": KRAEMER, "defect": WIDE} | RAW,
    "static": {"model": "static", "defect": GROOVE, "clearance": "-2 um"},
}
NUMBERS: dict[str, dict[str, float]] = {
    "rollers": {
        "displacement@BPFO": 9.309398450150237e-09,
        "velocity@BPFO": 9.300310007870368e-06,
        "velocity@BPFO.phase": -1.5604780393802602,
        "velocity@3BPFO": 2.571601288225044e-05,
        "velocity.rms": 0.00033481255025485387,
        "acceleration@BPFO": 0.00929125581979295,
        "acceleration.rms": 7.220796652885084,
        "acceleration.kurtosis": 26.23639707635902,
        "outer_force.max": 438.0892377459682,
    },
    "ring": {
        "displacement@BPFO": 2.8423527322697932e-08,
        "velocity@BPFO": 2.839576464606269e-05,
        "velocity@BPFO.phase": 1.7198104067209352,
        "velocity@3BPFO": 2.4838436418211917e-05,
        "velocity.rms": 0.00025562927275852985,
        "acceleration@BPFO": 0.028368120342433044,
        "acceleration.rms": 6.808999437737418,
        "acceleration.kurtosis": 28.85069163451923,
        "outer_force.max": 152.22082791610862,
    },
    "static": {
        "displacement@BPFO": 1.1557369306008692e-08,
        "velocity@BPFO": 1.1543832913591036e-05,
        "velocity@BPFO.phase": 2.9669715546049025,
        "velocity@3BPFO": 3.411143459058052e-05,
        "velocity.rms": 0.00030059189752603153,
        "acceleration@BPFO": 0.011532594574842596,
        "acceleration.rms": 4.7553915670680125,
        "acceleration.kurtosis": 21.34561103715766,
        "outer_force.max": 210.13994886058262,
    },
}


@pytest.mark.parametrize("scene", SCENES)
def test_numbers_do_not_change_unless_the_model_version_does(scene):
    features, numbers = simulate(case(**SHORT, **SCENES[scene])).features, NUMBERS[scene]
    found = {name: features[name] for name in numbers}
    assert MODEL_VERSION == GOLDEN_VERSION, f"new model version: set GOLDEN_VERSION and these numbers: {found}"
    if found != pytest.approx(numbers, rel=1e-9):
        pytest.fail(
            "the same case gives other numbers than before. If that was meant, raise MODEL_VERSION in"
            f" bearingsim/core/__init__.py (stored results are then computed anew) and put here: {found}"
        )
