"""Simulations with form of the surfaces: what repeats, and steps that resolve its waves."""

import numpy as np
import pytest

from bearingsim.errors import Refused
from bearingsim.simulation.repetition import may_be_periodic
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


def test_a_step_too_long_for_the_shortest_wave_is_refused():
    """Order 500 of the inner race at 6000 rpm passes a contact in 39 us / 1.5."""
    fast = {"speed": "6000 rpm", "surfaces": {"inner": {"harmonics": [{"order": 500, "amplitude": "5 nm"}]}}}
    wave = 1.0 / (500 * (100.0 - 12.2308 * 100.0 / 30.0))
    with pytest.raises(Refused, match=r"a step of 5 us passes a wave of 33\.8 us in too few steps"):
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
