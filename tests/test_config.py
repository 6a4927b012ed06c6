import math
from pathlib import Path
from typing import Any, get_args

import pytest
from pydantic import ValidationError

from bearingsim import build
from bearingsim.config import (
    CHANNELS,
    FEATURES,
    Bearing,
    Case,
    Material,
    Rig,
    dataset_names,
    library,
    library_names,
)
from bearingsim.config.case import Method, Model
from bearingsim.config.contact import StiffnessLaw

SLOT = {"shape": "rectangular", "length": "3 mm", "width": "0.8 mm", "depth": "50 um"}


def case(**fields: Any) -> Case:
    return Case.model_validate({"bearing": "nf308", "speed": "1800 rpm", "load": "150 N"} | fields)


def messages(**fields: Any) -> list[str]:
    with pytest.raises(ValidationError) as caught:
        case(**fields)
    return [error["msg"] for error in caught.value.errors()]


def test_text_with_units_becomes_si() -> None:
    found = case(defect=SLOT | {"angle": "90 deg"}, clearance="-5 um", settle="0 s")
    assert found.defects[0].width == 0.0008
    assert found.defects[0].angle == pytest.approx(math.pi / 2)
    assert found.clearance == -5e-6
    assert found.settle == 0.0


def test_floats_from_python_are_si_already() -> None:
    assert case(speed=100, load=150.0).speed == 100.0
    assert type(case(speed=100).speed) is float


def test_nf308_has_the_papers_outer_race_frequency() -> None:
    found = case()
    assert found.bearing.ball_pass_frequency(found.speed) == pytest.approx(159.0, rel=1e-12)


def test_defaults_are_resolved() -> None:
    found = case()
    assert found.start_angle == math.pi / 13
    assert found.method == "verlet"
    assert case(model="static").method is None
    assert case(start_angle="0 deg").start_angle == 0.0
    assert found.rig.bracket_stiffness == 1e7
    assert found.bearing.material.density == 7850.0
    assert found.record == ("ring.velocity",)


def test_a_case_survives_its_own_dump() -> None:
    found = case(defect=SLOT, contact={"damping": "kraemer"})
    assert Case.model_validate(found.model_dump()) == found
    assert hash(found) == hash(Case.model_validate(found.model_dump()))


def test_damping_is_chosen_by_its_law() -> None:
    assert case().contact.damping.law == "hunt-crossley"
    assert case(contact={"damping": {"chi": "5 s/m"}}).contact.damping.model_dump()["chi"] == 5.0
    general = {"law": "general", "coefficient": "1e6", "indentation_exponent": "2"}
    assert case(contact={"damping": general}).contact.damping.model_dump()["coefficient"] == 1e6
    assert "expected `hunt-crossley`, `kraemer` or `general`" in messages(contact={"damping": "kramer"})[0]


@pytest.mark.parametrize(
    ("fields", "part"),
    [
        ({"speed": "0 rpm"}, "a rotation speed above zero"),
        ({"load": "-1 N"}, "a force above zero"),
        ({"load": float("nan")}, "got `nan`"),
        ({"load": True}, "expected a force"),
        ({"load": {"a": "1 N"}}, "got a mapping"),
        ({"duration": "0 s"}, "above zero"),
        ({"duration": "1 ms"}, "1 ms is shorter than one ball pass (6.28931 ms)"),
        ({"step": "fast"}, "expected a time"),
        ({"step": "0 us"}, "above zero"),
        ({"antialias": "no"}, "expected `true` or `false`, got `no`"),
        ({"record": ["ring.speed"]}, "expected `ring.displacement`"),
        ({"record": "ring.velocity"}, "tuple"),
        ({"model": "static", "method": "rk4"}, "the static model has no method, got `rk4`"),
        ({"contact": {"length_nodes": "6.0"}}, "whole number from 1 to 64"),
        ({"contact": {"length_nodes": "0"}}, "whole number from 1 to 64"),
        ({"bearing": "nf309"}, "no bearing `nf309` (did you mean `nf308`?)"),
        ({"rig": "xyz"}, "there are: bvt5"),
        ({"defect": SLOT | {"length": "13 mm"}}, "13 mm is longer than the roller (12 mm)"),
        ({"defect": SLOT | {"width": "19 mm"}}, "19 mm is wider than the roller spacing (18.6079 mm)"),
        ({"defect": SLOT | {"depth": "10 mm"}}, "10 mm deep goes through the outer ring (6.5 mm)"),
        ({"clearance": "25 mm"}, "beyond -1 % to 5 % of the roller diameter"),
        ({"clearance": "-1 mm"}, "beyond -1 % to 5 % of the roller diameter"),
        ({"defect": SLOT | {"width": "-1 mm"}}, "above zero"),
        ({"defect": SLOT | {"race": "middle"}}, "expected `outer`, `inner` or `roller`"),
        ({"defect": SLOT, "defects": [SLOT]}, "not both"),
        ({"defects": "none"}, "expected a list"),
        ({"lod": "1 N"}, "Extra inputs"),
    ],
)
def test_wrong_values_are_refused(fields: dict[str, Any], part: str) -> None:
    assert part in "\n".join(messages(**fields))


