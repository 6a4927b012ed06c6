"""Fields of the spatial model: profile, flanges, misalignment, slices, channels; and refusals."""

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from bearingsim import assemble
from bearingsim.assemble import space
from bearingsim.config import Bearing, Case, dataset_names
from bearingsim.config.rules.completion import slice_count, slice_ends
from bearingsim.core.geometry.slices import MAX_SLICES, WEIGHT, ZETA, slice_edges
from bearingsim.core.parts.cage_in_space import CageInPlane
from bearingsim.core.parts.flanges import NoFlanges
from bearingsim.core.parts.mounts import ElasticMount, RigidMount
from bearingsim.simulation import limits
from bearingsim.study.jobs import _healthy_baseline, case_id
from tests.scenes.nf308 import CHI

DEFECT = {"shape": "rectangular", "length": "3 mm", "width": "0.8 mm", "depth": "50 um"}
SPRUNG = {"axial_stiffness": "1e7 N/m", "tilting_stiffness": "1e4 N m/rad"}
SHAFT = {"stiffness": "1e8 N/m", "mass": "1 kg"}


def case(**fields: Any) -> Case:
    base = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "model": "spatial"}
    return Case.model_validate(base | fields)


def profiled(**profile: Any) -> Case:
    bearing = case().bearing.model_dump() | {"roller_profile": profile}
    return case(bearing=bearing)


def refusal(**fields: Any) -> tuple[str, str]:
    with pytest.raises(ValidationError) as caught:
        case(**fields)
    (error,) = caught.value.errors()
    conflict = error["ctx"]["conflicts"][0] if "conflicts" in error["ctx"] else None
    return (conflict.message, conflict.hint) if conflict else (error["ctx"]["message"], error["ctx"]["hint"])


@pytest.mark.parametrize(("length", "offset"), [(12.0, 0.0), (3.0, 0.0), (3.0, 4.5), (0.37, -2.11)])
def test_slices_align_with_the_defect_and_cover_the_roller(length: float, offset: float) -> None:
    test_case = case(defect=DEFECT | {"length": length * 1e-3, "offset": offset * 1e-3})
    ends, table = slice_ends(test_case), space.build_slices(test_case).table
    for side in (-0.5, 0.5):
        assert np.abs(ends - (offset + side * length) * 1e-3).min() < 1e-11
    assert ends[0] == -6e-3
    assert ends[-1] == 6e-3
    assert np.all(np.diff(ends) > 0.0)
    assert table[:, WEIGHT].sum() == pytest.approx(1.0, abs=1e-14)
    assert np.allclose(table[:, ZETA], (ends[1:] + ends[:-1]) / 2.0, atol=1e-15)
    assert 24 <= len(table) <= 28


def test_slices_are_denser_in_a_defect() -> None:
    ends = slice_edges(12e-3, [(-1.5e-3, 1.5e-3)], 24)
    inside = np.diff(ends[(ends > -1.6e-3) & (ends < 1.6e-3)])
    outside = np.diff(ends[ends < -1.4e-3])
    assert inside.max() < outside.min() / 2.0


def test_too_many_slices_are_refused() -> None:
    defects = [(-6e-3 + n * 1e-4, -6e-3 + n * 1e-4 + 5e-5) for n in range(40)]
    with pytest.raises(ValueError, match=f"at most {MAX_SLICES}"):
        slice_edges(12e-3, defects, 24)


def test_profiles() -> None:
    assert set(space.build_slices(case()).table[:, 2]) == {0.0}
    crowned = profiled(shape="crowned", drop=5e-6, straight_length=6e-3)
    assert space.profile_drop(crowned, 2.9e-3) == 0.0
    assert space.profile_drop(crowned, 6e-3) == pytest.approx(5e-6)
    assert space.profile_drop(crowned, -4.5e-3) == pytest.approx(1.25e-6)
    log = profiled(shape="logarithmic")
    assert space.profile_drop(log, 5.5e-3) == pytest.approx(
        0.00035 * 12e-3 * 1.8343, rel=1e-4
    )  # ln(1/(1 - (11/12)^2))


def test_missing_or_unknown_keys_of_a_profile_are_refused() -> None:
    for profile, words in (
        ({"shape": "crowned"}, "a crowned profile needs `drop`"),
        ({"shape": "logarithmic", "drop": 1e-6}, "a logarithmic profile has no `drop`"),
        ({"shape": "round"}, "expected `straight`, `crowned` or `logarithmic`, got `round`"),
    ):
        with pytest.raises(ValidationError, match=words):
            profiled(**profile)


