"""Statistics of a series."""

import numpy as np


def statistics(series: np.ndarray, weights: np.ndarray | None = None) -> dict[str, float]:
    """Compute RMS, peak, crest factor and kurtosis (3 for noise) of a series (n,) without its mean.

    weights: (n,) number of occurrences of each value, 1 by default. Crest and kurtosis of a constant series are
    nan.
    """
    centred = series - np.average(series, weights=weights)
    peak, largest = (max(values.max(), -values.min()) for values in (centred, series))
    squares = np.square(centred, out=centred)  # in place: moments of odd order come before
    mean_square = np.average(squares, weights=weights)
    varies = peak > 1e-12 * largest  # smaller values are rounding errors
    fourth_moment = np.average(np.square(squares, out=squares), weights=weights)
    return {
        "rms": float(np.sqrt(mean_square)),
        "peak": float(peak),
        "crest": float(peak / np.sqrt(mean_square)) if varies else float("nan"),
        "kurtosis": float(fourth_moment / mean_square**2) if varies else float("nan"),
    }
