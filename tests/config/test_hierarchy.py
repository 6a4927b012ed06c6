"""Simplest model that meets the requirements of a case, and the reason."""

from itertools import pairwise
from typing import Any

import pytest
from pydantic import ValidationError

from bearingsim.catalogue import MODELS
from bearingsim.config import CHANNELS, Case
from bearingsim.config.rules.hierarchy import needs, reasons, reference_model, simplest_model
from bearingsim.config.sections.free import Cage, Frictionless

DEFECT = {"shape": "rectangular", "length": "3 mm", "width": "0.8 mm", "depth": "50 um"}
SPRUNG = {"axial_stiffness": "1e7 N/m", "tilting_stiffness": "1e4 N m/rad"}


def case(**fields: Any) -> Case:
    return Case.model_validate({"bearing": "nf308", "speed": "1800 rpm", "load": "150 N"} | fields)


def refusals(**fields: Any) -> list[tuple[str, str | None]]:
    with pytest.raises(ValidationError) as caught:
        case(**fields)
    (error,) = caught.value.errors()
    return [(conflict.message, conflict.hint) for conflict in error["ctx"]["conflicts"]]


LINEAR = {"stiffness": {"law": "constant", "coefficient": 1e6, "exponent": 1.0}}
JUMPING = {"law": "general", "coefficient": 1e3, "indentation_exponent": 0.0}
IMPULSES = {"defect": DEFECT, "excitation": "impulse-train"}

LEAST: list[tuple[dict[str, Any], str, str]] = [
    (IMPULSES, "impulse", "`impulse-train` is a force history"),
    (IMPULSES | {"record": ["ring.acceleration"]}, "impulse", "a force history"),
    (IMPULSES | {"excitation": "random-impulses", "seed": 3}, "impulse", "a force history"),
    ({}, "static", "a healthy bearing vibrates due to varying compliance"),
    ({"defect": DEFECT}, "static", "`envelope` needs elastic contacts"),
    ({"defect": DEFECT | {"race": "inner"}}, "static", "`envelope` needs elastic contacts"),
    ({"defect": DEFECT | {"race": "roller"}}, "static", "`envelope` needs elastic contacts"),
    ({"defect": DEFECT, "excitation": "half-sine-pulse"}, "static", "`half-sine-pulse` needs elastic contacts"),
    ({"record": ["roller.2.inner_force"]}, "static", "a contact force is recorded"),
    ({"load_across": "10 N"}, "static", "`load_across` changes the direction of the load"),
    ({"friction": "none", "drag": "none"}, "static", "a healthy bearing"),
    ({"record": ["ring.acceleration"]}, "ring", "acceleration depends on the masses"),
    ({"contact": {"damping": {"chi": "5 s/m"}}}, "ring", "`contact.damping` needs a moving ring"),
    ({"contact": {"damping": JUMPING}}, "ring", "`contact.damping` needs a moving ring"),
    (
        {"defect": DEFECT, "contact": {"damping": JUMPING}},
        "rollers",
        "this damping law needs the mass of the rollers",
    ),
    (
        {"defect": DEFECT, "contact": {"damping": "kraemer"} | LINEAR},
        "rollers",
        "this damping law needs the mass of the rollers",
    ),
    (
        {"defect": DEFECT, "contact": {"damping": "kraemer", "stiffness": "johnson"}},
        "rollers",
        "this damping law needs the mass of the rollers",
    ),
    ({"defect": DEFECT, "contact": {"damping": "kraemer"}}, "ring", "`contact.damping` needs a moving ring"),
    (
        {"defect": DEFECT, "contact": {"damping": JUMPING | {"coefficient": 0.0}}},
        "ring",
        "`contact.damping` needs",
    ),
    (
        {"contact": {"damping": JUMPING | {"indentation_exponent": 1.0}}},
        "ring",
        "`contact.damping` needs a moving ring",
    ),
    ({"defect": DEFECT, "excitation": "pressure-share"}, "ring", "`pressure-share` changes the contact force"),
    ({"defect": DEFECT, "excitation": "soft-edge"}, "ring", "`soft-edge` changes the contact force"),
    ({"defect": DEFECT, "record": ["roller.outer_force"]}, "rollers", "the impact depends on a roller's mass"),
    ({"defect": DEFECT, "record": ["ring.acceleration"]}, "rollers", "the impact depends on a roller's mass"),
    ({"speed": "9000 rpm"}, "rollers", "centrifugal force 109 % of roller load"),
    ({"ramp": {"to": "3000 rpm", "time": "1 s"}}, "planar", "a `ramp` changes the speed"),
    ({"gravity": True}, "planar", "`gravity` needs rollers"),
    ({"friction": "static-dynamic"}, "planar", "`friction` needs rollers that can slip"),
    ({"friction": "traction"}, "planar", "`friction` needs rollers that can slip"),
    ({"cage": {"motion": "kinematic"}}, "planar", "`cage` needs a cage that can move"),
    ({"drag": {}}, "planar", "`drag` needs"),
    ({"shaft": {"stiffness": "1e8 N/m", "mass": "1 kg"}}, "planar", "a `shaft` needs a moving inner ring"),
    ({"rig": {"torsion_stiffness": "1e4 N m/rad"}}, "planar", "lets the outer ring rotate"),
    ({"defect": DEFECT | {"offset": "2 mm"}}, "spatial", "an `offset` tilts the roller"),
    ({"misalignment": {"inner": "0.5 mrad"}}, "spatial", "loads the rollers unevenly"),
    ({"rig": SPRUNG}, "spatial", "lets the outer ring tilt"),
    ({"shaft": {"stiffness": "1e8 N/m", "mass": "1 kg"} | SPRUNG}, "spatial", "lets the inner ring tilt"),
    ({"record": ["roller.2.tilt"]}, "spatial", "the tilt of a roller is recorded"),
    ({"record": ["roller.outer_line_load"]}, "spatial", "the line load of a roller is recorded"),
]


