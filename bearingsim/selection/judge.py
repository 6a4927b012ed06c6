"""How far one trial is from another in what is asked, and how surely that is known.

A line's amplitude, and the square of an RMS, are means under a window. Their difference d between two models is
one, too. How it scatters is seen between pairs of turns of the slowest pit: a motion that is no chaos has none.

    error = |d| + t s,   s^2 = 2/N var(d_w)

over W = N - 1 pairs of the N turns, t Student's at 97.5 % with W - 1 degrees of freedom. (Under Hann's window a
mean over N turns has 2/N of the variance of one over two turns.) Of the largest force, d is that of each turn.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

from bearingsim.config.names import of_band
from bearingsim.simulation.trial import LARGEST_FORCE, Trial
from bearingsim.study.goal import HEALTHY

SURE = 0.975


class Value(NamedTuple):
    """A feature as a trial has it: its value (SI), what it is in each part, and the share of one part's variance
    that the whole has.
    """

    value: float
    parts: np.ndarray
    share: float


def value(feature: str, found: Trial, twin: Trial | None) -> Value:
    """A feature (SI) of a trial, against its healthy twin if it is measured so."""
    if feature == LARGEST_FORCE:
        turns = np.array_split(found.forces, found.turns)
        return Value(float(found.forces.max()), np.array([turn.max() for turn in turns]), 1.0)
    share = 2.0 / found.turns
    line = feature.removesuffix(HEALTHY)
    if of_band(line) is not None and feature != line and twin is not None:  # magnitudes are subtracted
        own, healthy = value(line, found, None), value(line, twin, None)
        return Value(own.value - healthy.value, own.parts - healthy.parts, share)
    if line in found.powers:
        rms = float(np.sqrt(found.powers[line][0]))
        return Value(rms, 0.5 * found.powers[line][1:] / (rms or 1.0), share)
    amplitudes = found.lines[line] - (twin.lines[line] if feature != line and twin is not None else 0.0)
    parts = amplitudes[1:] * np.exp(-1j * np.angle(amplitudes[0]))
    return Value(float(abs(amplitudes[0])), parts.real, share)


def error(one: Value, other: Value) -> float:
    """What the first is surely no further off from the second than (SI); infinite if too little is seen of it."""
    if len(one.parts) < 2 or len(one.parts) != len(other.parts):
        return float("inf")  # how they scatter is not seen
    apart, parts = abs(one.value - other.value), one.parts - other.parts
    t = float(stdtrit(len(parts) - 1.0, SURE))
    return apart + t * float(np.sqrt(one.share) * np.std(parts, ddof=1))
