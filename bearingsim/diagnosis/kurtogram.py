"""Kurtosis of the envelope in bands of halved width: where a signal is most impulsive."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from bearingsim.signals.spectra import PASSBAND_EDGE

LEVELS = 5
"""Levels of the kurtogram: the narrowest band is 1/32 of half the sampling rate."""


class Kurtogram(NamedTuple):
    """Excess kurtosis of the complex envelope (levels, bands) and the edges of bands (Hz), by level.

    A level k has 2^k bands; rows are filled by repetition to 2^LEVELS columns. best: band (Hz) of the largest.
    """

    kurtosis: np.ndarray
    edges: np.ndarray
    best: tuple[float, float]


def kurtogram(series: np.ndarray, fs: float) -> Kurtogram:
    """Compute the kurtogram of a series (n,) sampled at ``fs`` (Hz), up to 0.4 of it.

    Bands are cut from the Fourier transform; the complex envelope of each, decimated to its width, has the
    kurtosis <|c|^4>/<|c|^2>^2 - 2, 0 for Gaussian noise (Antoni, Fast computation of the kurtogram for the
    detection of transient faults, Mech. Syst. Signal Process. 21, 2007, 108-124, by Fourier bands instead of
    filters). Level 0, the whole band, is not a candidate. Bands have no overlap, so a resonance on an edge counts
    in two halves. A band without a line, of a very short series, has 0.
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
            repeat = 2 ** (LEVELS - level)
            values[level, band * repeat : (band + 1) * repeat] = np.mean(power**2) / mean**2 - 2.0 if mean else 0.0
    edges = np.linspace(0.0, PASSBAND_EDGE * fs, 2**LEVELS + 1)
    row, column = map(int, np.unravel_index(np.argmax(values[1:]), values[1:].shape))
    width = 2 ** (LEVELS - row - 1)
    begin = column // width * width
    return Kurtogram(values, edges, (float(edges[begin]), float(edges[begin + width])))
