"""Checks of signals: refusal of those that cannot be analysed, and remarks on dropouts."""

from pathlib import Path

import numpy as np

from bearingsim.measured.content import UNSPECIFIED, MeasuredError, Request

MAX_CLIPPED = 1e-3
"""Largest share of samples at the smallest or largest value, in runs of two and more."""
MIN_LEVELS = 8
"""Number of different values below which equal neighbours at the extremes are due to a coarse resolution."""
MAX_CONSTANT = 0.02
"""Largest share of a record in constant runs that gives no remark."""
MIN_RUN = 32
"""Number of equal samples in a row that a coarse resolution alone does not explain."""
MIN_SHORT_RUN = 4
"""Number of equal samples in a row, in a record of few samples, that counts as constant."""


def refuse_unusable(
    path: Path, channel: str, values: np.ndarray, rate: float, request: Request = UNSPECIFIED
) -> None:
    """Raise MeasuredError for an unusable signal (n,), sampled at ``rate`` (Hz).

    Unusable are signals with missing or infinite samples, constant and clipped ones, and those of too few
    different values. request: names the option or key that selects another channel.
    """
    missing = np.flatnonzero(~np.isfinite(values))
    if len(missing):
        raise MeasuredError(
            path,
            f"`{channel}` has {len(missing)} missing or infinite samples, the first at {missing[0] / rate:.6g} s:"
            " export a part without them",
        )
    low, high = values.min(), values.max()
    if high - low <= 1e-12 * max(abs(low), abs(high)):
        advice = f"check the sensor, or name a `{request.name('channel')}`"
        raise MeasuredError(path, f"`{channel}` is constant ({low:.6g}): {advice}")
    share = clipped_share(values)
    if share > MAX_CLIPPED and len(np.unique(values)) < MIN_LEVELS:
        raise MeasuredError(
            path,
            f"`{channel}` has only {len(np.unique(values))} different values: measure with a smaller range, or "
            "export with more digits",
        )
    if share > MAX_CLIPPED:
        raise MeasuredError(
            path,
            f"`{channel}` is clipped: {100.0 * share:.2g} % of its samples are at its extremes in a row: "
            "measure again with a larger range",
        )


def clipped_share(values: np.ndarray) -> float:
    """Compute the share of samples at the largest or smallest value that have a neighbour at the same value."""
    share = 0.0
    for extreme in (values.min(), values.max()):
        is_extreme = values == extreme
        has_equal_neighbour = np.zeros(len(values), bool)
        has_equal_neighbour[1:] = is_extreme[1:] & is_extreme[:-1]
        has_equal_neighbour[:-1] |= has_equal_neighbour[1:]
        share += float(np.count_nonzero(has_equal_neighbour & is_extreme)) / len(values)
    return share


def describe_dropouts(channel: str, values: np.ndarray, rate: float) -> str | None:
    """Return a remark on the constant parts of a signal (n,) at ``rate`` (Hz); None if they are short."""
    bounds = np.concatenate([[0], 1 + np.flatnonzero(np.diff(values)), [len(values)]])
    lengths, begins = np.diff(bounds), bounds[:-1]
    is_long = lengths >= max(MIN_SHORT_RUN, min(MIN_RUN, MAX_CONSTANT * len(values)))
    total = int(lengths[is_long].sum())
    if total <= MAX_CONSTANT * len(values):
        return None
    begin, count = float(begins[is_long][0]) / rate, np.count_nonzero(is_long)
    parts, advice = (
        (f", in {count} parts", "check cable and range") if count > 1 else ("", "export a part without it")
    )
    share = f"{total / rate:.4g} s from {begin:.4g} s on{parts}, {100.0 * total / len(values):.0f} % of the record"
    return f"`{channel}` does not change for {share}: {advice}"
