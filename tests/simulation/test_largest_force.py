"""The standard error of the largest force of a record, by sequences of maxima whose scatter is known."""

from collections.abc import Callable

import numpy as np
import pytest

from bearingsim.simulation.start_error import PARTS, error_of_largest

Z, TURNS, RECORDS = 13, 12, 400
ORDERED = np.triu_indices(RECORDS, 1)


def independent(rng: np.random.Generator, tail: str) -> np.ndarray:
    """Draw records (RECORDS, passes) of independent passes."""
    draws: dict[str, Callable[..., np.ndarray]] = {
        "exponential": rng.exponential,
        "normal": rng.normal,
        "bounded": rng.uniform,
    }
    return 100.0 + draws[tail](size=(RECORDS, TURNS * Z))


def by_place(rng: np.random.Generator, tail: str) -> np.ndarray:
    """Draw records in which each roller has a force of its own, the same in all turns."""
    return np.tile(independent(rng, tail)[:, :Z], TURNS)


def drifting(rng: np.random.Generator, tail: str) -> np.ndarray:
    """Draw records in which all rollers' forces follow a slow course, of a period of two records."""
    phase, passes = independent(rng, "bounded")[:, :1] * 2.0 * np.pi, np.arange(TURNS * Z)
    return by_place(rng, tail) + 5.0 * np.cos(phase + np.pi * passes / len(passes))


def errors(records: np.ndarray) -> np.ndarray:
    quarter = records.shape[1] // PARTS // Z * Z
    return np.array([error_of_largest(forces, Z, quarter) * forces.max() for forces in records])


@pytest.mark.parametrize("tail", ["exponential", "normal", "bounded"])
@pytest.mark.parametrize("kind", [independent, by_place, drifting])
def test_two_records_differ_by_less_than_two_of_their_errors(
    kind: Callable[[np.random.Generator, str], np.ndarray], tail: str
) -> None:
    records = kind(np.random.default_rng(7), tail)
    largest, said = records.max(axis=1), errors(records)
    one, other = ORDERED
    covered = np.abs(largest[one] - largest[other]) <= 2.0 * np.hypot(said[one], said[other])
    assert covered.mean() >= 0.95
    assert np.median(said) <= {"exponential": 2.0, "normal": 2.0, "bounded": 7.0}[tail] * largest.std()


def test_it_has_no_unit_and_a_record_that_repeats_itself_has_none() -> None:
    (forces, *_) = independent(np.random.default_rng(1), "normal")
    assert error_of_largest(1e3 * forces, Z, 39) == pytest.approx(error_of_largest(forces, Z, 39), rel=1e-12)
    assert error_of_largest(np.full(60, 7.0), Z, 13) == 0.0
    assert error_of_largest(np.zeros(8), Z, 2) == 0.0
