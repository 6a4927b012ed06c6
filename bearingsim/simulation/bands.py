"""Features of a band: an RMS, or a line of the acceleration's squared envelope, from fine samples.

Fine samples are not low-passed, so these features do not depend on `sampling`; the fine rate leaves the band
unattenuated (``time_grid.grid``).
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
    """Return the band features of a case over the whole ball passes of its record; NaN if it holds none."""
    requested = {name: feature for name in case.features if (feature := of_band(name)) is not None}
    of_record = windows(case, cut, raw, reach=0)
    start, count = of_record.start, len(of_record.index) * of_record.M
    if not requested or not count:
        return dict.fromkeys(requested, nan)
    series = {f.quantity: sensed(case, raw, f.quantity, start, count) for f in requested.values()}
    angles = angles_of_record(case, model, cut, raw, start, count)
    values = {}
    for name, feature in requested.items():
        cpu_time.check()
        of, band = series[feature.quantity], band_of(case, feature)
        if not resolves(band, count / cut.fine_rate):
            values[name] = nan
        elif feature.line:
            values[name] = _envelope_line(case, feature, band, of, cut.fine_rate, angles)
        else:
            values[name] = signals.band_rms(of, cut.fine_rate, band)
    return values


def band_of(case: Case, feature: BandFeature) -> Band:
    """Return the band of a feature; of an envelope without one, the flat band of `sampling`."""
    return feature.band or Band(0.0, FLAT * case.sampling)


def resolves(band: Band, duration: float) -> bool:
    """Check if a record of ``duration`` (s) holds a period of a band's lowest frequency and of its width."""
    return (band.low == 0.0 or band.low * duration >= 1.0) and (band.high - band.low) * duration >= 1.0


def _envelope_line(
    case: Case, feature: BandFeature, band: Band, series: np.ndarray, fs: float, angles: SampleAngles
) -> float:
    """Return the amplitude of a line of the squared envelope; NaN if band or record do not resolve it."""
    Z, name, duration = case.bearing.rollers, feature.line, (len(series) - 1) / fs
    ends = np.array([angles.ends().along(line, Z) for line in LINES.values()])
    frequencies = (ends[:, 1] - ends[:, 0]) / (2.0 * pi * duration)
    resolved = zip(frequencies, signals.resolvable(frequencies, duration), strict=True)
    frequency, is_resolved = dict(zip(LINES, resolved, strict=True))[name]
    if not (is_resolved or LINES[name].outer) or not 0.0 < frequency < band.high - band.low:
        return nan
    angle = angles.along(LINES[name], Z)
    return float(abs(signals.line_at(signals.squared_envelope(series, fs, band), angle)))
