"""Formats of measuring systems, read by optional packages: UFF dataset 58 (pyuff) and TDMS (nptdms)."""

from collections.abc import Mapping
from math import pi
from pathlib import Path
from typing import Any

import numpy as np

from bearingsim.measured.arrays import names_time
from bearingsim.measured.content import Content, MeasuredError, Stated
from bearingsim.measured.si import TIME_FACTORS
from bearingsim.text.numbers import is_number

INSTALLATION = "`pip install 'bearingsim[formats]'`"
FREQUENCY_TYPE = 18
"""Data type of an abscissa of frequency in dataset 58; 17 is time, 0 unknown."""
UNEVEN_SPACING = 0
"""Spacing code of an abscissa in dataset 58 that is stored with the samples; 1 is even spacing."""


def read_uff(path: Path) -> Content:
    """Read the time series (dataset 58) of a universal file; those of uneven spacing with their times.

    Raises MeasuredError if pyuff is missing, without time series, and for two of the same name.
    """
    try:
        import pyuff
    except ImportError:
        raise MeasuredError(path, f"UFF needs pyuff: {INSTALLATION}") from None
    data = pyuff.UFF(str(path)).read_sets()
    sets: list[dict[str, Any]] = data if isinstance(data, list) else [data]
    channels, units, rates, times = {}, {}, list[Stated[float]](), list[Stated[np.ndarray]]()
    for number, entry in enumerate(sets):
        is_spectrum = entry.get("abscissa_spec_data_type") == FREQUENCY_TYPE
        if entry.get("type") == 58 and not is_spectrum and not np.iscomplexobj(entry["data"]):
            name = str(entry.get("id1", "")).strip() or f"set {number + 1}"
            name = name if name not in channels and name.upper() != "NONE" else f"set {number + 1}"
            if name in channels:
                raise MeasuredError(path, f"has two time series `{name}`: rename or remove one of them")
            channels[name] = np.asarray(entry["data"], float)
            if entry.get("abscissa_spacing") == UNEVEN_SPACING:
                times.append(Stated(np.asarray(entry["x"], float), f"the abscissa of `{name}`", name))
            elif float(entry["abscissa_inc"]) > 0.0:
                rates.append(Stated(1.0 / float(entry["abscissa_inc"]), f"`abscissa_inc` of `{name}`", name))
            unit = str(entry.get("ordinate_axis_units_lab", "")).strip()
            if unit and unit.upper() != "NONE":
                units[name] = unit
    if not channels:
        raise MeasuredError(path, "has no time series (dataset 58)")
    return Content(channels, times, rates, units=units)


def read_tdms(path: Path) -> Content:
    """Read the channels of a TDMS file that have a sampling interval, `wf_increment`; all if none has one.

    Without intervals, a channel named as a time contains the times (s) of the channels of its group.
    Raises MeasuredError if nptdms is missing, and without numbers.
    """
    try:
        from nptdms import TdmsFile
    except ImportError:
        raise MeasuredError(path, f"TDMS needs nptdms: {INSTALLATION}") from None
    channels, units, rates, speeds = {}, {}, dict[str, Stated[float]](), {}
    file = TdmsFile.read(str(path))
    for group in file.groups():
        for channel in group.channels():
            properties = {**file.properties, **group.properties, **channel.properties}
            values = np.asarray(channel[:])
            if values.dtype.kind not in "fiu" or len(values) < 2:
                continue
            name = f"{group.name}/{channel.name}"
            channels[name] = values.astype(float)
            if float(channel.properties.get("wf_increment", 0.0)) > 0.0:
                source = f"`wf_increment` of `{name}`"
                rates[name] = Stated(1.0 / float(channel.properties["wf_increment"]), source, name)
            if channel.properties.get("unit_string"):
                units[name] = str(channel.properties["unit_string"])
            if is_number(str(properties.get("rpm", ""))):
                speeds[name] = Stated(float(properties["rpm"]) * pi / 30.0, "the property `rpm`")
    if not channels:
        raise MeasuredError(path, "has no channel with numbers")
    channels = {name: values for name, values in channels.items() if name in rates or not rates}
    times = [] if rates else _pop_times(path, channels, units)
    speeds = {name: speed for name, speed in speeds.items() if name in channels}
    return Content(channels, times, list(rates.values()), speeds, units)


def _pop_times(path: Path, channels: dict[str, np.ndarray], units: Mapping[str, str]) -> list[Stated[np.ndarray]]:
    """Remove the times (s) from the channels of a TDMS file, and return them.

    Channels whose length is that of no time are removed as well. Raises MeasuredError for times in an unknown
    unit, and if nothing else remains.
    """
    times = []
    for name in [name for name, values in channels.items() if names_time(name.rpartition("/")[2], values)]:
        unit = units.get(name, "").lower()
        if unit not in TIME_FACTORS:
            raise MeasuredError(path, f"has times in `{unit}`: expected s, ms or us")
        instants = TIME_FACTORS[unit] * channels.pop(name)
        times.append(Stated(instants, f"the channel `{name}`", name.rpartition("/")[0]))
    lengths = {len(time.value) for time in times}
    for name in [name for name, values in channels.items() if times and len(values) not in lengths]:
        del channels[name]
    if not channels:
        raise MeasuredError(path, "has times but no signal of the same length")
    return times
