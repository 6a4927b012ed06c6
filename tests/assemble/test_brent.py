"""Brent's method against SciPy's, to the last bit."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from bearingsim.assemble.brent import root


def test_same_bits_as_scipy() -> None:
    """Force laws of any exponent, some with several roots, at the tolerances of an approach and at coarse ones."""
    random = np.random.default_rng(1)
    for _ in range(3000):
        exponent, stiffness = random.uniform(0.3, 3.0), 10 ** random.uniform(5, 12)
        load = 10 ** random.uniform(-3, 4)
        ripple, waves = random.choice([0.0, 0.1]) * load, 10 ** random.uniform(1, 4)
        xtol, rtol = [(1e-18, 1e-12), (1e-6, 1e-9)][random.integers(2)]
        high = 10 * (load / stiffness) ** (1.0 / exponent)

        def excess(x: float) -> float:
            return stiffness * x**exponent + ripple * math.sin(waves * x / high) - load  # noqa: B023

        expected = brentq(excess, 0.0, high, xtol=xtol, rtol=rtol)
        assert root(excess, 0.0, high, xtol, rtol) == expected


def test_root_at_an_end() -> None:
    assert root(lambda x: x, 0.0, 1.0, 1e-12, 1e-12) == 0.0
    assert root(lambda x: x - 1.0, 0.0, 1.0, 1e-12, 1e-12) == 1.0


def test_refuses_what_has_no_root() -> None:
    with pytest.raises(ValueError, match="no change of sign between 0 and 1: 1, 2"):
        root(lambda x: x + 1.0, 0.0, 1.0, 1e-12, 1e-12)
    with pytest.raises(ValueError, match="no change of sign"):
        root(lambda x: math.nan, 0.0, 1.0, 1e-12, 1e-12)
    with pytest.raises(ValueError, match="last value nan"):
        root(lambda x: math.nan if 0.0 < x < 1.0 else x - 0.5, 0.0, 1.0, 1e-12, 1e-12)
    with pytest.raises(ValueError, match="in 100 steps"):
        root(lambda x: 1.0 if x > 0.3 else -1.0, 0.0, 1.0, 0.0, 0.0)


def test_equal_values_at_three_points() -> None:
    """A flat function has no line through its values: the interval is halved, as by SciPy."""

    def step(x: float) -> float:
        return 1.0 if x > 0.3 else -1.0

    assert root(step, 0.0, 1.0, 1e-9, 1e-9) == brentq(step, 0.0, 1.0, xtol=1e-9, rtol=1e-9)
