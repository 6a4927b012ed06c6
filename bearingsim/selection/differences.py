"""Differences between two trials in the features of a study, with their confidence limits.

The amplitude of a line and the square of an RMS are windowed means, and so is their difference d between two
models. The standard error s of d is estimated from pairs of revolutions of the slowest defect; it is small unless
the motion is chaotic.

    error = |d| + t s,   s^2 = 2/N var(d_w)

with the difference d_w in each of the W = N - 1 pairs of the N revolutions, and t of Student's distribution at
97.5 % with W - 1 degrees of freedom. (Under a Hann window the variance of a mean over N revolutions is 2/N of that
over two revolutions.) For the largest force, d_w is the difference in each revolution, and s^2 its variance.
"""

from typing import NamedTuple

import numpy as np

from bearingsim.config.names import read_band
from bearingsim.simulation.trial import LARGEST_FORCE, Trial, part_count
from bearingsim.study.goal import HEALTHY_SUFFIX

CONFIDENCE = 0.975  # one-sided confidence level of an error bound


class FeatureValue(NamedTuple):
    """Feature of a trial.

    value: over the whole trial (SI); parts: values in its parts, (mean square)/(2 RMS) for an RMS; variance_ratio:
    variance of the value over that of a part.
    """

    value: float
    parts: np.ndarray
    variance_ratio: float


def feature_value(feature: str, trial: Trial, baseline: Trial | None) -> FeatureValue:
    """Return a feature (SI) of a trial, as the change from the healthy case ``baseline`` if the feature is one."""
    revolution_count = max(1, trial.revolutions)  # a short record has no whole revolution of a defect
    if feature == LARGEST_FORCE:
        forces_by_revolution = np.array_split(trial.forces, revolution_count)
        return FeatureValue(
            float(trial.forces.max()), np.array([forces.max() for forces in forces_by_revolution]), 1.0
        )
    variance_ratio = 2.0 / revolution_count
    base_name = feature.removesuffix(HEALTHY_SUFFIX)
    if feature != base_name and baseline is None:  # a bearing without defects
        return FeatureValue(0.0, np.zeros(part_count(trial.revolutions) - 1), variance_ratio)
    if read_band(base_name) is not None and feature != base_name and baseline is not None:
        # of features in a band, magnitudes are subtracted, not complex amplitudes
        faulty, healthy = feature_value(base_name, trial, None), feature_value(base_name, baseline, None)
        return FeatureValue(faulty.value - healthy.value, faulty.parts - healthy.parts, variance_ratio)
    if base_name in trial.mean_squares:
        rms = float(np.sqrt(trial.mean_squares[base_name][0]))
        return FeatureValue(rms, 0.5 * trial.mean_squares[base_name][1:] / (rms or 1.0), variance_ratio)
    amplitudes = trial.amplitudes[base_name] - (
        baseline.amplitudes[base_name] if feature != base_name and baseline is not None else 0.0
    )
    parts = amplitudes[1:] * np.exp(-1j * np.angle(amplitudes[0]))
    return FeatureValue(float(abs(amplitudes[0])), parts.real, variance_ratio)


def difference_bound(value: FeatureValue, reference: FeatureValue) -> float:
    """Bound the difference (SI) of two values at 97.5 % confidence; infinite with too few parts."""
    from scipy.special import stdtrit

    if len(value.parts) < 2 or len(value.parts) != len(reference.parts):
        return float("inf")
    difference, parts = abs(value.value - reference.value), value.parts - reference.parts
    t = float(stdtrit(len(parts) - 1.0, CONFIDENCE))
    return difference + t * float(np.sqrt(value.variance_ratio) * np.std(parts, ddof=1))
