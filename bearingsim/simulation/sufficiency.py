"""Standard errors of the requested features of a record, which ends when they are at most `until`.

A feature is computed over pairs of successive common periods (``ending.common_period``) that overlap by half, as
in ``trial.py``; a harmonic of BPFO in a record that also has other lines is computed from single ball passes. The
standard error of the mean is estimated by batch means. If values are positively correlated, it increases with the
batch size, so batches are doubled in size and the largest error is used (batch means: Jones, Haran, Caffo and
Neath 2006, J. Am. Stat. Assoc. 101, 1537; their bias: Vats and Flegal 2022, Biometrika 109, 735; stopping at a
relative width: Flegal and Gong 2015, Stat. Sinica 25, 655).
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache, partial
from math import inf, nan

import numpy as np

from bearingsim import signals
from bearingsim.config import Case
from bearingsim.config.names import LINES, QUIET_LINE, read_band
from bearingsim.simulation import ending, trial
from bearingsim.simulation.accuracy import TWO_SIGMA, StandardErrors
from bearingsim.simulation.comparison import fault_lines
from bearingsim.simulation.recording import RawRecord, first_sample, whole_passes
from bearingsim.simulation.run_setup import Setup
from bearingsim.simulation.spectral_lines import (
    amplitudes_by_pass,
    angles_of_record,
    has_other_lines,
    sensor_samples,
)

MIN_BATCHES = 4  # smallest number, chosen for at least three degrees of freedom of Student's t
HANN_VARIANCE_RATIO, HANN_POWER_VARIANCE_RATIO = 3.0 / 2.0, 35.0 / 18.0
"""Variances, for white noise, of a mean weighted by a Hann window and of one weighted by its square (mean square
of a windowed series), over that of a plain mean."""


class Inspections:
    """Accuracy checks of a run that ends early when the accuracy `until` is reached.

    passes: numbers of computed ball passes (settling included) at which the accuracy is checked; empty without
    `until`; record_passes: number of ball passes of the record, by number of computed ball passes.
    """

    def __init__(self, setup: Setup) -> None:
        self.setup = setup
        self.record_passes = {
            trial.last_pass(setup, count): count for count in ending.inspection_passes(setup.case)
        }
        self.passes = self.record_passes.keys()
        self.errors: dict[int, StandardErrors] = {}

    def ends(self, raw: RawRecord) -> bool:
        """Check if the standard errors of a run's record are at most `until`."""
        return self.record_errors(raw).largest <= (self.setup.case.until or 0.0)

    def complete_record(self, raw: RawRecord, may_end: bool) -> bool:
        """Check if the run of a trial is complete, that is if a separate run would end at the same ball pass.

        It is complete if it is periodic or, with ``may_end``, accurate enough or at the end of the record.
        """
        computed = raw.repetition.computed
        if raw.repetition.period > 0:
            return computed <= min(self.passes, default=computed)
        is_accurate = computed in self.passes and self.ends(raw)
        return may_end and (is_accurate or computed == self.setup.grid.passes)

    @property
    def shortest_setup(self) -> Setup:
        """Setup with the shortest possible record, on which the step is checked."""
        return self._with_passes(min(self.record_passes.values())) if self.record_passes else self.setup

    def setup_of_record(self, raw: RawRecord) -> Setup:
        """Return the setup with the duration of the record, which an accuracy check may have ended early.

        If the last check needs all ball passes of the run, the duration is that of this check, less than two ball
        passes shorter than the case's own, whether or not the accuracy is reached.
        """
        passes = raw.repetition.computed
        if raw.repetition.period > 0 or passes not in self.record_passes:
            return self.setup
        return self._with_passes(self.record_passes[passes])

    def _with_passes(self, passes: int) -> Setup:
        """Return the setup with a record of ``passes`` ball passes."""
        update = {"duration": passes / self.setup.grid.rate}
        return replace(self.setup, case=self.setup.case.model_copy(update=update))

    def record_errors(self, raw: RawRecord) -> StandardErrors:
        """Return the largest relative standard errors of a run's record; NaN without `until`."""
        if self.setup.case.until is None:
            return StandardErrors(nan, nan)
        passes = raw.repetition.computed
        if passes not in self.errors:
            self.errors[passes] = largest_standard_errors(self.setup_of_record(raw), raw)
        return self.errors[passes]


def monitored_features(case: Case) -> list[str]:
    """List the features that must reach the accuracy `until`: defect lines, velocity RMS, and those of the case.

    Lines of the acceleration are replaced by those of the velocity, which differ by a factor that is constant, or
    nearly so with a free cage.
    """
    names = (*(f"velocity@{line}" for line in fault_lines(case)), "velocity.rms", *case.features)
    return list(dict.fromkeys(name.replace("acceleration@", "velocity@") for name in names))


