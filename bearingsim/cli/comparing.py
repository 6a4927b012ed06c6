"""`bearingsim compare`: a simulated job and a measured signal side by side."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import typer

from bearingsim.cli.analysis import LINE_NAMES, source_of_low_rate
from bearingsim.cli.opening import shell_path, short_path
from bearingsim.cli.screen import print_table
from bearingsim.errors import UserError
from bearingsim.text.numbers import significant
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    import numpy as np

    from bearingsim.diagnosis import Lines
    from bearingsim.diagnosis.comparison import Row, Signal
    from bearingsim.diagnosis.detection import Detection
    from bearingsim.measured import Recording, Request
    from bearingsim.store import Results


NO_SERIES = "run the study with `record: [ring.acceleration]`, for example, instead of `record: []`"


class Pair(NamedTuple):
    """Simulated and measured signal of a bearing, names of their channels, the race with the defect, and unit.

    The unit is that of the job's channel (SI). If the simulated signal is scaled to a measured one in another or
    an unknown unit, it is the unit of the file.
    """

    simulated: "Signal"
    measured: "Signal"
    recording: "Recording"
    channels: tuple[str, str]
    race: str
    unit: str


def show(
    results: "Results",
    job: str,
    file: Path,
    request: "Request",
    y: str | None,
    scale: bool,
    figure: Path | None,
    as_json: bool,
) -> None:
    """Print features of a job's channel and of a measured signal, and draw both.

    request: values of the options, which replace those of the file; y: the job's channel; scale: multiply the
    simulated signal by the factor that gives it the measured RMS. Raises UserError for an unsuitable channel, unit
    or speed.
    """
    from bearingsim.diagnosis.comparison import common_band, compare
    from bearingsim.measured.checks import describe_dropouts

    if figure is not None:
        from bearingsim.plots import measured as figures

        figures.check_path(figure)
    pair = _read_pair(results, job, file, request, y, scale)
    band = common_band(pair.simulated, pair.measured)
    detection, line_remarks = _detect_line(pair)
    line = detection.comb.frequency if detection and detection.objection is None else math.nan
    rows = compare(pair.simulated, pair.measured, pair.race, band, pair.unit, line)
    factor = _ratio_of_levels(rows[0], job, pair, _zero_level(results, job, pair)) if scale else None
    if factor is not None:
        pair = pair._replace(simulated=pair.simulated._replace(series=factor * pair.simulated.series))
        rows = compare(pair.simulated, pair.measured, pair.race, band, pair.unit, line)
    if figure is not None:
        names = f"job {job[:8]}, {pair.channels[0]}", f"{file.name}, {pair.channels[1]}"
        signals = pair.simulated, pair.measured
        figures.write(figures.draw_comparison(*signals, pair.race, band, names, pair.unit, factor), figure)
    dropout_remark = describe_dropouts(pair.channels[1], pair.measured.series, pair.measured.fs)
    for text in filter(None, (*pair.recording.remarks, dropout_remark)):
        say(text, err=True)
    if as_json:
        say(json.dumps(_as_dict(job, pair, band, factor, detection, rows), indent=1))
        return
    _print_signals(job, pair, band, factor)
    _print_features(rows, detection is not None)
    for text in line_remarks:
        say(text)
    if figure is not None:
        say(short_path(figure))


def _read_pair(results: "Results", job: str, file: Path, request: "Request", y: str | None, scale: bool) -> Pair:
    """Read both signals, in one unit unless the simulated one is scaled, with the lines at their speeds."""
    from bearingsim.diagnosis.comparison import Signal
    from bearingsim.measured import read
    from bearingsim.measured.checks import refuse_unusable
    from bearingsim.plots import lines

    series, parameters = results.series(job), _parameters(results, job)
    channel = _choose_channel(list(series.channels), y)
    recording = read(file, request, needs_unit=not scale)
    name, rate = _only_channel(recording), recording.rate.value
    refuse_unusable(file, name, recording.channels[name], rate)
    unit = series.units[channel]
    factor = _unit_factor(recording, name, channel, unit, scale)
    values = recording.channels[name] * (factor or 1.0)
    info = results.info().loc[job].to_dict()
    shaft = _steady_speed(job, lines.speeds(parameters, info, series.time)) / (2.0 * math.pi)
    measured_shaft = shaft if recording.speed is None else recording.shaft
    fs = 1.0 / float(series.time[1] - series.time[0])
    simulated = Signal(series.channels[channel].astype(float), fs, lines_of(parameters, shaft))
    measured = Signal(values, rate, lines_of(parameters, measured_shaft))
    race = (lines.races(parameters) or ["outer"])[0]
    return Pair(
        simulated, measured, recording, (channel, name), race, unit if factor else recording.units[name].value
    )


def _zero_level(results: "Results", job: str, pair: Pair) -> float:
    """Return the RMS (SI) up to which the simulated channel is zero within numerical errors.

    A component is zero next to the motion along the sensor, too.
    """
    from bearingsim.store.zero import EQUALITY_TOLERANCE

    quantity = pair.channels[0].split(".")[1]
    row = results.frame.loc[job].to_dict()
    values = (float(row.get(f"features/{quantity}.{name}", math.nan)) for name in ("rounding", "rms"))
    rounding, rms = (value if math.isfinite(value) else 0.0 for value in values)
    return rounding + EQUALITY_TOLERANCE * rms


def _ratio_of_levels(row: "Row", job: str, pair: Pair, zero: float) -> float:
    """Return the factor from the simulated to the measured RMS.

    Raises UserError for a simulated RMS of at most ``zero`` (SI).
    """
    channel = pair.channels[0]
    if row.simulated <= zero:
        raise UserError(
            f"{channel} of job {job} is zero within numerical errors, which no factor scales: "
            "name another channel by `--y`"
        )
    return row.measured / row.simulated


def _detect_line(pair: Pair) -> "tuple[Detection | None, list[str]]":
    """Compare the race's line with the rest of the measured signal; None if it cannot be assessed. Also return
    remarks."""
    from bearingsim.diagnosis.comparison import detect_line
    from bearingsim.diagnosis.suitability import Unsuitable
    from bearingsim.diagnosis.thresholds import decibels

    line = LINE_NAMES[pair.race]
    try:
        result = detect_line(pair.measured, pair.race)
    except Unsuitable as error:
        advice = source_of_low_rate(pair.recording) or _effect_of_short_record(pair)
        return None, [f"{line} of the measured signal cannot be assessed: {error}{advice}"]
    score, needed = (f"{decibels(value):.1f} dB" for value in (result.comb.score, result.threshold))
    values = f"score {score}, threshold {needed}"
    if result.objection is None:
        return result, [f"{line} of the measured signal: {values}"]
    if not result.is_over:
        reason = f"no line over the threshold ({values})"
    elif result.is_crowded:
        reason = f"not significant, {100.0 * result.crowded:.0f} % of all periodicities are as strong ({values})"
    else:
        reason = _describe_stronger(result, pair)
    return result, [f"{line} of the measured signal: {reason}; check speed and bearing by `bearingsim analyze`"]


def _effect_of_short_record(pair: Pair) -> str:
    """Return a remark on the level of a measured record of few passes of the race; else empty."""
    from bearingsim.diagnosis.suitability import MIN_PERIODS

    measured = pair.measured
    if len(measured.series) / measured.fs * measured.lines.of_race(pair.race) >= MIN_PERIODS:
        return ""
    return "; its RMS, peak, crest factor and kurtosis depend on where it begins, as does the factor of `--scale`"


def _describe_stronger(detection: "Detection", pair: Pair) -> str:
    """Describe the periodicity that the measured signal has instead of the line of the race."""
    from bearingsim.diagnosis.comparison import TOLERANCE
    from bearingsim.diagnosis.thresholds import decibels

    other, comb = detection.strongest_other, detection.comb
    line, lines = LINE_NAMES[pair.race], pair.measured.lines
    scores = f"({decibels(other.score):.1f} dB, {line} {decibels(comb.score):.1f} dB)"
    if detection.is_of_shaft:
        order = round(other.frequency / lines.shaft)
        return f"order {order} of the shaft, {other.frequency:.2f} Hz, explains it {scores}"
    if other is comb:
        deviation = 100.0 * (comb.frequency / lines.of_race(pair.race) - 1.0)
        return (
            f"the line found, {comb.frequency:.2f} Hz, deviates by {deviation:+.2f} %, over {100 * TOLERANCE:g} %"
        )
    return f"a periodicity of {other.frequency:.2f} Hz is stronger {scores}"


def _speed_of_job(pair: Pair) -> str:
    """Return a remark on the speed of the job if the measurement has another one; else empty."""
    from bearingsim.measured.arrays import MAX_CHANGE
    from bearingsim.measured.content import differ

    job, measured = pair.simulated.lines.shaft, pair.measured.lines.shaft
    if not differ(measured, job, MAX_CHANGE):
        return ""
    return f"; the job has {60.0 * job:.6g} rpm, and levels depend on the speed"


def _source_of_speed(recording: "Recording") -> str:
    return "the job" if recording.speed is None else recording.speed.source


def _print_signals(job: str, pair: Pair, band: tuple[float, float], factor: float | None) -> None:
    """Print duration and rate of both signals, the speed of the measurement, the common band, and the scaling."""
    (channel, name), rate = pair.channels, pair.recording.rate
    say(
        f"job {job}: {channel}, {len(pair.simulated.series) / pair.simulated.fs:.4g} s at {pair.simulated.fs:g} Hz"
    )
    seconds = len(pair.measured.series) / rate.value
    say(f"{short_path(pair.recording.path)}: {name}, {seconds:.4g} s at {rate.value:g} Hz ({rate.source})")
    advice = "; to change it, use `--speed`" if pair.recording.speed is None else ""
    speed = f"{pair.measured.lines.shaft * 60.0:.6g} rpm"
    say(f"speed of the measurement: {speed} ({_source_of_speed(pair.recording)}{advice}){_speed_of_job(pair)}")
    say(f"both in the band {band[0] / 1e3:g} to {band[1] / 1e3:.4g} kHz")
    if factor is not None:
        from bearingsim.measured.si import FACTORS
        from bearingsim.plots.labels import format_unit

        unit = pair.unit or "the unit of the file, which is not stated"
        in_unit = "" if unit in FACTORS else f", in {format_unit(unit)}"
        say(f"simulated signal times {factor:.4g}, to the measured RMS{in_unit}")


def _print_features(rows: "list[Row]", is_assessed: bool) -> None:
    """Print the features of both signals, and the meaning of a dash."""
    from bearingsim.plots.labels import format_unit
    from bearingsim.report.measured import DIFFERENCE, RATIO

    cells = [
        [
            row.name,
            format_unit(row.unit),
            *(_number(value) for value in (row.simulated, row.measured)),
            *_difference_and_ratio(row),
        ]
        for row in rows
    ]
    print_table(["", "unit", "simulated", "measured", DIFFERENCE, RATIO], cells, text_columns=2)
    if any("-" in row[2:4] for row in cells):
        say(f"-: not found in the signal{'' if is_assessed else ', or not assessed'}")
    compared = [row for row in rows if math.isfinite(row.simulated) and math.isfinite(row.measured)]
    if any(row.unit == "dB" for row in compared):
        say("-: no ratio, because the values are in dB")
    if any(row.unit != "dB" and not row.measured for row in compared):
        say("-: no ratio, because the measured value is zero")


def _as_dict(
    job: str,
    pair: Pair,
    band: tuple[float, float],
    factor: float | None,
    detection: "Detection | None",
    rows: "list[Row]",
) -> dict[str, Any]:
    """Return the values of `--json`."""
    from bearingsim.diagnosis.thresholds import decibels

    recording, (channel, name) = pair.recording, pair.channels
    return {
        "job": job,
        "channel": channel,
        "file": str(recording.path),
        "measured_channel": name,
        "race": pair.race,
        "simulated_rate_hz": pair.simulated.fs,
        "simulated_speed_rpm": pair.simulated.lines.shaft * 60.0,
        "rate_hz": recording.rate.value,
        "rate_source": recording.rate.source,
        "speed_rpm": pair.measured.lines.shaft * 60.0,
        "speed_source": _source_of_speed(recording),
        "unit": recording.units[name].value,
        "unit_source": recording.units[name].source,
        "band_hz": list(band),
        "scale": 1.0 if factor is None else factor,
        "score_db": decibels(detection.comb.score) if detection else None,
        "threshold_db": decibels(detection.threshold) if detection else None,
        "objection": detection.objection if detection else None,
        "rival": _strongest_other(detection) if detection else None,
        "features": {
            row.key: {"unit": row.unit, "simulated": _json(row.simulated), "measured": _json(row.measured)}
            for row in rows
        },
    }


def _strongest_other(detection: "Detection") -> dict[str, float]:
    """Return the strongest other periodicity, with the keys of `analyze --json`."""
    from bearingsim.diagnosis.thresholds import decibels

    other = detection.strongest_other
    return {"hz": other.frequency, "score_db": decibels(other.score), "crowded": detection.crowded}


def only_job(results: "Results") -> str:
    """Return the only job with a defect and series.

    Raises UserError if there are several, or none, or if jobs are not done.
    """
    from bearingsim.plots.lines import races

    unfinished = set(results.jobs).difference(results.parameters().index)
    if unfinished:  # one of them may be the job that is meant
        count = f"{len(unfinished)} of {len(results.jobs)} jobs are not done"
        raise UserError(f"{count}: run the study to its end, or name a finished job by `--job`")
    recorded = [job for job in results.jobs if _parameters(results, job).get("record")]
    if results.jobs and not recorded:
        raise UserError(f"no job has a time series: {NO_SERIES}")
    damaged = [job for job in recorded if races(_parameters(results, job))]
    candidates = damaged or recorded
    if len(candidates) != 1:
        raise UserError(
            f"{len(candidates)} jobs could be compared: name one by `--job`; "
            f"`bearingsim show {shell_path(results.path)}` lists them"
        )
    return candidates[0]


def _steady_speed(job: str, speed: "np.ndarray") -> float:
    """Return the mean (rad/s) of a job's ``speed`` (n,). Raises UserError if a ramp changes it in the record."""
    from bearingsim.measured.arrays import MAX_CHANGE

    mean = float(speed.mean())
    if speed.max() - speed.min() > MAX_CHANGE * mean:
        ends = " to ".join(f"{end * 30.0 / math.pi:.4g}" for end in (speed[0], speed[-1]))
        raise UserError(
            f"the speed of job {job} changes in its record, from {ends} rpm: its lines have no frequency; "
            "lengthen `settle` beyond the ramp, and run again"
        )
    return mean


