"""The first ball passes of a case, against all of it."""

import math

import numpy as np
import pytest

from bearingsim.config import Case
from bearingsim.simulation import simulate, try_out
from bearingsim.simulation.trial import (
    MIN_PASSES,
    TURNS,
    amplitudes,
    defect_turn,
    mean_square,
    most_passes,
    trial_passes,
    turn_spans,
)
from bearingsim.study import healthy_case
from tests.scenes.short_cases import SLOT, case

ASKED = ("velocity@BPFO", "velocity.rms", "outer_force.max")


def long(**fields: object) -> Case:
    return case(defects=[SLOT], duration="0.25 s", **fields)


def test_a_case_that_repeats_itself_is_computed_to_the_end() -> None:
    """Its record is the very one that a run of it gives."""
    result, record = try_out(long(), ASKED, 16)
    full = simulate(long())
    assert result.repeats
    assert record is not None
    assert record.features.keys() == full.features.keys()
    same = [
        record.features[name] == value or (math.isnan(value) and math.isnan(record.features[name]))
        for name, value in full.features.items()
    ]
    assert all(same)
    assert record.series.keys() == full.series.keys() != set()
    assert all((record.series[name] == series).all() for name, series in full.series.items())
    assert abs(result.lines["velocity@BPFO"][0]) == pytest.approx(full.features["velocity@BPFO"], rel=1e-3)
    assert result.forces.max() == pytest.approx(full.features["outer_force.max"], rel=1e-6)


@pytest.mark.parametrize("said", [{"periodic": False}, {"periodic": False, "antialias": False}])
def test_one_that_does_not_is_seen_in_its_first_passes(said: dict[str, bool]) -> None:
    result, record = try_out(long(**said), ASKED, 16)
    full = simulate(long(**said)).features
    assert record is None
    assert not result.repeats
    assert [len(parts) for parts in (result.lines["velocity@BPFO"], result.forces)] == [1 + 15, 16]
    assert abs(result.lines["velocity@BPFO"][0]) == pytest.approx(full["velocity@BPFO"], rel=0.02)
    assert np.sqrt(result.powers["velocity.rms"][0]) == pytest.approx(full["velocity.rms"], rel=0.05)
    assert result.forces.max() <= full["outer_force.max"]


def test_a_healthy_twin_is_cut_as_the_case_whose_defect_turns() -> None:
    damaged = case(defects=[SLOT | {"race": "inner"}], duration="0.25 s")
    passes, turn = trial_passes(damaged), defect_turn(damaged)
    healthy = healthy_case(damaged)
    assert healthy is not None
    own, counterpart = (try_out(one, ("velocity@BPFI",), passes, turn)[0] for one in (damaged, healthy))
    assert own.turns == counterpart.turns
    assert abs(own.lines["velocity@BPFI"]).shape == abs(counterpart.lines["velocity@BPFI"]).shape
    assert abs(counterpart.lines["velocity@BPFI"][0]) < 0.01 * abs(own.lines["velocity@BPFI"][0])


def test_a_record_that_may_end_early_is_tried_all_the_same() -> None:
    """It may be known well enough before so many passes have gone by."""
    test_case = long(until="40 %", record=[], periodic=False)
    passes = most_passes(test_case)
    result, record = try_out(test_case, ASKED, passes)
    assert result.passes == len(result.forces) == passes
    assert record is None


def test_a_strict_step_is_proven_by_the_run_itself() -> None:
    result, record = try_out(long(step_check="strict"), ASKED, 16)
    assert result.repeats
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
def test_enough_passes_are_tried_and_never_most_of_a_record(race: str, duration: str, passes: int) -> None:
    one = case(defects=[SLOT | {"race": race}], duration=duration)
    rate = one.bearing.ball_pass_frequency(one.speed)
    assert trial_passes(one) == pytest.approx(passes, abs=1)
    assert trial_passes(one) <= max(1.0, 0.5 * one.duration * rate)
    if one.duration >= 1.0:
        assert trial_passes(one) >= max(MIN_PASSES, TURNS * defect_turn(one) * rate)


# Lines of series that are known

PER_PASS, PER_TURN = 64, 5.4  # samples in a ball pass; ball passes in a turn of the defect
CYCLES = 1.7  # of the line in a ball pass


def tones(spans: list[slice], *of: tuple[float, float]) -> np.ndarray:
    """Cosines (cycles in a ball pass, amplitude), added up."""
    at = np.arange(spans[0].stop + PER_PASS) / PER_PASS
    return sum((size * np.cos(2.0 * np.pi * cycles * at) for cycles, size in of), np.zeros(len(at)))


def turning(spans: list[slice], *cycles: float) -> np.ndarray:
    at = np.arange(spans[0].stop + PER_PASS) / PER_PASS
    return 2.0 * np.pi * np.multiply.outer(cycles, at)


def test_what_turns_with_a_defect_is_no_scatter() -> None:
    """A line that a defect's turn modulates, though no whole number of ball passes is a turn."""
    spans = turn_spans(22, PER_TURN, PER_PASS)
    series = tones(spans, (CYCLES, 1.0), *((CYCLES + k / PER_TURN, 0.4) for k in (-2, -1, 1, 2)))
    result = amplitudes(series, turning(spans, CYCLES), spans)
    assert len(result) == 1 + 3  # four turns
    assert result[0] == pytest.approx(1.0, abs=1e-3)
    assert np.abs(result[1:] - result[0]).max() < 0.01
    modulated = tones(spans, (1.0, 1.0)) * (1.0 + tones(spans, (1.0 / PER_TURN, 0.4)))
    powers = np.array([mean_square(modulated[span]) for span in spans])
    assert np.ptp(powers) < 0.01 * powers[0]


@pytest.mark.parametrize(("beside", "known"), [(2.5, True), (0.7, True), (0.4, False), (0.0, False)])
def test_lines_nearer_than_a_window_tells_are_solved_for(beside: float, known: bool) -> None:
    """``beside``: how many cycles more the other line, 30 times as large, makes in the window."""
    spans = turn_spans(22, PER_TURN, PER_PASS)
    other = CYCLES + beside / (4.0 * PER_TURN)
    series = tones(spans, (CYCLES, 0.01), (other, 0.3))
    result = amplitudes(series, turning(spans, CYCLES, other), spans)
    assert np.isnan(result).all() or known
    if known:
        assert result[0] == pytest.approx(0.01, rel=0.1)
        assert np.abs(result[1:] - 0.01).max() < 2e-3  # though two turns alone could not tell them apart
