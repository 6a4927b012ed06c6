import math
import pickle
from typing import Any

import pytest
from pydantic import ValidationError

from bearingsim import assemble, catalogue
from bearingsim.assemble import contacts
from bearingsim.assemble.free import build_drag
from bearingsim.config import (
    CHANNELS,
    FEATURES,
    Cage,
    Case,
    Constant,
    Drag,
    Frictionless,
    Rig,
    StaticDynamic,
    Traction,
    dataset_names,
)
from bearingsim.config.sections.contact import WORD_LAWS
from tests.scenes.case_messages import INNER, ON_ROLLER, SLOT, case, messages

PLANAR = {"model": "planar"}


def test_text_with_units_becomes_si() -> None:
    test_case = case(defect=SLOT | {"angle": "90 deg"}, clearance="-5 um", settle="0 s")
    assert test_case.defects[0].width == 0.0008
    assert test_case.defects[0].angle == pytest.approx(math.pi / 2)
    assert test_case.clearance == -5e-6
    assert test_case.settle == 0.0


def test_floats_from_python_are_si_already() -> None:
    assert case(speed=100, load=150.0).speed == 100.0
    assert type(case(speed=100).speed) is float


def test_defaults_are_resolved() -> None:
    test_case = case()
    assert test_case.start_angle == math.pi / 13
    assert test_case.method == "auto"
    assert case(model="static").method is None
    assert case(start_angle="0 deg").start_angle == 0.0
    assert test_case.rig.bracket_stiffness == 1e7
    assert test_case.bearing.material.density == 7850.0
    assert test_case.record == ("ring.velocity",)


def test_a_case_survives_its_own_dump() -> None:
    test_case = case(defect=SLOT, contact={"damping": "kraemer"})
    assert Case.model_validate(test_case.model_dump()) == test_case
    assert hash(test_case) == hash(Case.model_validate(test_case.model_dump()))


def test_automatic_method_of_a_model_without_methods_is_its_own() -> None:
    assert case(model="static", method="auto") == case(model="static")
    assert case(model="static").method is None


def test_damping_is_chosen_by_its_law() -> None:
    assert case().contact.damping.model_dump() == {"law": "kraemer", "beta": 2.5e-6}
    assert case(contact={"damping": {"chi": "5 s/m"}}).contact.damping.model_dump()["chi"] == 5.0
    general = {"law": "general", "coefficient": "1e6", "indentation_exponent": "2"}
    assert case(contact={"damping": general}).contact.damping.model_dump()["coefficient"] == 1e6
    assert (
        "expected `kraemer`, `hunt-crossley`, `film`, `loss-factor`, `general` or `none`"
        in messages(contact={"damping": "kramer"})[0]
    )


