"""Identification of signals, time, sampling rate and speed among the named arrays of a file."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from bearingsim.measured.content import Content, MeasuredError, Stated, contradiction, differ
from bearingsim.measured.si import HERTZ, SECONDS, TURNS

RATES = (
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
STEPS = ("dt", "ts", "timestep", "sampletime", "sampleinterval", "samplinginterval", "deltax", "deltat")
TIMES = ("t", "time", "times", "timestamp", "zeit", "xvalue")
SPEEDS = ("rpm", "speedrpm", "shaftrpm", "rotationalspeedrpm")
OWN_SPEED = re.compile(r"(?P<job>(?:.+\.)?job_[^.]+)\.parameters\.speed")
"""Name of a job's speed (rad/s) in an exported file; other files have speeds in other units under such names."""
MAX_CHANGE = 0.01
"""Largest relative change of a speed that counts as constant."""
MIN_SAMPLES = 16
"""Smallest number of samples of a signal; shorter arrays are ignored."""
MAX_CHANNELS = 256
"""Largest number of columns of a table of signals."""


def content_of(path: Path, arrays: Mapping[str, np.ndarray], texts: Mapping[str, str]) -> Content:
    """Identify signals, time, rate and speed among named arrays.

    Only the letters and digits of a name are compared, in lower case, and only the part after its last dot. Raises
    MeasuredError for a file without signals, and for times in an unknown unit.
    """
    channels: dict[str, np.ndarray] = {}
    rates: list[Stated[float]] = []
    speeds: dict[str, Stated[float]] = {}
    other_speed = None
    times: list[Stated[np.ndarray]] = []
    for name, values in arrays.items():
        if np.iscomplexobj(values):
            continue
        word, own_unit = word_of(name), (_own_unit(name, texts) or "").strip().lower()
        if values.size == 1:
            number = float(values.ravel()[0])
            if word in RATES and own_unit in HERTZ:
                rates.append(Stated(HERTZ[own_unit] * number, f"the variable `{name}`"))
            elif word in STEPS and number > 0.0 and own_unit in SECONDS:
                rates.append(Stated(1.0 / (SECONDS[own_unit] * number), f"the variable `{name}`"))
            elif (word in SPEEDS or word.endswith("rpm")) and (own_unit or "rpm") in TURNS:
                speed = Stated(number * TURNS[own_unit or "rpm"], f"the variable `{name}`")
                group_speed = speeds.setdefault(name.rpartition(".")[0], speed)
                if other_speed is None and differ(speed.value, group_speed.value):
                    other_speed = speed
            elif (match := OWN_SPEED.fullmatch(name)) and f"{match['job']}.parameters.ramp_to" not in arrays:
                # with a ramp, the record has another speed
                speeds.setdefault(match["job"], Stated(number, f"the variable `{name}`"))
        elif (
            word in TIMES
            and values.size >= MIN_SAMPLES
            and (not times or (own_unit in SECONDS and rises(values.ravel())))
        ):
            if own_unit not in SECONDS:
                raise MeasuredError(path, f"has times in `{own_unit}`: expected s, ms or us")
            times.append(Stated(SECONDS[own_unit] * values.astype(float).ravel(), f"the variable `{name}`"))
        elif word in SPEEDS and (own_unit or "rpm") in TURNS and values.size == max(values.shape):
            samples = values.astype(float).ravel() * TURNS[own_unit or "rpm"]
            speed, end = sampled_speed(samples, f"the variable `{name}`")
            group_speed = speeds.setdefault(name.rpartition(".")[0], speed)
            is_other = differ(speed.value, group_speed.value, MAX_CHANGE)
            other_speed = other_speed or end or (speed if is_other else None)
        else:
            channels |= _columns(name, values)
    if times:
        lengths = {len(time.value) for time in times}
        channels = {name: values for name, values in channels.items() if len(values) in lengths}
    if not channels:
        raise MeasuredError(path, f"has no signal: {_listed(arrays)}{_advice(arrays)}")
    time, rate = times[0] if times else None, rates[0] if rates else None
    other_rate = contradiction(rates) or rate_of_other_times(times)
    return Content(channels, time, rate, speeds, _units(channels, texts), other_rate, other_speed)


