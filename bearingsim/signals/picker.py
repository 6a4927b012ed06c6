"""Detection of the spectral line near an expected frequency, resolved from its neighbours."""

from math import inf, pi
from typing import NamedTuple

import numpy as np

from bearingsim.signals.spectra import hann

MIN_PROMINENCE = 2.0  # ratio to the local median; leakage and ripple can reach 1.5
MIN_HALF_WIDTH = 0.75  # bins, half width of the narrowest resolvable frequency window
PADDING = 4  # minimum number of samples of the spectrum per bin
MARGIN = 6.0  # bins beyond the frequency window in which lines are resolved together
MIN_SEPARATION = 1.5  # bins, minimum distance of two lines
SHOULDER = 3.0, 0.05  # bins, and share of a line: a weaker line within this distance is its shoulder
MIN_LINE = 1e-3  # relative to the strongest line nearby
MAX_LINES = 12  # lines resolved together
PARABOLA_POWER = 0.23  # power at which Hann's main lobe is closest to a parabola


class PickedLine(NamedTuple):
    """Detected line: frequency (Hz), amplitude in the series' unit, and its ratio to the local median
    (prominence).

    White noise alone reaches a prominence of 3 to 4 among a hundred bins.
    """

    frequency: float
    amplitude: float
    prominence: float


def pick_line(series: np.ndarray, fs: float, expected: float, tolerance: float = 0.005) -> PickedLine | None:
    """Find the strongest line of a series (n,) within a relative ``tolerance`` of ``expected`` (Hz); ``fs`` in Hz.

    Returns None if there is no line.

    A Hann window over the record length T resolves lines 2/T apart, and masks a weak line closer than 4/T to a
    strong one. Nearby lines are therefore resolved together: starting with the strongest, each is subtracted, and
    frequency, amplitude and phase of all are refined by least squares on the complex spectrum, until the residual
    is below twice the local median or 1e-3 of the strongest line (RELAX: Li and Stoica, Efficient mixed-spectrum
    estimation with applications to target feature extraction, IEEE Trans. Signal Process. 44, 1996). A line is
    accepted if there is no stronger one within 1.5/T and none 20 times as strong within 3/T, of which it would be
    a shoulder. The median is that of the spectrum around the expected frequency, within 10 %, five tolerances or
    20/T, whichever is largest.

    Raises ValueError if the half width expected * tolerance is under 0.75/T (at 159 Hz and 0.5 %: T under 0.94 s),
    so that lines inside and outside cannot be distinguished, or if the window reaches half the sample rate.
    Limits: amplitude and speed must be constant over the record. A speed variation of 0.03 % changes the amplitude
    of a ten times weaker neighbour by 8 %, one of 0.1 % by 30 %, and one of 0.2 % turns a shoulder into a false
    line (at 159 Hz, in 1 s).
    """
    duration, half_width = len(series) / fs, tolerance * expected
    if half_width * duration < MIN_HALF_WIDTH:
        raise ValueError(
            f"a record of {duration:.4g} s is too short to separate a line at {expected:g} Hz within "
            f"{100 * tolerance:g} % from its neighbours: use {MIN_HALF_WIDTH / half_width:.4g} s or more"
        )
    if expected + half_width + (MARGIN + 2.0) / duration > fs / 2.0:
        raise ValueError(f"{expected:g} Hz is too near half the sample rate, {fs / 2.0:g} Hz")
    bins, values = _centred_spectrum(series, expected * duration)
    in_median = np.abs(bins) <= _median_half_width(expected, tolerance, 1.0 / duration) * duration
    median = float(np.median(np.abs(values[in_median])))
    in_window = np.abs(bins) <= half_width * duration + MARGIN
    positions, amplitudes = _resolve(bins[in_window], values[in_window], MIN_PROMINENCE * median)
    accepted = _are_lines(positions, amplitudes, MIN_PROMINENCE * median) & (
        np.abs(positions) <= half_width * duration
    )
    if not accepted.any():
        return None
    best = int(np.argmax(np.where(accepted, amplitudes, 0.0)))
    return _picked_line(expected + positions[best] / duration, amplitudes[best], median)


def pick_from(
    frequencies: np.ndarray, amplitudes: np.ndarray, expected: float, tolerance: float = 0.02
) -> PickedLine | None:
    """Find the strongest local maximum of a spectrum (n,) within a relative ``tolerance`` of ``expected`` (Hz).

    Returns None if no maximum reaches twice the local median. For spectra of measured signals, in which slip
    shifts lines by up to 1.4 %; ``frequencies`` (Hz) equally spaced. Frequency and amplitude are those of a
    parabola through three amplitudes to the power 0.23: for a pure tone under a Hann window within 0.001 of a bin
    and 0.2 % (Werner and Germain, Sinusoidal parameter estimation using quadratic interpolation around
    power-scaled magnitude spectrum peaks, Appl. Sci. 6, 2016, 306). The median is that of the spectrum around the
    expected frequency, within 10 %, five tolerances or 20 bins. For neighbours closer than the resolution of a
    Hann window use ``pick_line``.
    """
    step = float(frequencies[1] - frequencies[0])
    in_median = np.abs(frequencies - expected) <= _median_half_width(expected, tolerance, step)
    median = float(np.median(amplitudes[in_median])) if in_median.any() else 0.0
    peaks = 1 + np.flatnonzero((amplitudes[1:-1] > amplitudes[:-2]) & (amplitudes[1:-1] >= amplitudes[2:]))
    candidates = [_interpolate_peak(frequencies, amplitudes, peak) for peak in peaks[in_median[peaks]]]
    candidate_lines = [
        (amplitude, frequency)
        for frequency, amplitude in candidates
        if abs(frequency - expected) <= tolerance * expected and amplitude >= MIN_PROMINENCE * median
    ]
    if not candidate_lines:
        return None
    amplitude, frequency = max(candidate_lines)
    return _picked_line(frequency, amplitude, median)


