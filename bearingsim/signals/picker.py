"""Search for the spectral line near an expected frequency, also if other lines are close to it."""

from math import inf, pi
from typing import NamedTuple

import numpy as np

from bearingsim.signals.spectra import hann

# A bin is 1/T for a record of length T.
MIN_MEDIAN_RATIO = 2.0  # smallest amplitude over the local median; leakage and ripple can reach 1.5
MIN_HALF_WIDTH = 0.75  # bins; smallest half width of the searched band
PADDING = 4  # smallest number of samples of the spectrum per bin
MARGIN = 6.0  # bins on both sides of the searched band in which lines are fitted as well
MIN_SEPARATION = 1.5  # bins; smallest distance of two lines
SHOULDER_DISTANCE = 3.0  # bins from a strong line within which a weak one is a shoulder of its main lobe
SHOULDER_RATIO = 0.05  # amplitude of a weak line over that of the strong one, up to which it is a shoulder
MIN_RELATIVE_AMPLITUDE = 1e-3  # of a line, relative to the strongest of the fitted lines
MAX_LINES = 12  # lines fitted simultaneously
MAX_ITERATIONS = 30  # of the Gauss-Newton method
MAX_SHIFT = 0.25  # bins; largest change of a position in an iteration
SHIFT_TOLERANCE = 1e-8  # bins; change of the positions at which the iteration ends
INTERPOLATION_POWER = 0.23  # power of the amplitudes for which the main lobe of a Hann window is nearly parabolic


class PickedLine(NamedTuple):
    """Line in a spectrum: frequency (Hz), amplitude in the unit of the series, and its ratio to the local median.

    The largest of a hundred bins of white noise has a ratio of 3 to 4.
    """

    frequency: float
    amplitude: float
    median_ratio: float


def pick_line(series: np.ndarray, fs: float, expected: float, tolerance: float = 0.005) -> PickedLine | None:
    """Find the strongest line of a series (n,) within a relative ``tolerance`` of ``expected`` (Hz); ``fs`` in Hz.

    Returns None if there is no line.

    A Hann window over the record length T resolves lines 2/T apart, and masks a weak line closer than 4/T to a
    strong one. Neighbouring lines are therefore fitted simultaneously: one line at a time is added at the maximum
    of the residual, and frequency, amplitude and phase of all lines are refined by least squares on the complex
    spectrum, until the residual is below twice the local median or 1e-3 of the strongest line (RELAX: Li and
    Stoica, Efficient mixed-spectrum estimation with applications to target feature extraction, IEEE Trans. Signal
    Process. 44, 1996). A line is rejected if a stronger one lies within 1.5/T, or one 20 times as strong within
    3/T, because it would be a shoulder of that line. The median is that of the spectrum around the expected
    frequency, within 10 %, five tolerances or 20/T, whichever is largest.

    Raises ValueError if the half width expected * tolerance of the searched band is less than 0.75/T (at 159 Hz
    and 0.5 %: T less than 0.94 s), so that lines inside and outside cannot be distinguished, or if the band, with
    a margin of 8/T, reaches half the sampling rate. Limits: amplitude and speed must be constant over the record.
    A speed variation of 0.03 % changes the amplitude of a ten times weaker neighbour by 8 %, one of 0.1 % by 30 %,
    and one of 0.2 % turns a shoulder into a false line (at 159 Hz, in 1 s).
    """
    duration, half_width = len(series) / fs, tolerance * expected
    if half_width * duration < MIN_HALF_WIDTH:
        raise ValueError(
            f"a record of {duration:.4g} s is too short to separate a line at {expected:g} Hz within "
            f"{100 * tolerance:g} % from its neighbours: use {MIN_HALF_WIDTH / half_width:.4g} s or more"
        )
    if expected + half_width + (MARGIN + 2.0) / duration > fs / 2.0:
        raise ValueError(f"{expected:g} Hz is too near half the sampling rate, {fs / 2.0:g} Hz")
    bins, values = _centred_spectrum(series, expected * duration)
    in_median = np.abs(bins) <= _median_half_width(expected, tolerance, 1.0 / duration) * duration
    median = float(np.median(np.abs(values[in_median])))
    in_fit = np.abs(bins) <= half_width * duration + MARGIN
    positions, amplitudes = _fit_all_lines(bins[in_fit], values[in_fit], MIN_MEDIAN_RATIO * median)
    accepted = _are_lines(positions, amplitudes, MIN_MEDIAN_RATIO * median) & (
        np.abs(positions) <= half_width * duration
    )
    if not accepted.any():
        return None
    strongest = int(np.argmax(np.where(accepted, amplitudes, 0.0)))
    return _picked_line(expected + positions[strongest] / duration, amplitudes[strongest], median)


