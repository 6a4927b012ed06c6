"""Width of a defect of the outer race from the time between a roller's entry and exit."""

from collections.abc import Mapping
from math import cos, pi, sqrt
from typing import NamedTuple

import numpy as np

from bearingsim.config.sections.machine import RollingParts
from bearingsim.diagnosis.envelopes import default_band
from bearingsim.signals.events import SMOOTHING_RATIO, measure_spacing
from bearingsim.signals.spectra import band_pass

DEPTH = 60e-6
"""m; largest floor depth assumed for early strikes of the far edge (docs/double_impulse.md, step 4)."""
CONDITION = f"the acceleration is along the load and the depth up to {1e6 * DEPTH:g} um"
"""Condition of every stated width: a signal across the load may have two events of other causes."""
APPROACH = {"ball": 3e-3, "roller": 1e-3}
"""Largest approach of the races to each other at a rolling element, over its diameter: after this drop behind the
near rim the element has lost all its force, and its entry is detected. At a given contact pressure it is
proportional to the diameter. A ball of the 6205 reaches it (24 um) at a tenth of the dynamic load rating."""
MAX_DIFFERENCE = 0.05
"""Largest relative difference between the estimates from both halves of a record."""
MAX_STRONGER = 3.0
"""Largest RMS of another channel relative to that of the channel of a width: across the load the vibration of a
defect is 10 to 100 times weaker than along it, at 45 deg 1.4 times."""


class Size(NamedTuple):
    """Interval (m) of the width of a defect along the outer race, and the spacing (s) of entry and exit."""

    low: float
    high: float
    spacing: float


def outer_race_size(series: np.ndarray, fs: float, parts: RollingParts, outer: float) -> Size | str:
    """Estimate the width of an outer-race defect from a series (n,) at ``fs`` (Hz); outer: measured BPFO (Hz).

    With s the spacing of entry and exit times the speed of the contact point, the width is from s, less half
    the width of the smoothing, to s + sqrt(2 R_eff d) + sqrt(2 R_eff a). A roller in the air lands beyond the far
    edge. One on the floor, at a depth d of up to 60 um, strikes it the first root before the defect's end. The
    entry is detected up to the second root late, after a drop a of up to the ``APPROACH``. Returns the reason if
    an entry and an exit are not the only events of a pass, or if the estimates from both halves of the record
    differ by over 5 %.
    """
    period = 1.0 / outer
    half = len(series) // 2
    try:
        spacings = [measure_spacing(part, fs, period) for part in (series, series[:half], series[half:])]
    except ValueError:
        return "a pass has fewer than 40 samples"
    for estimate in spacings:
        if estimate.reason:
            return estimate.reason
    whole, *halves = (estimate.time for estimate in spacings)
    if abs(halves[0] - halves[1]) > MAX_DIFFERENCE * whole:
        return f"the estimates from both halves of the record differ by over {100.0 * MAX_DIFFERENCE:g} %"
    roller, cosine = parts.roller_diameter / 2.0, cos(parts.contact_angle)
    track = parts.pitch_diameter / 2.0 + roller * cosine  # radius of the circle of contact points
    speed = 2.0 * pi * track * outer / parts.rollers
    race = track / cosine  # radius of curvature along the track, normal to the race (Meusnier)
    effective = roller * race / (race - roller)
    drop = APPROACH[parts.element] * parts.roller_diameter
    low, high = (whole - 0.5 * period / SMOOTHING_RATIO) * speed, whole * speed
    return Size(low, high + sqrt(2.0 * effective * DEPTH) + sqrt(2.0 * effective * drop), whole)


def remark(size: Size | str | None) -> str | None:
    """Return the sentence that states a width with its condition, or why there is none; None without either."""
    if isinstance(size, Size):
        width = f"{1e3 * size.low:.2f} to {1e3 * size.high:.2f} mm"
        return f"width along the race: {width} if {CONDITION} (entry to exit {1e3 * size.spacing:.3g} ms)"
    return None if size is None else f"no width is estimated: {size}"


def values_of(size: Size | str | None) -> dict[str, list[float] | float | str | None]:
    """Return the values of `--json`: width (mm) and its condition, or the reason why there is none."""
    if isinstance(size, Size):
        width, spacing, reason = [1e3 * size.low, 1e3 * size.high], 1e3 * size.spacing, None
    else:
        width, spacing, reason = None, None, size
    return {
        "width_mm": width,
        "width_condition": CONDITION if width else None,
        "width_missing": reason,
        "spacing_ms": spacing,
    }


def without_width_across(
    size: Size | str | None, name: str, channels: Mapping[str, np.ndarray], fs: float
) -> Size | str | None:
    """Return the size of a channel, or the reason if another one vibrates much more strongly.

    channels: series (n,) of one unit at ``fs`` (Hz), by name.
    """
    stronger = stronger_channel(name, channels, fs) if isinstance(size, Size) else None
    if stronger is None:
        return size
    return f"`{stronger}` vibrates over {MAX_STRONGER:g} times as strongly, so this channel is not along the load"


def stronger_channel(name: str, channels: Mapping[str, np.ndarray], fs: float) -> str | None:
    """Return the channel in whose vibration that of a channel is weak, so that it is not along the load.

    channels: series (n,) of one unit at ``fs`` (Hz), by name. None if none exceeds its RMS above 1 kHz
    ``MAX_STRONGER`` times.
    """
    levels = {key: float(np.std(band_pass(series, fs, default_band(fs)))) for key, series in channels.items()}
    strongest = max(levels, key=lambda key: levels[key])
    return strongest if levels[strongest] > MAX_STRONGER * levels[name] else None
