"""Features, step limits and ids of cases with a free cage or a shaft."""

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import start_at_rest
from bearingsim.simulation import choice
from bearingsim.simulation.simulate import simulate
from bearingsim.study.used import relevant_fields
from tests.scenes.nf308 import SLOT, case

SHAFT = {
    "shaft": {"stiffness": "1e7 N/m", "mass": "2 kg", "damping": "2000 N s/m"},
    "unbalance": {"mass_radius": "3e-4 kg m"},
}
IDLE = {
    "cage": {"guide": "rollers"},
    "drag": {"oil_viscosity": "1e-9 Pa s", "oil_density": "1e-6 kg/m^3"},
    "rig": {"torsion_stiffness": "1e5 N m/rad", "torsion_damping": "2 N m s/rad"},
}
"""Parts with a negligible effect, so that the model has the types of another one, which is compiled anyway."""


def test_an_unbalance_leaks_little_into_the_ball_pass_line():
    """The ring moves by 100 um/s at the shaft frequency and not at BPFO; leakage is under 1e-3."""
    settings = {
        "model": "planar",
        "method": "verlet",
        "duration": "0.2 s",
        "settle": "0.1 s",
        "clearance": "-10 um",
    }
    result = simulate(case(**settings, **SHAFT, **IDLE)).features
    assert result["velocity@fr"] == pytest.approx(100.5e-6, rel=0.01)
    assert result["velocity@BPFO"] < 1e-3 * result["velocity@fr"]


def test_lines_of_a_slipping_cage_are_not_aliased():
    """Read at the samples of a kinematic pass the line was 9.8 um/s; with fine samples and a window 20.5."""
    settings = {"speed": "6000 rpm", "load": "5 N", "drag": {}, "rig": {"bracket_stiffness": "1e5 N/m"}}
    result = simulate(case(model="planar", defect=SLOT, settle="0.3 s", duration="0.2 s", **settings)).features
    assert result["cage.slip.mean"] == pytest.approx(0.49, abs=0.03)
    assert result["velocity@BPFO"] == pytest.approx(20.5e-6, rel=0.1)


def test_initial_cage_angle_includes_slip():
    """Its change between two starts of the record equals the integral of the recorded cage speed."""
    settings = {"speed": "6000 rpm", "load": "5 N", "drag": {}, "rig": {"bracket_stiffness": "1e5 N/m"}}
    settings |= {"model": "planar", "duration": "40 ms", "record": ["cage.speed"]}
    early, late = (simulate(case(settle=settle, **settings)) for settle in ("20 ms", "50 ms"))
    speed = early.series["cage.speed"]
    angles = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(early.time))])
    result = float(late.info["cage_angle_start_rad"]) - float(early.info["cage_angle_start_rad"])
    assert result == pytest.approx(np.interp(0.03, early.time, angles), abs=2e-4)
    assert result < 7.0  # and not 7.7, as without slip


def test_acceleration_line_on_a_ramp_is_that_of_the_acceleration():
    """An unbalance from 600 to 3000 rpm: the line at fr, compared with the windowed acceleration."""
    ramp = {"speed": "600 rpm", "ramp": {"to": "3000 rpm", "time": "0.4 s"}, "settle": "0 s", "duration": "0.4 s"}
    record = simulate(case(model="planar", record=["ring.acceleration"], sampling="20 kHz", **ramp, **SHAFT))
    t = record.time
    angle = 2 * np.pi * (10.0 * t + 0.5 * (40.0 / 0.4) * t * t)
    window = np.sin(np.pi * angle / angle[-1]) ** 2 * np.gradient(angle)
    direct = 2.0 * abs(np.sum(window * record.acceleration[:, 0] * np.exp(-1j * angle)) / window.sum())
    assert record.features["acceleration@fr"] == pytest.approx(direct, rel=0.03)


@pytest.mark.parametrize("ramp", [None, {"to": "2400 rpm", "time": "0.3 s"}])
def test_an_impact_at_the_border_of_passes_is_counted_once(ramp):
    """A slot under the load, crossed in the middle or at the end of passes: equal lines, a = omega v."""
    settings = {"model": "planar", "defect": SLOT, "load": "500 N", "settle": "50 ms", "duration": "0.25 s"}
    first, second = (
        simulate(case(start_angle=angle, ramp=ramp, **settings)).features for angle in ("13.846 deg", "0 deg")
    )
    assert second["velocity@BPFO"] == pytest.approx(first["velocity@BPFO"], rel=0.005)
    assert second["velocity@BPFO.phase"] == pytest.approx(first["velocity@BPFO.phase"], abs=0.02)
    assert second["acceleration@BPFO"] == pytest.approx(first["acceleration@BPFO"], rel=0.01)
    assert second["velocity@BPFO-scatter"] < 2.0 * first["velocity@BPFO-scatter"]


def test_race_defect_acts_on_a_roller_with_a_defect_turned_away():
    """The roller over an outer defect has a defect itself, turned away by 1 rad of slip."""
    outer, on_roller = SLOT, SLOT | {"race": "roller", "width": "1.2 mm"}
    forces = []
    for defects in ([outer], [outer, on_roller]):
        test_case = case(model="planar", start_angle=0.0, defects=defects)
        model = assemble.model(test_case)
        y, _ = assemble.start(
            test_case, assemble.model(case(model="planar", start_angle=0.0))
        )  # equilibrium of the healthy bearing
        y[lay.SPIN] = 1.0
        start_at_rest(model, 0.0, y)
        forces.append(y[lay.Q_O : lay.Q_O + 13].copy())
    assert forces[1] == pytest.approx(forces[0], abs=1e-9)
    assert forces[0][0] == 0.0


@pytest.mark.parametrize("model", ["static", "ring", "rollers", "planar"])
def test_preload_extends_the_load_zone_to_the_whole_turn(model):
    method = {} if model == "static" else {"method": "verlet"}
    result = simulate(case(model=model, clearance="-10 um", duration="20 ms", settle="10 ms", **method)).features
    assert result["load_zone.extent"] == pytest.approx(2.0 * np.pi, rel=1e-6)


@pytest.mark.parametrize(
    ("fields", "limit"),
    [
        (SHAFT | IDLE | {"rig": {"torsion_stiffness": "1e4 N m/rad", "torsion_damping": "1e4 N m s/rad"}}, 1e-7),
        ({"shaft": {"stiffness": "1e8 N/m", "mass": "1 kg", "damping": "1e7 N s/m"}}, 1.1e-7),
        ({"cage": {"pocket_stiffness": "1e12 N/m"}}, 2e-7),
    ],
)
def test_supports_and_pockets_limit_the_step(fields, limit):
    """Verlet: h C = 1 of damper over inertia, or h^2 K/4 = 1 of a pocket over a roller."""
    assert choice.limits(case(model="planar", method="verlet")).at_rest > 1e-6
    assert choice.limits(case(model="planar", method="verlet", **fields)).at_rest < limit


@pytest.mark.parametrize(
    ("fields", "is_distinct"),
    [
        ({"contact": {"stiffness": "palmgren"}}, False),
        ({"contact": {"stiffness": "johnson"}}, True),
        ({"excitation": "pressure-share", "defect": SLOT}, True),
    ],
)
def test_material_is_part_of_the_id_only_if_used(fields, is_distinct):
    def hashed_fields(modulus):
        bearing = case().bearing
        material = bearing.material.model_copy(update={"young_modulus": modulus})
        return relevant_fields(
            case(**fields).model_copy(update={"bearing": bearing.model_copy(update={"material": material})})
        )

    assert (hashed_fields(2.0e11) != hashed_fields(2.1e11)) == is_distinct
