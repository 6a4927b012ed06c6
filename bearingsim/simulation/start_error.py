"""Errors of amplitudes, RMS and largest force of a record due to incomplete settling.

For a periodic motion the record is compared with its steady passes. Otherwise its second half is compared with the
first, and the decay between them is extrapolated; each error is at least the scatter between quarters of the
record. If the motion scatters at random (chaos or a free cage), each error is also at least the standard error. If
a defect rotates, the errors of amplitudes and RMS are also at least those due to its incomplete last revolution.
"""

from collections.abc import Sequence
from math import ceil, exp, floor, hypot, isfinite, isnan, nan, pi
from typing import NamedTuple

import numpy as np

from bearingsim import signals
from bearingsim.catalogue import MODELS
from bearingsim.config import Case
from bearingsim.config.names import LINES, QUIET_LINE
from bearingsim.core.geometry.motion import is_steady
from bearingsim.simulation.accuracy import TWO_SIGMA, StandardErrors, error_from_passes
from bearingsim.simulation.comparison import PEAK_FORCE_COLUMN
from bearingsim.simulation.pilot import elements_with_deviations
from bearingsim.simulation.recording import RawRecord, Segments, pass_segments, recorded_samples
from bearingsim.simulation.run_setup import Setup
from bearingsim.simulation.settling import MAX_TRANSIENT, remaining_transient, slowest_decay
from bearingsim.simulation.spectral_lines import angles_of_record, has_other_lines, sensor_samples
from bearingsim.simulation.trial import defect_revolution_time

PARTS = 4  # quarters of a record, from whose changes the decay is extrapolated
PERIOD_MULTIPLE = 12  # ball passes, a multiple of all observed periods
RESOLVED_REVOLUTIONS = 2.0
"""Revolutions of a defect or unbalance below which a record shows no scatter, and a Hann window does not separate
lines one rotation frequency apart."""
DECAY_RATIO = 16.0  # ratio of the decay rate at rest to the slowest one while contacts open


class StartErrors(NamedTuple):
    """Relative errors of a record.

    line: largest of those of the defects' amplitudes; rms: of the velocity RMS; force: of the largest outer force.
    """

    line: float
    rms: float
    force: float


class Means(NamedTuple):
    """Means over a part of a record.

    amplitudes: (L,) complex amplitudes (m/s) of the defects' lines; mean_square: of the velocity (m^2/s^2);
    force: largest outer force (N).
    """

    amplitudes: np.ndarray
    mean_square: float
    force: float


class RecordedMotion(NamedTuple):
    """Motion over the n distinct ball passes of a record, each of M fine samples.

    velocity: (n M,) unfiltered velocity along the sensor (m/s); recorded: (n M,) the same as recorded, that is
    low-passed with `antialias`; phases: (L, n M) phase angles (rad) of the defects' lines; forces: (n,) largest
    outer force (N) of each pass; has_neighbours: whether there are other lines that a mean over ball passes does
    not remove, so that amplitudes are computed under a Hann window.
    """

    velocity: np.ndarray
    recorded: np.ndarray
    phases: np.ndarray
    forces: np.ndarray
    has_neighbours: bool

    def weighted(self, weights: np.ndarray) -> Means:
        """Return the means over the passes with ``weights`` (n,); only for a motion without neighbouring lines."""
        powers = np.mean(self.recorded.reshape(len(self.forces), -1) ** 2, axis=1)
        share = weights / weights.sum()
        return Means(
            self.amplitudes_by_pass() @ share, float(powers @ share), float(self.forces[weights > 0].max())
        )

    def amplitudes_by_pass(self) -> np.ndarray:
        """Return the complex amplitudes (L, n) of the lines over each pass, in m/s."""
        n = len(self.forces)
        contributions = [
            2.0 * (self.velocity * np.exp(-1j * phase)).reshape(n, -1).mean(axis=1) for phase in self.phases
        ]
        return np.array(contributions).reshape(len(contributions), n)

    def part(self, begin: float, end: float) -> Means:
        """Return the means from ``begin`` to ``end``, in ball passes."""
        M = len(self.velocity) // len(self.forces)
        span = slice(round(begin * M), round(end * M))
        velocity, phases = self.velocity[span], self.phases[:, span]
        if self.has_neighbours:
            amplitudes = signals.amplitudes_at(velocity, phases)
        else:
            amplitudes = np.array(
                [2.0 * np.mean(velocity * np.exp(-1j * phase)) for phase in phases], dtype=complex
            )
        forces = self.forces[int(begin) : ceil(end)]
        return Means(amplitudes, float(np.mean(self.recorded[span] ** 2)), float(forces.max()))