@pytest.mark.parametrize(
    ("change", "part"),
    [
        ({"roller_profile": {"shape": "crowned", "drop": 5e-6, "straight_length": 0.012}}, "leaves no crown"),
        ({"roller_profile": "logarithmic", "roller_diameter": 4.7e-3}, "at most 2.5 diameters"),
        ({"flanges": {"inner": 2, "height": 0.012}}, "flanges of 12 mm do not fit between the races, 12 mm apart"),
        ({"flanges": {"inner": 2, "outer": 1, "height": 0.006}}, "flanges of 6 mm do not fit"),
    ],
)
def test_profile_and_flanges_must_fit_the_roller(change: dict[str, Any], part: str) -> None:
    bearing = case().bearing.model_dump()
    with pytest.raises(ValidationError, match=part):
        Bearing.model_validate(bearing | change)


def test_longest_profile_and_highest_flanges_that_fit() -> None:
    bearing = case().bearing.model_dump()
    fitting: list[dict[str, Any]] = [
        {"roller_profile": {"shape": "crowned", "drop": 5e-6, "straight_length": 0.0119}},
        {"roller_profile": "logarithmic", "roller_diameter": 4.8e-3},
        {"flanges": {"inner": 2, "height": 0.0119}},
        {"flanges": {"inner": 2, "outer": 1, "height": 0.0059}},
    ]
    for change in fitting:
        valid = Bearing.model_validate(bearing | change).model_dump()
        assert {key for key in valid if valid[key] != bearing[key]} == set(change)


def test_nf308_has_two_inner_flanges_and_one_outer_flange() -> None:
    result = space.build_flanges(case())
    assert (result.inner_minus, result.inner_plus, result.outer_minus, result.outer_plus) == (1.0, 1.0, 0.0, 1.0)
    assert result.play == 25e-6
    bare = case().bearing.model_copy(update={"flanges": None})
    assert isinstance(space.build_flanges(case().model_copy(update={"bearing": bare})), NoFlanges)


def test_misaligned_ring_is_tilted_in_the_given_direction() -> None:
    test_case = case(misalignment={"inner": "1 mrad", "outer": "-0.5 mrad", "direction": "30 deg"})
    inner, outer = space.build_inner_mount(test_case), space.build_outer_mount(test_case)
    assert isinstance(inner, RigidMount)
    assert inner == pytest.approx((1e-3 * np.cos(np.pi / 6), 0.5e-3), rel=1e-6)
    assert outer == pytest.approx((-0.5e-3 * np.cos(np.pi / 6), -0.25e-3), rel=1e-6)


def test_implausibly_large_misalignment_is_refused() -> None:
    message, hint = refusal(misalignment={"inner": "2 deg"})
    assert message == "a tilt of 2 deg is beyond 1.14592 deg"
    assert "mrad" in hint


def test_sprung_rings_have_masses_and_inertias() -> None:
    test_case = case(rig=SPRUNG, shaft=SHAFT | SPRUNG)
    inner, outer = space.build_inner_mount(test_case), space.build_outer_mount(test_case)
    assert isinstance(inner, ElasticMount)
    assert isinstance(outer, ElasticMount)
    assert inner.m == 1.0
    assert outer.k_tilt == 1e4
    assert outer.I_a > outer.I_t > outer.I_a / 2.0  # of a ring


@pytest.mark.parametrize("key", ["axial_stiffness", "tilting_stiffness"])
def test_incomplete_spring_is_refused(key: str) -> None:
    message, _ = refusal(rig={key: SPRUNG[key]})
    other = next(name for name in SPRUNG if name != key)
    assert message == f"a ring that tilts also needs `{other}`"


def test_a_line_load_is_a_channel_for_each_slice() -> None:
    test_case = case(record=["roller.3.outer_line_load", "roller.inner_line_load.7"], contact={"slices": 12})
    assert test_case.record == (
        *(f"roller.3.outer_line_load.{k}" for k in range(1, 13)),
        "roller.inner_line_load.7",
    )
    assert dataset_names("roller.3.outer_line_load.4") == ("roller.3.outer_line_load.4",)
    assert Case.model_validate(test_case.model_dump()) == test_case
    message, hint = refusal(record=["roller.3.outer_line_load.13"], contact={"slices": 12})
    assert message == "there is no slice 13: the roller has 12"
    assert "`roller.3.outer_line_load`" in hint


