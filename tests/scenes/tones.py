"""Frequencies and angles of tones with known lines."""

import numpy as np

FS = 10240.0
BPFO, SPIN = 159.0, 156.9616  # Hz, of the NF308 at 1800 rpm; twice the spin of a roller


def varying_angle(t: np.ndarray, frequency: float, share: float, rate: float) -> np.ndarray:
    """Return the angle (rad) of a line whose frequency varies by a share at a rate (Hz)."""
    return 2 * np.pi * frequency * (t - share * np.cos(2 * np.pi * rate * t) / (2 * np.pi * rate)) + 0.3
