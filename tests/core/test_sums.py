"""Sums over rollers, in a fixed order that does not depend on the processor."""

from typing import Any

import numpy as np
import pytest
from numba.core.registry import cpu_target

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import RING_MOTION
from bearingsim.core.jit import jit
from bearingsim.core.methods.backward_euler import BackwardEuler
from bearingsim.core.methods.dormand_prince import DormandPrince
from bearingsim.core.methods.interface import prepare, step
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.models.interface import begin
from bearingsim.core.outcomes import SUCCESS
from bearingsim.core.sums import lane_sum, sum_addends
from bearingsim.core.vectors import dot
from tests.scenes.nf308 import SLOT, case
from tests.scenes.oscillators import with_tolerance
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


@pytest.mark.parametrize("n", [0, 2, 8, 20, 24])
def test_addends_up_to_n_are_summed(n: int) -> None:
    addends = np.random.default_rng(n).standard_normal(40)
    y = lay.make_buffer(13, 1.0)
    y[lay.ADDENDS : lay.ADDENDS + 40] = addends
    assert sum_addends(y, n) == pytest.approx(addends[:n].sum(), rel=1e-12)


@pytest.mark.parametrize("n", [0, 7, 16, 81, 131])
def test_dot_adds_sixteen_partial_sums(n: int) -> None:
    """Products of factors with 24 bits are exact, fused or not; their sums depend on the order."""
    rng = np.random.default_rng(n)
    factors = rng.standard_normal((2, 140)) * 10.0 ** rng.uniform(-6.0, 6.0, (2, 140))
    a, b = factors.astype(np.float32).astype(float)
    compiled = jit(lambda a, b, n: dot(a, b, n))
    assert compiled(a, b, n) == dot(a, b, n)
    assert dot(a, b, n) == pytest.approx(a[:n] @ b[:n], rel=1e-12)


MANY = {
    "name": "many",
    "rollers": 30,
    "roller_diameter": "12 mm",
    "roller_length": "12 mm",
    "pitch_diameter": "150 mm",
    "bore": "120 mm",
    "outside_diameter": "180 mm",
    "width": "28 mm",
}
"""A bearing whose sums fill more than one vector, which a reordering compiler would accumulate in parallel."""
VERLET, STEPS = Verlet(4e-7), 2000
SCENES: dict[str, tuple[dict[str, Any], Any, int]] = {
    "ring": ({"model": "ring"}, VERLET, STEPS),
    "rollers": ({"model": "rollers"}, VERLET, STEPS),
    "planar": ({"model": "planar"}, VERLET, STEPS),
    "adaptive": ({"bearing": MANY, "model": "rollers"}, with_tolerance(DormandPrince, 2e-5, 1e-9), 40),
    "implicit": ({"bearing": MANY, "model": "rollers"}, with_tolerance(BackwardEuler, 2e-5, 1e-6), 40),
}


@jit
def run(method, model, count, y):
    begin(model, 0.0, y)
    prepare(method, model, 0.0, y)
    for n in range(count):
        step(method, model, n * method.h, y)


def bits(name: str) -> str:
    """Return the bits of the ring's motion after 0.8 ms."""
    fields, method, count = SCENES[name]
    scene = case(defect=SLOT, **fields)
    model = assemble.model(scene)
    y = assemble.start(scene, model)[0]
    run(method, model, count, y)
    motion = y[[*RING_MOTION]]
    assert np.isfinite(motion).all()
    assert y[lay.FAILED] == SUCCESS
    return motion.tobytes().hex()


FEATURES = cpu_target.target_context.codegen().magic_tuple()[2]


@pytest.mark.skipif("+avx2" not in FEATURES, reason="the processor has no AVX2: there is no other width")
@pytest.mark.parametrize("name", SCENES)
def test_the_width_of_vectors_changes_no_bit(name: str) -> None:
    """Two lanes instead of four or eight, with the same fused multiply-add."""
    code = f"from tests.core.test_sums import *; print(bits('{name}'))"
    features = [feature.replace("+avx512", "-avx512") for feature in FEATURES.split(",")]
    narrow = ",".join([*features, "+prefer-128-bit"])
    assert run_in_new_process(code, NUMBA_CPU_NAME="haswell", NUMBA_CPU_FEATURES=narrow) == bits(name)
