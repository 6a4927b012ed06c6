"""Results folders with signals of known sines, for figures of signals."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from bearingsim.config import dataset_names
from tests.scenes.figure_results import BPFO

STUDY = """\
study: options
bearing: nf308
speed: 1800 rpm
load: 150 N
defect: {race: outer, shape: circular, length: 3 mm, width: 0.8 mm, depth: 0.05 mm, angle: 0 deg}
model: rollers
sampling: 51200 Hz
duration: 0.1 s
record: [ring.acceleration, roller.1.outer_force]
sweep:
  defect.length: [3 mm, 6 mm, 9 mm]
  load: [150 N, 300 N]
"""
DESIGN = STUDY[: STUDY.index("sweep:")] + (
    "sweep: {sobol: {n: 8, over: {defect.length: [3 mm, 9 mm]}}, load: [150 N, 300 N]}\n"
)
OFFSET = 2.0  # m/s2, mean of the acceleration
START = -0.2  # rad, angle of roller 1 at time zero
PASS = 1.0 / BPFO


def record_of(case):
    """Sines at BPFO, 4 kHz and 8 kHz (modulated) with a mean; half the amplitude in the healthy bearing."""
    time = np.arange(round(case.duration * case.sampling)) / case.sampling
    amplitude = 1.0 if case.defects else 0.5
    passes, low, high = (2.0 * math.pi * hertz * time for hertz in (BPFO, 4000.0, 8000.0))
    sines = np.sin(passes) + 0.1 * np.sin(low) + 0.2 * (1.0 + np.cos(passes)) * np.sin(high)
    signal = OFFSET + amplitude * sines
    names = [name for channel in case.record for name in dataset_names(channel)]
    series = {name: signal if name.endswith((".x", "force")) else 0.0 * signal for name in names}
    features = {"velocity@BPFO": 1e-6 * amplitude, "velocity@BPFO.phase": 0.1, "velocity.rms": 1e-5 * amplitude,
                "acceleration.peak": amplitude}  # fmt: skip
    info = {"cpu_s": 0.1, "cage_angle_start_rad": START}
    return SimpleNamespace(time=time, series=series, features=features, info=info)


@pytest.fixture
def make_results(results, monkeypatch):
    monkeypatch.setattr("tests.scenes.figure_results.record", record_of)
    return lambda text=STUDY, **options: results(text, **options)
