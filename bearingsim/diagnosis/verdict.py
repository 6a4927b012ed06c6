"""Verdict on a signal of a bearing: whose line stands out, whether another rhythm does, or none."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bearingsim.config.sections.machine import RollingParts
from bearingsim.diagnosis.claims import NONE, RHYTHM, Claim, claim
from bearingsim.diagnosis.combs import (
    RELATIVE_BINS,
    RELATIVE_SHARE,
    SHAFT_SHARE,
    Comb,
    best_comb,
    comb_at,
    heights_at,
    highest_frequency,
    refined,
)
from bearingsim.diagnosis.fronts import Front, envelope_front, fast_length, levelled_front
from bearingsim.diagnosis.kinematics import RACES, Lines
from bearingsim.diagnosis.size import Size, outer_race_size
from bearingsim.diagnosis.thresholds import clear, measured_turns, threshold

OUTER, INNER, ROLLER = RACES
EITHER = "outer or roller"
CAGE_RANGE, CAGE_STEPS = (0.98, 1.01), 25
"""Range of the cage's frequency over the kinematic one, and steps in it."""
OUTER_MOST, ROLLER_LEAST = 0.55, 0.75
"""Score of the cage's lines over that of the comb in the first front: at most that of an outer race, at least
that of a roller. Simulated outer races have up to 0.38, rollers 0.76 and more from 0 dB on
(benchmarks/diagnosis), three measured outer races 0.16 to 0.65."""
SAME_BINS = 2.0
"""Bins within which two combs share one fundamental."""
STRONG_HALF = 0.8
"""Score of the rhythm at half of a race's line over that of the line, from which the given speed may be twice the
true one. Three measured outer races have 0.45 to 0.55 at their speed, and 0.89 to 1.10 at twice their speed."""


class Finding(NamedTuple):
    """Line of an element: expected and found frequency (Hz), comb, and scores of sidebands of shaft and cage.

    Sidebands are heights log(1 + h) at the spacing itself, below and above the fundamental, in the first front.
    """

    expected: float
    comb: Comb
    shaft_sidebands: tuple[float, ...]
    cage_sidebands: tuple[float, ...]

    @property
    def deviation(self) -> float:
        """Relative deviation of the found frequency from the expected one."""
        return self.comb.frequency / self.expected - 1.0


class Diagnosis(NamedTuple):
    """Verdict, and its evidence: fronts, findings by element, and the claim of the best one.

    verdict: a name of ``RACES``, "outer or roller", "other rhythm" or "none"; loose: whether clearance alone may
    give the line; turns: of the shaft.
    """

    verdict: str
    lines: Lines
    findings: dict[str, Finding]
    claim: Claim
    size: Size | None
    loose: bool
    turns: float
    fronts: tuple[Front, Front]

    @property
    def threshold(self) -> float:
        """Score that one of a hundred healthy signals exceeds."""
        return self.claim.threshold

    @property
    def rival(self) -> Comb:
        """Strongest other rhythm."""
        return self.claim.rival

    @property
    def crowded(self) -> float:
        """Share of other rhythms with a score as high as the best race's."""
        return self.claim.crowded

    @property
    def has_other_rhythm(self) -> bool:
        """True if a rhythm that is no line stands out: the verdict, or clearly over the threshold beside none.

        Of 200 records of noise the strongest rhythm exceeds the threshold in 8, by 1.2 dB at most.
        """
        is_full = self.claim.is_over and self.claim.is_crowded
        is_clear = self.verdict == NONE and self.rival.score >= clear(self.threshold) and not is_full
        return self.verdict == RHYTHM or is_clear

    @property
    def is_sideband(self) -> bool:
        """True if the verdict is a rhythm at one or two frequencies of the shaft from the inner race's line.

        Then the inner race may be damaged all the same: 1.5 to 3 % of the damaged signals of the operating table,
        at 0 to 10 dB and diagnosed as the right bearing, have a sideband that scores higher than the line.
        """
        claimed = self.findings[INNER].comb.frequency
        step = abs(self.rival.frequency - claimed)
        width = max(RELATIVE_SHARE * self.rival.frequency, RELATIVE_BINS * self.fronts[0].step)
        is_beside = any(abs(step - number * self.lines.shaft) <= width for number in (1, 2))
        return self.verdict == RHYTHM and self.best == INNER and is_beside

    @property
    def is_extrapolated(self) -> bool:
        """True if the threshold is of a shorter or longer record than those for which it was measured."""
        low, high = measured_turns()
        return not low <= self.turns <= high

    @property
    def best(self) -> str:
        """Element with the highest score."""
        return max(self.findings, key=lambda race: self.findings[race].comb.score)

    @property
    def half(self) -> Comb:
        """Comb at half of the line of the best element."""
        return comb_at(self.fronts, self.findings[self.best].comb.frequency / 2.0)

    @property
    def may_be_doubled(self) -> bool:
        """True if a race of a ring is named, and half of its line is about as strong a rhythm and no shaft order.

        Not for a rolling element, which may strike one of the races only, at BSF.
        """
        order = self.half.frequency / self.lines.shaft
        is_order = abs(order - round(order)) <= SHAFT_SHARE * round(order)
        is_strong = self.half.score >= STRONG_HALF * self.findings[self.best].comb.score
        return self.verdict in (OUTER, INNER) and is_strong and not is_order


