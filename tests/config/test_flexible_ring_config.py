# ruff: noqa: E501 (a table of messages, one line each)
"""Flexible outer ring, its load and its sensor: fields of a case, refusals and earlier ids."""

import math
from pathlib import Path
from typing import Any

import pytest

from bearingsim.catalogue import METHODS, MODELS
from bearingsim.config import Case
from bearingsim.config.rules.hierarchy import simplest_model
from bearingsim.config.sections.ring import FlexibleRing, RingLoad, SupportPoint
from bearingsim.simulation.choice import choose_method, is_suitable
from bearingsim.store import case_of
from bearingsim.store.names import flat_parameters, parameter_attributes
from bearingsim.study import case_id, json_schema, load_study
from bearingsim.study.uncertainty import has_effect
from tests.scenes.commands import type_
from tests.scenes.study_text import Write

HEALTHY = "study: base\nbearing: nf308\nspeed: 1800 rpm\nload: 150 N\n"
BENDS = {"bends": "true"}
HOUSING = {"by": "housing", "stiffness": "1e10 N/m/m"}
PADS = {"by": "pads", "angles": ["-45 deg", "45 deg"]}
POINTS = {
    "by": "points",
    "at": [{"angle": f"{angle} deg", "stiffness": "1e8 N/m"} for angle in (-30, 30)],
    "mass": "2 kg",
}
LOADS: list[dict[str, Any]] = [{}, {"load": PADS}, {"load": POINTS}, {"load": HOUSING}]


def case(**fields: Any) -> Case:
    return Case.model_validate({"bearing": "nf308", "speed": "1800 rpm", "load": "150 N"} | fields)


def flexible_case(**rig: Any) -> Case:
    return case(rig={"ring": BENDS} | rig)


def ring_of(test_case: Case) -> FlexibleRing:
    assert test_case.rig.ring is not None
    return test_case.rig.ring


def load_of(test_case: Case) -> RingLoad:
    assert test_case.rig.load is not None
    return test_case.rig.load


# What a case says


def test_defaults_of_a_flexible_ring_follow_from_the_bearing() -> None:
    test_case = flexible_case()
    ring = ring_of(test_case)
    assert (ring.harmonics, ring.damping) == (13 + 7, 0.01)
    assert (ring.section.height, ring.section.width) == (0.0065, 0.023)
    assert load_of(test_case) == RingLoad(by="point")
    assert (test_case.rig.sensor.on, test_case.rig.sensor.angle) == ("ring", 0.0)


@pytest.mark.parametrize(
    "rig", [{}, {"ring": "none"}, {"ring": {"bends": "false"}}, {"ring": "none", "load": "none"}]
)
def test_a_rigid_ring_has_neither_ring_nor_load(rig: dict[str, Any]) -> None:
    test_case = case(rig=rig)
    assert (test_case.rig.ring, test_case.rig.load) == (None, None)
    assert test_case == case(rig={})
    assert case_id(test_case) == case_id(case(rig={}))


def test_ring_keys_imply_bending() -> None:
    assert ring_of(case(rig={"ring": {"harmonics": 12}})).harmonics == 12


def test_load_has_the_given_distribution() -> None:
    assert load_of(flexible_case(load=PADS)).angles == pytest.approx((-math.pi / 4.0, math.pi / 4.0))
    points = load_of(flexible_case(load=POINTS))
    assert points.mass == 2.0
    assert points.at is not None
    assert points.at[1] == SupportPoint(angle=math.pi / 6.0, stiffness=1e8)
    housing = load_of(flexible_case(load=HOUSING | {"fit": "-5 um"}))
    assert (housing.stiffness, housing.fit, housing.mass) == (1e10, -5e-6, 1.0)
    assert load_of(flexible_case(load=HOUSING)).fit == 0.0


@pytest.mark.parametrize("unit", ["1e10 N/m/m", "1e10 N/m^2", "1e10 N/m²", "1e4 N/mm/mm", "1e4 N/mm^2"])
def test_units_of_a_housing(unit: str) -> None:
    assert load_of(flexible_case(load=HOUSING | {"stiffness": unit})).stiffness == 1e10


def test_a_sensor_on_the_housing_needs_fewer_harmonics() -> None:
    test_case = flexible_case(load=HOUSING, sensor={"on": "housing", "angle": "10 deg"})
    assert ring_of(test_case).harmonics == 8
    assert test_case.rig.sensor_angle == test_case.rig.sensor.angle == math.radians(10.0)


