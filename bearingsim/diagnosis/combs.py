"""Scores of combs: three harmonics of one fundamental in two spectra, of which the lower counts."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bearingsim.diagnosis.envelopes import EnvelopeSpectrum, band_spectrum, fast_length, levelled_spectrum
from bearingsim.diagnosis.kinematics import Lines

HARMONICS = 3
STEPS_PER_BIN = 6
"""Fundamentals tried per bin: the third harmonic moves by half a bin."""
OTHERS_FROM, OTHERS_TO = 1.2, 1.3
"""Range of other periodicities: from 1.2 shaft orders to 1.3 times the highest line."""
SHAFT_SHARE = 0.01
"""Relative half width of the shaft orders, which do not count as other periodicities."""
SCORE_SCATTER = 2.0
"""Largest score of a comb over that of the shaft order that explains it. Of constructed knocks it is up to 0.6,
because heights of lines scatter, of an outer race or a rolling element at an order of the shaft 7 and more."""
RELATIVE_SHARE, RELATIVE_BINS = 0.006, 2.0
"""Half width of the relatives of the line of a race: its share, and at least some bins."""
RELATIVES = (1 / 3, 1 / 2, 2 / 3, 1.0, 3 / 2, 2.0, 3.0)
"""Multiples of the line of a race whose combs share its harmonics."""


def highest_frequency(lines: Lines) -> float:
    """Return the highest frequency (Hz) that is read from a spectrum: the third harmonic of the highest other
    periodicity."""
    return 1.02 * HARMONICS * OTHERS_TO * max(lines.outer, lines.inner, lines.roller)


def envelope_spectra(
    series: np.ndarray, fs: float, lines: Lines, band: tuple[float, float] | None = None
) -> tuple[EnvelopeSpectrum, EnvelopeSpectrum]:
    """Compute both envelope spectra of a series (n,) at ``fs`` (Hz), shortened for a fast transform.

    band: as of ``band_spectrum``, whose errors are raised.
    """
    part, shaft, highest = series[: fast_length(len(series))], lines.shaft, highest_frequency(lines)
    return band_spectrum(part, fs, shaft, highest, band), levelled_spectrum(part, fs, shaft, highest)


class Comb(NamedTuple):
    """Comb of a fundamental (Hz): its score, that of each spectrum, and the heights (spectra, harmonics)."""

    frequency: float
    score: float
    scores: tuple[float, ...]
    heights: tuple[tuple[float, ...], ...]


def heights_at(spectrum: EnvelopeSpectrum, frequency: np.ndarray) -> np.ndarray:
    """Return the heights (...) at frequencies (...) in Hz: that of the higher of two bins. 0 beyond."""
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
    """Return the fundamentals (n,) between two frequencies (Hz) that are tried, for bins of ``step`` (Hz)."""
    return np.linspace(low, high, max(2, int(np.ceil((high - low) / step * STEPS_PER_BIN)) + 1))


def comb_at(spectra: Sequence[EnvelopeSpectrum], frequency: float) -> Comb:
    """Return the comb of one fundamental (Hz)."""
    scores = comb_scores(spectra, np.array([frequency]))[:, 0]
    numbers = np.arange(1, HARMONICS + 1)
    heights = tuple(tuple(map(float, heights_at(spectrum, numbers * frequency))) for spectrum in spectra)
    return Comb(float(frequency), float(scores.min()), tuple(map(float, scores)), heights)


def best_comb(spectra: Sequence[EnvelopeSpectrum], expected: float, tolerance: float) -> Comb:
    """Find the comb with the highest score whose fundamental is within a relative tolerance of ``expected``
    (Hz).

    Of fundamentals with the same score, which a bin may have, it is the middle one.
    """
    fundamentals = fundamentals_between(
        (1.0 - tolerance) * expected, (1.0 + tolerance) * expected, spectra[0].step
    )
    scores = comb_scores(spectra, fundamentals).min(axis=0)
    best = int(np.argmax(scores))
    end = best + int(np.argmin(np.append(scores[best:] == scores[best], False))) - 1
    return comb_at(spectra, float(fundamentals[(best + end) // 2]))


def refined(spectra: Sequence[EnvelopeSpectrum], comb: Comb) -> Comb:
    """Refine the fundamental of a comb by peaks near its harmonics: parabolas through three logarithms of heights.

    Harmonics are weighted by their number and score.
    """
    estimates, weights = [], []
    for spectrum in spectra:
        for number in range(1, HARMONICS + 1):
            low = int(number * comb.frequency / spectrum.step)
            window = spectrum.height[max(low - 1, 1) : low + 3]
            if len(window) < 4 or low + 3 >= len(spectrum.height):
                continue
            peak = max(low - 1, 1) + int(np.argmax(window))
            left, middle, right = np.log(np.maximum(spectrum.height[peak - 1 : peak + 2], 1e-9))
            curvature = left - 2.0 * middle + right
            shift = 0.5 * (left - right) / curvature if curvature < 0.0 else 0.0
            estimates.append((peak + min(max(shift, -0.5), 0.5)) * spectrum.step / number)
            weights.append(number * np.log1p(spectrum.height[peak]))
    return comb._replace(frequency=float(np.average(estimates, weights=weights))) if sum(weights) > 0.0 else comb


class OtherPeriodicities(NamedTuple):
    """Fundamentals (n,) in Hz and the lower of their scores (n,), 0 for relatives of the line of the race."""

    fundamentals: np.ndarray
    scores: np.ndarray


def other_periodicities(
    spectra: Sequence[EnvelopeSpectrum], lines: Lines, race: str, race_comb: Comb, tolerance: float
) -> OtherPeriodicities:
    """Score the periodicities that are neither the line of a race nor its relatives, nor shaft orders.

    Relatives are its multiples and fractions up to 3, and its sidebands at one and two times the frequencies of
    shaft and cage. A sideband of the shaft that scores higher than the line in both spectra is no
    relative, because the load zone modulates an inner-race defect less than fully, so a line exceeds its own
    sidebands, and the line of the race may itself be a sideband of a line of another bearing.
    """
    low, high = OTHERS_FROM * lines.shaft, OTHERS_TO * max(lines.outer, lines.inner, lines.roller)
    fundamentals = fundamentals_between(low, high, spectra[0].step)
    scores = comb_scores(spectra, fundamentals)
    order = np.round(fundamentals / lines.shaft) * lines.shaft
    is_own = np.abs(fundamentals - order) <= SHAFT_SHARE * order
    is_own |= np.abs(fundamentals / lines.of_race(race) - 1.0) <= tolerance
    is_own |= _is_near(fundamentals, [share * race_comb.frequency for share in RELATIVES], spectra[0].step)
    is_own |= _is_near(fundamentals, _sidebands(race_comb.frequency, lines.cage), spectra[0].step)
    is_weaker = np.any(scores <= np.array(race_comb.scores)[:, np.newaxis], axis=0)
    is_own |= is_weaker & _is_near(fundamentals, _sidebands(race_comb.frequency, lines.shaft), spectra[0].step)
    return OtherPeriodicities(fundamentals, np.where(is_own, 0.0, scores.min(axis=0)))


def _sidebands(frequency: float, spacing: float) -> list[float]:
    """Return the first and second sidebands (Hz) of a line at both sides."""
    return [frequency + number * spacing for number in (-2, -1, 1, 2)]


def _is_near(fundamentals: np.ndarray, relatives: Sequence[float], step: float) -> np.ndarray:
    """Check which fundamentals (n,) in Hz lie at any of the relatives of a line (Hz)."""
    half_widths = [max(RELATIVE_SHARE * relative, RELATIVE_BINS * step) for relative in relatives]
    pairs = zip(relatives, half_widths, strict=True)
    return np.any([np.abs(fundamentals - relative) <= width for relative, width in pairs], axis=0)


def comb_of_shaft(spectra: Sequence[EnvelopeSpectrum], lines: Lines, comb: Comb, threshold: float) -> Comb | None:
    """Return the strongest comb of an order of the shaft that explains the comb of a race; None if there is none.

    A knock once per revolution raises all orders of the shaft, of which a line within the tolerance may be one.
    The order scores about as high as the race's comb, which is not over the threshold without the harmonics that
    both share. Each order is searched itself: knocks four times per revolution have no line at the lower orders.
    """
    least = max(threshold, comb.score - SCORE_SCATTER)
    numbers, explanations = np.arange(1, HARMONICS + 1), []
    for order in range(1, round(comb.frequency / lines.shaft)):
        candidate = refined(spectra, best_comb(spectra, order * lines.shaft, SHAFT_SHARE))
        multiples = numbers * comb.frequency / candidate.frequency
        distances = np.abs(multiples - np.round(multiples)) * candidate.frequency
        own = np.log1p(comb.heights) * (distances > RELATIVE_BINS * spectra[0].step)
        if candidate.score > least and own.sum(axis=1).min() <= threshold:
            explanations.append(candidate)
    return max(explanations, key=lambda candidate: candidate.score, default=None)


def share_at_score(others: OtherPeriodicities, score: float, tolerance: float) -> float:
    """Compute the share of windows, each twice the relative tolerance wide, in which a periodicity reaches a
    score."""
    low, high = np.log(others.fundamentals[[0, -1]])
    starts = np.searchsorted(others.fundamentals, np.exp(np.arange(low, high, 2.0 * tolerance)))
    return float(np.mean(np.maximum.reduceat(others.scores, np.unique(starts)) >= score))
