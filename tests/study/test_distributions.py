"""Distributions of the ranges of a design: their values at given shares."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate, stats

from bearingsim.study import distributions, load_study
from bearingsim.text.yamlfile import Node, parse
from tests.scenes.designs import sweep, values
from tests.scenes.study_text import Write


def range_of(text: str, path: str = "load") -> Node:
    return parse(f"{path}: {text}", "f").root.mapping[path]


def quantiles_of(text: str, shares: list[float], path: str = "load") -> list[float]:
    """Quantiles of the range at given shares, in its unit."""
    distribution = distributions.range_of(path, range_of(text, path))
    return [float(node.text.split()[0]) for node in distribution.nodes(np.array(shares))]


SHARES = [0.0, 0.1, 0.25, 0.5, 0.75, 0.9, 0.999]


@pytest.mark.parametrize("text", ["[100 N, 200 N]", "{uniform: [100 N, 0.2 kN]}"])
def test_uniform(text: str) -> None:
    assert quantiles_of(text, SHARES) == pytest.approx([100.0 + 100.0 * t for t in SHARES], rel=1e-12)


def test_log() -> None:
    assert quantiles_of("{log: [0.5 N, 10 N]}", SHARES) == pytest.approx(
        [0.5 * 20.0**t for t in SHARES], rel=1e-11
    )


@pytest.mark.parametrize(
    ("text", "mean", "deviation", "low", "high"),
    [
        ("{normal: [150 N, 20 N], within: [100 N, 200 N]}", 150.0, 20.0, 100.0, 200.0),
        ("{normal: [150 N, 0.02 kN], within: [0.16 kN, 300 N]}", 150.0, 20.0, 160.0, 300.0),
        ("{normal: [0.15 kN, 20 N], within: [30 N, 120 N]}", 0.15, 0.02, 0.03, 0.12),
    ],
)
def test_normal_is_cut_at_its_bounds(text: str, mean: float, deviation: float, low: float, high: float) -> None:
    """The share below each value, by quadrature of the density."""

    def density(x: float) -> float:
        return math.exp(-0.5 * ((x - mean) / deviation) ** 2)

    total, _ = integrate.quad(density, low, high, epsabs=0.0, epsrel=1e-12)
    quantiles = quantiles_of(text, SHARES)
    below = [integrate.quad(density, low, x, epsabs=0.0, epsrel=1e-12)[0] / total for x in quantiles]
    assert below == pytest.approx(SHARES, abs=2e-9)
    assert quantiles[0] == low


def test_a_deviation_of_a_temperature_is_a_difference() -> None:
    path = "contact.damping.temperature"
    in_kelvin = quantiles_of("{normal: [55 C, 5 K], within: [40 C, 70 C]}", SHARES, path)
    assert in_kelvin == quantiles_of("{normal: [55 C, 5 C], within: [40 C, 70 C]}", SHARES, path)
    assert in_kelvin[3] == 55.0


@given(
    st.floats(1e-6, 1e6),
    st.floats(1e-9, 10.0),
    st.sampled_from(
        ["[{a} N, {b} N]", "{{log: [{a} N, {b} N]}}", "{{normal: [{a} N, {s} N], within: [{a} N, {b} N]}}"]
    ),
    st.lists(st.floats(0.0, 1.0, exclude_max=True), min_size=1, max_size=5),
)
def test_values_lie_within_their_ranges(low: float, width: float, form: str, shares: list[float]) -> None:
    high = low * (1.0 + width)
    if not low < high:
        return
    values = quantiles_of(
        form.format(a=repr(low), b=repr(high), s=repr(high - low)), [*shares, 0.0, 1.0 - 2.0**-53]
    )
    assert all(low <= value <= high for value in values)
    by_share = [value for _, value in sorted(zip(shares, values, strict=False))]
    assert by_share == sorted(by_share)


def test_large_design_has_the_requested_distribution(write: Write) -> None:
    text = sweep("lhs", 400, "{load: {normal: [150 N, 20 N], within: [130 N, 200 N]}}")
    scores = (np.array(values(load_study(write(text)), "load")) - 150.0) / 20.0
    assert stats.kstest(scores, stats.truncnorm(-1.0, 2.5).cdf).statistic < 1.0 / 400