@pytest.mark.parametrize("rig", [{"sensor_angle": "60 deg"}, {"sensor": {"angle": "60 deg"}}])
def test_sensor_angle_has_two_keys(rig: dict[str, Any]) -> None:
    test_case = case(rig=rig)
    assert test_case.rig.sensor_angle == test_case.rig.sensor.angle == math.pi / 3.0
    assert test_case == case(rig={"sensor_angle": "60 deg", "sensor": {"angle": "60 deg"}})


@pytest.mark.parametrize("rig", LOADS)
def test_a_case_survives_a_dump_and_the_results_folder(rig: dict[str, Any]) -> None:
    test_case = flexible_case(**rig)
    assert Case.model_validate(test_case.model_dump()) == test_case
    assert case_of(flat_parameters(test_case) | {"record": ""}).rig == test_case.rig


def test_results_without_sensor_are_read() -> None:
    stored = flat_parameters(case(rig={"sensor_angle": "60 deg"})) | {"record": ""}
    old = {name: value for name, value in stored.items() if not name.startswith("rig.sensor.")}
    assert len(old) == len(stored) - 2
    assert case_of(old).rig == case(rig={"sensor_angle": "60 deg"}).rig


def test_stored_parameters_have_units() -> None:
    names = {"rig.load.stiffness": "N/m/m", "rig.load.at.2.stiffness": "N/m", "rig.load.angles.1": "rad"}
    assert {name: parameter_attributes(name)["units"] for name in names} == names
    assert set(names) <= {name for load in LOADS[1:] for name in flat_parameters(flexible_case(**load))}


def test_schema_contains_the_ring() -> None:
    schema = json_schema()["$defs"]
    rig = schema["Rig"]["properties"]
    assert rig["ring"]["anyOf"][0] == rig["load"]["anyOf"][0] == {"type": "string", "enum": ["none"]}
    assert {"ring", "load", "sensor", "sensor_angle"} <= rig.keys()
    assert schema["RingLoad"]["properties"]["by"]["enum"] == ["point", "pads", "points", "housing"]
    assert {"bends", "harmonics", "damping", "section"} == schema["FlexibleRing"]["properties"].keys()


# Ids


RIGID: list[tuple[dict[str, Any], str]] = [
    ({"method": "verlet"}, "1661ed5fe428bb4f"),
    ({"model": "static"}, "347f3a7249d8946c"),
    ({"method": "verlet", "rig": {"sensor_angle": "60 deg", "bracket_stiffness": "1e5 N/m"}}, "b46bf8dc8e1dfbc2"),
    ({"method": "rk4", "model": "ring", "rig": {"name": "x", "ring_mass": "0.3 kg"}}, "ef9d4655b8085693"),
    (
        {
            "method": "verlet",
            "model": "spatial",
            "rig": {"axial_stiffness": "1e7 N/m", "tilting_stiffness": "1e4 N m/rad"},
        },
        "ee12e379664183a6",
    ),
]
"""Cases, and their ids before a ring could bend."""


@pytest.mark.parametrize(("fields", "name"), RIGID)
def test_rigid_ring_keeps_the_id(monkeypatch: pytest.MonkeyPatch, fields: dict[str, Any], name: str) -> None:
    monkeypatch.setattr("bearingsim.core.MODEL_VERSION", 8)
    assert case_id(case(settle="50 ms", **fields)) == name


def test_one_sensor_has_one_id() -> None:
    assert case_id(case(rig={"sensor": {"angle": "60 deg"}})) == case_id(case(rig={"sensor_angle": "60 deg"}))
    assert case_id(case(rig={"sensor": {"angle": "60 deg"}})) != case_id(case())


@pytest.mark.usefixtures("constant_candidates")
def test_id_depends_on_all_parameters_of_a_flexible_ring() -> None:
    rigs: list[dict[str, Any]] = [
        *LOADS,
        {"ring": BENDS | {"harmonics": 12}},
        {"ring": BENDS | {"damping": "2 %"}},
        {"load": HOUSING | {"fit": "1 um"}},
        {"load": HOUSING | {"mass": "3 kg"}},
        {"load": HOUSING, "ring": BENDS | {"harmonics": 8}},
        {"load": HOUSING, "sensor": {"on": "housing"}},
    ]
    ids = {
        case_id(test_case)
        for test_case in [case(), *(case(model="static", rig={"ring": BENDS} | rig) for rig in rigs)]
    }
    assert len(ids) == 1 + len(rigs)
    material = case().bearing.model_dump() | {"material": {"density": 7850.0, "young_modulus": 100e9}}
    static = {"model": "static", "rig": {"ring": BENDS}}
    assert case_id(case(bearing=material, **static)) != case_id(case(**static))


