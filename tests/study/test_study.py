"""Template of a study, ids of its cases, schema and dimensions of paths."""

import json
import math
import subprocess
import sys
from fractions import Fraction
from typing import Any, get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bearingsim.config import Cage, Case, Drag, StaticDynamic
from bearingsim.config.sections.defect import Shape
from bearingsim.errors import Refused
from bearingsim.simulation import choice
from bearingsim.study import NEW_STUDY, case_id, dimension, json_schema, load_study
from bearingsim.study.jobs import identity
from tests.scenes.study_text import Write


def test_the_template_is_a_good_study(write: Write) -> None:
    study = load_study(write(NEW_STUDY))
    assert (study.name, study.quick, study.text) == ("defect-length", False, NEW_STUDY)
    assert len(study.cases()) == 12
    assert len(study.jobs()) == 12 + 3
    assert study.units == {"defect.length": "mm", "load": "N"}
    assert [(f.y, f.x, f.by) for f in study.figures] == [(("velocity@BPFO",), "defect.length", ("load",))]


def test_commented_lines_of_template_are_defaults(write: Write) -> None:
    text = NEW_STUDY
    keys = ("rig", "clearance", "excitation", "model", "method", "step", "settle", "sampling", "gravity", "seed")
    for key in keys:
        text = text.replace(f"\n# {key}:", f"\n{key}:")
    text = text.replace("# contact:\n#   stiffness", "contact:\n  stiffness").replace(
        "\n#   damping", "\n  damping"
    )
    text = text.replace("\n  # offset:", "\n  offset:")
    assert text.count("#") < NEW_STUDY.count("#")
    assert load_study(write(text)).cases() == load_study(write(NEW_STUDY)).cases()


@pytest.mark.parametrize("which", [0, 1])
def test_zip_lines_of_the_template_are_valid(write: Write, which: int) -> None:
    head, *ends = NEW_STUDY.split("\n  # zip:")
    parts = [head, *("\n  # zip:" + end for end in ends)]
    parts[1 + which] = parts[1 + which].replace("\n  # zip:", "\n  zip:")
    assert len(load_study(write("".join(parts))).cases()) == 12 * (2, 3)[which]


def test_planar_lines_of_the_template_are_valid(write: Write) -> None:
    text = NEW_STUDY.replace("\n# model: rollers", "\nmodel: reference")
    for key in ("friction", "cage", "drag", "ramp", "shaft", "unbalance"):
        text = text.replace(f"\n# {key}:", f"\n{key}:")
    test_case = load_study(write(text)).cases()[0]
    assert (test_case.model, test_case.friction, test_case.cage) == ("planar", StaticDynamic(), Cage())
    assert test_case.drag == Drag()
    assert None not in (test_case.ramp, test_case.shaft, test_case.unbalance)


def test_spatial_lines_of_the_template_are_valid(write: Write) -> None:
    text = NEW_STUDY.replace("\n# model: rollers", "\nmodel: reference")
    for key in ("misalignment", "  offset", "  edge"):
        text = text.replace(f"\n# {key}:", f"\n{key}:").replace(f"\n  # {key.strip()}:", f"\n  {key.strip()}:")
    test_case = load_study(write(text)).cases()[0]
    assert test_case.model == "spatial"
    assert test_case.misalignment is not None
    assert test_case.defects[0].edge is not None


# Ids


PLANAR = {"model": "planar"}
HEAVY = {"contact": {"damping": {"chi": "50 s/m"}}}
OF_OLD = HEAVY | {"settle": "50 ms"}


def single_case(**fields: Any) -> Case:
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
        ids.add(case_id(single_case(load=text)))
    assert ids == {case_id(single_case(load=float(load)))}


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
        ({}, {"method": "auto"}),
        ({}, {"contact": {"stiffness": "palmgren"}}),
        ({}, {"excitation": "soft-edge"}),  # nothing to excite
        ({}, {"seed": 3}),  # nothing random
        ({}, {"friction": "none", "drag": "none"}),  # which is so in this model
        ({"clearance": "CN"}, {"clearance": "37.5 um"}),
        ({"model": "planar", "cage": {"motion": "kinematic"}}, {"model": "reference"}),
        (PLANAR, PLANAR | {"friction": "static-dynamic", "cage": {"motion": "free"}}),
        (PLANAR, PLANAR | {"cage": {"radial_pocket_clearance": "0.2 mm"}}),
        ({}, {"start_angle": math.pi / 13}),
        ({"model": "static"}, {"model": "static", "step_check": "strict"}),
        ({}, {"contact": {"damping": {"beta": "0.0025 ms"}}}),
        (HEAVY, {"contact": {"damping": {"law": "hunt-crossley", "chi": "0.05 s/mm"}}}),
        (HEAVY, {"contact": {"damping": "hunt-crossley"}}),
    ],
)
def test_equal_physics_equal_id(first: dict[str, Any], second: dict[str, Any]) -> None:
    assert case_id(single_case(**first)) == case_id(single_case(**second))


