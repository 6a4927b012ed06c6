"""Comparison of the line of a race with all other periodicities of a signal."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bearingsim.diagnosis.combs import Comb, comb_at, find_shaft_comb, score_other_periodicities, share_at_score
from bearingsim.diagnosis.envelopes import EnvelopeSpectrum
from bearingsim.diagnosis.kinematics import Lines

RHYTHM, NONE = "other rhythm", "none"
"""Objections to a line. ``RHYTHM``: another periodicity is stronger, or explains the line. ``NONE``: the line is
not over the threshold, or the record is full of lines."""
MAX_CROWDED = 0.2
"""Share of other periodicities with a score as high as the line's, above which a record is full of lines. It is at
most 0.06 for the damaged signals of benchmarks/diagnosis/operating_table.py, and 0.24 for a healthy record with
many harmonics of the mains."""


class Detection(NamedTuple):
    """Comb at the line of a race, the threshold of its score, and the other periodicities.

    strongest_other: strongest other periodicity; if none scores higher than the comb, the shaft order that
    explains the comb, or the comb itself if its peak lies beyond the tolerance; crowded: share of other
    periodicities with a score as high as that of the comb; is_of_shaft: True if strongest_other is a shaft order,
    one of whose harmonics is the line; of_shaft: shaft order that explains a line of the inner race nearly as well
    as a defect, None for other lines.
    """

    comb: Comb
    threshold: float
    strongest_other: Comb
    crowded: float
    is_of_shaft: bool = False
    of_shaft: Comb | None = None

    @property
    def is_over(self) -> bool:
        """True if the score exceeds the threshold."""
        return self.comb.score > self.threshold

    @property
    def is_crowded(self) -> bool:
        """True if the record is full of lines as strong as that of the race."""
        return self.crowded > MAX_CROWDED

    @property
    def objection(self) -> str | None:
        """``NONE`` or ``RHYTHM``; None if there is no objection."""
        if not self.is_over or self.is_crowded:
            return NONE
        is_weaker = self.strongest_other is self.comb or self.strongest_other.score > self.comb.score
        return RHYTHM if is_weaker or self.is_of_shaft else None


def detect(
    spectra: Sequence[EnvelopeSpectrum], lines: Lines, race: str, comb: Comb, tolerance: float, threshold: float
) -> Detection:
    """Compare the comb of a race, of refined frequency, with the other periodicities of the spectra.

    race: one of ``ELEMENTS``; tolerance: relative, of the line; threshold: of the score. A defect of the inner
    race itself raises shaft orders, so a shaft order is an objection to its line only if it scores higher.
    """
    others = score_other_periodicities(spectra, lines, race, comb, tolerance)
    other = comb_at(spectra, float(others.fundamentals[np.argmax(others.scores)]))
    if abs(comb.frequency / lines.of_race(race) - 1.0) > tolerance:  # the peak is beyond the searched range
        other = max(comb, other, key=lambda candidate: candidate.score)
    detection = Detection(comb, threshold, other, share_at_score(others, comb.score, tolerance))
    if detection.objection == NONE:
        return detection
    of_shaft = find_shaft_comb(spectra, lines, comb, threshold)
    if of_shaft is None or other.score > max(comb.score, of_shaft.score):  # already an objection
        return detection
    if race == "inner" and of_shaft.score <= comb.score:
        return detection._replace(of_shaft=of_shaft)
    return detection._replace(strongest_other=of_shaft, is_of_shaft=True)