@pytest.mark.parametrize(("apart", "fits"), [("1.19 deg", False), ("1.20 deg", True), ("361.19 deg", False)])
def test_defects_of_one_race_do_not_overlap(apart: str, fits: bool) -> None:
    # 0.8 mm on a race of 38.5 mm radius is 1.1906 deg
    pair = [SLOT, SLOT | {"angle": apart}]
    if fits:
        assert len(case(defects=pair).defects) == 2
    else:
        assert "overlaps defect 1" in messages(defects=pair)[0]


NF308 = {
    "rollers": 13,
    "roller_diameter": 0.012,
    "roller_length": 0.012,
    "pitch_diameter": 0.065,
    "bore": 0.040,
    "outside_diameter": 0.090,
    "width": 0.023,
}


@pytest.mark.parametrize(
    ("change", "part"),
    [
        ({"rollers": 17}, "17 rollers do not fit: at most 16"),
        ({"rollers": 2}, "from 3 to 64"),
        ({"outside_diameter": 0.0769}, "outside the outer ring"),
        ({"bore": 0.0531}, "inside the bore"),
    ],
)
def test_a_bearing_must_fit_together(change: dict[str, Any], part: str) -> None:
    assert Bearing.model_validate(NF308 | {"rollers": 16}).rollers == 16
    with pytest.raises(ValidationError, match=part):
        Bearing.model_validate(NF308 | change)


def test_configs_beside_the_user_come_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert Material.model_validate(Bearing.model_validate(NF308).material).density == 7850.0
    folder = tmp_path / "configs" / "materials"
    folder.mkdir(parents=True)
    (folder / "steel.yaml").write_text("density: 8000 kg/m^3\n")
    (folder / "ceramic.yaml").write_text("density: 3200 kg/m^3\n")
    assert Bearing.model_validate(NF308).material.density == 8000.0
    assert library_names("materials") == ["ceramic", "steel"]
    assert (
        Bearing.model_validate(NF308 | {"material": "configs/materials/ceramic.yaml"}).material.density == 3200.0
    )


def test_configs_come_from_the_package_or_its_checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Installed, `configs` beside the package is somebody else's; in a checkout it is where they are written."""
    monkeypatch.chdir(tmp_path)
    package = tmp_path / "site-packages" / "bearingsim"
    monkeypatch.setattr(library, "_PACKAGE", package)
    for folder, name in ((package, "packed"), (package.parent, "beside")):
        (folder / "configs" / "materials").mkdir(parents=True)
        (folder / "configs" / "materials" / f"{name}.yaml").write_text("density: 1 kg/m^3\n")
    assert library_names("materials") == ["packed"]
    assert Material.model_validate(library.described("materials", "packed")).density == 1.0
    (package.parent / "pyproject.toml").touch()
    assert library_names("materials") == ["beside"]


def test_sections_are_frozen() -> None:
    with pytest.raises(ValidationError, match="frozen"):
        Rig().bracket_stiffness = 1.0  # type: ignore[misc]


def test_names_of_channels_and_features() -> None:
    assert dataset_names("ring.velocity") == ("ring.velocity.x", "ring.velocity.y")
    assert dataset_names("roller.outer_force") == ("roller.outer_force",)
    assert CHANNELS["ring.acceleration"].unit == "m/s^2"
    expected = {"velocity@BPFO", "velocity@5BPFO-healthy", "displacement@2BPFO.phase", "velocity@BPFO-scatter"}
    assert expected | {"acceleration.kurtosis", "outer_force.max"} <= FEATURES.keys()


def test_every_word_offered_is_built() -> None:
    assert set(build.MODELS) <= set(get_args(Model))
    assert {*get_args(Method), None} == set(build.METHODS)
    assert set(build.STIFFNESS) <= set(get_args(StiffnessLaw))
