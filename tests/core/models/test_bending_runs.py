"""Flexible outer ring at rest and in motion: against independent solutions, the rigid limit, and other methods."""

from math import pi

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.assemble import bending
from bearingsim.core import layout as lay
from bearingsim.core.models.equilibrium import solve_initial_equilibrium
from bearingsim.core.models.interface import state_width
from bearingsim.core.parameters import lanes
from bearingsim.core.parts import bending as core
from bearingsim.simulation import simulate
from tests.independent import bent_static
from tests.independent import rollers as nf308
from tests.scenes.bent_ring import HOUSING, PADS, POINTS, case, line, slot_contribution


@pytest.mark.parametrize(
    ("load", "reference_load", "expected"),
    [
        (None, bent_static.POINT, 93.58),
        (PADS, bent_static.soft_pads(-45, 45), 4.585),
        ({"by": "pads", "angles": ["-60 deg", "0 deg", "60 deg"]}, bent_static.soft_pads(-60, 0, 60), 40.88),
    ],
)
def test_static_lines_equal_the_independent_solution(load, reference_load, expected):
    """Change of the amplitude at BPFO from healthy (um/s), with 30 harmonics, within 1 %."""
    assert slot_contribution(30, load, model="static", contact=None) == pytest.approx(expected, rel=1e-2)


@pytest.mark.parametrize("load", [None, PADS, HOUSING])
def test_the_static_path_equals_the_independent_solution(load):
    """Sensor displacement at five cage angles, to 1e-6 of its range; residual forces up to 1e-8 of the load."""
    reference_load = {None: bent_static.POINT, str(PADS): bent_static.soft_pads(-45, 45)}.get(
        load and str(load), bent_static.seat(1e10, pieces=64)
    )
    model = assemble.static_model(assemble.model(case(8, load, model="static", contact=None)))
    scene = bent_static.Scene(last=8, outside=reference_load)
    angles = pi / nf308.Z + bent_static.PASS * np.array([0.0, 0.2, 0.49, 0.53, 0.8])
    reference = bent_static.static_path(scene, angles, bent_static.anchor_position(scene))
    y, readings = assemble.empty_buffer(model), []
    for angle in angles:
        residual = solve_initial_equilibrium(model, (angle - model.bearing.theta_0) / model.bearing.omega_c, y)
        assert residual <= 1e-8 * 150.0
        core.read_sensor(model.bending, y)
        readings.append(y[lay.SENSOR])
    assert readings == pytest.approx(list(reference.reading), abs=1e-6 * np.ptp(reference.reading))


@pytest.mark.parametrize("harmonics", [8, 19, 40])
@pytest.mark.parametrize("load", [None, PADS, POINTS, HOUSING])
def test_a_run_starts_with_ring_and_carrier_at_rest(load, harmonics):
    """Without damping no body accelerates; a shifted carrier or a missing harmonic gives over 10 m/s^2."""
    undamped = case(harmonics, load, contact={"damping": "none"})
    model = assemble.model(undamped)
    y, residual = assemble.start(undamped, model)
    assert residual <= 1e-8 * 150.0
    n = lay.MODES_S + model.bending.harmonic_table.shape[1]
    assert np.abs(y[lay.ACCELERATION : lay.ACCELERATION + n]).max() < 1e-5


def test_two_springs_act_as_two_pads():
    """To 1e-6, at 1e8 N/m each, without bracket: by symmetry each spring carries the same share of the load."""
    rig = {"bracket_stiffness": "0 N/m", "bracket_damping": "0 N s/m"}
    features = [simulate(case(8, load, model="static", rig=rig, contact=None)).features for load in (PADS, POINTS)]
    for name in ("velocity@BPFO", "velocity.rms", "outer_force.max"):
        assert features[0][name] == pytest.approx(features[1][name], rel=1e-6)


