"""Measured signals: comparison with published analyses. Run if BEARINGSIM_MEASURED names their folder.

Files: two of the CWRU Bearing Data Center (drive end, 6205-2RS, 1796 rpm; 130: 0.007 in. fault of the outer race,
97: healthy), as .npz with x, fs, rpm; three of the Harbin Institute of Technology (6205; two with an outer-race
spall of 8 deg, Wang 2022), as .mat, 51 200 Hz.
"""

import os
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import scipy.io

from bearingsim.signals import entry_to_exit_time, envelope_spectrum, pick_from, pick_line, squared_envelope

FOLDER = os.environ.get("BEARINGSIM_MEASURED", "")
pytestmark = pytest.mark.skipif(not FOLDER, reason="BEARINGSIM_MEASURED names no folder of measured signals")

BPFO, BPFI = 3.5848, 5.4152  # orders of the shaft, as CWRU prints them for the 6205


class Signal(NamedTuple):
    """A measured acceleration (n,), its sampling rate (Hz) and the shaft's speed (Hz)."""

    series: np.ndarray
    fs: float
    shaft: float


def load_cwru(name: str) -> Signal:
    file = np.load(Path(FOLDER, name))
    return Signal(file["x"], float(file["fs"]), float(file["rpm"]) / 60)


def load_hit(name: str, rpm: float) -> Signal:
    file = scipy.io.loadmat(Path(FOLDER, name))
    (series,) = (value[:, 0] for key, value in file.items() if not key.startswith("__"))
    return Signal(series, 51200.0, rpm / 60)


SIGNALS = {
    "fault": lambda: load_cwru("cwru_130_OR007_6_DE.npz"),
    "healthy": lambda: load_cwru("cwru_97_normal_DE.npz"),
    "spall at 900": lambda: load_hit("hit_spectraquest_OR8_900.mat", 900),
    "spall at 600": lambda: load_hit("hit_spectraquest_OR8_600.mat", 600),
    "no spall": lambda: load_hit("hit_spectraquest_Normal_900.mat", 900),
}


def strongest_frequency(signal: Signal) -> float:
    """Frequency (Hz) of the highest bin of the squared-envelope spectrum from 3 Hz to 1 kHz."""
    frequencies, amplitudes = envelope_spectrum(signal.series, signal.fs)
    low = (frequencies > 3.0) & (frequencies < 1000.0)
    return float(frequencies[low][np.argmax(amplitudes[low])])


@pytest.mark.parametrize(
    ("name", "frequency"),
    [("fault", 107.61), ("spall at 900", 53.91), ("spall at 600", 35.94), ("no spall", 100.0)],
)
def test_strongest_line_has_the_expected_frequency(name: str, frequency: float) -> None:
    signal = SIGNALS[name]()
    # the exact bin; without a spall, twice the mains frequency
    assert strongest_frequency(signal) == pytest.approx(frequency, abs=0.005)


@pytest.mark.parametrize(
    ("name", "harmonic", "prominence"),
    [("fault", 1, 621.0), ("fault", 2, 502.0), ("fault", 3, 425.0), ("spall at 900", 1, 217.0)],
)
def test_ball_pass_prominence_agrees_with_publication(name: str, harmonic: int, prominence: float) -> None:
    """Prominence of the highest bin, relative to a local median whose width is not published: within 10 %.

    The picked line, interpolated between bins, is up to 16 % higher (scalloping loss of the Hann window).
    """
    signal = SIGNALS[name]()
    frequencies, amplitudes = envelope_spectrum(signal.series, signal.fs)
    picked = pick_from(frequencies, amplitudes, harmonic * BPFO * signal.shaft)
    assert picked is not None
    in_band = np.abs(frequencies - picked.frequency) < 20.0
    highest = amplitudes[np.abs(frequencies - picked.frequency) < frequencies[1]].max()
    assert highest / np.median(amplitudes[in_band]) == pytest.approx(prominence, rel=0.1)
    assert 0.95 < picked.median_ratio / prominence < 1.2


@pytest.mark.parametrize(("name", "limit"), [("healthy", 4.0), ("no spall", 10.0)])
@pytest.mark.parametrize("order", [BPFO, BPFI])
def test_healthy_bearing_has_no_prominent_line(name: str, limit: float, order: float) -> None:
    signal = SIGNALS[name]()
    for picked in (
        pick_from(*envelope_spectrum(signal.series, signal.fs), order * signal.shaft),
        pick_line(squared_envelope(signal.series, signal.fs), signal.fs, order * signal.shaft, 0.02),
    ):
        assert picked is None or picked.median_ratio < limit


@pytest.mark.parametrize("name", ["fault", "spall at 900", "spall at 600"])
def test_both_pickers_agree(name: str) -> None:
    signal = SIGNALS[name]()
    expected = BPFO * signal.shaft
    rough = pick_from(*envelope_spectrum(signal.series, signal.fs), expected)
    fine = pick_line(squared_envelope(signal.series, signal.fs), signal.fs, expected, 0.02)
    assert rough is not None
    assert fine is not None
    assert fine.frequency == pytest.approx(rough.frequency, abs=0.1 * signal.fs / len(signal.series))
    assert fine.amplitude == pytest.approx(rough.amplitude, rel=0.02)
    # measured lines are 0.3 to 1.4 % higher, because of slip and the nominal speed
    assert 0.0 < fine.frequency / expected - 1 < 0.014


@pytest.mark.parametrize(("name", "expected"), [("spall at 900", 3.09e-3), ("spall at 600", 4.65e-3)])
def test_measured_spacing_agrees_with_publication(name: str, expected: float) -> None:
    """Wang 2022: the spacing is 0.75 to 0.95 of the time in which a ball crosses the spall.

    A ball crosses 8 deg of the outer race in 8/360 of a turn of the cage.
    """
    signal = SIGNALS[name]()
    measured = entry_to_exit_time(signal.series, signal.fs, 1.0 / strongest_frequency(signal))
    assert measured == pytest.approx(expected, rel=0.01)
    crossing = 8 / 360 / (BPFO / 9 * signal.shaft)
    assert 0.75 < measured / crossing < 0.95


def test_spacing_times_speed_is_constant() -> None:
    """Within 4 %, at 600 and 900 rpm."""
    products = [
        entry_to_exit_time(signal.series, signal.fs, 1.0 / strongest_frequency(signal)) * signal.shaft
        for signal in (SIGNALS["spall at 900"](), SIGNALS["spall at 600"]())
    ]
    assert max(products) / min(products) < 1.04


@pytest.mark.parametrize("name", ["fault", "healthy", "no spall"])
def test_small_or_missing_fault_has_no_spacing(name: str) -> None:
    signal = SIGNALS[name]()
    assert np.isnan(entry_to_exit_time(signal.series, signal.fs, 1.0 / (BPFO * signal.shaft)))