# Models and methods


@pytest.mark.parametrize("name", MODELS)
def test_models_without_a_flexible_ring_refuse_it(write: Write, name: str) -> None:
    text = f"{HEALTHY}rig: {{ring: {{bends: true}}}}\nsweep: {{model: [{name}]}}\n"
    if name in ("static", "rollers"):
        assert load_study(write(text)).cases()[0].rig.ring
        return
    stderr = type_("check", write(text), code=2)[1]
    assert f"model: the {name} model cannot do this: `rig.ring` lets the outer ring bend" in stderr


def test_simplest_model_of_a_flexible_ring() -> None:
    assert simplest_model(case(model="rollers", rig={"ring": BENDS})) == "static"
    assert simplest_model(case(model="rollers", rig={"ring": BENDS}, record=["ring.acceleration"])) == "rollers"


def test_auto_excludes_implicit_methods_for_a_flexible_ring() -> None:
    test_case = flexible_case()
    implicit = {name for name, method in METHODS.items() if method.implicit}
    assert not any(is_suitable(test_case, name) for name in implicit)
    assert any(is_suitable(case(), name) for name in implicit)
    assert implicit.isdisjoint(choose_method(test_case).costs)


def test_missing_bracket_is_not_varied() -> None:
    assert not has_effect("bracket", flexible_case(bracket_stiffness="0 N/m"))
    assert has_effect("bracket", flexible_case())


# Refusals


BEND = "ring: {bends: true}"


def _loaded(what: str) -> str:
    return f"rig: {{{BEND}, load: {{{what}}}}}"


def springs_at(angles: str) -> str:
    points = ", ".join(f"{{angle: {angle} deg, stiffness: 1e8 N/m}}" for angle in angles.split())
    return f"by: points, at: [{points}]"


