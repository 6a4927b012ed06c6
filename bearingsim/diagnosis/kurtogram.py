"""Kurtogram: kurtosis of the envelope by frequency band, which shows the most impulsive band of a signal."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from bearingsim.signals.spectra import PASSBAND_EDGE

LEVELS = 5
"""Number of halvings of the band: the narrowest is 1/32 of the range up to 0.4 of the sampling rate."""


class Kurtogram(NamedTuple):
    """Excess kurtosis of the complex envelope (LEVELS + 1, 2^LEVELS), and edges (Hz) of the narrowest bands.

    Level k has 2^k bands, whose values are repeated to 2^LEVELS columns. best: band (Hz) of the largest kurtosis.
    """

    kurtosis: np.ndarray
    edges: np.ndarray
    best: tuple[float, float]


def kurtogram(series: np.ndarray, fs: float) -> Kurtogram:
    """Compute the kurtogram of a series (n,) sampled at ``fs`` (Hz), up to 0.4 of it.

    Bands are cut from the Fourier transform; the complex envelope of each, decimated to its width, has the
    kurtosis <|c|^4>/<|c|^2>^2 - 2, 0 for Gaussian noise (Antoni, Fast computation of the kurtogram for the
    detection of transient faults, Mech. Syst. Signal Process. 21, 2007, 108-124, by Fourier bands instead of
    filters). Level 0, the whole range, is not a candidate for ``best``. Bands do not overlap, so a resonance at an
    edge is divided between two bands. The kurtosis of a band without bins, in a very short series, is 0.
    """
    transform = np.fft.rfft(series - series.mean())
    limit = 2 * PASSBAND_EDGE * (len(transform) - 1)
    values = np.zeros((LEVELS + 1, 2**LEVELS))
    for level in range(LEVELS + 1):
        edges = np.linspace(0, limit, 2**level + 1).astype(int)
        for band, (low, high) in enumerate(pairwise(edges)):
            part = transform[low:high]
            power = np.abs(np.fft.ifft(part)) ** 2 if len(part) else np.zeros(1)
            mean = power.mean()
            columns = 2 ** (LEVELS - level)
            values[level, band * columns : (band + 1) * columns] = (
                np.mean(power**2) / mean**2 - 2.0 if mean else 0.0
            )
    edges = np.linspace(0.0, PASSBAND_EDGE * fs, 2**LEVELS + 1)
    row, column = map(int, np.unravel_index(np.argmax(values[1:]), values[1:].shape))
    width = 2 ** (LEVELS - row - 1)
    begin = column // width * width
    return Kurtogram(values, edges, (float(edges[begin]), float(edges[begin + width])))
