# ruff: noqa: E501 (a table of messages, one line each)
"""`rig.ring`, `rig.load` and `rig.sensor` in a study: what is filled in, what is refused, what has an id of its own."""

import math

import pytest

from bearingsim.catalogue import METHODS
from bearingsim.config import Case
from bearingsim.study import StudyError, case_id, json_schema, load_study
from bearingsim.study.used import used
from tests.scenes.commands import type_
from tests.scenes.study_text import BASE, Write

BENT = "rig: {ring: {bends: true}}"
HOUSED = "rig: {ring: {bends: true}, load: {by: housing, stiffness: 1e10 N/m/m}}"


def cases(write: Write, said: str) -> list[Case]:
    return load_study(write(f"{BASE}{said}\n")).cases()


def loaded(load: str) -> str:
    """A rig whose ring bends under such a load."""
    return f"rig: {{ring: {{bends: true}}, load: {load}}}"


# What is filled in


def test_a_ring_that_bends_is_completed_from_the_bearing(write: Write) -> None:
    (case,) = cases(write, BENT)
    ring, load = case.rig.ring, case.rig.load
    assert ring is not None
    assert load is not None
    b = case.bearing
    outer_race = (b.pitch_diameter + b.roller_diameter) / 2.0
    assert ring.section.height == pytest.approx(b.outside_diameter / 2.0 - outer_race, rel=1e-12)
    assert ring.section.width == b.width
    assert (ring.harmonics, ring.damping) == (b.rollers + 7, 0.01)
    assert load.model_dump(exclude_none=True) == {"by": "point"}
    assert case.rig.sensor.model_dump() == {"on": "ring", "angle": 0.0}


def test_a_housing_is_completed(write: Write) -> None:
    (case,) = cases(write, HOUSED)
    load = case.rig.load
    assert load is not None
    assert (load.mass, load.fit, load.stiffness) == (1.0, 0.0, 1e10)


def test_what_reaches_a_housing_needs_fewer_harmonics(write: Write) -> None:
    (case,) = cases(write, HOUSED.replace("{ring", "{sensor: {on: housing}, ring"))
    assert case.rig.ring is not None
    assert case.rig.ring.harmonics == 8


def test_what_is_said_is_kept(write: Write) -> None:
    ring = "{harmonics: 12, damping: 2 %, section: {height: 6.52 mm}}"
    load = (
        "{by: points, at: [{angle: 0 deg, stiffness: 1e8 N/m}, {angle: 90 deg, stiffness: 2e8 N/m}], mass: 3 kg}"
    )
    (case,) = cases(write, f"rig: {{ring: {ring}, load: {load}}}")
    assert case.rig.ring is not None
    assert case.rig.load is not None
    assert case.rig.ring.bends
    assert (case.rig.ring.harmonics, case.rig.ring.damping, case.rig.ring.section.height) == (12, 0.02, 6.52e-3)
    assert [point.angle for point in case.rig.load.at or ()] == [0.0, math.pi / 2.0]
    assert (case.rig.load.mass, case.rig.load.fit) == (3.0, None)


def test_a_ring_that_does_not_bend_is_rigid_whatever_its_load(write: Write) -> None:
    (case,) = cases(write, HOUSED.replace("true", "false"))
    assert case.rig.ring is None
    assert case.rig.load is None


@pytest.mark.parametrize(("record", "model"), [("ring.velocity", "static"), ("roller.radial", "rollers")])
def test_the_least_model_is_one_that_knows_it(write: Write, record: str, model: str) -> None:
    (case,) = cases(write, f"{BENT}\nmodel: least\nrecord: [{record}]")
    assert case.model == model


# The sensor


def test_the_sensors_angle_has_an_old_word(write: Write) -> None:
    new, old, both = (
        cases(write, f"rig: {{{said}}}")[0]
        for said in (
            "sensor: {angle: 5 deg}",
            "sensor_angle: 5 deg",
            "sensor_angle: 5 deg, sensor: {angle: 5 deg}",
        )
    )
    for case in (new, old, both):
        assert case.rig.sensor_angle == case.rig.sensor.angle == pytest.approx(math.radians(5.0))
    assert case_id(new) == case_id(old) == case_id(both)


# Refusals


