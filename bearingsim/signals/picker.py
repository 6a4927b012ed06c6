"""Detection of the spectral line near an expected frequency, resolved from its neighbours."""

from math import inf, pi
from typing import NamedTuple

import numpy as np

from bearingsim.signals.spectra import hann

LEAST_PROMINENCE = 2.0  # ratio to the local median; leakage and ripple can reach 1.5
TOLD = 0.75  # bins, half width of the narrowest resolvable frequency window
PADDING = 4  # least samples of the spectrum per bin
REACH = 6.0  # bins beyond the frequency window in which lines are resolved together
ONE = 1.5  # bins, least distance of two lines
SHOULDER = 3.0, 0.05  # bins, and share of a line: a weaker line within this distance is its shoulder
MIN_LINE = 1e-3  # relative to the strongest line nearby
MAX_LINES = 12  # lines resolved together
BENT = 0.23  # power at which Hann's main lobe is closest to a parabola


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
    duration, half = len(series) / fs, tolerance * expected
    if half * duration < TOLD:
        raise ValueError(
            f"a record of {duration:.4g} s is too short to tell a line at {expected:g} Hz within "
            f"{100 * tolerance:g} % from its neighbours: it takes {TOLD / half:.4g} s"
        )
    if expected + half + (REACH + 2.0) / duration > fs / 2.0:
        raise ValueError(f"{expected:g} Hz is too near half the sample rate, {fs / 2.0:g} Hz")
    bins, values = _centred_spectrum(series, expected * duration)
    around = np.abs(bins) <= _surroundings(expected, tolerance, 1.0 / duration) * duration
    median = float(np.median(np.abs(values[around])))
    near = np.abs(bins) <= half * duration + REACH
    positions, amplitudes = _resolved(bins[near], values[near], LEAST_PROMINENCE * median)
    stands = _stand(positions, amplitudes, LEAST_PROMINENCE * median) & (np.abs(positions) <= half * duration)
    if not stands.any():
        return None
    best = int(np.argmax(np.where(stands, amplitudes, 0.0)))
    return _picked(expected + positions[best] / duration, amplitudes[best], median)


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
    close = np.abs(frequencies - expected) <= _surroundings(expected, tolerance, step)
    median = float(np.median(amplitudes[close])) if close.any() else 0.0
    tops = 1 + np.flatnonzero((amplitudes[1:-1] > amplitudes[:-2]) & (amplitudes[1:-1] >= amplitudes[2:]))
    candidates = [_top(frequencies, amplitudes, top) for top in tops[close[tops]]]
    inside = [
        (amplitude, frequency)
        for frequency, amplitude in candidates
        if abs(frequency - expected) <= tolerance * expected and amplitude >= LEAST_PROMINENCE * median
    ]
    if not inside:
        return None
    amplitude, frequency = max(inside)
    return _picked(frequency, amplitude, median)


def _surroundings(expected: float, tolerance: float, step: float) -> float:
    """Return the half width (Hz) of the band for a line's median, for bins ``step`` (Hz) wide."""
    return max(0.1 * expected, 5.0 * tolerance * expected, 20.0 * step)


def _picked(frequency: float, amplitude: float, median: float) -> PickedLine:
    return PickedLine(float(frequency), float(amplitude), float(amplitude / median) if median > 0.0 else inf)


def _top(frequencies: np.ndarray, amplitudes: np.ndarray, top: int) -> tuple[float, float]:
    """Interpolate frequency and amplitude of a local maximum between samples."""
    left, middle, right = amplitudes[top - 1 : top + 2] ** BENT
    shift = 0.5 * (left - right) / (left - 2.0 * middle + right)
    frequency = frequencies[top] + shift * (frequencies[1] - frequencies[0])
    return float(frequency), float((middle - 0.25 * (left - right) * shift) ** (1.0 / BENT))


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


def _resolved(bins: np.ndarray, values: np.ndarray, floor: float) -> tuple[np.ndarray, np.ndarray]:
    """Resolve a piece of a spectrum into lines; return their positions (bins) and amplitudes, the strongest first.

    A guess that converges within 1.5 bins of another line is part of a broad line, so it is dropped and its
    position excluded.
    """
    positions, lines, left = np.zeros(0), np.zeros(0, dtype=complex), values
    open_bins = np.ones(len(bins))
    for _ in range(MAX_LINES):
        strongest = int(np.argmax(np.abs(left) * open_bins))
        if abs(left[strongest]) * open_bins[strongest] <= max(floor, MIN_LINE * np.abs(lines).max(initial=0.0)):
            break
        refined = _refined(bins, values, np.append(positions, bins[strongest]))
        if np.diff(np.sort(refined[0])).min(initial=ONE) < ONE:
            open_bins[np.abs(bins - bins[strongest]) < ONE] = 0.0
        else:
            positions, lines, left = refined
    return positions, np.abs(lines)


def _refined(
    bins: np.ndarray, values: np.ndarray, positions: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Refine line positions (k,) by Gauss-Newton; return them, complex amplitudes (k,) and the residual (n,)."""
    for _ in range(30):
        shape, lines, left = _remove_peaks(bins, values, positions)
        distance = bins[:, np.newaxis] - positions
        derivative = (_line_shape(distance - 1e-4) - _line_shape(distance + 1e-4)) / 2e-4
        columns = np.hstack([shape, 1j * shape, derivative * lines])
        moves = np.linalg.lstsq(_parts(columns), _parts(left), rcond=1e-10)[0][2 * len(positions) :]
        positions = positions + np.clip(moves, -0.25, 0.25)
        if np.abs(moves).max() < 1e-8:
            break
    _, lines, left = _remove_peaks(bins, values, positions)
    return positions, lines, left


def _remove_peaks(
    bins: np.ndarray, values: np.ndarray, positions: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fit lines at positions; return shapes (n, k), amplitudes (k,) by least squares, and the residual (n,)."""
    shape = _line_shape(bins[:, np.newaxis] - positions)
    lines = np.linalg.lstsq(shape.astype(complex), values, rcond=1e-10)[0]
    return shape, lines, values - shape @ lines


def _parts(values: np.ndarray) -> np.ndarray:
    """Stack real and imaginary parts, for complex least squares with real unknowns."""
    return np.concatenate([values.real, values.imag])


def _stand(positions: np.ndarray, amplitudes: np.ndarray, floor: float) -> np.ndarray:
    """Check which lines (k,) exceed ``floor`` and are not part or shoulder of a stronger one."""
    apart = np.abs(np.subtract.outer(positions, positions))
    stronger = amplitudes > amplitudes[:, np.newaxis]
    part = stronger & (apart < ONE)
    shoulder = (apart < SHOULDER[0]) & (amplitudes * SHOULDER[1] > amplitudes[:, np.newaxis])
    enough = amplitudes >= max(floor, MIN_LINE * amplitudes.max(initial=0.0))
    return enough & ~np.any(part | shoulder, axis=1)