@pytest.mark.usefixtures("constant_candidates")
@pytest.mark.parametrize(
    "change",
    [
        {"load": 150.0 * (1 + 1e-10)},
        {"speed": "1801 rpm"},
        {"clearance": "1 um"},
        {"rig": {"sensor_angle": "1 deg"}},
        {"contact": {"damping": {"beta": "2.6 us"}}},
        {"contact": {"damping": {"chi": "2.5e-6 s/m"}}},
        {"contact": {"damping": "hunt-crossley"}},
        {"contact": {"damping": {"law": "film", "viscosity": "30 mPa s"}}},
        {"contact": {"stiffness": "iso16281"}},
        {"contact": {"length_nodes": 7}},
        {"model": "ring"},
        {"method": "rk4"},
        {"step": "1 us"},
        {"tolerance": 1e-5},
        {"step_check": False},  # a step that does not hold is not halved
        {"step_check": "strict"},  # which may refuse what is done else
        {"duration": "2 s"},
        {"settle": "0 s"},
        {"start_angle": "0 deg"},
        {"sampling": "1024 Hz"},
        {"antialias": "false"},
        {"load_across": "1 N"},
        {"model": "planar"},
        {"contact": {"stiffness": "johnson"}},
        {"contact": {"stiffness": {"law": "constant", "coefficient": 3e5, "exponent": 1.1}}},
        {"record": []},
        {"defect": {"shape": "circular", "length": 1e-3, "width": 1e-3, "depth": 1e-3}},
    ],
)
def test_parameters_that_change_the_result_change_the_id(change: dict[str, Any]) -> None:
    assert case_id(single_case(**change)) != case_id(single_case())


@pytest.mark.usefixtures("constant_candidates")
@pytest.mark.parametrize(
    "change",
    [
        {"gravity": True},
        {"seed": 1},
        {"friction": "none"},
        {"friction": {"static": 0.2}},
        {"friction": "traction"},
        {"cage": {"mass": "20 g"}},
        {"cage": {"motion": "kinematic"}},
        {"cage": {"friction": {"static": 0.01}}},
        {"drag": {}},
        {"ramp": {"to": "20 Hz", "time": "1 s"}},
        {"shaft": {"stiffness": "1e8 N/m", "mass": "1 kg"}},
        {"rig": {"torsion_stiffness": "1e4 N m/rad"}},
    ],
)
def test_parameters_of_planar_change_the_id(change: dict[str, Any]) -> None:
    assert case_id(single_case(**PLANAR | change)) != case_id(single_case(**PLANAR))


@pytest.mark.usefixtures("constant_candidates")
def test_race_and_excitation_of_a_defect_change_the_id() -> None:
    defect = {"shape": "circular", "length": 1e-3, "width": 1e-3, "depth": 1e-4}
    roller: dict[str, Any] = {"race": "roller"}
    races = [{"race": "outer"}, {"race": "inner"}, roller, roller | {"roller": 2}]
    ids = {case_id(single_case(defect=defect | race)) for race in races}
    ids |= {case_id(single_case(defect=defect, excitation=word)) for word in ("half-sine-pulse", "soft-edge")}
    impulses = {"defect": defect, "model": "impulse"}
    ids |= {case_id(single_case(**impulses)), case_id(single_case(**impulses, excitation="random-impulses"))}
    ids |= {case_id(single_case(**impulses, excitation="random-impulses", seed=1))}
    assert len(ids) == 9
    assert case_id(single_case(**impulses, seed=1)) == case_id(single_case(**impulses))
    assert case_id(single_case(defect=defect | {"race": "roller"})) == case_id(
        single_case(defect=defect | {"race": "roller", "roller": 1})
    )


@pytest.mark.usefixtures("constant_candidates")
def test_elastic_constants_change_the_id_if_they_are_used() -> None:
    def ids(**fields: Any) -> set[str]:
        materials = [{"density": 7850.0, "young_modulus": modulus} for modulus in (207e9, 100e9)]
        bearing = single_case().bearing.model_dump()
        return {case_id(single_case(bearing=bearing | {"material": material}, **fields)) for material in materials}

    assert len(ids()) == 1
    assert len(ids(contact={"stiffness": "johnson"})) == 2
    assert len(ids(contact={"damping": {"law": "film", "viscosity": "30 mPa s"}})) == 2
    assert len(ids(surfaces={"rollers": {"diameter": {"scatter": 1e-6}}})) == 1
    # a contact averages waviness over its width, which is proportional to E^-1/2
    assert len(ids(surfaces={"outer": {"harmonics": [{"order": 100, "amplitude": 1e-6}]}})) == 2
    assert len(ids(surfaces={"rollers": {"spectrum": {"amplitude": 1e-6}}})) == 2


