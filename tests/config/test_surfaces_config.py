"""The section `surfaces`: what it accepts, what it refuses, and what it leaves as it was."""

from typing import Any

import pytest
from pydantic import ValidationError

from bearingsim.config import Case
from bearingsim.config.sections.surfaces import MAX_ORDER
from bearingsim.study.jobs import case_id, healthy_case
from tests.scenes.nf308 import SLOT

pytestmark = pytest.mark.usefixtures("constant_candidates")

SPECTRUM = {"spectrum": {"amplitude": "0.2 um"}}


def case(**fields: Any) -> Case:
    return Case.model_validate({"bearing": "nf308", "speed": "1800 rpm", "load": "150 N"} | fields)


def refusals(surfaces: Any, **fields: Any) -> list[str]:
    """Messages with their remedies."""
    with pytest.raises(ValidationError) as caught:
        case(surfaces=surfaces, **fields)
    messages = []
    for error in caught.value.errors():
        context = error.get("ctx", {})
        conflicts = context.get("conflicts") or ()
        messages += [f"{conflict.message} ({conflict.hint})" for conflict in conflicts]
        messages += [] if conflicts else [f"{error['msg']} ({context.get('hint')})"]
    return messages


REFUSED = {
    "an order of none": ({"outer": {"harmonics": [{"order": 0, "amplitude": "1 um"}]}}, "from 1 to 1000, got `0`"),
    "an order beyond the table": (
        {"inner": {"harmonics": [{"order": MAX_ORDER + 1, "amplitude": "1 um"}]}},
        "expected a whole number from 1 to 1000, got `1001`",
    ),
    "half an order": ({"outer": {"harmonics": [{"order": 2.5, "amplitude": "1 um"}]}}, "expected a whole number"),
    "no unit": ({"outer": {"harmonics": [{"order": 2, "amplitude": "20"}]}}, "expected a length"),
    "one mapping": ({"outer": {"harmonics": {"order": 2, "amplitude": "20 nm"}}}, "expected a list of mappings"),
    "a single order": (
        {"outer": {"spectrum": {"amplitude": "1 um", "orders": 200}}},
        "expected the lowest and the highest order, got `200` (as in `orders: [2, 200]`)",
    ),
    "orders the wrong way round": (
        {"outer": {"spectrum": {"amplitude": "1 um", "orders": [200, 2]}}},
        "the lowest order, 200, is above the highest, 2 (give the lower one first)",
    ),
    "too few diameters": (
        {"rollers": {"diameter": ["1 um", "0 um"]}},
        "2 diameter deviations, but the bearing has 13 rollers (give 13 deviations, one per roller)",
    ),
    "no diameters": (
        {"rollers": {"diameter": []}},
        "0 diameter deviations, but the bearing has 13 rollers (give 13 deviations, one per roller)",
    ),
    "many large waves": (
        {"outer": {"harmonics": [{"order": order, "amplitude": "90 um"} for order in range(2, 202)]}},
        "18000 um is over 1 % of the rolling element's diameter (is the unit right?)",
    ),
    "two kinds of diameters": (
        {"rollers": {"diameter": {"scatter": "1 um", "deviations": ["1 um"]}}},
        "expected either `scatter` or `deviations`",
    ),
    "no kind of diameters": ({"rollers": {"diameter": {}}}, "expected either `scatter` or `deviations`"),
    "a roller too many": (
        {"rollers": {"harmonics": [{"order": 2, "amplitude": "1 um", "roller": 14}]}},
        "there is no roller 14: the bearing has 13 (numbers start at 1)",
    ),
    "a coarse unit": (
        {"rollers": {"diameter": {"scatter": "0.5 mm"}}},
        "500 um is over 1 % of the rolling element's diameter (is the unit right?)",
    ),
    "a class": ({"outer": {"class": "P5"}}, "Extra inputs are not permitted"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_wrong_surfaces_are_refused_with_a_remedy(what):
    surfaces, message = REFUSED[what]
    (refusal,) = refusals(surfaces)
    assert message in refusal


def test_a_model_without_form_is_refused():
    messages = refusals({"outer": SPECTRUM}, model="impulse", defect=SLOT)
    assert any("needs a model that includes surface form" in message for message in messages)


def test_implicit_methods_of_rollers_that_slip_are_refused():
    (refusal,) = refusals({"outer": SPECTRUM}, model="planar", method="rodas")
    assert "`rodas` needs the Jacobian" in refusal
    case(surfaces={"outer": SPECTRUM}, model="rollers", method="rodas")


def test_until_is_refused_where_the_form_turns():
    fields = {"until": "1 %", "record": [], "duration": "10 s"}
    case(surfaces={"outer": SPECTRUM}, **fields)
    (refusal,) = refusals({"inner": SPECTRUM}, **fields)
    assert (
        refusal == "`until` compares revolutions, which differ: the surfaces of inner race or rollers rotate "
        "(remove `until`)"
    )


def test_surfaces_without_deviations_are_none():
    """No id changes by a section that changes nothing."""
    smooth = ({}, {"seed": 3}, {"outer": {}}, {"rollers": {"diameter": ["0 um"] * 13}}, "none", {"inner": "none"})
    for surfaces in smooth:
        assert case(surfaces=surfaces).surfaces is None
        assert case_id(case(surfaces=surfaces)) == case_id(case())


def test_a_seed_counts_only_for_what_is_random():
    waves = {"outer": {"harmonics": [{"order": 12, "amplitude": "20 nm"}]}}
    assert case_id(case(surfaces=waves | {"seed": 3})) == case_id(case(surfaces=waves))
    assert case_id(case(surfaces={"outer": SPECTRUM, "seed": 3})) != case_id(case(surfaces={"outer": SPECTRUM}))


def test_the_healthy_baseline_has_the_same_surfaces():
    surfaces = {"outer": SPECTRUM, "seed": 3}
    healthy = healthy_case(case(surfaces=surfaces, defect=SLOT))
    assert healthy is not None
    assert healthy.surfaces == case(surfaces=surfaces).surfaces
    assert not healthy.defects


def test_a_list_of_diameters_is_read_back():
    """From the mapping that a case is stored as."""
    diameters = {"rollers": {"diameter": ["0.5 um", *["0 um"] * 12]}}
    stored = case(surfaces=diameters).model_dump()["surfaces"]
    assert case(surfaces=stored) == case(surfaces=diameters)
