"""How far one trial is from another, of trials whose difference is known."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import stdtrit

from bearingsim.selection.judge import error, value
from bearingsim.simulation.trial import Trial
from tests.scenes.trials import PASSES, trial

LINE, RMS, FORCE = "velocity@BPFO", "velocity.rms", "outer_force.max"
NAMES = (LINE, RMS)
ALL = (LINE, RMS, FORCE)


def off(feature: str, one: Trial, other: Trial, turns: float = 0.0) -> float:
    return error(feature, value(feature, one, None), value(feature, other, None), turns)


def with_parts(parts: np.ndarray) -> Trial:
    """A trial of a line of which each pass adds something."""
    return Trial(len(parts), False, {LINE: parts.astype(complex)}, {}, np.ones(len(parts)))


@pytest.mark.parametrize("feature", ALL)
def test_a_trial_is_nothing_off_itself(feature: str) -> None:
    assert off(feature, trial(3.0, scatter=0.1, names=NAMES), trial(3.0, scatter=0.1, names=NAMES)) == 0.0


@pytest.mark.parametrize("feature", ALL)
def test_what_each_pass_adds_alike_is_off_by_just_that(feature: str) -> None:
    one, other = trial(3.3, names=NAMES), trial(3.0, names=NAMES)
    assert value(feature, one, None).value == pytest.approx(3.3, rel=1e-12)
    assert off(feature, one, other) == pytest.approx(0.3, rel=1e-9)
    assert off(feature, other, one) == pytest.approx(0.3, rel=1e-9)


def test_scatter_between_passes_counts_as_often_as_student_says() -> None:
    """Of many draws of equal motions, whose true difference is none, the error covers 95 %, and is t s."""
    draw, hann = np.random.default_rng(3), np.hanning(2 * PASSES + 1)[1::2] / PASSES
    size = float(np.sqrt(2.0) * 0.1 * np.linalg.norm(hann))  # of two draws
    found = []
    for _ in range(400):
        pair = [with_parts(hann * (1.0 + 0.1 * draw.normal(size=PASSES))) for _ in range(2)]
        apart = abs(value(LINE, pair[0], None).value - value(LINE, pair[1], None).value)
        found.append((off(LINE, pair[0], pair[1]) - apart, apart))
    more, apart = np.array(found).T
    assert np.median(more) == pytest.approx(stdtrit(PASSES - 1, 0.975) * size, rel=0.1)
    assert np.mean(apart < more) == pytest.approx(0.95, abs=0.03)


def test_rms_scatters_as_half_the_power_does() -> None:
    draw = np.random.default_rng(4)
    noise = [0.1 * draw.normal(size=PASSES) for _ in range(2)]
    pair = [Trial(PASSES, False, {}, {RMS: (1.0 + one) * 4.0}, np.ones(PASSES)) for one in noise]
    s = float(np.std(noise[0] - noise[1], ddof=1)) / np.sqrt(PASSES)  # half of 2 * (noise) of an RMS of 2
    apart = abs(value(RMS, pair[0], None).value - value(RMS, pair[1], None).value)
    assert off(RMS, pair[0], pair[1]) - apart == pytest.approx(stdtrit(PASSES - 1, 0.975) * s, rel=0.02)


def test_a_pit_that_turns_with_its_race_has_no_scatter_of_its_own() -> None:
    turn, turns = 6, 8
    hann = np.full(turn * turns, 1.0 / (turn * turns))  # no window: each turn weighs the same
    modulated = 1.0 + 0.9 * np.cos(2.0 * np.pi * np.arange(turn * turns) / turn)
    parts = hann * modulated
    one, other = value(LINE, with_parts(parts * 1.1), None), value(LINE, with_parts(parts), None)
    one, other = one._replace(shares=hann), other._replace(shares=hann)
    assert error(LINE, one, other, turn) == pytest.approx(0.1, rel=1e-9)
    assert error(LINE, one, other, 1.0) > 0.11  # passes as they are would look like chaos


def test_a_healthy_twin_is_taken_off_pass_by_pass() -> None:
    own, twin = trial(3.0, scatter=0.2, names=NAMES), trial(1.0, scatter=0.2, names=NAMES)
    found = value(f"{LINE}-healthy", own, twin)
    assert found.value == pytest.approx(abs((own.lines[LINE] - twin.lines[LINE]).sum()), rel=1e-12)
    assert found.value == pytest.approx(2.0 / 3.0 * value(LINE, own, twin).value, rel=1e-9)
    turned = replace(twin, lines={LINE: -twin.lines[LINE]})  # against its phase: the two add up
    assert value(f"{LINE}-healthy", own, turned).value == pytest.approx(2.0 * found.value, rel=1e-9)


@pytest.mark.parametrize(("passes", "turns"), [(1, 0.0), (1, 1.0), (16, 9.0)])
def test_one_block_tells_nothing_of_scatter_so_nothing_is_sure(passes: int, turns: float) -> None:
    one = trial(3.0, passes, names=NAMES)
    assert all(math.isinf(off(feature, one, one, turns)) for feature in ALL)
