"""Verdict on a signal of a bearing: the damaged race, another periodicity, or none."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bearingsim.config.sections.machine import RollingParts
from bearingsim.diagnosis.combs import (
    HARMONICS,
    RELATIVE_BINS,
    RELATIVE_SHARE,
    SHAFT_SHARE,
    Comb,
    best_comb,
    comb_at,
    envelope_spectra,
    heights_at,
    refined,
)
from bearingsim.diagnosis.detection import NONE, RHYTHM, Detection, detect
from bearingsim.diagnosis.envelopes import EnvelopeSpectrum
from bearingsim.diagnosis.kinematics import ELEMENTS, Lines
from bearingsim.diagnosis.size import Size, outer_race_size
from bearingsim.diagnosis.thresholds import CLEAR_DB, clear, equivalent_turns, measured_turns, threshold

OUTER, INNER, ROLLER = ELEMENTS
EITHER = "outer or roller"
CAGE_RANGE, CAGE_STEPS = (0.98, 1.01), 25
"""Range of the cage's frequency over the kinematic one, and steps in it."""
OUTER_MOST, ROLLER_LEAST = 0.55, 0.75
"""Score of the cage's lines over that of the comb, in the first envelope spectrum: largest of an outer race,
smallest of a roller. Simulated outer races have up to 0.38, rollers 0.76 and more from 0 dB on
(benchmarks/diagnosis), three measured outer races 0.16 to 0.65."""
SAME_BINS = 2.0
"""Bins within which two combs share one fundamental."""
STRONG_HALF = 0.8
"""Score of the periodicity at half of a race's line over that of the line, from which the given speed may be twice
the true one. Three measured outer races have 0.45 to 0.55 at their speed, and 0.89 to 1.10 at twice their
speed."""


class Finding(NamedTuple):
    """Line of an element: expected and found frequency (Hz), comb, and scores of sidebands of shaft and cage.

    Sidebands are heights log(1 + h) at the spacing itself, below and above the fundamental, in the first
    spectrum.
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
    """Verdict, and its evidence: spectra, findings by element, and the detection of its line at the best one.

    verdict: a name of ``ELEMENTS``, "outer or roller", "other rhythm" or "none"; size: of a defect of the outer
    race, or the reason why it is not estimated, None for other verdicts; turns: of the shaft.
    """

    verdict: str
    lines: Lines
    findings: dict[str, Finding]
    detection: Detection
    size: Size | str | None
    turns: float
    spectra: tuple[EnvelopeSpectrum, EnvelopeSpectrum]

    @property
    def loose(self) -> bool:
        """True if clearance alone may give the line."""
        return self.verdict in (OUTER, EITHER) and not isinstance(self.size, Size)

    @property
    def threshold(self) -> float:
        """Score exceeded by 1 % of healthy signals."""
        return self.detection.threshold

    @property
    def strongest_other(self) -> Comb:
        """Strongest other periodicity."""
        return self.detection.strongest_other

    @property
    def crowded(self) -> float:
        """Share of other periodicities with a score as high as the best race's."""
        return self.detection.crowded

    @property
    def has_other_rhythm(self) -> bool:
        """True if a periodicity other than a line is the verdict, or is clearly over the threshold without a
        verdict.

        Of 200 records of noise the strongest periodicity exceeds the threshold in 8, by 1.2 dB at most.
        """
        is_full = self.detection.is_over and self.detection.is_crowded
        is_clear = self.verdict == NONE and self.strongest_other.score >= clear(self.threshold) and not is_full
        return self.verdict == RHYTHM or is_clear

    @property
    def is_sideband(self) -> bool:
        """True if the verdict is a periodicity at one or two frequencies of the shaft from the inner race's line.

        The inner race may then be damaged nevertheless: 1.5 to 3 % of the damaged signals of the operating table,
        at 0 to 10 dB and diagnosed as the right bearing, have a sideband that scores higher than the line.
        """
        race_line = self.findings[INNER].comb.frequency
        step = abs(self.strongest_other.frequency - race_line)
        width = max(RELATIVE_SHARE * self.strongest_other.frequency, RELATIVE_BINS * self.spectra[0].step)
        is_beside = any(abs(step - number * self.lines.shaft) <= width for number in (1, 2))
        return self.verdict == RHYTHM and self.best == INNER and is_beside

    @property
    def is_extrapolated(self) -> bool:
        """True if the threshold is of a shorter or longer record than those for which it was measured."""
        low, high = measured_turns()
        return not low <= self.equivalent_turns <= high

    @property
    def equivalent_turns(self) -> float:
        """Revolutions of the shaft for which the threshold is taken, more than ``turns`` for many rollers."""
        return equivalent_turns(self.lines, self.turns)

    @property
    def is_of_shaft(self) -> bool:
        """True if the verdict is an order of the shaft, one of whose harmonics is the line of the best element."""
        return self.verdict == RHYTHM and self.detection.is_of_shaft

    @property
    def shaft_may_cause(self) -> bool:
        """True if the inner race is named, and a knock once per revolution explains its line nearly as well."""
        return self.verdict == INNER and self.detection.of_shaft is not None

    @property
    def other_race(self) -> str | None:
        """Another element than the named one, whose line is the strongest other periodicity.

        It is clear without the harmonics that both share: of 4/3 of a line the third is the fourth of that line.
        """
        other = self.strongest_other
        if self.verdict not in ELEMENTS:
            return None
        numbers, named = np.arange(1, HARMONICS + 1), self.findings[self.verdict].comb.frequency
        distances = np.abs(numbers * other.frequency - np.round(numbers * other.frequency / named) * named)
        widths = np.maximum(RELATIVE_SHARE * numbers * other.frequency, RELATIVE_BINS * self.spectra[0].step)
        own = np.log1p(other.heights) * (distances > widths)
        if own.sum(axis=1).min() < clear(self.threshold):
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
    def half(self) -> Comb:
        """Comb at half of the line of the best element."""
        return comb_at(self.spectra, self.findings[self.best].comb.frequency / 2.0)

    @property
    def may_be_doubled(self) -> bool:
        """True if a race of a ring is named, and half of its line is about as strong and no shaft order.

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

    tolerance: relative, of the lines; band: of the first envelope (Hz). A race is named if its comb exceeds the
    threshold and is within the tolerance, no other periodicity of the record scores higher, and the record is not
    full of lines. Raises ValueError as ``band_spectrum``.
    """
    lines = Lines.of(parts, shaft)
    spectra = envelope_spectra(series, fs, lines, band)
    findings = {race: _finding(spectra, lines, race, tolerance) for race in ELEMENTS}
    turns = shaft * len(series) / fs
    limit = threshold(equivalent_turns(lines, turns), tolerance)
    best = max(findings, key=lambda race: findings[race].comb.score)
    comb = findings[best].comb
    detection = detect(spectra, lines, best, comb, tolerance, limit)
    verdict = detection.objection or _race(spectra, findings, best)
    size = _size(series, fs, parts, comb, limit) if verdict == OUTER else None
    return Diagnosis(verdict, lines, findings, detection, size, turns, spectra)