def _parameters(results: "Results", job: str) -> dict[str, Any]:
    """Return the parameters of a job (SI) that have a value."""
    row = results.parameters().loc[[job]].iloc[0].replace("", None).dropna()
    return {str(name): value for name, value in row.items()}


def lines_of(parameters: Mapping[str, Any], shaft: float) -> "Lines":
    """Return the kinematic lines (Hz) of a job's bearing at a frequency of the shaft (Hz)."""
    from bearingsim.config.names import Line
    from bearingsim.diagnosis import Lines
    from bearingsim.plots.lines import frequency

    values = {**parameters, "speed": 2.0 * math.pi * shaft}
    kinds = {"cage": Line(cage=1), "outer": Line(outer=1), "inner": Line(inner=1), "roller": Line(spin=2)}
    return Lines(shaft=shaft, **{name: frequency(line, values) for name, line in kinds.items()})


def _choose_channel(channels: list[str], y: str | None) -> str:
    """Return the channel to compare: the requested one, else the first acceleration."""
    if not channels:
        raise UserError(f"the job has no time series: {NO_SERIES}")
    if y is None:
        return next((name for name in channels if "acceleration" in name), channels[0])
    if y not in channels:
        raise typer.BadParameter(f"the job recorded {', '.join(channels)}, not `{y}`", param_hint="--y")
    return y