def largest_standard_errors(setup: Setup, raw: RawRecord) -> StandardErrors:
    """Estimate the largest relative standard errors of the monitored lines and RMS values.

    They are 0 for a periodic motion, and infinite for too few ball passes.
    """
    if raw.repetition.period > 0:
        return StandardErrors(0.0, 0.0)
    errors = feature_errors(setup, raw, monitored_features(setup.case))
    is_line = {name: "@" in name and ".rms" not in name for name in errors}
    return StandardErrors(
        max(error for name, error in errors.items() if is_line[name]),
        max(error for name, error in errors.items() if not is_line[name]),
    )


def feature_errors(setup: Setup, raw: RawRecord, requested: Sequence[str]) -> dict[str, float]:
    """Estimate the relative standard errors of the ``requested`` features of a non-periodic record, by name.

    They are relative to the value of the feature; for a line to at least ``QUIET_LINE`` of the standard deviation
    of the unfiltered signal, except for lines of an envelope. Infinite for too short a record, and for lines that
    it does not resolve.
    """
    case, grid = setup.case, setup.grid
    passes = whole_passes(case, grid)
    start, length = first_sample(case, grid), passes * grid.fine_per_pass + 1
    spans = trial.revolution_spans(passes, float(ending.common_period(case)), grid.fine_per_pass)
    if len(spans) <= MIN_BATCHES:
        return dict.fromkeys(requested, inf)
    fine_samples = cache(partial(sensor_samples, case, raw, start=start, count=length))
    low_passed_samples = cache(partial(sensor_samples, case, raw.low_passed, start=start, count=length))
    angles = angles_of_record(case, setup.model, grid, raw, start, length)
    window_features = [name for name in requested if not (has_other_lines(case) and _harmonic(name))]
    amplitudes, mean_squares = trial.feature_parts(
        setup, window_features, fine_samples, low_passed_samples, angles, spans
    )
    pass_features = [name for name in dict.fromkeys(requested) if name not in window_features]
    pass_amplitudes = amplitudes_by_pass(case, setup.model, grid, raw) if pass_features else {}
    for name in pass_features if pass_amplitudes else ():
        contributions = pass_amplitudes[name.partition("@")[0]][_harmonic(name) - 1]
        weights = signals.pass_weights(len(contributions), has_neighbours=True)
        amplitudes[name] = np.append(np.average(contributions, weights=weights), contributions)
    errors = {}
    for name, parts in amplitudes.items():
        min_amplitude = (
            0.0 if read_band(name) else QUIET_LINE * float(np.std(fine_samples(name.partition("@")[0])))
        )
        in_phase = (parts * np.exp(-1j * np.angle(parts[0]))).real
        errors[name] = batch_error(in_phase[1:]) / (max(abs(parts[0]), min_amplitude) or 1.0)
    for name, parts in mean_squares.items():
        errors[name] = 0.5 * batch_error(parts[1:]) / (parts[0] or 1.0)
    errors = {name: variance_ratio(case, name) ** 0.5 * error for name, error in errors.items()}
    return {name: inf if np.isnan(errors.get(name, nan)) else float(errors[name]) for name in requested}


def variance_ratio(case: Case, name: str) -> float:
    """Return the variance of a feature (for an RMS, of its square) over that of a plain mean.

    Only the RMS of the record and, in a record without other lines, harmonics of BPFO are plain means. All other
    lines, those of an envelope, and the RMS of a band are computed under a Hann window over the record.
    """
    band_feature = read_band(name)
    if band_feature is not None and not band_feature.line:
        return HANN_POWER_VARIANCE_RATIO
    is_plain = name.endswith(".rms") or (_harmonic(name) > 0 and not has_other_lines(case))
    return 1.0 if is_plain else HANN_VARIANCE_RATIO


def _harmonic(name: str) -> int:
    """Return the order of a BPFO harmonic of the motion, 0 for any other feature."""
    line = LINES.get(name.partition("@")[2])
    return 0 if line is None or read_band(name) else line.outer


def batch_error(values: np.ndarray) -> float:
    """Estimate the standard error of the mean of successive values (n,), in their unit.

    The result is the largest for batches of 1, 2, 4 ... values. Twice the variance from batches of one size, minus
    that from batches of half the size, has no first-order bias due to correlation between batches (Vats and Flegal
    2022). The error is scaled by Student's t so that two standard errors have the confidence of two sigma. It is
    infinite for fewer than MIN_BATCHES values, or if one is NaN (a line that a pair of common periods does not
    resolve).
    """
    from scipy.special import stdtrit

    n, size, previous = len(values), 1, 0.0
    largest = 0.0 if n >= MIN_BATCHES and np.isfinite(values).all() else inf
    while (count := n // size) >= MIN_BATCHES:
        means = values[n - count * size :].reshape(count, size).mean(axis=1)
        variance = size * float(np.var(means, ddof=1))
        unbiased = max(variance, 2.0 * variance - previous) if size > 1 else variance
        t_factor = float(stdtrit(count - 1.0, TWO_SIGMA)) / 2.0
        largest = max(largest, t_factor * (unbiased / n) ** 0.5)
        previous, size = variance, 2 * size
    return largest
