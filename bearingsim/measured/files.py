"""Reader of files of signals: format by suffix, sampling rate, speed and units, and checks of the samples."""

import zipfile
from collections.abc import Callable, Iterator, Mapping
from math import pi
from pathlib import Path

import numpy as np

from bearingsim.measured.arrays import content_of
from bearingsim.measured.content import (
    EXAMPLES,
    UNSPECIFIED,
    Content,
    MeasuredError,
    MissingError,
    Recording,
    Request,
    Stated,
    differ,
)
from bearingsim.measured.exchange import read_tdms, read_uff
from bearingsim.measured.matlab import read_hdf5, read_mat
from bearingsim.measured.sound import read_wav
from bearingsim.measured.tables import read_csv, read_parquet

MAX_BYTES = 1 << 30
"""Largest file, and largest content of a compressed one (bytes)."""
INFLATION = 20.0
"""Largest plausible ratio of the size of an array to that of its file; noise does not compress."""
MIN_LIMIT = 1 << 22
"""Memory (bytes) that an array of any file may take."""
OF_FULL_SCALE = "of full scale"
"""Unit of integer samples without a value at full scale."""
UNEVEN = 0.5
"""Largest deviation of an instant from even spacing, relative to a step: printed times are rounded."""


def read_npz(path: Path, most: float) -> Content:
    """Read the arrays of an NPZ file; most: largest memory (bytes) of them together."""
    with zipfile.ZipFile(path) as archive:
        size = sum(entry.file_size for entry in archive.infolist())
    if size > most:
        raise MeasuredError(path, f"would take {size / 1e6:.3g} MB, which is not plausible for its size")
    with np.load(path, allow_pickle=False) as archive:
        arrays = {name: _array(path, archive, name) for name in archive.files}
    arrays = {name: values for name, values in arrays.items() if isinstance(values, np.ndarray)}
    texts = {name: str(values) for name, values in arrays.items() if values.dtype.kind == "U" and values.size == 1}
    return content_of(path, {name: v for name, v in arrays.items() if v.dtype.kind in "fiubc"}, texts)


