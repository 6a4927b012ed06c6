"""Numbers that must not change unless MODEL_VERSION does: a stored result is taken for what it would be today."""

import pytest

from bearingsim.core import MODEL_VERSION
from bearingsim.simulation import simulate
from tests.scenes import ON_A_ROLLER, ON_INNER_RACE, SLOT, case

SHORT = {"duration": "80 ms", "settle": "30 ms"}
GOLDEN_VERSION = 3  # the MODEL_VERSION whose numbers these are
WIDE = SLOT | {"shape": "circular", "length": "6 mm", "angle": "10 deg"}
GROOVE = SLOT | {"shape": "triangular", "depth": "5 um", "angle": "-20 deg"}
KRAEMER = {"stiffness": "iso16281", "damping": "kraemer"}
THIRD = {"roller": 3}
RAW = {"load": "300 N", "clearance": "5 um", "antialias": False}
SCENES = {
    "rollers": {"model": "rollers", "defect": SLOT},
    "ring": {"model": "ring", "method": "rk4", "contact": KRAEMER, "defect": WIDE} | RAW,
    "static": {"model": "static", "defect": GROOVE, "clearance": "-2 um"},
    "inner race and roller": {"model": "rollers", "defects": [SLOT | ON_INNER_RACE, WIDE | ON_A_ROLLER | THIRD]},
}
NUMBERS: dict[str, dict[str, float]] = {
    "rollers": {
        "displacement@BPFO": 9.309604109042904e-09,
        "velocity@BPFO": 9.300513744261641e-06,
        "velocity@BPFO.phase": -1.5604838167682267,
        "velocity@3BPFO": 2.571659715900825e-05,
        "velocity.rms": 0.0003348096504203922,
        "acceleration@BPFO": 0.009291459357839479,
        "acceleration.rms": 7.22014353289943,
        "acceleration.kurtosis": 26.2352172576549,
        "outer_force.max": 440.9720675156745,
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
        "displacement@BPFO": 1.1558546362171519e-08,
        "velocity@BPFO": 1.1547227140330827e-05,
        "velocity@BPFO.phase": 2.9669465074717265,
        "velocity@3BPFO": 3.412052224373813e-05,
        "velocity.rms": 0.00030036547551107396,
        "acceleration@BPFO": 0.011535985497179924,
        "acceleration.rms": 4.755007160514761,
        "acceleration.kurtosis": 21.222942961408076,
        "outer_force.max": 210.13943444022414,
    },
    "inner race and roller": {
        "displacement@BPFI": 3.4671215523506314e-09,
        "velocity@BPFI": 5.031536402525795e-06,
        "velocity@BPFI.phase": -1.5786987218953104,
        "velocity@BPFI+fr": 4.871208977858787e-06,
        "velocity@BPFO": 6.70891988692991e-07,
        "velocity.rms": 0.0001765311355997932,
        "acceleration@BPFI-fr": 0.004568777350966563,
        "acceleration.rms": 3.1551903002222472,
        "outer_force.max": 92.1822424650798,
        "inner_force.max": 77.40969493715069,
        "load_zone.extent": 3.0952635389257943,
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
