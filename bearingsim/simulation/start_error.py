"""Errors of line, RMS and largest force of a record due to incomplete settling.

For a periodic motion the record is compared with its steady passes. Otherwise its second half is compared with the
first, and the decay between them is extrapolated; each error is at least the scatter between quarters of the
record. If the motion scatters at random (chaos or a free cage), each error is also at least the standard error. If
a defect turns, the error of the RMS is also at least that of the partial revolution at the end of the record.
"""

from collections.abc import Sequence
from math import ceil, exp, floor, hypot, isfinite, isnan, nan
from typing import NamedTuple

import numpy as np

from bearingsim import signals
from bearingsim.catalogue import MODELS
from bearingsim.config import Case
from bearingsim.config.names import LINES, QUIET_LINE
from bearingsim.core.geometry.motion import is_steady
from bearingsim.simulation.accuracy import TWO_SIGMA, StandardErrors, error_from_passes
from bearingsim.simulation.comparison import PEAK_FORCE_COLUMN
from bearingsim.simulation.recording import RawRecord, Windows, recorded_samples, windows
from bearingsim.simulation.run_setup import Setup
from bearingsim.simulation.settling import MAX_TRANSIENT, remaining_transient, slowest_decay
from bearingsim.simulation.spectral_lines import angles_of_record, has_other_lines, sensor_samples
from bearingsim.simulation.trial import defect_turn

PARTS = 4  # parts of a record whose successive changes are used to extrapolate the decay
PERIOD_MULTIPLE = 12  # ball passes, a multiple of all observed periods
RESOLVED_TURNS = 2.0  # of a defect: fewer show no scatter, nor does Hann's window separate lines one turn apart
DECAY_RATIO = 16.0  # ratio of the decay rate at rest to the slowest one while contacts open


class StartErrors(NamedTuple):
    """Relative errors of the defects' lines, of the velocity RMS and of the largest outer force."""

    line: float
    rms: float
    force: float


class Means(NamedTuple):
    """Means over a part of a record.

    lines: (L,) complex amplitudes (m/s) of the defects' lines; power: mean square of the velocity (m^2/s^2);
    force: largest outer force (N).
    """

    lines: np.ndarray
    power: float
    force: float


class Motion(NamedTuple):
    """Motion over the n distinct ball passes of a record, each of M fine samples.

    velocity: (n M,) along the sensor (m/s); recorded: (n M,) the same, as recorded; phases: (L, n M) angles (rad)
    of the defects' lines; forces: (n,) largest outer force (N) of each pass; has_neighbours: whether there are
    lines that a mean over ball passes does not remove, so that lines are computed under Hann's window.
    """

    velocity: np.ndarray
    recorded: np.ndarray
    phases: np.ndarray
    forces: np.ndarray
    has_neighbours: bool

    def weighted(self, weights: np.ndarray) -> Means:
        """Return the means over the passes with ``weights`` (n,); only without neighbouring lines."""
        powers = np.mean(self.recorded.reshape(len(self.forces), -1) ** 2, axis=1)
        share = weights / weights.sum()
        return Means(self.lines_of_passes() @ share, float(powers @ share), float(self.forces[weights > 0].max()))

    def lines_of_passes(self) -> np.ndarray:
        """Return the contribution (L, n) of each pass to the complex amplitudes of the lines, in m/s."""
        n = len(self.forces)
        lines = [2.0 * (self.velocity * np.exp(-1j * phase)).reshape(n, -1).mean(axis=1) for phase in self.phases]
        return np.array(lines).reshape(len(lines), n)

    def part(self, begin: float, end: float) -> Means:
        """Return the means from ``begin`` to ``end``, in ball passes."""
        M = len(self.velocity) // len(self.forces)
        span = slice(round(begin * M), round(end * M))
        velocity, phases = self.velocity[span], self.phases[:, span]
        if self.has_neighbours:
            lines = signals.amplitudes_at(velocity, phases)
        else:
            lines = np.array([2.0 * np.mean(velocity * np.exp(-1j * phase)) for phase in phases], dtype=complex)
        forces = self.forces[int(begin) : ceil(end)]
        return Means(lines, float(np.mean(self.recorded[span] ** 2)), float(forces.max()))


