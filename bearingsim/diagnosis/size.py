"""Width of an outer-race defect, estimated from the time between a roller's entry and exit."""

from collections.abc import Mapping
from math import cos, pi, sqrt
from typing import NamedTuple

import numpy as np

from bearingsim.config.sections.machine import RollingParts
from bearingsim.diagnosis.envelopes import default_band
from bearingsim.signals.events import SMOOTHING_RATIO, measure_spacing
from bearingsim.signals.spectra import band_pass

MAX_DEPTH = 60e-6
"""m; largest assumed depth of the floor. A roller on the floor strikes the far edge before the end of the defect
(docs/double_impulse.md, step 4)."""
WIDTH_CONDITION = f"the acceleration is along the load and the depth up to {1e6 * MAX_DEPTH:g} um"
"""Condition of every width: a signal across the load may have two events of other causes."""
APPROACH = {"ball": 3e-3, "roller": 1e-3}
"""Largest elastic approach of the races at a rolling element, over its diameter. An element that drops this far
behind the near edge has lost its contact force, at which its entry is detected. At a given contact pressure the
approach is proportional to the diameter. A ball of the 6205 reaches it (24 um) at a tenth of the dynamic load
rating."""
MAX_HALVES_DIFFERENCE = 0.05
"""Largest relative difference between the estimates from both halves of a record."""
MAX_RMS_RATIO = 3.0
"""Largest RMS of another channel, relative to that of the channel in which a width is estimated: the vibration of
a defect is 10 to 100 times weaker across the load than along it, and 1.4 times at 45 deg."""


class Size(NamedTuple):
    """Bounds (m) of the width of a defect along the outer race, and the time (s) from entry to exit."""

    low: float
    high: float
    spacing: float


def estimate_outer_race_size(series: np.ndarray, fs: float, parts: RollingParts, bpfo: float) -> Size | str:
    """Estimate the width of an outer-race defect from a series (n,) at ``fs`` (Hz); bpfo: measured BPFO (Hz).

    Let s be the time from entry to exit times the speed of the contact point. The lower bound of the width is s
    less half the width of the smoothing, because a roller in the air lands beyond the far edge. The upper bound is
    s + sqrt(2 R_eff d) + sqrt(2 R_eff a): a roller on the floor, at a depth d of up to 60 um, strikes the far edge
    by the first root before the end of the defect, and its entry is detected up to the second root late, after a
    drop a of up to ``APPROACH``. Returns the reason instead if an entry and an exit are not the only events of a
    pass, if a pass has fewer than 40 samples, or if the estimates from both halves of the record differ by over
    5 %.
    """
    period = 1.0 / bpfo
    half = len(series) // 2
    try:
        spacings = [measure_spacing(part, fs, period) for part in (series, series[:half], series[half:])]
    except ValueError:
        return "a pass has fewer than 40 samples"
    for estimate in spacings:
        if estimate.reason:
            return estimate.reason
    whole, *halves = (estimate.time for estimate in spacings)
    if abs(halves[0] - halves[1]) > MAX_HALVES_DIFFERENCE * whole:
        return f"the estimates from both halves of the record differ by over {100.0 * MAX_HALVES_DIFFERENCE:g} %"
    R_w, cosine = parts.roller_diameter / 2.0, cos(parts.contact_angle)
    track_radius = parts.pitch_diameter / 2.0 + R_w * cosine  # of the circle of contact points
    speed = 2.0 * pi * track_radius * bpfo / parts.rollers
    R_race = track_radius / cosine  # radius of curvature along the track, normal to the race (Meusnier)
    R_eff = R_w * R_race / (R_race - R_w)
    drop = APPROACH[parts.element] * parts.roller_diameter
    low, high = (whole - 0.5 * period / SMOOTHING_RATIO) * speed, whole * speed
    return Size(low, high + sqrt(2.0 * R_eff * MAX_DEPTH) + sqrt(2.0 * R_eff * drop), whole)


def size_remark(size: Size | str | None) -> str | None:
    """Return a remark with the width and its condition, or with the reason why there is none; None for None."""
    if isinstance(size, Size):
        width = f"{1e3 * size.low:.2f} to {1e3 * size.high:.2f} mm"
        return f"width along the race: {width} if {WIDTH_CONDITION} (entry to exit {1e3 * size.spacing:.3g} ms)"
    return None if size is None else f"no width is estimated: {size}"


def json_entries(size: Size | str | None) -> dict[str, list[float] | float | str | None]:
    """Return the entries of `--json`: width (mm), its condition, time (ms) from entry to exit; or the reason."""
    if isinstance(size, Size):
        width, spacing, reason = [1e3 * size.low, 1e3 * size.high], 1e3 * size.spacing, None
    else:
        width, spacing, reason = None, None, size
    return {
        "width_mm": width,
        "width_condition": WIDTH_CONDITION if width else None,
        "width_missing": reason,
        "spacing_ms": spacing,
    }


def refuse_width_across_load(
    size: Size | str | None, name: str, channels: Mapping[str, np.ndarray], fs: float
) -> Size | str | None:
    """Return the size estimated from a channel, or a reason against it if another one vibrates more strongly.

    name: name of the channel; channels: series (n,) of one unit at ``fs`` (Hz), by name.
    """
    stronger = find_stronger_channel(name, channels, fs) if isinstance(size, Size) else None
    if stronger is None:
        return size
    return f"`{stronger}` vibrates over {MAX_RMS_RATIO:g} times as strongly, so this channel is not along the load"


def find_stronger_channel(name: str, channels: Mapping[str, np.ndarray], fs: float) -> str | None:
    """Return the strongest channel if it vibrates so much more strongly that a channel is not along the load.

    name: name of the channel; channels: series (n,) of one unit at ``fs`` (Hz), by name. None unless the RMS above
    1 kHz of the strongest channel exceeds ``MAX_RMS_RATIO`` times that of the channel.
    """
    levels = {key: float(np.std(band_pass(series, fs, default_band(fs)))) for key, series in channels.items()}
    strongest = max(levels, key=lambda key: levels[key])
    return strongest if levels[strongest] > MAX_RMS_RATIO * levels[name] else None
