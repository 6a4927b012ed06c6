"""Kurtogram by a tree of filters, as published: J. Antoni, Fast computation of the kurtogram for the detection of
transient faults, Mech. Syst. Signal Process. 21 (2007) 108-124, section 4.

Two quasi-analytic filters, a low-pass of cut-off 1/8 (of the sampling rate) shifted to 1/8 and 3/8, split the band
0 to 1/2 in halves; each half is decimated by two, moved to 0 to 1/2, and split again. The kurtosis of the complex
envelope c is <|c|^4>/<|c|^2>^2 - 2 (eq. 8).
"""

import numpy as np
from scipy.signal import firwin

ORDER = 64
"""Of the filters; the author's program has 16 and a cut-off of 0.2, so that neighbouring bands overlap widely."""
CUT_OFF = 0.125
"""Of the sampling rate."""
_TAPS = np.arange(ORDER + 1)
_LOW_PASS = firwin(ORDER + 1, CUT_OFF, fs=1.0)
LOW = _LOW_PASS * np.exp(0.25j * np.pi * _TAPS)
HIGH = _LOW_PASS * np.exp(0.75j * np.pi * _TAPS)
"""Filters (taps,) of the lower and the upper half of a band."""


def excess(envelope):
    """Return the kurtosis of a complex envelope (n,), 0 for Gaussian noise."""
    power = np.abs(envelope[ORDER:]) ** 2
    return np.mean(power**2) / np.mean(power) ** 2 - 2.0


def halves(signal):
    """Return the envelopes (n / 2,) of the lower and the upper half of the band of a signal (n,), in 0 to 1/2.

    Decimation moves the upper half to 1/2 to 1; the factor (-1)^n moves it to 0 to 1/2.
    """
    low, high = (np.convolve(signal, taps)[1 : len(signal) : 2] for taps in (LOW, HIGH))
    return low, high * (-1.0) ** np.arange(len(high))


def kurtogram(signal, levels):
    """Return the kurtosis of the bands by level, a list of arrays (2^k,) for k = 1 ... ``levels``."""
    bands, kurtoses = [signal - signal.mean()], []
    for _ in range(levels):
        bands = [half for band in bands for half in halves(band)]
        kurtoses.append(np.array([excess(band) for band in bands]))
    return kurtoses
