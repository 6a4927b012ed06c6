"""Features of a band: what they are of, whatever the sampling of the record."""

import numpy as np
import pytest

from bearingsim.config.names import read_band
from bearingsim.simulation import simulate
from tests.scenes.nf308 import SLOT, case

BPFO = case().bearing.ball_pass_frequency(case().speed)
NARROW = SLOT | {"width": "0.2 mm"}
RMS, HIGH, ENVELOPE = "velocity.rms@10-1000Hz", "acceleration.rms@1000-5000Hz", "envelope@BPFO@1000-5000Hz"


def computed(**given):
    names = [RMS, HIGH, ENVELOPE, "envelope@BPFO"]
    return simulate(case(defect=NARROW, duration="0.25 s", features=names, **given))


@pytest.fixture(scope="module")
def narrow():
    return computed(sampling="102400 Hz", record=["sensor.velocity", "sensor.acceleration"])


def test_a_band_does_not_depend_on_the_sampling(narrow):
    coarse = computed(sampling="10240 Hz", record=[]).features
    for name in (RMS, HIGH, ENVELOPE):
        assert coarse[name] == pytest.approx(narrow.features[name], rel=0.01)
    assert coarse["velocity.rms"] < 0.5 * narrow.features["velocity.rms"]  # which does


def test_an_envelope_without_a_band_is_that_of_what_the_sampling_shows(narrow):
    coarse = computed(sampling="10240 Hz", record=[], periodic=False).features
    named = simulate(case(defect=NARROW, duration="0.25 s", features=["envelope@BPFO@0-4096Hz"], record=[]))
    assert coarse["envelope@BPFO"] == pytest.approx(named.features["envelope@BPFO@0-4096Hz"], rel=1e-3)
    assert narrow.features["envelope@BPFO"] > 10.0 * coarse["envelope@BPFO"]


def test_the_rms_of_a_band_is_that_of_its_harmonics(narrow):
    """All that repeats is in multiples of BPFO: six of them up to 1000 Hz, from the recorded series."""
    line, series = BPFO, narrow.series["sensor.velocity"]
    n = round(10 / line * 102400)
    amplitudes = np.abs(np.fft.rfft(series[-n:])) * 2.0 / n
    power = 0.5 * np.sum(amplitudes[10 : 10 * int(1000 / line) + 1 : 10] ** 2)
    assert narrow.features[RMS] == pytest.approx(np.sqrt(power), rel=0.02)


OTHERS = ("velocity.rms@10-1000", "velocity.peak@10-1000Hz", "envelope@BPFX", "envelope@BPFO@5kHz", "envelope")


@pytest.mark.parametrize("name", [*OTHERS, "velocity.rms@1-5kHz", "velocity.rms@10.0-1000Hz"])
def test_other_names_are_no_bands(name):
    assert read_band(name) is None


def test_a_line_that_the_band_is_too_narrow_for_is_none():
    result = simulate(case(defect=NARROW, duration="0.1 s", features=["envelope@BPFO@1000-1100Hz"], record=[]))
    assert np.isnan(result.features["envelope@BPFO@1000-1100Hz"])


def test_a_line_that_the_record_does_not_tell_from_another_is_none():
    """157 Hz beside BPFO at 159 Hz, in 0.1 s."""
    result = simulate(case(defect=NARROW, duration="0.1 s", features=["envelope@2BSF"], record=[]))
    assert np.isnan(result.features["envelope@2BSF"])
    assert np.isnan(result.features["velocity@2BSF"])