def diagnose(
    series: np.ndarray,
    fs: float,
    parts: RollingParts,
    shaft: float,
    tolerance: float = 0.02,
    band: tuple[float, float] | None = None,
) -> Diagnosis:
    """Diagnose a bearing from a series (n,) sampled at ``fs`` (Hz), with the shaft at ``shaft`` (Hz).

    tolerance: relative, of the lines; band: of the first front (Hz). A race is named if its comb exceeds the
    threshold and lies within the tolerance, no other rhythm of the record scores higher, and the record is not
    full of lines. Raises ValueError as ``envelope_front``.
    """
    lines = Lines.of(parts, shaft)
    part = series[: fast_length(len(series))]
    highest = highest_frequency(lines)
    fronts = (envelope_front(part, fs, shaft, highest, band), levelled_front(part, fs, shaft, highest))
    findings = {race: _finding(fronts, lines, race, tolerance) for race in RACES}
    turns = shaft * len(series) / fs
    limit = threshold(turns, tolerance)
    best = max(findings, key=lambda race: findings[race].comb.score)
    comb = findings[best].comb
    best_claim = claim(fronts, lines, best, comb, tolerance, limit)
    verdict = best_claim.objection or _race(fronts, findings, best)
    has_size = verdict == OUTER and comb.score >= clear(limit)
    size = outer_race_size(series, fs, parts, comb.frequency) if has_size else None
    loose = verdict in (OUTER, EITHER) and size is None
    return Diagnosis(verdict, lines, findings, best_claim, size, loose, turns, fronts)


def _finding(fronts: Sequence[Front], lines: Lines, race: str, tolerance: float) -> Finding:
    comb = best_comb(fronts, lines.of_race(race), tolerance)
    comb = comb._replace(frequency=refined(fronts, comb.frequency))
    shaft = _sidebands(fronts[0], comb.frequency, np.array([lines.shaft]))
    cages = np.linspace(*CAGE_RANGE, CAGE_STEPS) * lines.cage
    return Finding(lines.of_race(race), comb, shaft, _sidebands(fronts[0], comb.frequency, cages))


def _sidebands(front: Front, frequency: float, spacings: np.ndarray) -> tuple[float, ...]:
    """Return log(1 + height) at a spacing (Hz), and below and above a frequency (Hz), for the best spacing."""
    heights = np.log1p(heights_at(front, np.array([spacings, frequency - spacings, frequency + spacings])))
    return tuple(map(float, heights[:, np.argmax(heights.sum(axis=0))]))


def _race(fronts: Sequence[Front], findings: dict[str, Finding], best: str) -> str:
    """Return the race with the best comb, or ``EITHER`` if outer race and roller share it and the lines of the
    cage do not decide."""
    outer, roller = findings[OUTER], findings[ROLLER]
    is_shared = abs(outer.comb.frequency - roller.comb.frequency) <= SAME_BINS * fronts[0].step
    if best == INNER or not is_shared:
        return best
    ratio = sum(findings[best].cage_sidebands) / findings[best].comb.scores[0]
    return OUTER if ratio <= OUTER_MOST else ROLLER if ratio >= ROLLER_LEAST else EITHER
