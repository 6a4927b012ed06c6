"""Reading of files of signals: reader by suffix, and choice of sampling rate, speed and units."""

import zipfile
from collections.abc import Callable, Iterator, Mapping
from math import pi
from pathlib import Path

import numpy as np

from bearingsim.measured.arrays import identify_content
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
    find_contradiction,
)
from bearingsim.measured.exchange import read_tdms, read_uff
from bearingsim.measured.matlab import read_hdf5, read_mat
from bearingsim.measured.sound import read_wav
from bearingsim.measured.tables import read_csv, read_parquet

MAX_BYTES = 1 << 30
"""Size limit (bytes) of a file, and of the content of a compressed one."""
MAX_INFLATION = 20.0
"""Largest plausible ratio of the size of an array to that of its file; noise does not compress."""
MIN_LIMIT = 1 << 22
"""Memory limit (bytes) of the arrays of a small file."""
FULL_SCALE_UNIT = "of full scale"
"""Unit of integer samples whose value at full scale is unknown."""
MIN_LENGTH_RATIO = 1.5
"""Ratio of the lengths of two channels from which they may have been sampled at different rates."""
MAX_DEVIATION = 0.5
"""Largest deviation of an instant from even spacing, relative to the sampling interval: times may be rounded."""


def read_npz(path: Path, max_bytes: float) -> Content:
    """Read the arrays of an NPZ file; max_bytes: memory limit of all arrays together."""
    with zipfile.ZipFile(path) as archive:
        size = sum(entry.file_size for entry in archive.infolist())
    if size > max_bytes:
        raise MeasuredError(path, f"would take {size / 1e6:.3g} MB, which is not plausible for its size")
    with np.load(path, allow_pickle=False) as archive:
        arrays = {name: _read_array(path, archive, name) for name in archive.files}
    arrays = {name: values for name, values in arrays.items() if isinstance(values, np.ndarray)}
    texts = {name: str(values) for name, values in arrays.items() if values.dtype.kind == "U" and values.size == 1}
    return identify_content(path, {name: v for name, v in arrays.items() if v.dtype.kind in "fiubc"}, texts)