@pytest.mark.parametrize(
    ("said", "caret", "message"),
    [
        ("rig: {ring: none}", "none", "rig.ring: expected a mapping such as `{bends: true}`, got `none`"),
        ("rig: {ring: {bends: maybe}}", "maybe", "rig.ring.bends: expected `true` or `false`, got `maybe`"),
        ("rig: {ring: {bend: true}}", "bend:", "rig.ring: unknown key `bend` (did you mean `bends`?)"),
        ("rig: {ring: {harmonics: 1}}", "1", "rig.ring.harmonics: expected `auto`, or a whole number from 2 to 100, got `1`"),
        ("rig: {ring: {harmonics: all}}", "all", "rig.ring.harmonics: expected `auto`, or a whole number from 2 to 100, got `all`"),
        ("rig: {ring: {damping: 0.01}}", "0.01", "rig.ring.damping: expected a share such as `60 %`, got `0.01` (the unit is missing)"),
        ("rig: {ring: {damping: 50 %}}", "50 %", "rig.ring.damping: expected a share from 0.01 % to 20 %, got `50 %`"),
        ("rig: {ring: {section: {height: 3 mm}}}", "3 mm", "rig.ring.section.height: the bearing's outer ring has a height of 6.5 mm, not 3 mm (leave it out)"),
        ("rig: {ring: {section: {width: 30 mm}}}", "30 mm", "rig.ring.section.width: the bearing's outer ring has a width of 23 mm, not 30 mm (leave it out)"),
        ("rig: {load: {by: point}}", "{by", "rig.load: where the load enters is nothing to a rigid ring (say `ring: {bends: true}`)"),
        ("rig: {sensor: {on: housing}}", "housing", "rig.sensor.on: a rigid ring has no housing around it (say `ring: {bends: true}`, or `on: ring`)"),
        ("rig: {sensor: {on: shaft}}", "shaft", "rig.sensor.on: expected `ring` or `housing`, got `shaft`"),
        ("rig: {bracket_stiffness: 0 N/m}", "0 N/m", "rig.bracket_stiffness: a rigid ring needs a bracket (say `1e7 N/m`, or `ring: {bends: true}`)"),
        ("rig: {sensor_angle: 5 deg, sensor: {angle: 6 deg}}", "5 deg", "rig.sensor_angle: `sensor_angle` is another word for `sensor.angle` (say one of them)"),
        ("rig: {sensor: {on: housing}, ring: {bends: true}}", "housing", "rig.sensor.on: `by: point` has no housing for a sensor (say `by: housing`)"),
        (loaded("housing"), "housing", "rig.load: expected a mapping such as `{by: housing, stiffness: 1e10 N/m/m}`, got `housing`"),
        (loaded("{by: pad}"), "pad", "rig.load.by: expected `point`, `pads`, `points` or `housing`, got `pad` (did you mean `pads`?)"),
        (loaded("{by: pads}"), "pads", "rig.load.by: `by: pads` needs `angles` (say `angles: [-45 deg, 45 deg]`)"),
        (loaded("{by: points}"), "points", "rig.load.by: `by: points` needs `at` (say `at: [{angle: 0 deg, stiffness: 1e8 N/m}]`)"),
        (loaded("{by: housing}"), "housing", "rig.load.by: `by: housing` needs `stiffness` (say `stiffness: 1e10 N/m/m`)"),
        (loaded("{mass: 1 kg}"), "1 kg", "rig.load.mass: `by: point` has no `mass` (leave it out, or say `by: points` or `by: housing`; a sweep takes all of `rig.load`)"),
        (loaded("{by: points, at: [{angle: 0 deg}]}"), "{angle", "rig.load.at: `stiffness` is missing (expected a stiffness such as `1e7 N/m`)"),
        (loaded("{by: pads, angles: [0 deg, 10 deg]}"), "[0 deg", "rig.load.angles: equal forces at these angles do not add up to a load along the load line (take angles on both sides of it, such as `[-45 deg, 45 deg]`)"),
        (loaded("{by: pads, angles: [-135 deg, 135 deg]}"), "[-135", "rig.load.angles: equal forces at these angles do not add up to a load along the load line (take angles on both sides of it, such as `[-45 deg, 45 deg]`)"),
        (loaded("{by: pads, angles: [0 deg, 360 deg]}"), "[0 deg", "rig.load.angles: two pads stand at the same angle (give each angle once)"),
        (loaded("{by: points, at: [{angle: 0 deg, stiffness: 1e8 N/m}, {angle: 360 deg, stiffness: 1e8 N/m}]}"), "[{", "rig.load.at: two springs stand at the same angle (give each angle once)"),
        (loaded("{by: points, at: [{angle: 90 deg, stiffness: 1e8 N/m}]}"), "[{", "rig.load.at: no spring stands within 90 deg of the load line: nothing carries the load (give one at `angle: 0 deg`)"),
        (loaded("{by: housing, stiffness: 1e10 N/m}"), "1e10 N/m", "rig.load.stiffness: expected a stiffness per metre of circumference such as `1e10 N/m/m`, got `1e10 N/m` (`N/m` is a unit of stiffness)"),
        (loaded("{by: housing, stiffness: 1e14 N/m/m}"), "1e14", "rig.load.stiffness: a housing of 1e14 N/m/m holds the ring as a rigid one (take a rigid ring, or at most 1e13 N/m/m)"),
        (loaded("{by: housing, stiffness: 1e10 N/m/m, fit: 1 mm}"), "1 mm", "rig.load.fit: a fit of 1000 um is beyond 100 um (is the unit right?)"),
        (f"load_across: 10 N\n{BENT}", "10 N", "load_across: `by: point` gives the ring forces along the load line alone (leave it out, or say `by: points` or `by: housing`)"),
        # of what is swept, the value
        (f"{HOUSED}\nsweep: {{rig.load.by: [housing, point]}}", "point]", "rig.load.by: `by: point` has no `stiffness` (leave it out, or say `by: housing`; a sweep takes all of `rig.load`)"),
        (f"{BENT}\nsweep: {{rig.load.by: [point, housing]}}", "housing]", "rig.load.by: `by: housing` needs `stiffness` (say `stiffness: 1e10 N/m/m`)"),
        (f"{HOUSED}\nsweep: {{rig.load.stiffness: [1e9 N/m/m, 1e15 N/m/m]}}", "1e15", "rig.load.stiffness: a housing of 1e15 N/m/m holds the ring as a rigid one (take a rigid ring, or at most 1e13 N/m/m)"),
        ("rig: {bracket_stiffness: 0 N/m}\nsweep: {rig.ring.bends: [true, false]}", "false]", "rig.ring.bends: a rigid ring needs a bracket (say `1e7 N/m`, or `ring: {bends: true}`)"),
        (f"{BENT}\nsweep: {{model: [static, ring]}}", "ring]", "model: the ring model cannot do this: `rig.ring` bends the outer ring, which `static` and `rollers` know (the least that can is `model: static`)"),
        *((f"{BENT}\nmodel: {model}", "{bends", f"rig.ring: the {model} model cannot do this: `rig.ring` bends the outer ring, which `static` and `rollers` know (the least that can is `model: static`)") for model in ("impulse", "ring", "planar", "spatial")),
        *((f"{BENT}\nmethod: {name}", name, f"method: `{name}` solves with derivatives, which a ring that bends does not have (leave `method` out, or take an explicit one)") for name, method in METHODS.items() if method.implicit),
    ],
)  # fmt: skip
def test_a_mistake_is_one_message_at_its_place(write: Write, said: str, caret: str, message: str) -> None:
    path = write(f"{BASE}{said}\n")
    with pytest.raises(StudyError) as caught:
        load_study(path)
    (found,) = caught.value.problems
    first, source, pointer = str(found).splitlines()
    assert first == f"{path}:{found.line}:{found.column}: {message}"
    assert source[pointer.index("^") :].startswith(caret)