@pytest.mark.parametrize("load", [None, PADS])
def test_a_ring_of_ten_thousand_times_the_modulus_is_rigid(load):
    """Line and RMS of `static` agree with a rigid ring to 2e-3, and to 2e-4 at ten times this modulus."""
    rigid = simulate(case(0, model="static", contact=None)).features
    for modulus, tolerance in ((207e13, 2e-3), (207e14, 2e-4)):
        material = case().bearing.material.model_copy(update={"young_modulus": modulus})
        bearing = case().bearing.model_copy(update={"material": material})
        flexible = simulate(case(8, load, model="static", bearing=bearing, contact=None)).features
        for name in ("velocity@BPFO", "velocity.rms"):
            assert flexible[name] == pytest.approx(rigid[name], rel=tolerance)


@pytest.mark.slow
def test_lines_under_a_point_load_equal_the_independent_solution():
    """With 8 harmonics, within 1 %: 94.05 and 11.70 um/s in tests/independent/test_bent_rollers.py."""
    assert slot_contribution(8) == pytest.approx(94.05, rel=1e-2)
    assert abs(line(case(8, defect=None))) == pytest.approx(11.70, rel=1e-2)


@pytest.mark.slow
def test_rollers_at_low_speed_agree_with_static():
    """At 1 % of the speed the amplitude of displacement at BPFO is within 1 % of that of `static`."""
    fields = {"speed": "18 rpm", "duration": "1.3 s", "settle": "0.7 s", "sampling": "1 kHz"}
    features = [simulate(case(8, model=model, contact=None, **fields)).features for model in ("static", "rollers")]
    assert features[1]["displacement@BPFO"] == pytest.approx(features[0]["displacement@BPFO"], rel=1e-2)


def test_all_methods_agree_on_a_flexible_ring():
    """Line and RMS over 20 ms by Verlet and Runge-Kutta are within 0.5 % of those by `dop853`."""
    base = {"defect": None, "duration": "20 ms", "settle": "5 ms", "step_check": False, "periodic": False}
    results = {method: simulate(case(8, method=method, **base)).features for method in ("verlet", "rk4", "dop853")}
    for name in ("velocity@BPFO", "velocity.rms"):
        for method, features in results.items():
            assert features[name] == pytest.approx(results["dop853"][name], rel=5e-3), method


def test_halving_the_step_changes_the_rms_within_its_error():
    """For a flexible ring in a housing, by Verlet at the automatic step."""
    bearing_case = case(8, HOUSING | {"stiffness": "1e11 N/m/m"}, defect=None, method="verlet")
    result = simulate(bearing_case)
    step = 0.5 * float(result.info["step_s"])
    fine_result = simulate(bearing_case.model_copy(update={"step": step, "step_check": False}))
    change = abs(fine_result.features["velocity.rms"] / result.features["velocity.rms"] - 1.0)
    assert change <= result.features["step_error.rms"]


def test_results_hardly_depend_on_the_number_of_springs(monkeypatch):
    """Line and RMS of `static` change by less than 0.5 %: from 64 to 160 springs, with a gap from 320 to 160."""
    for fit, name, count in (("0 um", "MIN_SPRINGS", 160), ("-15 um", "MIN_SPRINGS_WITH_GAP", 160)):
        housing = {"fit": fit, "stiffness": "1e10 N/m/m"}
        bearing_case = case(20, HOUSING | housing, model="static", contact=None)
        features = simulate(bearing_case).features
        monkeypatch.setattr(bending, name, count)
        bending.build_bending.cache_clear()
        assemble._build_model.cache_clear()
        fine_features = simulate(bearing_case).features
        monkeypatch.undo()
        bending.build_bending.cache_clear()
        assemble._build_model.cache_clear()
        for feature in ("velocity@BPFO", "velocity.rms"):
            assert fine_features[feature] == pytest.approx(features[feature], rel=5e-3)


def test_a_rigid_ring_has_no_harmonics():
    """The state contains only the ring and the rollers."""
    model = assemble.model(case(0))
    assert isinstance(model.bending, core.RigidRing)
    assert core.harmonics(model.bending) == 0
    assert state_width(model) == lay.FIRST_LANE + lanes(model.bearing)
