"""Cost of a diagnosis."""

import time

import numpy as np

from bearingsim.diagnosis import diagnose
from bearingsim.diagnosis.kurtogram import kurtogram
from bearingsim.measured import read
from tests.scenes.impacts import PARTS


def test_ten_seconds_at_51_2_kHz_take_under_two_seconds_of_cpu(tmp_path):
    np.savez(tmp_path / "a.npz", x=np.random.default_rng(0).normal(size=512_000), fs=51200.0, rpm=1500.0)
    begin = time.process_time()
    recording = read(tmp_path / "a.npz")
    kurtogram(recording.channels["x"], recording.rate.value)
    result = diagnose(recording.channels["x"], recording.rate.value, PARTS, recording.shaft)
    assert time.process_time() - begin < 2.0
    assert result.revolutions == 250.0
    assert result.verdict == "none"
