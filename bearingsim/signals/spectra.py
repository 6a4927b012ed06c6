"""Spectra of a series and of its squared envelope."""

from collections.abc import Callable

import numpy as np


def hann(n: int) -> np.ndarray:
    """Return the periodic Hann window (n,), whose main lobe is four bins wide."""
    return np.sin(np.pi * np.arange(n) / n) ** 2


def spectrum(
    series: np.ndarray, fs: float, window: Callable[[int], np.ndarray] = hann
) -> tuple[np.ndarray, np.ndarray]:
    """Compute the one-sided amplitude spectrum of a series (n,) sampled at ``fs`` (Hz), without its mean.

    window: function that returns the weights (n,) of n samples (``np.ones``: no window). Returns frequencies (Hz),
    fs/n apart, and 0-peak amplitudes in the unit of the series, (n//2 + 1,) each. The amplitude of a sine at the
    centre of a bin is exact with any window; between two bins it is up to 15 % smaller with a Hann window.
    """
    weights = window(len(series))
    amplitudes = np.abs(np.fft.rfft((series - series.mean()) * weights)) * (2.0 / weights.sum())
    amplitudes[0] /= 2.0
    if len(series) % 2 == 0:
        amplitudes[-1] /= 2.0  # like the mean, the Nyquist frequency has no negative counterpart
    return np.fft.rfftfreq(len(series), 1.0 / fs), amplitudes


def cut_to_whole_periods(series: np.ndarray, fs: float, frequency: float) -> np.ndarray:
    """Cut a series (n,) sampled at ``fs`` (Hz) to whole periods of ``frequency`` (Hz), unless it has none."""
    periods = int(len(series) / fs * frequency + 1e-9)
    count = min(len(series), round(periods * fs / frequency))
    return series[: count or None]


def squared_envelope(series: np.ndarray, fs: float, band: tuple[float, float] | None = None) -> np.ndarray:
    """Compute the squared envelope (n,) of a series (n,), or of its content in ``band`` (Hz).

    Negative frequencies and those outside the band are set to zero in the Fourier transform (Randall and Antoni,
    Rolling element bearing diagnostics - a tutorial, Mech. Syst. Signal Process. 25, 2011, 485-520). The record is
    treated as periodic, so about the inverse of the bandwidth is distorted at both ends. Raises ValueError if the
    band is empty or not within 0 to fs/2.
    """
    low, high = band or (0.0, fs / 2.0)
    if not 0.0 <= low < high <= fs / 2.0:
        raise ValueError(f"a band from {low:g} to {high:g} Hz is not within 0 to {fs / 2.0:g} Hz")
    frequencies = np.fft.rfftfreq(len(series), 1.0 / fs)
    transform = np.fft.rfft(series) * ((frequencies >= low) & (frequencies <= high) & (frequencies > 0.0))
    return np.abs(analytic(transform, len(series))) ** 2


def band_pass(series: np.ndarray, fs: float, band: tuple[float, float]) -> np.ndarray:
    """Filter a series (n,) sampled at ``fs`` (Hz): keep its content in ``band`` (Hz), with zero phase.

    Both ends are extended by their mirror image, so about the inverse of the bandwidth is distorted there. Raises
    ValueError if the band is empty or not within 0 to fs/2.
    """
    low, high = band
    if not 0.0 <= low < high <= fs / 2.0:
        raise ValueError(f"a band from {low:g} to {high:g} Hz is not within 0 to {fs / 2.0:g} Hz")
    mirrored = np.concatenate([series, series[-2:0:-1]])
    frequencies = np.fft.rfftfreq(len(mirrored), 1.0 / fs)
    transform = np.fft.rfft(mirrored) * ((frequencies >= low) & (frequencies <= high))
    return np.asarray(np.fft.irfft(transform, len(mirrored))[: len(series)])