@pytest.mark.parametrize(
    ("fields", "part"),
    [
        ({"speed": "0 rpm"}, "a rotation speed above zero"),
        ({"load": "-1 N"}, "a force above zero"),
        ({"load": float("nan")}, "got `nan`"),
        ({"load": True}, "expected a force"),
        ({"load": {"a": "1 N"}}, "got a mapping"),
        ({"duration": "0 s"}, "above zero"),
        ({"duration": "1 ms"}, "1 ms is shorter than one ball pass of 6.28931 ms"),
        ({"step": "fast"}, "expected a time"),
        ({"step": "0 us"}, "above zero"),
        ({"antialias": "no"}, "expected `true` or `false`, got `no`"),
        ({"step_check": "strictly"}, "expected `true`, `strict` or `false`, got `strictly`"),
        ({"record": ["ring.speed"]}, "expected `ring.displacement`"),
        ({"record": "ring.velocity"}, "tuple"),
        ({"model": "static", "method": "rk4"}, "the static model has no method, got `rk4`"),
        ({"contact": {"length_nodes": "6.0"}}, "whole number from 1 to 64"),
        ({"contact": {"length_nodes": "0"}}, "whole number from 1 to 64"),
        ({"bearing": "nf309"}, "no bearing `nf309` (available: 6203, 6205, 6309, nf308, "),
        ({"bearing": "x" * 5000 + "/own.yaml"}, "available: 6203"),
        ({"rig": "xyz"}, "available: bvt5"),
        ({"defect": SLOT | {"length": "13 mm"}}, "13 mm is longer than the roller (12 mm)"),
        (
            {"defect": SLOT | {"edge": {"ramp": "20 mm"}}},
            "a ramp of 20 mm is longer than the defect is wide (0.8 mm)",
        ),
        ({"defect": SLOT | {"width": "19 mm"}}, "19 mm is wider than the roller spacing (18.6079 mm)"),
        ({"defect": SLOT | {"depth": "10 mm"}}, "10 mm deep goes through the outer ring (6.5 mm)"),
        ({"clearance": "25 mm"}, "beyond -1 % to 5 % of the roller diameter"),
        ({"clearance": "-1 mm"}, "beyond -1 % to 5 % of the roller diameter"),
        ({"defect": SLOT | {"width": "-1 mm"}}, "above zero"),
        ({"defect": SLOT | {"race": "middle"}}, "expected `outer`, `inner` or `roller`"),
        ({"defect": SLOT | {"race": "roller", "roller": 14}}, "there is no roller 14: the bearing has 13"),
        ({"defect": SLOT | {"race": "roller", "roller": 0}}, "whole number from 1 to 64"),
        ({"defect": SLOT | {"roller": 3}}, "a defect of the outer race has no `roller`"),
        ({"defect": INNER | {"width": "13 mm"}}, "wider than the roller spacing on the inner race (12.808 mm)"),
        ({"defect": INNER | {"depth": "6.6 mm"}}, "6.6 mm deep goes through the inner ring (6.5 mm)"),
        ({"defect": INNER | {"length": "13 mm"}}, "13 mm is longer than the roller (12 mm)"),
        ({"defect": ON_ROLLER | {"width": "13 mm"}}, "wider than the roller's diameter (12 mm)"),
        ({"defect": ON_ROLLER | {"depth": "6 mm"}}, "6 mm deep goes past the roller's axis (6 mm)"),
        ({"excitation": "envelop"}, "expected `envelope`"),
        ({"model": "impulse", "defect": SLOT, "method": "rk4"}, "the impulse model has no method, got `rk4`"),
        ({"model": "impulse"}, "a bearing without a defect has no impulses"),
        ({"clearance": "C6"}, "expected a length such as `20 um`, or a class: C2, CN, C3, C4, C5; got `C6`"),
        ({"seed": "-1"}, "whole number from 0"),
        ({"record": ["roller.14.outer_force"]}, "there is no roller 14: the bearing has 13"),
        ({"record": ["roller.0.outer_force"]}, "expected `ring.displacement`"),
        ({"contact": {"stiffness": "hertz"}}, "expected `palmgren`, `iso16281`, `johnson`, `point` or `constant`"),
        ({"contact": {"stiffness": "constant"}}, "the law `constant` needs parameters"),
        ({"contact": {"stiffness": {"law": "johnson", "exponent": 1.1}}}, "the law `johnson` has no parameters"),
        ({"contact": {"stiffness": {"coefficient": 1e5, "exponent": 0}}}, "a plain number above 0 and at most 10"),
        ({"contact": {"stiffness": "point"}}, "the law `point` is for balls, not for rollers"),
        ({"bearing": "6205", "contact": {"stiffness": "johnson"}}, "`johnson` is for rollers, not for balls"),
        (PLANAR | {"friction": "dry"}, "expected `static-dynamic`, `traction` or `none`, got `dry`"),
        (PLANAR | {"friction": {"dynamic": 0.4}}, "dynamic friction (0.4) is above static (0.3)"),
        (PLANAR | {"friction": {"dynamic_speed": "1 mm/s"}}, "must be above `static_speed`"),
        (PLANAR | {"friction": {"law": "traction", "static": 0.3}}, "Extra inputs"),
        (PLANAR | {"friction": {"law": "traction", "a": -0.2}}, "a + d = -0.1 is below zero"),
        (PLANAR | {"friction": {"law": "traction", "a": 0.1}}, "a = 0.1 is above zero"),
        (PLANAR | {"friction": {"law": "traction", "b": -5}}, "a plain number that is not negative"),
        (PLANAR | {"friction": {"law": "traction", "c": 0}}, "a plain number above zero"),
        (PLANAR | {"cage": {"motion": "kinematic"}, "friction": "traction"}, "RMS 11-15 % low"),
        (PLANAR | {"cage": {"motion": "kinematic"}, "drag": {}}, "drag has no effect on a kinematic cage"),
        (PLANAR | {"cage": {"motion": "kinematic", "guide": "rollers"}}, "a kinematic cage stays centred"),
        (PLANAR | {"cage": {"guide": "rings"}}, "expected `centred`, `rollers`, `inner-ring` or `outer-ring`"),
        (PLANAR | {"drag": {"oil_fraction": 1.5}}, "expected a plain number from 0 to 1, got `1.5`"),
        (PLANAR | {"drag": {"oil_viscosity": "0 Pa s"}}, "a dynamic viscosity above zero"),
        (PLANAR | {"drag": "some"}, "valid dictionary or instance of Drag"),
        (PLANAR | {"shaft": {"stiffness": "1e8 N/m"}}, "Field required"),
        (PLANAR | {"unbalance": {"mass_radius": "100 g mm"}}, "has no effect on a fixed inner ring"),
        (PLANAR | {"rig": {"torsion_damping": "1 N m s/rad"}}, "does not rotate without `torsion_stiffness`"),
        (PLANAR | {"ramp": {"to": "0 rpm", "time": "1 s"}}, "a rotation speed above zero"),
        ({"defect": SLOT, "defects": [SLOT]}, "not both"),
        ({"defects": "none"}, "expected a list"),
        ({"lod": "1 N"}, "Extra inputs"),
    ],
)
def test_wrong_values_are_refused(fields: dict[str, Any], part: str) -> None:
    assert part in "\n".join(messages(**fields))


