"""Causal low-pass."""

import numpy as np
import pytest

from bearingsim import signals
from bearingsim.core.sampling import kaiser_sinc

FS = 1000.0


def test_causal_filter_rings_only_after_impact():
    t = np.arange(400) - 200.25  # samples; the impact falls between two
    zero_phase = kaiser_sinc(t, 0.5, 13.0, 80.0)
    filtered = signals.causal_low_pass(zero_phase)
    largest = np.abs(filtered).max()
    assert np.abs(zero_phase[:199]).max() > 0.05 * np.abs(zero_phase).max()
    assert np.abs(filtered[:199]).max() < 0.002 * largest
    assert np.abs(filtered[201:]).max() == pytest.approx(largest)


def test_amplitudes_are_preserved():
    t = np.arange(2000) / FS
    series = np.sin(2.0 * np.pi * 40.0 * t) + 5.0
    filtered = signals.causal_low_pass(series)[500:1500]
    assert filtered.mean() == pytest.approx(5.0, abs=1e-3)
    assert filtered.std() == pytest.approx(np.sqrt(0.5), rel=1e-3)


def test_short_series_and_rows_are_accepted():
    rows = np.ones((2, 5))
    assert signals.causal_low_pass(rows) == pytest.approx(rows)
