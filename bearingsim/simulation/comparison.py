"""Comparison of two runs of the same case: lines of the defects, RMS, largest force, and recorded channels.

A periodic motion is compared over one period (recorded channels partly over more, see ``period_signals``), a
non-periodic motion over the ball passes of a pilot run.
"""

from math import ceil, floor
from typing import NamedTuple

import numpy as np

from bearingsim import signals
from bearingsim.config import Case
from bearingsim.config.names import FAULT_LINES, LINES, QUIET_LINE
from bearingsim.core import layout as lay
from bearingsim.simulation import channels, recording, spectral_lines
from bearingsim.simulation.channels import MOTION
from bearingsim.simulation.recording import RawRecord
from bearingsim.simulation.repetition import EXTREMES
from bearingsim.simulation.rounding import Rounding, notable
from bearingsim.simulation.run_setup import Setup

WIDE_BAND_SHARE = 0.5
"""Least change of the recorded RMS, as a share of the change of the wide-band RMS, since it may be small by chance
(chosen, not measured)."""
MIN_SAMPLES = 16
"""Smallest number of recorded values to compare a periodic motion, or to derive the least amplitude of a line."""
PEAK_FORCE_COLUMN = list(EXTREMES).index("outer_force.max")
"""Column of the largest outer contact force (N) in ``RawRecord.peaks``."""


class Changes(NamedTuple):
    """Relative changes from one run to another.

    line: largest change of the complex amplitude of a defect's line; rms: change of the RMS of the recorded
    velocity, at least ``WIDE_BAND_SHARE`` of the change of the wide-band RMS; force: change of the largest outer
    force; record: largest change of the RMS of any recorded channel.
    """

    line: float
    rms: float
    force: float
    record: float


class RunSignals(NamedTuple):
    """Signals of a run over the ball passes that are compared.

    fine_velocity: (n,) velocity (m/s) along the sensor at fine samples; recorded_velocity: (m,) the same velocity
    as recorded, low-passed or raw; low_passed: (C, m) low-passed rows (motion along the sensor, requested
    channels) in SI, empty without anti-aliasing; raw_values: (P, k) unfiltered rows at the sampling instants in
    SI: contact forces, or all rows without anti-aliasing; contributions: (L, p) contribution of each of p ball
    passes (of the whole period if p = 1) to the complex amplitude of each defect's line (m/s); force: largest
    outer contact force (N); rounding: bounds of the motion due to rounding; row_rounding: the same of the rows of
    low_passed and of raw_values, (C,) and (P,).
    """

    fine_velocity: np.ndarray
    recorded_velocity: np.ndarray
    low_passed: np.ndarray
    raw_values: np.ndarray
    contributions: np.ndarray
    force: float
    rounding: Rounding
    row_rounding: tuple[np.ndarray, np.ndarray]


def compare(run: RunSignals, reference: RunSignals) -> Changes:
    """Return the changes of a run relative to the values of a reference run, beyond those due to rounding.

    The change of a line is relative to at least ``QUIET_LINE`` of the standard deviation of the recorded velocity,
    or of the velocity at fine samples if few are recorded.
    """
    has_samples = len(reference.recorded_velocity) >= MIN_SAMPLES
    velocity = reference.recorded_velocity if has_samples else reference.fine_velocity
    min_amplitude = QUIET_LINE * float(np.std(velocity)) or 1.0
    bound = run.rounding.plus(reference.rounding).velocity
    line_bound = notable(bound, float(np.std(velocity)))
    low_passed_bounds, raw_bounds = map(np.add, run.row_rounding, reference.row_rounding)
    return Changes(
        line=float(
            max(
                max(line_difference(a, b) - line_bound, 0.0) / max(abs(b.sum()), min_amplitude)
                for a, b in zip(run.contributions, reference.contributions, strict=True)
            )
        ),
        rms=max(
            WIDE_BAND_SHARE * rms_change(run.fine_velocity, reference.fine_velocity, bound),
            rms_change(run.recorded_velocity, reference.recorded_velocity, bound),
        ),
        force=abs(run.force - reference.force) / (reference.force or 1.0),
        record=max(
            (
                *map(rms_change, run.low_passed, reference.low_passed, low_passed_bounds),
                *map(raw_value_change, run.raw_values, reference.raw_values, raw_bounds),
            )
        ),
    )


