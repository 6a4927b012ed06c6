"""RMS, peak, crest factor and kurtosis of a series."""

import numpy as np


def statistics(series: np.ndarray, weights: np.ndarray | None = None) -> dict[str, float]:
    """Compute RMS, peak, crest factor and kurtosis (3 for Gaussian noise) of a series (n,) without its mean.

    weights: (n,) number of occurrences of each value, 1 by default. Returns values by `rms`, `peak`, `crest` and
    `kurtosis`; crest factor and kurtosis of a constant series are NaN.
    """
    centred = series - np.average(series, weights=weights)
    peak, largest_value = (max(values.max(), -values.min()) for values in (centred, series))
    squares = np.square(centred, out=centred)  # in place to save memory: `centred` is not used below
    mean_square = np.average(squares, weights=weights)
    varies = peak > 1e-12 * largest_value  # smaller deviations are rounding errors
    fourth_moment = np.average(np.square(squares, out=squares), weights=weights)
    return {
        "rms": float(np.sqrt(mean_square)),
        "peak": float(peak),
        "crest": float(peak / np.sqrt(mean_square)) if varies else float("nan"),
        "kurtosis": float(fourth_moment / mean_square**2) if varies else float("nan"),
    }
