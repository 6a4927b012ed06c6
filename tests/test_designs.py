"""Designs in the unit cube: what each of them promises."""

import numpy as np
import pytest

from bearingsim import designs
from bearingsim.designs import KINDS, LEVELS, MORRIS_STEP, unit_cube_points


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("n", "d"), [(1, 1), (5, 3), (16, 6), (100, 2)])
def test_a_design_has_its_rows_within_the_cube(kind: designs.Kind, n: int, d: int) -> None:
    points = unit_cube_points(kind, n, d, seed=7)
    assert points.shape == (n * designs.block_size(kind, d), d)
    assert points.min() >= 0.0
    assert points.max() < 1.0
    assert np.array_equal(points, unit_cube_points(kind, n, d, seed=7))
    assert not np.array_equal(points, unit_cube_points(kind, n, d, seed=8))


@pytest.mark.parametrize("kind", KINDS)
def test_extensible_designs_preserve_their_points(kind: designs.Kind) -> None:
    few, many = unit_cube_points(kind, 64, 3, seed=1), unit_cube_points(kind, 256, 3, seed=1)
    assert np.array_equal(few, many[: len(few)]) == (kind in designs.EXTENSIBLE)


def test_a_latin_hypercube_has_a_point_in_each_stratum() -> None:
    points = unit_cube_points("lhs", 50, 4, seed=3)
    for column in points.T:
        assert sorted(np.floor(50 * column)) == list(range(50))


def test_sobol_points_are_spread_evenly() -> None:
    """The points are a net: each of 2^m intervals, and of 2^m squares in two dimensions, has one of 2^m points."""
    points = unit_cube_points("sobol", 64, 2, seed=3)
    assert sorted(np.floor(64 * points[:, 0])) == list(range(64))
    assert len({tuple(np.floor(8 * point)) for point in points}) == 64


def test_saltelli_blocks_mix_two_samples() -> None:
    d = 3
    for a, b, *mixed in unit_cube_points("saltelli", 10, d, seed=5).reshape(10, d + 2, d):
        assert not set(a) & set(b)
        for j, row in enumerate(mixed):
            expected = a.copy()
            expected[j] = b[j]
            assert np.array_equal(row, expected)


def test_saltelli_samples_are_from_one_sequence() -> None:
    blocks = unit_cube_points("saltelli", 16, 2, seed=5).reshape(16, 4, 2)
    assert np.array_equal(np.hstack([blocks[:, 0], blocks[:, 1]]), unit_cube_points("sobol", 16, 4, seed=5))


def test_morris_changes_each_parameter_once_by_its_step() -> None:
    d, steps = 5, set()
    for trajectory in unit_cube_points("morris", 200, d, seed=2).reshape(200, d + 1, d):
        moves = np.diff(trajectory, axis=0)
        assert np.array_equal(np.abs(moves).sum(axis=0), np.full(d, MORRIS_STEP))
        assert np.array_equal(np.count_nonzero(moves, axis=1), np.ones(d))
        steps |= {(int(np.flatnonzero(move)[0]), float(move.sum())) for move in moves}
    assert steps == {(j, sign * MORRIS_STEP) for j in range(d) for sign in (-1.0, 1.0)}


def test_morris_levels_come_up_equally_often() -> None:
    points = unit_cube_points("morris", 4000, 2, seed=2)
    counts = np.array([np.count_nonzero(points == level) for level in LEVELS])
    assert counts.sum() == points.size
    assert np.all(np.abs(counts / points.size - 1.0 / len(LEVELS)) < 0.02)


@pytest.mark.parametrize(
    ("kind", "first"),
    [
        ("lhs", [0.6699494033500657, 0.7257847192589643, 0.2968554278239638]),
        ("sobol", [0.9456960996612906, 0.6048936443403363, 0.17640437185764313]),
        ("saltelli", [0.2868441781029105, 0.511673104017973, 0.8703022720292211]),
        ("morris", [5 / 16, 5 / 16, 11 / 16]),
    ],
)
def test_the_points_are_those_that_results_were_named_by(kind: designs.Kind, first: list[float]) -> None:
    """They shape the ids of results: another version of a library must not move them unnoticed."""
    assert unit_cube_points(kind, 4, 3, seed=1)[1].tolist() == pytest.approx(first, rel=1e-12)