def analytic(one_sided: np.ndarray, n: int) -> np.ndarray:
    """Compute the analytic signal (n,) of a real series of n samples, from its one-sided transform (n//2 + 1,)."""
    transform = np.zeros(n, dtype=complex)
    transform[: len(one_sided)] = 2.0 * one_sided
    transform[0] = one_sided[0]
    if n % 2 == 0:
        transform[n // 2] = one_sided[-1]
    return np.fft.ifft(transform)


PASSBAND_EDGE = 0.4
"""Fraction of the sampling rate up to which the low-pass of records is flat. Above it, residual content between
0.5 and 0.6 of the sampling rate aliases to frequencies without lines, and would appear in an envelope spectrum."""


def envelope_spectrum(
    series: np.ndarray, fs: float, band: tuple[float, float] | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Compute the envelope spectrum of a series (n,) sampled at ``fs`` (Hz), from the squared envelope.

    Impacts excite resonances, and the envelope shows their repetition (Randall and Antoni 2011; squared, because
    the square root adds harmonics that alias). band: of the resonance (Hz), by default up to ``PASSBAND_EDGE`` of
    ``fs``. Returns frequencies (Hz) and amplitudes in the squared unit of the series, as ``spectrum``. Raises
    ValueError as ``squared_envelope``.
    """
    return spectrum(squared_envelope(series, fs, band or (0.0, PASSBAND_EDGE * fs)), fs)


def band_rms(series: np.ndarray, fs: float, band: tuple[float, float]) -> float:
    """Compute the RMS of a series (n,) sampled at ``fs`` (Hz) in ``band`` (Hz, ends included), without its mean.

    The power spectrum of a Hann window, whose noise bandwidth is 1.5 fs/n, is summed over the band, so a line
    closer than this to an end of the band contributes in part. Returns NaN for a band between two bins. Raises
    ValueError if the band is empty or not within 0 to fs/2.
    """
    low, high = band
    if not 0.0 <= low < high <= fs / 2.0:
        raise ValueError(f"a band from {low:g} to {high:g} Hz is not within 0 to {fs / 2.0:g} Hz")
    weights = hann(len(series))
    transform = np.fft.rfft((series - np.average(series, weights=weights)) * weights)
    frequencies = np.fft.rfftfreq(len(series), 1.0 / fs)
    inside = (frequencies >= low) & (frequencies <= high)
    if not inside.any():
        return float("nan")
    power = 2.0 * np.abs(transform) ** 2
    if len(series) % 2 == 0:
        power[-1] /= 2.0  # the Nyquist frequency has no negative counterpart
    return float(np.sqrt(power[inside].sum() / (len(series) * np.sum(weights**2))))


MIRROR_LENGTH = 64
"""Samples by which a series is extended at both ends for filtering."""
PHASE_POINTS, PHASE_RANGE = 1 << 14, 4
"""Number of frequencies at which the gain is evaluated for its minimum phase, and their range over the sampling
rate (from -2 to 2 times the sampling rate)."""
STOPBAND_GAIN = 1e-4
"""Gain above half of the sampling rate: its logarithm must be finite."""


def causal_low_pass(series: np.ndarray) -> np.ndarray:
    """Filter a series (..., n) with a causal low-pass, flat up to ``PASSBAND_EDGE`` of its sampling rate.

    The gain falls to ``STOPBAND_GAIN`` at half the sampling rate. A zero-phase low-pass, such as that of a record,
    rings before an impact; this minimum-phase filter rings only after it. Its phase is the Hilbert transform of
    the logarithm of its gain (Oppenheim and Schafer, Discrete-Time Signal Processing, ch. 13). Both ends are
    extended by their mirror image, so some samples there are distorted.
    """
    n = series.shape[-1]
    margin = min(n - 1, MIRROR_LENGTH)
    extended = np.concatenate([series[..., margin:0:-1], series, series[..., -2 : -2 - margin : -1]], axis=-1)
    frequencies = np.fft.rfftfreq(extended.shape[-1])
    response = _gain(frequencies) * np.exp(1j * _minimum_phase(frequencies))
    return np.fft.irfft(np.fft.rfft(extended) * response, extended.shape[-1])[..., margin : margin + n]


def _gain(frequency: np.ndarray) -> np.ndarray:
    """Compute the gain of the low-pass; frequency: relative to the sampling rate."""
    transition = np.clip((frequency - PASSBAND_EDGE) / (0.5 - PASSBAND_EDGE), 0.0, 1.0)
    return np.maximum(np.cos(0.5 * np.pi * transition) ** 2, STOPBAND_GAIN)


def _minimum_phase(frequency: np.ndarray) -> np.ndarray:
    """Compute the phase (rad) of the minimum-phase filter with the gain ``_gain``, from its real cepstrum.

    frequency: relative to the sampling rate.
    """
    frequencies, half = np.fft.fftfreq(PHASE_POINTS, 1.0 / PHASE_RANGE), PHASE_POINTS // 2
    cepstrum = np.fft.ifft(np.log(_gain(np.abs(frequencies)))).real
    cepstrum[1:half] *= 2.0
    cepstrum[half + 1 :] = 0.0
    return np.interp(frequency, frequencies[:half], np.fft.fft(cepstrum).imag[:half])
