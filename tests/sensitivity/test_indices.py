"""Sobol' indices and Morris' effects against closed forms and SciPy."""

import numpy as np
import pytest
from scipy.stats import sobol_indices

from bearingsim.designs import unit_cube_points
from bearingsim.sensitivity import estimates
from bearingsim.sensitivity.estimates import estimate
from tests.scenes.closed_forms import ISHIGAMI, SOBOL_G, ReferenceIndices

EACH_CLOSED_FORM = pytest.mark.parametrize("closed_form", [ISHIGAMI, SOBOL_G], ids=["ishigami", "sobol-g"])
BOTH = np.stack


def blocks_of(closed_form: ReferenceIndices, n: int, seed: int = 1):
    d = len(closed_form.first)
    return closed_form.function(unit_cube_points("saltelli", n, d, seed)).reshape(n, d + 2)


def test_closed_forms_agree_with_literature():
    assert ISHIGAMI.first == pytest.approx([0.3139, 0.4424, 0.0], abs=1e-4)
    assert ISHIGAMI.total == pytest.approx([0.5576, 0.4424, 0.2437], abs=1e-4)
    assert SOBOL_G.first.sum() < 1.0 < SOBOL_G.total.sum()


@EACH_CLOSED_FORM
@pytest.mark.parametrize("seed", [1, 2])
def test_indices_agree_with_closed_forms(closed_form, seed):
    result = estimates.sobol_indices(blocks_of(closed_form, 2**14, seed))
    assert np.abs(result - BOTH([closed_form.first, closed_form.total])).max() < 0.02


@EACH_CLOSED_FORM
def test_indices_with_dropped_blocks(closed_form):
    f = blocks_of(closed_form, 2**14)
    f[np.random.default_rng(1).random(f.shape) < 0.03] = np.nan
    full = f[np.isfinite(f).all(axis=1)]
    assert 0.8 < len(full) / len(f) < 0.9
    assert np.abs(estimates.sobol_indices(full) - BOTH([closed_form.first, closed_form.total])).max() < 0.05


@EACH_CLOSED_FORM
@pytest.mark.parametrize("offset", [0.0, 1e3])
def test_indices_agree_with_scipy(closed_form, offset):
    f = blocks_of(closed_form, 2**12) + offset
    scipy_result = sobol_indices(func={"f_A": f[:, 0], "f_B": f[:, 1], "f_AB": f[:, None, 2:].T}, n=2**12)
    first, total = estimates.sobol_indices(f)
    assert total == pytest.approx(scipy_result.total_order, abs=1e-9)
    assert first == pytest.approx(scipy_result.first_order, abs=0.01)


def pair(u):
    """The product of the first parameter and the fourth: neither does anything alone."""
    return (u[..., 0] - 0.5) * (u[..., 3] - 0.5)


@pytest.mark.parametrize("seed", range(5))
def test_correlated_columns_give_no_false_first_index(seed):
    """Of six parameters at 128 blocks, those columns of A and B are correlated whatever the scramble."""
    f = pair(unit_cube_points("saltelli", 128, 6, seed)).reshape(128, 8)
    assert abs(np.corrcoef(f[:, 0], f[:, 1])[0, 1]) > 0.3
    result = estimates.estimate_indices(f)
    assert np.abs(result.first.value).max() < 0.12
    assert np.all((result.first.low <= 0.0) & (result.first.high >= 0.0))


def test_inert_parameter_has_index_zero():
    f = (unit_cube_points("saltelli", 16, 2, 1)[:, 0] ** 2).reshape(16, 4)
    assert estimates.sobol_indices(f)[0] == pytest.approx([1.0, 0.0], abs=1e-12)


def test_first_indices_are_independent_of_mean():
    plain, shifted = (blocks_of(ISHIGAMI, 128) + offset for offset in (0.0, 1e4))
    assert estimates.sobol_indices(shifted) == pytest.approx(estimates.sobol_indices(plain), abs=1e-8)


