"""Standard errors of the BPFO line and the RMS of a record, from its ball passes."""

from typing import Any, NamedTuple

import numpy as np

from bearingsim import signals
from bearingsim.config import Case
from bearingsim.core.sampling import sampling_kernel
from bearingsim.simulation.recording import RawRecord, Windows, windows
from bearingsim.simulation.spectral_lines import has_other_lines, lines_of_passes, sensed
from bearingsim.simulation.time_grid import Grid

MIN_PASSES = 16  # smallest number of ball passes for a standard error
COSINES = 12  # over the record: fewer increase Student's t, more miss the correlation of successive passes
THREE_SIGMA = 0.99865  # probability of a deviation below three sigma
LOOK_AGAIN = 1.1  # ratio of the numbers of passes at successive estimates of the errors
QUIET_LINE = 1e-3  # part of the RMS (-60 dB) to which changes of a weaker line are relative


class StandardErrors(NamedTuple):
    """Relative standard errors of the velocity's line at BPFO and of its RMS."""

    line: float
    rms: float

    @property
    def largest(self) -> float:
        """Larger of the two."""
        return max(self)


def standard_errors(case: Case, model: Any, cut: Grid, raw: RawRecord) -> StandardErrors:
    """Estimate the standard errors of the computed part of a record; infinite for too few passes."""
    if raw.repetition.period > 0:
        return StandardErrors(0.0, 0.0)
    taps = sampling_kernel(cut.fine_rate / case.sampling)
    of_record = windows(case, cut, raw, reach=len(taps) // 2)
    M, n = of_record.M, len(of_record.index)
    if n < MIN_PASSES:
        return StandardErrors(np.inf, np.inf)
    low = sensed(case, raw.through(taps), "velocity", of_record.start, n * M)
    power = np.mean(low.reshape(n, M) ** 2, axis=1, keepdims=True)
    least = QUIET_LINE * np.sqrt(power.mean())
    error_of_line = _error_from_passes if has_other_lines(case) else _error_from_samples
    return StandardErrors(
        error_of_line(case, model, cut, raw, of_record, least),
        float(0.5 * standard_error(power) / (power.mean() or 1.0)),
    )


def _error_from_samples(
    case: Case, model: Any, cut: Grid, raw: RawRecord, of_record: Windows, least: float
) -> float:
    """Estimate the relative standard error of a line that is a plain mean, from all samples of its passes.

    An impact divided between two passes adds to one pass what the other lacks, so the scatter of whole passes
    would overestimate the error of their mean several times.
    """
    M, n, start = of_record.M, len(of_record.index), of_record.start
    velocity, Z_theta_0 = sensed(case, raw, "velocity", start, n * M), case.bearing.rollers * model.bearing.theta_0
    line = signals.lines_by_pass(velocity, M, [1], start, Z_theta_0).mean()
    along = 2.0 * np.cos(signals.pass_angles(M, start, Z_theta_0) + np.angle(line))
    return _relative(standard_error(velocity.reshape(n, M) * along), line, least)


def _error_from_passes(
    case: Case, model: Any, cut: Grid, raw: RawRecord, of_record: Windows, least: float
) -> float:
    """Estimate the relative standard error of BPFO if there are other lines, from weighted passes."""
    lines = lines_of_passes(case, model, cut, raw).get("velocity", np.empty((1, 0)))[0]
    if len(lines) < MIN_PASSES:
        return np.inf
    weights = signals.pass_weights(len(lines), neighbours=True)
    line = np.average(lines, weights=weights)
    along = (lines * np.exp(-1j * np.angle(line))).real
    return _relative(standard_error(along[:, np.newaxis], weights), line, least)


def _relative(error: float, line: complex, least: float) -> float:
    return float(error / (max(abs(line), least) or 1.0))


def standard_error(values: np.ndarray, weights: np.ndarray | None = None) -> float:
    """Estimate the standard error of the mean over ball passes, which may be correlated.

    values: (passes, M), M values of each pass, from which the mean pass is subtracted; weights: (passes,), by
    default equal. The spectrum at zero frequency is the mean square of the projections on the lowest cosines over
    the record (Lazarus, Lewis, Stock and Watson 2018, J. Bus. Econ. Stat. 36, 541: equal-weighted cosines), so
    alternation does not contribute, but slow change does. The error is scaled by Student's t so that three
    standard errors have the confidence of three sigma.
    """
    from scipy.fft import dct
    from scipy.special import stdtrit

    passes, M = values.shape
    weights = np.ones(passes) if weights is None else weights
    lowest = dct((values - values.mean(axis=0)).ravel(), norm="ortho")[1 : COSINES + 1]
    spectrum = np.mean(lowest**2) / M
    student = stdtrit(float(len(lowest)), THREE_SIGMA) / 3.0
    return float(student * np.sqrt(spectrum * np.sum(weights**2)) / np.sum(weights))