LINES: list[tuple[str, str, str]] = [
    ("rig: {load: {by: point}}", "{by", "rig.load: the load path has no effect on a rigid ring (use `ring: {bends: true}`)"),
    ("rig: {sensor: {on: housing}}", "housing", "rig.sensor.on: a rigid ring has no housing around it (use `ring: {bends: true}`)"),
    ("rig: {bracket_stiffness: 0 N/m}", "0 N/m", "rig.bracket_stiffness: a rigid ring needs a bracket (use `1e7 N/m`, or `ring: {bends: true}`)"),
    (f"rig: {{{BEND}, bracket_stiffness: -1 N/m}}", "-1 N/m", "rig.bracket_stiffness: expected a stiffness that is not negative, such as `1e7 N/m`, got `-1 N/m`"),
    ("rig: {sensor: {angle: 10 deg}, sensor_angle: 20 deg}", "20 deg", "rig.sensor_angle: `sensor_angle` is a synonym of `sensor.angle` (keep one of them)"),
    ("rig: {sensor: {on: table}}", "table", "rig.sensor.on: expected `ring` or `housing`, got `table`"),
    ("rig: {sensor: 0 deg}", "0 deg", "rig.sensor: expected a mapping such as `{on: ring, angle: 0 deg}`, got `0 deg`"),
    ("rig: {ring: {bend: true}}", "bend", "rig.ring: unknown key `bend` (did you mean `bends`?)"),
    ("rig: {ring: true}", "true", "rig.ring: expected a mapping such as `{bends: true}`, got `true`"),
    ("rig: {ring: {section: 6.5 mm}}", "6.5 mm", "rig.ring.section: expected a mapping such as `{height: 6.5 mm, width: 23 mm}`, got `6.5 mm`"),
    ("rig: {ring: {damping: 0.01}}", "0.01", "rig.ring.damping: expected a percentage such as `1 %`, got `0.01` (the unit is missing)"),
    (f"rig: {{{BEND}, load: housing}}", "housing", "rig.load: expected a mapping such as `{by: housing, stiffness: 1e10 N/m/m}`, got `housing`"),
    ("rig: {ring: {bends: yes}}", "yes", "rig.ring.bends: expected `true` or `false`, got `yes`"),
    ("rig: {ring: {harmonics: 1}}", "1}", "rig.ring.harmonics: expected a whole number from 2 to 100, or `auto`, got `1`"),
    ("rig: {ring: {harmonics: 101}}", "101", "rig.ring.harmonics: expected a whole number from 2 to 100, or `auto`, got `101`"),
    ("rig: {ring: {damping: 0 %}}", "0 %", "rig.ring.damping: expected a percentage from 0.01 % to 20 %, got `0 %`"),
    ("rig: {ring: {damping: 21 %}}", "21 %", "rig.ring.damping: expected a percentage from 0.01 % to 20 %, got `21 %`"),
    ("rig: {ring: {section: {height: 6.6 mm}}}", "6.6 mm", "rig.ring.section.height: the bearing's outer ring has a height of 6.5 mm, not 6.6 mm (remove `height`)"),
    ("rig: {ring: {section: {width: 22 mm}}}", "22 mm", "rig.ring.section.width: the bearing's outer ring has a width of 23 mm, not 22 mm (remove `width`)"),
    (_loaded("by: hosing"), "hosing", "rig.load.by: expected `point`, `pads`, `points` or `housing`, got `hosing` (did you mean `housing`?)"),
    (_loaded("by: point, mass: 1 kg"), "1 kg", "rig.load.mass: `by: point` has no `mass` (remove `mass`, or use `by: points`)"),
    (_loaded("by: pads, angles: [0 deg], fit: 1 um"), "1 um", "rig.load.fit: `by: pads` has no `fit` (remove `fit`, or use `by: housing`)"),
    (_loaded("by: pads"), "pads", "rig.load.by: `by: pads` needs `angles` (use `angles: [-45 deg, 45 deg]`)"),
    (_loaded("by: pads, angles: []"), "pads", "rig.load.by: `by: pads` needs `angles` (use `angles: [-45 deg, 45 deg]`)"),
    (_loaded("by: pads, angles: 45 deg"), "45 deg", "rig.load.angles: expected a list such as `[a, b]`"),
    (_loaded("by: pads, angles: [0 deg, 360 deg]"), "[0 deg", "rig.load.angles: two pads have the same angle (give each angle once)"),
    (_loaded("by: pads, angles: [-45 deg, 46 deg]"), "[-45", "rig.load.angles: equal forces at these angles do not add up to a load along the load line (use angles on both sides of it, such as `[-45 deg, 45 deg]`)"),
    (_loaded("by: pads, angles: [-85 deg, 85 deg]"), "[-85", "rig.load.angles: pads at these angles carry almost none of the load: their forces act across it (use angles nearer to the load line, such as `[-45 deg, 45 deg]`)"),
    (_loaded("by: pads, angles: [-135 deg, 135 deg]"), "[-135", "rig.load.angles: equal forces at these angles do not add up to a load along the load line (use angles on both sides of it, such as `[-45 deg, 45 deg]`)"),
    (_loaded("by: points, at: []"), "points", "rig.load.by: `by: points` needs `at` (use `at: [{angle: 0 deg, stiffness: 1e8 N/m}]`)"),
    (_loaded("by: points, at: [45 deg]"), "45 deg", "rig.load.at: expected a mapping such as `{angle: 0 deg, stiffness: 1e8 N/m}`, got `45 deg`"),
    (_loaded("by: points, at: [{angle: 0 deg}]"), "{angle", "rig.load.at: `stiffness` is missing (expected a stiffness such as `1e7 N/m`)"),
    (_loaded("by: points, at: [{angle: 0 deg, stifness: 1 N/m, stiffness: 1 N/m}]"), "stifness", "rig.load.at: unknown key `stifness` (did you mean `stiffness`?)"),
    (_loaded(springs_at("20 -340")), "[{angle", "rig.load.at: two springs have the same angle (give each angle once)"),
    (_loaded(springs_at("120 -90")), "[{angle", "rig.load.at: no spring within 90 deg of the load line carries the load (give one at `angle: 0 deg`)"),
    (f"rig: {{{BEND}, bracket_stiffness: 0 N/m, load: {{{springs_at('0')}}}}}", "[{angle", "rig.load.at: compression springs at these angles do not support the carrier (give springs on both sides of the load line)"),
    (_loaded("by: housing"), "housing", "rig.load.by: `by: housing` needs `stiffness` (use `stiffness: 1e10 N/m/m`)"),
    (_loaded("by: housing, stiffness: 1e10 N/m"), "1e10 N/m", "rig.load.stiffness: expected a stiffness per metre of circumference such as `1e10 N/m/m`, got `1e10 N/m` (`N/m` is a unit of stiffness)"),
    (_loaded("by: housing, stiffness: 2e13 N/m/m"), "2e13", "rig.load.stiffness: a housing of 2e+13 N/m/m makes the ring practically rigid (use a rigid ring, or at most 1e13 N/m/m)"),
    (_loaded("by: housing, stiffness: 2e6 N/m/m"), "2e6 N", "rig.load.stiffness: under its load the housing would move by 1.06 mm (use a stiffer one, such as `1e10 N/m/m`)"),
    (_loaded("by: housing, stiffness: 1e10 N/m/m, mass: 1e-6 kg"), "1e-6 kg", "rig.load.mass: a carrier of 0.001 g on its springs needs too short a step (use 1 g or more, or omit `mass`, 1 kg by default)"),
    (_loaded("by: housing, stiffness: 1e10 N/m/m, fit: -0.2 mm"), "-0.2 mm", "rig.load.fit: a fit of -200 um is beyond 100 um (is the unit right?)"),
    (_loaded("by: housing, stiffness: 1e10 N/m/m, mass: 0 kg"), "0 kg", "rig.load.mass: expected a mass above zero, such as `0.6 kg`, got `0 kg`"),
    (f"load_across: 1 N\nrig: {{{BEND}}}", "1 N", "load_across: `by: point` exerts no force across the load line (remove `load_across`, or use `by: points` or `by: housing`)"),
    (f"{_loaded('by: pads, angles: [0 deg]')}\nload_across: 1 N", "1 N", "load_across: `by: pads` exerts no force across the load line (remove `load_across`, or use `by: points` or `by: housing`)"),
    (f"rig: {{{BEND}, sensor: {{on: housing}}}}", "housing", "rig.sensor.on: `by: point` has no housing for a sensor (use `by: housing`)"),
    (f"rig: {{{BEND}, torsion_stiffness: 1e4 N m/rad}}", "1e4 N m/rad", "rig.torsion_stiffness: the rollers model cannot do this: `rig.torsion_stiffness` lets the outer ring rotate (no model can compute all of this)"),
    *(
        (f"rig: {{{BEND}}}\nmethod: {name}", name, f"method: `{name}` needs the Jacobian, which models with a flexible ring do not have (omit `method`, or use an explicit one)")
        for name, method in METHODS.items()
        if method.implicit
    ),
]  # fmt: skip


