"""Bearings of a case, and the folders with their files."""

import math
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from bearingsim import shipped
from bearingsim.config import Bearing, Material, library, library_names
from tests.scenes.case_messages import ON_ROLLER, SLOT, case, messages

NF308 = {
    "rollers": 13,
    "roller_diameter": 0.012,
    "roller_length": 0.012,
    "pitch_diameter": 0.065,
    "bore": 0.040,
    "outside_diameter": 0.090,
    "width": 0.023,
}


def test_bpfo_of_nf308_equals_the_paper() -> None:
    test_case = case()
    assert test_case.bearing.ball_pass_frequency(test_case.speed) == pytest.approx(159.0, rel=1e-12)


BALL = {"element": "ball", "roller_length": None, "inner_groove_radius": 0.00624, "outer_groove_radius": 0.00636}


def test_the_mass_of_a_rolling_element() -> None:
    roller, ball = (Bearing.model_validate(NF308 | change) for change in ({}, BALL))
    assert roller.element_mass == pytest.approx(7850 * math.pi * 0.006**2 * 0.012)
    assert ball.element_mass == pytest.approx(7850 * 4 / 3 * math.pi * 0.006**3)
    assert ball.inner_spacing == pytest.approx(math.pi * 0.053 / 13)


def test_a_balls_defect_may_be_longer_than_its_contact() -> None:
    assert case(bearing="6205", defect=SLOT | {"length": "15 mm"}).defects[0].length == 0.015
    assert "longer than the bearing (15 mm)" in messages(bearing="6205", defect=SLOT | {"length": "15.1 mm"})[0]
    too_long = ON_ROLLER | {"length": "8 mm"}
    assert "longer than the ball (7.94 mm)" in messages(bearing="6205", defect=too_long)[0]


@pytest.mark.parametrize(
    ("change", "part"),
    [
        ({"rollers": 17}, "17 rollers do not fit: at most 16"),
        ({"rollers": 2}, "from 3 to 104"),
        ({"outside_diameter": 0.0769}, "outside the outer ring"),
        ({"bore": 0.0531}, "inside the bore"),
        ({"roller_length": 0.0231}, r"a roller of 23.1 mm is longer than the rings are wide \(23 mm\)"),
        (BALL | {"width": 0.0119}, "a ball of 12 mm is longer than the rings are wide"),
        ({"roller_length": None}, "a roller bearing needs `roller_length`"),
        ({"inner_groove_radius": 0.0062}, "a roller bearing has no `inner_groove_radius`"),
        ({"element": "ball"}, "a ball bearing has no `roller_length`"),
        ({"element": "ball", "roller_length": None}, "a ball bearing needs `inner_groove_radius`"),
        (BALL | {"outer_groove_radius": None}, "a ball bearing needs `outer_groove_radius`"),
        (
            BALL | {"inner_groove_radius": 0.006},
            r"a groove of 6 mm does not fit the ball \(over 6 mm, at most 12 mm",
        ),
        (BALL | {"outer_groove_radius": 0.0121}, "a groove of 12.1 mm does not fit the ball"),
    ],
)
def test_a_bearing_must_fit_together(change: dict[str, Any], part: str) -> None:
    assert Bearing.model_validate(NF308 | {"rollers": 16}).rollers == 16
    with pytest.raises(ValidationError, match=part):
        Bearing.model_validate(NF308 | change)


def test_configs_in_the_working_folder_take_precedence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
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


def test_configs_are_found_in_the_package_or_its_checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`configs` beside an installed package belongs to another program; in a checkout it is the source."""
    monkeypatch.chdir(tmp_path)
    package = tmp_path / "site-packages" / "bearingsim"
    monkeypatch.setattr(shipped, "_PACKAGE", package)
    for folder, name in ((package, "packed"), (package.parent, "beside")):
        (folder / "configs" / "materials").mkdir(parents=True)
        (folder / "configs" / "materials" / f"{name}.yaml").write_text("density: 1 kg/m^3\n")
    assert library_names("materials") == ["packed"]
    assert Material.model_validate(library.load_mapping("materials", "packed")).density == 1.0
    (package / "configs").rename(package / "elsewhere")
    assert library_names("materials") == ["beside"]


@pytest.mark.parametrize("density", ["1e-9 kg/m^3", "0 kg/m^3", "1e6 kg/m^3"])
def test_unphysical_material_is_refused(density: str) -> None:
    """Rollers of negligible mass would need extremely short steps, also in an estimate."""
    with pytest.raises(ValidationError, match="expected a density"):
        Material.model_validate({"density": density})
