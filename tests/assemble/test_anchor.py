"""Anchor of the bracket with form of the surfaces: on average the rollers carry the load."""

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.assemble import rest
from bearingsim.assemble.anchor import bracket_anchor
from bearingsim.core import layout as lay
from bearingsim.core.models.equilibrium import solve_equilibrium, solve_initial_equilibrium
from bearingsim.simulation.simulate import simulate
from tests.independent import formed_rollers
from tests.independent.formed_rollers import INNER, OUTER, Scene
from tests.independent.rollers import K_B, OMEGA_C, Z
from tests.scenes.nf308 import SLOT, case

TURN = 2 * np.pi / OMEGA_C  # s


def waves_of_order(order, phase, amplitude="5 um"):
    """Fields of a race with waves of one order; phase: deg."""
    return {"harmonics": [{"order": order, "amplitude": amplitude, "phase": f"{phase} deg"}]}


@pytest.mark.parametrize("phase", [0, 70, 180])
def test_a_shifted_race_leaves_the_rollers_with_the_load(phase):
    """Within 0.5 %, by the forces of an independent solution: order 1 of 5 um shifts the outer race.

    Anchored for the smooth bearing, the rollers would carry 101 to 199 of 150 N.
    """
    anchor = complex(*bracket_anchor(case(model="static", surfaces={"outer": waves_of_order(1, phase)})))
    waves = np.array([[OUTER, 1, 5e-6, np.radians(phase), -1]])
    forces = []
    for t in np.arange(40) / 40 * TURN / Z:
        u, _ = formed_rollers.at_rest(Scene(0.0, 150.0, waves), t, K_B, anchor, guess=1e6 * anchor.real)
        forces.append(150.0 + K_B * (u - anchor))
    assert np.mean(forces).real == pytest.approx(150.0, rel=5e-3)
    assert abs(np.mean(forces).imag) < 0.005 * 150.0
    smooth = complex(*bracket_anchor(case(model="static")))
    assert abs(anchor - smooth) == pytest.approx(5e-6, rel=1e-3)


def test_the_mean_is_over_the_turns_of_shaft_and_cage():
    """An inner race of order 1, and one roller 3 um thicker: the mean roller load over 400 turns of the cage."""
    diameter = ["3 um", *["0 um"] * (Z - 1)]
    surfaces = {"inner": waves_of_order(1, 0), "rollers": {"diameter": diameter}}
    model = assemble.model(case(model="static", surfaces=surfaces))
    y, carried = assemble.empty_buffer(model), []
    for k, t in enumerate(np.arange(400) * (1 + 1 / 400) * TURN):
        (solve_initial_equilibrium if k == 0 else solve_equilibrium)(model, float(t), y)
        cosines = y[lay.COS : lay.COS + Z] + 1j * y[lay.SIN : lay.SIN + Z]
        carried.append(y[lay.Q_O : lay.Q_O + Z] @ cosines)
    assert np.std(carried) > 10.0
    assert np.mean(carried) == pytest.approx(150.0, rel=5e-3)


@pytest.mark.parametrize("model", ["static", "rollers"])
def test_thinner_rollers_equal_a_clearance(model):
    """All diameters 2 um below the nominal one, and 4 um of diametral clearance; 1e-3 (races 1 um apart)."""
    thin, loose = (
        simulate(case(model=model, defect=SLOT, duration="0.1 s", **fields)).features
        for fields in ({"surfaces": {"rollers": {"diameter": ["-2 um"] * Z}}}, {"clearance": "4 um"})
    )
    for name in ("velocity@BPFO", "velocity.rms", "outer_force.max"):
        assert thin[name] == pytest.approx(loose[name], rel=1e-3)


def test_the_largest_load_knows_the_mean_diameter_only():
    loads = [
        rest.largest_load(case(**fields))
        for fields in (
            {"surfaces": {"rollers": {"diameter": ["-2 um"] * Z}}},
            {"clearance": "4 um"},
            {"surfaces": {"outer": waves_of_order(2, 0)}},
            {},
        )
    ]
    assert loads[0] == pytest.approx(loads[1], rel=1e-4)
    assert loads[2] == loads[3] < 0.9 * loads[1]


def test_the_anchor_is_where_an_independent_mean_is():
    """With waves of both races, within 1 % of what they move it and their own spread over 300 angles."""
    waves = np.array([[OUTER, 2, 2e-6, 0.4, -1], [INNER, 3, 1e-6, 0.0, -1]])
    surfaces = {
        "outer": {"harmonics": [{"order": 2, "amplitude": "2 um", "phase": "0.4 rad"}]},
        "inner": waves_of_order(3, 0, "1 um"),
    }
    formed, smooth = (complex(*bracket_anchor(case(model="static", **f))) for f in ({"surfaces": surfaces}, {}))
    scene = formed_rollers.with_contact_average(Scene(0.0, 150.0, waves), rest.largest_load(case()))
    assert abs(formed - smooth) > 1e-7
    assert formed == pytest.approx(formed_rollers.anchor_of(scene), abs=0.01 * abs(formed - smooth))
