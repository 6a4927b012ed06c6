"""Trends of the paper's figures, at reduced size: line at the outer-race frequency against the defect.

Yang et al.: it rises with length (Fig. 14), with width and depth (Fig. 15), and falls with the angle from the most
loaded position (Fig. 16). 0.8 mm x 0.05 mm at 150 N, clearance 0, unless said otherwise.
"""

from functools import lru_cache
from itertools import pairwise

import numpy as np
import pytest

from bearingsim import simulate
from tests.scenes.nf308 import SLOT, case

MODELS = ("static", "ring", "rollers")


@lru_cache(maxsize=256)
def line(model, clearance="0 um", healthy=False, **changes):
    """Complex velocity line (m/s)."""
    settings = {"model": model, "clearance": clearance, "duration": "60 ms", "settle": "40 ms"}
    features = simulate(case(defects=[] if healthy else [SLOT | changes], **settings)).features
    return features["velocity@BPFO"] * np.exp(1j * features["velocity@BPFO.phase"])


def amplitude(*arguments, **changes):
    return abs(line(*arguments, **changes))


def change_from_healthy(*arguments, **changes):
    return abs(line(*arguments, **changes) - line(*arguments, healthy=True))


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("measure", [amplitude, change_from_healthy])
def test_the_line_falls_with_angle(model, measure):
    result = [measure(model, angle=f"{angle} deg") for angle in range(0, 61, 10)]
    assert all(a > b for a, b in pairwise(result))
    assert result[-1] < 0.35 * result[0]


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("shape", ["circular", "rectangular"])
def test_the_line_rises_with_length(model, shape):
    result = [amplitude(model, shape=shape, length=f"{mm} mm") for mm in (3, 6, 9, 12)]
    assert all(b > 1.2 * a for a, b in pairwise(result))


@pytest.mark.parametrize("model", MODELS)
def test_the_line_rises_with_width(model):
    result = [amplitude(model, width=f"{mm} mm") for mm in (0.2, 0.4, 0.8, 1.2, 2.0)]
    assert all(b > 1.2 * a for a, b in pairwise(result))


@pytest.mark.parametrize("model", MODELS)
def test_the_line_rises_with_depth_until_the_roller_is_unloaded(model):
    """Beyond the approach of the loaded contacts (about 0.35 um) the line does not depend on depth."""
    shallow = [amplitude(model, depth=f"{um} um") for um in (0.1, 0.2, 0.5)]
    assert all(b > 1.2 * a for a, b in pairwise(shallow))
    deep = [amplitude(model, depth=f"{um} um") for um in (1, 5, 50)]
    assert max(deep) < 1.15 * min(deep)


@pytest.mark.parametrize("model", MODELS)
def test_rectangle_and_triangle_excite_equally_and_more_than_a_bowl(model):
    """At 0.05 mm depth the roller reaches neither wall nor floor; the narrow ends of a bowl support it."""
    rectangle, triangle, bowl = (
        amplitude(model, shape=shape) for shape in ("rectangular", "triangular", "circular")
    )
    assert triangle == pytest.approx(rectangle, rel=1e-9)
    assert bowl < 0.9 * rectangle


@pytest.mark.parametrize(("angle", "expected"), [(0, 9.30), (20, 7.38), (40, 4.25), (60, 2.03)])
def test_the_amplitudes_of_the_documented_slot(angle, expected):
    """um/s; the value at 0 deg agrees with the independent solution of tests/independent/rollers.py (9.2978)."""
    assert 1e6 * amplitude("rollers", angle=f"{angle} deg") == pytest.approx(expected, abs=0.02)


def test_with_clearance_shapes_agree_beyond_some_angle():
    """10 um, slot 0.8 mm x 5 um: different at the load line; from 40 deg on all three equal the healthy line."""
    shapes = ("rectangular", "triangular", "circular")
    healthy = abs(line("rollers", clearance="10 um", healthy=True))

    def spread(angle):
        result = [amplitude("rollers", clearance="10 um", angle=angle, shape=s, depth="5 um") for s in shapes]
        return np.ptp(result) / healthy, max(abs(value / healthy - 1.0) for value in result)

    assert spread("0 deg")[0] > 0.15
    for angle in ("40 deg", "50 deg", "60 deg"):
        difference, from_healthy = spread(angle)
        assert difference < 0.03
        assert from_healthy < 0.03
