"""From a simulated acceleration to a signal as a sensor on a machine records it, drawn from a seed.

Slip (period 0.5 % shorter to 1.5 % longer than kinematic, spacing of the passes a random walk of 0 to 1.5 %), a
structure resonance (2 to 6 kHz, damping 1 to 5 %) as transfer path, noise of 1/f^a (a from 0 to 1) with one to
three humps, in half of the signals one at the resonance, and in half of the signals confounders: shaft orders 1
to 4, mains, a gear mesh modulated by the shaft, broadband noise modulated by the shaft and by a motor (twice its
supply's frequency, with harmonics and sidebands of its slip), and random knocks.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.diagnosis import bases

OFFSET = -0.015, 0.005  # range of the relative deviation of the rate
MAX_WALK = 0.015  # largest standard deviation of a pass's spacing, relative
UPSAMPLING = 4  # before a series is read at warped instants
SHAFT_HZ = bases.RPM / 60.0


class Twins(NamedTuple):
    """Acceleration (n,) of a healthy bearing, and what a defect adds to it (m,), both m/s^2."""

    setting: bases.Setting
    defect: bases.Defect
    healthy: np.ndarray
    fault: np.ndarray


class Sample(NamedTuple):
    """Signal (n,) at ``bases.RATE``, and what made it: bearing, defect or None, SNR (dB), deviation of rate."""

    signal: np.ndarray
    setting: bases.Setting
    defect: bases.Defect | None
    snr: float
    offset: float
    confounded: bool


def all_twins(folder: Path) -> list[Twins]:
    """Load the runs of all settings and defects, and simulate those that are missing."""
    twins = []
    for setting in bases.settings():
        healthy = bases.stored(folder, setting, None)
        for defect in bases.defects():
            damaged = bases.stored(folder, setting, defect)
            twins.append(Twins(setting, defect, healthy, damaged - healthy[: len(damaged)]))
    return twins


def sample(twins: Twins, seed: int, snr: float | None, damaged: bool, seconds: float = bases.SECONDS) -> Sample:
    """Draw a signal; snr: power of the fault over the noise after the path (dB), None: from -20 to 20 dB."""
    rng = np.random.default_rng(seed)
    level = rng.uniform(-20.0, 20.0) if snr is None else snr
    offset, walk = rng.uniform(*OFFSET), rng.uniform(0.0, MAX_WALK)
    resonance, damping = rng.uniform(2000.0, 6000.0), rng.uniform(0.01, 0.05)
    n = round(seconds * bases.RATE)
    instants = warped(n, bases.RATE / bases.lines(twins.setting.bearing).outer, offset, walk, rng)
    power = through(twins.fault, resonance, damping).var()
    bearing = twins.healthy + twins.fault if damaged else twins.healthy
    background = noise(n, resonance, rng)
    confounded = bool(rng.integers(2))
    if confounded:
        background = _confounded(background, rng)
    background *= np.sqrt(power / 10.0 ** (level / 10.0)) / background.std()
    signal = through(read(bearing, instants), resonance, damping) + background
    return Sample(signal, twins.setting, twins.defect if damaged else None, level, offset, confounded)


def warped(n: int, pass_samples: float, offset: float, walk: float, rng: np.random.Generator) -> np.ndarray:
    """Return the instants (n,) of the simulation, in samples, that a slipping bearing has reached.

    pass_samples: samples of a pass without slip.
    """
    count = int(1.1 * n / pass_samples) + 2
    borders = np.cumsum(pass_samples / (1.0 + offset) * np.maximum(1.0 + walk * rng.standard_normal(count), 0.5))
    borders = np.concatenate([[0.0], borders])
    return np.interp(np.arange(n), borders, pass_samples * np.arange(count + 1))


def read(series: np.ndarray, instants: np.ndarray) -> np.ndarray:
    """Return a series at instants (samples), which begins anew where it is too short."""
    fine = np.fft.irfft(np.fft.rfft(series), UPSAMPLING * len(series)) * UPSAMPLING
    return np.interp(UPSAMPLING * np.mod(instants, len(series) - 1), np.arange(len(fine)), fine)


def through(series: np.ndarray, resonance: float, damping: float) -> np.ndarray:
    """Filter a series by a resonance (Hz) of one degree of freedom."""
    ratio = np.fft.rfftfreq(len(series), 1.0 / bases.RATE) / resonance
    return np.fft.irfft(np.fft.rfft(series) / (1.0 - ratio**2 + 2j * damping * ratio), len(series))


def noise(n: int, resonance: float, rng: np.random.Generator) -> np.ndarray:
    """Draw noise (n,) of 1/f^a with one to three humps."""
    frequency = np.fft.rfftfreq(n, 1.0 / bases.RATE)
    power = np.maximum(frequency, 5.0) ** -rng.uniform(0.0, 1.0)
    centres = rng.uniform(300.0, 9000.0, rng.integers(1, 4))
    if rng.integers(2):
        centres[0] = resonance
    for centre in centres:
        width, gain = rng.uniform(0.02, 0.15) * centre, 10.0 ** rng.uniform(0.5, 2.0)
        level = np.interp(centre, frequency, power)
        power += gain * level * np.exp(-0.5 * ((frequency - centre) / width) ** 2)
    draws = rng.standard_normal((2, len(frequency)))
    series = np.fft.irfft(np.sqrt(power) * (draws[0] + 1j * draws[1]), n)
    return series / series.std()


def _confounded(noise: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Add what other parts of a machine contribute; levels are relative to the noise's RMS of 1."""
    t = np.arange(len(noise)) / bases.RATE
    shaft = 2.0 * np.pi * SHAFT_HZ * t
    signal = noise * (1.0 + rng.uniform(0.1, 0.6) * np.cos(shaft + rng.uniform(0.0, 2.0 * np.pi)))
    if rng.integers(4) == 0:
        signal *= _motor(t, rng)
    for order in range(1, 5):
        signal += rng.uniform(0.05, 1.0) * np.cos(order * shaft + rng.uniform(0.0, 2.0 * np.pi))
    mains = rng.choice([50.0, 60.0])
    for harmonic in (1, 2, 4, 6):
        signal += rng.uniform(0.02, 0.4) * np.cos(
            2.0 * np.pi * harmonic * mains * t + rng.uniform(0.0, 2.0 * np.pi)
        )
    teeth = rng.integers(17, 60)
    modulation = 1.0 + rng.uniform(0.1, 0.6) * np.cos(shaft + rng.uniform(0.0, 2.0 * np.pi))
    for harmonic in (1, 2, 3):
        tone = np.cos(harmonic * teeth * shaft + rng.uniform(0.0, 2.0 * np.pi))
        signal += rng.uniform(0.05, 0.6) * modulation * tone
    return signal + _knocks(t, rng)


