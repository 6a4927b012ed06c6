"""Statistics of a series."""

import numpy as np


def statistics(series: np.ndarray) -> dict[str, float]:
    """RMS, peak, crest factor and kurtosis (3 for noise) of a series (n,), its mean taken out.

    A series that does not move has crest and kurtosis nan.
    """
    moving = series - series.mean()
    square = np.mean(moving**2)
    peak = np.abs(moving).max()
    alive = peak > 1e-12 * np.abs(series).max()  # less is rounding
    return {
        "rms": float(np.sqrt(square)),
        "peak": float(peak),
        "crest": float(peak / np.sqrt(square)) if alive else float("nan"),
        "kurtosis": float(np.mean(moving**4) / square**2) if alive else float("nan"),
    }
