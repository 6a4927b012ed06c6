"""Kurtogram against the published algorithm, which splits bands by filters."""

import numpy as np
import pytest
from scipy.signal import resample

from bearingsim.diagnosis.kurtogram import LEVELS, kurtogram
from bearingsim.signals.spectra import PASSBAND_EDGE
from tests.independent import kurtogram as published
from tests.scenes.impacts import LINES, RATE, impacts

SIGNALS = (
    (2000.0, 1.0), (1800.0, 1.0), (2300.0, 1.0), (2600.0, 1.5), (2900.0, 1.5), (3300.0, 1.0), (3700.0, 1.5),
    (4200.0, 1.0), (4500.0, 2.0), (4800.0, 1.0),
)  # fmt: skip
"""Resonance (Hz) and noise over the impacts."""
DAMPING = 0.03
"""Of the resonance: half of its half-power bandwidth, relative."""


def signal_of(number):
    """Return a signal (n,) of impacts behind a resonance."""
    resonance, noise = SIGNALS[number]
    return impacts(LINES.outer, slip=0.005, noise=noise, resonance=resonance, seed=number)


def published_of(series):
    """Return the published kurtoses by level, of 0 to 0.4 of the rate, which resampling makes the whole band."""
    return published.kurtogram(resample(series, round(2.0 * PASSBAND_EDGE * len(series))), LEVELS)


@pytest.mark.parametrize("number", range(len(SIGNALS)))
def test_bands_have_the_kurtosis_of_the_published_algorithm(number):
    series = signal_of(number)
    image, expected = kurtogram(series, RATE), published_of(series)
    own = [image.kurtosis[level][:: 2 ** (LEVELS - level)] for level in range(1, LEVELS + 1)]
    assert np.corrcoef(np.concatenate(own), np.concatenate(expected))[0, 1] > 0.9
    level = max(range(LEVELS), key=lambda level: expected[level].max())
    assert own[level][np.argmax(expected[level])] > 0.95 * max(values.max() for values in own)


@pytest.mark.parametrize("number", range(len(SIGNALS)))
def test_the_chosen_band_is_around_the_resonance(number):
    """One at the edge of two bands, as that of 2600 Hz, may be in either."""
    low, high = kurtogram(signal_of(number), RATE).best
    resonance = SIGNALS[number][0]
    assert low < (1.0 + DAMPING) * resonance
    assert (1.0 - DAMPING) * resonance < high


def test_noise_has_no_kurtosis():
    image = kurtogram(np.random.default_rng(0).normal(size=1 << 17), RATE)
    assert np.abs(image.kurtosis[:4]).max() < 0.1
