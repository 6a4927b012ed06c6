"""From integrator steps to samples: linear-phase low-pass filters whose delay is taken out.

Two stages. ``decimate`` brings the recording of one ball pass from thousands of steps to ``M`` fine samples (M
divides the steps, so that lines are read over whole passes without leakage). ``resample`` brings the fine
samples to the user's sampling, whose instants fall anywhere between them. Both are Kaiser-windowed sincs
(Kaiser 1974); ``pick`` is the raw alternative, which lets impacts alias.
"""

import numpy as np

from bearingsim.core.jit import add, jit

DECIMATION_REACH = 4  # fine samples on each side: flat to 1e-4 below 0.15 of the fine rate, which is all that the
# second stage lets through (0.6 of a sampling at most a quarter as fast), and 85 dB above 0.85, which folds there
RESAMPLE_REACH = 13  # samples on each side: flat to 0.4 of the sampling, 80 dB above 0.6
TABLE = 512  # entries of the resampling kernel per sample


def kaiser_sinc(t: np.ndarray, cutoff: float, reach: float, decibels: float) -> np.ndarray:
    """Kernel of a low-pass at ``t`` (in sample periods), ``cutoff`` in cycles a period, zero beyond ``reach``."""
    beta = 0.1102 * (decibels - 8.7)
    inside = np.clip(1.0 - (t / reach) ** 2, 0.0, None)
    window = np.where(np.abs(t) <= reach, np.i0(beta * np.sqrt(inside)) / np.i0(beta), 0.0)
    return 2.0 * cutoff * np.sinc(2.0 * cutoff * t) * window


def decimation_kernel(D: int) -> np.ndarray:
    """Taps (2 D DECIMATION_REACH + 1,) of the first stage, one in D kept; their sum is 1."""
    t = np.arange(-D * DECIMATION_REACH, D * DECIMATION_REACH + 1) / D
    taps = kaiser_sinc(t, 0.5, DECIMATION_REACH, 88.0)
    return taps / taps.sum()


def resampling_kernel() -> np.ndarray:
    """One side of the second stage's kernel, TABLE entries per sample, with a zero after the end."""
    t = np.arange(RESAMPLE_REACH * TABLE + 2) / TABLE
    return kaiser_sinc(t, 0.5, RESAMPLE_REACH, 80.0)


@jit
def dot(a, b, n):
    """Sum of a[k] b[k] over the first n."""
    total = 0.0
    for k in range(n):
        total = add(total, a[k] * b[k])
    return total


@jit
def decimate(raw, taps, D, out):
    """Filter ``raw`` (C, n) and keep one in D: out[c, m] is centred on column m D + len(taps)//2 + D - 1.

    That is: column 0 of ``raw`` is the step after a fine sample, so that fine samples lie at columns D - 1,
    2 D - 1, ...; the first output is the first of them with all its neighbours in ``raw``.
    """
    length = len(taps)
    for c in range(out.shape[0]):
        for m in range(out.shape[1]):
            start = (m + 1) * D - 1
            out[c, m] = dot(taps, raw[c, start : start + length], length)


@jit
def resample(fine, first, ratio, kernel, out):
    """Samples ``out`` (C, n) at fine positions first + n ratio of ``fine`` (C, m), low-passed to the new rate.

    ``ratio``: fine samples per sample, at least 1. The kernel is normalised at every sample, so a constant stays
    what it is.
    """
    reach = RESAMPLE_REACH * ratio
    weights = np.empty(int(2.0 * reach) + 3)
    for n in range(out.shape[1]):
        centre = first + n * ratio
        low = int(np.ceil(centre - reach))
        count = int(np.floor(centre + reach)) - low + 1
        total = 0.0
        for k in range(count):
            place = abs(low + k - centre) / ratio * TABLE
            i = int(place)
            weights[k] = kernel[i] + (place - i) * (kernel[i + 1] - kernel[i])
            total = add(total, weights[k])
        for c in range(out.shape[0]):
            out[c, n] = dot(weights, fine[c, low : low + count], count) / total


@jit
def pick(raw, first, ratio, out, begin, end):
    """Raw values between steps: out[:, n] at column first + n ratio of ``raw`` (C, m), begin <= n < end.

    Linear in between. ``out`` is the whole record: a slice of it would compile a second copy where it covers all.
    """
    for n in range(begin, end):
        place = first + n * ratio
        i = min(int(place), raw.shape[1] - 2)
        for c in range(out.shape[0]):
            out[c, n] = raw[c, i] + (place - i) * (raw[c, i + 1] - raw[c, i])
