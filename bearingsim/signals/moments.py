"""Statistics of a series."""

import numpy as np


def statistics(series: np.ndarray, weights: np.ndarray | None = None) -> dict[str, float]:
    """RMS, peak, crest factor and kurtosis (3 for noise) of a series (n,), its mean taken out.

    weights: (n,) how often each value occurs, if not once. A series that does not move has crest and kurtosis nan.
    """
    moving = series - np.average(series, weights=weights)
    square = np.average(moving**2, weights=weights)
    peak = np.abs(moving).max()
    alive = peak > 1e-12 * np.abs(series).max()  # less is rounding
    return {
        "rms": float(np.sqrt(square)),
        "peak": float(peak),
        "crest": float(peak / np.sqrt(square)) if alive else float("nan"),
        "kurtosis": float(np.average(moving**4, weights=weights) / square**2) if alive else float("nan"),
    }
