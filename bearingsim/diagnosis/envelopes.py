"""Spectra of two squared envelopes of a signal, as heights: power over the local median.

Each roller that crosses a defect causes an impact, so a defect raises lines in both spectra. Other lines differ
between them: those of mains and gears with many harmonics are in the envelope of the band above 1 kHz, those of
modulated noise in the envelope of the levelled signal.
"""

from typing import NamedTuple

import numpy as np

from bearingsim.signals.spectra import PASSBAND_EDGE, analytic, hann, squared_envelope

BAND_START_HZ = 1000.0
"""Hz; lowest frequency of the band of the first envelope. Shaft orders and most gear meshes lie below."""
LEVEL_HALF_WIDTH_HZ = 50.0
"""Hz; half width of the moving median by which a spectrum is divided."""
MAX_LEVELLED = 3.0
"""Largest magnitude of a levelled spectrum, relative to the median: stronger lines are tones, not noise."""
MEDIAN_ORDERS = 1.5
"""Half width, in shaft orders, of the median to which heights refer."""
MIN_MEDIAN_BINS = 20
"""Minimum half width of that median in bins."""


class EnvelopeSpectrum(NamedTuple):
    """Envelope spectrum as power over the local median: frequencies (Hz) and heights, (n,) each."""

    frequency: np.ndarray
    height: np.ndarray

    @property
    def step(self) -> float:
        """Spacing of the frequencies (Hz)."""
        return float(self.frequency[1])


def default_band(fs: float) -> tuple[float, float]:
    """Return the band (Hz) of the first envelope spectrum at a sampling rate (Hz)."""
    return BAND_START_HZ, PASSBAND_EDGE * fs


def band_spectrum(
    series: np.ndarray, fs: float, shaft: float, highest: float, band: tuple[float, float] | None = None
) -> EnvelopeSpectrum:
    """Compute the spectrum of the squared envelope of a series (n,) in a band (Hz), up to a frequency (Hz).

    fs: sampling rate (Hz); shaft: frequency of the shaft (Hz); highest: highest frequency (Hz) of the result;
    band: ``default_band`` if None. Raises ValueError as ``squared_envelope``.
    """
    return _envelope_spectrum(squared_envelope(series, fs, band or default_band(fs)), fs, shaft, highest)


def levelled_spectrum(series: np.ndarray, fs: float, shaft: float, highest: float) -> EnvelopeSpectrum:
    """Compute the spectrum of the squared envelope of a levelled series, in which tones are as weak as noise.

    Arguments as for ``band_spectrum``. The Fourier transform is divided by its moving median magnitude within
    50 Hz, its magnitude is limited to ``MAX_LEVELLED``, and frequencies above ``PASSBAND_EDGE`` are set to zero.
    """
    n = len(series)
    transform = np.fft.rfft(series - series.mean())
    magnitude = np.abs(transform)
    level = local_median(magnitude, max(MIN_MEDIAN_BINS, round(LEVEL_HALF_WIDTH_HZ * n / fs)))
    with np.errstate(divide="ignore", invalid="ignore"):
        gain = np.where(level > 0.0, np.minimum(1.0 / level, MAX_LEVELLED / magnitude), 0.0)
    transform *= gain * (np.arange(len(transform)) <= PASSBAND_EDGE * n)
    return _envelope_spectrum(np.abs(analytic(transform, n)) ** 2, fs, shaft, highest)


def _envelope_spectrum(envelope: np.ndarray, fs: float, shaft: float, highest: float) -> EnvelopeSpectrum:
    n = len(envelope)
    count = min(n // 2 + 1, int(highest * n / fs) + 2)
    power = np.abs(np.fft.rfft((envelope - envelope.mean()) * hann(n))[:count]) ** 2
    median = local_median(power, max(MIN_MEDIAN_BINS, round(MEDIAN_ORDERS * shaft * n / fs)))
    height = np.divide(power, median, out=np.zeros(count), where=median > 0.0)
    return EnvelopeSpectrum(np.arange(count) * fs / n, height)


def local_median(values: np.ndarray, half_width: int) -> np.ndarray:
    """Compute the moving median (n,) of values (n,) within ``half_width`` values on each side.

    Values are mirrored at both ends. The median is computed at four positions per half width, and interpolated
    between them.
    """
    half_width = min(half_width, len(values) - 1)
    mirrored = np.pad(values, half_width, mode="reflect")
    stride = max(1, half_width // 4)
    windows = np.lib.stride_tricks.sliding_window_view(mirrored, 2 * half_width + 1)[::stride]
    return np.interp(np.arange(len(values)), np.arange(len(windows)) * stride, np.median(windows, axis=1))


def fast_length(n: int) -> int:
    """Return the largest even length up to ``n`` without prime factors over 5; n: at least 2.

    The Fourier transform of other lengths takes up to ten times longer.
    """
    lengths = [2**a * 3**b * 5**c for a in range(1, 40) for b in range(12) for c in range(9)]
    return max(length for length in lengths if length <= n)
