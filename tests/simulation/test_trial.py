"""Trials: the first ball passes of a case, compared with its whole record."""

import math

import numpy as np
import pytest

from bearingsim.config import Case
from bearingsim.simulation import run_trial, simulate
from bearingsim.simulation.trial import (
    DEFECT_REVOLUTIONS,
    MIN_PASSES,
    defect_revolution_time,
    line_amplitudes,
    max_trial_passes,
    mean_square,
    revolution_spans,
    trial_passes,
)
from bearingsim.study import healthy_case
from tests.scenes.short_cases import SLOT, case

FEATURE_NAMES = ("velocity@BPFO", "velocity.rms", "outer_force.max")


def long_case(**fields: object) -> Case:
    return case(defects=[SLOT], duration="0.25 s", **fields)


def test_periodic_case_is_computed_completely() -> None:
    """The trial returns the record of a run."""
    result, record = run_trial(long_case(), FEATURE_NAMES, 16)
    full = simulate(long_case())
    assert result.is_periodic
    assert record is not None
    assert record.features.keys() == full.features.keys()
    is_equal = [
        record.features[name] == value or (math.isnan(value) and math.isnan(record.features[name]))
        for name, value in full.features.items()
    ]
    assert all(is_equal)
    assert record.series.keys() == full.series.keys() != set()
    assert all((record.series[name] == series).all() for name, series in full.series.items())
    assert abs(result.amplitudes["velocity@BPFO"][0]) == pytest.approx(full.features["velocity@BPFO"], rel=1e-3)
    assert result.forces.max() == pytest.approx(full.features["outer_force.max"], rel=1e-6)


@pytest.mark.parametrize("fields", [{"periodic": False}, {"periodic": False, "antialias": False}])
def test_non_periodic_case_is_represented_by_its_first_passes(fields: dict[str, bool]) -> None:
    result, record = run_trial(long_case(**fields), FEATURE_NAMES, 16)
    full = simulate(long_case(**fields)).features
    assert record is None
    assert not result.is_periodic
    assert [len(parts) for parts in (result.amplitudes["velocity@BPFO"], result.forces)] == [1 + 15, 16]
    assert abs(result.amplitudes["velocity@BPFO"][0]) == pytest.approx(full["velocity@BPFO"], rel=0.02)
    assert np.sqrt(result.mean_squares["velocity.rms"][0]) == pytest.approx(full["velocity.rms"], rel=0.05)
    assert result.forces.max() <= full["outer_force.max"]


def test_healthy_case_is_divided_into_the_same_turns() -> None:
    damaged = case(defects=[SLOT | {"race": "inner"}], duration="0.25 s")
    passes, turn = trial_passes(damaged), defect_revolution_time(damaged)
    healthy = healthy_case(damaged)
    assert healthy is not None
    damaged_trial, healthy_trial = (
        run_trial(test_case, ("velocity@BPFI",), passes, turn)[0] for test_case in (damaged, healthy)
    )
    assert damaged_trial.revolutions == healthy_trial.revolutions
    assert (
        abs(damaged_trial.amplitudes["velocity@BPFI"]).shape
        == abs(healthy_trial.amplitudes["velocity@BPFI"]).shape
    )
    assert abs(healthy_trial.amplitudes["velocity@BPFI"][0]) < 0.01 * abs(
        damaged_trial.amplitudes["velocity@BPFI"][0]
    )


def test_record_that_may_end_early_has_a_trial() -> None:
    """It may be accurate enough before so many passes."""
    test_case = long_case(until="40 %", record=[], periodic=False)
    passes = max_trial_passes(test_case)
    result, record = run_trial(test_case, FEATURE_NAMES, passes)
    assert result.passes == len(result.forces) == passes
    assert record is None


def test_trial_with_a_strict_step_check_is_not_the_record() -> None:
    result, record = run_trial(long_case(step_check="strict"), FEATURE_NAMES, 16)
    assert result.is_periodic
    assert record is None


@pytest.mark.parametrize(
    ("race", "duration", "passes"),
    [
        ("outer", "1 s", 16),
        ("outer", "4 s", 40),
        ("outer", "0.1 s", 7),
        ("outer", "10 ms", 1),
        ("roller", "1 s", 52),
    ],
)
def test_trial_has_enough_passes_but_at_most_half_of_the_record(race: str, duration: str, passes: int) -> None:
    test_case = case(defects=[SLOT | {"race": race}], duration=duration)
    rate = test_case.bearing.ball_pass_frequency(test_case.speed)
    assert trial_passes(test_case) == pytest.approx(passes, abs=1)
    assert trial_passes(test_case) <= max(1.0, 0.5 * test_case.duration * rate)
    if test_case.duration >= 1.0:
        assert trial_passes(test_case) >= max(
            MIN_PASSES, DEFECT_REVOLUTIONS * defect_revolution_time(test_case) * rate
        )


# Lines of synthetic series

PER_PASS, PER_TURN = 64, 5.4  # samples in a ball pass; ball passes in a turn of the defect
CYCLES = 1.7  # of the line in a ball pass


def tones(spans: list[slice], *components: tuple[float, float]) -> np.ndarray:
    """Return a sum of cosines (cycles per ball pass, amplitude)."""
    passes = np.arange(spans[0].stop + PER_PASS) / PER_PASS
    return sum(
        (size * np.cos(2.0 * np.pi * cycles * passes) for cycles, size in components), np.zeros(len(passes))
    )


def phases(spans: list[slice], *cycles: float) -> np.ndarray:
    passes = np.arange(spans[0].stop + PER_PASS) / PER_PASS
    return 2.0 * np.pi * np.multiply.outer(cycles, passes)


def test_modulation_by_defect_turns_is_not_scatter() -> None:
    """A line is modulated by the turns of a defect, which are no whole number of ball passes."""
    spans = revolution_spans(22, PER_TURN, PER_PASS)
    series = tones(spans, (CYCLES, 1.0), *((CYCLES + k / PER_TURN, 0.4) for k in (-2, -1, 1, 2)))
    result = line_amplitudes(series, phases(spans, CYCLES), spans)
    assert len(result) == 1 + 3  # four turns
    assert result[0] == pytest.approx(1.0, abs=1e-3)
    assert np.abs(result[1:] - result[0]).max() < 0.01
    modulated = tones(spans, (1.0, 1.0)) * (1.0 + tones(spans, (1.0 / PER_TURN, 0.4)))
    powers = np.array([mean_square(modulated[span]) for span in spans])
    assert np.ptp(powers) < 0.01 * powers[0]


@pytest.mark.parametrize(("offset", "is_known"), [(2.5, True), (0.7, True), (0.4, False), (0.0, False)])
def test_close_lines_are_separated_by_a_fit(offset: float, is_known: bool) -> None:
    """``offset``: distance of another line, 30 times as large, in cycles per window."""
    spans = revolution_spans(22, PER_TURN, PER_PASS)
    other = CYCLES + offset / (4.0 * PER_TURN)
    series = tones(spans, (CYCLES, 0.01), (other, 0.3))
    result = line_amplitudes(series, phases(spans, CYCLES, other), spans)
    assert np.isnan(result).all() or is_known
    if is_known:
        assert result[0] == pytest.approx(0.01, rel=0.1)
        assert np.abs(result[1:] - 0.01).max() < 2e-3  # two turns alone could not separate them
