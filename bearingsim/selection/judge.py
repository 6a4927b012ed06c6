"""How far one trial is from another in what is asked, and how surely that is known.

A line's amplitude A = |sum_p a_p| and its twin's are sums over ball passes. Along their own phases the passes add
up to the value that is drawn, so what two models differ by is a sum over passes, too, d = sum_p d_p. How it
scatters is seen between blocks of passes, each a turn of the slowest pit: a motion that is no chaos has none.

    error = |d| + t s,   s^2 = B/(B - 1) sum_b (d_b - w_b d)^2

with B blocks, w_b the share of a block in the sum, and t Student's at 97.5 % with B - 1 degrees of freedom.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

from bearingsim.simulation.trial import Trial
from bearingsim.study.goal import HEALTHY

SURE = 0.975


class Value(NamedTuple):
    """A feature as a trial has it: its value (SI), what each ball pass adds to it, and the share of each."""

    value: float
    parts: np.ndarray
    shares: np.ndarray


def value(feature: str, found: Trial, twin: Trial | None) -> Value:
    """A feature (SI) of a trial, against its healthy twin if it is measured so."""
    even = np.full(found.passes, 1.0 / found.passes)
    if feature == "outer_force.max":
        return Value(float(found.forces.max()), found.forces, even)
    if feature in found.powers:
        rms = float(np.sqrt(found.powers[feature].mean()))
        return Value(rms, 0.5 * found.powers[feature] * even / (rms or 1.0), even)
    line = feature.removesuffix(HEALTHY)
    parts = found.lines[line] - (twin.lines[line] if feature != line and twin is not None else 0.0)
    total = parts.sum()
    hann = np.hanning(2 * found.passes + 1)[1::2]
    return Value(float(abs(total)), (parts * np.exp(-1j * np.angle(total))).real, hann / hann.sum())


def error(feature: str, one: Value, other: Value, turns: float) -> float:
    """What the first is surely no further off from the second than (SI); ``turns``: passes of a pit's turn."""
    difference = one.parts - other.parts
    blocks = np.array_split(difference, max(1, int(len(difference) / max(1.0, turns))))
    apart = abs(one.value - other.value)
    if len(blocks) < 2:
        return float("inf") if turns > 1.0 else apart
    t = float(stdtrit(len(blocks) - 1.0, SURE))
    if feature == "outer_force.max":
        return apart + t * float(np.std([block.max() for block in blocks], ddof=1))
    weights = [block.sum() for block in np.array_split(one.shares, len(blocks))]
    left = np.array([block.sum() for block in blocks]) - np.array(weights) * difference.sum()
    return apart + t * float(np.sqrt(len(blocks) / (len(blocks) - 1.0) * np.sum(left**2)))
