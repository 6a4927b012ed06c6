"""Scores exceeded by 1 % of healthy signals, by length and tolerance (benchmarks/diagnosis)."""

import csv
from functools import cache
from math import exp, log, log10
from pathlib import Path

import numpy as np

from bearingsim.diagnosis.combs import HARMONICS
from bearingsim.diagnosis.kinematics import Lines

TABLE = Path(__file__).with_name("thresholds.csv")
TOLERANCES = 0.005, 0.04
"""Range of the relative tolerance for which thresholds were measured."""
MEASURED_ORDERS = 18.2
"""Largest sum of the orders of the three lines of the bearings for which thresholds were measured (NF308)."""
SLOPE_ROWS = 4
"""Last lengths of the table that give the slope beyond it: one octave alone is within the scatter of the table."""
CLEAR_DB = 3.0
"""dB; height of each harmonic over the threshold from which a result is clear."""


def threshold(turns: float, tolerance: float) -> float:
    """Return the threshold of the score for a record of some revolutions of the shaft and a relative tolerance.

    It is interpolated over the logarithms of both. Beyond 320 revolutions it rises with the mean slope of the last
    three octaves; below 5 revolutions the value at 5 is used.
    """
    lengths, tolerances, scores = _table()
    by_length = np.array([np.interp(log(tolerance), tolerances, row) for row in scores])
    x, last = log(turns), lengths[-1]
    slope = max(0.0, float(np.polyfit(lengths[-SLOPE_ROWS:], by_length[-SLOPE_ROWS:], 1)[0]))
    return float(np.interp(x, lengths, by_length) + max(0.0, x - last) * slope)


def equivalent_turns(lines: Lines, turns: float) -> float:
    """Return the revolutions of a measured bearing with as many fundamentals as a bearing has in some revolutions.

    lines: of the bearing (Hz); turns: revolutions of its shaft. The number of fundamentals within the tolerance
    is proportional to the orders of the lines and to the revolutions. Few rollers do not lower the threshold.
    """
    orders = (lines.outer + lines.inner + lines.roller) / lines.shaft
    return turns * max(1.0, orders / MEASURED_ORDERS)


@cache
def _table() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the logarithms of turns (l,) and of tolerances (t,), and scores (l, t)."""
    with TABLE.open(newline="") as file:
        rows = [tuple(map(float, row)) for row in list(csv.reader(file))[1:]]
    turns, tolerances = (sorted({row[column] for row in rows}) for column in (0, 1))
    scores = np.array([row[2] for row in sorted(rows)]).reshape(len(turns), len(tolerances))
    return np.log(turns), np.log(tolerances), scores


def measured_turns() -> tuple[float, float]:
    """Return the smallest and largest number of revolutions for which thresholds were measured."""
    lengths = _table()[0]
    return round(exp(lengths[0])), round(exp(lengths[-1]))


def clear(limit: float) -> float:
    """Return the score from which a result is clear, ``CLEAR_DB`` over a threshold."""
    return limit + HARMONICS * log(10.0 ** (CLEAR_DB / 10.0))


def decibels(score: float) -> float:
    """Convert a score to the height (dB over the local median) that each of its harmonics has if all are equal."""
    return 10.0 * log10(max(exp(score / HARMONICS) - 1.0, 1e-3))