def _array(path: Path, archive: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    """Return an array of an NPZ file. Raises MeasuredError if it contains Python objects."""
    try:
        return archive[name]
    except ValueError as error:
        if "allow_pickle" not in str(error):
            raise
        raise MeasuredError(path, f"has Python objects in `{name}`: save it as an array of numbers") from None


FORMATS: dict[str, Callable[[Path, float], Content]] = {
    ".csv": lambda path, most: read_csv(path),
    ".txt": lambda path, most: read_csv(path),
    ".wav": lambda path, most: read_wav(path),
    ".mat": read_mat,
    ".npz": read_npz,
    ".parquet": lambda path, most: read_parquet(path),
    ".h5": read_hdf5,
    ".hdf5": read_hdf5,
    ".uff": lambda path, most: read_uff(path),
    ".unv": lambda path, most: read_uff(path),
    ".tdms": lambda path, most: read_tdms(path),
}
"""Readers by suffix."""


def read(
    path: Path, request: Request = UNSPECIFIED, needs_speed: bool = False, needs_unit: bool = False
) -> Recording:
    """Read the channels of a file; values of the request take precedence over those of the file.

    needs_speed: refuse a file without a speed unless the request gives it; needs_unit: name a missing unit, too,
    if another value is missing.
    Raises MissingError with all options, or keys of a study, that state what is missing; MeasuredError with the
    reason and the remedy: an unknown or damaged format, a gap in time, a missing channel. OSError if the
    file cannot be opened.
    """
    size = path.stat().st_size
    reader = FORMATS.get(path.suffix.lower())
    if path.is_dir():
        raise MeasuredError(path, "is a folder: name a file in it")
    if reader is None:
        advice = "; save the array with its rate by `np.savez`" if path.suffix.lower() == ".npy" else ""
        raise MeasuredError(path, f"expected a file that ends in {', '.join(FORMATS)}{advice}")
    if size == 0:
        raise MeasuredError(path, "is empty")
    if size > MAX_BYTES:
        raise MeasuredError(path, f"has {size / 1e9:.3g} GB, above {MAX_BYTES / 1e9:.3g} GB: export a part of it")
    try:
        content = reader(path, min(MAX_BYTES, max(MIN_LIMIT, INFLATION * size)))
    except MeasuredError:
        raise
    except Exception as error:
        if isinstance(error, OSError) and error.filename:
            raise
        reason = " ".join(str(error).replace(str(path), path.name).split())[:120] or type(error).__name__
        raise MeasuredError(path, f"cannot be read as a {path.suffix} file, it is damaged ({reason})") from error
    missing = list(_missing(content, request, needs_speed))
    if missing and needs_unit:
        missing += _missing_unit(content, request)
    if missing:
        raise MissingError(path, {name: EXAMPLES[name] for name in missing}, request)
    return _recording(path, content, request)


def _missing(content: Content, request: Request, needs_speed: bool) -> Iterator[str]:
    """Yield the names of values that neither the file nor the request states."""
    if content.rate is None and content.time is None and request.rate is None:
        yield "sampling rate"
    if needs_speed and not content.speeds and request.speed is None:
        yield "speed"


def _missing_unit(content: Content, request: Request) -> Iterator[str]:
    """Yield the name of the unit if no channel has one."""
    names = content.channels if request.channel is None else [request.channel]
    if request.unit is None and not any(name in content.units for name in names):
        yield "unit" if content.integer_range is None else "unit of integer samples"


def _recording(path: Path, content: Content, request: Request) -> Recording:
    channels = dict(content.channels)
    if request.channel is not None:
        if request.channel not in channels:
            raise MeasuredError(path, f"has no channel `{request.channel}`: it has {_listed(channels)}")
        channels = {request.channel: channels[request.channel]}
    scale, scale_unit = _scale(path, content, request)
    return Recording(
        path,
        {name: np.asarray(values, float) * scale for name, values in channels.items()},
        _rate(path, content, request),
        _speed(path, content, request, list(channels)),
        {name: _unit(content.units.get(name), request, scale_unit) for name in channels},
        tuple(_contradictions(path, content, request)),
    )


def _contradictions(path: Path, content: Content, request: Request) -> Iterator[str]:
    """Yield the values of a file that contradict the request, which takes precedence."""
    times = None if content.time is None or _is_coarse(content.time.value) else content.time
    rates = content.rate, None if times is None else _rate_of_times(path, times, request)
    statements: list[tuple[str, float | None, Stated[float] | None, float, str]] = [
        *(("rate", request.rate, rate, 1.0, "Hz") for rate in rates),
        *(("speed", request.speed, speed, 30.0 / pi, "rpm") for speed in content.speeds.values()),
    ]
    for field, requested, stated, factor, unit in statements:
        if requested is not None and stated is not None and differ(requested, stated.value):
            yield (
                f"{path.name} states {factor * stated.value:.6g} {unit} ({stated.source}): "
                f"`{request.name(field)}`, {factor * requested:.6g} {unit}, is used instead"
            )


def _listed(channels: dict[str, np.ndarray]) -> str:
    names = [f"`{name}`" for name in channels]
    return f"{', '.join(names[:8])}{f' and {len(names) - 8} more' if len(names) > 8 else ''}"


def _rate(path: Path, content: Content, request: Request) -> Stated[float]:
    """Return the sampling rate (Hz), from the request, the file's own statement, or its times."""
    is_stated = request.rate is not None or content.rate is not None
    if content.time is not None and not (is_stated and _is_coarse(content.time.value)):
        rate_of_times = _rate_of_times(path, content.time, request)
        if request.rate is not None:
            return Stated(request.rate, request.name("rate"))
        rounding = 1.0 + 1.0 / len(content.time.value)  # of the first and last time, by half a step each
        for stated in filter(None, (content.rate, content.other_rate)):
            if differ(stated.value, rate_of_times.value) and not (
                rate_of_times.value / rounding <= stated.value <= rate_of_times.value * rounding
            ):
                raise _two_rates(path, rate_of_times, stated, request)
        return rate_of_times
    if request.rate is not None:
        return Stated(request.rate, request.name("rate"))
    if content.rate is None:
        raise MissingError(path, {"sampling rate": EXAMPLES["sampling rate"]}, request)
    rate = f"`{request.name('rate')}`"
    if content.other_rate is not None:
        raise _two_rates(path, content.rate, content.other_rate, request)
    if not (np.isfinite(content.rate.value) and content.rate.value > 0.0):
        raise MeasuredError(path, f"states a sampling rate of {content.rate.value:g} Hz: give it by {rate}")
    return content.rate


def _two_rates(path: Path, rate: Stated[float], other: Stated[float], request: Request) -> MeasuredError:
    values = " and ".join(f"{stated.value:g} Hz ({stated.source})" for stated in (rate, other))
    return MeasuredError(
        path, f"states two sampling rates, {values}: give the right one by `{request.name('rate')}`"
    )


def _speed(path: Path, content: Content, request: Request, names: list[str]) -> Stated[float] | None:
    """Return the speed (rad/s) of channels. Raises MeasuredError if they have several."""
    if request.speed is not None:
        return Stated(request.speed, request.name("speed"))
    speeds = [content.speed_of(name) for name in names]
    stated = [speed for speed in speeds if speed is not None]
    for speed in stated:
        if not (np.isfinite(speed.value) and speed.value > 0.0):
            value = f"{30.0 / pi * speed.value:.6g} rpm ({speed.source})"
            raise MeasuredError(path, f"states a speed of {value}: give it by `{request.name('speed')}`")
    if stated and content.other_speed is not None:
        values = [f"{30.0 / pi * s.value:.6g} rpm ({s.source})" for s in (stated[0], content.other_speed)]
        advice = f"give the right one by `{request.name('speed')}`"
        raise MeasuredError(path, f"states two speeds, {' and '.join(values)}: {advice}")
    if any(differ(stated[0].value, speed.value) for speed in stated) or (stated and None in speeds):
        listed = {f"{30.0 / pi * speed.value:.6g} rpm ({speed.source})": None for speed in stated}
        advice = f"name a `{request.name('channel')}`, or a `{request.name('speed')}`"
        raise MeasuredError(path, f"states several speeds, such as {' and '.join([*listed][:2])}: {advice}")
    return stated[0] if stated else None


def _is_coarse(time: np.ndarray) -> bool:
    """Check if instants (s) are rounded to more than a step, so that most neighbours are equal."""
    steps = np.diff(time)
    return len(steps) > 0 and bool(np.all(steps >= 0.0)) and float(np.median(steps)) == 0.0


def _rate_of_times(path: Path, time: Stated[np.ndarray], request: Request) -> Stated[float]:
    """Return the sampling rate (Hz) of instants (s). Raises MeasuredError for a gap."""
    steps = np.diff(time.value)
    if len(steps) == 0:
        raise MeasuredError(path, "has one sample only")
    if _is_coarse(time.value):
        advice = f"give the rate by `{request.name('rate')}`"
        raise MeasuredError(path, f"has times rounded to more than a step, in {time.source}: {advice}")
    if not np.all(np.isfinite(steps)):
        raise MeasuredError(path, f"has missing times in {time.source}")
    median = float(np.median(steps))
    if median <= 0.0:
        raise MeasuredError(path, f"has times that do not increase, in {time.source}")
    gaps = np.flatnonzero(np.abs(steps - median) > UNEVEN * median)
    if len(gaps):
        begin, step, expected = float(time.value[gaps[0]]), 1e3 * steps[gaps[0]], 1e3 * median
        raise MeasuredError(
            path,
            f"has {len(gaps)} gap{'s' * (len(gaps) != 1)} in {time.source}, the first after {begin:.6g} s "
            f"({step:.4g} ms instead of {expected:.4g} ms): export a part without gaps",
        )
    mean = (time.value[-1] - time.value[0]) / len(steps)
    deviation = np.abs(time.value - time.value[0] - mean * np.arange(len(time.value))).max()
    if deviation > UNEVEN * mean:
        raise MeasuredError(
            path,
            f"has unevenly spaced times in {time.source} (deviation up to {1e3 * deviation:.4g} ms): resample it",
        )
    return Stated(float(1.0 / mean), time.source)


def _scale(path: Path, content: Content, request: Request) -> tuple[float, str | None]:
    """Return the factor of integer samples, and their unit if the request gives none.

    Raises MeasuredError for a full scale of other samples.
    """
    if content.integer_range is None:
        if request.full_scale is not None:
            raise MeasuredError(
                path,
                f"has no integer WAV samples, so `{request.name('full_scale')}` does not apply: omit it, and give "
                f"the unit of the samples by `{request.name('unit')}`",
            )
        return 1.0, None
    full_scale = 1.0 if request.full_scale is None else request.full_scale
    return full_scale / content.integer_range, None if request.full_scale is not None else OF_FULL_SCALE


def _unit(file_unit: str | None, request: Request, scale_unit: str | None) -> Stated[str]:
    """Return the unit of a channel, and its source."""
    if scale_unit is not None:
        fields = f"`{request.name('unit')}` and `{request.name('full_scale')}`"
        return Stated(scale_unit, f"integer samples; set their unit by {fields}")
    if request.unit is not None:
        return Stated(request.unit, request.name("unit"))
    if file_unit:
        return Stated(file_unit, "the file")
    return Stated("", f"not stated; set it by `{request.name('unit')}`")
