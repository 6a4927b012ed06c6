"""Signals of impacts that repeat, as a sensor behind a resonance records them."""

import numpy as np

from bearingsim.diagnosis import Lines
from bearingsim.study import load_rolling_parts

RATE = 12800.0
SHAFT = 25.0  # Hz
PARTS = load_rolling_parts("6205")
LINES = Lines.of(PARTS, SHAFT)


def impacts(rhythm, modulation=0.0, seconds=4.0, noise=0.3, seed=0, slip=0.0, resonance=3000.0):
    """Impacts (n,) at the rate `rhythm` (Hz), modulated by `modulation` (Hz), with a resonance and noise."""
    rng = np.random.default_rng(seed)
    t = np.arange(int(seconds * RATE)) / RATE
    pulses = np.zeros(len(t))
    steps = (1.0 + slip * rng.standard_normal(int(1.1 * seconds * rhythm))) / rhythm
    instants = np.cumsum(steps)
    instants = instants[instants < t[-1]]
    pulses[(instants * RATE).astype(int)] = 1.0 + 0.9 * np.cos(2.0 * np.pi * modulation * instants) * bool(
        modulation
    )
    ring = np.exp(-2.0 * np.pi * 0.03 * resonance * t) * np.sin(2.0 * np.pi * resonance * t)
    signal = np.fft.irfft(np.fft.rfft(pulses, 2 * len(t)) * np.fft.rfft(ring, 2 * len(t)))[: len(t)]
    return signal + noise * signal.std() * rng.standard_normal(len(t))
