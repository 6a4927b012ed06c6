"""Recording of a run as it is stepped: fine samples, raw values at the record's instants, peaks of each pass."""

from collections import deque
from math import ceil, floor

import numpy as np

from bearingsim import assemble, cpu_time
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.advance import NoSamples, Samples
from bearingsim.core.sampling import (
    DECIMATION_REACH,
    INTERPOLATION_REACH,
    RESAMPLE_REACH,
    decimate,
    decimation_kernel,
    pick,
)
from bearingsim.simulation import channels
from bearingsim.simulation.raw_record import RawRecord
from bearingsim.simulation.repetition import EXTREMES, LONGEST_PERIOD, Repetition, may_repeat, turned
from bearingsim.simulation.time_grid import Grid, samples


class Recording:
    """Fine samples, raw values and peaks of a run, ball pass by ball pass."""

    def __init__(self, case: Case, cut: Grid, Z: int, y: np.ndarray) -> None:
        """Allocate the arrays. y: the buffer at t = 0, before which everything stood still."""
        self.case, self.cut, self.Z = case, cut, Z
        self.places = channels.recorded(self.case)
        self.lead = ceil(RESAMPLE_REACH * self.cut.fine_rate / self.case.sampling) + INTERPOLATION_REACH + 1
        self.taps = decimation_kernel(self.cut.decimation)
        self.fine = np.empty((len(self.places), self.lead + self.cut.passes * self.cut.fine_per_pass))
        self.fine[:, : self.lead] = y[self.places][:, np.newaxis]
        self.picks = channels.picks(self.case)
        self.picked = np.empty((len(self.places), samples(self.case) if self.picks else 0))
        self.picked[:, :1] = y[self.places][:, np.newaxis]  # at t = 0, should the record begin there
        self.peaks = np.empty((self.cut.passes, len(EXTREMES)))
        self.samples = samples_between_steps(self.case, self.picked)
        keeps = self.picks and may_repeat(self.case)  # passes to pick from
        self.last: deque[np.ndarray] = deque(maxlen=LONGEST_PERIOD if keeps else 0)

    def keep(self, p: int, window: np.ndarray, y: np.ndarray) -> None:
        """Record pass ``p``; window: as ``_ball_passes`` gives it."""
        M, D = self.cut.fine_per_pass, self.cut.decimation
        start = self.lead + p * M
        decimate(window, self.taps, D, self.fine[:, start : start + M])
        if self.picks and type(self.samples) is NoSamples:
            _pick_pass(self.case, self.cut, p, window, self.picked)
            if self.last.maxlen:
                self.last.append(window.copy())
        self.peaks[p] = take_peaks(y)

    def pick_repeated(self, repetition: Repetition) -> None:
        """Pick raw values of the passes that were not computed."""
        for p in range(repetition.computed, self.cut.passes):
            cpu_time.check()
            source = int(repetition.source(p))
            picked = _pick_pass(self.case, self.cut, p, self.last[source - repetition.computed], self.picked)
            picked[:] = picked[turned(self.places, self.Z, p - source)]

    def raw(self, repetition: Repetition, y: np.ndarray, cpu_s: float) -> RawRecord:
        """Return the record as far as it has been computed."""
        M, passes = self.cut.fine_per_pass, repetition.computed
        return RawRecord(
            places=self.places,
            fine=self.fine[:, : self.lead + passes * M],
            lead=self.lead,
            zero=self.lead + DECIMATION_REACH - 1,
            M=M,
            Z=self.Z,
            repetition=repetition,
            picked=self.picked,
            peaks=self.peaks[:passes],
            y=y,
            integrator_cpu_s=cpu_s,
        )


def samples_between_steps(case: Case, picked: np.ndarray) -> NoSamples | Samples:
    """Return the samples that an adaptive method writes into ``picked`` at the raw record's own instants.

    Other methods have steps so short that values are interpolated between two.
    """
    if not channels.picks(case) or not assemble.adaptive(case):
        return NoSamples()
    return Samples(case.settle_s, case.sampling, picked)


def take_peaks(y: np.ndarray) -> list[float]:
    """Return the largest of each of ``EXTREMES`` over all rollers since the last call, and reset them."""
    rows = [y[row : row + lay.MAX_ROLLERS] for row in EXTREMES.values()]  # empty if the model has none
    peaks = [float(row.max(initial=0.0)) for row in rows]
    for row in rows:
        row[:] = 0.0
    return peaks


def extend_back(case: Case, raw: RawRecord) -> None:
    """Fill in the samples before t = 0 with those one revolution of the cage later.

    With pits that turn these differ, and only the ring's motion is extended, by its first pass: filters reach that
    far, no feature does.
    """
    fine, zero, turn = raw.fine, raw.zero, raw.Z * raw.M
    if raw.repetition.period > 0:
        fine[:, :zero] = raw.read(-zero % turn, zero)
    else:
        rows = len(channels.base(case))
        fine[:rows, :zero] = fine[:rows, zero + np.arange(-zero, 0) % raw.M]


def _pick_pass(case: Case, cut: Grid, p: int, window: np.ndarray, picked: np.ndarray) -> np.ndarray:
    """Fill in, and return, the raw values whose instants lie in ball pass ``p`` (start excluded, end included)."""
    steps, tail = cut.steps_per_pass, window.shape[1] - cut.steps_per_pass
    ratio = 1.0 / (case.sampling * cut.step)  # steps per sample
    start = case.settle_s / cut.step
    begin, end = (max(0, floor((q * steps - start) / ratio) + 1) for q in (p, p + 1))
    begin = 0 if p == 0 else min(begin, picked.shape[1])
    end = min(end, picked.shape[1])
    if end > begin:
        pick(window, start - p * steps + tail - 1, ratio, picked, begin, end)
    return picked[:, begin : max(begin, end)]