@pytest.mark.parametrize("name", ["ring.lean", "ring.axial", "inner.lean", "inner.axial"])
def test_channels_of_fixed_rings_are_refused(name: str) -> None:
    message, hint = refusal(record=[name])
    assert message.startswith(f"`{name}` stays zero")
    assert "tilting_stiffness" in hint
    assert case(record=[name], rig=SPRUNG, shaft=SHAFT | SPRUNG).record == (name,)


def test_kinematic_cage_has_no_skew_and_no_own_motion() -> None:
    kinematic = {"motion": "kinematic"}
    assert isinstance(space.build_cage_in_space(case(cage=kinematic)), CageInPlane)
    assert isinstance(space.build_flanges(case(cage=kinematic)), NoFlanges)
    for name in ("roller.skew", "cage.axial", "roller.flange_force"):
        assert refusal(record=[name], cage=kinematic)[0] == f"`{name}` stays zero: the cage is kinematic"


def test_balls_and_shared_pressure_have_no_slices() -> None:
    with pytest.raises(ValidationError) as caught:
        case(bearing="6205", record=["roller.outer_line_load"])
    (only,) = caught.value.errors()[0]["ctx"]["conflicts"]
    assert "tilt and skew are defined for rollers, not for balls" in only.message
    assert "not of its slices" in refusal(defect=DEFECT, excitation="pressure-share")[0]


def test_too_many_slices_are_reported_with_other_problems() -> None:
    defects = [
        DEFECT | {"length": "0.1 mm", "angle": f"{12 * n} deg", "offset": f"{0.35 * n - 5} mm"} for n in range(30)
    ]
    with pytest.raises(ValidationError) as caught:
        case(defects=defects, contact={"slices": 48}, record=["roller.1.outer_line_load.3", "roller.14.tilt"])
    messages = [conflict.message for conflict in caught.value.errors()[0]["ctx"]["conflicts"]]
    assert messages == [
        "the defects cut the roller into more than 64 slices",
        "there is no roller 14: the bearing has 13",
    ]


def test_healthy_case_with_line_loads_keeps_its_slices() -> None:
    record = ["ring.velocity", "roller.1.outer_line_load"]
    aside = case(defect=DEFECT | {"length": "2.9 mm", "offset": "1.1 mm"}, record=record)
    baseline = _healthy_baseline(aside, {})
    assert baseline is not None
    assert slice_count(aside) == 25
    assert slice_count(baseline.case) == 24
    assert baseline.case.record == ("ring.velocity",)


def test_a_flange_force_without_flanges_stays_zero() -> None:
    bare = case().bearing.model_dump() | {"flanges": None}
    assert refusal(bearing=bare, record=["roller.flange_force"])[0].startswith("`roller.flange_force` stays zero")


def test_loads_at_rest_include_misalignment() -> None:
    """A tilt of 1 mrad at 1 kN loads the ends of rollers: 455 N instead of 316 N without tilt."""

    def at_rest(lean: str, **damping: Any) -> tuple[float, float, float]:
        fields = {"load": "1 kN", "misalignment": {"inner": lean}, "contact": {"slices": 12} | damping}
        return limits.load_and_rates_at_rest(assemble.healthy_case(case(**fields)))

    tilted, straight = (at_rest(lean, damping=CHI) for lean in ("1 mrad", "0 mrad"))
    assert straight[0] == pytest.approx(316, rel=0.01)
    assert tilted[0] == pytest.approx(455, rel=0.01)
    assert (
        tilted[2] > 1.3 * straight[2]
    )  # this damping goes with the force, stiffness with the length that carries
    for loads in (at_rest(lean) for lean in ("1 mrad", "0 mrad")):  # the default goes with the stiffness
        assert loads[2] == pytest.approx(2.5e-6 * loads[1], rel=1e-9)


@pytest.mark.usefixtures("constant_candidates")
def test_equivalent_cases_have_one_id() -> None:
    assert case_id(case(misalignment={})) == case_id(case())
    assert case_id(case(contact={"length_nodes": 6})) == case_id(case())
    fields = {"excitation": "elastic-edge", "defect": DEFECT | {"edge": {"radius": "20 um"}}}
    assert case_id(case(**fields)) == case_id(case(excitation="elastic-edge", defect=DEFECT))


@pytest.mark.usefixtures("constant_candidates")
def test_keys_of_spatial_do_not_change_ids_of_other_models() -> None:
    for other in ({"contact": {"slices": 12}}, {"cage": {"axial_clearance": "0.1 mm"}}):
        for model, same in (("planar", True), ("spatial", False)):
            cage = {"cage": {}} if "cage" in other else {}
            assert (case_id(case(model=model, **cage)) == case_id(case(model=model, **other))) == same
