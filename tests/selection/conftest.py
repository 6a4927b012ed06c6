"""Fixtures of the tests of selections."""

from importlib import import_module

import pytest

from bearingsim.config import Case
from bearingsim.selection import candidates


@pytest.fixture
def costs(monkeypatch: pytest.MonkeyPatch) -> dict[str, float]:
    """Cost of a case by its model, at 20 slices or 32 harmonics; a test may change it."""
    prices = {"spatial": 30.0, "planar": 10.0, "rollers": 3.0, "ring": 1.0, "static": 0.1}

    def estimated_cpu_time(case: Case) -> float:
        many = 1.0 if case.rig.ring is None else int(case.rig.ring.harmonics) / 32.0
        return prices[case.model] * many * (int(case.contact.slices) / 20.0 if case.model == "spatial" else 1.0)

    for module in (candidates, import_module("bearingsim.selection.decide")):
        monkeypatch.setattr(module, "estimated_cpu_time", estimated_cpu_time)
    return prices