def test_defaults_depend_on_the_model() -> None:
    assert case().friction is None
    assert case().cage is None
    assert case(friction="none").friction is None
    test_case = case(model="planar")
    assert (test_case.friction, test_case.cage, test_case.drag) == (StaticDynamic(), Cage(), None)
    assert test_case.method == "auto"
    kinematic = case(model="planar", cage={"motion": "kinematic"})
    assert kinematic.friction == Frictionless()
    assert case(model="planar", friction="none").friction == Frictionless()
    impulse = case(model="impulse", defect=SLOT)
    assert (impulse.excitation, impulse.method) == ("impulse-train", None)
    assert case(model="impulse", defect=SLOT, excitation="random-impulses").excitation == "random-impulses"
    assert case(defect=ON_ROLLER).defects[0].roller == 1
    assert case(defect=SLOT).defects[0].roller is None


def test_defaults_of_planar() -> None:
    """Friction coefficients are the paper's; the rest are assumptions of this project."""
    cage, friction, drag = Cage(), StaticDynamic(), Drag()
    assert (friction.static, friction.dynamic) == (0.3, 0.15)
    assert (friction.static_speed, friction.dynamic_speed) == (0.02, 0.1)
    assert (cage.friction.static, cage.friction.dynamic) == (0.002, 0.001)
    assert (cage.pocket_clearance, cage.guide_clearance) == (2e-4, 4e-4)
    assert Cage.model_validate({"pocket_clearance": "0.1 mm"}).radial_pocket_clearance == 1e-4
    assert Cage.model_validate({"radial_pocket_clearance": "0.3 mm"}).radial_pocket_clearance == 3e-4
    assert (drag.oil_fraction, drag.oil_density, drag.oil_viscosity, drag.land_gap) == (0.1, 860.0, 0.05, 2e-4)
    traction = case(model="planar", friction="traction").friction
    assert isinstance(traction, Traction)
    assert (traction.a, traction.b, traction.c, traction.d) == (-0.1, 22.28, 181.46, 0.1)


def test_traction_may_start_from_zero_within_rounding() -> None:
    """0.1 + 0.2 is not 0.3, as in a sweep."""
    assert case(model="planar", friction={"law": "traction", "a": -0.1 - 0.2, "d": 0.3}).friction.d == 0.3


def test_cage_without_land_has_no_drag_of_a_land() -> None:
    assert build_drag(case(model="planar", drag={"land_width": "0 mm"})).land == 0.0
    assert build_drag(case(model="planar", drag={})).land > 0.0


def test_stiffness_suits_the_bearing() -> None:
    assert case().contact.stiffness == "palmgren"
    assert case(bearing="6205").contact.stiffness == "point"
    constant = case(bearing="6205", contact={"stiffness": {"coefficient": "1e5", "exponent": "1.5"}})
    assert constant.contact.stiffness == Constant(coefficient=1e5, exponent=1.5)
    assert case(contact={"stiffness": {"law": "iso16281"}}).contact.stiffness == "iso16281"