def _size(series: np.ndarray, fs: float, parts: RollingParts, comb: Comb, limit: float) -> Size | str:
    """Estimate the size of a defect of the outer race if its comb is clear, else return the reason."""
    if comb.score < clear(limit):
        return f"the line is not {CLEAR_DB:g} dB over the threshold"
    return outer_race_size(series, fs, parts, comb.frequency)


def _finding(spectra: Sequence[EnvelopeSpectrum], lines: Lines, race: str, tolerance: float) -> Finding:
    comb = refined(spectra, best_comb(spectra, lines.of_race(race), tolerance))
    shaft = _sidebands(spectra[0], comb.frequency, np.array([lines.shaft]))
    cages = np.linspace(*CAGE_RANGE, CAGE_STEPS) * lines.cage
    return Finding(lines.of_race(race), comb, shaft, _sidebands(spectra[0], comb.frequency, cages))


def _sidebands(spectrum: EnvelopeSpectrum, frequency: float, spacings: np.ndarray) -> tuple[float, ...]:
    """Return log(1 + height) at a spacing (Hz), and below and above a frequency (Hz), for the best spacing."""
    heights = np.log1p(heights_at(spectrum, np.array([spacings, frequency - spacings, frequency + spacings])))
    return tuple(map(float, heights[:, np.argmax(heights.sum(axis=0))]))


def _race(spectra: Sequence[EnvelopeSpectrum], findings: dict[str, Finding], best: str) -> str:
    """Return the race with the best comb, or ``EITHER`` if outer race and roller share it and the lines of the
    cage do not decide."""
    outer, roller = findings[OUTER], findings[ROLLER]
    is_shared = abs(outer.comb.frequency - roller.comb.frequency) <= SAME_BINS * spectra[0].step
    if best == INNER or not is_shared:
        return best
    ratio = sum(findings[best].cage_sidebands) / findings[best].comb.scores[0]
    return OUTER if ratio <= OUTER_MOST else ROLLER if ratio >= ROLLER_LEAST else EITHER
