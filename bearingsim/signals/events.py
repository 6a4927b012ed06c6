"""Time between a roller's entry into a defect and its exit, from a vibration signal."""

from math import nan
from typing import NamedTuple

import numpy as np

from bearingsim.signals.spectra import analytic

# The period is that of the ball passes. Prominence is as in ``scipy.signal.peak_prominences``.
SMOOTHING_RATIO = 40  # period over the width of the Gaussian smoothing (full width at half maximum)
WHITENING_HARMONICS = 20  # half width of the moving average for whitening, in harmonics of the pass frequency
POWER_FLOOR = 1e-3  # relative to the mean power: keeps whitening from amplifying weaker content
MIN_ENTRY_PROMINENCE = 0.2  # of an entry, relative to the range of the mean pass: other rollers cause less
MAX_PROMINENCE_BEFORE = 1 / 3  # of an event before the exit, relative to the entry; more is a third event
MAX_PROMINENCE_AFTER = 1 / 2  # of an event after the exit: ringing in a measured signal reaches 0.45
MAX_PROMINENCE_ABOVE = 1 / 5  # of an event that is higher than the entry, relative to the entry
EARLY_ENTRY = 0.3  # of the period before the exit: in signals across the load, rollers enter the load zone there
MAX_RISE = 0.03  # of the period, of an early entry: 0.02 over a rim, 0.03 to 0.06 into the load zone
MIN_VARIATION = 1e-6  # relative to the mean envelope: smaller variations are rounding errors
MIN_SPACING = 0.05  # of the period: twice the width of the smoothing
MAX_SPACING = 0.4  # of the period: the envelope of a smooth oscillation has maxima half a period apart
MIN_SIGNIFICANCE = 7.0  # smallest prominence of an event, in standard errors of the mean over passes

# Reasons why the events are not an entry and an exit
ONE_EVENT = "there is no second event per pass of at least a fifth of the strongest"
THIRD_EVENT = "a third event per pass is about as strong as the entry, as in acceleration across the load"
SLOW_ENTRY = (
    f"the event over {EARLY_ENTRY:g} of a pass before the strongest rises slowly,"
    " as when rollers enter the load zone"
)
TOO_CLOSE = f"the two events are less than {MIN_SPACING:g} of a pass apart"
TOO_FAR = f"the two events are over {MAX_SPACING:g} of a pass apart, as in the motion of a healthy bearing"


class Spacing(NamedTuple):
    """Time (s) from entry to exit of a defect; NaN with the reason if the events are not an entry and an exit."""

    time: float
    reason: str = ""


def entry_to_exit_time(series: np.ndarray, fs: float, period: float) -> float:
    """Measure the time (s) from entry to exit of a defect, as ``measure_spacing``; NaN if there is none."""
    return measure_spacing(series, fs, period).time


def measure_spacing(series: np.ndarray, fs: float, period: float) -> Spacing:
    """Measure the time from entry to exit of a defect from all ball passes of a series (n,) at ``fs`` (Hz).

    period: of the ball passes (s). The spectrum is whitened, so that the entry (weak, low frequency) and the exit
    (ringing) have similar weight (Sawalhi and Randall, Vibration response of spalled rolling element bearings,
    Mech. Syst. Signal Process. 25, 2011, 846-870). The squared envelope is smoothed over period/40, and its square
    root averaged over all passes, aligned at their highest value, the exit, so that variations of the period have
    no effect. The entry is the most prominent maximum in the half pass before the exit.

    The time is NaN if the prominence of the entry is less than 0.2 of the range of the mean pass or less than
    seven standard errors of the mean there, that is if a pass has one event; if the time is not within 0.05 to 0.4
    of the period; or if a third event is about as strong: before the exit a landing on the floor, or in
    acceleration across the load rollers that enter the load zone and beats of the ringing. An entry over 0.3 of
    the period before the exit must rise from half its prominence within 0.03 of the period, because rollers that
    enter the load zone take longer. Limits: the exit must be the strongest event. The position of an event is that
    of its energy: an entry that rises over 0.3 ms before a sudden exit is measured 0.2 ms late.

    Raises ValueError if the record has fewer than two passes, or a pass fewer than 40 samples.
    """
    if len(series) < 2.0 * period * fs or period * fs < SMOOTHING_RATIO:
        raise ValueError(
            f"{len(series)} samples at {fs:g} Hz: expected at least two passes of {period:g} s"
            f" and {SMOOTHING_RATIO} samples per pass"
        )
    envelope = smooth(whitened_envelope(series, fs, WHITENING_HARMONICS / period), period * fs / SMOOTHING_RATIO)
    passes = cut_passes(np.sqrt(np.maximum(envelope, 0.0)), int(period * fs / 2.0))
    if len(passes) < 2:
        return Spacing(nan, ONE_EVENT)
    mean, error = passes.mean(axis=0), passes.std(axis=0) / np.sqrt(len(passes) - 1)
    if np.ptp(mean) <= MIN_VARIATION * mean.mean():
        return Spacing(nan, ONE_EVENT)
    centre = len(mean) // 2
    entry = most_prominent(
        mean[: centre + 1], np.maximum(MIN_ENTRY_PROMINENCE * np.ptp(mean), MIN_SIGNIFICANCE * error)
    )
    if not entry:
        return Spacing(nan, ONE_EVENT)
    if has_third_event(mean, entry):
        return Spacing(nan, THIRD_EVENT)
    time = (interpolate_peak(mean, centre) - interpolate_peak(mean, entry)) / fs
    if not MIN_SPACING * period <= time <= MAX_SPACING * period:
        return Spacing(nan, TOO_CLOSE if time < MIN_SPACING * period else TOO_FAR)
    if time > EARLY_ENTRY * period and rise_length(mean, entry) > MAX_RISE * period * fs:
        return Spacing(nan, SLOW_ENTRY)
    return Spacing(time)


