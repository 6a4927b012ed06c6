"""Errors of line, RMS and largest force of a record due to incomplete settling.

For a periodic motion the record is compared with its steady passes. Otherwise its second half is compared with the
first, and the decay between them is extrapolated; each error is at least the scatter between quarters of the
record. If the motion scatters at random (chaos or a free cage), each error is also at least the standard error.
"""

from math import exp, hypot, isnan, nan
from typing import NamedTuple

import numpy as np

from bearingsim.catalogue import MODELS
from bearingsim.config import Case
from bearingsim.config.names import LINES, QUIET_LINE
from bearingsim.core.geometry.motion import is_steady
from bearingsim.simulation.accuracy import StandardErrors
from bearingsim.simulation.comparison import PEAK_FORCE_COLUMN, fault_lines
from bearingsim.simulation.recording import RawRecord, Windows, recorded_samples, windows
from bearingsim.simulation.run_setup import Setup
from bearingsim.simulation.settling import slowest_decay
from bearingsim.simulation.spectral_lines import angles_of_record, sensor_samples
from bearingsim.simulation.trial import defect_turn

PARTS = 4  # parts of a record whose successive changes are used to extrapolate the decay
PERIOD_MULTIPLE = 12  # ball passes, a multiple of all observed periods
DECAY_RATIO = 16.0  # ratio of the decay rate at rest to the slowest one while contacts open


class StartErrors(NamedTuple):
    """Relative errors of the defects' lines, of the velocity RMS and of the largest outer force."""

    line: float
    rms: float
    force: float


class Passes(NamedTuple):
    """Contributions of each of n ball passes to a record.

    lines: (L, n) complex amplitudes (m/s) of the defects' lines; powers: (n,) mean squares of the velocity
    (m^2/s^2); forces: (n,) largest outer forces (N).
    """

    lines: np.ndarray
    powers: np.ndarray
    forces: np.ndarray

    def mean(self, weights: np.ndarray) -> "Passes":
        """Return the weighted means, and the largest force over passes of nonzero weight."""
        return Passes(
            self.lines @ weights / weights.sum(),
            self.powers @ weights / weights.sum(),
            self.forces[weights > 0].max(),
        )


def start_errors(setup: Setup, raw: RawRecord, standard_errors: StandardErrors) -> StartErrors:
    """Return the errors of a run.

    NaN if the speed is not constant, or the record is shorter than a period or, if it is not periodic, than
    ``PARTS`` ball passes. standard_errors: those of line and RMS if the motion scatters at random, else NaN.
    """
    case, grid = setup.case, setup.grid
    if MODELS[case.model].memoryless:
        return StartErrors(0.0, 0.0, 0.0)
    record_windows = windows(case, grid, raw, recorded_samples(case, raw)[1])
    min_passes = raw.repetition.period or PARTS
    if min(len(record_windows.index), record_windows.distinct) < min_passes or not is_steady(setup.model):
        return StartErrors(nan, nan, nan)
    passes = _passes(setup, raw, record_windows)
    if raw.repetition.period > 0:
        last = np.zeros(record_windows.distinct)
        last[-raw.repetition.period :] = 1.0
        record = passes.mean(record_windows.weights)
        return _changes(record, passes.mean(last), record)
    return _decay_errors(case, passes, grid.rate, standard_errors)


def _passes(setup: Setup, raw: RawRecord, record_windows: Windows) -> Passes:
    case, grid, M, n = setup.case, setup.grid, record_windows.M, record_windows.distinct
    velocity = sensor_samples(case, raw, "velocity", record_windows.start, n * M)
    samples, _ = recorded_samples(case, raw)
    recorded = sensor_samples(case, samples, "velocity", record_windows.start, n * M)
    angles = angles_of_record(case, setup.model, grid, raw, record_windows.start, n * M)
    lines = np.stack(
        [
            2.0 * (velocity * np.exp(-1j * angles.phase(LINES[name], raw.Z))).reshape(n, M).mean(axis=1)
            for name in fault_lines(case)
        ]
    )
    sources = raw.repetition.source(round(record_windows.start / M) + np.arange(n))
    return Passes(lines, np.mean(recorded.reshape(n, M) ** 2, axis=1), raw.peaks[sources, PEAK_FORCE_COLUMN])


