"""Features of a run: lines, statistics, largest values, load zone, cage slip, bands, and those of other packages.

Band features are computed from fine samples, which are not low-passed, so they do not depend on `sampling`. The
fine rate is high enough to leave the bands unattenuated (``time_grid.make_grid``).
"""

from collections.abc import Callable, Iterable, Mapping
from math import ceil, floor, isfinite, nan, pi
from numbers import Real
from typing import Any

import numpy as np

from bearingsim import cpu_time, signals
from bearingsim.catalogue import FEATURES, MODELS, Feature, call
from bearingsim.config import FEATURES as DECLARED
from bearingsim.config import Case
from bearingsim.config.bands import PASSBAND, Band, BandFeature
from bearingsim.config.names import LINES, NO_VALUE, read_band
from bearingsim.core import layout as lay
from bearingsim.core.geometry.motion import speed_factor
from bearingsim.errors import UserError
from bearingsim.extensions import BrokenExtension
from bearingsim.simulation.channels import CAGE_SPEED, MOTION
from bearingsim.simulation.recording import RawRecord, pass_segments
from bearingsim.simulation.repetition import EXTREMES
from bearingsim.simulation.spectral_lines import (
    ROW_OF,
    SampleAngles,
    angles_of_record,
    ball_pass_lines,
    block_ranges,
    other_lines,
    sensor_samples,
    sensor_series,
)
from bearingsim.simulation.time_grid import Grid


def compute_features(
    case: Case, model: Any, grid: Grid, raw: RawRecord, pass_amplitudes: Mapping[str, np.ndarray]
) -> dict[str, float]:
    """Compute all features of a run except those of bands and of other packages.

    pass_amplitudes: result of ``amplitudes_by_pass``.
    """
    return {
        **ball_pass_lines(case, pass_amplitudes),
        **other_lines(case, model, grid, raw),
        **compute_statistics(case, grid, raw),
        **find_extremes(case, grid, raw),
        **compute_cage_and_load_zone(case, model, grid, raw),
    }


def compute_statistics(case: Case, grid: Grid, raw: RawRecord) -> dict[str, float]:
    """Compute RMS, peak, crest factor and kurtosis along the sensor, over the whole ball passes of the record.

    The low-passed motion at fine samples is used, so peaks between two samples of the record are included. A raw
    record (`antialias: false`) is evaluated at its own samples.
    """
    motion = _low_passed_motion(case, grid, raw) if case.antialias else _raw_motion(case, grid, raw)
    return {
        f"{quantity}.{name}": value
        for quantity in MOTION
        for name, value in signals.statistics(*motion(quantity)).items()
    }


Motion = Callable[[str], tuple[np.ndarray, np.ndarray | None]]
"""Function that returns values (n,) of a quantity along the sensor and their multiplicities (None: all 1)."""


def _raw_motion(case: Case, grid: Grid, raw: RawRecord) -> Motion:
    """Return the motion along the sensor at the samples of the record, unfiltered."""
    passes = len(pass_segments(case, grid, raw, margin=0).index)
    raw_values = raw.raw_values[:, : round(passes / grid.rate * case.sampling)]
    return lambda quantity: (sensor_series(case, raw_values, quantity), None)


def _low_passed_motion(case: Case, grid: Grid, raw: RawRecord) -> Motion:
    """Return the low-passed motion along the sensor over the distinct passes of the record."""
    segments, filtered = pass_segments(case, grid, raw, margin=raw.half_length), raw.low_passed
    count, weights = segments.distinct * segments.M, segments.weights
    multiplicities = np.repeat(weights, segments.M) if np.any(weights > 1) else None
    return lambda quantity: (sensor_samples(case, filtered, quantity, segments.start, count), multiplicities)


def find_extremes(case: Case, grid: Grid, raw: RawRecord) -> dict[str, float]:
    """Find the largest force (N), tilt (rad) and line load (N/m) of any roller in the whole passes of the record.

    If the record has no whole pass, the first pass to begin at or after its start is used. Quantities that the
    model does not compute are NaN.
    """
    entry = MODELS[case.model]
    available = (entry.loaded, entry.loaded, entry.slips, entry.sliced, entry.sliced)
    first_pass = ceil(case.settle_s * grid.rate - 1e-6)
    passes = np.arange(first_pass, max(first_pass + 1, floor((case.settle_s + case.duration) * grid.rate + 1e-6)))
    if raw.repetition.period == 0:
        passes = passes[passes < raw.repetition.computed]
    largest = raw.peaks[np.unique(raw.repetition.source(passes))].max(axis=0)
    return {
        name: float(value) if is_available else float("nan")
        for name, value, is_available in zip(EXTREMES, largest, available, strict=True)
    }


