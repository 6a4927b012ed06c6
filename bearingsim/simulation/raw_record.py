"""Fine samples of the computed ball passes, and of those that repeat them."""

from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil

import numpy as np

from bearingsim import cpu_time
from bearingsim.core import layout as lay
from bearingsim.core.sampling import low_pass
from bearingsim.simulation.repetition import Repetition, turned


@dataclass(frozen=True)
class RawRecord:
    """Fine samples of a run.

    places: (C,) of the buffer, recorded; fine: (C, n) fine samples of them over the computed passes, number 0
    (t = 0) in column ``zero``, the first pass from column ``lead`` on, ``M`` to each pass; Z: rollers; picked:
    (C, m) raw values at the record's instants, empty if none is asked for; peaks: (passes, E) largest values of
    ``EXTREMES`` in each computed pass; y: the buffer at the end.
    """

    places: np.ndarray
    fine: np.ndarray
    lead: int
    zero: int
    M: int
    Z: int
    repetition: Repetition
    picked: np.ndarray
    peaks: np.ndarray
    y: np.ndarray
    integrator_cpu_s: float

    @property
    def repeats_from(self) -> int | None:
        """Fine sample from which on the motion is periodic; None if it is not."""
        if self.repetition.period == 0:
            return None
        return (self.repetition.computed - self.repetition.period) * self.M + self.lead - self.zero

    @property
    def end(self) -> int | None:
        """Number of available fine samples from t = 0 on; None (any) of a periodic motion."""
        return None if self.repetition.period else self.lead - self.zero + self.repetition.computed * self.M

    def read(self, start: int, count: int, rows: np.ndarray | None = None) -> np.ndarray:
        """Return fine samples (R, count) from number ``start`` on, of all rows or ``rows`` (R,)."""
        rows = np.arange(len(self.places)) if rows is None else np.asarray(rows)
        column, computed = self.zero + start, self.lead + self.repetition.computed * self.M
        if column < 0 or (column + count > computed and self.repetition.period == 0):
            raise IndexError(f"fine samples {start} to {start + count} were not computed")
        if column + count <= computed:
            return self.fine[rows, column : column + count]
        stored = self.fine[rows, column:computed]
        return np.concatenate([stored, self._repeated(max(column, computed), column + count, rows)], axis=1)

    def _repeated(self, start: int, end: int, rows: np.ndarray) -> np.ndarray:
        """Return columns from ``start`` to ``end``, after the computed ones, from the passes that they repeat."""
        first_pass, last_pass = ((column - self.lead) // self.M for column in (start, end - 1))
        passes = np.arange(first_pass, last_pass + 1)
        sources = self.repetition.source(passes)
        starts, shifts = self.lead + sources * self.M, (passes - sources) % self.Z
        parts = [
            self.fine[self._partners[m][rows], column : column + self.M]
            for m, column in zip(shifts, starts, strict=True)
        ]
        skipped = start - self.lead - first_pass * self.M
        return np.concatenate(parts, axis=1)[:, skipped : skipped + end - start]

    @cached_property
    def _partners(self) -> np.ndarray:
        """Row (Z, C) that held, m passes before, what row c holds now."""
        if np.all(lay.lane_of(self.places) < 0):  # nothing of a roller
            return np.broadcast_to(np.arange(len(self.places)), (self.Z, len(self.places)))
        return np.array([turned(self.places, self.Z, m) for m in range(self.Z)])

    def through(self, taps: np.ndarray) -> "RawRecord | LowPassed":
        """Return the record filtered by the low-pass ``taps`` (odd number), read in the same way.

        Of a periodic motion the computed passes are filtered at once, with those that follow within the filter's
        reach; any other is filtered as it is read.
        """
        if self.repetition.period == 0:
            return LowPassed(self, taps)
        reach, computed = len(taps) // 2, self.repetition.computed + ceil(len(taps) / self.M)
        fine = LowPassed(self, taps).read(reach - self.zero, self.lead + computed * self.M - reach)
        repetition = self.repetition._replace(computed=computed)
        return replace(self, fine=fine, lead=self.lead - reach, zero=self.zero - reach, repetition=repetition)


PRODUCTS = 1 << 28
"""Products of a tap and a value between two looks at the clock: some 0.1 s."""


@dataclass(frozen=True)
class LowPassed:
    """Raw record, filtered by the low-pass ``taps`` as it is read."""

    raw: RawRecord
    taps: np.ndarray

    def read(self, start: int, count: int, rows: np.ndarray | None = None) -> np.ndarray:
        """Read fine samples as ``RawRecord.read`` does."""
        reach = len(self.taps) // 2
        wide = np.ascontiguousarray(self.raw.read(start - reach, count + 2 * reach, rows))
        out = np.empty((len(wide), count))
        block = max(1, PRODUCTS // (len(self.taps) * max(1, len(wide))))
        for begin in range(0, count, block):
            cpu_time.check()
            low_pass(wide, self.taps, out, begin, min(begin + block, count))
        return out