def rms_change(series: np.ndarray, reference: np.ndarray, rounding: float = 0.0) -> float:
    """Return the change of the standard deviation (AC RMS) of a series (n,), beyond that due to ``rounding``.

    The change is relative to the standard deviation of the reference, or to ``QUIET_LINE`` of its peak if that is
    larger (nearly constant series). rounding: bound of the difference, in the unit of the series.
    """
    scale = max(float(np.std(reference)), QUIET_LINE * float(np.abs(reference).max()))
    change = abs(np.std(series) - np.std(reference)) - notable(rounding, scale)
    return float(max(change, 0.0) / (scale or 1.0))


def pass_changes(difference: np.ndarray, passes: int, rms: float, rounding: float) -> np.ndarray:
    """Return the RMS (passes,) of a difference of velocities in each ball pass, beyond that due to ``rounding``.

    It is relative to ``rms``, that of the velocity; rounding: bound of the difference; all in m/s.
    """
    changes = pass_rms(difference, passes) - notable(rounding, rms)
    return np.maximum(changes, 0.0) / (rms or 1.0)


def lead_time(setup: Setup, other: Setup) -> float:
    """Return the time (s) by which the rollers of one setup lead those of another.

    Initial roller angles may differ, since each setup is aligned with its grid (``assemble.align_with_cusp``).
    """
    return float((setup.model.bearing.theta_0 - other.model.bearing.theta_0) / other.model.bearing.omega_c)


def shift(series: np.ndarray, fraction: float) -> np.ndarray:
    """Advance a series by a small ``fraction`` of a sample, to first order."""
    return series + fraction * np.gradient(series)