def test_pure_interaction_is_found():
    d = 2
    f = np.prod(unit_cube_points("saltelli", 4096, d, 1) - 0.5, axis=1).reshape(-1, d + 2)  # x y: nothing alone
    result = estimates.estimate_indices(f)
    assert result.interaction.value == pytest.approx([1.0], abs=0.05)
    assert result.interaction.low[0] > 0.9
    assert result.total.value == pytest.approx([1.0, 1.0], abs=0.05)


def independent(n, d, seed):
    a, b = np.random.default_rng(seed).random((2, n, d))
    mixed = np.where(np.eye(d, dtype=bool), b[:, None, :], a[:, None, :])
    return np.concatenate([a[:, None], b[:, None], mixed], axis=1).reshape(-1, d)


def of_design(n, d, seed):
    return unit_cube_points("saltelli", n, d, seed)


@pytest.mark.parametrize(
    ("points", "tries", "least", "most"), [(independent, 60, 0.9, 0.985), (of_design, 10, 0.99, 1.0)]
)
def test_coverage_of_confidence_intervals(points, tries, least, most):
    """Of independent draws; a design by Sobol' is more even, and its intervals hold it more often still."""
    weights, n, d = np.array([3.0, 2.0, 1.0]), 128, 3
    first, held = weights**2 / (weights**2).sum(), 0
    for seed in range(tries):
        result = estimates.estimate_indices((points(n, d, seed) @ weights).reshape(n, d + 2)).first
        held += int(np.count_nonzero((result.low <= first) & (first <= result.high)))
    assert least <= held / (tries * d) <= most


def test_intervals_are_reproducible_and_shrink_with_n():
    short_design, again, many = (estimates.estimate_indices(blocks_of(ISHIGAMI, n)) for n in (128, 128, 2048))
    assert np.array_equal(short_design.total.low, again.total.low)
    narrower = (many.total.high - many.total.low) / (short_design.total.high - short_design.total.low)
    assert narrower == pytest.approx(0.25, abs=0.08)  # 16 times as many blocks


def test_bootstrap_draws_whole_blocks():
    """Rows drawn each for itself would tear A from its mixtures: the total index of a constant step would move."""
    a = np.random.default_rng(1).normal(size=200)
    result = estimate(lambda f: (f[:, 2] - f[:, 0]).mean(keepdims=True), np.stack([a, a, a + 1.0], axis=1))
    assert result.low == pytest.approx([1.0])
    assert result.high == pytest.approx([1.0])


@EACH_CLOSED_FORM
@pytest.mark.parametrize("n", [128, 2**14])
def test_morris_ranks_by_total_index(closed_form, n):
    d = len(closed_form.first)
    points = unit_cube_points("morris", n, d, 1).reshape(n, d + 1, d)
    magnitude = np.abs(estimates.elementary_effects(points, closed_form.function(points))).mean(axis=0)
    assert np.argsort(-magnitude).tolist() == np.argsort(-closed_form.total).tolist()


def test_effects_of_linear_function_are_its_slopes():
    points = unit_cube_points("morris", 20, 3, 1).reshape(20, 4, 3)
    result = estimates.estimate_effects(points, points @ np.array([3.0, -2.0, 0.0]))
    assert result.mu.value == pytest.approx([3.0, -2.0, 0.0])
    assert result.mu_star.value == pytest.approx([3.0, 2.0, 0.0])
    assert result.sigma.value == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)


def test_interaction_has_spread():
    points = unit_cube_points("morris", 400, 2, 1).reshape(400, 3, 2)
    x, y = np.moveaxis(points, -1, 0)
    result = estimates.estimate_effects(points, x * (y - 0.5))
    assert result.sigma.low[0] > np.abs(result.mu.high[0])
    assert result.mu_star.low[0] > 0.2
    of_levels = np.sqrt((3**2 + 7**2) / 2) / 16  # y - 0.5 at four levels
    assert result.sigma.value[0] == pytest.approx(of_levels, abs=0.01)
