"""Spectra of recorded series by name, with units."""

from types import SimpleNamespace

import numpy as np
import pytest

import bearingsim as bs
from bearingsim.errors import UserError
from bearingsim.store import Series

RATE, BPFO = 10_000.0, 159.0
TIME = np.arange(10_000) / RATE
CARRIER = 2e-3 * (1.0 + 0.5 * np.cos(2.0 * np.pi * BPFO * TIME)) * np.sin(2.0 * np.pi * 2_000.0 * TIME)
CHANNELS = {"ring.velocity.x": CARRIER.astype("f4"), "ring.acceleration.y": CARRIER.astype("f4")}
SERIES = Series(TIME, CHANNELS, {"ring.velocity.x": "m/s", "ring.acceleration.y": "m/s^2"})
RECORD = SimpleNamespace(time=TIME, series=CHANNELS)


@pytest.mark.parametrize("record", [SERIES, RECORD], ids=["series", "record"])
def test_spectrum_of_a_modulated_carrier(record: object) -> None:
    spectrum = bs.spectrum(record, "ring.velocity.x")
    peaks = dict(zip(spectrum.frequency.round(), spectrum.amplitude, strict=True))
    assert peaks[2000.0] == pytest.approx(2e-3, rel=1e-6)
    assert peaks[2000.0 - BPFO] == pytest.approx(0.5e-3, rel=1e-6)
    assert (spectrum.unit, spectrum.label) == ("m/s", "Amplitude of ring.velocity.x (m/s, 0-peak)")


@pytest.mark.parametrize("record", [SERIES, RECORD], ids=["series", "record"])
def test_envelope_spectrum_of_a_modulated_carrier(record: object) -> None:
    """The squared envelope is A^2 (1 + m cos wt)^2, whose line at w is 2 m A^2."""
    spectrum = bs.envelope_spectrum(record, "ring.acceleration.y", band=(1e3, 3e3))
    line = spectrum.frequency[1:][np.argmax(spectrum.amplitude[1:])]
    assert line == pytest.approx(BPFO)
    assert spectrum.amplitude[1:].max() == pytest.approx(2.0 * 0.5 * 4e-6, rel=1e-6)
    assert spectrum.unit == "(m/s^2)^2"
    outside = bs.envelope_spectrum(record, "ring.acceleration.y", band=(3e3, 4e3))
    assert outside.amplitude.max() < 1e-12


def test_record_is_cut_to_whole_periods() -> None:
    """Of 1 s, 158 periods of 158.5 Hz remain, so a multiple of it is a line."""
    spectrum = bs.spectrum(SERIES, "ring.velocity.x", periods_of=158.5)
    assert spectrum.frequency[158] == pytest.approx(158.5, rel=1e-4)
    assert bs.spectrum(SERIES, "ring.velocity.x").frequency[158] == pytest.approx(158.0)


def test_unknown_channel_names_those_recorded() -> None:
    with pytest.raises(UserError, match=r"`ring.velocity.z` was not recorded \(did you mean `ring.velocity.x`"):
        bs.spectrum(SERIES, "ring.velocity.z")
    with pytest.raises(UserError, match=r"`force` was not recorded \(recorded: ring.velocity.x, "):
        bs.envelope_spectrum(SERIES, "force")


def test_band_beyond_half_of_the_sampling_rate_is_refused() -> None:
    with pytest.raises(ValueError, match="not within 0 to 5000 Hz"):
        bs.envelope_spectrum(SERIES, "ring.velocity.x", band=(1e3, 6e3))
