"""Thresholds: scores exceeded by 1 % of healthy signals, by length and tolerance (benchmarks/diagnosis)."""

import csv
from functools import cache
from math import exp, log, log10
from pathlib import Path

import numpy as np

from bearingsim.diagnosis.combs import HARMONICS
from bearingsim.diagnosis.kinematics import Lines

TABLE_FILE = Path(__file__).with_name("thresholds.csv")
TOLERANCES = 0.005, 0.04
"""Range of the relative tolerance for which thresholds were determined."""
MAX_ORDERS = 18.2
"""Largest sum of the orders of the three lines of the bearings for which thresholds were determined (NF308)."""
SLOPE_ROWS = 4
"""Number of last lengths of the table that give the slope beyond it: a single octave differs by random scatter."""
CLEAR_DB = 3.0
"""dB; excess of each harmonic over the threshold from which a result is clear."""


def threshold(revolutions: float, tolerance: float) -> float:
    """Return the threshold of the score for a number of revolutions of the shaft and a relative tolerance.

    It is interpolated over the logarithms of both. Beyond 320 revolutions it increases with the mean slope of the
    last three octaves; below 5 revolutions the value at 5 is used.
    """
    log_lengths, log_tolerances, scores = _table()
    by_length = np.array([np.interp(log(tolerance), log_tolerances, row) for row in scores])
    log_length, log_longest = log(revolutions), log_lengths[-1]
    slope = max(0.0, float(np.polyfit(log_lengths[-SLOPE_ROWS:], by_length[-SLOPE_ROWS:], 1)[0]))
    return float(np.interp(log_length, log_lengths, by_length) + max(0.0, log_length - log_longest) * slope)


def equivalent_revolutions(lines: Lines, revolutions: float) -> float:
    """Return the number of revolutions for which the threshold of a bearing is to be taken.

    lines: of the bearing (Hz); revolutions: those of its shaft in the record. The number of fundamentals within
    the tolerance, which increases the largest score by chance, is proportional to the orders of the lines and to
    the revolutions. More orders than ``MAX_ORDERS`` therefore count as more revolutions; fewer do not lower the
    threshold.
    """
    orders = (lines.outer + lines.inner + lines.roller) / lines.shaft
    return revolutions * max(1.0, orders / MAX_ORDERS)


@cache
def _table() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the logarithms of revolutions (l,) and of tolerances (t,), and scores (l, t)."""
    with TABLE_FILE.open(newline="") as file:
        rows = [tuple(map(float, row)) for row in list(csv.reader(file))[1:]]
    lengths, tolerances = (sorted({row[column] for row in rows}) for column in (0, 1))
    scores = np.array([row[2] for row in sorted(rows)]).reshape(len(lengths), len(tolerances))
    return np.log(lengths), np.log(tolerances), scores


def revolutions_range() -> tuple[float, float]:
    """Return the smallest and largest number of revolutions for which thresholds were determined."""
    log_lengths = _table()[0]
    return round(exp(log_lengths[0])), round(exp(log_lengths[-1]))


def clear_score(limit: float) -> float:
    """Return the score from which a result is clear, ``CLEAR_DB`` over the threshold ``limit``."""
    return limit + HARMONICS * log(10.0 ** (CLEAR_DB / 10.0))


def decibels(score: float) -> float:
    """Convert a score to the height (dB over the local median) of each harmonic of a comb of equal heights."""
    return 10.0 * log10(max(exp(score / HARMONICS) - 1.0, 1e-3))
