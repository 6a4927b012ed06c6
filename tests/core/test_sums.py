"""Sums over rollers, in a fixed order that does not depend on the processor."""

import numpy as np
import pytest
from numba.core.registry import cpu_target

from bearingsim import assemble
from bearingsim.core.advance import RING_MOTION
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.sums import lane_sum
from tests.core.models.test_by_roller import run
from tests.scenes.nf308 import SLOT, case
from tests.simulation.test_same_numbers import run_in_new_process


@pytest.mark.parametrize("n", [8, 16, 32, 104])
def test_lane_sum_adds_eight_partial_sums(n: int) -> None:
    rng = np.random.default_rng(n)
    y = rng.standard_normal(4 + n) * 10.0 ** rng.uniform(-8.0, 8.0, 4 + n)
    lanes = y[4:].reshape(-1, 8)
    sums = lanes[0]
    for lane in lanes[1:]:
        sums = sums + lane
    while len(sums) > 1:
        sums = sums[: len(sums) // 2] + sums[len(sums) // 2 :]
    assert lane_sum(4, y, n) == sums[0]
    assert lane_sum(4, y, n) == pytest.approx(y[4:].sum(), rel=1e-12)


def bits(name: str) -> str:
    """Return the bits of the ring's motion after 2000 steps."""
    ring_case = case(model=name, method="verlet", defect=SLOT)
    model = assemble.model(ring_case)
    y = assemble.start(ring_case, model)[0]
    run(Verlet(4e-7), model, 2000, y)
    return " ".join(float(y[cell]).hex() for cell in RING_MOTION)


FEATURES = cpu_target.target_context.codegen().magic_tuple()[2]


@pytest.mark.skipif("+avx2" not in FEATURES, reason="the processor has no AVX2: there is no other width")
@pytest.mark.parametrize("name", ["ring", "rollers", "planar"])
def test_the_width_of_vectors_changes_no_bit(name: str) -> None:
    """Two lanes instead of four or eight, with the same fused multiply-add."""
    code = f"from tests.core.test_sums import *; print(bits('{name}'))"
    narrow = ",".join(feature.replace("+avx512", "-avx512") for feature in FEATURES.split(","))
    assert run_in_new_process(code, NUMBA_CPU_NAME="haswell", NUMBA_CPU_FEATURES=narrow) == bits(name)