def pass_rms(difference: np.ndarray, passes: int) -> np.ndarray:
    """Return the RMS (passes,) of a difference in each ball pass."""
    rows = difference[: (len(difference) - 1) // passes * passes].reshape(passes, -1)
    return np.sqrt(np.mean(rows**2, axis=1))


def raw_value_change(values: np.ndarray, reference: np.ndarray, rounding: float = 0.0) -> float:
    """Return the relative change of the RMS of raw values (k,), sampled at the same instants.

    The mean of the reference is subtracted from both series, so a change of the mean is included. Whether a sample
    falls on the flank of an impact is random, because the step size shifts the impact. Changes of single values
    may cancel in the sum by chance, so the change is at least their root sum of squares. It is 0 if both series
    vary by less than ``rounding``.
    """
    if max(np.std(values), np.std(reference)) < rounding:
        return 0.0
    reference_squares, squares = ((series - np.mean(reference)) ** 2 for series in (reference, values))
    min_sum = (QUIET_LINE * float(np.abs(reference).max(initial=0.0))) ** 2 * len(reference)
    change = squares - reference_squares
    return float(
        0.5 * max(abs(change.sum()), np.linalg.norm(change)) / (max(reference_squares.sum(), min_sum) or 1.0)
    )


def pass_contributions(phase: np.ndarray, passes: int, series: np.ndarray) -> np.ndarray:
    """Return the contribution (passes,) of each ball pass to the complex amplitude of a line, in the series' unit.

    series: (passes * M + 1,) fine samples, M per pass; phase: phase angles (rad) of the line at these samples.
    A Hann window covers all passes.
    """
    window = np.hanning(len(phase))
    kernel = 2.0 * window * np.exp(-1j * phase) / window.sum()
    contributions = kernel * (series - window @ series / window.sum())
    return np.add.reduceat(contributions, np.arange(0, len(phase) - 1, (len(phase) - 1) // passes)[:passes])


def line_difference(contributions: np.ndarray, reference: np.ndarray) -> float:
    """Return the absolute difference of two complex amplitudes, given as contributions (passes,) of ball passes.

    Errors that change sign from pass to pass may cancel in a few passes by chance, so the difference is at least
    their root sum of squares, which is the RMS of their sum if they are independent. It has the unit of the
    contributions.
    """
    difference = contributions - reference
    return float(max(abs(difference.sum()), np.linalg.norm(difference)))


def periodic_start(setup: Setup, raw: RawRecord) -> float:
    """Return the time (s) from the start of a periodic run after which the motion is periodic."""
    return (raw.repetition.computed - raw.repetition.period) / setup.grid.rate


def first_raw_value(case: Case, start_time: float) -> int:
    """Return the index of the record's first sampling instant at or after ``start_time`` (s into the run)."""
    return max(0, ceil((start_time - case.settle_s) * case.sampling))


def period_signals(setup: Setup, raw: RawRecord, start_time: float) -> RunSignals:
    """Return the compared signals of a periodic motion.

    Velocity, line and largest force are compared over one period, low-passed rows over one cage revolution if
    channels of single rollers are recorded, else over one period. Raw rows are compared over the whole record from
    ``start_time`` (s) on, because few sampling instants fall within one period. The only line is BPFO, since a
    motion with other defects is not periodic over ball passes.
    """
    case, grid, model = setup.case, setup.grid, setup.model
    M, period = grid.fine_per_pass, raw.repetition.period
    cage_revolutions = ceil((raw.repetition.computed + ceil(len(raw.taps) / M)) / raw.Z)
    start = cage_revolutions * raw.Z * M
    fine_velocity = spectral_lines.sensor_series(case, raw.read(start, period * M), "velocity")
    length = raw.Z * M if np.any(lay.lane_of(raw.cells) >= 0) else period * M
    filtered = raw.low_passed.read(start, length) if case.antialias else None
    contributions = signals.amplitudes_by_pass(
        fine_velocity, M, [1], start, case.bearing.rollers * model.bearing.theta_0
    )
    raw_values = raw.raw_values[:, first_raw_value(case, start_time) :]
    return _collect_signals(
        setup,
        raw,
        fine_velocity,
        filtered,
        raw_values,
        contributions.mean(axis=1, keepdims=True),
        raw.peaks[-period:],
    )


def _collect_signals(
    setup: Setup,
    raw: RawRecord,
    fine_velocity: np.ndarray,
    filtered: np.ndarray | None,
    raw_values: np.ndarray,
    contributions: np.ndarray,
    peaks: np.ndarray,
) -> RunSignals:
    """Collect the compared signals.

    fine_velocity: (n,) unfiltered velocity; filtered: (C, m) all recorded rows low-passed, None without
    anti-aliasing; raw_values: (C, k) all recorded rows at the sampling instants; peaks: (passes, ``EXTREMES``).
    """
    case, rows = setup.case, raw_values if filtered is None else filtered
    sensor_motion = {quantity: spectral_lines.sensor_series(case, rows, quantity) for quantity in MOTION}
    motion = np.stack([*sensor_motion.values()])
    channel_rows = channels.requested_rows(case, raw.cells)
    channel_rows = channel_rows[channel_rows >= len(channels.feature_cells(case))]
    raw_mask = channels.contact_force_mask(case, raw.cells[channel_rows])
    bounds = setup.rounding.of_cells(raw.cells[channel_rows])
    if filtered is None:
        filtered_rows, raw_rows = motion[:0], np.concatenate([motion, raw_values[channel_rows]])
        row_rounding = np.zeros(0), np.concatenate([setup.rounding, bounds])
    else:
        filtered_rows, raw_rows = (
            np.concatenate([motion, filtered[channel_rows[~raw_mask]]]),
            raw_values[channel_rows[raw_mask]],
        )
        row_rounding = np.concatenate([setup.rounding, bounds[~raw_mask]]), bounds[raw_mask]
    return RunSignals(
        fine_velocity,
        sensor_motion["velocity"],
        filtered_rows,
        raw_rows,
        contributions,
        float(peaks[:, PEAK_FORCE_COLUMN].max()),
        setup.rounding,
        row_rounding,
    )


def fault_lines(case: Case) -> list[str]:
    """Return the names of the lines of a case's defects.

    BPFO for a healthy bearing, which vibrates at BPFO due to varying compliance.
    """
    return list(dict.fromkeys(FAULT_LINES[defect.race] for defect in case.defects)) or ["BPFO"]


def pilot_signals(setup: Setup, raw: RawRecord, passes: int) -> RunSignals:
    """Return the compared signals of a pilot run over its ``passes`` ball passes after settling."""
    case, grid = setup.case, setup.grid
    start, length = recording.first_sample(case, grid), passes * grid.fine_per_pass + 1
    fine_velocity = spectral_lines.sensor_samples(case, raw, "velocity", start, length)
    filtered = raw.low_passed.read(start, length) if case.antialias else None
    raw_values = raw.raw_values[:, : floor(passes / grid.rate * case.sampling) + 1]
    angles = spectral_lines.angles_of_record(case, setup.model, grid, raw, start, length)
    phases = [angles.phase(LINES[name], case.bearing.rollers) for name in fault_lines(case)]
    contributions = np.stack([pass_contributions(phase, passes, fine_velocity) for phase in phases])
    settling_passes = floor(case.settle_s * grid.rate + 1e-6)
    return _collect_signals(
        setup,
        raw,
        fine_velocity,
        filtered,
        raw_values,
        contributions,
        raw.peaks[settling_passes : settling_passes + passes],
    )
