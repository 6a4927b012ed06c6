"""Refusal of signals that cannot be analysed."""

from pathlib import Path

import numpy as np

from bearingsim.measured.content import UNSPECIFIED, MeasuredError, Request

MAX_CLIPPED = 1e-3
"""Largest share of samples at the extremes, in runs of two and more."""

MIN_LEVELS = 8
"""Different values of a signal, under which equal neighbours at its extremes are due to its resolution."""

LONGEST_REST = 0.02
"""Largest share of a record without change that gives no remark."""
SHORTEST_REST = 32
"""Equal samples in a row that are no accident of a coarse resolution."""


def refuse_unusable(
    path: Path, channel: str, values: np.ndarray, rate: float, request: Request = UNSPECIFIED
) -> None:
    """Raise MeasuredError for a signal (n,) at ``rate`` (Hz) with missing samples, without motion, too coarse, or
    clipped."""
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
    """Compute the share of samples at the largest or smallest value whose neighbour has the same value."""
    share = 0.0
    for extreme in (values.min(), values.max()):
        is_extreme = values == extreme
        in_run = np.zeros(len(values), bool)
        in_run[1:] = is_extreme[1:] & is_extreme[:-1]
        in_run[:-1] |= in_run[1:]
        share += float(np.count_nonzero(in_run & is_extreme)) / len(values)
    return share


def dropout(channel: str, values: np.ndarray, rate: float) -> str | None:
    """Return a remark on the parts of a signal (n,) at ``rate`` (Hz) without change; None if they are short."""
    edges = np.concatenate([[0], 1 + np.flatnonzero(np.diff(values)), [len(values)]])
    lengths, begins = np.diff(edges), edges[:-1]
    rests = lengths >= min(SHORTEST_REST, LONGEST_REST * len(values))
    total = int(lengths[rests].sum())
    if total <= LONGEST_REST * len(values):
        return None
    begin, count = float(begins[rests][0]) / rate, np.count_nonzero(rests)
    parts, advice = (
        (f", in {count} parts", "check cable and range") if count > 1 else ("", "export a part without it")
    )
    share = f"{total / rate:.4g} s from {begin:.4g} s on{parts}, {100.0 * total / len(values):.0f} % of the record"
    return f"`{channel}` does not change for {share}: {advice}"