def _changes(mean: Passes, other: Passes, record: Passes) -> StartErrors:
    """Return the differences between two means over passes, relative to the mean over the record."""
    rms = float(record.powers) ** 0.5 or 1.0
    sizes = np.maximum(np.abs(record.lines), QUIET_LINE * rms)
    return StartErrors(
        float(np.max(np.abs(mean.lines - other.lines) / sizes)),
        float(abs(mean.powers**0.5 - other.powers**0.5)) / rms,
        float(abs(mean.forces - other.forces) / (record.forces or 1.0)),
    )


def _decay_errors(case: Case, passes: Passes, rate: float, standard_errors: StandardErrors) -> StartErrors:
    """Return errors from the decay between the parts of a record, at least the scatter between the parts.

    Let r be the part of the transient left after half a record. The error of the record's mean is (1 + r)/(2 (1 -
    r)) times the change from its first half to its second, that of the largest force 1/(1 - r) times the change. r
    is estimated from successive parts, with an upper limit from the slowest mode at rest, decaying ``DECAY_RATIO``
    times more slowly.
    """
    turn = max(1.0, defect_turn(case) * rate or PERIOD_MULTIPLE)  # in passes
    length = len(passes.powers) // PARTS
    length = int(int(length // turn) * turn) or length
    parts = np.repeat(np.eye(PARTS), length, axis=1)
    parts = np.pad(parts, ((0, 0), (0, len(passes.powers) - parts.shape[1])))
    record, means = passes.mean(np.ones(len(passes.powers))), [passes.mean(part) for part in parts]
    earlier, later = (_changes(means[n], means[n + 2], record) for n in range(2))
    half_changes = _changes(passes.mean(parts[0] + parts[1]), passes.mean(parts[2] + parts[3]), record)
    max_ratio = exp(-slowest_decay(case) / DECAY_RATIO * 2.0 * length / rate)
    before, after, change = (np.array(changes) for changes in (earlier, later, half_changes))
    with np.errstate(divide="ignore", invalid="ignore"):
        r = np.fmin((after / before) ** 2, max_ratio)
        remaining = change * [0.5, 0.5, 1.0] * (1.0 + r * [1.0, 1.0, 0.0]) / (1.0 - r)
    scatter = _scatter(means, record)
    largest = nan if isnan(standard_errors.rms) else error_of_largest(passes.forces, case.bearing.rollers, length)
    return StartErrors(*np.fmax.reduce([remaining, scatter, (*standard_errors, largest)]).tolist())


def error_of_largest(forces: np.ndarray, rollers: int, quarter: int) -> float:
    """Estimate the relative standard error of the largest force of a record that scatters at random.

    forces: (n,) largest outer force (N) of each ball pass; rollers: passes per revolution of the cage; quarter:
    passes in a quarter of the record, at most n / PARTS.

    If the tail of the distribution is exponential, the maximum of a sample has the same standard deviation as the
    maxima of its parts (Gumbel); if it is bounded, a smaller one. The parts are the rollers, because each keeps
    its position in its pocket for tens of revolutions. Their maxima above the median give the scatter; quarters
    of the record add the changes common to all rollers.
    """
    roller_maxima = np.array([forces[n::rollers].max() for n in range(min(rollers, len(forces)))])
    quarter_maxima = forces[: PARTS * quarter].reshape(PARTS, quarter).max(axis=1)
    excess = np.maximum(roller_maxima - np.median(roller_maxima), 0.0)
    scatter = hypot(np.sqrt(2.0 * np.mean(excess**2)), np.std(quarter_maxima, ddof=1))
    return float(scatter / (forces.max() or 1.0))


def _scatter(means: list[Passes], record: Passes) -> StartErrors:
    """Return the standard errors of the mean over the parts of a record, from the scatter between the parts.

    For the largest force, it is the standard error of the mean of the parts' largest forces.
    """
    changes = np.array([_changes(mean, other, record) for mean in means for other in means])
    return StartErrors(*np.sqrt(np.mean(changes**2, axis=0) * PARTS / (PARTS - 1) / 2.0 / PARTS).tolist())