@pytest.mark.parametrize(("lines", "caret", "message"), LINES)
def test_mistake_gives_one_message_at_its_position(write: Write, lines: str, caret: str, message: str) -> None:
    path = write(HEALTHY + lines + "\n")
    text = error_output(path)
    first, source, mark = text.splitlines()
    assert first.partition(": ")[2] == message
    assert source[mark.index("^") :].startswith(caret)


def error_output(path: Path) -> str:
    """Return the error output of `check` for an invalid study."""
    return str(type_("check", path, code=2)[1])


@pytest.mark.parametrize("angles", ["10 -10", "-30 30 180", "0 120 -120", "80 -80"])
def test_springs_on_both_sides_need_no_bracket(angles: str) -> None:
    springs = [{"angle": f"{angle} deg", "stiffness": "1e8 N/m"} for angle in angles.split()]
    assert load_of(flexible_case(bracket_stiffness="0 N/m", load={"by": "points", "at": springs})).has_carrier


def test_a_load_across_turns_the_load_line() -> None:
    """Springs at 100 and 120 deg, and 10 deg, hold a load that a load across has turned to 45 deg; without that
    at 10 deg nothing carries a load at 0 deg.
    """
    load = {"by": "points", "at": [{"angle": f"{angle} deg", "stiffness": "1e8 N/m"} for angle in (100, 120, 10)]}
    assert case(load_across="150 N", rig={"ring": BENDS, "load": load}).load_across == 150.0
    with pytest.raises(ValueError, match="carries the load"):
        flexible_case(load={"by": "points", "at": load["at"][:2]})


@pytest.mark.parametrize("load", LOADS)
def test_flexible_ring_needs_no_bracket(load: dict[str, Any]) -> None:
    assert flexible_case(bracket_stiffness="0 N/m", **load).rig.bracket_stiffness == 0.0
