"""Numbers that must not change unless MODEL_VERSION does: a stored result is taken for what it would be today."""

from pathlib import Path
from typing import Any

import pytest

from bearingsim.core import MODEL_VERSION
from bearingsim.simulation.simulate import simulate
from tests.scenes.nf308 import ON_A_ROLLER, ON_INNER_RACE, SLOT, case

SHORT = {"duration": "80 ms", "settle": "30 ms"}
GOLDEN_VERSION = 7  # the MODEL_VERSION whose numbers these are
WIDE = SLOT | {"shape": "circular", "length": "6 mm", "angle": "10 deg"}
GROOVE = SLOT | {"shape": "triangular", "depth": "5 um", "angle": "-20 deg"}
ASIDE = SLOT | {"length": "3 mm", "offset": "3 mm"}
ASKEW = {"misalignment": {"inner": "0.2 mrad"}, "contact": {"slices": 6}}
SPALL = {"shape": "spall", "width": "2 mm", "grown": "60 %", "seed": 2}
SCAN = Path(__file__).parents[2] / "studies" / "scans" / "spall.csv"
KRAEMER = {"stiffness": "iso16281", "damping": {"law": "kraemer", "beta": "10 us"}}
THIRD = {"roller": 3}
RAW = {"load": "300 N", "clearance": "5 um", "antialias": False}
SCENES: dict[str, dict[str, Any]] = {
    "rollers": {"model": "rollers", "defect": SLOT},
    "default damping": {"model": "rollers", "contact": {"damping": "kraemer"}, "defect": SLOT},
    "ring": {"model": "ring", "method": "rk4", "contact": KRAEMER, "defect": WIDE} | RAW,
    "static": {"model": "static", "defect": GROOVE, "clearance": "-2 um"},
    "planar": {"model": "planar", "defect": GROOVE},
    "in space": {"model": "spatial", "defect": ASIDE} | ASKEW,
    "spall": {"model": "rollers", "defect": ASIDE | SPALL},
    "scan": {"model": "rollers", "defect": {"shape": "scan", "file": str(SCAN)}},
    "elastic edge": {"model": "rollers", "defect": SLOT, "excitation": "elastic-edge"},
    "inner race and roller": {"model": "rollers", "defects": [SLOT | ON_INNER_RACE, WIDE | ON_A_ROLLER | THIRD]},
}
"""Where a scene says no damping, chi = 50 s/m acts as ``nf308.case`` has it: not the default."""
SENSITIVE = {"planar": 1e-6, "in space": 1e-6}  # friction that changes sides makes more of a rounding
NUMBERS: dict[str, dict[str, float]] = {
    "rollers": {
        "displacement@BPFO": 9.309604109042904e-09,
        "velocity@BPFO": 9.300513744261641e-06,
        "velocity@BPFO.phase": -1.5604838167682267,
        "velocity@3BPFO": 2.571659715900825e-05,
        "velocity.rms": 0.00033535773109178986,
        "acceleration@BPFO": 0.009291459357839479,
        "acceleration.rms": 7.196502597716886,
        "acceleration.kurtosis": 25.987249359157087,
        "outer_force.max": 440.97206751142,
    },
    "default damping": {
        "displacement@BPFO": 7.5861408027824e-09,
        "velocity@BPFO": 7.57874497513437e-06,
        "velocity@BPFO.phase": -1.530390637283508,
        "velocity@3BPFO": 2.091811564752587e-05,
        "velocity.rms": 0.0004977423061506239,
        "acceleration@BPFO": 0.007571366792865942,
        "acceleration.rms": 12.061688677900511,
        "acceleration.kurtosis": 21.623311070507725,
        "outer_force.max": 228.53569551716316,
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
        "velocity.rms": 0.0002989836897317884,
        "acceleration@BPFO": 0.011535985497179924,
        "acceleration.rms": 4.763839355346772,
        "acceleration.kurtosis": 21.339800201002316,
        "outer_force.max": 210.13943444022414,
    },
    "planar": {
        "velocity@BPFO": 7.92492887499179e-06,
        "velocity@BPFO.phase": 3.047685244397439,
        "velocity@3BPFO": 2.3695486204326064e-05,
        "velocity.rms": 0.00025643208795135677,
        "acceleration.rms": 5.124304412664159,
        "outer_force.max": 164.21996647229273,
        "cage_force.max": 0.0,
    },
    "in space": {
        "velocity@BPFO": 4.445516991339306e-06,
        "velocity@BPFO.phase": -1.5780461699636443,
        "velocity@3BPFO": 9.60017095264279e-06,
        "velocity.rms": 8.940987286758206e-05,
        "acceleration.rms": 1.4901656487584505,
        "outer_force.max": 81.64391637731504,
        "tilt.max": 0.00012093000744663178,
        "line_load.max": 25117.341090889913,
    },
    "spall": {
        "velocity@BPFO": 1.4333383652198593e-06,
        "velocity@BPFO.phase": -1.5665247289006436,
        "velocity@3BPFO": 2.246723884441131e-06,
        "velocity.rms": 1.8202161944708362e-05,
        "acceleration.rms": 0.42458499699243024,
        "outer_force.max": 50.213214858003,
    },
    "scan": {
        "velocity@BPFO": 1.367524597772173e-06,
        "velocity@BPFO.phase": -1.5780587012649125,
        "velocity@3BPFO": 2.7225827740637324e-06,
        "velocity.rms": 0.0001299430365823713,
        "acceleration.rms": 3.083640295814476,
        "outer_force.max": 61.16316726652602,
    },
    "elastic edge": {
        "velocity@BPFO": 9.536087621594428e-06,
        "velocity@BPFO.phase": -1.5618815287786958,
        "velocity@3BPFO": 2.638780731471859e-05,
        "velocity.rms": 0.000330449664766275,
        "acceleration.rms": 7.081658844903452,
        "outer_force.max": 354.766426941608,
    },
    "inner race and roller": {
        "displacement@BPFI": 3.4671215523506314e-09,
        "velocity@BPFI": 5.031536402525795e-06,
        "velocity@BPFI.phase": -1.5786987218888118,
        "velocity@BPFI+fr": 4.871208977858787e-06,
        "velocity@BPFO": 6.70891988692991e-07,
        "velocity.rms": 0.00017666017066861854,
        "acceleration@BPFI-fr": 0.004568777350966563,
        "acceleration.rms": 3.149274560443065,
        "outer_force.max": 92.1822424650798,
        "inner_force.max": 77.40969493715069,
        "load_zone.extent": 3.0991034330104084,
    },
}


@pytest.mark.parametrize("scene", SCENES)
def test_numbers_do_not_change_unless_the_model_version_does(scene):
    features, numbers = simulate(case(**SHORT, **SCENES[scene])).features, NUMBERS[scene]
    found = {name: features[name] for name in numbers}
    assert MODEL_VERSION == GOLDEN_VERSION, f"new model version: set GOLDEN_VERSION and these numbers: {found}"
    if found != pytest.approx(numbers, rel=SENSITIVE.get(scene, 1e-9)):
        pytest.fail(
            "the same case gives other numbers than before. If that was meant, raise MODEL_VERSION in"
            f" bearingsim/core/__init__.py (stored results are then computed anew) and put here: {found}"
        )
