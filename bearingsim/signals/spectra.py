"""Spectra of a series and of its squared envelope."""

from collections.abc import Callable

import numpy as np


def hann(n: int) -> np.ndarray:
    """Return a periodic Hann window of n samples; its main lobe is four bins wide."""
    return np.sin(np.pi * np.arange(n) / n) ** 2


def spectrum(
    series: np.ndarray, fs: float, window: Callable[[int], np.ndarray] = hann
) -> tuple[np.ndarray, np.ndarray]:
    """Compute the one-sided amplitude spectrum of a series (n,) sampled at ``fs`` (Hz), without its mean.

    Returns frequencies (Hz), fs/n apart, and amplitudes in the series' unit, (n//2 + 1,) each: a sine on a bin
    gives its amplitude with any window; between two bins of a Hann window up to 15 % less. ``window`` gives the
    weights (n,) for n samples (``np.ones``: none).
    """
    weight = window(len(series))
    amplitudes = np.abs(np.fft.rfft((series - series.mean()) * weight)) * (2.0 / weight.sum())
    amplitudes[0] /= 2.0
    if len(series) % 2 == 0:
        amplitudes[-1] /= 2.0  # the Nyquist line has no mirror image either
    return np.fft.rfftfreq(len(series), 1.0 / fs), amplitudes


def whole_periods(series: np.ndarray, fs: float, frequency: float) -> np.ndarray:
    """Cut a series (n,) sampled at ``fs`` (Hz) to whole periods of ``frequency`` (Hz), if it has any."""
    periods = int(len(series) / fs * frequency + 1e-9)
    count = min(len(series), round(periods * fs / frequency))
    return series[: count or None]


def squared_envelope(series: np.ndarray, fs: float, band: tuple[float, float] | None = None) -> np.ndarray:
    """Compute the squared envelope (n,) of a series (n,), or of its content in ``band`` (Hz).

    Negative frequencies and those outside the band are set to zero in the Fourier transform (Randall and Antoni,
    Rolling element bearing diagnostics - a tutorial, Mech. Syst. Signal Process. 25, 2011, 485-520). The record is
    treated as periodic, so its two ends mix over about the inverse of the bandwidth. Raises ValueError if the band
    is empty or not within 0 to fs/2.
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


FLAT = 0.4
"""Fraction of the sampling rate up to which records of bearingsim are unaltered. Residual content between 0.5
and 0.6 of the sampling rate aliases to frequencies without lines and would appear in an envelope spectrum."""


def envelope_spectrum(
    series: np.ndarray, fs: float, band: tuple[float, float] | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Compute the envelope spectrum of a series (n,) sampled at ``fs`` (Hz), from the squared envelope.

    Impacts excite resonances; the envelope shows their repetition (Randall and Antoni 2011; squared, because its
    root adds harmonics that alias). ``band`` (Hz): of the resonance; by default up to ``FLAT`` of ``fs``. Returns
    frequencies (Hz) and amplitudes in the series' unit squared, as ``spectrum`` does. Raises ValueError as
    ``squared_envelope``.
    """
    return spectrum(squared_envelope(series, fs, band or (0.0, FLAT * fs)), fs)


def band_rms(series: np.ndarray, fs: float, band: tuple[float, float]) -> float:
    """Compute the RMS of a series (n,) sampled at ``fs`` (Hz) in ``band`` (Hz, ends included), without its mean.

    The RMS is summed over the power spectrum with a Hann window of bandwidth 1.5 fs/n, so a line closer than this
    to an end of the band contributes in part. Returns nan for a band between two bins. Raises ValueError if the
    band is empty or not within 0 to fs/2.
    """
    low, high = band
    if not 0.0 <= low < high <= fs / 2.0:
        raise ValueError(f"a band from {low:g} to {high:g} Hz is not within 0 to {fs / 2.0:g} Hz")
    weight = hann(len(series))
    transform = np.fft.rfft((series - np.average(series, weights=weight)) * weight)
    frequencies = np.fft.rfftfreq(len(series), 1.0 / fs)
    inside = (frequencies >= low) & (frequencies <= high)
    if not inside.any():
        return float("nan")
    power = 2.0 * np.abs(transform) ** 2
    if len(series) % 2 == 0:
        power[-1] /= 2.0  # the Nyquist line has no mirror image
    return float(np.sqrt(power[inside].sum() / (len(series) * np.sum(weight**2))))


MIRROR_LENGTH = 64
"""Samples by which a series is extended at both ends for filtering."""
PHASE_POINTS, PHASE_RATES = 1 << 14, 4
"""Points at which the gain is evaluated, up to ``PHASE_RATES``/2 times the sampling rate."""
STOP_GAIN = 1e-4
"""Gain above half of the sampling rate."""


def causal(series: np.ndarray) -> np.ndarray:
    """Filter a series (..., n) with a causal low-pass, flat up to ``FLAT`` of its sampling rate and zero at half
    of it.

    A zero-phase low-pass, such as that of a record, rings before an impact; this minimum-phase filter rings only
    after it (its phase is the Hilbert transform of the gain's logarithm: Oppenheim and Schafer, Discrete-Time
    Signal Processing, ch. 13). Both ends are extended by their mirror image, so some samples there are distorted.
    """
    n = series.shape[-1]
    margin = min(n - 1, MIRROR_LENGTH)
    extended = np.concatenate([series[..., margin:0:-1], series, series[..., -2 : -2 - margin : -1]], axis=-1)
    frequencies = np.fft.rfftfreq(extended.shape[-1])
    response = _gain(frequencies) * np.exp(1j * _minimum_phase(frequencies))
    return np.fft.irfft(np.fft.rfft(extended) * response, extended.shape[-1])[..., margin : margin + n]


def _gain(frequency: np.ndarray) -> np.ndarray:
    """Compute the gain of the low-pass; frequency: relative to the sampling rate."""
    transition = np.clip((frequency - FLAT) / (0.5 - FLAT), 0.0, 1.0)
    return np.maximum(np.cos(0.5 * np.pi * transition) ** 2, STOP_GAIN)


def _minimum_phase(frequency: np.ndarray) -> np.ndarray:
    """Compute the phase (rad) of the minimum-phase filter with that gain."""
    frequencies, half = np.fft.fftfreq(PHASE_POINTS, 1.0 / PHASE_RATES), PHASE_POINTS // 2
    cepstrum = np.fft.ifft(np.log(_gain(np.abs(frequencies)))).real
    cepstrum[1:half] *= 2.0
    cepstrum[half + 1 :] = 0.0
    return np.interp(frequency, frequencies[:half], np.fft.fft(cepstrum).imag[:half])
