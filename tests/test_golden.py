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
        "displacement@BPFO": 9.309398450150234e-09,
        "velocity@BPFO": 9.300310007870278e-06,
        "velocity@BPFO.phase": -1.5604780393802717,
        "velocity@3BPFO": 2.5716012882250394e-05,
        "velocity.rms": 0.0003348125502548538,
        "acceleration@BPFO": 0.009291255819792857,
        "acceleration.rms": 7.220796652885084,
        "acceleration.kurtosis": 26.236397076358987,
        "outer_force.max": 438.0892377459682,
    },
    "ring": {
        "displacement@BPFO": 2.842352732269797e-08,
        "velocity@BPFO": 2.8395764646062795e-05,
        "velocity@BPFO.phase": 1.7198104067209485,
        "velocity@3BPFO": 2.4838436418212314e-05,
        "velocity.rms": 0.0002556292727585304,
        "acceleration@BPFO": 0.028368120342433325,
        "acceleration.rms": 6.808999437737364,
        "acceleration.kurtosis": 28.85069163451893,
        "outer_force.max": 152.22082791610856,
    },
    "static": {
        "displacement@BPFO": 1.155736930636317e-08,
        "velocity@BPFO": 1.1546060824922787e-05,
        "velocity@BPFO.phase": 2.9669875678158104,
        "velocity@3BPFO": 3.411712466187558e-05,
        "velocity.rms": 0.000300373905099086,
        "acceleration@BPFO": 0.011534820317222106,
        "acceleration.rms": 4.754916941556513,
        "acceleration.kurtosis": 21.291456472289607,
        "outer_force.max": 210.1399488617282,
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
