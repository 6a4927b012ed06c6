"""Scores of harmonic combs, which are a fundamental and its multiples, in two envelope spectra.

A comb has three harmonics. Its score is the lower of its scores in both spectra.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bearingsim.diagnosis.envelopes import EnvelopeSpectrum, band_spectrum, fast_length, levelled_spectrum
from bearingsim.diagnosis.kinematics import Lines

HARMONICS = 3
STEPS_PER_BIN = 6
"""Number of fundamentals tried per bin: a step shifts the third harmonic by half a bin."""
MIN_OTHER_ORDER, MAX_OTHER_RATIO = 1.2, 1.3
"""Range of other periodicities: from 1.2 shaft orders to 1.3 times the highest line of a defect."""
SHAFT_TOLERANCE = 0.01
"""Relative half width of the shaft orders, which do not count as other periodicities."""
MAX_SCORE_EXCESS = 2.0
"""Largest difference between the score of a comb and that of the shaft order that explains it. It is up to 0.6 for
constructed knocks, because the heights of lines scatter, and 7 or more for an outer race or a rolling element
whose line is a shaft order."""
RELATED_TOLERANCE, RELATED_BINS = 0.006, 2.0
"""Half width of the lines related to the line of a defect: relative, and at least a number of bins."""
RELATED_RATIOS = (1 / 3, 1 / 2, 2 / 3, 1.0, 3 / 2, 2.0, 3.0)
"""Ratios to the line of a defect of the fundamentals whose combs share its harmonics."""


def highest_frequency(lines: Lines) -> float:
    """Return the highest frequency (Hz) required of a spectrum: 2 % above the third harmonic of the highest other
    periodicity."""
    return 1.02 * HARMONICS * MAX_OTHER_RATIO * max(lines.outer, lines.inner, lines.roller)


def envelope_spectra(
    series: np.ndarray, fs: float, lines: Lines, band: tuple[float, float] | None = None
) -> tuple[EnvelopeSpectrum, EnvelopeSpectrum]:
    """Compute both envelope spectra of a series (n,) at ``fs`` (Hz), shortened for a fast transform.

    band: as for ``band_spectrum``, whose errors are raised. Returns the spectrum of the envelope in the band, and
    that of the levelled signal.
    """
    part, shaft, highest = series[: fast_length(len(series))], lines.shaft, highest_frequency(lines)
    return band_spectrum(part, fs, shaft, highest, band), levelled_spectrum(part, fs, shaft, highest)


class Comb(NamedTuple):
    """Comb of a fundamental: frequency (Hz), score, score by spectrum, and heights (spectra, harmonics)."""

    frequency: float
    score: float
    scores: tuple[float, ...]
    heights: tuple[tuple[float, ...], ...]


def heights_at(spectrum: EnvelopeSpectrum, frequency: np.ndarray) -> np.ndarray:
    """Return the heights (...) at frequencies (...) in Hz, each that of the higher of the two nearest bins.

    It is 0 above the highest frequency of the spectrum.
    """
    bins = frequency / spectrum.step
    low = np.clip(bins.astype(int), 0, len(spectrum.height) - 2)
    return np.where(
        bins < len(spectrum.height) - 1, np.maximum(spectrum.height[low], spectrum.height[low + 1]), 0.0
    )


def comb_scores(spectra: Sequence[EnvelopeSpectrum], fundamentals: np.ndarray) -> np.ndarray:
    """Compute the scores (spectra, n) of fundamentals (n,) in Hz: sums of log(1 + height) over three harmonics."""
    numbers = np.arange(1, HARMONICS + 1)[:, np.newaxis]
    return np.array([np.log1p(heights_at(spectrum, numbers * fundamentals)).sum(axis=0) for spectrum in spectra])


def fundamentals_between(low: float, high: float, step: float) -> np.ndarray:
    """Return the fundamentals (n,) to try between two frequencies (Hz), for bins of ``step`` (Hz)."""
    return np.linspace(low, high, max(2, int(np.ceil((high - low) / step * STEPS_PER_BIN)) + 1))


def comb_at(spectra: Sequence[EnvelopeSpectrum], frequency: float) -> Comb:
    """Return the comb of one fundamental (Hz)."""
    scores = comb_scores(spectra, np.array([frequency]))[:, 0]
    numbers = np.arange(1, HARMONICS + 1)
    heights = tuple(tuple(map(float, heights_at(spectrum, numbers * frequency))) for spectrum in spectra)
    return Comb(float(frequency), float(scores.min()), tuple(map(float, scores)), heights)


def find_best_comb(spectra: Sequence[EnvelopeSpectrum], expected: float, tolerance: float) -> Comb:
    """Find the comb with the highest score whose fundamental is within a relative tolerance of ``expected``
    (Hz).

    If neighbouring fundamentals have the same score, because their harmonics lie in the same bins, it is that of
    the central one.
    """
    fundamentals = fundamentals_between(
        (1.0 - tolerance) * expected, (1.0 + tolerance) * expected, spectra[0].step
    )
    scores = comb_scores(spectra, fundamentals).min(axis=0)
    best = int(np.argmax(scores))
    end = best + int(np.argmin(np.append(scores[best:] == scores[best], False))) - 1
    return comb_at(spectra, float(fundamentals[(best + end) // 2]))


def refine(spectra: Sequence[EnvelopeSpectrum], comb: Comb) -> Comb:
    """Refine the fundamental of a comb by interpolating the peaks near its harmonics.

    A peak is that of a parabola through the logarithms of three heights. Harmonics are weighted by their number
    and score. Score and heights of the comb are not changed.
    """
    estimates, weights = [], []
    for spectrum in spectra:
        for number in range(1, HARMONICS + 1):
            low = int(number * comb.frequency / spectrum.step)
            nearby = spectrum.height[max(low - 1, 1) : low + 3]
            if len(nearby) < 4 or low + 3 >= len(spectrum.height):
                continue
            peak = max(low - 1, 1) + int(np.argmax(nearby))
            left, centre, right = np.log(np.maximum(spectrum.height[peak - 1 : peak + 2], 1e-9))
            curvature = left - 2.0 * centre + right
            shift = 0.5 * (left - right) / curvature if curvature < 0.0 else 0.0
            estimates.append((peak + min(max(shift, -0.5), 0.5)) * spectrum.step / number)
            weights.append(number * np.log1p(spectrum.height[peak]))
    return comb._replace(frequency=float(np.average(estimates, weights=weights))) if sum(weights) > 0.0 else comb


class OtherPeriodicities(NamedTuple):
    """Fundamentals (n,) in Hz and their scores (n,), 0 for shaft orders, the line of a race and related lines."""

    fundamentals: np.ndarray
    scores: np.ndarray


def score_other_periodicities(
    spectra: Sequence[EnvelopeSpectrum], lines: Lines, race: str, race_comb: Comb, tolerance: float
) -> OtherPeriodicities:
    """Score the periodicities that are neither shaft orders, nor the line of a race, nor related to it.

    race: one of ``ELEMENTS``; race_comb: comb at its line; tolerance: relative, of the line. Related lines are the
    multiples of the line by ``RELATED_RATIOS``, and its first and second sidebands of shaft and cage. A shaft
    sideband that scores higher than the line in both spectra is not related, because a line exceeds its own
    sidebands: the load zone modulates an inner-race defect incompletely. The line of the race may then itself be a
    sideband of a line of another bearing.
    """
    low, high = MIN_OTHER_ORDER * lines.shaft, MAX_OTHER_RATIO * max(lines.outer, lines.inner, lines.roller)
    fundamentals = fundamentals_between(low, high, spectra[0].step)
    scores = comb_scores(spectra, fundamentals)
    line, step = race_comb.frequency, spectra[0].step
    order = np.round(fundamentals / lines.shaft) * lines.shaft
    is_excluded = np.abs(fundamentals - order) <= SHAFT_TOLERANCE * order
    is_excluded |= np.abs(fundamentals / lines.of_race(race) - 1.0) <= tolerance
    is_excluded |= _is_near(fundamentals, [ratio * line for ratio in RELATED_RATIOS], step)
    is_excluded |= _is_near(fundamentals, _sidebands(line, lines.cage), step)
    is_weaker = np.any(scores <= np.array(race_comb.scores)[:, np.newaxis], axis=0)
    is_excluded |= is_weaker & _is_near(fundamentals, _sidebands(line, lines.shaft), step)
    return OtherPeriodicities(fundamentals, np.where(is_excluded, 0.0, scores.min(axis=0)))


def _sidebands(frequency: float, spacing: float) -> list[float]:
    """Return the frequencies (Hz) of the first and second sidebands on both sides of a line."""
    return [frequency + number * spacing for number in (-2, -1, 1, 2)]


def _is_near(fundamentals: np.ndarray, related: Sequence[float], step: float) -> np.ndarray:
    """Check which fundamentals (n,) in Hz lie at any of the related lines (Hz), for bins of ``step`` (Hz)."""
    half_widths = [max(RELATED_TOLERANCE * line, RELATED_BINS * step) for line in related]
    pairs = zip(related, half_widths, strict=True)
    return np.any([np.abs(fundamentals - line) <= half_width for line, half_width in pairs], axis=0)


def find_shaft_comb(
    spectra: Sequence[EnvelopeSpectrum], lines: Lines, comb: Comb, threshold: float
) -> Comb | None:
    """Find the strongest comb of a shaft order that explains the comb of a race; None if there is none.

    A knock once per revolution raises all shaft orders, one of which may be within the tolerance of the line of a
    race. An order explains the comb of the race if its score is about as high, and if that comb is not over the
    threshold without the harmonics that both share. Every order is searched for, because knocks four times per
    revolution have no line at the lower orders.
    """
    min_score = max(threshold, comb.score - MAX_SCORE_EXCESS)
    numbers, explanations = np.arange(1, HARMONICS + 1), []
    for order in range(1, round(comb.frequency / lines.shaft)):
        candidate = refine(spectra, find_best_comb(spectra, order * lines.shaft, SHAFT_TOLERANCE))
        multiples = numbers * comb.frequency / candidate.frequency
        distances = np.abs(multiples - np.round(multiples)) * candidate.frequency
        unshared = np.log1p(comb.heights) * (distances > RELATED_BINS * spectra[0].step)
        if candidate.score > min_score and unshared.sum(axis=1).min() <= threshold:
            explanations.append(candidate)
    return max(explanations, key=lambda candidate: candidate.score, default=None)


def share_at_score(others: OtherPeriodicities, score: float, tolerance: float) -> float:
    """Compute the share of frequency intervals in which a periodicity reaches a score.

    An interval is twice the relative tolerance wide, as that in which the line of a race is searched.
    """
    low, high = np.log(others.fundamentals[[0, -1]])
    starts = np.searchsorted(others.fundamentals, np.exp(np.arange(low, high, 2.0 * tolerance)))
    return float(np.mean(np.maximum.reduceat(others.scores, np.unique(starts)) >= score))