def estimate_start_errors(
    setup: Setup, raw: RawRecord, standard_errors: StandardErrors, lines: Sequence[str]
) -> StartErrors:
    """Estimate the errors of a record.

    NaN if the speed is not constant, or if the record is shorter than a period or, if it is not periodic, than
    ``PARTS`` ball passes; zero in these cases for a model without memory. NaN also if a record at constant speed
    is not periodic and shorter than ``RESOLVED_REVOLUTIONS``; that of the line also if there are no
    lines. standard_errors: those of BPFO and RMS if the motion scatters at random (infinite for too few ball
    passes), else NaN; lines: the defects' lines that the record resolves.
    """
    case, grid = setup.case, setup.grid
    segments = pass_segments(case, grid, raw, recorded_samples(case, raw)[1])
    passes = min(len(segments.index), segments.distinct)
    min_duration = 0.0 if raw.repetition.period > 0 else RESOLVED_REVOLUTIONS * _revolution_time(case)
    if is_steady(setup.model) and passes < floor(min_duration * grid.rate):
        return StartErrors(nan, nan, nan)  # revolutions may differ even in a model without memory
    if passes < (raw.repetition.period or PARTS) or not is_steady(setup.model):
        return StartErrors(*[0.0 if MODELS[case.model].memoryless else nan] * 3)
    motion = _read_motion(setup, raw, segments, lines)
    if raw.repetition.period > 0:
        last = np.zeros(segments.distinct)
        last[-raw.repetition.period :] = 1.0
        record = motion.weighted(segments.weights)
        return _relative_changes(record, motion.weighted(last), record)
    return _decay_errors(case, motion, grid.rate, standard_errors)


def _read_motion(setup: Setup, raw: RawRecord, segments: Segments, lines: Sequence[str]) -> RecordedMotion:
    """Read the motion over the distinct ball passes of a record; lines: names of the defects' lines."""
    case, grid, M, n = setup.case, setup.grid, segments.M, segments.distinct
    start = segments.start
    samples, _ = recorded_samples(case, raw)
    angles = angles_of_record(case, setup.model, grid, raw, start, n * M)
    sources = raw.repetition.source(round(start / M) + np.arange(n))
    return RecordedMotion(
        sensor_samples(case, raw, "velocity", start, n * M),
        sensor_samples(case, samples, "velocity", start, n * M),
        np.array([angles.phase(LINES[name], raw.Z) for name in lines]).reshape(len(lines), n * M),
        raw.peaks[sources, PEAK_FORCE_COLUMN],
        has_other_lines(case),
    )


def _relative_changes(mean: Means, other: Means, record: Means) -> StartErrors:
    """Return the differences between two means, relative to the mean over the record."""
    rms = record.mean_square**0.5 or 1.0
    scales = np.maximum(np.abs(record.amplitudes), QUIET_LINE * rms)
    return StartErrors(
        float(np.max(np.abs(mean.amplitudes - other.amplitudes) / scales)) if len(scales) else nan,
        abs(mean.mean_square**0.5 - other.mean_square**0.5) / rms,
        abs(mean.force - other.force) / (record.force or 1.0),
    )