def sampled_speed(values: np.ndarray, source: str) -> tuple[Stated[float], Stated[float] | None]:
    """Return the mean of samples (n,) of a speed (rad/s), and None; of a speed that changes, its two extremes.

    Missing samples are left out.
    """
    present = values[~np.isnan(values)]
    if len(present) == 0:
        return Stated(float("nan"), source), None
    if np.ptp(present) <= MAX_CHANGE * abs(present.mean()):
        return Stated(float(present.mean()), source), None
    lowest, highest = float(present.min()), float(present.max())
    return Stated(lowest, f"the lowest in {source}"), Stated(highest, f"the highest in {source}")


def rises(values: np.ndarray) -> bool:
    """Check if values (n,) do not decrease, and are not constant."""
    return bool(np.all(np.diff(values) >= 0.0)) and bool(values[-1] > values[0])


def rate_of_other_times(times: Sequence[Stated[np.ndarray]]) -> Stated[float] | None:
    """Return the mean rate (Hz) of the instants (s) whose rate differs from that of the first; None if none do."""
    rising = [time for time in times if rises(time.value)]
    counts = [len(time.value) - 1 for time in rising]
    spans = [float(time.value[-1] - time.value[0]) for time in rising]
    rates = [Stated(n / span, time.source) for n, span, time in zip(counts, spans, rising, strict=True)]
    return contradiction(rates)


def _own_unit(name: str, texts: Mapping[str, str]) -> str | None:
    """Return the unit of an array itself: `x.unit`, `x_unit`, or `units.x` beside `x`; None if there is none."""
    owner, _, last = name.rpartition(".")
    candidates = f"{name}.unit", f"{name}_unit", f"{owner}.units.{last}" if owner else f"units.{last}"
    return next((texts[candidate] for candidate in candidates if candidate in texts), None)


def _advice(arrays: Mapping[str, np.ndarray]) -> str:
    name = next((name for name, values in arrays.items() if np.iscomplexobj(values)), None)
    return f"; `{name}` is complex: save the real time signal" if name else ""


def word_of(name: str) -> str:
    """Return the letters and digits of the last part of a name with dots, in lower case."""
    return "".join(letter for letter in name.rpartition(".")[2].lower() if letter.isalnum())


def _columns(name: str, values: np.ndarray) -> dict[str, np.ndarray]:
    """Return the signals of an array: itself, or its rows or columns, whichever are longer."""
    values = np.squeeze(values)
    if values.ndim not in (1, 2) or max(values.shape) < MIN_SAMPLES:
        return {}
    if values.ndim == 1:
        return {name: values}
    if min(values.shape) > MAX_CHANNELS:
        return {}
    columns = values if values.shape[0] >= values.shape[1] else values.T
    return {f"{name}.{number + 1}": columns[:, number] for number in range(columns.shape[1])}


def _units(channels: Mapping[str, np.ndarray], texts: Mapping[str, str]) -> dict[str, str]:
    """Return the units of signals: `x.unit`, `x_unit`, `units.x` beside `x`, or one `unit` of the file."""
    units = {}
    for name in channels:
        owner = name.rpartition(".")[0]
        keys = *((f"{owner}.unit", f"{owner}_unit") if owner else ()), "unit", "units"
        shared = (texts[key] for key in keys if key in texts)
        own_unit = _own_unit(name, texts)
        unit = next(shared, None) if own_unit is None else own_unit
        if unit is not None:
            units[name] = unit
    return units


def _listed(arrays: Mapping[str, np.ndarray]) -> str:
    shapes = [f"`{name}` {'x'.join(map(str, values.shape)) or '1'}" for name, values in arrays.items()]
    return (
        f"its arrays are {', '.join(shapes[:6])}{', ...' if len(shapes) > 6 else ''}"
        if shapes
        else "it contains no numbers"
    )
