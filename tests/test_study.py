# ruff: noqa: E501 (a table of messages, one line each)
import json
import math
import subprocess
import sys
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bearingsim.config import Case
from bearingsim.study import (
    NEW_STUDY,
    Problem,
    Study,
    StudyError,
    case_id,
    dimension,
    json_schema,
    load_bearing,
    load_study,
)

BASE = """\
study: base
bearing: nf308
speed: 1800 rpm
load: 150 N
defect: {shape: circular, length: 3 mm, width: 0.8 mm, depth: 50 um}
"""

Write = Callable[[str], Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Writes a study file, and gives its path."""

    def to_file(text: str) -> Path:
        path = tmp_path / "study.yaml"
        path.write_text(text, encoding="utf-8")
        return path

    return to_file


def problems(path: Path, overrides: dict[str, str] | None = None, quick: bool = False) -> list[Problem]:
    with pytest.raises(StudyError) as caught:
        load_study(path, overrides, quick)
    return caught.value.problems


def pointed(problem: Problem) -> str:
    """The text at the caret."""
    caret = str(problem).splitlines()[2].index("^")
    return str(problem).splitlines()[1][caret:]


def swept(study: Study) -> list[tuple[float | str, ...]]:
    return [tuple(job.swept.values()) for job in study.jobs() if job.healthy]


# What a good study becomes


def test_the_template_is_a_good_study(write: Write) -> None:
    study = load_study(write(NEW_STUDY))
    assert (study.name, study.quick, study.text) == ("defect-length", False, NEW_STUDY)
    assert len(study.cases()) == 12
    assert len(study.jobs()) == 12 + 3
    assert study.units == {"defect.length": "mm", "load": "N"}
    assert [(f.y, f.x, f.by) for f in study.figures] == [(("velocity@BPFO",), "defect.length", ("load",))]


def test_the_commented_lines_of_the_template_hold_the_defaults(write: Write) -> None:
    said = NEW_STUDY.replace("\n# zip", "\n#   zip")
    for key in ("rig", "clearance", "model", "method", "step", "settle", "sampling"):
        said = said.replace(f"\n# {key}:", f"\n{key}:")
    said = said.replace("# contact:\n#   stiffness", "contact:\n  stiffness").replace(
        "\n#   damping", "\n  damping"
    )
    assert said.count("#") < NEW_STUDY.count("#")
    assert load_study(write(said)).cases() == load_study(write(NEW_STUDY)).cases()


def test_the_last_axis_is_the_fastest(write: Write) -> None:
    study = load_study(write(BASE + "sweep: {load: [150 N, 0.3 kN], defect.length: [1 mm, 2 mm]}\n"))
    assert swept(study) == [(150.0, 0.001), (150.0, 0.002), (300.0, 0.001), (300.0, 0.002)]
    assert [case.load for case in study.cases()] == [150.0, 150.0, 300.0, 300.0]
    assert [case.defects[0].length for case in study.cases()] == [0.001, 0.002, 0.001, 0.002]


def test_zip_moves_paths_together(write: Write) -> None:
    text = BASE + "sweep: {zip: {load: [150 N, 300 N], speed: [30 Hz, 1200 rpm]}, model: [ring, rollers]}\n"
    rows = swept(load_study(write(text)))
    speeds = [30 * 2 * math.pi, 40 * math.pi]
    pairs = list(zip([150.0, 300.0], speeds, strict=True))
    assert rows == [(load, speed, model) for load, speed in pairs for model in ("ring", "rollers")]


def test_several_zips_multiply(write: Write) -> None:
    text = BASE + (
        "sweep:\n  zip:\n"
        "    - {load: [1 N, 2 N], clearance: [0 um, 1 um]}\n"
        "    - {defect.width: [1 mm, 2 mm], defect.depth: [1 um, 2 um]}\n"
    )
    assert [row[0::2] for row in swept(load_study(write(text)))] == [
        (1.0, 0.001),
        (1.0, 0.002),
        (2.0, 0.001),
        (2.0, 0.002),
    ]


@pytest.mark.parametrize(
    ("entry", "values"),
    [
        ("load: {linspace: [150 N, 300 N, 4]}", [150.0, 200.0, 250.0, 300.0]),
        ("load: {linspace: [100 N, 0.2 kN, 3]}", [100.0, 150.0, 200.0]),
        ("load: {logspace: [1 N, 100 N, 3]}", [1.0, 10.0, 100.0]),
        ("load: {range: [100 N, 250 N, 60 N]}", [100.0, 160.0, 220.0]),
        ("load: {range: [0.1 N, 0.3 N, 0.1 N]}", [0.1, 0.2, 0.3]),
        ("load: {range: [300 N, 100 N, -100 N]}", [300.0, 200.0, 100.0]),
        ("contact.damping.chi: {linspace: [0 s/m, 50 s/m, 2]}", [0.0, 50.0]),
        ("contact.length_nodes: [2, 4]", [2.0, 4.0]),
        ("contact.stiffness: [palmgren, iso16281]", ["palmgren", "iso16281"]),
        ("step: [auto, 0.5 us]", ["auto", 5e-7]),
        ("antialias: [true, false]", ["true", "false"]),
        ("bearing.roller_length: [10 mm, 12 mm]", [0.010, 0.012]),
        ("rig.sensor_angle: [0 rad, 1 rad]", [0.0, 1.0]),
    ],
)
def test_what_an_entry_sweeps(write: Write, entry: str, values: list[float | str]) -> None:
    assert [row[0] for row in swept(load_study(write(BASE + f"sweep: {{{entry}}}\n")))] == values


def test_linspace_takes_an_inner_value_as_if_it_were_written(write: Write) -> None:
    spaced = load_study(write(BASE + "sweep: {defect.depth: {linspace: [0.1 um, 0.7 um, 7]}}\n"))
    listed = BASE + "sweep: {defect.depth: [0.1 um, 0.2 um, 0.3 um, 0.4 um, 0.5 um, 0.6 um, 0.7 um]}\n"
    assert spaced.cases() == load_study(write(listed)).cases()


def test_a_whole_section_can_be_swept_and_its_parts_too(write: Write) -> None:
    text = BASE + (
        "sweep:\n  contact.damping.chi: [5 s/m, 50 s/m]\n  defect.length: [1 mm]\n"
        "  defect:\n    - {shape: circular, length: 3 mm, width: 1 mm, depth: 1 um}\n"
        "    - {shape: triangular, length: 3 mm, width: 1 mm, depth: 1 um}\n"
    )
    study = load_study(write(text))
    assert [case.defects[0].shape for case in study.cases()] == ["circular", "triangular"] * 2
    assert {case.defects[0].length for case in study.cases()} == {0.001}
    assert study.units["defect"] == ""
    assert study.jobs()[0].swept["defect"] == "{shape: circular, length: 3 mm, width: 1 mm, depth: 1 um}"


def test_damping_laws_by_name(write: Write) -> None:
    text = BASE + "contact: {damping: kraemer}\nsweep: {contact.damping.beta: [10 us, 20 us]}\n"
    assert [row[0] for row in swept(load_study(write(text)))] == [1e-5, 2e-5]
    text = BASE + "sweep: {contact.damping: [hunt-crossley, kraemer]}\n"
    assert [case.contact.damping.law for case in load_study(write(text)).cases()] == ["hunt-crossley", "kraemer"]


def test_several_defects_are_counted_from_one(write: Write) -> None:
    text = BASE.replace("defect: {", "defects:\n  - &pit {").rstrip() + (
        "\n  - {shape: circular, length: 3 mm, width: 1 mm, depth: 50 um, angle: 40 deg}\n"
        "sweep: {defects.2.width: [1 mm, 2 mm]}\n"
    )
    assert [[d.width for d in case.defects] for case in load_study(write(text)).cases()] == [
        [0.0008, 0.001],
        [0.0008, 0.002],
    ]


def test_a_value_may_stand_in_the_sweep_alone(write: Write) -> None:
    text = BASE.replace("load: 150 N\n", "") + "sweep: {load: [1 N, 2 N]}\n"
    assert [case.load for case in load_study(write(text)).cases()] == [1.0, 2.0]


def test_scalars_stay_text(write: Write) -> None:
    text = BASE + "contact: {damping: {law: general, coefficient: 1e-3, indentation_exponent: 2}}\n"
    damping = load_study(write(text)).cases()[0].contact.damping.model_dump()
    assert damping["coefficient"] == 0.001


def test_equal_cases_are_kept_once(write: Write) -> None:
    study = load_study(write(BASE + "sweep: {load: [150 N, 0.15 kN, 200 N]}\n"))
    assert [case.load for case in study.cases()] == [150.0, 200.0]


# Twins


def test_twins_are_shared_and_come_last(write: Write) -> None:
    jobs = load_study(write(BASE + "sweep: {load: [1 N, 2 N], defect.length: [1 mm, 2 mm]}\n")).jobs()
    assert len({job.id for job in jobs}) == len(jobs) == 6
    twins = jobs[4:]
    assert [job.swept for job in twins] == [{"load": 1.0}, {"load": 2.0}]
    assert all(job.healthy is None and job.case.defects == () for job in twins)
    assert [job.healthy for job in jobs[:4]] == [twins[0].id, twins[0].id, twins[1].id, twins[1].id]
    assert all(job.id == case_id(job.case) for job in jobs)
    for job in jobs[:4]:
        assert job.case.model_copy(update={"defects": ()}) in [twin.case for twin in twins]


def test_a_healthy_bearing_has_no_twin(write: Write) -> None:
    text = BASE.replace("defect:", "# defect:") + "sweep: {load: [1 N, 2 N]}\n"
    assert [(job.swept, job.healthy) for job in load_study(write(text)).jobs()] == [
        ({"load": 1.0}, None),
        ({"load": 2.0}, None),
    ]


# Ids


def one(**fields: Any) -> Case:
    base = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N"}
    return Case.model_validate(base | fields)


@given(st.integers(1, 10**13), st.integers(-13, -9), st.integers(-9, 3), st.integers(-9, 3))
def test_the_same_quantity_in_another_unit_has_the_same_id(
    digits: int, power: int, first: int, second: int
) -> None:
    load = Fraction(digits) * Fraction(10) ** power
    words = {"N": 0, "kN": 3}
    ids = set()
    for (word, shift), exponent in zip(words.items(), (first, second), strict=True):
        mantissa = Fraction(digits) * Fraction(10) ** (power - shift - exponent)
        text = f"{digits}e{power - shift} {word}" if exponent > 0 else f"{_decimal(mantissa)}e{exponent} {word}"
        ids.add(case_id(one(load=text)))
    assert ids == {case_id(one(load=float(load)))}


def _decimal(value: Fraction) -> str:
    """A decimal fraction, written out."""
    places = 0
    while (value * 10**places).denominator != 1:
        places += 1
    text = str(int(value * 10**places)).rjust(places + 1, "0")
    return f"{text[:-places]}.{text[-places:]}" if places else text


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ({"clearance": "0.02 mm"}, {"clearance": "20 um"}),
        ({"speed": "1800 rpm"}, {"speed": "30 Hz"}),
        ({"speed": "1800 rpm"}, {"speed": "10800 deg/s"}),
        ({"record": ["ring.velocity", "ring.displacement"]}, {"record": ["ring.displacement", "ring.velocity"]}),
        ({"clearance": 0.0}, {"clearance": -0.0}),
        ({"load": 150.0}, {"load": 150.0 * (1 + 1e-15)}),
        ({}, {"method": "verlet"}),
        ({}, {"start_angle": math.pi / 13}),
        ({}, {"contact": {"damping": {"law": "hunt-crossley", "chi": "0.05 s/mm"}}}),
    ],
)
def test_equal_physics_equal_id(first: dict[str, Any], second: dict[str, Any]) -> None:
    assert case_id(one(**first)) == case_id(one(**second))


@pytest.mark.parametrize(
    "change",
    [
        {"load": 150.0 * (1 + 1e-10)},
        {"speed": "1801 rpm"},
        {"clearance": "1 um"},
        {"rig": {"sensor_angle": "1 deg"}},
        {"contact": {"damping": {"chi": "51 s/m"}}},
        {"contact": {"damping": "kraemer"}},
        {"contact": {"stiffness": "iso16281"}},
        {"contact": {"length_nodes": 7}},
        {"model": "ring"},
        {"method": "rk4"},
        {"step": "1 us"},
        {"duration": "2 s"},
        {"settle": "0 s"},
        {"start_angle": "0 deg"},
        {"sampling": "1024 Hz"},
        {"antialias": "false"},
        {"record": []},
        {"defect": {"shape": "circular", "length": 1e-3, "width": 1e-3, "depth": 1e-3}},
    ],
)
def test_whatever_shapes_the_result_shapes_the_id(change: dict[str, Any]) -> None:
    assert case_id(one(**change)) != case_id(one())


def test_names_do_not_shape_the_id_but_the_models_version_does(monkeypatch: pytest.MonkeyPatch) -> None:
    found = one()
    renamed = found.bearing.model_copy(update={"name": "other", "source": "elsewhere"})
    assert case_id(found.model_copy(update={"bearing": renamed})) == case_id(found)
    before = case_id(found)
    monkeypatch.setattr("bearingsim.core.MODEL_VERSION", -1)
    assert case_id(found) != before
    assert len(before) == 16
    assert int(before, 16) >= 0


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.integers(1, 4), min_size=1, max_size=4), st.integers(1, 3))
def test_the_product_has_the_size_of_its_factors(write: Write, sizes: list[int], zipped: int) -> None:
    paths = ["load: [{}]", "defect.length: [{}]", "clearance: [{}]", "settle: [{}]"]
    units = ["N", "mm", "um", "ms"]
    entries = [
        path.format(", ".join(f"{k + 1} {unit}" for k in range(size)))
        for path, unit, size in zip(paths, units, sizes, strict=False)
    ]
    pairs = ", ".join(f"{k + 1} deg" for k in range(zipped)), ", ".join(f"{k + 1} s" for k in range(zipped))
    entries.append("zip: {{defect.angle: [{}], duration: [{}]}}".format(*pairs))
    study = load_study(write(BASE + "sweep: {" + ", ".join(entries) + "}\n"))
    assert len(study.cases()) == math.prod(sizes) * zipped
    assert len({case_id(case) for case in study.cases()}) == len(study.cases())


# Quick and overrides

SWEPT = BASE + (
    "sweep: {load: [1 N, 2 N, 3 N], zip: {defect.width: [1 mm, 2 mm], defect.depth: [1 um, 2 um]}}\n"
    "figures: [{y: velocity@BPFO, x: load, by: defect.width}]\n"
    "quick: {duration: 0.3 s, sweep: {load: [2 N], zip: {defect.width: [3 mm, 4 mm], clearance: [0 um, 1 um]}}}\n"
)


def test_quick_takes_the_reduced_grid(write: Write) -> None:
    path = write(SWEPT)
    assert len(load_study(path).cases()) == 6
    study = load_study(path, quick=True)
    assert study.quick
    assert swept(study) == [(2.0, 0.003, 0.0), (2.0, 0.004, 1e-6)]
    assert {case.duration for case in study.cases()} == {0.3}
    assert {case.defects[0].depth for case in study.cases()} == {5e-5}


@pytest.mark.parametrize(
    ("overrides", "loads", "widths"),
    [
        ({"load": "7 N"}, {7.0}, {0.001, 0.002}),
        ({"load": "[7 N, 8 N]"}, {7.0, 8.0}, {0.001, 0.002}),
        ({"load": "{linspace: [7 N, 9 N, 3]}"}, {7.0, 8.0, 9.0}, {0.001, 0.002}),
        ({"defect.width": "5 mm"}, {1.0, 2.0, 3.0}, {0.005}),
        ({"defect.width": "5 mm", "load": "7 N"}, {7.0}, {0.005}),
    ],
)
def test_an_override_replaces_a_sweep(
    write: Write, overrides: dict[str, str], loads: set[float], widths: set[float]
) -> None:
    study = load_study(write(SWEPT), overrides)
    assert {case.load for case in study.cases()} == loads
    assert {case.defects[0].width for case in study.cases()} == widths
    assert {case.defects[0].depth for case in study.cases()} == {1e-6, 2e-6}
    assert all({"load", "defect.width"} <= job.swept.keys() for job in study.jobs() if job.healthy)
    assert study.overrides == overrides


def test_an_override_keeps_its_axis_in_place(write: Write) -> None:
    study = load_study(write(SWEPT), {"load": "[7 N, 8 N]"})
    assert list(study.units) == ["load", "defect.width", "defect.depth"]
    assert [row[0] for row in swept(study)] == [7.0, 7.0, 8.0, 8.0]


def test_an_override_of_what_is_not_swept(write: Write) -> None:
    overrides = {
        "duration": "2 s",
        "record": "[ring.velocity, roller.outer_force]",
        "bearing.roller_length": "9 mm",
    }
    study = load_study(write(SWEPT), overrides)
    case = study.cases()[0]
    assert (case.duration, len(case.record), case.bearing.roller_length) == (2.0, 2, 0.009)
    assert "duration" not in study.jobs()[0].swept
    assert len(load_study(write(SWEPT), {"speed": "[20 Hz, 30 Hz]"}).cases()) == 12


# What a bad study is told


@pytest.mark.parametrize(
    ("line", "caret", "message"),
    [
        ("load: 150", "150", "load: expected a force such as `150 N`, got `150` (the unit is missing)"),
        ("load: 150 mm", "150 mm", "load: expected a force such as `150 N`, got `150 mm` (`mm` is a unit of length)"),
        ("load: 150 n", "150 n", "load: expected a force such as `150 N`, got `150 n` (did you mean `N`?)"),
        ("load:", None, "load: expected a force such as `150 N`, got `` (nothing is written)"),
        ("load: nan N", "nan N", "load: expected a force such as `150 N`, got `nan N` (the number must be finite)"),
        ("load: 12:30:45", "12:30:45", "load: expected a force such as `150 N`, got `12:30:45` (units: N, kN)"),
        ("clearance: 0,2 mm", "0,2 mm", "clearance: expected a length such as `0.8 mm`, got `0,2 mm` (write a decimal point)"),
        ("lod: 150 N", "lod", "unknown key `lod` (did you mean `load`?)"),
        ("speed: 1 rpm", "speed: 1", "the key `speed` is given twice, first on line 3"),
        ("antialias: no", "no", "antialias: expected `true` or `false`, got `no`"),
        ("model: roller", "roller", "model: expected `static`, `ring` or `rollers`, got `roller` (did you mean `rollers`?)"),
        ("duration: 1 ms", "1 ms", "duration: 1 ms is shorter than one ball pass (6.28931 ms)"),
        ("rig: bvt", "bvt", "rig: no rig `bvt` (did you mean `bvt5`?)"),
        ("rig: {sensor: 0 deg}", "sensor:", "rig: unknown key `sensor` (did you mean `sensor_angle`?)"),
        ("contact: {damping: {law: kraemer, chi: 5 s/m}}", "chi", "contact.damping: unknown key `chi` (known: law, beta)"),
        ("contact: {damping: {law: general, coefficient: 1}}", "damping", "contact.damping: `indentation_exponent` is missing (expected a plain number such as `1.5`)"),
        ("record: [ring.velocty]", "ring.velocty", "record: expected `ring.displacement`, `ring.velocity`, `ring.acceleration`, `roller.outer_force` or `roller.inner_force`, got `ring.velocty` (did you mean `ring.velocity`?)"),
        ("record: ring.velocity", "ring.velocity", "record: expected a list such as `[a, b]`"),
        ("record: !!python/object:os.system x", "!!python", None),
        ("load: [150 N", None, "not valid YAML: expected ',' or ']', but got '<stream end>'"),
        ("defects: []", None, "say `defect` (one mapping) or `defects` (a list), not both"),
        ("sweep: {defect.lenght: [1 mm]}", "defect.lenght", "no such path `defect.lenght` (did you mean `defect.length`?)"),
        ("sweep: {defects.2.length: [1 mm]}", "defects.2", "there is no defect 2 (the study has 1, counted from 1)"),
        ("sweep: {load: [1 N, 2 mm]}", "2 mm]", "load: expected a force such as `150 N`, got `2 mm` (`mm` is a unit of length)"),
        ("sweep: {load: [1 N, 0,2 N]}", "0,2 N]", "load: expected a force such as `150 N`, got `0,2 N` (write a decimal point)"),
        ("sweep: {load: [[1 N]]}", "[1 N]]", "load: expected a force such as `150 N`, got a list"),
        ("sweep: {load: []}", "[]", "sweep.load: the list is empty"),
        ("sweep: {load: 1 N}", "1 N", "sweep.load: expected a list, or `linspace`, `logspace` or `range` with three numbers (write `[1 N]`)"),
        ("sweep: {load: {linspce: [1 N, 2 N, 3]}}", "{linspce", "sweep.load: expected a list, or `linspace`, `logspace` or `range` with three numbers (did you mean `linspace`?)"),
        ("sweep: {load: {linspace: [1 N, 2 N]}}", "[1 N", "sweep.load: expected three values, as in `linspace: [150 N, 300 N, 4]`"),
        ("sweep: {load: {linspace: [1 N, 2 mm, 3]}}", "2 mm", "sweep.load: expected the unit `N` as in the first value, got `2 mm`"),
        ("sweep: {load: {linspace: [1 mm, 2 mm, 3]}}", "1 mm", None),
        ("sweep: {load: {linspace: [1 N, 2 N, 1]}}", "1]", "sweep.load: expected the number of values, from 2 to 100000, got `1`"),
        ("sweep: {load: {logspace: [0 N, 2 N, 3]}}", "0 N", "sweep.load: logspace needs values above zero"),
        ("sweep: {load: {range: [1 N, 2 N, 0 N]}}", "0 N", "sweep.load: a step of `0 N` does not lead from `1 N` to `2 N`"),
        ("sweep: {zip: {load: [1 N, 2 N], settle: [1 ms]}}", "load", "zip: lists of unequal length (`load` has 2, `settle` has 1)"),
        ("sweep: {load: [1 N], zip: {load: [1 N], settle: [1 s]}}", "load: [1 N], settle", "`load` is swept twice"),
        ("sweep: {load: [1 N], defect.width: [1 mm], defects.1.width: [1 mm]}", "defects.1", "`defects.1.width` is swept twice"),
        ("sweep: {defect.length: [3 mm, 13 mm], load: [1 N, 2 N]}", "13 mm", "defect.length: a defect of 13 mm is longer than the roller (12 mm)"),
        ("sweep: {speed: [1800 rpm, 1 rpm]}", "1 rpm]", "speed: 1000 ms is shorter than one ball pass (11320.8 ms)"),
        ("sweep: {model: [rollers, static]}\nmethod: rk4", "static]", "model: the static model has no method, got `rk4` (leave it out)"),
        ("figures: {y: velocity@BPFO}", "{y", "figures: expected a list such as `[{y: velocity@BPFO, x: load}]`"),
        ("figures: [{y: velocity@BPFO}]", "{y", "figures: `x` is missing"),
        ("figures: [{y: velocity@BPF0, x: load}]\nsweep: {load: [1 N]}", "velocity@BPF0", "figures.y: no feature `velocity@BPF0` (did you mean `velocity@BPFO`?)"),
        ("figures: [{y: velocity@BPFO, x: lod}]\nsweep: {load: [1 N]}", "lod", "figures.x: no swept path `lod` (did you mean `load`?)"),
        ("figures: [{y: velocity@BPFO, x: load, bye: a}]\nsweep: {load: [1 N]}", "bye", "figures: no key `bye` (did you mean `by`?)"),
        ("quick: {durtion: 1 s}", "durtion", "no such path `durtion` (did you mean `duration`?)"),
        ("quick: {sweep: {load: [1 mm]}}", "1 mm", "load: expected a force such as `150 N`, got `1 mm` (`mm` is a unit of length)"),
        ("quick: 3", "3", "quick: expected a mapping such as `{duration: 0.3 s, sweep: {load: [150 N]}}`"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_message_at_its_place(
    write: Write, line: str, caret: str | None, message: str | None
) -> None:
    key = line.split(":")[0]
    kept = [old for old in BASE.splitlines() if key == "speed" or not old.startswith(f"{key}:")]
    path = write("\n".join([*kept, line, ""]))
    found = problems(path)
    assert len({(p.line, p.message) for p in found}) == (1 if message else len(found))
    shown = str(found[0]).splitlines()
    if message:
        assert shown[0] == f"{path}:{found[0].line}:{found[0].column}: {message}"
    if caret:
        assert pointed(found[0]).startswith(caret)
    assert shown[1].removeprefix("    ") == path.read_text().splitlines()[found[0].line - 1]


@pytest.mark.parametrize(
    ("defect", "caret", "message"),
    [
        ("shape: cirular", "cirular", "defect.shape: expected `rectangular`, `triangular` or `circular`, got `cirular` (did you mean `circular`?)"),
        ("width: 0,8 mm", "0,8 mm", "defect.width: expected a length such as `0.8 mm`, got `0,8 mm` (write a decimal point)"),
        ("width: -0.8 mm", "-0.8 mm", "defect.width: expected a length above zero, such as `0.8 mm`, got `-0.8 mm`"),
        ("width: 5 deg", "5 deg", "defect.width: expected a length such as `0.8 mm`, got `5 deg` (`deg` is a unit of angle)"),
        ("length: 13 mm", "13 mm", "defect.length: a defect of 13 mm is longer than the roller (12 mm)"),
        ("width: 19 mm", "19 mm", "defect.width: a defect of 19 mm is wider than the roller spacing (18.6079 mm)"),
        ("lenght: 3 mm", "lenght", "defect: unknown key `lenght` (did you mean `length`?)"),
        ("angle: .nan deg", ".nan deg", "defect.angle: expected an angle such as `5 deg`, got `.nan deg` (the number must be finite)"),
    ],
)  # fmt: skip
def test_a_mistake_in_a_defect(write: Write, defect: str, caret: str, message: str) -> None:
    parts = ["shape: circular", "length: 3 mm", "width: 0.8 mm", "depth: 50 um"]
    key = defect.split(":")[0]
    kept = [part for part in parts if not part.startswith(f"{key}:")]
    path = write("\n".join([*BASE.splitlines()[:4], "defect: {" + ", ".join([*kept, defect]) + "}", ""]))
    (found,) = problems(path)
    assert str(found).splitlines()[0] == f"{path}:5:{found.column}: {message}"
    assert pointed(found).startswith(caret)


def test_everything_wrong_is_told_at_once(write: Write) -> None:
    path = write("""\
study: two words
bearing: nf308
speed: 1800
speed: 1800 rpm
lod: 150 N
defects:
  - {shape: circle, length: 13 mm, width: -1 mm, depth: 0,2 mm}
  - {shape: circular, length: 3 mm, width: 1 mm, depth: 1 um, angle: 40 deg}
  - {shape: circular, length: 3 mm, width: 1 mm, depth: 1 um, angle: 40 deg}
clearance: nan mm
duration: 1 N
sweep: {defects.1.lenght: [1 mm], settle: [1 s, 2 mm]}
figures: [{y: velocity@BPFO, x: load}]
quick: {sweep: {model: [rigid]}}
""")
    told = "\n".join(map(str, problems(path, {"foo": "1"})))
    for part in [
        "1:8: study: expected a name",
        "3:8: speed: expected a rotation speed",
        "4:1: the key `speed` is given twice",
        "`load` is missing (expected a force such as `150 N`)",
        "5:1: unknown key `lod`",
        "7:13: defects.1.shape: expected",
        "7:29: defects.1.length: a defect of 13 mm is longer",
        "7:43: defects.1.width: expected a length above zero",
        "7:57: defects.1.depth: expected a length such as `0.8 mm`, got `0,2 mm` (write a decimal point)",
        "9:70: defects.3.angle: overlaps defect 2",
        "10:12: clearance: ",
        "11:11: duration: ",
        "12:9: no such path `defects.1.lenght`",
        "12:49: settle: expected a time",
        "13:33: figures.x: no swept path `load`",
        "14:25: model: expected",
        "command line: no such path `foo`",
    ]:
        assert part in told
    assert told.count("^") == 17


@pytest.mark.parametrize(
    ("text", "count"),
    [
        # a wrong angle does not also overlap the defect at 0 deg
        (
            BASE.replace("defect: ", "defects:\n  - &pit ")
            + "  - {shape: circular, length: 3 mm, width: 1 mm, depth: 1 um, angle: 5 N}\n",
            1,
        ),
        # of the values that a linspace makes, the ends
        (BASE + "sweep: {speed: {linspace: [1 rpm, 4 rpm, 4]}}\n", 2),
        # a wrong sweep of what the base does not say
        (BASE.replace("load: 150 N\n", "") + "sweep: {load: 1 N}\n", 1),
        (BASE.replace("load: 150 N\n", "") + "sweep: {zip: {load: [1 N], settle: [1 s, 2 s]}}\n", 1),
    ],
)
def test_a_mistake_has_no_echo(write: Write, text: str, count: int) -> None:
    assert len(problems(write(text))) == count


def test_a_mistake_in_a_bearings_file_is_shown_there(write: Write, tmp_path: Path) -> None:
    bearing = Path(__file__).parents[1] / "configs" / "bearings" / "nf308.yaml"
    own = tmp_path / "own.yaml"
    text = bearing.read_text().replace("bore: 40 mm", "bore: 60 mm\nwdth: 1 mm")
    own.write_text(text.replace("rollers: 13", "rollers: 13\nrollers: 14"))
    path = write(BASE.replace("nf308", "own.yaml") + "clearance: 1\n")
    told = problems(path)
    assert [(p.file, p.message) for p in told] == [
        (str(path), "clearance: expected a length such as `0.8 mm`, got `1`"),
        (str(own), "the key `rollers` is given twice, first on line 3"),
        (str(own), "bearing: unknown key `wdth`"),
    ]
    with pytest.raises(StudyError, match="wdth"):
        load_bearing(str(own))
    own.write_text(bearing.read_text().replace("bore: 40 mm", "bore: 60 mm"))
    (found,) = problems(write(BASE.replace("nf308", "own.yaml")))
    assert (found.file, found.message) == (str(own), "bearing.bore: the inner race (53 mm) is inside the bore")
    assert pointed(found).startswith("60 mm")


def test_a_bearing_by_name() -> None:
    assert load_bearing("nf308").rollers == 13
    with pytest.raises(StudyError, match="did you mean `nf308`"):
        load_bearing("nf38")


def test_a_bearings_file_that_is_no_yaml(write: Write, tmp_path: Path) -> None:
    (tmp_path / "own.yaml").write_text("rollers: [13\n")
    found = problems(write(BASE.replace("nf308", "own.yaml")))
    assert [p.file for p in found] == [str(tmp_path / "own.yaml")]


@pytest.mark.parametrize(
    ("override", "shown"),
    [
        ({"load": "15 mm"}, ["    --set load=15 mm", "               ^"]),
        ({"lod": "15 N"}, ["    --set lod=15 N", "          ^"]),
        ({"load": "[1 N, 2 mm]"}, ["    --set load=[1 N, 2 mm]", "                     ^"]),
        ({"load": "{a: 1, a: 2}"}, ["    --set load={a: 1, a: 2}", "                      ^"]),
    ],
)
def test_a_mistake_on_the_command_line_is_shown_there(
    write: Write, override: dict[str, str], shown: list[str]
) -> None:
    found = problems(write(BASE), override)
    assert {problem.file for problem in found} == {"command line"}
    assert shown in [str(problem).splitlines()[1:] for problem in found]


@pytest.mark.parametrize(
    ("content", "part"),
    [
        (b"\xff\xfe\x00", "not a text file in UTF-8"),
        (b"- a\n- b\n", "expected `key: value` lines"),
        (b"", "`study` is missing"),
        (b"study: a\n---\nstudy: b\n", "not valid YAML"),
        (b"study: &a [*a]\n", "an alias inside its own anchor"),
        (b"study: a\x00b\n", "not valid YAML"),
        (b"? [a]\n: b\n", "a key must be a word"),
    ],
)
def test_files_that_are_no_studies(tmp_path: Path, content: bytes, part: str) -> None:
    path = tmp_path / "study.yaml"
    path.write_bytes(content)
    assert part in "\n".join(map(str, problems(path)))


def test_a_missing_file(tmp_path: Path) -> None:
    (found,) = problems(tmp_path / "none.yaml")
    assert str(found) == f"{tmp_path / 'none.yaml'}: no such file"


def test_a_sweep_beyond_reason_is_refused(write: Write) -> None:
    thousand = "{linspace: [1 N, 2 N, 1001]}"
    text = BASE + f"sweep: {{load: {thousand}, clearance: {thousand.replace('N', 'um')}}}\n"
    assert "1002001 cases; at most 1000000" in str(problems(write(text))[0])


# For editors and other modules


def test_the_schema_knows_what_a_study_may_say() -> None:
    schema = json.loads(json.dumps(json_schema()))
    assert schema["required"] == ["study"]
    assert {"study", "sweep", "figures", "quick", "defect", *Case.model_fields} == schema["properties"].keys()
    assert schema["$defs"]["Defect"]["properties"]["shape"]["enum"] == ["rectangular", "triangular", "circular"]
    assert schema["properties"]["load"]["type"] == "string"
    assert schema["properties"]["load"]["description"] == "a force such as `150 N`"


def test_dimensions_of_paths() -> None:
    assert dimension("defects.3.length") == "length"
    assert dimension("speed") == "rotation"
    assert dimension("rig.ring_mass") == "mass"
    assert dimension("contact.damping.beta") == "time"
    assert dimension("model") is None


def test_reading_a_study_imports_nothing_heavy(write: Write) -> None:
    path = write(NEW_STUDY)
    code = (
        "import sys; from bearingsim.study import load_study; load_study(sys.argv[1]).jobs();"
        "print({'numpy', 'numba', 'scipy', 'pandas', 'h5py', 'matplotlib'} & sys.modules.keys())"
    )
    run = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "set()"