def compute_cage_and_load_zone(case: Case, model: Any, grid: Grid, raw: RawRecord) -> dict[str, float]:
    """Compute the mean extent of the load zone (rad), and mean and standard deviation of the cage slip.

    NaN if the model does not compute them.
    """
    segments, entry = pass_segments(case, grid, raw, margin=0), MODELS[case.model]
    start, M = segments.start, segments.M
    slip, loaded_rollers = np.empty(segments.distinct * M), 0.0
    for begin, end in block_ranges(len(slip)):
        rollers, speed = raw.read(
            start + begin, end - begin, np.array([ROW_OF[lay.LOADED_ROLLERS], ROW_OF[CAGE_SPEED]])
        )
        time = (start + np.arange(begin, end)) / grid.fine_rate
        slip[begin:end] = -speed / (model.bearing.omega_c * speed_factor(model, time))
        loaded_rollers += rollers @ segments.weights[np.arange(begin, end) // M]
    weights = segments.weights
    pass_means = slip.reshape(-1, M).mean(axis=1)
    extent = 2.0 * pi / model.bearing.Z * loaded_rollers / (weights.sum() * M)
    return {
        "load_zone.extent": float(extent) if entry.loaded else float("nan"),
        "cage.slip.mean": float(np.average(pass_means, weights=weights)) if entry.slips else float("nan"),
        "cage.slip.std": float(slip.std()) if entry.slips else float("nan"),
    }


def compute_band_features(case: Case, model: Any, grid: Grid, raw: RawRecord) -> dict[str, float]:
    """Compute the band features over the whole ball passes of a record; NaN if it has no whole pass."""
    requested = {name: feature for name in case.features if (feature := read_band(name)) is not None}
    segments = pass_segments(case, grid, raw, margin=0)
    start, count = segments.start, len(segments.index) * segments.M
    if not requested or not count:
        return dict.fromkeys(requested, nan)
    series = {f.quantity: sensor_samples(case, raw, f.quantity, start, count) for f in requested.values()}
    angles = angles_of_record(case, model, grid, raw, start, count)
    values = {}
    for name, feature in requested.items():
        cpu_time.check()
        samples, band = series[feature.quantity], band_of(case, feature)
        if not can_resolve(band, count / grid.fine_rate):
            values[name] = nan
        elif feature.line:
            values[name] = _envelope_line(case, feature, band, samples, grid.fine_rate, angles)
        else:
            values[name] = signals.band_rms(samples, grid.fine_rate, band)
    return values


def band_of(case: Case, feature: BandFeature) -> Band:
    """Return the band of a feature; for an envelope without a band, the flat band of `sampling`."""
    return feature.band or Band(0.0, PASSBAND * case.sampling)


def can_resolve(band: Band, duration: float) -> bool:
    """Check if ``duration`` (s) resolves a band, that is if it is at least 1/low and 1/(high - low)."""
    return (band.low == 0.0 or band.low * duration >= 1.0) and (band.high - band.low) * duration >= 1.0


def _envelope_line(
    case: Case, feature: BandFeature, band: Band, series: np.ndarray, sampling_rate: float, angles: SampleAngles
) -> float:
    """Compute the amplitude of a line of the squared envelope; NaN if the band or record does not resolve it."""
    Z, name, duration = case.bearing.rollers, feature.line, (len(series) - 1) / sampling_rate
    ends = angles.ends().phases(Z)
    frequencies = (ends[:, 1] - ends[:, 0]) / (2.0 * pi * duration)
    resolved = zip(frequencies, signals.are_resolved(frequencies, duration), strict=True)
    frequency, is_resolved = dict(zip(LINES, resolved, strict=True))[name]
    if not (is_resolved or LINES[name].outer) or not 0.0 < frequency < band.high - band.low:
        return nan
    angle = angles.phase(LINES[name], Z)
    return float(abs(signals.amplitude_at(signals.squared_envelope(series, sampling_rate, band), angle)))


class NotRecorded(UserError, KeyError):
    """Error of a feature function that reads a series which the case does not record."""


class RecordedSeries(dict[str, np.ndarray]):
    """Recorded series (n,) by name; raises ``NotRecorded`` for any other name."""

    def __missing__(self, name: str) -> np.ndarray:
        raise NotRecorded(name)


def compute_extension_features(
    case: Case, time: np.ndarray, series: dict[str, np.ndarray]
) -> tuple[dict[str, float], dict[str, str]]:
    """Compute the features of other packages from a record: ``time`` (n,) in s, ``series`` (n,) by name, in SI.

    The functions get read-only views, because the record is stored after them. Returns the values, and reasons
    (``NO_VALUE``) for values that are not finite or need a series that is not recorded. Raises BrokenExtension if
    a feature fails.
    """
    values, reasons = dict[str, float](), dict[str, str]()
    time, series = _read_only(time), {channel: _read_only(samples) for channel, samples in series.items()}
    for name, feature in FEATURES.items():
        try:
            values[name] = _extension_value(feature, case, time, RecordedSeries(series))
        except NotRecorded as error:
            values[name], reasons[NO_VALUE + name] = nan, f"`{error.args[0]}` is not recorded"
        else:
            if not isfinite(values[name]):
                values[name], reasons[NO_VALUE + name] = nan, f"computed as {values[name]}"
        cpu_time.check()
    return values, reasons


def _read_only(array: np.ndarray) -> np.ndarray:
    """Return a read-only view of an array."""
    view = array.view()
    view.flags.writeable = False
    return view


def _extension_value(feature: Feature, case: Case, time: np.ndarray, series: RecordedSeries) -> float:
    """Compute a feature of another package. Raises BrokenExtension without a real number."""
    try:
        value = call(feature.compute, case, time, series)
    except BrokenExtension as error:
        raise BrokenExtension(f"feature `{feature.name}`: {error}") from error
    number = value.item() if isinstance(value, np.ndarray) and value.ndim == 0 else value
    if not isinstance(number, Real | np.bool_):  # float() would convert a string, and drop an imaginary part
        message = f"`{feature.compute}` returned a {type(value).__name__}, not a real number"
        raise BrokenExtension(f"feature `{feature.name}`: {message}")
    return float(number)


def refuse_undeclared(computed: Iterable[str]) -> None:
    """Raise UserError if a computed feature has no unit and label, and thus no column."""
    undeclared = [name for name in computed if name not in DECLARED]
    if undeclared:
        raise UserError(f"feature `{undeclared[0]}` is computed but not declared: add it to config/names.py")