def _only_channel(recording: "Recording") -> str:
    """Return the name of the only channel. Raises MeasuredError if there are several."""
    from bearingsim.measured import MeasuredError

    names = list(recording.channels)
    if len(names) > 1:
        raise MeasuredError(
            recording.path, f"has {len(names)} channels: name one by `--channel`, such as `{names[0]}`"
        )
    return names[0]


def _unit_factor(recording: "Recording", name: str, channel: str, unit: str, scale: bool) -> float | None:
    """Return the factor from the unit of the file to that of the job's channel.

    If there is none, return None if the simulated signal is scaled and the unit of the file is that of no other
    quantity, such as V; else raise MeasuredError.
    """
    from bearingsim.measured import MeasuredError
    from bearingsim.measured.files import FULL_SCALE_UNIT
    from bearingsim.measured.si import FACTORS, factor_to

    file_unit = recording.units[name].value
    factor = factor_to(unit, file_unit)
    if file_unit == FULL_SCALE_UNIT and not scale:
        advice = "give their unit and its value at full scale, as in `--unit g --full-scale 50`"
        raise MeasuredError(recording.path, f"has integer samples, which have no unit: {advice}")
    if factor is None and not scale:
        choices = ", ".join(FACTORS.get(unit, {unit: 1.0}))
        statement = f"has `{name}` in `{file_unit}`" if file_unit else f"states no unit of `{name}`"
        raise MeasuredError(
            recording.path, f"{statement}; {channel} is in {unit}: give `--unit`, one of {choices}"
        )
    other_quantities = (units for si_unit, units in FACTORS.items() if si_unit not in (unit, ""))
    if factor is None and any(file_unit in units for units in other_quantities):
        raise MeasuredError(
            recording.path,
            f"has `{name}` in `{file_unit}`, another quantity than {channel} in {unit}, which no factor converts: "
            "name a channel of the job by `--y`, or give the right unit by `--unit`",
        )
    return factor


def _difference_and_ratio(row: Any) -> list[str]:
    if not (math.isfinite(row.simulated) and math.isfinite(row.measured)):
        return ["-", "-"]
    ratio = row.simulated / row.measured if row.unit != "dB" and row.measured else math.nan
    return [_number(row.simulated - row.measured), _number(ratio)]


def _number(value: float) -> str:
    return significant(value, 4) if math.isfinite(value) else "-"


def _json(value: float) -> float | None:
    return value if math.isfinite(value) else None
