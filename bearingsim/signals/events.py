"""Entry of a roller into a defect and its exit, within a pass."""

import numpy as np

from bearingsim.signals.spectra import analytic

SMOOTHED = 40  # events closer than a pass over this count as one
WHITENED = 20  # lines to either side over which the spectrum is levelled
FLOOR = 1e-3  # of the mean power: weaker lines are not levelled
LEAST = 0.08  # of the exit, least height of an entry
STILL = 1e-6  # of the envelope: smaller changes are rounding
NOISE = 7.0  # standard errors of the mean over passes, least height of an event


def spacing(series: np.ndarray, fs: float, period: float) -> float:
    """Measure the time (s) from entry to exit of a defect, over all passes of a series (n,) at ``fs`` (Hz).

    period: of the passes (s). The spectrum is levelled, so that the entry, which is weak and low, and the exit,
    which rings, count alike (pre-whitening: Sawalhi and Randall, Vibration response of spalled rolling element
    bearings, Mech. Syst. Signal Process. 25, 2011, 846-870). The squared envelope is smoothed over period/40, its
    root taken, and all passes averaged about their highest value, the exit; so scatter of the passes does no harm.
    The spacing is that of the most prominent maximum in the half pass before it.

    nan if that stands less than 0.08 of the exit over its surroundings, or less than seven times the mean's own
    error there: one event to a pass, or none. Limits: spacings from 0.1 to 0.4 of the period, and the exit must be
    the stronger. An event counts where its energy is: an entry that rises in 0.3 ms before an exit that rises at
    once reads 0.2 ms late. ValueError if the record holds under two passes, or a pass under 40 samples.
    """
    if len(series) < 2.0 * period * fs or period * fs < SMOOTHED:
        raise ValueError(
            f"{len(series)} samples at {fs:g} Hz are not two passes of {period:g} s, {SMOOTHED} samples in each"
        )
    envelope = smoothed(levelled_envelope(series, fs, WHITENED / period), period * fs / SMOOTHED)
    passes = about_exits(np.sqrt(np.maximum(envelope, 0.0)), int(period * fs / 2.0))
    if len(passes) < 2:
        return float("nan")
    mean, error = passes.mean(axis=0), passes.std(axis=0) / np.sqrt(len(passes) - 1)
    if np.ptp(mean) <= STILL * mean.mean():
        return float("nan")
    half = len(mean) // 2
    entry = most_prominent(mean[: half + 1], np.maximum(LEAST * np.ptp(mean), NOISE * error))
    return (summit(mean, half) - summit(mean, entry)) / fs if entry else float("nan")


def about_exits(envelope: np.ndarray, half: int) -> np.ndarray:
    """Return passes (p, 2 half + 1) around the values of an envelope (n,) that are highest within half a pass."""
    tops = maxima(envelope)
    tops = tops[(tops >= half) & (tops < len(envelope) - half)]
    around = np.lib.stride_tricks.sliding_window_view(envelope, 2 * half + 1)[tops - half]
    return around[envelope[tops] >= around.max(axis=1)]


def levelled_envelope(series: np.ndarray, fs: float, reach: float) -> np.ndarray:
    """Compute the squared envelope (n,) of a series with its power levelled over +-``reach`` (Hz)."""
    transform = np.fft.rfft(series - series.mean())
    power = np.abs(transform) ** 2
    wide = min(max(1, round(reach * len(series) / fs)), len(power) - 1)
    total = np.cumsum(np.concatenate([[0.0], np.pad(power, wide, mode="reflect")]))
    local = (total[2 * wide + 1 :] - total[: -2 * wide - 1]) / (2 * wide + 1)
    level = np.sqrt(local + FLOOR * power.mean())
    return np.abs(analytic(transform / np.where(level > 0.0, level, 1.0), len(series))) ** 2


def smoothed(series: np.ndarray, width: float) -> np.ndarray:
    """Smooth a series (n,) with a bell of ``width`` samples at half height."""
    frequencies = np.fft.rfftfreq(len(series))
    bell = np.exp(-((np.pi * width * frequencies) ** 2) / (4.0 * np.log(2.0)))
    return np.fft.irfft(np.fft.rfft(series) * bell, len(series))


def maxima(values: np.ndarray) -> np.ndarray:
    """Return the indices of the local maxima of values (n,), without the ends."""
    return 1 + np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:]))


def most_prominent(values: np.ndarray, least: np.ndarray) -> int:
    """Return the index of the most prominent inner maximum; 0 if there is none.

    values: (n,); least: (n,) or more, what a maximum must stand to count. It stands over the higher of the two
    lowest values between it and what is higher on either side.
    """
    tops = maxima(values)
    heights = np.array([height(values, int(top)) for top in tops])
    heights[heights < least[tops]] = 0.0
    return int(tops[np.argmax(heights)]) if np.any(heights) else 0


def summit(values: np.ndarray, top: int) -> float:
    """Interpolate the position of the local maximum at index ``top`` by a parabola through three values."""
    left, middle, right = values[top - 1 : top + 2]
    return float(top + 0.5 * (left - right) / (left - 2.0 * middle + right))


def height(values: np.ndarray, top: int) -> float:
    """Compute the prominence of a maximum; the ends of the series count as higher."""
    higher = np.flatnonzero(values > values[top])
    left = higher[higher < top].max(initial=0)
    right = higher[higher > top].min(initial=len(values))
    return float(values[top] - max(values[left : top + 1].min(), values[top:right].min()))
