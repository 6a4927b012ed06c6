"""Verdict on a signal of a bearing: the damaged element, another periodicity, or none."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bearingsim.config.sections.machine import RollingParts
from bearingsim.diagnosis.combs import (
    HARMONICS,
    RELATED_BINS,
    RELATED_TOLERANCE,
    SHAFT_TOLERANCE,
    Comb,
    comb_at,
    envelope_spectra,
    find_best_comb,
    heights_at,
    refine,
)
from bearingsim.diagnosis.detection import NONE, RHYTHM, Detection, detect
from bearingsim.diagnosis.envelopes import EnvelopeSpectrum
from bearingsim.diagnosis.kinematics import ELEMENTS, Lines
from bearingsim.diagnosis.size import Size, estimate_outer_race_size
from bearingsim.diagnosis.thresholds import (
    CLEAR_DB,
    clear_score,
    equivalent_revolutions,
    revolutions_range,
    threshold,
)

OUTER, INNER, ROLLER = ELEMENTS
EITHER = "outer or roller"
CAGE_RANGE, CAGE_STEPS = (0.98, 1.01), 25
"""Range of the cage frequency over the kinematic one, and number of frequencies tried in it."""
MAX_OUTER_RATIO, MIN_ROLLER_RATIO = 0.55, 0.75
"""Score of the cage sidebands over that of the comb, in the first envelope spectrum: largest of an outer race,
smallest of a roller. It is up to 0.38 for simulated outer races, 0.76 or more for rollers at signal-to-noise
ratios from 0 dB on (benchmarks/diagnosis), and 0.16 to 0.65 for three measured outer races."""
SHARED_BINS = 2.0
"""Distance in bins up to which two combs have the same fundamental."""
MIN_HALF_RATIO = 0.8
"""Score of the comb at half the line of a race over that of the line, from which the stated speed may be twice the
true one. It is 0.45 to 0.55 for three measured outer races at their speed, and 0.89 to 1.10 at twice their
speed."""


class Finding(NamedTuple):
    """Line of an element: expected frequency (Hz), comb at its refined frequency, sidebands of shaft and cage.

    Sidebands are log(1 + height) in the first spectrum at their spacing, and at that distance below and above the
    fundamental.
    """

    expected: float
    comb: Comb
    shaft_sidebands: tuple[float, ...]
    cage_sidebands: tuple[float, ...]

    @property
    def deviation(self) -> float:
        """Relative deviation of the refined frequency from the expected one."""
        return self.comb.frequency / self.expected - 1.0


class Diagnosis(NamedTuple):
    """Verdict and its evidence: findings by element, detection of the line of the best element, both spectra.

    verdict: one of ``ELEMENTS``, ``EITHER``, ``RHYTHM`` or ``NONE``; size: of a defect of the outer race, or the
    reason why it is not estimated, None for other verdicts; revolutions: those of the shaft in the record.
    """

    verdict: str
    lines: Lines
    findings: dict[str, Finding]
    detection: Detection
    size: Size | str | None
    revolutions: float
    spectra: tuple[EnvelopeSpectrum, EnvelopeSpectrum]

    @property
    def clearance_may_cause(self) -> bool:
        """True if the line may be due to clearance alone."""
        return self.verdict in (OUTER, EITHER) and not isinstance(self.size, Size)

    @property
    def threshold(self) -> float:
        """Score exceeded by 1 % of healthy signals."""
        return self.detection.threshold

    @property
    def strongest_other(self) -> Comb:
        """Strongest other periodicity, as in ``Detection``."""
        return self.detection.strongest_other

    @property
    def crowded(self) -> float:
        """Share of other periodicities with a score as high as that of the best element."""
        return self.detection.crowded

    @property
    def has_other_rhythm(self) -> bool:
        """True if the verdict is another periodicity, or if it is none and one is clearly over the threshold.

        In 8 of 200 records of noise the strongest periodicity exceeds the threshold, by at most 1.2 dB.
        """
        is_full = self.detection.is_over and self.detection.is_crowded
        is_clear = (
            self.verdict == NONE and self.strongest_other.score >= clear_score(self.threshold) and not is_full
        )
        return self.verdict == RHYTHM or is_clear

    @property
    def is_sideband(self) -> bool:
        """True if the verdict is a periodicity at a shaft sideband, first or second, of the inner-race line.

        The inner race may nevertheless be damaged: a sideband scores higher than the line in 1.5 to 3 % of the
        damaged signals at 0 to 10 dB of benchmarks/diagnosis/operating_table.py, diagnosed as the right bearing.
        """
        race_line = self.findings[INNER].comb.frequency
        distance = abs(self.strongest_other.frequency - race_line)
        width = max(RELATED_TOLERANCE * self.strongest_other.frequency, RELATED_BINS * self.spectra[0].step)
        is_at_sideband = any(abs(distance - number * self.lines.shaft) <= width for number in (1, 2))
        return self.verdict == RHYTHM and self.best == INNER and is_at_sideband

    @property
    def is_extrapolated(self) -> bool:
        """True if the record is shorter or longer than those for which thresholds were determined."""
        low, high = revolutions_range()
        return not low <= self.equivalent_revolutions <= high

    @property
    def equivalent_revolutions(self) -> float:
        """Number of revolutions for which the threshold is taken, more than ``revolutions`` for many rollers."""
        return equivalent_revolutions(self.lines, self.revolutions)

    @property
    def is_of_shaft(self) -> bool:
        """True if the verdict is a shaft order, one of whose harmonics is the line of the best element."""
        return self.verdict == RHYTHM and self.detection.is_of_shaft

    @property
    def shaft_may_cause(self) -> bool:
        """True if the verdict is the inner race, and a knock once per revolution may explain its line."""
        return self.verdict == INNER and self.detection.of_shaft is not None

    @property
    def other_race(self) -> str | None:
        """Element, other than the verdict, whose line is the strongest other periodicity; None if there is none.

        Its comb is clear without the harmonics that both share: for example, the third harmonic of a fundamental
        at 4/3 of a line is the fourth harmonic of that line.
        """
        other = self.strongest_other
        if self.verdict not in ELEMENTS:
            return None
        numbers, line = np.arange(1, HARMONICS + 1), self.findings[self.verdict].comb.frequency
        distances = np.abs(numbers * other.frequency - np.round(numbers * other.frequency / line) * line)
        widths = np.maximum(RELATED_TOLERANCE * numbers * other.frequency, RELATED_BINS * self.spectra[0].step)
        unshared = np.log1p(other.heights) * (distances > widths)
        if unshared.sum(axis=1).min() < clear_score(self.threshold):
            return None
        for race, finding in self.findings.items():
            if race != self.verdict and abs(finding.comb.frequency - other.frequency) <= widths[0]:
                return race
        return None

    @property
    def best(self) -> str:
        """Element with the highest score."""
        return max(self.findings, key=lambda race: self.findings[race].comb.score)

    @property
    def half_comb(self) -> Comb:
        """Comb at half the line of the best element."""
        return comb_at(self.spectra, self.findings[self.best].comb.frequency / 2.0)

    @property
    def may_be_doubled(self) -> bool:
        """True if the verdict is the outer or inner race, and the comb at half its line is about as strong.

        False if half the line is a shaft order, and for a rolling element, which may strike only one race, at BSF.
        """
        order = self.half_comb.frequency / self.lines.shaft
        is_order = abs(order - round(order)) <= SHAFT_TOLERANCE * round(order)
        is_strong = self.half_comb.score >= MIN_HALF_RATIO * self.findings[self.best].comb.score
        return self.verdict in (OUTER, INNER) and is_strong and not is_order


def diagnose(
    series: np.ndarray,
    fs: float,
    parts: RollingParts,
    shaft: float,
    tolerance: float = 0.02,
    band: tuple[float, float] | None = None,
) -> Diagnosis:
    """Diagnose a bearing from a series (n,) sampled at ``fs`` (Hz), with a shaft that rotates at ``shaft`` (Hz).

    tolerance: relative, of the lines; band: of the first envelope (Hz). The verdict is an element if its comb
    exceeds the threshold and is within the tolerance, no other periodicity of the record scores higher or explains
    the line, and the record is not full of lines. Raises ValueError as ``band_spectrum``.
    """
    lines = Lines.of(parts, shaft)
    spectra = envelope_spectra(series, fs, lines, band)
    findings = {race: _finding(spectra, lines, race, tolerance) for race in ELEMENTS}
    revolutions = shaft * len(series) / fs
    limit = threshold(equivalent_revolutions(lines, revolutions), tolerance)
    best = max(findings, key=lambda race: findings[race].comb.score)
    comb = findings[best].comb
    detection = detect(spectra, lines, best, comb, tolerance, limit)
    verdict = detection.objection or _choose_element(spectra, findings, best)
    size = _estimate_size(series, fs, parts, comb, limit) if verdict == OUTER else None
    return Diagnosis(verdict, lines, findings, detection, size, revolutions, spectra)


def _estimate_size(series: np.ndarray, fs: float, parts: RollingParts, comb: Comb, limit: float) -> Size | str:
    """Estimate the size of a defect of the outer race if its comb is clear; otherwise return the reason."""
    if comb.score < clear_score(limit):
        return f"the line is not {CLEAR_DB:g} dB over the threshold"
    return estimate_outer_race_size(series, fs, parts, comb.frequency)


def _finding(spectra: Sequence[EnvelopeSpectrum], lines: Lines, race: str, tolerance: float) -> Finding:
    comb = refine(spectra, find_best_comb(spectra, lines.of_race(race), tolerance))
    shaft = _sidebands(spectra[0], comb.frequency, np.array([lines.shaft]))
    cages = np.linspace(*CAGE_RANGE, CAGE_STEPS) * lines.cage
    return Finding(lines.of_race(race), comb, shaft, _sidebands(spectra[0], comb.frequency, cages))


def _sidebands(spectrum: EnvelopeSpectrum, frequency: float, spacings: np.ndarray) -> tuple[float, ...]:
    """Return log(1 + height) at a spacing, and at this distance below and above a frequency (Hz).

    The spacing is that of ``spacings`` (n,) in Hz with the largest sum.
    """
    heights = np.log1p(heights_at(spectrum, np.array([spacings, frequency - spacings, frequency + spacings])))
    return tuple(map(float, heights[:, np.argmax(heights.sum(axis=0))]))


def _choose_element(spectra: Sequence[EnvelopeSpectrum], findings: dict[str, Finding], best: str) -> str:
    """Return the element with the best comb; if outer race and roller share it, choose by the cage sidebands.

    Returns ``EITHER`` if these are neither weak nor strong enough.
    """
    outer, roller = findings[OUTER], findings[ROLLER]
    is_shared = abs(outer.comb.frequency - roller.comb.frequency) <= SHARED_BINS * spectra[0].step
    if best == INNER or not is_shared:
        return best
    ratio = sum(findings[best].cage_sidebands) / findings[best].comb.scores[0]
    return OUTER if ratio <= MAX_OUTER_RATIO else ROLLER if ratio >= MIN_ROLLER_RATIO else EITHER