def start_errors(
    setup: Setup, raw: RawRecord, standard_errors: StandardErrors, lines: Sequence[str]
) -> StartErrors:
    """Return the errors of a run.

    NaN if the speed is not constant, or the record is shorter than a period or, if it is not periodic, than
    ``PARTS`` ball passes and ``RESOLVED_TURNS`` of a defect; that of the line also if there are no lines.
    standard_errors: those of BPFO and RMS if the motion scatters at random (infinite for too few ball passes),
    else NaN; lines: the defects' lines that the record resolves.
    """
    case, grid = setup.case, setup.grid
    record_windows = windows(case, grid, raw, recorded_samples(case, raw)[1])
    passes = min(len(record_windows.index), record_windows.distinct)
    turns = 0.0 if raw.repetition.period > 0 else RESOLVED_TURNS * defect_turn(case)
    if is_steady(setup.model) and passes < floor(turns * grid.rate):
        return StartErrors(nan, nan, nan)  # revolutions may differ, in a model without memory too
    if passes < (raw.repetition.period or PARTS) or not is_steady(setup.model):
        return StartErrors(*[0.0 if MODELS[case.model].memoryless else nan] * 3)
    motion = _motion(setup, raw, record_windows, lines)
    if raw.repetition.period > 0:
        last = np.zeros(record_windows.distinct)
        last[-raw.repetition.period :] = 1.0
        record = motion.weighted(record_windows.weights)
        return _changes(record, motion.weighted(last), record)
    return _decay_errors(case, motion, grid.rate, standard_errors)


def _motion(setup: Setup, raw: RawRecord, record_windows: Windows, lines: Sequence[str]) -> Motion:
    case, grid, M, n = setup.case, setup.grid, record_windows.M, record_windows.distinct
    start = record_windows.start
    samples, _ = recorded_samples(case, raw)
    angles = angles_of_record(case, setup.model, grid, raw, start, n * M)
    sources = raw.repetition.source(round(start / M) + np.arange(n))
    return Motion(
        sensor_samples(case, raw, "velocity", start, n * M),
        sensor_samples(case, samples, "velocity", start, n * M),
        np.array([angles.phase(LINES[name], raw.Z) for name in lines]).reshape(len(lines), n * M),
        raw.peaks[sources, PEAK_FORCE_COLUMN],
        has_other_lines(case),
    )


def _changes(mean: Means, other: Means, record: Means) -> StartErrors:
    """Return the differences between two means over passes, relative to the mean over the record."""
    rms = record.power**0.5 or 1.0
    sizes = np.maximum(np.abs(record.lines), QUIET_LINE * rms)
    return StartErrors(
        float(np.max(np.abs(mean.lines - other.lines) / sizes)) if len(sizes) else nan,
        abs(mean.power**0.5 - other.power**0.5) / rms,
        abs(mean.force - other.force) / (record.force or 1.0),
    )


