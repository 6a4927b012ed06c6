"""Differences between two trials in the features of a study, with their confidence limits.

The amplitude of a line and the square of an RMS are windowed means, and so is their difference d between two
models. Its scatter is estimated from pairs of revolutions ("turns") of the slowest defect; it is small unless the
motion is chaotic.

    error = |d| + t s,   s^2 = 2/N var(d_w)

with d_w over W = N - 1 pairs of the N turns, and t of Student's distribution at 97.5 % with W - 1 degrees of
freedom. (Under Hann's window a mean over N turns has 2/N of the variance of one over two turns.) For the largest
force, d_w is the difference in each turn, and s^2 its variance.
"""

from typing import NamedTuple

import numpy as np

from bearingsim.config.names import read_band
from bearingsim.simulation.trial import LARGEST_FORCE, Trial, part_count
from bearingsim.study.goal import HEALTHY_SUFFIX

CONFIDENCE = 0.975


class Value(NamedTuple):
    """Feature of a trial: its value (SI), the values in each part, and the ratio of the variance of the value to
    that of a part.
    """

    value: float
    parts: np.ndarray
    share: float


def value(feature: str, trial: Trial, baseline: Trial | None) -> Value:
    """Return a feature (SI) of a trial, relative to the healthy case ``baseline`` if the feature is so defined."""
    turn_count = max(1, trial.turns)  # a short record has no whole revolution of a defect
    if feature == LARGEST_FORCE:
        turns = np.array_split(trial.forces, turn_count)
        return Value(float(trial.forces.max()), np.array([turn.max() for turn in turns]), 1.0)
    share = 2.0 / turn_count
    line = feature.removesuffix(HEALTHY_SUFFIX)
    if feature != line and baseline is None:  # a bearing without defects
        return Value(0.0, np.zeros(part_count(trial.turns) - 1), share)
    if read_band(line) is not None and feature != line and baseline is not None:  # magnitudes are subtracted
        faulty, healthy = value(line, trial, None), value(line, baseline, None)
        return Value(faulty.value - healthy.value, faulty.parts - healthy.parts, share)
    if line in trial.powers:
        rms = float(np.sqrt(trial.powers[line][0]))
        return Value(rms, 0.5 * trial.powers[line][1:] / (rms or 1.0), share)
    amplitudes = trial.lines[line] - (baseline.lines[line] if feature != line and baseline is not None else 0.0)
    parts = amplitudes[1:] * np.exp(-1j * np.angle(amplitudes[0]))
    return Value(float(abs(amplitudes[0])), parts.real, share)


def error(value: Value, reference: Value) -> float:
    """Bound the difference (SI) of two values at 97.5 %; infinite with too few parts to estimate its scatter."""
    from scipy.special import stdtrit

    if len(value.parts) < 2 or len(value.parts) != len(reference.parts):
        return float("inf")  # scatter unknown
    difference, parts = abs(value.value - reference.value), value.parts - reference.parts
    t = float(stdtrit(len(parts) - 1.0, CONFIDENCE))
    return difference + t * float(np.sqrt(value.share) * np.std(parts, ddof=1))
