"""Identification of signals, time, sampling rate and speed among the named arrays of a file."""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from bearingsim.measured.content import MAX_DIFFERENCE, Content, MeasuredError, Stated, differ
from bearingsim.measured.si import FREQUENCY_FACTORS, SPEED_FACTORS, TIME_FACTORS

RATE_NAMES = (
    "fs",
    "sr",
    "rate",
    "samplerate",
    "samplingrate",
    "samplefrequency",
    "samplingfrequency",
    "fsamp",
    "fsampling",
)
"""Names of the sampling rate as ``normalize`` returns them, as are those below."""
STEP_NAMES = ("dt", "ts", "timestep", "sampletime", "sampleinterval", "samplinginterval", "deltax", "deltat")
"""Names of the sampling interval."""
TIME_NAMES = ("t", "time", "times", "timestamp", "zeit", "xvalue")
TIME_NUMBER = re.compile(r"[\s._-]*\d+$")
"""Number at the end of the name of a further time, such as `t2`, `Time 2` and `time.1`."""
RPM_NAMES = ("rpm", "speedrpm", "shaftrpm", "rotationalspeedrpm")
"""Names of a speed that is in rpm unless its unit is stated."""
EXPORTED_SPEED = re.compile(r"(?P<job>(?:.+\.)?job_[^.]+)\.parameters\.speed")
"""Name of the speed (rad/s) of a job in a MAT file exported by this program; in others, its unit is unknown."""
CONVERSION_NAMES = ("scale", "scalefactor", "scaling", "gain", "offset", "addoffset", "sensitivity", "calibration")
"""Names of numbers by which integer samples may have to be converted to their unit."""
MAX_CHANGE = 0.01
"""Largest relative change of a speed that counts as constant."""
MIN_SHAFT_RATE_RATIO = 100.0
"""Ratio of a sampling rate to a `rate` beside it, above which this is the frequency of the shaft."""
MIN_SAMPLES = 16
"""Smallest number of samples of a signal; shorter arrays are ignored."""
MAX_CHANNELS = 256
"""Largest number of channels in a two-dimensional array."""


def identify_content(path: Path, arrays: Mapping[str, np.ndarray], texts: Mapping[str, str]) -> Content:
    """Identify signals, time, rate and speed among named arrays; texts: those of the file by name, such as units.

    Only the letters and digits of a name are compared, in lower case, and only the part after its last dot.
    Complex arrays are ignored. Raises MeasuredError for a file without signals, and for times in an unknown unit.
    """
    channels: dict[str, np.ndarray] = {}
    rates: list[Stated[float]] = []
    speeds: dict[str, Stated[float]] = {}
    other_speed = None
    times: list[Stated[np.ndarray]] = []
    for name, values in arrays.items():
        if np.iscomplexobj(values):
            continue
        key, unit, source = (
            normalize(name),
            (_own_unit(name, texts) or "").lower().partition(" since ")[0].strip(),  # `seconds since 2020-01-01`
            f"the variable `{name}`",
        )
        group, samples, is_scalar = (
            name.rpartition(".")[0],
            values.astype(float, copy=False).ravel(),
            values.size == 1,
        )
        is_speed = key in RPM_NAMES or (is_scalar and key.endswith("rpm"))
        if is_scalar and key in RATE_NAMES and unit in FREQUENCY_FACTORS:
            rates.append(Stated(FREQUENCY_FACTORS[unit] * float(samples[0]), source, group))
        elif is_scalar and key in STEP_NAMES and unit in TIME_FACTORS and samples[0] > 0.0:
            rates.append(Stated(1.0 / (TIME_FACTORS[unit] * float(samples[0])), source, group))
        elif is_speed and (unit or "rpm") in SPEED_FACTORS and 0 < values.size == max(values.shape, default=1):
            speed, highest = mean_speed(samples * SPEED_FACTORS[unit or "rpm"], source)
            group_speed = speeds.setdefault(group, speed)
            is_other = differ(speed.value, group_speed.value, MAX_DIFFERENCE if is_scalar else MAX_CHANGE)
            other_speed = other_speed or highest or (speed if is_other else None)
        elif is_scalar and (match := EXPORTED_SPEED.fullmatch(name)):
            if f"{match['job']}.parameters.ramp_to" not in arrays:  # a ramp starts at the speed of the parameters
                speeds.setdefault(match["job"], Stated(float(samples[0]), source))
        elif (
            MIN_SAMPLES <= values.size == max(values.shape)
            and names_time(name, samples)
            and (not times or (unit in TIME_FACTORS and is_rising(samples)))
        ):
            if unit not in TIME_FACTORS:
                raise MeasuredError(path, f"has times in `{unit}`: expected s, ms or us")
            times.append(Stated(TIME_FACTORS[unit] * samples, source, group))
        else:
            channels |= _split_channels(name, values)
    if times:
        lengths = {len(time.value) for time in times}
        channels = {name: values for name, values in channels.items() if len(values) in lengths}
    if not channels:
        raise MeasuredError(path, f"has no signal: {_describe_arrays(arrays)}")
    rates, remarks = _omit_shaft_rates(rates), dict(_list_unconverted(arrays, channels))
    return Content(channels, times, rates, speeds, _units(channels, texts), other_speed, remarks)