def rise_length(values: np.ndarray, peak: int) -> float:
    """Compute the distance in samples from the rise through half the prominence of a maximum to the maximum.

    values: (n,); peak: index of the maximum.
    """
    level = values[peak] - 0.5 * prominence(values, peak)
    below = int(np.flatnonzero(values[:peak] <= level).max(initial=0))
    return float(peak - below - np.interp(level, values[below : below + 2], (0.0, 1.0)))


def has_third_event(mean: np.ndarray, entry: int) -> bool:
    """Check if a mean pass (n,), with the exit at its centre, has a third event about as strong as the entry.

    entry: index of the entry.
    """
    exit_, reference = len(mean) // 2, prominence(mean, entry)
    for peak in map(int, find_maxima(mean)):
        ratio = prominence(mean, peak) / reference
        is_third = ratio > (MAX_PROMINENCE_BEFORE if peak < exit_ else MAX_PROMINENCE_AFTER)
        is_third |= ratio > MAX_PROMINENCE_ABOVE and mean[peak] > mean[entry]
        if peak not in (entry, exit_) and is_third:
            return True
    return False


def cut_passes(envelope: np.ndarray, half: int) -> np.ndarray:
    """Cut an envelope (n,) into passes (p, 2 half + 1) centred on the exits.

    half: half a pass in samples. An exit is a maximum that no value within half a pass exceeds.
    """
    peaks = find_maxima(envelope)
    peaks = peaks[(peaks >= half) & (peaks < len(envelope) - half)]
    windows = np.lib.stride_tricks.sliding_window_view(envelope, 2 * half + 1)[peaks - half]
    return windows[envelope[peaks] >= windows.max(axis=1)]


def whitened_envelope(series: np.ndarray, fs: float, half_band: float) -> np.ndarray:
    """Compute the squared envelope (n,) of a series (n,) at ``fs`` (Hz) after whitening.

    half_band: half width (Hz) of the moving average of the power by which the spectrum is divided.
    """
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


def find_maxima(values: np.ndarray) -> np.ndarray:
    """Return the indices of the local maxima of values (n,), except at the ends."""
    return 1 + np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:]))


def most_prominent(values: np.ndarray, min_prominence: np.ndarray) -> int:
    """Return the index of the most prominent local maximum; 0 if there is none.

    values: (n,); min_prominence: smallest prominence by index, (n,) or longer.
    """
    peaks = find_maxima(values)
    prominences = np.array([prominence(values, int(peak)) for peak in peaks])
    prominences[prominences < min_prominence[peaks]] = 0.0
    return int(peaks[np.argmax(prominences)]) if np.any(prominences) else 0


def interpolate_peak(values: np.ndarray, peak: int) -> float:
    """Interpolate the position of the local maximum at index ``peak`` by a parabola through three values."""
    left, centre, right = values[peak - 1 : peak + 2]
    return float(peak + 0.5 * (left - right) / (left - 2.0 * centre + right))


def prominence(values: np.ndarray, peak: int) -> float:
    """Compute the prominence of the maximum of values (n,) at index ``peak``.

    It is the height above the higher of two minima, each between the maximum and the nearest higher value on one
    side, or the end of the series if no value there is higher.
    """
    higher = np.flatnonzero(values > values[peak])
    left = higher[higher < peak].max(initial=0)
    right = higher[higher > peak].min(initial=len(values))
    return float(values[peak] - max(values[left : peak + 1].min(), values[peak:right].min()))
