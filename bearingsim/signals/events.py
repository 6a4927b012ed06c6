"""Where in a pass things happen: a roller that enters a pit and leaves it."""

import numpy as np

from bearingsim.signals.spectra import analytic

SMOOTHED = 40  # events closer than a pass over this are one
WHITENED = 20  # lines to either side over which the spectrum is levelled
FLOOR = 1e-3  # of the mean power: what is weaker is not raised to the rest
LEAST = 0.05  # of the envelope's variance: a bump of the autocovariance that stands less is ripple
NOISE = 6.0  # standard deviations of the ripple that noise makes
STILL = 1e-10  # of the mean envelope squared: less variance is rounding


def spacing(series: np.ndarray, fs: float, period: float) -> float:
    """Time (s) between the entry and the exit event of a defect, over all passes of a series (n,) at ``fs`` (Hz).

    period: of the passes (s). The spectrum is levelled, so that the entry, which is weak and low, and the exit,
    which rings, count alike (pre-whitening: Sawalhi and Randall, Vibration response of spalled rolling element
    bearings, Mech. Syst. Signal Process. 25, 2011). Of the squared envelope, smoothed over period/40, the root is
    taken; the spacing is the lag below period/2 where the autocovariance of that has its most prominent maximum.
    Scatter of the passes does no harm, as each pair keeps its distance.

    nan if no maximum stands 0.05 of the variance over its surroundings, and six times the deviation that noise
    makes in so many passes: one event to a pass, or none. Limits: spacings from about 0.1 to 0.4 of the period
    (beyond half, the period less itself is read); 50 passes or more; ringing over by the next event. An event
    counts where its energy is: an entry that rises in 0.3 ms before an exit that rises at once reads 0.2 ms late.
    ValueError if the record holds under two passes, or a pass under 40 samples.
    """
    if len(series) < 2.0 * period * fs or period * fs < SMOOTHED:
        raise ValueError(
            f"{len(series)} samples at {fs:g} Hz are not two passes of {period:g} s, {SMOOTHED} samples in each"
        )
    envelope = smoothed(levelled_envelope(series, fs, WHITENED / period), period * fs / SMOOTHED)
    magnitude = np.sqrt(np.maximum(envelope, 0.0))
    covariance = autocovariance(magnitude)[: int(period * fs / 2.0) + 2]
    if not covariance[0] > STILL * magnitude.mean() ** 2:
        return float("nan")
    ripple = NOISE / np.sqrt(SMOOTHED * len(series) / (fs * period))
    return most_prominent(covariance / covariance[0], max(LEAST, ripple)) / fs


def levelled_envelope(series: np.ndarray, fs: float, reach: float) -> np.ndarray:
    """Squared envelope (n,) of a series whose power is levelled over +-``reach`` (Hz)."""
    transform = np.fft.rfft(series - series.mean())
    power = np.abs(transform) ** 2
    wide = min(max(1, round(reach * len(series) / fs)), len(power) - 1)
    total = np.cumsum(np.concatenate([[0.0], np.pad(power, wide, mode="reflect")]))
    local = (total[2 * wide + 1 :] - total[: -2 * wide - 1]) / (2 * wide + 1)
    level = np.sqrt(local + FLOOR * power.mean())
    return np.abs(analytic(transform / np.where(level > 0.0, level, 1.0), len(series))) ** 2


def smoothed(series: np.ndarray, width: float) -> np.ndarray:
    """Series (n,) averaged under a bell whose width at half height is ``width`` samples."""
    frequencies = np.fft.rfftfreq(len(series))
    bell = np.exp(-((np.pi * width * frequencies) ** 2) / (4.0 * np.log(2.0)))
    return np.fft.irfft(np.fft.rfft(series) * bell, len(series))


def autocovariance(series: np.ndarray) -> np.ndarray:
    """Autocovariance (n,) of a series (n,) at lags 0 to n - 1, each over the pairs that the record holds."""
    power = np.abs(np.fft.rfft(series - series.mean(), 2 * len(series))) ** 2
    return np.fft.irfft(power)[: len(series)] / np.arange(len(series), 0, -1)


def most_prominent(values: np.ndarray, least: float) -> float:
    """Place, between samples, of the inner maximum that stands most over its surroundings, nan if under ``least``.

    A maximum stands over the higher of the two lowest values between it and what is higher on either side.
    """
    tops = 1 + np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:]))
    heights = np.array([height(values, int(top)) for top in tops])
    if not np.any(heights >= least):
        return float("nan")
    top = tops[np.argmax(heights)]
    left, middle, right = values[top - 1 : top + 2]
    return float(top + 0.5 * (left - right) / (left - 2.0 * middle + right))


def height(values: np.ndarray, top: int) -> float:
    """How far a maximum stands over its surroundings; the end of the series counts as what is higher."""
    higher = np.flatnonzero(values > values[top])
    left = higher[higher < top].max(initial=0)
    right = higher[higher > top].min(initial=len(values))
    return float(values[top] - max(values[left : top + 1].min(), values[top:right].min()))