def _list_unconverted(
    arrays: Mapping[str, np.ndarray], channels: Mapping[str, np.ndarray]
) -> Iterator[tuple[str, str]]:
    """Yield name and remark of each channel of integers beside a scale or an offset, which are not applied."""
    for name, values in channels.items():
        if values.dtype.kind not in "iu":
            continue
        conversions = [
            f"`{other}`"
            for other, value in arrays.items()
            if value.size == 1
            and normalize(other) in CONVERSION_NAMES
            and other.rpartition(".")[0] in ("", name.rpartition(".")[0])
        ]
        if conversions:
            listed, verb = " and ".join(conversions), "is" if len(conversions) == 1 else "are"
            yield name, f"`{name}` has integer samples, to which {listed} {verb} not applied: convert them"


def _omit_shaft_rates(rates: list[Stated[float]]) -> list[Stated[float]]:
    """Return sampling rates (Hz) without a `rate` far below another one of its group, which is of the shaft."""
    return [
        stated
        for stated in rates
        if not stated.source.lower().removesuffix("`").endswith(("`rate", ".rate"))
        or not any(o.group == stated.group and MIN_SHAFT_RATE_RATIO * stated.value < o.value for o in rates)
    ]


def mean_speed(samples: np.ndarray, source: str) -> tuple[Stated[float], Stated[float] | None]:
    """Return the mean of a sampled speed (n,), rad/s, and None; its lowest and highest value if it changes.

    Missing samples are left out. The mean is NaN if all are missing.
    """
    present = samples[~np.isnan(samples)]
    if len(present) == 0:
        return Stated(float("nan"), source), None
    lowest, highest = float(present.min()), float(present.max())
    if lowest == highest or highest - lowest <= MAX_CHANGE * abs(present.mean()):
        return Stated(float(present.mean()), source), None
    return Stated(lowest, f"the lowest in {source}"), Stated(highest, f"the highest in {source}")


def names_time(name: str, values: np.ndarray) -> bool:
    """Check if a name is that of a time, or such a name with a number behind it, and the values (n,) are even.

    Names with a number may be those of other quantities, such as temperatures: their values are times if they
    increase by equal steps.
    """
    if normalize(name) in TIME_NAMES:
        return True
    return normalize(TIME_NUMBER.sub("", name)) in TIME_NAMES and is_evenly_spaced(values)


def is_evenly_spaced(values: np.ndarray) -> bool:
    """Check if the first 1000 values increase by equal steps, within 2 %."""
    steps = np.diff(values[:1000])
    return bool(len(steps) > 2 and np.all(steps > 0.0) and np.ptp(steps) <= 0.02 * np.median(steps))


def is_rising(values: np.ndarray) -> bool:
    """Check if values (n,) do not decrease, and are not constant."""
    return bool(np.all(np.diff(values) >= 0.0)) and bool(values[-1] > values[0])


def normalize(name: str) -> str:
    """Return the letters and digits of the part of a name after its last dot, in lower case."""
    return "".join(letter for letter in name.rpartition(".")[2].lower() if letter.isalnum())


def _own_unit(name: str, texts: Mapping[str, str]) -> str | None:
    """Return the unit of an array alone: `x.unit`, `x_unit`, or `units.x` beside `x`; None if there is none."""
    group, _, field = name.rpartition(".")
    keys = f"{name}.unit", f"{name}_unit", f"{group}.units.{field}" if group else f"units.{field}"
    return next((texts[key] for key in keys if key in texts), None)


def _units(channels: Mapping[str, np.ndarray], texts: Mapping[str, str]) -> dict[str, str]:
    """Return the units of channels: their own, that of their array or group, or that of the file."""
    units = {}
    for name in channels:
        group = name.rpartition(".")[0]
        keys = *((f"{group}.unit", f"{group}_unit") if group else ()), "unit", "units"
        shared_unit = next((texts[key] for key in keys if key in texts), None)
        own_unit = _own_unit(name, texts)
        unit = shared_unit if own_unit is None else own_unit
        if unit is not None:
            units[name] = unit
    return units


def _split_channels(name: str, values: np.ndarray) -> dict[str, np.ndarray]:
    """Return the channels of an array: itself, or its rows or columns, whichever are longer; none if short."""
    values = np.squeeze(values)
    if values.ndim not in (1, 2) or max(values.shape) < MIN_SAMPLES:
        return {}
    if values.ndim == 1:
        return {name: values}
    if min(values.shape) > MAX_CHANNELS:
        return {}
    columns = values if values.shape[0] >= values.shape[1] else values.T
    return {f"{name}.{number + 1}": columns[:, number] for number in range(columns.shape[1])}


def _describe_arrays(arrays: Mapping[str, np.ndarray]) -> str:
    """Describe the shapes of arrays that contain no signal, with the remedy for a complex array."""
    if not arrays:
        return "it contains no numbers"
    shapes = [f"`{name}` {'x'.join(map(str, values.shape)) or '1'}" for name, values in arrays.items()]
    more = ", ..." if len(shapes) > 6 else ""
    complex_name = next((name for name, values in arrays.items() if np.iscomplexobj(values)), None)
    advice = f"; `{complex_name}` is complex: save the real time signal" if complex_name else ""
    return f"its arrays are {', '.join(shapes[:6])}{more}{advice}"
