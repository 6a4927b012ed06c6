"""Formats of measuring systems, read by optional packages: UFF dataset 58 (pyuff) and TDMS (nptdms)."""

from math import pi
from pathlib import Path
from typing import Any

import numpy as np

from bearingsim.measured.content import Content, MeasuredError, Stated

EXTRA = "`pip install 'bearingsim[formats]'`"

FREQUENCY = 18
"""Type of an abscissa in dataset 58 that is a frequency; 17 is time, 0 unknown."""


def read_uff(path: Path) -> Content:
    """Read the time series (dataset 58) of a universal file."""
    try:
        import pyuff
    except ImportError:
        raise MeasuredError(path, f"UFF needs pyuff: {EXTRA}") from None
    data = pyuff.UFF(str(path)).read_sets()
    sets: list[dict[str, Any]] = data if isinstance(data, list) else [data]
    channels, units, steps = {}, {}, set()
    for number, entry in enumerate(sets):
        is_spectrum = entry.get("abscissa_spec_data_type") == FREQUENCY
        if entry.get("type") == 58 and not is_spectrum and not np.iscomplexobj(entry["data"]):
            name = str(entry.get("id1", "")).strip() or f"set {number + 1}"
            name = name if name not in channels and name.upper() != "NONE" else f"set {number + 1}"
            channels[name] = np.asarray(entry["data"], float)
            steps.add(float(entry["abscissa_inc"]))
            unit = str(entry.get("ordinate_axis_units_lab", "")).strip()
            if unit and unit.upper() != "NONE":
                units[name] = unit
    if not channels:
        raise MeasuredError(path, "has no time series (dataset 58)")
    if len(steps) > 1:
        raise MeasuredError(path, "has time series of several sampling rates: export one of them")
    step = steps.pop()
    return Content(channels, rate=Stated(1.0 / step, "`abscissa_inc`") if step > 0.0 else None, units=units)


def read_tdms(path: Path) -> Content:
    """Read the channels of a TDMS file that have a waveform."""
    try:
        from nptdms import TdmsFile
    except ImportError:
        raise MeasuredError(path, f"TDMS needs nptdms: {EXTRA}") from None
    channels, units, steps, speeds = {}, {}, set(), {}
    file = TdmsFile.read(str(path))
    for group in file.groups():
        for channel in group.channels():
            properties = {**file.properties, **group.properties, **channel.properties}
            values = np.asarray(channel[:])
            if values.dtype.kind not in "fiu" or len(values) < 2:
                continue
            name = f"{group.name}/{channel.name}"
            channels[name] = values.astype(float)
            if "wf_increment" in channel.properties:
                steps.add(float(channel.properties["wf_increment"]))
            if channel.properties.get("unit_string"):
                units[name] = str(channel.properties["unit_string"])
            if "rpm" in properties:
                speeds[name] = Stated(float(properties["rpm"]) * pi / 30.0, "the property `rpm`")
    if not channels:
        raise MeasuredError(path, "has no channel with numbers")
    if len(steps) > 1:
        raise MeasuredError(path, "has channels of several sampling rates: export one of them")
    step = steps.pop() if steps else 0.0
    return Content(channels, None, Stated(1.0 / step, "`wf_increment`") if step > 0.0 else None, speeds, units)
