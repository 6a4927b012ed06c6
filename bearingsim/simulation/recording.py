"""Recording of a run: fine samples (periodic passes are repeated when they are read), raw values and peaks."""

from collections import deque
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil, floor

import numpy as np

from bearingsim import assemble, cpu_time
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.advance import NoSamples, Samples
from bearingsim.core.sampling import (
    DECIMATION_HALF_LENGTH,
    INTERPOLATION_HALF_LENGTH,
    RESAMPLE_HALF_LENGTH,
    decimate,
    decimation_kernel,
    interpolate,
    interpolate_linearly,
    interpolation_kernel,
    low_pass,
    sampling_kernel,
)
from bearingsim.simulation import channels
from bearingsim.simulation.differentiation import STENCIL_HALF_LENGTH, derives_velocity
from bearingsim.simulation.repetition import EXTREMES, LONGEST_PERIOD, Repetition, may_repeat, rotated_rows
from bearingsim.simulation.time_grid import Grid, sample_count


@dataclass(frozen=True)
class RawRecord:
    """Fine samples of a run.

    cells: (C,) recorded cells of the buffer; fine: (C, n) their fine samples over the computed passes, with t = 0
    in column ``zero``, the first pass from column ``lead`` on, and ``M`` samples per pass; Z: number of rollers;
    raw_values: (C, m) raw values at the sampling instants, empty if not requested; peaks: (passes, E) largest
    values of ``EXTREMES`` in each computed pass; taps: (odd,) coefficients of the low-pass to the band of
    ``sampling``; y: the buffer at the end.
    """

    cells: np.ndarray
    fine: np.ndarray
    lead: int
    zero: int
    M: int
    Z: int
    repetition: Repetition
    raw_values: np.ndarray
    peaks: np.ndarray
    taps: np.ndarray
    y: np.ndarray

    @property
    def half_length(self) -> int:
        """Number of fine samples on each side on which a low-passed sample depends."""
        return len(self.taps) // 2

    @property
    def periodic_from(self) -> int | None:
        """Number of the fine sample from which the motion is periodic; None if it is not."""
        if self.repetition.period == 0:
            return None
        return (self.repetition.computed - self.repetition.period) * self.M + self.lead - self.zero

    @property
    def end(self) -> int | None:
        """Number of available fine samples from t = 0 on; None (unlimited) for a periodic motion."""
        return None if self.repetition.period else self.lead - self.zero + self.repetition.computed * self.M

    def read(self, start: int, count: int, rows: np.ndarray | None = None) -> np.ndarray:
        """Return fine samples (R, count) from number ``start`` on, of all rows or ``rows`` (R,).

        Raises IndexError for samples that are neither computed nor repeated.
        """
        rows = np.arange(len(self.cells)) if rows is None else np.asarray(rows)
        column, computed = self.zero + start, self.lead + self.repetition.computed * self.M
        if column < 0 or (column + count > computed and self.repetition.period == 0):
            raise IndexError(f"fine samples {start} to {start + count} were not computed")
        if column + count <= computed:
            return self.fine[rows, column : column + count]
        stored = self.fine[rows, column:computed]
        return np.concatenate([stored, self._repeated(max(column, computed), column + count, rows)], axis=1)

    def _repeated(self, start: int, end: int, rows: np.ndarray) -> np.ndarray:
        """Return columns ``start`` to ``end``, beyond the computed ones, from the passes that they repeat.

        After ``Z`` periods every roller is in its initial position, so the columns repeat as well.
        """
        first_pass, last_pass = ((column - self.lead) // self.M for column in (start, end - 1))
        count = last_pass + 1 - first_pass
        passes = first_pass + np.arange(min(count, self.Z * self.repetition.period))
        sources = self.repetition.source(passes)
        starts, shifts = self.lead + sources * self.M, (passes - sources) % self.Z
        parts = [
            self.fine[self._rotated_rows[m][rows], column : column + self.M]
            for m, column in zip(shifts, starts, strict=True)
        ]
        offset = start - self.lead - first_pass * self.M
        repeated = np.tile(np.concatenate(parts, axis=1), ceil(count / len(passes)))
        return repeated[:, offset : offset + end - start]

    @cached_property
    def _rotated_rows(self) -> np.ndarray:
        """Row numbers (Z, C): [m, c] is that of the roller that was in the position of row c m passes before."""
        if np.all(lay.lane_of(self.cells) < 0):  # no quantity of a roller is recorded
            return np.broadcast_to(np.arange(len(self.cells)), (self.Z, len(self.cells)))
        return np.array([rotated_rows(self.cells, self.Z, m) for m in range(self.Z)])

    @property
    def low_passed(self) -> "RawRecord | LowPassed":
        """Record low-passed to the band of ``sampling``, with the same ``read``.

        A periodic motion is filtered once; otherwise samples are filtered as they are read.
        """
        return self._filtered_passes if self.repetition.period else LowPassed(self)

    @cached_property
    def _filtered_passes(self) -> "RawRecord":
        """Computed passes of a periodic motion, and those within half the filter's length after, low-passed."""
        half_length, computed = self.half_length, self.repetition.computed + ceil(len(self.taps) / self.M)
        fine = LowPassed(self).read(half_length - self.zero, self.lead + computed * self.M - half_length)
        repetition = self.repetition._replace(computed=computed)
        return replace(
            self, fine=fine, lead=self.lead - half_length, zero=self.zero - half_length, repetition=repetition
        )


MULTIPLICATIONS = 1 << 28
"""Multiplications of the filter between two checks of the CPU time, about 0.1 s."""


@dataclass(frozen=True)
class LowPassed:
    """Raw record that is low-passed to the band of ``sampling`` when it is read."""

    raw: RawRecord

    def read(self, start: int, count: int, rows: np.ndarray | None = None) -> np.ndarray:
        """Return filtered fine samples, as ``RawRecord.read``."""
        taps, half_length = self.raw.taps, self.raw.half_length
        extended = np.ascontiguousarray(self.raw.read(start - half_length, count + 2 * half_length, rows))
        out = np.empty((len(extended), count))
        block = max(1, MULTIPLICATIONS // (len(taps) * max(1, len(extended))))
        for begin in range(0, count, block):
            cpu_time.check()
            low_pass(extended, taps, out, begin, min(begin + block, count))
        return out


@dataclass(frozen=True)
class Segments:
    """Ball passes of a record as adjacent segments of ``M`` fine samples, from the first fine sample ``start`` on.

    index: (K,) number of the distinct segment to which each segment of the record is equal; period: number of
    segments after which a periodic motion repeats, 0 if it is not periodic.
    """

    start: int
    M: int
    index: np.ndarray
    period: int

    @property
    def distinct(self) -> int:
        """Number of distinct segments, which are the first ones."""
        return int(self.index.max(initial=-1)) + 1

    @property
    def weights(self) -> np.ndarray:
        """Numbers of occurrences (distinct,) of the distinct segments."""
        return np.bincount(self.index, minlength=self.distinct)


def first_sample(case: Case, grid: Grid) -> int:
    """Return the number of the record's first fine sample, counted from t = 0."""
    return ceil(case.settle_s * grid.fine_rate - 1e-6)


def whole_passes(case: Case, grid: Grid) -> int:
    """Return the number of complete ball passes in the record."""
    return floor(case.duration * grid.rate + 1e-6)


def recorded_samples(case: Case, raw: RawRecord) -> tuple["RawRecord | LowPassed", int]:
    """Return the fine samples, low-passed with `antialias`, and the half length of the filter (fine samples)."""
    return (raw.low_passed, raw.half_length) if case.antialias else (raw, 0)


def pass_segments(case: Case, grid: Grid, raw: RawRecord, margin: int) -> Segments:
    """Return the complete ball passes of the record as segments.

    margin: number of fine samples beyond both ends of a segment on which its values depend.
    """
    count, M, start = whole_passes(case, grid), grid.fine_per_pass, first_sample(case, grid)
    if raw.end is not None:  # the computed samples may end before the record
        count = min(count, (raw.end - margin - start) // M)
    numbers = np.arange(count)
    if raw.periodic_from is None:
        return Segments(start, M, numbers, 0)
    onset, period = max(0, ceil((raw.periodic_from + margin - start) / M)), raw.repetition.period
    return Segments(start, M, np.where(numbers < onset, numbers, onset + (numbers - onset) % period), period)


class Recording:
    """Fine samples, raw values and peaks of a run, recorded by ball passes."""

    def __init__(self, case: Case, grid: Grid, Z: int, y: np.ndarray) -> None:
        """Allocate the arrays. y: the buffer at t = 0, whose values are also used for all earlier times."""
        self.case, self.grid, self.Z = case, grid, Z
        self.cells = channels.recorded_cells(self.case)
        self.lead = (
            ceil(RESAMPLE_HALF_LENGTH * self.grid.fine_rate / self.case.sampling) + INTERPOLATION_HALF_LENGTH + 1
        )
        self.taps = decimation_kernel(self.grid.decimation)
        self.fine = np.empty((len(self.cells), self.lead + self.grid.passes * self.grid.fine_per_pass))
        self.fine[:, : self.lead] = y[self.cells][:, np.newaxis]
        self.stores_raw_values = channels.stores_raw_values(self.case)
        self.raw_values = np.empty((len(self.cells), sample_count(self.case) if self.stores_raw_values else 0))
        self.raw_values[:, :1] = y[self.cells][:, np.newaxis]  # t = 0, if the record begins there
        self.peaks = np.empty((self.grid.passes, len(EXTREMES)))
        self.samples = make_samples(self.case, self.raw_values)
        stores_passes = self.stores_raw_values and may_repeat(self.case)  # to sample raw values of repeated passes
        self.last_passes: deque[np.ndarray] = deque(maxlen=LONGEST_PERIOD if stores_passes else 0)

    def add_pass(self, p: int, pass_values: np.ndarray, y: np.ndarray) -> None:
        """Record pass ``p``; pass_values: its values at all steps (``integration._ball_passes``)."""
        M, D = self.grid.fine_per_pass, self.grid.decimation
        start = self.lead + p * M
        decimate(pass_values, self.taps, D, self.fine[:, start : start + M])
        if self.stores_raw_values and type(self.samples) is NoSamples:
            _sample_pass(self.case, self.grid, p, pass_values, self.raw_values)
            if self.last_passes.maxlen:
                self.last_passes.append(pass_values.copy())
        self.peaks[p] = pop_peaks(y)

    def fill_repeated_passes(self, repetition: Repetition) -> None:
        """Fill in the raw values of the passes that were not computed."""
        for p in range(repetition.computed, self.grid.passes):
            cpu_time.check()
            source = int(repetition.source(p))
            raw_values = _sample_pass(
                self.case, self.grid, p, self.last_passes[source - repetition.computed], self.raw_values
            )
            raw_values[:] = raw_values[rotated_rows(self.cells, self.Z, p - source)]

    def raw_record(self, repetition: Repetition, y: np.ndarray) -> RawRecord:
        """Return the record of the computed passes."""
        M, passes = self.grid.fine_per_pass, repetition.computed
        return RawRecord(
            cells=self.cells,
            fine=self.fine[:, : self.lead + passes * M],
            lead=self.lead,
            zero=self.lead + DECIMATION_HALF_LENGTH - 1,
            M=M,
            Z=self.Z,
            repetition=repetition,
            raw_values=self.raw_values,
            peaks=self.peaks[:passes],
            taps=sampling_kernel(self.grid.fine_rate / self.case.sampling),
            y=y,
        )


def make_samples(case: Case, raw_values: np.ndarray) -> NoSamples | Samples:
    """Make the samples that an adaptive method writes into ``raw_values`` at the sampling instants.

    ``NoSamples`` for methods of fixed step, whose steps are short enough for interpolation between them.
    """
    if not channels.stores_raw_values(case) or not assemble.is_adaptive(case):
        return NoSamples()
    return Samples(case.settle_s, case.sampling, raw_values)


def pop_peaks(y: np.ndarray) -> list[float]:
    """Return the largest value of each of ``EXTREMES`` over all rollers since the last call; reset it."""
    # rows that the model does not have are empty
    rows = [y[row : row + lay.MAX_ROLLERS] for row in EXTREMES.values()]
    peaks = [float(row.max(initial=0.0)) for row in rows]
    for row in rows:
        row[:] = 0.0
    y[lay.LARGEST_AT_ENDS : lay.LARGEST_AT_ENDS + 3] = 0.0
    return peaks


def extend_back(case: Case, raw: RawRecord) -> None:
    """Fill in the samples before t = 0 with those whole cage revolutions later.

    If the motion is not periodic, only the ring's motion and the other ``feature_cells`` rows are extended, by
    their first pass. Filters use these samples, but features do not.
    """
    fine, zero, revolution = raw.fine, raw.zero, raw.Z * raw.M
    if raw.repetition.period > 0:
        fine[:, :zero] = raw.read(-zero % revolution, zero)
    else:
        rows = len(channels.feature_cells(case))
        fine[:rows, :zero] = fine[:rows, zero + np.arange(-zero, 0) % raw.M]


def _sample_pass(case: Case, grid: Grid, p: int, pass_values: np.ndarray, raw_values: np.ndarray) -> np.ndarray:
    """Fill in the raw values at the sampling instants within ball pass ``p``; return them (C, k).

    The end of the pass is included, its start only in pass 0. If velocities are differences of positions, they are
    accurate up to ``STENCIL_HALF_LENGTH`` steps before the end, so the instants after that are read with the next
    pass.
    """
    steps, tail = grid.steps_per_pass, pass_values.shape[1] - grid.steps_per_pass
    missing = STENCIL_HALF_LENGTH if derives_velocity(case) else 0
    ratio = 1.0 / (case.sampling * grid.step)  # steps per sample
    start = case.settle_s / grid.step
    begin, end = (max(0, floor((q * steps - missing - start) / ratio) + 1) for q in (p, p + 1))
    begin = 0 if p == 0 else min(begin, raw_values.shape[1])
    end = min(end, raw_values.shape[1])
    if end > begin:
        interpolate_linearly(pass_values, start - p * steps + tail - 1, ratio, raw_values, begin, end)
    return raw_values[:, begin : max(begin, end)]


BLOCK = 1 << 15  # fine samples resampled at a time


def sample_rows(case: Case, grid: Grid, raw: RawRecord, rows: np.ndarray) -> np.ndarray:
    """Sample ``rows`` (R,) of the raw record at the n sampling instants; return the samples (R, n).

    With `antialias` all rows except contact forces are low-passed.
    """
    if not case.antialias:
        return raw.raw_values[rows]
    forces = channels.contact_force_mask(case, raw.cells[rows])
    values = np.empty((len(rows), sample_count(case)))
    if forces.any():
        values[forces] = raw.raw_values[rows[forces]]
    values[~forces] = _low_passed(case, grid, raw, rows[~forces])
    return values


def _low_passed(case: Case, grid: Grid, raw: RawRecord, rows: np.ndarray) -> np.ndarray:
    """Return the low-passed samples (R, n) of ``rows``, computed block by block."""
    out = np.empty((len(rows), sample_count(case)))
    if len(rows) == 0:
        return out
    ratio, kernel = grid.fine_rate / case.sampling, interpolation_kernel()
    filtered, weights = raw.low_passed, np.empty(2 * INTERPOLATION_HALF_LENGTH)
    block = max(1, int(BLOCK / ratio))
    start = case.settle_s * grid.fine_rate
    for n in range(0, out.shape[1], block):
        cpu_time.check()
        end = min(n + block, out.shape[1])
        begin = floor(start + n * ratio) - INTERPOLATION_HALF_LENGTH
        count = ceil((end - n) * ratio) + 2 * INTERPOLATION_HALF_LENGTH + 1
        interpolate(filtered.read(begin, count, rows), start - begin, ratio, kernel, weights, out, n, end)
    return out
