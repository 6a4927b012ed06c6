"""Errors of a record because its run has not wholly settled: of line, RMS and largest force.

The record of a periodic motion is compared with its steady passes. Of any other the second half is compared with
the first, and the decay between them is extrapolated. If the motion scatters by chance (a chaotic motion, a free
cage), no error is below the standard error.
"""

from math import exp, hypot, isnan, nan
from typing import NamedTuple

import numpy as np

from bearingsim.catalogue import MODELS
from bearingsim.config import Case
from bearingsim.config.names import LINES
from bearingsim.core.geometry.motion import steady
from bearingsim.core.sampling import sampling_kernel
from bearingsim.simulation.accuracy import QUIET_LINE, StandardErrors
from bearingsim.simulation.comparison import FORCE, fault_lines
from bearingsim.simulation.recording import RawRecord, Windows, windows
from bearingsim.simulation.run_setup import Setup
from bearingsim.simulation.settling import slowest_decay
from bearingsim.simulation.spectral_lines import angles_of_record, sensed
from bearingsim.simulation.trial import defect_turn

PARTS = 4  # of a record: the ratio of their successive changes extrapolates the decay
ALIKE = 12  # ball passes: a multiple of all periods observed
SLOWER = 16.0  # times slower than at rest: slowest decay of a driven motion whose contacts open


class StartErrors(NamedTuple):
    """Relative errors of the fault's line, of the velocity's RMS, and of the largest outer force."""

    line: float
    rms: float
    force: float


class Passes(NamedTuple):
    """Contributions of each of n ball passes to a record.

    lines: (L, n) complex amplitudes (m/s) of the fault's lines; powers: (n,) mean squares of the velocity
    (m^2/s^2); forces: (n,) largest outer forces (N).
    """

    lines: np.ndarray
    powers: np.ndarray
    forces: np.ndarray

    def mean(self, weights: np.ndarray) -> "Passes":
        """Return the weighted means, and the largest force of passes that weigh anything."""
        return Passes(
            self.lines @ weights / weights.sum(),
            self.powers @ weights / weights.sum(),
            self.forces[weights > 0].max(),
        )


