"""The search for a root takes the same steps as SciPy's, to the last bit."""

from math import sin, tanh

import numpy as np
import pytest
from scipy.optimize import brentq

from bearingsim.assemble.roots import root

KINDS = {
    "a contact": lambda scale, n, load: lambda x: scale * x**n - load,
    "a step": lambda scale, n, load: lambda x: tanh(scale * (x - load * 1e-4)) + 1e-3 * x,
    "a bend": lambda scale, n, load: lambda x: (x - load * 1e-4) ** 3 + 1e-3 * n * sin(x - load * 1e-4),
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_root_is_that_of_scipy_to_the_last_bit(kind):
    chance = np.random.default_rng(1)
    for _ in range(200):
        scale, n, load = (
            10.0 ** chance.uniform(3.0, 12.0),
            chance.uniform(1.0, 2.0),
            10.0 ** chance.uniform(-3.0, 3.0),
        )
        function = KINDS[kind](scale, n, load)
        if function(0.0) * function(1.0) < 0.0:
            assert root(function, 0.0, 1.0, 1e-18, 1e-12) == brentq(function, 0.0, 1.0, xtol=1e-18, rtol=1e-12)


def test_a_root_at_an_end_is_that_end():
    assert root(lambda x: x, 0.0, 1.0, 1e-18, 1e-12) == 0.0
    assert root(lambda x: x - 1.0, 0.0, 1.0, 1e-18, 1e-12) == 1.0


def test_an_interval_without_a_change_of_sign_is_refused():
    with pytest.raises(ValueError, match=r"equal signs at 0\.0 and 1\.0"):
        root(lambda x: x + 1.0, 0.0, 1.0, 1e-18, 1e-12)