def _median_half_width(expected: float, tolerance: float, step: float) -> float:
    """Return the half width (Hz) of the band for a line's median, for bins ``step`` (Hz) wide."""
    return max(0.1 * expected, 5.0 * tolerance * expected, 20.0 * step)


def _picked_line(frequency: float, amplitude: float, median: float) -> PickedLine:
    return PickedLine(float(frequency), float(amplitude), float(amplitude / median) if median > 0.0 else inf)


def _interpolate_peak(frequencies: np.ndarray, amplitudes: np.ndarray, peak: int) -> tuple[float, float]:
    """Interpolate frequency and amplitude of a local maximum between samples."""
    left, middle, right = amplitudes[peak - 1 : peak + 2] ** PARABOLA_POWER
    shift = 0.5 * (left - right) / (left - 2.0 * middle + right)
    frequency = frequencies[peak] + shift * (frequencies[1] - frequencies[0])
    return float(frequency), float((middle - 0.25 * (left - right) * shift) ** (1.0 / PARABOLA_POWER))


def _centred_spectrum(series: np.ndarray, expected: float) -> tuple[np.ndarray, np.ndarray]:
    """Compute the complex spectrum (Hann, padded), with phases at the record's middle and bins relative to
    ``expected``."""
    n = len(series)
    padded = 2 ** int(np.ceil(np.log2(PADDING * n)))
    weight = hann(n)
    values = np.fft.rfft((series - series.mean()) * weight, padded) * (2.0 / weight.sum())
    bins = np.arange(len(values)) * (n / padded)
    return bins - expected, values * np.exp(1j * pi * bins)


def _line_shape(distance: np.ndarray) -> np.ndarray:
    """Compute the spectrum of Hann's window at a distance in bins, 1 at 0: sinc(d)/(1 - d^2)."""
    return np.sinc(distance) + 0.5 * (np.sinc(distance - 1.0) + np.sinc(distance + 1.0))


def _resolve(bins: np.ndarray, values: np.ndarray, floor: float) -> tuple[np.ndarray, np.ndarray]:
    """Resolve a piece of a spectrum into lines; return their positions (bins) and amplitudes, the strongest first.

    A guess that converges within 1.5 bins of another line is part of a broad line, so it is dropped and its
    position excluded.
    """
    positions, lines, residual = np.zeros(0), np.zeros(0, dtype=complex), values
    is_open = np.ones(len(bins))
    for _ in range(MAX_LINES):
        strongest = int(np.argmax(np.abs(residual) * is_open))
        if abs(residual[strongest]) * is_open[strongest] <= max(floor, MIN_LINE * np.abs(lines).max(initial=0.0)):
            break
        refined_lines = _refine(bins, values, np.append(positions, bins[strongest]))
        if np.diff(np.sort(refined_lines[0])).min(initial=MIN_SEPARATION) < MIN_SEPARATION:
            is_open[np.abs(bins - bins[strongest]) < MIN_SEPARATION] = 0.0
        else:
            positions, lines, residual = refined_lines
    return positions, np.abs(lines)


def _refine(
    bins: np.ndarray, values: np.ndarray, positions: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Refine line positions (k,) by Gauss-Newton; return them, complex amplitudes (k,) and the residual (n,)."""
    for _ in range(30):
        shape, lines, residual = _fit_lines(bins, values, positions)
        distance = bins[:, np.newaxis] - positions
        derivative = (_line_shape(distance - 1e-4) - _line_shape(distance + 1e-4)) / 2e-4
        columns = np.hstack([shape, 1j * shape, derivative * lines])
        shifts = np.linalg.lstsq(_stack_parts(columns), _stack_parts(residual), rcond=1e-10)[0][
            2 * len(positions) :
        ]
        positions = positions + np.clip(shifts, -0.25, 0.25)
        if np.abs(shifts).max() < 1e-8:
            break
    _, lines, residual = _fit_lines(bins, values, positions)
    return positions, lines, residual


def _fit_lines(
    bins: np.ndarray, values: np.ndarray, positions: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fit lines at positions; return shapes (n, k), amplitudes (k,) by least squares, and the residual (n,)."""
    shape = _line_shape(bins[:, np.newaxis] - positions)
    lines = np.linalg.lstsq(shape.astype(complex), values, rcond=1e-10)[0]
    return shape, lines, values - shape @ lines


def _stack_parts(values: np.ndarray) -> np.ndarray:
    """Stack real and imaginary parts, for complex least squares with real unknowns."""
    return np.concatenate([values.real, values.imag])


def _are_lines(positions: np.ndarray, amplitudes: np.ndarray, floor: float) -> np.ndarray:
    """Check which lines (k,) exceed ``floor`` and are not part or shoulder of a stronger one."""
    distances = np.abs(np.subtract.outer(positions, positions))
    stronger = amplitudes > amplitudes[:, np.newaxis]
    is_part = stronger & (distances < MIN_SEPARATION)
    is_shoulder = (distances < SHOULDER[0]) & (amplitudes * SHOULDER[1] > amplitudes[:, np.newaxis])
    is_strong = amplitudes >= max(floor, MIN_LINE * amplitudes.max(initial=0.0))
    return is_strong & ~np.any(is_part | is_shoulder, axis=1)