def start_errors(setup: Setup, raw: RawRecord, standard: StandardErrors) -> StartErrors:
    """Return the errors of a run; NaN of too short a record, and where no motion is steady.

    standard: standard errors of its line and RMS where these are chance, else NaN.
    """
    case, cut = setup.case, setup.cut
    if MODELS[case.model].memoryless:
        return StartErrors(0.0, 0.0, 0.0)
    of_record = windows(case, cut, raw, reach=len(sampling_kernel(cut.fine_rate / case.sampling)) // 2)
    if len(of_record.index) < PARTS or not steady(setup.model):
        return StartErrors(nan, nan, nan)
    passes = _passes(setup, raw, of_record)
    if raw.repetition.period > 0:
        last = np.zeros(of_record.distinct)
        last[-raw.repetition.period :] = 1.0
        return _changes(passes.mean(of_record.weights), passes.mean(last), passes)
    return _decay_errors(case, passes, cut.rate, standard)


def _passes(setup: Setup, raw: RawRecord, of_record: Windows) -> Passes:
    case, cut, M, n = setup.case, setup.cut, of_record.M, of_record.distinct
    velocity = sensed(case, raw, "velocity", of_record.start, n * M)
    taps = sampling_kernel(cut.fine_rate / case.sampling)
    low = sensed(case, raw.through(taps), "velocity", of_record.start, n * M)
    angles = angles_of_record(case, setup.model, cut, raw, of_record.start, n * M)
    lines = np.stack(
        [
            2.0 * (velocity * np.exp(-1j * angles.along(LINES[name], raw.Z))).reshape(n, M).mean(axis=1)
            for name in fault_lines(case)
        ]
    )
    sources = raw.repetition.source(round(of_record.start / M) + np.arange(n))
    return Passes(lines, np.mean(low.reshape(n, M) ** 2, axis=1), raw.peaks[sources, FORCE])


def _changes(mean: Passes, other: Passes, passes: Passes) -> StartErrors:
    """Return the differences between the means of some passes and of others."""
    power = float(passes.powers.mean()) or 1.0
    sizes = np.maximum(np.abs(passes.lines.mean(axis=1)), QUIET_LINE * power**0.5)
    return StartErrors(
        float(np.max(np.abs(mean.lines - other.lines) / sizes)),
        0.5 * float(abs(mean.powers - other.powers)) / power,
        float(abs(mean.forces - other.forces) / (passes.forces.max() or 1.0)),
    )


def _decay_errors(case: Case, passes: Passes, rate: float, standard: StandardErrors) -> StartErrors:
    """Return errors from what decays from part to part of a record.

    The mean of the record is off by (1 + r)/(2 (1 - r)) of the change from its first half to its second, the
    largest force by 1/(1 - r), with r what remains of a decay after a half: as seen from part to part, at most
    that of the slowest mode at rest if it decays ``SLOWER`` times as slowly.
    """
    turn = max(1.0, defect_turn(case) * rate or ALIKE)  # in passes
    length = len(passes.powers) // PARTS
    length = int(int(length // turn) * turn) or length
    parts = np.repeat(np.eye(PARTS), length, axis=1)
    parts = np.pad(parts, ((0, 0), (0, len(passes.powers) - parts.shape[1])))
    earlier, later = (_changes(passes.mean(parts[n]), passes.mean(parts[n + 2]), passes) for n in range(2))
    halves = _changes(passes.mean(parts[0] + parts[1]), passes.mean(parts[2] + parts[3]), passes)
    slow = exp(-slowest_decay(case) / SLOWER * 2.0 * length / rate)
    before, after, change = (np.array(changes) for changes in (earlier, later, halves))
    with np.errstate(divide="ignore", invalid="ignore"):
        r = np.fmin((after / before) ** 2, slow)
        remaining = change * [0.5, 0.5, 1.0] * (1.0 + r * [1.0, 1.0, 0.0]) / (1.0 - r)
    scatter = _scatter([passes.mean(part) for part in parts], passes)
    largest = nan if isnan(standard.rms) else error_of_largest(passes.forces, case.bearing.rollers, length)
    return StartErrors(*np.fmax.reduce([remaining, scatter, (*standard, largest)]).tolist())


def error_of_largest(forces: np.ndarray, rollers: int, quarter: int) -> float:
    """Estimate the relative standard error of the largest force of a record that scatters by chance.

    forces: (n,) largest outer force (N) of each ball pass; rollers: passes in a turn of the cage; quarter: passes
    in a quarter of the record, at most n / PARTS.

    The maximum of a sample with an exponential tail has the standard deviation of its parts' maxima (Gumbel);
    that of a bounded tail has a smaller one. The parts are rollers: each keeps its place in its pocket for tens of
    turns. Their maxima above the median estimate the tail. Quarters of the record add what changes for all.
    """
    of_rollers = np.array([forces[n::rollers].max() for n in range(min(rollers, len(forces)))])
    of_quarters = forces[: PARTS * quarter].reshape(PARTS, quarter).max(axis=1)
    above = np.maximum(of_rollers - np.median(of_rollers), 0.0)
    scatter = hypot(np.sqrt(2.0 * np.mean(above**2)), np.std(of_quarters, ddof=1))
    return float(scatter / (forces.max() or 1.0))


def _scatter(means: list[Passes], passes: Passes) -> StartErrors:
    """Return standard errors of a record from the means of its parts."""
    changes = np.array([_changes(mean, other, passes) for mean in means for other in means])
    return StartErrors(*np.sqrt(np.mean(changes**2, axis=0) * PARTS / (PARTS - 1) / 2.0 / PARTS).tolist())
