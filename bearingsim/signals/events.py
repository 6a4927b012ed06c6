"""Entry of a roller into a defect and its exit, within a pass."""

import numpy as np

from bearingsim.signals.spectra import analytic

SMOOTHING = 40  # period over the smallest distance between two events
WHITENING_HARMONICS = 20  # half width of the average for whitening, in harmonics of the pass frequency
POWER_FLOOR = 1e-3  # relative to the mean power: weaker lines are not whitened
MIN_ENTRY_HEIGHT = 0.08  # smallest prominence of an entry, relative to the exit
MIN_VARIATION = 1e-6  # relative to the mean envelope: smaller variations are rounding errors
MAX_SPACING = 0.4  # of the period: in a smooth oscillation the other half wave is half a period before the highest
MIN_SIGNIFICANCE = 7.0  # smallest prominence of an event, in standard errors of the mean over passes


def spacing(series: np.ndarray, fs: float, period: float) -> float:
    """Measure the time (s) from entry to exit of a defect from all passes of a series (n,) sampled at ``fs`` (Hz).

    period: of the passes (s). The spectrum is whitened, so that the entry (weak, low frequency) and the exit
    (ringing) have similar weight (Sawalhi and Randall, Vibration response of spalled rolling element bearings,
    Mech. Syst. Signal Process. 25, 2011, 846-870). The squared envelope is smoothed over period/40, and its square
    root averaged over all passes, aligned at their highest value, the exit, so that variations of the period have
    no effect. The spacing is measured to the most prominent maximum in the half pass before the exit.

    Returns nan if its prominence is less than 0.08 of the exit or less than seven standard errors of the mean
    there, which means at most one event per pass, or if the spacing exceeds 0.4 of the period, as in the periodic
    motion of a healthy bearing. Limits: spacings from 0.1 to 0.4 of the period, and the exit
    must be the stronger event. The position of an event is that of its energy: an entry that rises over 0.3 ms
    before a sudden exit is measured 0.2 ms late. Raises ValueError if the record has fewer than two passes, or a
    pass fewer than 40 samples.
    """
    if len(series) < 2.0 * period * fs or period * fs < SMOOTHING:
        raise ValueError(
            f"{len(series)} samples at {fs:g} Hz: expected at least two passes of {period:g} s"
            f" and {SMOOTHING} samples per pass"
        )
    envelope = smooth(whitened_envelope(series, fs, WHITENING_HARMONICS / period), period * fs / SMOOTHING)
    passes = passes_around_exits(np.sqrt(np.maximum(envelope, 0.0)), int(period * fs / 2.0))
    if len(passes) < 2:
        return float("nan")
    mean, error = passes.mean(axis=0), passes.std(axis=0) / np.sqrt(len(passes) - 1)
    if np.ptp(mean) <= MIN_VARIATION * mean.mean():
        return float("nan")
    centre = len(mean) // 2
    entry = most_prominent(
        mean[: centre + 1], np.maximum(MIN_ENTRY_HEIGHT * np.ptp(mean), MIN_SIGNIFICANCE * error)
    )
    if not entry:
        return float("nan")
    time = (interpolate_peak(mean, centre) - interpolate_peak(mean, entry)) / fs
    return time if time <= MAX_SPACING * period else float("nan")


def passes_around_exits(envelope: np.ndarray, half: int) -> np.ndarray:
    """Return passes (p, 2 half + 1) centred on the values of an envelope (n,) that are highest within half a
    pass."""
    peaks = maxima(envelope)
    peaks = peaks[(peaks >= half) & (peaks < len(envelope) - half)]
    windows = np.lib.stride_tricks.sliding_window_view(envelope, 2 * half + 1)[peaks - half]
    return windows[envelope[peaks] >= windows.max(axis=1)]


def whitened_envelope(series: np.ndarray, fs: float, half_band: float) -> np.ndarray:
    """Compute the squared envelope (n,) of a series whitened over +-``half_band`` (Hz)."""
    transform = np.fft.rfft(series - series.mean())
    power = np.abs(transform) ** 2
    half_width = min(max(1, round(half_band * len(series) / fs)), len(power) - 1)
    cumulative = np.cumsum(np.concatenate([[0.0], np.pad(power, half_width, mode="reflect")]))
    local_mean = (cumulative[2 * half_width + 1 :] - cumulative[: -2 * half_width - 1]) / (2 * half_width + 1)
    level = np.sqrt(local_mean + POWER_FLOOR * power.mean())
    return np.abs(analytic(transform / np.where(level > 0.0, level, 1.0), len(series))) ** 2


def smooth(series: np.ndarray, width: float) -> np.ndarray:
    """Smooth a series (n,) with a Gaussian of ``width`` samples (full width at half maximum)."""
    frequencies = np.fft.rfftfreq(len(series))
    response = np.exp(-((np.pi * width * frequencies) ** 2) / (4.0 * np.log(2.0)))
    return np.fft.irfft(np.fft.rfft(series) * response, len(series))


def maxima(values: np.ndarray) -> np.ndarray:
    """Return the indices of the local maxima of values (n,), except at the ends."""
    return 1 + np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:]))


def most_prominent(values: np.ndarray, min_prominence: np.ndarray) -> int:
    """Return the index of the most prominent local maximum; 0 if there is none.

    values: (n,); min_prominence: (n,) or more. The prominence is the height above the higher of the two
    minima between the maximum and a higher value on either side.
    """
    peaks = maxima(values)
    prominences = np.array([prominence(values, int(peak)) for peak in peaks])
    prominences[prominences < min_prominence[peaks]] = 0.0
    return int(peaks[np.argmax(prominences)]) if np.any(prominences) else 0


def interpolate_peak(values: np.ndarray, peak: int) -> float:
    """Interpolate the position of the local maximum at index ``peak`` by a parabola through three values."""
    left, middle, right = values[peak - 1 : peak + 2]
    return float(peak + 0.5 * (left - right) / (left - 2.0 * middle + right))


def prominence(values: np.ndarray, peak: int) -> float:
    """Compute the prominence of a maximum; the ends of the series are treated as higher."""
    higher = np.flatnonzero(values > values[peak])
    left = higher[higher < peak].max(initial=0)
    right = higher[higher > peak].min(initial=len(values))
    return float(values[peak] - max(values[left : peak + 1].min(), values[peak:right].min()))