def test_new_field_at_its_default_keeps_the_id(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ids of the first model version with Verlet, before these fields existed.

    Its damping was chi = 50 s/m by default, and beta = 10 us that of a bare `kraemer`; it settled for 50 ms.
    """
    monkeypatch.setattr("bearingsim.core.MODEL_VERSION", 1)
    defect = {"shape": "circular", "length": 1e-3, "width": 1e-3, "depth": 1e-3}
    assert case_id(single_case(method="verlet", **OF_OLD)) == "974269e6f84a60ad"
    assert case_id(single_case(model="static", **OF_OLD)) == "2510496c4be94656"
    assert case_id(single_case(method="verlet", defect=defect, **OF_OLD)) == "4a0348f94d255097"
    several = {"method": "verlet", "model": "ring", "defects": [defect, defect | {"angle": 1.0}]}
    assert case_id(single_case(**several, **OF_OLD)) == "7f2b9e8f07decf70"
    kraemer = {"stiffness": "iso16281", "damping": {"beta": "10 us"}}
    assert case_id(single_case(method="verlet", contact=kraemer, settle="50 ms")) == "00aa2375f74ec272"


def test_id_depends_on_the_model_version_not_on_names(monkeypatch: pytest.MonkeyPatch) -> None:
    test_case = single_case()
    renamed = test_case.bearing.model_copy(update={"name": "other", "source": "elsewhere"})
    assert case_id(test_case.model_copy(update={"bearing": renamed})) == case_id(test_case)
    before = case_id(test_case)
    monkeypatch.setattr("bearingsim.core.MODEL_VERSION", -1)
    assert case_id(test_case) != before
    assert len(before) == 16
    assert int(before, 16) >= 0


# For editors and other modules


def test_schema_covers_all_keys_of_a_study() -> None:
    schema = json.loads(json.dumps(json_schema()))
    assert schema["required"] == ["study"]
    own = {"study", "sweep", "figures", "quick", "uncertainty", "accuracy", "measured", "defect", "prove"}
    assert own | Case.model_fields.keys() == schema["properties"].keys()
    assert schema["$defs"]["Defect"]["properties"]["shape"]["enum"] == [*get_args(Shape)]
    assert schema["properties"]["friction"]["anyOf"][0]["enum"] == ["static-dynamic", "traction", "none"]
    assert schema["properties"]["drag"]["anyOf"][0]["enum"] == ["none"]
    assert {"zip", "sobol", "morris", "derived", "where", "repeat"} < schema["properties"]["sweep"][
        "properties"
    ].keys()
    assert schema["properties"]["clearance"]["anyOf"][0]["enum"] == ["C2", "CN", "C3", "C4", "C5"]
    assert "palmgren" in schema["$defs"]["Contact"]["properties"]["stiffness"]["anyOf"][0]["enum"]
    assert schema["properties"]["load"]["type"] == "string"
    assert schema["properties"]["load"]["description"].endswith(" Format: a force such as `150 N`.")


def test_dimensions_of_paths() -> None:
    assert dimension("defects.3.length") == "length"
    assert dimension("speed") == "rotation"
    assert dimension("rig.ring_mass") == "mass"
    assert dimension("contact.damping.beta") == "time"
    assert dimension("contact.stiffness") is None
    assert dimension("contact.stiffness.exponent") == "number"
    assert dimension("clearance") == "length"
    assert dimension("ramp.to") == "rotation"
    assert dimension("friction") is None
    assert dimension("friction.static_speed") == "velocity"
    assert dimension("cage.friction.dynamic") == "number"
    assert dimension("cage.pocket_clearance") == "length"
    assert dimension("drag.oil_viscosity") == "viscosity"
    assert dimension("unbalance.mass_radius") == "unbalance"
    assert dimension("rig.torsion_stiffness") == "torsional stiffness"
    assert dimension("bearing.material.young_modulus") == "pressure"
    assert dimension("defects.2.race") is None
    assert dimension("model") is None


def test_id_depends_on_the_candidate_methods(monkeypatch: pytest.MonkeyPatch) -> None:
    """Costs that change the candidates change the result; a named method is the only candidate."""
    case, named = single_case(), single_case(method="verlet")
    before = choice.candidate_methods(case)
    assert before[0] == "verlet"
    assert case_id(case) == identity(case, {"method": before}) != case_id(named)
    monkeypatch.setattr(choice, "candidate_methods", lambda case: before[::-1])
    assert case_id(case) == identity(case, {"method": before[::-1]}) != identity(case, {"method": before})
    assert case_id(named) == identity(named)


def test_a_case_that_is_refused_has_an_id(monkeypatch: pytest.MonkeyPatch) -> None:
    """The case becomes a job, which fails."""

    def refuse(case: Case) -> None:
        raise Refused("nothing holds the ring", "give it a load")

    monkeypatch.setattr(choice, "choose_method", refuse)
    assert case_id(single_case()) == identity(single_case(), {"method": ["auto"]})


def test_reading_a_study_imports_nothing_heavy(write: Write) -> None:
    path = write(NEW_STUDY)
    code = (
        "import sys; from bearingsim.study import load_study; load_study(sys.argv[1]).cases();"
        "print({'numpy', 'numba', 'scipy', 'pandas', 'h5py', 'matplotlib'} & sys.modules.keys())"
    )
    run = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "set()"