def test_optional_sections_may_be_none() -> None:
    sections = ("ramp", "drag", "shaft", "unbalance")
    test_case = case(**dict.fromkeys(sections, "none"))
    assert [getattr(test_case, name) for name in sections] == 4 * [None]


def test_every_section_survives_its_own_dump() -> None:
    test_case = case(
        model="planar",
        bearing="6205",
        clearance="C3",
        defects=[SLOT, ON_ROLLER],
        friction="traction",
        cage={"guide": "outer-ring", "mass": "20 g"},
        drag={},
        shaft={"stiffness": "1e8 N/m", "mass": "1 kg"},
        unbalance={"mass_radius": "1e-4 kg m"},
        ramp={"to": "3000 rpm", "time": "1 s"},
        gravity=True,
        load_across="-20 N",
        seed=3,
        rig={"torsion_stiffness": "1e4 Nm/rad"},
    )
    assert Case.model_validate(test_case.model_dump()) == test_case
    assert test_case.load_across == -20.0


def test_sections_are_frozen() -> None:
    with pytest.raises(ValidationError, match="frozen"):
        Rig().bracket_stiffness = 1.0


def test_names_of_channels_and_features() -> None:
    assert dataset_names("ring.velocity") == ("ring.velocity.x", "ring.velocity.y")
    assert dataset_names("roller.outer_force") == ("roller.outer_force",)
    assert CHANNELS["ring.acceleration"].unit == "m/s^2"
    expected = {"velocity@BPFO", "velocity@5BPFO-healthy", "displacement@2BPFO.phase", "velocity@BPFO-scatter"}
    assert expected | {"acceleration.kurtosis", "outer_force.max"} <= FEATURES.keys()


def test_every_catalogue_entry_is_implemented() -> None:
    for name, model in catalogue.MODELS.items():
        of_model = case(model=name, defect=SLOT, settle="0 s")
        assert isinstance(assemble.model(of_model), assemble.kind_of_model(name).parameters)
        assert not model.own_method or "h" in assemble.method_kind(of_model).parameters.__annotations__
    for name in catalogue.METHODS:
        assert "h" in assemble.kind_of_method(name).parameters.__annotations__
    for law in (law for laws in catalogue.LAWS.values() for law in laws.values()):
        assert callable(catalogue.code(law.build))
    assert all(callable(catalogue.code(shape.build)) for shape in catalogue.SHAPES.values())


@pytest.mark.parametrize("law", WORD_LAWS)
def test_every_accepted_stiffness_law_is_implemented(law: str) -> None:
    bearing = "6205" if law == "point" else "nf308"
    assert contacts.build_outer_law(case(bearing=bearing, contact={"stiffness": law}))


@pytest.mark.parametrize("angle", ["361 deg", "-361 deg", "1e9 deg", "6.29 rad"])
@pytest.mark.parametrize(
    "field",
    [
        lambda angle: {"start_angle": angle},
        lambda angle: {"defect": SLOT | {"angle": angle}},
        lambda angle: {"rig": {"sensor_angle": angle}},
        lambda angle: {"rig": {"sensor": {"angle": angle}}},
        lambda angle: {"misalignment": {"direction": angle}, "model": "spatial"},
        lambda angle: {"rig": {"ring": {"bends": True}, "load": {"by": "pads", "angles": [angle]}}},
        lambda angle: {
            "model": "planar",
            "shaft": {"stiffness": "1e8 N/m", "mass": "1 kg"},
            "unbalance": {"mass_radius": "1 g mm", "angle": angle},
        },
    ],
)
def test_an_angle_beyond_a_turn_is_refused(field: Any, angle: str) -> None:
    with pytest.raises(ValidationError, match=f"expected an angle from -360 deg to 360 deg, got `{angle}`"):
        case(**field(angle))
    for turn in ("360 deg", "-360 deg"):
        case(**field(turn))


def test_a_full_turn_may_be_rounded() -> None:
    assert case(start_angle="6.2832 rad").start_angle == 6.2832


def test_the_hash_of_a_changed_copy_is_its_own() -> None:
    """Cases are keys of caches, and their hash is computed once."""
    original = case(load="150 N")
    before = hash(original)
    changed = original.model_copy(update={"load": 200.0})
    assert hash(changed) == hash(case(load="200 N")) != before
    assert hash(pickle.loads(pickle.dumps(original))) == hash(original) == before