def _decay_errors(case: Case, motion: Motion, rate: float, standard_errors: StandardErrors) -> StartErrors:
    """Return errors from the decay between the parts of a record, at least the scatter between the parts.

    Let r be the part of the transient left after half a record. The error of the record's mean is (1 + r)/(2 (1 -
    r)) times the change from its first half to its second, that of the largest force 1/(1 - r) times the change. r
    is estimated from successive parts, with an upper limit from the slowest mode at rest, decaying ``DECAY_RATIO``
    times more slowly. Changes that do not decrease are scatter, which this limit would multiply up to a hundred
    times; r is then that of the slowest mode at rest, or 0 if it has decayed before the record. Quarters shorter
    than ``RESOLVED_TURNS`` do not separate a line from its sidebands, so they show neither decay nor scatter; then
    halves show the scatter. An error is NaN if they are too short as well.
    """
    defect_passes, count = defect_turn(case) * rate, len(motion.forces)
    turn = max(1.0, defect_passes or PERIOD_MULTIPLE)  # in passes
    record, quarter, half = motion.part(0.0, count), *(_whole_turns(count // n, turn) for n in (PARTS, 2))
    means = [motion.part(n * quarter, (n + 1) * quarter) for n in range(PARTS)]
    halves = [motion.part(n * half, (n + 1) * half) for n in range(2)]
    earlier, later = (_changes(means[n], means[n + 2], record) for n in range(2))
    is_resolved = not motion.has_neighbours or quarter >= RESOLVED_TURNS * turn
    r = _remaining_ratios(case, half / rate, earlier, later if is_resolved else later._replace(line=nan))
    change = np.array(_changes(halves[0], halves[1], record))
    with np.errstate(divide="ignore", invalid="ignore"):
        remaining = change * [0.5, 0.5, 1.0] * (1.0 + r * [1.0, 1.0, 0.0]) / (1.0 - r)
    scatter = _scatter(means, record)._replace(line=_scatter(means if is_resolved else halves, record).line)
    partial_turn = _partial_turn_errors(motion, defect_passes)
    random = _random_errors(motion, standard_errors, case.bearing.rollers, int(quarter))
    largest = np.fmax.reduce(np.array([remaining, scatter, random, partial_turn]))
    return StartErrors(*np.where(np.isnan(scatter), nan, largest).tolist())


def _remaining_ratios(case: Case, half: float, earlier: StartErrors, later: StartErrors) -> np.ndarray:
    """Return the parts (3,) of the transients of line, RMS and force that are left after half a record.

    half: in s; earlier, later: changes between successive quarters, NaN if they do not show a decay.
    """
    decay, before, after = slowest_decay(case), np.array(earlier), np.array(later)
    has_decayed = remaining_transient(case) <= MAX_TRANSIENT * (1.0 + 1e-9)  # tolerates rounding
    at_rest = 0.0 if has_decayed else exp(-decay * half)
    with np.errstate(divide="ignore", invalid="ignore"):
        observed = np.fmin((after / before) ** 2, exp(-decay / DECAY_RATIO * half))
    return np.where(after < before, observed, at_rest)


def _random_errors(motion: Motion, standard_errors: StandardErrors, rollers: int, quarter: int) -> StartErrors:
    """Return the standard errors of a record that scatters at random, else NaN; quarter: its ball passes.

    The given standard error of a line is that of BPFO. If the record also has other lines, that of each defect's
    line is estimated from ball passes. Those of line and RMS are NaN for too few ball passes.
    """
    if isnan(standard_errors.rms):
        return StartErrors(nan, nan, nan)
    line = standard_errors.line
    if motion.has_neighbours:
        min_amplitude = QUIET_LINE * float(np.sqrt(np.mean(motion.recorded**2)))
        errors = [error_from_passes(passes, min_amplitude) for passes in motion.lines_of_passes()]
        line = max(errors, default=nan)
    line, rms = (error if isfinite(error) else nan for error in (line, standard_errors.rms))
    return StartErrors(line, rms, error_of_largest(motion.forces, rollers, quarter))


def _whole_turns(passes: int, turn: float) -> float:
    """Return the ball passes of all whole turns in ``passes``, or ``passes`` if there is none."""
    return passes // turn * turn or float(passes)


def _partial_turn_errors(motion: Motion, turn: float) -> StartErrors:
    """Return the changes of line and RMS by the last, incomplete revolution of a defect in the record.

    turn: in ball passes, 0 if no defect turns. A defect is stronger in the load zone, so the RMS of a record of
    few revolutions depends on where the record ends, and so does what neighbours of a line add to it.
    """
    count = len(motion.forces)
    record = motion.part(0.0, count)
    end = _whole_turns(count, turn) if turn > 0.0 else count
    return _changes(record, motion.part(0.0, end), record)._replace(force=0.0)


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


def _scatter(means: list[Means], record: Means) -> StartErrors:
    """Return the standard errors of the mean over the parts of a record, from the scatter between the parts.

    For the largest force, it is the standard error of the mean of the parts' largest forces. The errors are scaled
    by Student's t so that two standard errors have the confidence of two sigma; a line, which is complex, has
    twice the degrees of freedom.
    """
    from scipy.special import stdtrit

    changes = np.array([_changes(mean, other, record) for mean in means for other in means])
    freedom = len(means) - 1
    t_factors = stdtrit(freedom * np.array([2.0, 1.0, 1.0]), TWO_SIGMA) / 2.0
    return StartErrors(*(t_factors * np.sqrt(np.mean(changes**2, axis=0) / freedom / 2.0)).tolist())