def _decay_errors(case: Case, motion: RecordedMotion, rate: float, standard_errors: StandardErrors) -> StartErrors:
    """Estimate errors from the decay between the parts of a record, at least the scatter between the parts.

    Let r be the fraction of the transient left after half a record. The error of the record's mean is (1 + r)/(2
    (1 - r)) times the change from its first half to its second, that of the largest force 1/(1 - r) times the
    change. r is estimated from successive quarters, with an upper limit from the slowest mode at rest if it decays
    ``DECAY_RATIO`` times more slowly. Changes that do not decrease are scatter, which this limit would multiply up
    to a hundred times; r is then that of the slowest mode at rest, or 0 if it has decayed before the record.
    Quarters shorter than ``RESOLVED_REVOLUTIONS`` do not separate a line from its sidebands, so they show neither
    decay nor scatter; then halves show the scatter. An error is NaN if they are too short as well.
    """
    passes_per_revolution, count = _revolution_time(case) * rate, len(motion.forces)
    revolution = max(1.0, passes_per_revolution or PERIOD_MULTIPLE)  # in ball passes
    record, quarter, half = (
        motion.part(0.0, count),
        *(_whole_revolutions(count // n, revolution) for n in (PARTS, 2)),
    )
    means = [motion.part(n * quarter, (n + 1) * quarter) for n in range(PARTS)]
    halves = [motion.part(n * half, (n + 1) * half) for n in range(2)]
    earlier, later = (_relative_changes(means[n], means[n + 2], record) for n in range(2))
    is_resolved = not motion.has_neighbours or quarter >= RESOLVED_REVOLUTIONS * revolution
    r = _remaining_ratios(case, half / rate, earlier, later if is_resolved else later._replace(line=nan))
    change = np.array(_relative_changes(halves[0], halves[1], record))
    with np.errstate(divide="ignore", invalid="ignore"):
        remaining = change * [0.5, 0.5, 1.0] * (1.0 + r * [1.0, 1.0, 0.0]) / (1.0 - r)
    scatter = _scatter_errors(means, record)._replace(
        line=_scatter_errors(means if is_resolved else halves, record).line
    )
    partial_revolution = _partial_revolution_errors(motion, passes_per_revolution)
    random = _random_errors(motion, standard_errors, _equal_rollers(case), int(quarter))
    largest = np.fmax.reduce(np.array([remaining, scatter, random, partial_revolution]))
    return StartErrors(*np.where(np.isnan(scatter), nan, largest).tolist())


def _revolution_time(case: Case) -> float:
    """Return the time (s) of a revolution of the slowest defect or form, or of an unbalance; 0 if none rotates."""
    shaft = 0.0 if case.unbalance is None else 2.0 * pi / case.speed
    return max(shaft, defect_revolution_time(case))


def _remaining_ratios(case: Case, half: float, earlier: StartErrors, later: StartErrors) -> np.ndarray:
    """Return the fractions (3,) of the transients of line, RMS and force that are left after half a record.

    half: duration of half the record (s); earlier, later: changes from the first quarter to the third, and from
    the second to the fourth, NaN if they do not show a decay.
    """
    decay, before, after = slowest_decay(case), np.array(earlier), np.array(later)
    has_decayed = remaining_transient(case) <= MAX_TRANSIENT * (1.0 + 1e-9)  # tolerates rounding
    at_rest = 0.0 if has_decayed else exp(-decay * half)
    with np.errstate(divide="ignore", invalid="ignore"):
        observed = np.fmin((after / before) ** 2, exp(-decay / DECAY_RATIO * half))
    return np.where(after < before, observed, at_rest)


def _random_errors(
    motion: RecordedMotion, standard_errors: StandardErrors, rollers: int, quarter: int
) -> StartErrors:
    """Return the standard errors of a record that scatters at random, else NaN.

    rollers: as in ``largest_force_error``; quarter: ball passes in a quarter of the record. The given standard
    error of a line is that of BPFO. If the record also has other lines, that of each defect's line is estimated
    from ball passes. Those of line and RMS are NaN for too few ball passes.
    """
    if isnan(standard_errors.rms):
        return StartErrors(nan, nan, nan)
    line = standard_errors.line
    if motion.has_neighbours:
        min_amplitude = QUIET_LINE * float(np.sqrt(np.mean(motion.recorded**2)))
        errors = [error_from_passes(passes, min_amplitude) for passes in motion.amplitudes_by_pass()]
        line = max(errors, default=nan)
    line, rms = (error if isfinite(error) else nan for error in (line, standard_errors.rms))
    return StartErrors(line, rms, largest_force_error(motion.forces, rollers, quarter))


def _whole_revolutions(passes: int, revolution: float) -> float:
    """Return the ball passes of all whole revolutions in ``passes``, or ``passes`` if there is none.

    revolution: ball passes in a revolution.
    """
    return passes // revolution * revolution or float(passes)


def _partial_revolution_errors(motion: RecordedMotion, revolution: float) -> StartErrors:
    """Return the changes of amplitudes and RMS by the last, incomplete revolution of a defect or unbalance.

    revolution: in ball passes, 0 if nothing rotates. The vibration due to a defect is stronger in the load zone,
    so the RMS of a record of few revolutions depends on where the record ends, and so does the leakage of
    neighbouring lines into an amplitude.
    """
    count = len(motion.forces)
    record = motion.part(0.0, count)
    end = _whole_revolutions(count, revolution) if revolution > 0.0 else count
    return _relative_changes(record, motion.part(0.0, end), record)._replace(force=0.0)


def _equal_rollers(case: Case) -> int:
    """Return the number of rollers whose largest forces differ only by chance; 1 if rollers deviate in shape."""
    return 1 if "roller" in elements_with_deviations(case) else case.bearing.rollers


def largest_force_error(forces: np.ndarray, rollers: int, quarter: int) -> float:
    """Estimate the relative standard error of the largest force of a record that scatters at random.

    forces: (n,) largest outer force (N) of each ball pass; rollers: number of equal rollers, which is that of the
    passes per revolution of the cage, 1 if they are not equal; quarter: passes in a quarter of the record, at most
    n / PARTS.

    If the tail of the distribution is exponential, the maximum of a sample has the same standard deviation as the
    maxima of its parts (Gumbel); if it is bounded, a smaller one. The parts are the passes of each roller, because
    a roller keeps its position in its pocket for tens of revolutions. Their maxima above the median give the
    scatter; quarters of the record add the changes common to all rollers. If one roller has a defect, the largest
    force is its own, and only the quarters show its scatter.
    """
    roller_maxima = np.array([forces[n::rollers].max() for n in range(min(rollers, len(forces)))])
    quarter_maxima = forces[: PARTS * quarter].reshape(PARTS, quarter).max(axis=1)
    excess = np.maximum(roller_maxima - np.median(roller_maxima), 0.0)
    scatter = hypot(np.sqrt(2.0 * np.mean(excess**2)), np.std(quarter_maxima, ddof=1))
    return float(scatter / (forces.max() or 1.0))


def _scatter_errors(means: list[Means], record: Means) -> StartErrors:
    """Return the standard errors of the mean over the parts of a record, from the scatter between the parts.

    For the largest force, it is the standard error of the mean of the parts' largest forces. The errors are scaled
    by Student's t so that two standard errors have the confidence of two sigma; a line, which is complex, has
    twice the degrees of freedom.
    """
    from scipy.special import stdtrit

    changes = np.array([_relative_changes(mean, other, record) for mean in means for other in means])
    degrees_of_freedom = len(means) - 1
    t_factors = stdtrit(degrees_of_freedom * np.array([2.0, 1.0, 1.0]), TWO_SIGMA) / 2.0
    return StartErrors(*(t_factors * np.sqrt(np.mean(changes**2, axis=0) / degrees_of_freedom / 2.0)).tolist())
