"""Width of a defect of the outer race from the time between a roller's entry and exit."""

from math import cos, isfinite, pi, sqrt
from typing import NamedTuple

import numpy as np

from bearingsim.config.sections.machine import RollingParts
from bearingsim.signals.events import spacing

DEPTH = 60e-6
"""m; largest floor depth assumed for early strikes of the far edge (docs/double_impulse.md, step 4)."""
ENTRY_DROP = 1.5e-6
"""m; drop behind the near rim at which the entry is detected: a ball of the 6205 has lost half of its force after
0.12 mm (docs/double_impulse.md, step 1)."""
MAX_DIFFERENCE = 0.05
"""Largest relative difference between the estimates from both halves of a record."""


class Size(NamedTuple):
    """Interval (m) of the width of a defect along the outer race, and the spacing (s) of entry and exit."""

    low: float
    high: float
    spacing: float


def outer_race_size(series: np.ndarray, fs: float, parts: RollingParts, outer: float) -> Size | None:
    """Estimate the width of an outer-race defect from a series (n,) at ``fs`` (Hz); outer: measured BPFO (Hz).

    With s the spacing of entry and exit times the speed of the contact point, the width is from s to s + sqrt(2
    R_eff d) + sqrt(2 R_eff a). A roller on the floor, at a depth d of up to 60 um, strikes the far edge the first
    root earlier. The entry is detected the second root late, after a drop a of up to 1.5 um. Returns None without
    two events, or if the estimates from both halves of the record differ by over 5 %.
    """
    period = 1.0 / outer
    half = len(series) // 2
    try:
        whole, *halves = (spacing(part, fs, period) for part in (series, series[:half], series[half:]))
    except ValueError:  # fewer than 40 samples in a pass
        return None
    if not all(map(isfinite, (whole, *halves))) or abs(halves[0] - halves[1]) > MAX_DIFFERENCE * whole:
        return None
    roller, cosine = parts.roller_diameter / 2.0, cos(parts.contact_angle)
    track = parts.pitch_diameter / 2.0 + roller * cosine  # radius of the circle of contact points
    low = whole * 2.0 * pi * track * outer / parts.rollers
    race = track / cosine  # radius of curvature along the track, normal to the race (Meusnier)
    effective = roller * race / (race - roller)
    return Size(low, low + sqrt(2.0 * effective * DEPTH) + sqrt(2.0 * effective * ENTRY_DROP), whole)
