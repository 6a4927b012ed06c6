"""Differences between two trials in the features of a study, with their confidence limits.

A line's amplitude, and the square of an RMS, are means under a window. Their difference d between two models is
one, too. How it scatters is seen between pairs of turns of the slowest defect: a motion that is no chaos has none.

    error = |d| + t s,   s^2 = 2/N var(d_w)

over W = N - 1 pairs of the N turns, t Student's at 97.5 % with W - 1 degrees of freedom. (Under Hann's window a
mean over N turns has 2/N of the variance of one over two turns.) Of the largest force, d is that of each turn.
"""

from typing import NamedTuple

import numpy as np

from bearingsim.config.names import read_band
from bearingsim.simulation.trial import LARGEST_FORCE, Trial
from bearingsim.study.goal import HEALTHY

SURE = 0.975


class Value(NamedTuple):
    """A feature as a trial has it: its value (SI), what it is in each part, and the share of one part's variance
    that the whole has.
    """

    value: float
    parts: np.ndarray
    share: float


def value(feature: str, trial: Trial, baseline: Trial | None) -> Value:
    """Return a feature (SI) of a trial, against its healthy case if it is measured so."""
    if feature == LARGEST_FORCE:
        turns = np.array_split(trial.forces, trial.turns)
        return Value(float(trial.forces.max()), np.array([turn.max() for turn in turns]), 1.0)
    share = 2.0 / trial.turns
    line = feature.removesuffix(HEALTHY)
    if read_band(line) is not None and feature != line and baseline is not None:  # magnitudes are subtracted
        own, healthy = value(line, trial, None), value(line, baseline, None)
        return Value(own.value - healthy.value, own.parts - healthy.parts, share)
    if line in trial.powers:
        rms = float(np.sqrt(trial.powers[line][0]))
        return Value(rms, 0.5 * trial.powers[line][1:] / (rms or 1.0), share)
    amplitudes = trial.lines[line] - (baseline.lines[line] if feature != line and baseline is not None else 0.0)
    parts = amplitudes[1:] * np.exp(-1j * np.angle(amplitudes[0]))
    return Value(float(abs(amplitudes[0])), parts.real, share)


def error(own: Value, other: Value) -> float:
    """Bound the difference (SI) of two values at 97.5 %; infinite if too little is seen of its scatter."""
    from scipy.special import stdtrit

    if len(own.parts) < 2 or len(own.parts) != len(other.parts):
        return float("inf")  # how they scatter is not seen
    apart, parts = abs(own.value - other.value), own.parts - other.parts
    t = float(stdtrit(len(parts) - 1.0, SURE))
    return apart + t * float(np.sqrt(own.share) * np.std(parts, ddof=1))