def most_able(fields: dict[str, Any]) -> str:
    """Reference model of a case: `planar` if it is sufficient."""
    able = {model: why for named, model, why in LEAST if named is fields}
    (model,) = able
    return model if model in ("impulse", "spatial") else "planar"


@pytest.mark.parametrize(("fields", "model", "why"), LEAST)
def test_simplest_model_and_reason(fields: dict[str, Any], model: str, why: str) -> None:
    test_case = case(**fields | {"model": most_able(fields)})
    assert simplest_model(test_case) == model
    assert any(why in reason for reason in reasons(test_case))


@pytest.mark.parametrize(("fields", "model", "why"), LEAST)
def test_reference_is_planar_if_it_is_sufficient(fields: dict[str, Any], model: str, why: str) -> None:
    test_case = case(**fields | {"model": "reference"})
    assert test_case.model == most_able(fields)
    assert reference_model(test_case) == test_case.model
    assert test_case.method == (None if test_case.model == "impulse" else "auto")
    assert Case.model_validate(test_case.model_dump()) == test_case


def test_reference_has_slip_only_if_the_case_has_its_keys() -> None:
    silent = case(model="reference")
    assert silent.cage == Cage(motion="kinematic")
    assert silent.friction == Frictionless()
    recorded = ("cage.slip", "roller.skew", "roller.flange_force")
    slipping: list[dict[str, Any]] = [{"friction": "static-dynamic"}, {"drag": {}}]
    for fields in (*slipping, *({"record": [name]} for name in recorded)):
        test_case = case(model="reference", **fields)
        assert test_case.cage == Cage(), fields


def test_reference_of_a_flexible_ring_is_rollers() -> None:
    assert case(model="reference", rig={"ring": {"bends": True}}).model == "rollers"


@pytest.mark.parametrize(("fields", "model", "why"), LEAST)
def test_every_model_above_the_simplest_is_sufficient(fields: dict[str, Any], model: str, why: str) -> None:
    above = [*MODELS][[*MODELS].index(model) :] if model != "impulse" else ("impulse",)
    sliced = "spatial" if fields.get("excitation") == "pressure-share" else ""  # its slices share no pressure
    for higher in (name for name in above if name != sliced):
        assert case(**fields | {"model": higher}).model == higher


@pytest.mark.parametrize(("fields", "model", "why"), [row for row in LEAST if row[1] == "planar"])
def test_keys_of_planar_are_refused_by_simpler_models(fields: dict[str, Any], model: str, why: str) -> None:
    for lower in ("static", "ring", "rollers"):
        ((message, hint),) = refusals(**fields | {"model": lower})
        assert message.startswith(f"the {lower} model cannot do this: ")
        assert why in message
        assert hint == "the simplest one that can is `model: planar`"