def pick_from(
    frequencies: np.ndarray, amplitudes: np.ndarray, expected: float, tolerance: float = 0.02
) -> PickedLine | None:
    """Find the strongest local maximum of a spectrum (n,) within a relative ``tolerance`` of ``expected`` (Hz).

    frequencies: (n,) in Hz, equally spaced. Returns None if no maximum reaches twice the local median. The default
    tolerance is for measured signals, in which slip shifts lines by up to 1.4 %.

    Frequency and amplitude are those of the vertex of a parabola through three amplitudes to the power 0.23, which
    for a pure tone under a Hann window is correct within 0.001 of a bin and 0.2 % (Werner and Germain, Sinusoidal
    parameter estimation using quadratic interpolation around power-scaled magnitude spectrum peaks, Appl. Sci. 6,
    2016, 306). The median is that of the spectrum around the expected frequency, within 10 %, five tolerances or
    20 bins, whichever is largest. Use ``pick_line`` if neighbours are closer than the resolution of a Hann window.
    """
    bin_width = float(frequencies[1] - frequencies[0])
    in_median = np.abs(frequencies - expected) <= _median_half_width(expected, tolerance, bin_width)
    median = float(np.median(amplitudes[in_median])) if in_median.any() else 0.0
    peaks = 1 + np.flatnonzero((amplitudes[1:-1] > amplitudes[:-2]) & (amplitudes[1:-1] >= amplitudes[2:]))
    interpolated = [_interpolate_peak(frequencies, amplitudes, peak) for peak in peaks[in_median[peaks]]]
    candidates = [
        (amplitude, frequency)
        for frequency, amplitude in interpolated
        if abs(frequency - expected) <= tolerance * expected and amplitude >= MIN_MEDIAN_RATIO * median
    ]
    if not candidates:
        return None
    amplitude, frequency = max(candidates)
    return _picked_line(frequency, amplitude, median)


def _median_half_width(expected: float, tolerance: float, bin_width: float) -> float:
    """Return the half width (Hz) of the band of the local median; bin_width: in Hz."""
    return max(0.1 * expected, 5.0 * tolerance * expected, 20.0 * bin_width)


def _picked_line(frequency: float, amplitude: float, median: float) -> PickedLine:
    return PickedLine(float(frequency), float(amplitude), float(amplitude / median) if median > 0.0 else inf)


def _interpolate_peak(frequencies: np.ndarray, amplitudes: np.ndarray, peak: int) -> tuple[float, float]:
    """Interpolate frequency (Hz) and amplitude of the local maximum at index ``peak`` by a parabola."""
    left, centre, right = amplitudes[peak - 1 : peak + 2] ** INTERPOLATION_POWER
    shift = 0.5 * (left - right) / (left - 2.0 * centre + right)
    frequency = frequencies[peak] + shift * (frequencies[1] - frequencies[0])
    return float(frequency), float((centre - 0.25 * (left - right) * shift) ** (1.0 / INTERPOLATION_POWER))


def _centred_spectrum(series: np.ndarray, expected: float) -> tuple[np.ndarray, np.ndarray]:
    """Compute the zero-padded complex spectrum of a series (n,) with a Hann window; return bins and values (m,).

    Bins are relative to ``expected`` (bins), and phases relative to the centre of the record, so that a line has a
    real shape.
    """
    n = len(series)
    padded_length = 2 ** int(np.ceil(np.log2(PADDING * n)))
    window = hann(n)
    values = np.fft.rfft((series - series.mean()) * window, padded_length) * (2.0 / window.sum())
    bins = np.arange(len(values)) * (n / padded_length)
    return bins - expected, values * np.exp(1j * pi * bins)