def _motor(t: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Draw the modulation (n,) by a motor: twice the supply's frequency, its harmonics, and sidebands of the
    slip."""
    supply, slip = rng.choice([50.0, 60.0, rng.uniform(20.0, 60.0)]), rng.uniform(0.5, 6.0)
    modulation = np.ones(len(t))
    for harmonic in range(1, 5):
        for side in range(-2, 3):
            frequency, depth = (
                2.0 * harmonic * supply + side * slip,
                rng.uniform(0.0, 0.3) / (harmonic + abs(side)),
            )
            modulation += depth * np.cos(2.0 * np.pi * frequency * t + rng.uniform(0.0, 2.0 * np.pi))
    return modulation


def _knocks(t: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Draw random knocks that ring at a resonance."""
    count = rng.poisson(rng.uniform(0.5, 5.0) * t[-1])
    pulses = np.zeros(len(t))
    pulses[rng.integers(0, len(t), count)] = rng.uniform(2.0, 10.0) * rng.exponential(1.0, count)
    resonance, damping = rng.uniform(1000.0, 8000.0), rng.uniform(0.01, 0.05)
    ring = np.exp(-2.0 * np.pi * damping * resonance * t) * np.sin(2.0 * np.pi * resonance * t)
    return np.fft.irfft(np.fft.rfft(pulses) * np.fft.rfft(ring), len(t))
