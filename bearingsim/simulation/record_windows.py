"""Ball passes of a record as windows: the distinct ones, and how often each occurs."""

from dataclasses import dataclass
from math import ceil, floor

import numpy as np

from bearingsim.config import Case
from bearingsim.simulation.raw_record import RawRecord
from bearingsim.simulation.time_grid import Grid


@dataclass(frozen=True)
class Windows:
    """Windows of ``M`` fine samples, side by side from fine sample ``start`` on, the record's first.

    index: (K,) number of the distinct window that each of the record's equals: after the first ``distinct`` it is
    the one ``period`` before.
    """

    start: int
    M: int
    index: np.ndarray
    period: int

    @property
    def distinct(self) -> int:
        """Number of windows that differ: the first ones."""
        return int(self.index.max(initial=-1)) + 1

    @property
    def weights(self) -> np.ndarray:
        """Occurrences (distinct,) of each window."""
        return np.bincount(self.index, minlength=self.distinct)


def first_sample(case: Case, cut: Grid) -> int:
    """Return the number of the record's first fine sample, counted from t = 0."""
    return ceil(case.settle_s * cut.fine_rate - 1e-6)


def whole_passes(case: Case, cut: Grid) -> int:
    """Return the number of ball passes that lie wholly in the record."""
    return floor(case.duration * cut.rate + 1e-6)


def windows(case: Case, cut: Grid, raw: RawRecord, reach: int) -> Windows:
    """Return the whole ball passes of the record.

    reach: fine samples beyond both ends of a window on which its filtered values depend.
    """
    K, M, start = whole_passes(case, cut), cut.fine_per_pass, first_sample(case, cut)
    if raw.end is not None:  # which the record may end before
        K = min(K, (raw.end - reach - start) // M)
    k = np.arange(K)
    if raw.repeats_from is None:
        return Windows(start, M, k, 0)
    onset, period = max(0, ceil((raw.repeats_from + reach - start) / M)), raw.repetition.period
    return Windows(start, M, np.where(k < onset, k, onset + (k - onset) % period), period)
