"""A study's template, the ids of its cases, and what editors and other modules ask of it."""

import json
import math
import subprocess
import sys
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bearingsim.config import Case
from bearingsim.study import NEW_STUDY, case_id, dimension, json_schema, load_study
from tests.study_text import Write


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
