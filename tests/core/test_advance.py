"""The loop over steps as compiled code."""

import numba
import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core.advance import NoSamples, advance_and_sample
from bearingsim.core.jit import OPTIONS
from bearingsim.simulation import channels
from bearingsim.simulation.integration import set_up
from tests.scenes.short_cases import case


@pytest.mark.parametrize("method", ["verlet", "dop853"])
def test_the_loop_counts_no_references(method: str) -> None:
    """Counting them takes a third to a half of a step of `ring` and `rollers`."""
    setup = set_up(case(model="rollers", method=method))
    y, places = assemble.start(setup.case, setup.model)[0], channels.recorded(setup.case)
    loop = numba.njit(**OPTIONS)(advance_and_sample.py_func)
    out = np.empty((len(places), 4))
    arguments = setup.method, setup.model, setup.monitor, 0, y, places, out, NoSamples()
    loop(*arguments)
    code = loop.inspect_llvm(tuple(numba.typeof(one) for one in arguments))
    calls = [line for line in code.splitlines() if " call " in line and "NRT_" in line]
    assert not calls