def test_the_command_shows_it_and_fails(write: Write) -> None:
    path = write(f"{BASE}{loaded('{by: pads}')}\n")
    out, told = type_("check", path, code=2)
    first, source, pointer = told.splitlines()
    assert out == ""
    assert first == f"{path}:6:39: rig.load.by: `by: pads` needs `angles` (say `angles: [-45 deg, 45 deg]`)"
    assert source[pointer.index("^") :] == "pads}}"


# Sweeps and ids


def test_a_bracket_without_stiffness_goes_with_a_ring_that_bends(write: Write) -> None:
    (case,) = cases(write, "rig: {bracket_stiffness: 0 N/m, ring: {bends: true}}")
    assert case.rig.bracket_stiffness == 0.0


@pytest.mark.parametrize(
    ("said", "count"),
    [
        ("sweep: {rig.ring.bends: [true, false]}", 2),
        (f"{HOUSED}\nsweep: {{rig.ring.bends: [true, false]}}", 2),
        (f"{HOUSED}\nsweep: {{rig.load.stiffness: [1e9 N/m/m, 1e10 N/m/m]}}", 2),
        # a rigid ring is one case, whatever the housing
        (f"{HOUSED}\nsweep: {{rig.ring.bends: [true, false], rig.load.stiffness: [1e9 N/m/m, 1e10 N/m/m]}}", 3),
        ("rig: bvt5\nsweep: {rig.sensor.angle: [0 deg, 10 deg]}", 2),
        (f"{BENT}\nsweep: {{rig.load: [{{by: point}}, {{by: pads, angles: [-45 deg, 45 deg]}}, {{by: housing, stiffness: 1e10 N/m/m}}]}}", 3),
        (f"{HOUSED}\nsweep: {{rig.load.by: [housing]}}", 1),
    ],
)  # fmt: skip
def test_what_is_swept_gives_cases_of_their_own(write: Write, said: str, count: int) -> None:
    assert len({case_id(case) for case in cases(write, said)}) == count


