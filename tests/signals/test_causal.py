"""A low-pass without delay, seen as the causal one of the same gain."""

import numpy as np
import pytest

from bearingsim import signals
from bearingsim.core.sampling import kaiser_sinc

FS = 1000.0


def test_an_impact_rings_after_it_only():
    t = np.arange(400) - 200.25  # samples; the impact falls between two
    zero_phase = kaiser_sinc(t, 0.5, 13.0, 80.0)
    after = signals.causal(zero_phase)
    largest = np.abs(after).max()
    assert np.abs(zero_phase[:199]).max() > 0.05 * np.abs(zero_phase).max()
    assert np.abs(after[:199]).max() < 0.002 * largest
    assert np.abs(after[201:]).max() == pytest.approx(largest)


def test_amplitudes_stay():
    t = np.arange(2000) / FS
    slow = np.sin(2.0 * np.pi * 40.0 * t) + 5.0
    turned = signals.causal(slow)[500:1500]
    assert turned.mean() == pytest.approx(5.0, abs=1e-3)
    assert turned.std() == pytest.approx(np.sqrt(0.5), rel=1e-3)


def test_a_short_series_and_rows_are_taken():
    rows = np.ones((2, 5))
    assert signals.causal(rows) == pytest.approx(rows)