@pytest.mark.parametrize(
    ("fields", "messages", "hint"),
    [
        (IMPULSES | {"model": "ring"}, ["`impulse-train` is a force history"], "`model: impulse`"),
        (
            {"defect": DEFECT, "model": "impulse", "excitation": "envelope"},
            ["`envelope` needs"],
            "`model: static`",
        ),
        (
            {"model": "static", "defect": DEFECT, "excitation": "soft-edge"},
            ["`soft-edge` changes"],
            "`model: ring`",
        ),
        (
            IMPULSES | {"model": "impulse", "record": ["roller.outer_force"]},
            ["a contact force is recorded"],
            "no model can compute all of this",
        ),
        (
            IMPULSES | {"model": "impulse", "friction": "traction", "load_across": "1 N"},
            ["`friction` needs", "`load_across` changes"],
            "no model can compute all of this",
        ),
        (
            IMPULSES | {"model": "reference", "gravity": True},
            ["`impulse-train` is a force history"],
            "no model can compute all",
        ),
    ],
)
def test_insufficient_model_is_refused_with_the_simplest_sufficient_one(
    fields: dict[str, Any], messages: list[str], hint: str
) -> None:
    reported = refusals(**fields)
    assert len(reported) == len(messages)
    for (message, advice), part in zip(reported, messages, strict=True):
        assert part in message
        assert hint in str(advice)


def test_inaccurate_model_is_not_refused() -> None:
    test_case = case(model="static", defect=DEFECT, record=["ring.acceleration", "roller.outer_force"])
    assert test_case.model == "static"
    assert simplest_model(test_case) == "rollers"
    assert case(model="ring", speed="9000 rpm").model == "ring"


def test_quality_requirement_is_dropped_if_no_model_meets_it() -> None:
    assert case(**IMPULSES | {"model": "reference", "contact": {"damping": "kraemer"}}).model == "impulse"


def test_defaults_of_planar_are_no_requirements() -> None:
    assert simplest_model(case(model="planar")) == "static"
    assert simplest_model(case(model="planar", friction="none")) == "static"


def test_every_requirement_is_met_by_a_model() -> None:
    abilities = frozenset[str]().union(*(model.abilities for model in MODELS.values()))
    needed = {need.ability for fields, _, _ in LEAST for need in needs(case(**fields | {"model": "reference"}))}
    assert needed <= abilities


def test_each_model_has_the_abilities_of_the_simpler_one() -> None:
    for lower, higher in pairwise([*MODELS.values()][1:]):
        own = {"bending ring"}  # of `static` and `rollers`
        assert lower.abilities - {"balls", "shared pressure"} - own < higher.abilities
        assert lower.abilities - own < higher.abilities or higher.name == "spatial"


STILL = {"ring.rotation": "rig.torsion_stiffness", "inner.displacement": "shaft", "cage.position": "cage.guide"}


@pytest.mark.parametrize("name", [name for name in STILL if name in CHANNELS])
def test_channels_that_remain_zero_are_refused(name: str) -> None:
    ((message, advice),) = refusals(model="planar", record=[name])
    assert message.startswith(f"`{name}` stays zero")
    assert advice == f"give `{STILL[name]}`"


def test_default_impulses_of_a_model_are_no_requirement() -> None:
    """The message can then name the model with these forces."""
    with pytest.raises(ValidationError, match="contact force"):
        case(model="impulse", record=["roller.outer_force"], defect=DEFECT)
    assert "impulses" not in {need.ability for need in needs(case(model="impulse", defect=DEFECT))}
    test_case = case(model="impulse", excitation="impulse-train", defect=DEFECT)
    assert "impulses" in {need.ability for need in needs(test_case)}


def test_only_the_spatial_model_refuses_balls() -> None:
    for name in MODELS:
        fields = {"bearing": "6205", "model": name, "defect": DEFECT | {"length": "1 mm"}}
        if name != "spatial":
            assert case(**fields).model == name
            continue
        ((message, hint),) = refusals(**fields)
        assert "tilt and skew are defined for rollers, not for balls" in message
        assert hint == "the simplest one that can is `model: static`"
