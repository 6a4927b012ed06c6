"""Features of a band: an RMS, or a line of the acceleration's squared envelope, from fine samples.

These are all that was computed, so that they do not depend on `sampling` and its low-pass; the fine rate is such
that a band is let through as it is (``time_grid.grid``).
"""

from math import nan, pi
from typing import Any

import numpy as np

from bearingsim import cpu_time, signals
from bearingsim.config import Case
from bearingsim.config.bands import FLAT, Band, BandFeature
from bearingsim.config.names import LINES, of_band
from bearingsim.simulation.features import SampleAngles, angles_of_record, sensed
from bearingsim.simulation.raw_record import RawRecord
from bearingsim.simulation.record_windows import windows
from bearingsim.simulation.time_grid import Grid


def band_features(case: Case, model: Any, cut: Grid, raw: RawRecord) -> dict[str, float]:
    """Return the features that a case names, over the whole ball passes of its record; nan if it holds none."""
    asked = {name: feature for name in case.features if (feature := of_band(name)) is not None}
    of_record = windows(case, cut, raw, reach=0)
    start, count = of_record.start, len(of_record.index) * of_record.M
    if not asked or not count:
        return dict.fromkeys(asked, nan)
    series = {f.quantity: sensed(case, raw, f.quantity, start, count) for f in asked.values()}
    angles = angles_of_record(case, model, cut, raw, start, count)
    found = {}
    for name, feature in asked.items():
        cpu_time.check()
        of, band = series[feature.quantity], band_of(case, feature)
        if not resolves(band, count / cut.fine_rate):
            found[name] = nan
        elif feature.line:
            found[name] = _envelope_line(case, feature, band, of, cut.fine_rate, angles)
        else:
            found[name] = signals.band_rms(of, cut.fine_rate, band)
    return found


def band_of(case: Case, feature: BandFeature) -> Band:
    """Return the band of a feature: its own, or of an envelope without one what `sampling` shows."""
    return feature.band or Band(0.0, FLAT * case.sampling)


def resolves(band: Band, duration: float) -> bool:
    """Tell whether a record of ``duration`` (s) holds a period of a band's lowest frequency and of its width."""
    return (band.low == 0.0 or band.low * duration >= 1.0) and (band.high - band.low) * duration >= 1.0


def _envelope_line(
    case: Case, feature: BandFeature, band: Band, series: np.ndarray, fs: float, angles: SampleAngles
) -> float:
    """Return amplitude of a line of the squared envelope; nan where band or record do not tell it from others."""
    Z, name, duration = case.bearing.rollers, feature.line, (len(series) - 1) / fs
    ends = np.array([angles.ends().along(line, Z) for line in LINES.values()])
    frequencies = (ends[:, 1] - ends[:, 0]) / (2.0 * pi * duration)
    known = dict(zip(LINES, zip(frequencies, signals.resolvable(frequencies, duration), strict=True), strict=True))
    frequency, is_told = known[name]
    if not (is_told or LINES[name].outer) or not 0.0 < frequency < band.high - band.low:
        return nan
    angle = angles.along(LINES[name], Z)
    return float(abs(signals.line_at(signals.squared_envelope(series, fs, band), angle)))
