"""What the integrator leaves behind, before it is sampled: the computed ball passes, and what repeats them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bearingsim.core.sampling import low_pass
from bearingsim.simulation.repetition import Repetition, turned


@dataclass(frozen=True)
class RawRecord:
    """Fine samples of a run.

    places: (C,) of the buffer, recorded; fine: (C, n) fine samples of them over the computed passes, number 0
    (t = 0) in column ``zero``, the first pass from column ``lead`` on, ``M`` to each pass; Z: rollers; picked:
    (C, m) raw values at the record's instants, empty with the low-pass on; peaks: (passes, E) largest values of
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
        """The fine sample from which on a period is as any later one; None of a motion that does not repeat."""
        if self.repetition.period == 0:
            return None
        return (self.repetition.computed - self.repetition.period) * self.M + self.lead - self.zero

    @property
    def end(self) -> int | None:
        """The number of fine samples from t = 0 on that there are; None of a motion that repeats: any."""
        return None if self.repetition.period else self.lead - self.zero + self.repetition.computed * self.M

    def read(self, first: int, count: int, rows: np.ndarray | None = None) -> np.ndarray:
        """Fine samples (R, count) from number ``first`` on, of all rows or those of the indices ``rows`` (R,)."""
        rows = np.arange(len(self.places)) if rows is None else np.asarray(rows)
        start = self.zero + first
        if start + count <= self.lead + self.repetition.computed * self.M:
            return self.fine[rows, start : start + count]
        column = np.arange(start, start + count) - self.lead
        passes = column // self.M
        source = np.where(passes < 0, passes, self.repetition.source(passes))
        partners = self._partners[(passes - source) % self.Z][:, rows].T
        return self.fine[partners, self.lead + column + (source - passes) * self.M]

    @cached_property
    def _partners(self) -> np.ndarray:
        """(Z, C) which row holds, m passes before, what row c holds now."""
        return np.array([turned(self.places, self.Z, m) for m in range(self.Z)])

    def low_passed(self, first: int, count: int, taps: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """The same, through the low-pass ``taps`` of the record's sampling."""
        reach = len(taps) // 2
        out = np.empty((len(rows), count))
        low_pass(np.ascontiguousarray(self.read(first - reach, count + 2 * reach, rows)), taps, out)
        return out
