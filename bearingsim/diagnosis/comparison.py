"""Comparison of a simulated and a measured signal of one bearing, in a common band."""

import re
from math import isfinite, log10, nan
from typing import NamedTuple

import numpy as np

from bearingsim.diagnosis.combs import (
    HARMONICS,
    RELATIVE_BINS,
    RELATIVE_SHARE,
    best_comb,
    envelope_spectra,
    refined,
)
from bearingsim.diagnosis.detection import Detection, detect
from bearingsim.diagnosis.envelopes import default_band
from bearingsim.diagnosis.kinematics import Lines
from bearingsim.diagnosis.suitability import refuse_unsuitable
from bearingsim.diagnosis.thresholds import equivalent_turns, threshold
from bearingsim.signals.events import entry_to_exit_time
from bearingsim.signals.moments import statistics
from bearingsim.signals.picker import PickedLine, pick_from
from bearingsim.signals.spectra import PASSBAND_EDGE, band_pass, envelope_spectrum

TOLERANCE = 0.02
"""Relative deviation of a line from its kinematic frequency; slip of measured bearings reaches 1.4 %."""


class Signal(NamedTuple):
    """Series (n,) in SI sampled at ``fs`` (Hz), and the kinematic lines of its bearing (Hz)."""

    series: np.ndarray
    fs: float
    lines: Lines


class Row(NamedTuple):
    """Feature with its unit, simulated and measured; nan where it is not read."""

    name: str
    unit: str
    simulated: float
    measured: float

    @property
    def key(self) -> str:
        """Name of the feature in JSON."""
        return re.sub(r"\W+", "_", self.name.lower())


def detect_line(signal: Signal, race: str) -> Detection:
    """Compare the line of a race with all other periodicities of a signal, as ``diagnose`` does.

    Raises Unsuitable for a record that cannot be judged.
    """
    series, fs, lines = signal
    refuse_unsuitable(len(series), fs, lines, default_band(fs))
    spectra = envelope_spectra(series, fs, lines)
    comb = refined(spectra, best_comb(spectra, lines.of_race(race), TOLERANCE))
    turns = equivalent_turns(lines, lines.shaft * len(series) / fs)
    return detect(spectra, lines, race, comb, TOLERANCE, threshold(turns, TOLERANCE))


def common_band(*signals: Signal) -> tuple[float, float]:
    """Return the band (Hz) in which all signals are unaltered by sampling."""
    return 0.0, PASSBAND_EDGE * min(signal.fs for signal in signals)


def compare(
    simulated: Signal, measured: Signal, race: str, band: tuple[float, float], unit: str, detected: float
) -> list[Row]:
    """Compare two signals in a band (Hz): RMS, peak, crest factor, kurtosis, and a race's line in the envelope.

    unit: SI unit of the series; detected: line (Hz) of the measured signal, nan if it has none. Harmonics of the
    envelope are in dB relative to the fundamental; orders refer to the frequency of the shaft; the spacing of
    entry and exit is in fractions of a pass, which do not depend on the speed, up to half the lower sampling rate.
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
        features[f"envelope, harmonic {number}"] = _level(harmonic, fundamental)
    features["entry to exit, of a pass"] = (
        _spacing(signal, line, nyquist) if race == "outer" and fundamental else nan
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
    # Around the detected line: one at the limit of the tolerance has its maximum on either side of it.
    bins = RELATIVE_BINS * (frequency[1] - frequency[0])
    return pick_from(frequency, amplitude, detected, max(RELATIVE_SHARE, bins / detected))


def _level(harmonic: PickedLine | None, fundamental: PickedLine | None) -> float:
    """Return the level (dB) of a harmonic over the fundamental."""
    return 20.0 * log10(harmonic.amplitude / fundamental.amplitude) if harmonic and fundamental else nan


def _spacing(signal: Signal, line: float, nyquist: float) -> float:
    """Return the time from entry to exit of a defect, relative to a pass; nan if it is not read.

    The maxima of the whitened envelope depend on the band: without content above ``nyquist`` (Hz) two signals of
    different rates have the same. The common band is not used: whitening turns its steep end into a tone.
    """
    try:
        series = band_pass(signal.series, signal.fs, (0.0, nyquist))
        return entry_to_exit_time(series, signal.fs, 1.0 / line) * line
    except ValueError:
        return nan
