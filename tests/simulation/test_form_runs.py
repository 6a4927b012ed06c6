"""Simulations with form of the surfaces: what repeats, and steps that resolve its waves."""

import numpy as np
import pytest

from bearingsim.config.names import LINES
from bearingsim.errors import Refused
from bearingsim.simulation.repetition import may_be_periodic
from bearingsim.simulation.settling import mode_eigenvalues
from bearingsim.simulation.simulate import simulate
from bearingsim.simulation.time_grid import requested_step
from tests.scenes.nf308 import SLOT, case

WAVES = {"spectrum": {"amplitude": "0.2 um"}}
UNEQUAL = {"diameter": {"scatter": "0.5 um"}}


@pytest.mark.parametrize(
    ("surfaces", "repeats"),
    [
        ({"outer": WAVES}, True),
        ({"inner": WAVES}, False),
        ({"rollers": UNEQUAL}, False),
        ({"rollers": {"harmonics": [{"order": 2, "amplitude": "20 nm"}]}}, False),
        ({"outer": WAVES, "rollers": UNEQUAL}, False),
    ],
)
def test_only_the_form_of_the_outer_race_repeats_each_ball_pass(surfaces, repeats):
    for model in ("static", "rollers"):
        method = {} if model == "static" else {"method": "verlet"}
        assert may_be_periodic(case(model=model, surfaces=surfaces, **method)) == repeats


def test_a_periodic_response_equals_the_whole_record():
    fields = {
        "surfaces": {"outer": WAVES},
        "defect": SLOT,
        "method": "verlet",
        "duration": "0.2 s",
        "settle": "50 ms",
    }
    short, whole = (simulate(case(periodic=periodic, **fields)) for periodic in (True, False))
    assert float(short.info["passes_computed"]) < 0.5 * float(whole.info["passes_computed"])
    for name in ("velocity@BPFO", "velocity.rms", "acceleration.rms"):
        assert short.features[name] == pytest.approx(whole.features[name], rel=1e-6)


@pytest.mark.parametrize("order", [199, 200])
def test_waves_that_lift_rollers_at_rest_leave_the_modes_as_they_are(order):
    """Order 200 at 600 rpm recedes by 1 mm/s from a roller pressed by 0.2 N: without it no mode is undamped."""
    surfaces = {"outer": {"harmonics": [{"order": order, "amplitude": "0.2 um"}]}}
    fields = {"speed": "600 rpm", "method": "verlet", "contact": {"damping": "kraemer"}, "duration": "0.2 s"}
    wavy, smooth = case(surfaces=surfaces, **fields), case(**fields)
    assert mode_eigenvalues(wavy) == mode_eigenvalues(smooth)
    assert int(simulate(wavy).info["passes_computed"]) < 10


def test_a_step_too_long_for_the_shortest_wave_is_refused():
    """Order 500 of the inner race at 6000 rpm passes a contact in 39 us / 1.5."""
    fast = {"speed": "6000 rpm", "surfaces": {"inner": {"harmonics": [{"order": 500, "amplitude": "5 nm"}]}}}
    wave = 1.0 / (500 * (100.0 - 12.2308 * 100.0 / 30.0))
    with pytest.raises(Refused, match=r"a step of 5 us passes an undulation of 33\.8 us in too few steps"):
        requested_step(case(**fast, step="5 us", method="rk4", contact={"damping": "none"}))
    assert requested_step(case(**fast, method="verlet")) <= wave / 40.0
    assert requested_step(case(**fast, model="static")) <= wave / 40.0
    assert np.isclose(wave, 33.76e-6, rtol=1e-3)


@pytest.mark.parametrize("model", ["ring", "rollers"])
def test_lanes_without_a_roller_carry_nothing(model):
    """The padding after the 13th roller would be pressed by the height of the race at its place."""
    surfaces = {"outer": {"harmonics": [{"order": 1, "amplitude": "5 um"}]}}
    forces = [
        simulate(case(model=name, surfaces=surfaces, duration="50 ms")).features["outer_force.max"]
        for name in (model, "static")
    ]
    assert forces[0] == pytest.approx(forces[1], rel=0.1)


def wave(order, **more):
    """Fields of a surface with one wave of 20 nm."""
    return {"harmonics": [{"order": order, "amplitude": "20 nm"} | more]}


PRELOADED = {
    "rig": {"ring_mass": "1 kg", "bracket_stiffness": "1e6 N/m", "bracket_damping": "100 N s/m"},
    "clearance": "-4 um",
    "duration": "2 s",
    "settle": "0 s",
    "record": [],
    "model": "static",
}
"""Every roller carries nearly the same load. In 2 s the nearest lines, 2BSF and BPFO, are 4 bins apart."""
THICKER = {"diameter": [f"{0.1 * (j == 4)} um" for j in range(13)]}
LINES_OF_FORM = {
    "outer order Z - 1": ({"outer": wave(12)}, {"BPFO": 20e-9}),
    "outer order 2 Z + 1": ({"outer": wave(27)}, {"2BPFO": 20e-9}),
    "inner order Z - 1": ({"inner": wave(12)}, {"BPFI-fr": 20e-9}),
    "inner order Z + 1": ({"inner": wave(14)}, {"BPFI+fr": 20e-9}),
    "inner order 2 Z - 1": ({"inner": wave(25)}, {"2BPFI-fr": 20e-9}),
    "inner order 2 Z + 1": ({"inner": wave(27)}, {"2BPFI+fr": 20e-9}),
    "inner order 3 Z - 1": ({"inner": wave(38)}, {"3BPFI-fr": 20e-9}),
    "inner order 3 Z + 1": ({"inner": wave(40)}, {"3BPFI+fr": 20e-9}),
    "inner order 2 Z": ({"inner": wave(26)}, {}),
    "one roller thicker": ({"rollers": THICKER}, {"FTF": 2.0 / 13.0 * 100e-9}),
    "order 2 of a roller": (
        {"rollers": wave(2, roller=3)},
        {"2BSF-FTF": 2.0 / 13.0 * 20e-9, "2BSF+FTF": 2.0 / 13.0 * 20e-9},
    ),
    "order 3 of a roller": ({"rollers": wave(3, roller=3)}, {}),
}


@pytest.fixture(scope="module")
def smooth():
    """Features of the preloaded bearing without form."""
    return simulate(case(**PRELOADED)).features


@pytest.mark.parametrize("what", LINES_OF_FORM)
def test_form_appears_at_its_lines_by_its_own_amplitude(what, smooth):
    """Equations of docs/form.md, as features of a run; all other lines have under 1 % of a wave."""
    surfaces, expected = LINES_OF_FORM[what]
    features = simulate(case(surfaces=surfaces, **PRELOADED)).features
    for line in LINES:
        name = f"displacement@{line}"
        amplitude = abs(
            features[name] * np.exp(1j * features[f"{name}.phase"])
            - smooth[name] * np.exp(1j * smooth[f"{name}.phase"])
        )
        assert amplitude == pytest.approx(expected.get(line, 0.0), rel=0.01, abs=2e-10), line
