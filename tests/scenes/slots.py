"""NF308 in `rollers` with slots, whose steps and cost are asked for before anything runs."""

from typing import Any

import pytest

from bearingsim.config import Case
from tests.scenes.nf308 import CHI, SLOT

NARROW = SLOT | {"width": "0.2 mm"}
SLOTS = [pytest.param((), id="healthy"), pytest.param((SLOT,), id="0.8 mm"), pytest.param((NARROW,), id="0.2 mm")]


HEAVY = {"contact": {"damping": CHI}}
"""Damping that grows with the load."""


def case(**fields: Any) -> Case:
    return Case.model_validate(
        {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N", "model": "rollers"} | fields
    )
