"""Standard errors of the amplitude at BPFO and of the RMS of a record, from its ball passes."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from bearingsim import signals
from bearingsim.config import Case
from bearingsim.config.names import QUIET_LINE
from bearingsim.simulation.recording import RawRecord, Segments, pass_segments, recorded_samples
from bearingsim.simulation.spectral_lines import has_other_lines, sensor_samples
from bearingsim.simulation.time_grid import Grid

MIN_PASSES = 16  # smallest number of ball passes for a standard error
COSINE_COUNT = 12  # of the lowest cosines; fewer increase Student's t, more lose the correlation of passes
TWO_SIGMA, THREE_SIGMA = 0.97725, 0.99865  # probabilities of a deviation below two and three sigma (one-sided)


class StandardErrors(NamedTuple):
    """Relative standard errors of the velocity.

    line: of the amplitude at BPFO, or the largest of those of the monitored lines; rms: of the RMS, likewise.
    """

    line: float
    rms: float

    @property
    def largest(self) -> float:
        """Larger of the two."""
        return max(self)


def estimate_standard_errors(
    case: Case, model: Any, grid: Grid, raw: RawRecord, pass_amplitudes: Mapping[str, np.ndarray]
) -> StandardErrors:
    """Estimate the standard errors of the computed part of a record.

    Zero for a periodic motion, infinite for too few passes. pass_amplitudes: result of ``amplitudes_by_pass``.
    """
    if raw.repetition.period > 0:
        return StandardErrors(0.0, 0.0)
    samples, margin = recorded_samples(case, raw)
    segments = pass_segments(case, grid, raw, margin)
    M, n = segments.M, len(segments.index)
    if n < MIN_PASSES:
        return StandardErrors(np.inf, np.inf)
    velocity = sensor_samples(case, samples, "velocity", segments.start, n * M)
    powers = np.mean(velocity.reshape(n, M) ** 2, axis=1, keepdims=True)
    min_amplitude = QUIET_LINE * np.sqrt(powers.mean())
    return StandardErrors(
        error_from_passes(pass_amplitudes.get("velocity", np.empty((1, 0)))[0], min_amplitude)
        if has_other_lines(case)
        else _error_from_samples(case, model, grid, raw, segments, min_amplitude),
        float(0.5 * standard_error(powers) / (powers.mean() or 1.0)),
    )


def _error_from_samples(
    case: Case, model: Any, grid: Grid, raw: RawRecord, segments: Segments, min_amplitude: float
) -> float:
    """Estimate the relative standard error of the amplitude at BPFO without other lines, from all samples.

    The amplitude is then a plain mean. An impact at the boundary of two passes adds to one pass what the other
    lacks, so the scatter of whole passes would overestimate the error of their mean several times.
    """
    M, n, start = segments.M, len(segments.index), segments.start
    velocity, Z_theta_0 = (
        sensor_samples(case, raw, "velocity", start, n * M),
        case.bearing.rollers * model.bearing.theta_0,
    )
    amplitude = signals.amplitudes_by_pass(velocity, M, [1], start, Z_theta_0).mean()
    carrier = 2.0 * np.cos(signals.pass_angles(M, start, Z_theta_0) + np.angle(amplitude))
    return _relative(standard_error(velocity.reshape(n, M) * carrier), amplitude, min_amplitude)


def error_from_passes(contributions: np.ndarray, min_amplitude: float) -> float:
    """Estimate the relative standard error of an amplitude next to other lines; infinite for too few passes.

    contributions: (n,) contribution of each ball pass to the complex amplitude; min_amplitude: smallest amplitude
    to which the error is related, in the same unit.
    """
    if len(contributions) < MIN_PASSES:
        return np.inf
    weights = signals.pass_weights(len(contributions), has_neighbours=True)
    amplitude = np.average(contributions, weights=weights)
    in_phase = (contributions * np.exp(-1j * np.angle(amplitude))).real
    return _relative(standard_error(in_phase[:, np.newaxis], weights), amplitude, min_amplitude)


def _relative(error: float, amplitude: complex, min_amplitude: float) -> float:
    """Return an error relative to an amplitude, or to ``min_amplitude`` if that is larger."""
    return float(error / (max(abs(amplitude), min_amplitude) or 1.0))


def standard_error(values: np.ndarray, weights: np.ndarray | None = None) -> float:
    """Estimate the standard error of the mean over ball passes, which may be correlated.

    values: (passes, M), M values of each pass, from which the mean pass is subtracted; weights: (passes,), by
    default equal. The spectral density at zero frequency is estimated by the mean square of the projections on the
    lowest cosines over the record (Lazarus, Lewis, Stock and Watson 2018, J. Bus. Econ. Stat. 36, 541:
    equal-weighted cosines), so slow change contributes, but alternation from pass to pass does not. The error is
    scaled by Student's t so that three standard errors have the confidence of three sigma.
    """
    from scipy.fft import dct
    from scipy.special import stdtrit

    passes, M = values.shape
    weights = np.ones(passes) if weights is None else weights
    coefficients = dct((values - values.mean(axis=0)).ravel(), norm="ortho")[1 : COSINE_COUNT + 1]
    spectrum = np.mean(coefficients**2) / M
    t_factor = stdtrit(float(len(coefficients)), THREE_SIGMA) / 3.0
    return float(t_factor * np.sqrt(spectrum * np.sum(weights**2)) / np.sum(weights))
