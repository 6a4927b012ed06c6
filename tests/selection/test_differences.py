"""Errors between trials of known difference."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import stdtrit

from bearingsim.selection.differences import difference_bound, feature_value
from bearingsim.simulation.trial import Trial, line_amplitudes, revolution_spans
from tests.scenes.trials import PASSES, trial

LINE, RMS, FORCE = "velocity@BPFO", "velocity.rms", "outer_force.max"
NAMES = (LINE, RMS)
ALL = (LINE, RMS, FORCE)


def off(feature: str, own: Trial, other: Trial) -> float:
    return difference_bound(feature_value(feature, own, None), feature_value(feature, other, None))


def with_parts(parts: np.ndarray) -> Trial:
    """A trial of a line, by its pairs of turns; the whole is their mean."""
    turns = len(parts) + 1
    amplitudes = np.array([parts.mean(), *parts]).astype(complex)
    return Trial(turns, turns, False, {LINE: amplitudes}, {}, np.ones(turns))


@pytest.mark.parametrize("feature", ALL)
def test_error_against_itself_is_zero(feature: str) -> None:
    assert off(feature, trial(3.0, scatter=0.1, names=NAMES), trial(3.0, scatter=0.1, names=NAMES)) == 0.0


@pytest.mark.parametrize("feature", ALL)
def test_error_of_constant_offset_is_the_offset(feature: str) -> None:
    shifted, other = trial(3.3, names=NAMES), trial(3.0, names=NAMES)
    assert feature_value(feature, shifted, None).value == pytest.approx(3.3, rel=1e-12)
    assert off(feature, shifted, other) == pytest.approx(0.3, rel=1e-9)
    assert off(feature, other, shifted) == pytest.approx(0.3, rel=1e-9)


def windowed(noise: np.ndarray) -> Trial:
    """A trial of a line of noise: (turns, samples), read as a run's is."""
    turns, per_turn = noise.shape
    spans = revolution_spans(turns, 1.0, per_turn)
    angles = 2.0 * np.pi * 8.0 / per_turn * np.arange(noise.size)[np.newaxis]
    return Trial(turns, turns, False, {LINE: line_amplitudes(noise.ravel(), angles, spans)}, {}, np.ones(turns))


def test_error_covers_scatter_at_confidence_level() -> None:
    """Of many draws of equal lines under noise, whose true difference is none, the error covers 95 %."""
    rng, line = np.random.default_rng(3), np.cos(2.0 * np.pi * np.arange(PASSES * 64) / 8.0).reshape(PASSES, 64)
    result = []
    for _ in range(400):
        pair = [windowed(line + 0.1 * rng.normal(size=line.shape)) for _ in range(2)]
        difference = abs(feature_value(LINE, pair[0], None).value - feature_value(LINE, pair[1], None).value)
        result.append((off(LINE, pair[0], pair[1]) - difference, difference))
    more, difference = np.array(result).T
    assert np.median(more) == pytest.approx(stdtrit(PASSES - 2, 0.975) * np.sqrt(np.mean(difference**2)), rel=0.15)
    assert np.mean(difference < more) == pytest.approx(0.95, abs=0.03)


def test_scatter_of_rms_is_from_half_the_power() -> None:
    rng = np.random.default_rng(4)
    noise = [np.array([0.0, *0.1 * rng.normal(size=PASSES - 1)]) for _ in range(2)]
    pair = [
        Trial(PASSES, PASSES, False, {}, {RMS: (1.0 + deviation) * 4.0}, np.ones(PASSES)) for deviation in noise
    ]
    s = float(np.std((noise[0] - noise[1])[1:], ddof=1)) * np.sqrt(2.0 / PASSES)  # half of 4, over an RMS of 2
    assert off(RMS, pair[0], pair[1]) == pytest.approx(stdtrit(PASSES - 2, 0.975) * s, rel=1e-9)


def test_healthy_case_is_subtracted_part_by_part() -> None:
    own, healthy = trial(3.0, scatter=0.2, names=NAMES), trial(1.0, scatter=0.2, names=NAMES)
    result = feature_value(f"{LINE}-healthy", own, healthy)
    assert result.value == pytest.approx(2.0, rel=1e-12)
    assert result.parts == pytest.approx(2.0 / 3.0 * feature_value(LINE, own, healthy).parts, rel=1e-9)
    turned = replace(healthy, amplitudes={LINE: -healthy.amplitudes[LINE]})  # against its phase: the two add up
    assert feature_value(f"{LINE}-healthy", own, turned).value == pytest.approx(2.0 * result.value, rel=1e-9)


@pytest.mark.parametrize("turns", [1, 2])
def test_error_is_infinite_with_one_part(turns: int) -> None:
    short = trial(3.0, turns, names=NAMES)
    assert all(math.isinf(off(feature, short, short)) for feature in (NAMES if turns == 2 else ALL))