def _read_array(path: Path, archive: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    """Return an array of an NPZ file. Raises MeasuredError if it contains Python objects."""
    try:
        return archive[name]
    except ValueError as error:
        if "allow_pickle" not in str(error):
            raise
        raise MeasuredError(path, f"has Python objects in `{name}`: save it as an array of numbers") from None


FORMATS: dict[str, Callable[[Path, float], Content]] = {
    ".csv": lambda path, max_bytes: read_csv(path),
    ".txt": lambda path, max_bytes: read_csv(path),
    ".lvm": lambda path, max_bytes: read_csv(path),
    ".wav": lambda path, max_bytes: read_wav(path),
    ".mat": read_mat,
    ".npz": read_npz,
    ".parquet": lambda path, max_bytes: read_parquet(path),
    ".h5": read_hdf5,
    ".hdf5": read_hdf5,
    ".uff": lambda path, max_bytes: read_uff(path),
    ".unv": lambda path, max_bytes: read_uff(path),
    ".tdms": lambda path, max_bytes: read_tdms(path),
}
"""Readers by suffix; arguments: path, and memory limit (bytes)."""


def read(
    path: Path, request: Request = UNSPECIFIED, needs_speed: bool = False, needs_unit: bool = False
) -> Recording:
    """Read the channels of a file; values of the request take precedence over those of the file.

    needs_speed: require a speed, of the file or of the request; needs_unit: if another value is missing, the
    message names a missing unit as well. Raises MissingError for missing values, with the options, or keys of a
    study, that set them; MeasuredError for an unknown or damaged format, uneven times, contradicting statements
    and a missing channel; OSError if the file cannot be opened.
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
        content = reader(path, min(MAX_BYTES, max(MIN_LIMIT, MAX_INFLATION * size)))
    except MeasuredError:
        raise
    except Exception as error:
        if isinstance(error, OSError) and error.filename:
            raise
        reason = " ".join(str(error).replace(str(path), path.name).split())[:120] or type(error).__name__
        raise MeasuredError(path, f"cannot be read as a {path.suffix} file, it is damaged ({reason})") from error
    missing = list(_list_missing(content, request, needs_speed))
    if "sampling rate" in missing and content.clock:
        options = request.format_values(EXAMPLES["sampling rate"])
        raise MeasuredError(
            path,
            f"states no sampling rate, and its times are clock times; export them in seconds, or give `{options}`",
        )
    if missing and needs_unit:
        missing += _list_missing_unit(content, request)
    if missing:
        raise MissingError(path, {name: EXAMPLES[name] for name in missing}, request)
    return _make_recording(path, content, request)


def _list_missing(content: Content, request: Request, needs_speed: bool) -> Iterator[str]:
    """Yield the names of quantities that neither the file nor the request states, except units."""
    if not content.rates and not content.times and request.rate is None:
        yield "sampling rate"
    if needs_speed and not content.speeds and request.speed is None:
        yield "speed"


def _list_missing_unit(content: Content, request: Request) -> Iterator[str]:
    """Yield the name of the unit if neither the request nor the file states one for the requested channels."""
    names = content.channels if request.channel is None else [request.channel]
    if request.unit is None and not any(name in content.units for name in names):
        yield "unit" if content.integer_range is None else "unit of integer samples"


def _make_recording(path: Path, content: Content, request: Request) -> Recording:
    """Apply a request to the content of a file. Raises MeasuredError."""
    channels = dict(content.channels)
    unequal_lengths = _list_unequal_lengths(content, request)
    if request.channel is not None:
        if request.channel not in channels:
            raise MeasuredError(path, f"has no channel `{request.channel}`: it has {_list_channels(channels)}")
        content = content.of_channel(request.channel)
        channels = dict(content.channels)
    remarks = *content.remarks.values(), *_list_unused(path, content, request), *unequal_lengths
    scale, unit_of_integers = _choose_scale(path, content, request)
    return Recording(
        path,
        {name: np.asarray(values, float) * scale for name, values in channels.items()},
        _choose_rate(path, content, request),
        _choose_speed(path, content, request, list(channels)),
        {name: _choose_unit(content.units.get(name), request, unit_of_integers) for name in channels},
        remarks,
    )


def _list_unused(path: Path, content: Content, request: Request) -> Iterator[str]:
    """Yield remarks on clock times, and on rates and speeds that differ from those of the request."""
    if content.clock:
        yield f"the clock times in {content.clock} of {path.name} are not used"
    rates = [*content.rates, *(_mean_rate(time) for time in content.times if not _is_coarse(time.value))]
    distinct_rates = {rate.value: rate for rate in reversed(rates)}.values()
    statements: list[tuple[str, float | None, Stated[float], float, str]] = [
        *(("rate", request.rate, rate, 1.0, "Hz") for rate in distinct_rates),
        *(("speed", request.speed, speed, 30.0 / pi, "rpm") for speed in content.speeds.values()),
    ]
    for field, requested, stated, factor, unit in statements:
        if requested is not None and differ(requested, stated.value):
            yield (
                f"{path.name} states {factor * stated.value:.6g} {unit} ({stated.source}): "
                f"`{request.name(field)}`, {factor * requested:.6g} {unit}, is used instead"
            )


def _list_unequal_lengths(content: Content, request: Request) -> Iterator[str]:
    """Yield remarks on channels of one stated rate, but of lengths that suggest two.

    The rate may be that of one of them only. None for a channel and a rate of the request.
    """
    if content.times or (request.rate is not None and request.channel is not None):
        return
    by_source: dict[str, dict[int, str]] = {}
    for name, values in content.channels.items():
        rates = content.of_channel(name).rates
        source = request.name("rate") if request.rate is not None or not rates else rates[0].source
        by_source.setdefault(source, {}).setdefault(len(values), name)
    for source, names in by_source.items():
        shortest, longest = min(names), max(names)
        if longest >= MIN_LENGTH_RATIO * shortest:
            yield (
                f"`{names[longest]}` has {longest} samples, `{names[shortest]}` {shortest}, at one rate "
                f"({source}): if theirs differ, give `{request.name('channel')}` and `{request.name('rate')}`"
            )


def _list_channels(channels: dict[str, np.ndarray]) -> str:
    names = [f"`{name}`" for name in channels]
    return f"{', '.join(names[:8])}{f' and {len(names) - 8} more' if len(names) > 8 else ''}"


def _choose_rate(path: Path, content: Content, request: Request) -> Stated[float]:
    """Return the sampling rate (Hz): of the request, of the times, or stated by the file, in this order.

    Raises MeasuredError for uneven times, contradicting rates, and a rate that is not positive and finite.
    """
    times, rates = content.times, content.rates
    is_stated = request.rate is not None or len(rates) > 0
    if times and not (is_stated and _is_coarse(times[0].value)):
        rate_of_times = _compute_rate(path, times[0], request)
        others = [
            _mean_rate(time) if _is_coarse(time.value) else _compute_rate(path, time, request)
            for time in times[1:]
        ]
        if request.rate is not None:
            return Stated(request.rate, request.name("rate"))
        rounding = 1.0 + 1.0 / len(times[0].value)  # of the ends of the time, by half a sampling interval each
        for stated in (*rates, *others):
            if differ(stated.value, rate_of_times.value) and not (
                rate_of_times.value / rounding <= stated.value <= rate_of_times.value * rounding
            ):
                raise _two_rates_error(path, rate_of_times, stated, request)
        return rate_of_times
    if request.rate is not None:
        return Stated(request.rate, request.name("rate"))
    if not rates:
        raise MissingError(path, {"sampling rate": EXAMPLES["sampling rate"]}, request)
    other_rate = find_contradiction(rates)
    if other_rate is not None:
        raise _two_rates_error(path, rates[0], other_rate, request)
    if not (np.isfinite(rates[0].value) and rates[0].value > 0.0):
        advice = f"give it by `{request.name('rate')}`"
        raise MeasuredError(path, f"states a sampling rate of {rates[0].value:g} Hz: {advice}")
    return rates[0]


def _two_rates_error(path: Path, rate: Stated[float], other: Stated[float], request: Request) -> MeasuredError:
    """Return the error for two sampling rates (Hz) that contradict each other."""
    values = " and ".join(f"{stated.value:g} Hz ({stated.source})" for stated in (rate, other))
    advice = f"give the right one by `{request.name('rate')}`"
    if rate.group != other.group:
        advice = f"name a `{request.name('channel')}`, or {advice}"
    return MeasuredError(path, f"states two sampling rates, {values}: {advice}")


def _choose_speed(path: Path, content: Content, request: Request, names: list[str]) -> Stated[float] | None:
    """Return the speed (rad/s) of the request or of the named channels; None if neither states one.

    Raises MeasuredError for a speed that is not positive and finite, and for several speeds.
    """
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
    """Check if instants (s) are rounded so coarsely that most neighbours are equal."""
    steps = np.diff(time)
    return len(steps) > 0 and bool(np.all(steps >= 0.0)) and float(np.median(steps)) == 0.0


def _mean_rate(time: Stated[np.ndarray]) -> Stated[float]:
    """Return the mean sampling rate (Hz) of instants (s); NaN if it is not defined."""
    span = float(time.value[-1] - time.value[0])
    return Stated((len(time.value) - 1) / span if span else float("nan"), time.source, time.group)


def _compute_rate(path: Path, time: Stated[np.ndarray], request: Request) -> Stated[float]:
    """Compute the mean sampling rate (Hz) of instants (s).

    Raises MeasuredError for missing or decreasing instants, gaps, uneven spacing and coarse rounding.
    """
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
    gaps = np.flatnonzero(np.abs(steps - median) > MAX_DEVIATION * median)
    if len(gaps):
        begin, step, expected = float(time.value[gaps[0]]), 1e3 * steps[gaps[0]], 1e3 * median
        raise MeasuredError(
            path,
            f"has {len(gaps)} gap{'s' * (len(gaps) != 1)} in {time.source}, the first after {begin:.6g} s "
            f"({step:.4g} ms instead of {expected:.4g} ms): export a part without gaps",
        )
    mean = (time.value[-1] - time.value[0]) / len(steps)
    deviation = np.abs(time.value - time.value[0] - mean * np.arange(len(time.value))).max()
    if deviation > MAX_DEVIATION * mean:
        raise MeasuredError(
            path,
            f"has unevenly spaced times in {time.source} (deviation up to {1e3 * deviation:.4g} ms): resample it",
        )
    return Stated(float(1.0 / mean), time.source, time.group)


def _choose_scale(path: Path, content: Content, request: Request) -> tuple[float, str | None]:
    """Return the factor of the samples, and the unit of integer samples without a full scale, else None.

    Raises MeasuredError for a full scale of samples that are not integers.
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
    return full_scale / content.integer_range, None if request.full_scale is not None else FULL_SCALE_UNIT


def _choose_unit(file_unit: str | None, request: Request, unit_of_integers: str | None) -> Stated[str]:
    """Return the unit of a channel and its source; "" if neither the request nor the file states it."""
    if unit_of_integers is not None:
        fields = f"`{request.name('unit')}` and `{request.name('full_scale')}`"
        return Stated(unit_of_integers, f"integer samples; set their unit by {fields}")
    if request.unit is not None:
        return Stated(request.unit, request.name("unit"))
    if file_unit:
        return Stated(file_unit, "the file")
    return Stated("", f"not stated; set it by `{request.name('unit')}`")
