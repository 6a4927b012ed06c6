"""Defects of a case: overlap, shapes, and defaults of a spall."""

from typing import Any

import pytest

from tests.scenes.case_messages import INNER, ON_ROLLER, SLOT, case, messages


@pytest.mark.parametrize(("apart", "fits"), [("1.19 deg", False), ("1.20 deg", True), ("-358.81 deg", False)])
def test_defects_of_one_race_do_not_overlap_but_merge(apart: str, fits: bool) -> None:
    # 0.8 mm on a race of 38.5 mm radius is 1.1906 deg
    pair = [SLOT, SLOT | {"angle": apart}]
    assert len(case(defects=pair).defects) == 2
    if fits:
        assert len(case(defects=pair, excitation="soft-edge").defects) == 2
    else:
        (message,) = messages(defects=pair, excitation="soft-edge")
        assert "overlaps defect 1" in message


def test_defects_of_other_elements_may_lie_at_the_same_angle() -> None:
    assert len(case(defects=[SLOT, INNER, ON_ROLLER, ON_ROLLER | {"roller": 2}]).defects) == 4
    for pair in ([ON_ROLLER, ON_ROLLER | {"roller": 1, "angle": "7 deg"}], [INNER, INNER | {"angle": "1.7 deg"}]):
        assert "overlaps defect 1" in messages(defects=pair, excitation="soft-edge")[0]
    # 0.8 mm on a roller of 6 mm radius is 7.64 deg, on an inner race of 26.5 mm radius 1.73 deg
    for pair in ([ON_ROLLER, ON_ROLLER | {"angle": "7.7 deg"}], [INNER, INNER | {"angle": "1.8 deg"}]):
        assert len(case(defects=pair, excitation="soft-edge").defects) == 2


def test_merged_defects_are_not_wider_than_the_spacing() -> None:
    wide = SLOT | {"width": "8 mm"}
    chain = [wide | {"angle": f"{11 * n} deg"} for n in range(3)]
    assert len(case(defects=chain[:2]).defects) == 2
    message = messages(defects=chain)[0]
    assert (
        "the defects that overlap here are 22.7829 mm wide, wider than the roller spacing (18.6079 mm)" in message
    )


SPALL = SLOT | {"shape": "spall"}


@pytest.mark.parametrize(
    ("defect", "part"),
    [
        (
            SLOT | {"offset": "7.5 mm"},
            "7.5 mm from the centre lies beyond the roller's end (6 mm) and has no effect",
        ),
        (SLOT | {"offset": "-8 mm"}, "beyond the roller's end"),
        (
            ON_ROLLER | {"offset": "5 mm"},
            "a defect of 3 mm, 5 mm from the centre, extends beyond the roller's end",
        ),
        (SLOT | {"edge": {"radius": "20 um", "ramp": "50 um"}}, "expected either `radius` or `ramp`"),
        (SLOT | {"edge": {}}, "expected either `radius` or `ramp`"),
        (SLOT | {"edge": {"radius": "0 um"}}, "a length above zero"),
        (SLOT | {"grown": "60 %"}, "only a spall has `grown`"),
        (SLOT | {"seed": "3"}, "only a spall has `seed`"),
        (SLOT | {"file": "spall.csv"}, "only a scan has `file`"),
        (SPALL | {"grown": "60"}, "expected a percentage such as `1 %`, got `60`"),
        (SPALL | {"grown": "120 %"}, "expected a percentage from 0 % to 100 %, got `120 %`"),
        ({"shape": "scan"}, "a scan needs `file`"),
        ({"shape": "scan", "file": "none.csv"}, "no file `none.csv`"),
        ({"shape": "elliptical", "length": "3 mm", "width": "1 mm"}, "Field required"),
    ],
)
def test_wrong_defects_are_refused(defect: dict[str, Any], part: str) -> None:
    assert part in "\n".join(messages(defect=defect))


@pytest.mark.parametrize(
    ("defect", "part"),
    [
        (SLOT | {"shape": "elliptical"}, "`soft-edge` is not defined for an elliptical defect"),
        (SPALL, "`soft-edge` is not defined for a spall"),
        (SLOT | {"edge": {"radius": "20 um"}}, "`soft-edge` is defined for sharp edges only"),
    ],
)
def test_excitations_with_forms_for_simple_shapes_only(defect: dict[str, Any], part: str) -> None:
    assert part in messages(defect=defect, excitation="soft-edge")[0]
    for fits in ("envelope", "impulse-train"):
        model = "impulse" if fits == "impulse-train" else "rollers"
        assert case(defect=defect, excitation=fits, model=model).excitation == fits


def test_omitted_keys_of_a_spall_have_defaults() -> None:
    defect = case(defect=SPALL).defects[0]
    assert (defect.grown, defect.seed) == (1.0, 0)
    assert case(defect=SPALL | {"grown": "60 %", "seed": 4}).defects[0].grown == 0.6
    assert case(defect=SLOT | {"grown": "none", "edge": "none", "file": "none"}).defects[0].edge is None


def test_offset_defect_within_the_roller_is_accepted() -> None:
    assert case(defect=SLOT | {"offset": "4.5 mm"}).defects[0].offset == 0.0045
    assert case(defect=SLOT | {"offset": "-6.5 mm"}).defects[0].offset == -0.0065
    assert case(defect=ON_ROLLER | {"offset": "4.5 mm"}).defects[0].offset == 0.0045
