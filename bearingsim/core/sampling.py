"""Resampling from integrator steps to samples by linear-phase low-pass filters with compensated delay.

Three stages. ``decimate`` reduces the recording of one ball pass from thousands of steps to ``M`` fine samples (M
divides the number of steps, so that spectral lines are computed over whole passes without leakage). ``low_pass``
removes the content above the band of the user's sampling. ``interpolate`` evaluates the result at the user's
sample times, anywhere between fine samples. All use Kaiser-windowed sincs (Kaiser 1974); ``interpolate_linearly``
is the alternative without filter, in which impacts alias.
"""

from functools import lru_cache

import numpy as np

from bearingsim.core.jit import jit
from bearingsim.core.vectors import dot

# fine samples on each side: flat to 1e-4 below 0.15 of the fine rate, the band of the second stage (0.6 of a
# sampling rate that is at most a quarter of the fine rate); attenuation of 85 dB above 0.85, which aliases into
# this band
DECIMATION_HALF_LENGTH = 4
RESAMPLE_HALF_LENGTH = 13  # samples on each side: flat to 0.4 of the sampling rate, attenuation of 80 dB above 0.6
# fine samples on each side: exact to 1e-6 below 0.15 of the fine rate, the remaining band
INTERPOLATION_HALF_LENGTH = 6
KERNEL_ENTRIES = 1024  # entries of the interpolation kernel per fine sample


def kaiser_sinc(t: np.ndarray, cutoff: float, half_length: float, decibels: float) -> np.ndarray:
    """Return the kernel of a low-pass at ``t`` (in sample periods), with ``cutoff`` in cycles per period, zero
    beyond ``half_length``."""
    beta = 0.1102 * (decibels - 8.7)
    inside = np.clip(1.0 - (t / half_length) ** 2, 0.0, None)
    window = np.where(np.abs(t) <= half_length, np.i0(beta * np.sqrt(inside)) / np.i0(beta), 0.0)
    return 2.0 * cutoff * np.sinc(2.0 * cutoff * t) * window


@lru_cache(maxsize=64)
def decimation_kernel(D: int) -> np.ndarray:
    """Return the taps (2 D DECIMATION_HALF_LENGTH + 1,) of the first stage for decimation by D; their sum is 1."""
    t = np.arange(-D * DECIMATION_HALF_LENGTH, D * DECIMATION_HALF_LENGTH + 1) / D
    taps = kaiser_sinc(t, 0.5, DECIMATION_HALF_LENGTH, 88.0)
    return taps / taps.sum()


@lru_cache(maxsize=64)
def sampling_kernel(ratio: float) -> np.ndarray:
    """Return the taps (odd) of the second stage, at ``ratio`` (1.2 or more) fine samples per sample; their sum
    is 1."""
    half_length = int(np.ceil(RESAMPLE_HALF_LENGTH * ratio))
    taps = kaiser_sinc(np.arange(-half_length, half_length + 1) / ratio, 0.5, RESAMPLE_HALF_LENGTH, 80.0)
    return taps / taps.sum()


@lru_cache(maxsize=1)
def interpolation_kernel() -> np.ndarray:
    """Return one half of the third stage's symmetric kernel, with KERNEL_ENTRIES per fine sample and a final
    zero."""
    t = np.arange(INTERPOLATION_HALF_LENGTH * KERNEL_ENTRIES + 2) / KERNEL_ENTRIES
    return kaiser_sinc(t, 0.5, INTERPOLATION_HALF_LENGTH, 120.0)


@jit
def decimate(raw, taps, D, out):
    """Filter the C signals ``raw`` (C, n) and keep one sample in D.

    out[c, m] is centred on column m D + len(taps)//2 + D - 1.

    Column 0 of ``raw`` is the step after a fine sample, so fine samples lie at columns D - 1, 2 D - 1, ...; the
    first output is the first one with all its neighbours in ``raw``.
    """
    length = len(taps)
    for c in range(out.shape[0]):
        for m in range(out.shape[1]):
            start = (m + 1) * D - 1
            out[c, m] = dot(taps, raw[c, start : start + length], length)


@jit
def low_pass(fine, taps, out, begin, end):
    """Filter ``fine`` (C, n + len(taps) - 1) into the columns ``begin`` <= m < ``end`` of ``out`` (C, n).

    Sample m is centred on m + len(taps)//2.
    """
    length = len(taps)
    for c in range(out.shape[0]):
        for m in range(begin, end):
            out[c, m] = dot(taps, fine[c, m : m + length], length)


@jit
def interpolate(fine, origin, ratio, kernel, weights, out, begin, end):
    """Interpolate values out[:, n] at positions origin + n ratio of ``fine`` (C, m), begin <= n < end.

    fine: without content above 0.15 of its rate; weights: (2 INTERPOLATION_HALF_LENGTH,) workspace. The weights
    are normalised, so a constant is preserved.
    """
    for n in range(begin, end):
        position = origin + n * ratio
        low = int(np.floor(position)) - INTERPOLATION_HALF_LENGTH + 1
        total = 0.0
        for k in range(2 * INTERPOLATION_HALF_LENGTH):
            distance = abs(low + k - position) * KERNEL_ENTRIES
            i = int(distance)
            weights[k] = kernel[i] + (distance - i) * (kernel[i + 1] - kernel[i])
            total += weights[k]
        for c in range(out.shape[0]):
            out[c, n] = (
                dot(weights, fine[c, low : low + 2 * INTERPOLATION_HALF_LENGTH], 2 * INTERPOLATION_HALF_LENGTH)
                / total
            )


@jit
def interpolate_linearly(raw, origin, ratio, out, begin, end):
    """Interpolate raw values linearly: out[:, n] at column origin + n ratio of ``raw`` (C, m), begin <= n < end.

    ``out`` is the whole record, because a slice of it would compile a second copy.
    """
    for n in range(begin, end):
        position = origin + n * ratio
        i = min(int(position), raw.shape[1] - 2)
        for c in range(out.shape[0]):
            out[c, n] = raw[c, i] + (position - i) * (raw[c, i + 1] - raw[c, i])