@pytest.mark.parametrize(
    "said",
    ["rig: {sensor: {angle: 0 deg}}", "rig: {ring: {bends: false}}", "rig: {sensor: {on: ring}}", "rig: bvt5"],
)
def test_what_does_nothing_does_not_rename_a_rigid_case(write: Write, said: str) -> None:
    assert case_id(cases(write, said)[0]) == case_id(cases(write, "")[0])


def test_a_rigid_case_has_nothing_of_a_ring_in_its_id(write: Write) -> None:
    """So results from before rings could bend keep their names."""
    for said in ("", HOUSED.replace("true", "false"), "rig: {sensor: {angle: 5 deg}}"):
        assert {"ring", "load", "sensor"} & used(cases(write, said)[0])["rig"].keys() == set()


POINTS = "{by: points, at: [{angle: 0 deg, stiffness: 1e8 N/m}, {angle: 30 deg, stiffness: 1e8 N/m}]}"


@pytest.mark.parametrize(
    ("said", "other"),
    [
        (BENT, ""),
        (BENT, "rig: {ring: {harmonics: 12}}"),
        (BENT, "rig: {ring: {damping: 2 %}}"),
        (BENT, "rig: {ring: {section: {height: 6.52 mm}}}"),
        (BENT, "rig: {ring: {section: {width: 23.1 mm}}}"),
        (BENT, BENT.replace("{ring", "{sensor: {angle: 1 deg}, ring")),
        (BENT, loaded("{by: pads, angles: [-45 deg, 45 deg]}")),
        (loaded("{by: pads, angles: [-45 deg, 45 deg]}"), loaded("{by: pads, angles: [-40 deg, 40 deg]}")),
        (loaded(POINTS), loaded(POINTS.replace("30", "31"))),
        (loaded(POINTS), loaded(POINTS.replace("1e8", "2e8"))),
        (loaded(POINTS), loaded(POINTS.replace("]}", "], mass: 2 kg}"))),
        (HOUSED, HOUSED.replace("1e10", "2e10")),
        (HOUSED, HOUSED.replace("N/m/m", "N/m/m, fit: 5 um")),
        (HOUSED, HOUSED.replace("N/m/m", "N/m/m, mass: 2 kg")),
        (HOUSED.replace("true", "true, harmonics: 8"), HOUSED.replace("true}", "true, harmonics: 8}, sensor: {on: housing}")),
    ],
)  # fmt: skip
def test_each_field_of_a_bent_ring_has_an_id_of_its_own(write: Write, said: str, other: str) -> None:
    assert case_id(cases(write, said)[0]) != case_id(cases(write, other)[0])


@pytest.mark.parametrize(
    ("said", "other"),
    [
        (BENT, "rig: {ring: {}}"),
        (BENT, loaded("{by: point}")),
        (BENT, "rig: {ring: {harmonics: 20, damping: 1 %}}"),
        (HOUSED, HOUSED.replace("N/m/m", "N/m/m, fit: 0 um, mass: 1 kg")),
    ],
)
def test_a_default_that_is_written_names_the_same_result(write: Write, said: str, other: str) -> None:
    assert case_id(cases(write, said)[0]) == case_id(cases(write, other)[0])


def test_the_material_of_a_bent_ring_counts(write: Write) -> None:
    (case,) = cases(write, BENT)
    material = case.bearing.material.model_copy(update={"young_modulus": 1e11})
    changed = case.model_copy(update={"bearing": case.bearing.model_copy(update={"material": material})})
    assert case_id(changed) != case_id(case)


def test_the_schema_knows_it() -> None:
    known = json_schema()["$defs"]
    assert {"ring", "load", "sensor", "sensor_angle"} <= known["Rig"]["properties"].keys()
    assert known["RingLoad"]["properties"]["by"]["enum"] == ["point", "pads", "points", "housing"]
    assert known["Sensor"]["properties"]["on"]["enum"] == ["ring", "housing"]
    assert known["FlexibleRing"]["additionalProperties"] is False
