"""Features of runs whose cage or shaft is free, and what limits and tells such cases apart."""

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
"""Parts that do next to nothing here: with them the bearing has the types of one that is compiled anyway."""


def test_an_unbalance_leaks_little_into_the_ball_pass_line():
    """The ring moves by 100 um/s at the shaft's frequency and by nothing at BPFO: 1e-3 of it is read there."""
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


def test_lines_of_a_cage_that_slips_by_half_are_not_folded():
    """Read at the samples of a kinematic pass the line was 9.8 um/s; read finely enough, and by a window, 20.5."""
    settings = {"speed": "6000 rpm", "load": "5 N", "drag": {}, "rig": {"bracket_stiffness": "1e5 N/m"}}
    result = simulate(case(model="planar", defect=SLOT, settle="0.3 s", duration="0.2 s", **settings)).features
    assert result["cage.slip.mean"] == pytest.approx(0.49, abs=0.03)
    assert result["velocity@BPFO"] == pytest.approx(20.5e-6, rel=0.1)


def test_the_angle_of_a_cage_that_has_slipped_is_told_as_it_is():
    """What it turns from one start of the record to a later one, against its recorded speed in between."""
    settings = {"speed": "6000 rpm", "load": "5 N", "drag": {}, "rig": {"bracket_stiffness": "1e5 N/m"}}
    settings |= {"model": "planar", "duration": "40 ms", "record": ["cage.speed"]}
    early, late = (simulate(case(settle=settle, **settings)) for settle in ("20 ms", "50 ms"))
    speed = early.series["cage.speed"]
    turned = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(early.time))])
    result = float(late.info["cage_angle_start_rad"]) - float(early.info["cage_angle_start_rad"])
    assert result == pytest.approx(np.interp(0.03, early.time, turned), abs=2e-4)
    assert result < 7.0  # and not 7.7, as without slip


def test_on_a_ramp_an_acceleration_is_the_derivative_at_each_speed():
    """An unbalance from 600 to 3000 rpm: the line at fr against the acceleration itself, under a window."""
    ramp = {"speed": "600 rpm", "ramp": {"to": "3000 rpm", "time": "0.4 s"}, "settle": "0 s", "duration": "0.4 s"}
    record = simulate(case(model="planar", record=["ring.acceleration"], sampling="20 kHz", **ramp, **SHAFT))
    t = record.time
    angle = 2 * np.pi * (10.0 * t + 0.5 * (40.0 / 0.4) * t * t)
    window = np.sin(np.pi * angle / angle[-1]) ** 2 * np.gradient(angle)
    direct = 2.0 * abs(np.sum(window * record.acceleration[:, 0] * np.exp(-1j * angle)) / window.sum())
    assert record.features["acceleration@fr"] == pytest.approx(direct, rel=0.03)


def test_a_defect_is_felt_whatever_a_slipped_roller_carries():
    """The roller over an outer defect has one itself, turned 1 rad away by slip: only the race's acts."""
    outer, own = SLOT, SLOT | {"race": "roller", "width": "1.2 mm"}
    forces = []
    for defects in ([outer], [outer, own]):
        test_case = case(model="planar", start_angle=0.0, defects=defects)
        model = assemble.model(test_case)
        y, _ = assemble.start(
            test_case, assemble.model(case(model="planar", start_angle=0.0))
        )  # pressed as if healthy
        y[lay.SPIN] = 1.0
        start_at_rest(model, 0.0, y)
        forces.append(y[lay.Q_O : lay.Q_O + 13].copy())
    assert forces[1] == pytest.approx(forces[0], abs=1e-9)
    assert forces[0][0] == 0.0


@pytest.mark.parametrize("model", ["static", "ring", "rollers", "planar"])
def test_under_preload_the_load_zone_is_the_whole_turn(model):
    method = {} if model == "static" else {"method": "verlet"}
    result = simulate(case(model=model, clearance="-10 um", duration="20 ms", settle="10 ms", **method)).features
    assert result["load_zone.extent"] == pytest.approx(2.0 * np.pi, rel=1e-6)


@pytest.mark.parametrize(
    ("given", "limit"),
    [
        (SHAFT | IDLE | {"rig": {"torsion_stiffness": "1e4 N m/rad", "torsion_damping": "1e4 N m s/rad"}}, 1e-7),
        ({"shaft": {"stiffness": "1e8 N/m", "mass": "1 kg", "damping": "1e7 N s/m"}}, 1.1e-7),
        ({"cage": {"pocket_stiffness": "1e12 N/m"}}, 2e-7),
    ],
)
def test_what_holds_rings_and_rollers_limits_the_step_too(given, limit):
    """Verlet: h C = 1, or h^2 K/4 = 1, of damper over inertia, or of a pocket over a roller."""
    assert choice.limits(case(model="planar", method="verlet")).at_rest > 1e-6
    assert choice.limits(case(model="planar", method="verlet", **given)).at_rest < limit


@pytest.mark.parametrize(
    ("given", "told_apart"),
    [
        ({"contact": {"stiffness": "palmgren"}}, False),
        ({"contact": {"stiffness": "johnson"}}, True),
        ({"excitation": "pressure-share", "defect": SLOT}, True),
    ],
)
def test_cases_of_two_materials_have_two_ids_where_it_matters(given, told_apart):
    def of(modulus):
        bearing = case().bearing
        steel = bearing.material.model_copy(update={"young_modulus": modulus})
        return relevant_fields(
            case(**given).model_copy(update={"bearing": bearing.model_copy(update={"material": steel})})
        )

    assert (of(2.0e11) != of(2.1e11)) == told_apart
