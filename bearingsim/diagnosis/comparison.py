"""Comparison of a simulated and a measured signal of one bearing, in a common band."""

import re
from math import isfinite, log10, nan
from typing import NamedTuple

import numpy as np

from bearingsim.diagnosis.combs import (
    HARMONICS,
    RELATED_BINS,
    RELATED_TOLERANCE,
    envelope_spectra,
    find_best_comb,
    refine,
)
from bearingsim.diagnosis.detection import Detection, detect
from bearingsim.diagnosis.envelopes import default_band
from bearingsim.diagnosis.kinematics import Lines
from bearingsim.diagnosis.suitability import refuse_unsuitable
from bearingsim.diagnosis.thresholds import equivalent_revolutions, threshold
from bearingsim.signals.events import entry_to_exit_time
from bearingsim.signals.moments import statistics
from bearingsim.signals.picker import PickedLine, pick_from
from bearingsim.signals.spectra import PASSBAND_EDGE, band_pass, envelope_spectrum

TOLERANCE = 0.02
"""Largest relative deviation of a line from its kinematic frequency; slip of measured bearings reaches 1.4 %."""


class Signal(NamedTuple):
    """Series (n,) in SI sampled at ``fs`` (Hz), and the kinematic frequencies of its bearing (Hz)."""

    series: np.ndarray
    fs: float
    lines: Lines


class Row(NamedTuple):
    """Simulated and measured value of a feature, with its unit; NaN if a signal has no such value."""

    name: str
    unit: str
    simulated: float
    measured: float

    @property
    def key(self) -> str:
        """Name of the feature in JSON."""
        return re.sub(r"\W+", "_", self.name.lower())


def detect_line(signal: Signal, race: str) -> Detection:
    """Compare the line of a race with all other periodicities of a signal, as ``diagnose``.

    race: one of ``ELEMENTS``. Raises Unsuitable for a record that cannot be diagnosed.
    """
    series, fs, lines = signal
    refuse_unsuitable(len(series), fs, lines, default_band(fs))
    spectra = envelope_spectra(series, fs, lines)
    comb = refine(spectra, find_best_comb(spectra, lines.of_race(race), TOLERANCE))
    revolutions = equivalent_revolutions(lines, lines.shaft * len(series) / fs)
    return detect(spectra, lines, race, comb, TOLERANCE, threshold(revolutions, TOLERANCE))


def common_band(*signals: Signal) -> tuple[float, float]:
    """Return the band (Hz) in which all signals are unaltered by sampling."""
    return 0.0, PASSBAND_EDGE * min(signal.fs for signal in signals)


def compare(
    simulated: Signal, measured: Signal, race: str, band: tuple[float, float], unit: str, detected: float
) -> list[Row]:
    """Compare two signals in a band (Hz): RMS, peak, crest factor, kurtosis, and a line in the envelope spectrum.

    race: one of ``ELEMENTS``; unit: SI unit of the series; detected: line (Hz) of the measured signal, NaN if it
    has none. Harmonics of the envelope are in dB relative to the fundamental; orders are relative to the frequency
    of the shaft. The time from entry to exit is in fractions of a pass, which do not depend on the speed; it is
    determined from the content below half the lower sampling rate.
    """
    nyquist = 0.5 * min(simulated.fs, measured.fs)
    values = [_features(simulated, race, band, nyquist), _features(measured, race, band, nyquist, detected)]
    units = {"RMS": unit, "peak": unit, "line": "orders", "line over kinematic": ""}
    units |= {f"envelope, harmonic {number}": "dB" for number in range(2, HARMONICS + 1)}
    return [Row(name, units.get(name, ""), values[0][name], values[1][name]) for name in values[0]]


def _features(
    signal: Signal, race: str, band: tuple[float, float], nyquist: float, detected: float | None = None
) -> dict[str, float]:
    series = band_pass(signal.series - signal.series.mean(), signal.fs, band)
    moments = statistics(series)
    frequency, amplitude = envelope_spectrum(signal.series, signal.fs, band)
    expected = signal.lines.of_race(race)
    fundamental = _fundamental(frequency, amplitude, expected, detected)
    line = fundamental.frequency if fundamental else nan
    features = {
        "RMS": moments["rms"],
        "peak": moments["peak"],
        "crest factor": moments["crest"],
        "kurtosis": moments["kurtosis"],
        "line": line / signal.lines.shaft,
        "line over kinematic": line / expected,
    }
    for number in range(2, HARMONICS + 1):
        harmonic = pick_from(frequency, amplitude, number * line, TOLERANCE / number) if fundamental else None
        features[f"envelope, harmonic {number}"] = _relative_level(harmonic, fundamental)
    features["entry to exit, of a pass"] = (
        _entry_to_exit_share(signal, line, nyquist) if race == "outer" and fundamental else nan
    )
    return features


def _fundamental(
    frequency: np.ndarray, amplitude: np.ndarray, expected: float, detected: float | None
) -> PickedLine | None:
    """Find the line of a race in an envelope spectrum: the detected one (Hz), if any, else the kinematic one."""
    if detected is None:
        return pick_from(frequency, amplitude, expected, TOLERANCE)
    if not isfinite(detected):
        return None
    # A line detected at the limit of the tolerance may have its maximum beyond it.
    bins = RELATED_BINS * (frequency[1] - frequency[0])
    return pick_from(frequency, amplitude, detected, max(RELATED_TOLERANCE, bins / detected))


def _relative_level(harmonic: PickedLine | None, fundamental: PickedLine | None) -> float:
    """Return the level (dB) of a harmonic relative to the fundamental; NaN if a line is missing."""
    return 20.0 * log10(harmonic.amplitude / fundamental.amplitude) if harmonic and fundamental else nan


def _entry_to_exit_share(signal: Signal, line: float, nyquist: float) -> float:
    """Return the time from entry to exit of a defect relative to a pass; NaN if it cannot be measured.

    line: frequency (Hz) of the passes. The maxima of the whitened envelope depend on the band, so content above
    ``nyquist`` (Hz) is removed to give signals of different sampling rates the same band. The common band is not
    used, because whitening converts its steep edge to a tone.
    """
    try:
        series = band_pass(signal.series, signal.fs, (0.0, nyquist))
        return entry_to_exit_time(series, signal.fs, 1.0 / line) * line
    except ValueError:
        return nan
