"""Statements on indices and effects, as far as their intervals allow."""

import numpy as np
import pytest

from bearingsim.sensitivity import Effects, Estimate, Indices
from bearingsim.sensitivity.verdict import (
    describe_effects,
    describe_indices,
    negligible_parameters,
    strongest_parameters,
)

PATHS = ("defect.width", "load", "clearance")


def estimates(*ends):
    """An estimate from (value, low, high) of each parameter."""
    return Estimate(*(np.array(part) for part in zip(*ends, strict=True)))


ALONE = estimates((0.5, 0.4, 0.6), (0.2, 0.1, 0.3), (0.0, -0.01, 0.02))


def test_parameter_with_separate_interval_dominates():
    total = estimates((0.7, 0.6, 0.8), (0.3, 0.2, 0.59), (0.01, 0.0, 0.04))
    assert describe_indices(Indices(ALONE, total, estimates((0.3, 0.1, 0.5))), "velocity@BPFO", PATHS) == (
        "One parameter clearly dominates velocity@BPFO: `defect.width`, total index"
        " 0.70 (0.60 to 0.80), alone 0.50 (0.40 to 0.60). `clearance` is negligible, below 5 % of the"
        " variance. Parameters interact (1 - sum of first-order indices = 0.30 (0.10 to 0.50)), so varying one at"
        " a time is not enough."
    )


def test_parameters_with_overlapping_intervals_dominate_together():
    total = estimates((0.5, 0.4, 0.6), (0.6, 0.45, 0.7), (0.2, 0.1, 0.3))
    text = describe_indices(Indices(ALONE, total, estimates((0.3, -0.1, 0.5))), "velocity.rms", PATHS)
    assert text.startswith("2 parameters dominate velocity.rms, with overlapping intervals: `load`")
    assert text.index("`load`") < text.index("`defect.width`")
    assert "negligible" not in text
    assert (
        "Interactions of parameters are not significant (1 - sum of first-order indices = 0.30 (-0.10 to 0.50))."
        in text
    )


@pytest.mark.parametrize(("high", "count"), [(0.599, 1), (0.6, 2)])
def test_intervals_that_touch_overlap(high, count):
    assert len(strongest_parameters(estimates((0.7, 0.6, 0.8), (0.5, 0.4, high), (0.1, 0.0, 0.2)))) == count


@pytest.mark.parametrize(("high", "is_little"), [(0.049, [2]), (0.051, [])])
def test_negligible_needs_upper_limit_below_threshold(high, is_little):
    assert negligible_parameters(estimates((0.7, 0.6, 0.8), (0.5, 0.4, 0.6), (0.01, 0.0, high)), 1.0) == is_little


def test_effects_are_in_unit_of_feature():
    size = estimates((3e-6, 2.5e-6, 3.5e-6), (1e-6, 0.9e-6, 1.1e-6), (1e-8, 0.0, 2e-8))
    mean = estimates((1e-6, 0.5e-6, 1.5e-6), (1e-6, 0.9e-6, 1.1e-6), (0.0, 0.0, 0.0))
    spread = estimates((2e-6, 1.6e-6, 2.5e-6), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    assert describe_effects(Effects(mean, size, spread), "velocity@BPFO", PATHS, "um/s", 1e6) == (
        "One parameter clearly dominates velocity@BPFO: `defect.width`, mu* 3.00"
        " (2.50 to 3.50) um/s. `clearance` is negligible, below 5 % of that. The effect of `defect.width` is"
        " nonlinear or depends on other parameters (sigma exceeds mu)."
    )


@pytest.mark.parametrize("sign", [1, -1])
def test_spread_below_mean_effect_counts_as_linear(sign):
    low, high = sorted((sign * 4.0, sign * 6.0))
    size, mean, spread = estimates((5.0, 4.0, 6.0)), estimates((sign * 5.0, low, high)), estimates((4.6, 4.5, 5.0))
    assert "nonlinear" not in describe_effects(Effects(mean, size, spread), "velocity@BPFO", PATHS)


def test_no_parameter_dominates_if_all_intervals_overlap():
    total = estimates((0.5, 0.2, 0.9), (0.4, 0.1, 0.8), (0.3, 0.1, 0.7))
    text = describe_indices(Indices(ALONE, total, estimates((0.3, -0.1, 0.5))), "velocity.rms", PATHS)
    assert text.startswith("No parameter clearly dominates velocity.rms, because all intervals overlap:")
