"""Features of a frequency band, which do not depend on the sampling of the record."""

import numpy as np
import pytest

from bearingsim.config.names import read_band
from bearingsim.simulation import simulate
from tests.scenes.nf308 import SLOT, case

BPFO = case().bearing.ball_pass_frequency(case().speed)
NARROW = SLOT | {"width": "0.2 mm"}
RMS, HIGH, ENVELOPE = "velocity.rms@10-1000Hz", "acceleration.rms@1000-5000Hz", "envelope@BPFO@1000-5000Hz"


def simulate_bands(**overrides):
    names = [RMS, HIGH, ENVELOPE, "envelope@BPFO"]
    return simulate(case(defect=NARROW, duration="0.25 s", features=names, **overrides))


@pytest.fixture(scope="module")
def narrow():
    return simulate_bands(sampling="102400 Hz", record=["sensor.velocity", "sensor.acceleration"])


def test_a_band_does_not_depend_on_the_sampling(narrow):
    coarse = simulate_bands(sampling="10240 Hz", record=[]).features
    for name in (RMS, HIGH, ENVELOPE):
        assert coarse[name] == pytest.approx(narrow.features[name], rel=0.01)
    assert coarse["velocity.rms"] < 0.5 * narrow.features["velocity.rms"]  # depends on the sampling


def test_envelope_without_a_band_uses_the_sampled_band(narrow):
    coarse = simulate_bands(sampling="10240 Hz", record=[], periodic=False).features
    named = simulate(case(defect=NARROW, duration="0.25 s", features=["envelope@BPFO@0-4096Hz"], record=[]))
    assert coarse["envelope@BPFO"] == pytest.approx(named.features["envelope@BPFO@0-4096Hz"], rel=1e-3)
    assert narrow.features["envelope@BPFO"] > 10.0 * coarse["envelope@BPFO"]


def test_rms_of_a_band_is_that_of_its_harmonics(narrow):
    """A periodic motion has multiples of BPFO only: six up to 1000 Hz, from the recorded series."""
    line, series = BPFO, narrow.series["sensor.velocity"]
    n = round(10 / line * 102400)
    amplitudes = np.abs(np.fft.rfft(series[-n:])) * 2.0 / n
    power = 0.5 * np.sum(amplitudes[10 : 10 * int(1000 / line) + 1 : 10] ** 2)
    assert narrow.features[RMS] == pytest.approx(np.sqrt(power), rel=0.02)


OTHER_NAMES = (
    "velocity.rms@10-1000",
    "velocity.peak@10-1000Hz",
    "envelope@BPFX",
    "envelope@BPFO@5kHz",
    "envelope",
)


@pytest.mark.parametrize("name", [*OTHER_NAMES, "velocity.rms@1-5kHz", "velocity.rms@10.0-1000Hz"])
def test_other_names_are_not_bands(name):
    assert read_band(name) is None


def test_line_is_nan_if_the_band_is_too_narrow():
    result = simulate(case(defect=NARROW, duration="0.1 s", features=["envelope@BPFO@1000-1100Hz"], record=[]))
    assert np.isnan(result.features["envelope@BPFO@1000-1100Hz"])


def test_line_is_nan_if_the_record_cannot_resolve_it():
    """157 Hz next to BPFO at 159 Hz, in 0.1 s."""
    result = simulate(case(defect=NARROW, duration="0.1 s", features=["envelope@2BSF"], record=[]))
    assert np.isnan(result.features["envelope@2BSF"])
    assert np.isnan(result.features["velocity@2BSF"])