def _line_shape(distance: np.ndarray) -> np.ndarray:
    """Compute the spectrum of a Hann window at a distance d in bins from a line: sinc(d)/(1 - d^2), 1 at d = 0."""
    return np.sinc(distance) + 0.5 * (np.sinc(distance - 1.0) + np.sinc(distance + 1.0))


def _fit_all_lines(bins: np.ndarray, values: np.ndarray, floor: float) -> tuple[np.ndarray, np.ndarray]:
    """Fit lines to a section (n,) of a complex spectrum until its residual is below ``floor``.

    Returns positions (bins) and amplitudes (k,) in the order in which the lines were added. A line that converges
    within 1.5 bins of another is part of a broad line, so it is rejected, and its initial position is excluded.
    """
    positions, amplitudes, residual = np.zeros(0), np.zeros(0, dtype=complex), values
    is_candidate = np.ones(len(bins), dtype=bool)
    for _ in range(MAX_LINES):
        magnitudes = np.where(is_candidate, np.abs(residual), 0.0)
        peak = int(np.argmax(magnitudes))
        if magnitudes[peak] <= max(floor, MIN_RELATIVE_AMPLITUDE * np.abs(amplitudes).max(initial=0.0)):
            break
        refined = _refine(bins, values, np.append(positions, bins[peak]))
        if np.diff(np.sort(refined[0])).min(initial=MIN_SEPARATION) < MIN_SEPARATION:
            is_candidate[np.abs(bins - bins[peak]) < MIN_SEPARATION] = False
        else:
            positions, amplitudes, residual = refined
    return positions, np.abs(amplitudes)


def _refine(
    bins: np.ndarray, values: np.ndarray, positions: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Refine line positions (k,) in bins by the Gauss-Newton method.

    Returns positions (k,), complex amplitudes (k,) and the residual (n,).
    """
    for _ in range(MAX_ITERATIONS):
        shapes, amplitudes, residual = _fit_amplitudes(bins, values, positions)
        distance = bins[:, np.newaxis] - positions
        derivative = (_line_shape(distance - 1e-4) - _line_shape(distance + 1e-4)) / 2e-4
        jacobian = np.hstack([shapes, 1j * shapes, derivative * amplitudes])
        unknowns = np.linalg.lstsq(_stack_parts(jacobian), _stack_parts(residual), rcond=1e-10)[0]
        shifts = unknowns[2 * len(positions) :]
        positions = positions + np.clip(shifts, -MAX_SHIFT, MAX_SHIFT)
        if np.abs(shifts).max() < SHIFT_TOLERANCE:
            break
    _, amplitudes, residual = _fit_amplitudes(bins, values, positions)
    return positions, amplitudes, residual


def _fit_amplitudes(
    bins: np.ndarray, values: np.ndarray, positions: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fit the complex amplitudes of lines at positions (k,) in bins by least squares.

    Returns shapes (n, k), complex amplitudes (k,) and the residual (n,).
    """
    shapes = _line_shape(bins[:, np.newaxis] - positions)
    amplitudes = np.linalg.lstsq(shapes.astype(complex), values, rcond=1e-10)[0]
    return shapes, amplitudes, values - shapes @ amplitudes


def _stack_parts(values: np.ndarray) -> np.ndarray:
    """Stack real and imaginary parts, so that the unknowns of a complex least-squares problem are real."""
    return np.concatenate([values.real, values.imag])


def _are_lines(positions: np.ndarray, amplitudes: np.ndarray, floor: float) -> np.ndarray:
    """Check which lines (k,) reach ``floor`` and are neither part nor shoulder of a stronger one."""
    distances = np.abs(np.subtract.outer(positions, positions))
    stronger = amplitudes > amplitudes[:, np.newaxis]
    is_part = stronger & (distances < MIN_SEPARATION)
    is_shoulder = (distances < SHOULDER_DISTANCE) & (amplitudes * SHOULDER_RATIO > amplitudes[:, np.newaxis])
    is_over = amplitudes >= max(floor, MIN_RELATIVE_AMPLITUDE * amplitudes.max(initial=0.0))
    return is_over & ~np.any(is_part | is_shoulder, axis=1)
