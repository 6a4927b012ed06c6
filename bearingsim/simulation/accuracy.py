"""Standard errors of the BPFO line and the RMS of a record, from its ball passes."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from bearingsim import signals
from bearingsim.config import Case
from bearingsim.config.names import QUIET_LINE
from bearingsim.simulation.recording import RawRecord, Windows, recorded_samples, windows
from bearingsim.simulation.spectral_lines import has_other_lines, sensor_samples
from bearingsim.simulation.time_grid import Grid

MIN_PASSES = 16  # smallest number of ball passes for a standard error
COSINES = 12  # over the record: fewer increase Student's t, more miss the correlation of successive passes
TWO_SIGMA = 0.97725  # one-sided probability of two sigma of the normal distribution
THREE_SIGMA = 0.99865  # probability of a deviation below three sigma


class StandardErrors(NamedTuple):
    """Relative standard errors of the velocity's line at BPFO and of its RMS."""

    line: float
    rms: float

    @property
    def largest(self) -> float:
        """Larger of the two."""
        return max(self)


def standard_errors(
    case: Case, model: Any, grid: Grid, raw: RawRecord, pass_lines: Mapping[str, np.ndarray]
) -> StandardErrors:
    """Estimate the standard errors of the computed part of a record; infinite for too few passes.

    pass_lines: its ``lines_of_passes``.
    """
    if raw.repetition.period > 0:
        return StandardErrors(0.0, 0.0)
    samples, reach = recorded_samples(case, raw)
    record_windows = windows(case, grid, raw, reach)
    M, n = record_windows.M, len(record_windows.index)
    if n < MIN_PASSES:
        return StandardErrors(np.inf, np.inf)
    velocity = sensor_samples(case, samples, "velocity", record_windows.start, n * M)
    powers = np.mean(velocity.reshape(n, M) ** 2, axis=1, keepdims=True)
    min_amplitude = QUIET_LINE * np.sqrt(powers.mean())
    return StandardErrors(
        error_from_passes(pass_lines.get("velocity", np.empty((1, 0)))[0], min_amplitude)
        if has_other_lines(case)
        else _error_from_samples(case, model, grid, raw, record_windows, min_amplitude),
        float(0.5 * standard_error(powers) / (powers.mean() or 1.0)),
    )


def _error_from_samples(
    case: Case, model: Any, grid: Grid, raw: RawRecord, record_windows: Windows, min_amplitude: float
) -> float:
    """Estimate the relative standard error of a line that is a plain mean, from all samples of its passes.

    An impact divided between two passes adds to one pass what the other lacks, so the scatter of whole passes
    would overestimate the error of their mean several times.
    """
    M, n, start = record_windows.M, len(record_windows.index), record_windows.start
    velocity, Z_theta_0 = (
        sensor_samples(case, raw, "velocity", start, n * M),
        case.bearing.rollers * model.bearing.theta_0,
    )
    line = signals.amplitudes_by_pass(velocity, M, [1], start, Z_theta_0).mean()
    carrier = 2.0 * np.cos(signals.pass_angles(M, start, Z_theta_0) + np.angle(line))
    return _relative(standard_error(velocity.reshape(n, M) * carrier), line, min_amplitude)


def error_from_passes(lines: np.ndarray, min_amplitude: float) -> float:
    """Estimate the relative standard error of a line next to others; infinite for too few passes.

    lines: (n,) contribution of each ball pass to its complex amplitude, in the unit of ``min_amplitude``.
    """
    if len(lines) < MIN_PASSES:
        return np.inf
    weights = signals.pass_weights(len(lines), has_neighbours=True)
    line = np.average(lines, weights=weights)
    in_phase = (lines * np.exp(-1j * np.angle(line))).real
    return _relative(standard_error(in_phase[:, np.newaxis], weights), line, min_amplitude)


def _relative(error: float, line: complex, min_amplitude: float) -> float:
    return float(error / (max(abs(line), min_amplitude) or 1.0))


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
    coefficients = dct((values - values.mean(axis=0)).ravel(), norm="ortho")[1 : COSINES + 1]
    spectrum = np.mean(coefficients**2) / M
    t_factor = stdtrit(float(len(coefficients)), THREE_SIGMA) / 3.0
    return float(t_factor * np.sqrt(spectrum * np.sum(weights**2)) / np.sum(weights))
