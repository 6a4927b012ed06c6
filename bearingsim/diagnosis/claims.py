"""Comparison of the line of a race with all other periodicities of a signal."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bearingsim.diagnosis.combs import Comb, comb_at, rivals, share_of_rivals
from bearingsim.diagnosis.envelopes import EnvelopeSpectrum
from bearingsim.diagnosis.kinematics import Lines

RHYTHM, NONE = "other rhythm", "none"
"""Objections to a line: another periodicity is stronger; the line is not over the threshold, or the record is full
of lines."""
MAX_CROWDED = 0.2
"""Share of other periodicities with a score as high as the claimed one, above which a record is full of lines.
Damaged signals of the operating table have at most 0.06, a healthy record full of the mains' lines 0.24."""


class Claim(NamedTuple):
    """Comb claimed as the line of a race, the threshold of its score, and the other periodicities.

    rival: strongest other periodicity, or the comb itself if its peak lies beyond the tolerance; crowded: share of
    other periodicities with a score as high as the claimed one.
    """

    comb: Comb
    threshold: float
    rival: Comb
    crowded: float

    @property
    def is_over(self) -> bool:
        """True if the score exceeds the threshold."""
        return self.comb.score > self.threshold

    @property
    def is_crowded(self) -> bool:
        """True if the record is full of lines as strong as the claimed one."""
        return self.crowded > MAX_CROWDED

    @property
    def objection(self) -> str | None:
        """``NONE`` or ``RHYTHM``; None if there is no objection."""
        if not self.is_over or self.is_crowded:
            return NONE
        return RHYTHM if self.rival is self.comb or self.rival.score > self.comb.score else None


def claim(
    spectra: Sequence[EnvelopeSpectrum], lines: Lines, race: str, comb: Comb, tolerance: float, threshold: float
) -> Claim:
    """Compare the comb of a race, with its refined frequency, with the other periodicities of the spectra."""
    others = rivals(spectra, lines, race, comb, tolerance)
    rival = comb_at(spectra, float(others.fundamentals[np.argmax(others.scores)]))
    if abs(comb.frequency / lines.of_race(race) - 1.0) > tolerance:  # the peak is beyond the searched range
        rival = max(comb, rival, key=lambda other: other.score)
    return Claim(comb, threshold, rival, share_of_rivals(others, comb.score, tolerance))
