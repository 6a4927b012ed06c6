"""Entry of a roller into a defect and its exit, within a pass."""

from math import nan
from typing import NamedTuple

import numpy as np

from bearingsim.signals.spectra import analytic

SMOOTHING = 40  # period over the smallest distance between two events
WHITENING_HARMONICS = 20  # half width of the average for whitening, in harmonics of the pass frequency
POWER_FLOOR = 1e-3  # relative to the mean power: weaker lines are not whitened
MIN_ENTRY_HEIGHT = 0.2  # smallest prominence of an entry, relative to the exit: events of other rollers have less
MAX_BEFORE = 1 / 3  # largest prominence of a third event before the exit, relative to the entry
MAX_AFTER = 1 / 2  # the same after the exit: in a measured signal ringing reaches 0.45
MIN_THIRD = 1 / 5  # prominence, relative to the entry, from which an event higher than the entry is a third one
FAR = 0.3  # of the period before the exit, about where rollers enter the load zone across the load
MAX_RISE = 0.03  # of the period, of an entry before that: over a rim 0.02, into the load zone 0.03 to 0.06
MIN_VARIATION = 1e-6  # relative to the mean envelope: smaller variations are rounding errors
MIN_SPACING = 0.05  # of the period: twice the width of the smoothing
MAX_SPACING = 0.4  # of the period: in a smooth oscillation the other half wave is half a period before the highest
MIN_SIGNIFICANCE = 7.0  # smallest prominence of an event, in standard errors of the mean over passes


ONE_EVENT = "there is no second event per pass of at least a fifth of the strongest"
THIRD_EVENT = "a third event per pass is about as strong as the entry, as in acceleration across the load"
SLOW_ENTRY = (
    f"the event over {FAR:g} of a pass before the strongest rises slowly, as of rollers that enter the load zone"
)
TOO_CLOSE = f"the two events are less than {MIN_SPACING:g} of a pass apart"
TOO_FAR = f"the two events are over {MAX_SPACING:g} of a pass apart, as in the motion of a healthy bearing"


class Spacing(NamedTuple):
    """Time (s) from entry to exit of a defect; nan, and the reason, if the events are not those two."""

    time: float
    reason: str = ""


def spacing(series: np.ndarray, fs: float, period: float) -> float:
    """Measure the time (s) from entry to exit of a defect, as ``entry_to_exit``; nan if there is none."""
    return entry_to_exit(series, fs, period).time


def entry_to_exit(series: np.ndarray, fs: float, period: float) -> Spacing:
    """Measure the time (s) from entry to exit of a defect from all passes of a series (n,) sampled at ``fs`` (Hz).

    period: of the passes (s). The spectrum is whitened, so that the entry (weak, low frequency) and the exit
    (ringing) have similar weight (Sawalhi and Randall, Vibration response of spalled rolling element bearings,
    Mech. Syst. Signal Process. 25, 2011, 846-870). The squared envelope is smoothed over period/40, and its square
    root averaged over all passes, aligned at their highest value, the exit, so that variations of the period have
    no effect. The spacing is measured to the most prominent maximum in the half pass before the exit.

    There is none if its prominence is less than 0.2 of the exit or less than seven standard errors of the mean
    there, which means at most one event per pass; if the spacing is not within 0.05 to 0.4 of the period; or if a
    third event is about as strong: before the exit a landing on the floor, or in acceleration across the load
    rollers that enter the load zone and beats of the ringing. An entry over 0.3 of the period before the exit must
    rise from half its height within 0.03 of the period: rollers that enter the load zone take longer. The exit
    must be the strongest event. The position of an event is that of its energy: an entry that rises over 0.3 ms
    before a sudden exit is measured 0.2 ms late.
    Raises ValueError if the record has fewer than two passes, or a pass fewer than 40 samples.
    """
    if len(series) < 2.0 * period * fs or period * fs < SMOOTHING:
        raise ValueError(
            f"{len(series)} samples at {fs:g} Hz: expected at least two passes of {period:g} s"
            f" and {SMOOTHING} samples per pass"
        )
    envelope = smooth(whitened_envelope(series, fs, WHITENING_HARMONICS / period), period * fs / SMOOTHING)
    passes = passes_around_exits(np.sqrt(np.maximum(envelope, 0.0)), int(period * fs / 2.0))
    if len(passes) < 2:
        return Spacing(nan, ONE_EVENT)
    mean, error = passes.mean(axis=0), passes.std(axis=0) / np.sqrt(len(passes) - 1)
    if np.ptp(mean) <= MIN_VARIATION * mean.mean():
        return Spacing(nan, ONE_EVENT)
    centre = len(mean) // 2
    entry = most_prominent(
        mean[: centre + 1], np.maximum(MIN_ENTRY_HEIGHT * np.ptp(mean), MIN_SIGNIFICANCE * error)
    )
    if not entry:
        return Spacing(nan, ONE_EVENT)
    if has_third_event(mean, entry):
        return Spacing(nan, THIRD_EVENT)
    time = (interpolate_peak(mean, centre) - interpolate_peak(mean, entry)) / fs
    if not MIN_SPACING * period <= time <= MAX_SPACING * period:
        return Spacing(nan, TOO_CLOSE if time < MIN_SPACING * period else TOO_FAR)
    if time > FAR * period and rise_of(mean, entry) > MAX_RISE * period * fs:
        return Spacing(nan, SLOW_ENTRY)
    return Spacing(time)


def rise_of(values: np.ndarray, peak: int) -> float:
    """Return the samples in which values (n,) rise from half the prominence of a maximum to it."""
    level = values[peak] - 0.5 * prominence(values, peak)
    below = int(np.flatnonzero(values[:peak] <= level).max(initial=0))
    return float(peak - below - np.interp(level, values[below : below + 2], (0.0, 1.0)))


def has_third_event(mean: np.ndarray, entry: int) -> bool:
    """Check whether a mean pass (n,), with the exit in its middle, has an event as strong as that at ``entry``."""
    exit_, reference = len(mean) // 2, prominence(mean, entry)
    for peak in map(int, maxima(mean)):
        share = prominence(mean, peak) / reference
        is_third = share > (MAX_BEFORE if peak < exit_ else MAX_AFTER)
        is_third |= share > MIN_THIRD and mean[peak] > mean[entry]
        if peak not in (entry, exit_) and is_third:
            return True
    return False


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
