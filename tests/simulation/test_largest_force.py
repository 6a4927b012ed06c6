"""Standard error of the largest force of a record, for random sequences of maxima."""

from collections.abc import Callable

import numpy as np
import pytest

from bearingsim.simulation.start_error import PARTS, largest_force_error

Z, TURNS, RECORDS = 13, 12, 400
PAIRS = np.triu_indices(RECORDS, 1)


def independent(rng: np.random.Generator, tail: str) -> np.ndarray:
    """Draw records (RECORDS, passes) of independent passes."""
    draws: dict[str, Callable[..., np.ndarray]] = {
        "exponential": rng.exponential,
        "normal": rng.normal,
        "bounded": rng.uniform,
    }
    return 100.0 + draws[tail](size=(RECORDS, TURNS * Z))


def by_position(rng: np.random.Generator, tail: str) -> np.ndarray:
    """Draw records in which the force depends on the roller only and repeats each turn."""
    return np.tile(independent(rng, tail)[:, :Z], TURNS)


def modulated(rng: np.random.Generator, tail: str) -> np.ndarray:
    """Draw records in which all forces are modulated with a period of two records."""
    phase, passes = independent(rng, "bounded")[:, :1] * 2.0 * np.pi, np.arange(TURNS * Z)
    return by_position(rng, tail) + 5.0 * np.cos(phase + np.pi * passes / len(passes))


def errors(records: np.ndarray) -> np.ndarray:
    quarter = records.shape[1] // PARTS // Z * Z
    return np.array([largest_force_error(forces, Z, quarter) * forces.max() for forces in records])


@pytest.mark.parametrize("tail", ["exponential", "normal", "bounded"])
@pytest.mark.parametrize("kind", [independent, by_position, modulated])
def test_two_records_differ_by_at_most_two_standard_errors(
    kind: Callable[[np.random.Generator, str], np.ndarray], tail: str
) -> None:
    records = kind(np.random.default_rng(7), tail)
    largest, estimates = records.max(axis=1), errors(records)
    first, second = PAIRS
    covered = np.abs(largest[first] - largest[second]) <= 2.0 * np.hypot(estimates[first], estimates[second])
    assert covered.mean() >= 0.95
    assert np.median(estimates) <= {"exponential": 2.0, "normal": 2.0, "bounded": 7.0}[tail] * largest.std()


def test_error_is_relative_and_zero_for_constant_forces() -> None:
    (forces, *_) = independent(np.random.default_rng(1), "normal")
    assert largest_force_error(1e3 * forces, Z, 39) == pytest.approx(largest_force_error(forces, Z, 39), rel=1e-12)
    assert largest_force_error(np.full(60, 7.0), Z, 13) == 0.0
    assert largest_force_error(np.zeros(8), Z, 2) == 0.0
