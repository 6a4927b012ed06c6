"""Channels of contact forces, which are recorded without a filter."""

import pytest

from bearingsim.config import Case
from bearingsim.config.channels import is_contact_force
from bearingsim.study.used import relevant_fields


@pytest.mark.parametrize(
    "channel",
    [
        "roller.outer_force",
        "roller.3.inner_force",
        "roller.cage_force",
        "roller.2.flange_force",
        "roller.outer_line_load",
        "roller.3.inner_line_load.7",
    ],
)
def test_contact_forces_are_identified(channel: str) -> None:
    assert is_contact_force(channel)


@pytest.mark.parametrize("channel", ["roller.radial", "roller.2.outer_slip", "load_zone.rollers", "ring.velocity"])
def test_other_channels_are_no_contact_forces(channel: str) -> None:
    assert not is_contact_force(channel)


@pytest.mark.parametrize(
    ("record", "antialias", "as_they_are"),
    [
        (["roller.inner_force"], True, True),
        (["ring.velocity"], True, False),
        (["roller.inner_force"], False, False),  # nothing is filtered anyway: an old result is the same
    ],
)
def test_id_of_a_case_with_unfiltered_forces_has_changed(
    record: list[str], antialias: bool, as_they_are: bool
) -> None:
    fields = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "record": record, "antialias": antialias}
    assert (relevant_fields(Case.model_validate(fields)).get("forces") == '"raw"') == as_they_are
