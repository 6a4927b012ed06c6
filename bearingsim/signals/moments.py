"""Statistics of a series."""

import numpy as np


def statistics(series: np.ndarray, weights: np.ndarray | None = None) -> dict[str, float]:
    """Compute RMS, peak, crest factor and kurtosis (3 for noise) of a series (n,) without its mean.

    weights: (n,) number of occurrences of each value, 1 by default. Crest and kurtosis of a constant series are
    nan.
    """
    moving = series - np.average(series, weights=weights)
    peak, level = (max(values.max(), -values.min()) for values in (moving, series))
    power = np.square(moving, out=moving)
    square = np.average(power, weights=weights)
    alive = peak > 1e-12 * level  # smaller values are rounding errors
    fourth = np.average(np.square(power, out=power), weights=weights)
    return {
        "rms": float(np.sqrt(square)),
        "peak": float(peak),
        "crest": float(peak / np.sqrt(square)) if alive else float("nan"),
        "kurtosis": float(fourth / square**2) if alive else float("nan"),
    }
