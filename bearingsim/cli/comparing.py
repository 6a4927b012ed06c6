"""`bearingsim compare`: a simulated job and a measured signal side by side."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from bearingsim.cli.opening import short_path
from bearingsim.cli.screen import print_table
from bearingsim.errors import UserError
from bearingsim.text.numbers import significant
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    from bearingsim.diagnosis import Lines
    from bearingsim.measured import Recording, Request
    from bearingsim.store import Results


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

    request: what the user states in place of the file; y: the job's channel; scale: multiply the simulated signal
    by a factor, to the measured RMS. Raises UserError for a channel, unit or speed that does not fit.
    """
    from bearingsim.diagnosis.comparison import Signal, common_band, compare
    from bearingsim.measured import read
    from bearingsim.measured.checks import refuse_unusable
    from bearingsim.plots import lines
    from bearingsim.plots.measured import check_path, draw_comparison

    if figure is not None:
        check_path(figure)
    series, parameters = results.series(job), _parameters(results, job)
    channel = _channel(list(series.channels), y)
    recording = read(file, request)
    name = _only_channel(recording)
    refuse_unusable(file, name, recording.channels[name], recording.rate.value)
    unit = series.units[channel]
    measured_values = recording.channels[name] * _factor(recording, name, channel, unit)
    shaft = float(parameters["speed"]) / (2.0 * math.pi)
    fs = 1.0 / float(series.time[1] - series.time[0])
    race = (lines.races(parameters) or ["outer"])[0]
    measured_shaft = shaft if recording.speed is None else recording.shaft
    simulated = Signal(series.channels[channel].astype(float), fs, lines_of(parameters, shaft))
    measured = Signal(measured_values, recording.rate.value, lines_of(parameters, measured_shaft))
    band = common_band(simulated, measured)
    rows = compare(simulated, measured, race, band, unit)
    factor = rows[0].measured / rows[0].simulated if scale else 1.0
    if scale:
        simulated = simulated._replace(series=factor * simulated.series)
        rows = compare(simulated, measured, race, band, unit)
    if figure is not None:
        draw_comparison(
            simulated, measured, race, band, (f"job {job[:8]}, {channel}", f"{file.name}, {name}"), unit, figure
        )
    if as_json:
        values = {
            row.name: {"unit": row.unit, "simulated": _json(row.simulated), "measured": _json(row.measured)}
            for row in rows
        }
        facts = {"job": job, "channel": channel, "file": str(file), "measured_channel": name, "race": race}
        say(json.dumps({**facts, "band_hz": list(band), "scale": factor, "features": values}, indent=1))
        return
    say(f"job {job}: {channel}, {len(simulated.series) / fs:.4g} s at {fs:g} Hz")
    rate, seconds = recording.rate, len(measured_values) / recording.rate.value
    say(f"{short_path(file)}: {name}, {seconds:.4g} s at {rate.value:g} Hz ({rate.source})")
    source = "the job; `--speed` gives another" if recording.speed is None else recording.speed.source
    say(f"speed of the measurement: {measured_shaft * 60.0:.6g} rpm ({source})")
    say(f"both in the band {band[0] / 1e3:g} to {band[1] / 1e3:.4g} kHz")
    if scale:
        say(f"simulated signal times {factor:.4g}, to the measured RMS")
    print_table(
        ["", "unit", "simulated", "measured", "difference", "ratio"],
        [
            [row.name, row.unit, *(_number(value) for value in (row.simulated, row.measured)), *_differences(row)]
            for row in rows
        ],
        text_columns=2,
    )
    if figure is not None:
        say(short_path(figure))


def only_job(results: "Results") -> str:
    """Return the only job with a defect and series. Raises UserError if there are several, or none."""
    from bearingsim.plots.lines import races

    damaged = [job for job in results.jobs if races(_parameters(results, job))]
    candidates = damaged or list(results.jobs)
    if len(candidates) != 1:
        raise UserError(
            f"{len(candidates)} jobs could be compared: name one by `--job`; "
            f"`bearingsim show {short_path(results.path)}` lists them"
        )
    return candidates[0]


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


def _channel(channels: list[str], y: str | None) -> str:
    """Return the channel to compare: the requested one, else the first acceleration."""
    if not channels:
        raise UserError("the job has no series because the study has `record: []`")
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


def _factor(recording: "Recording", name: str, channel: str, unit: str) -> float:
    """Return the factor from the measured unit to that of the job's channel."""
    from bearingsim.measured import MeasuredError
    from bearingsim.measured.si import FACTORS, factor_to

    own = recording.units[name].value
    factor = factor_to(unit, own)
    if factor is None:
        choices = ", ".join(FACTORS.get(unit, {unit: 1.0}))
        statement = f"has `{name}` in `{own}`" if own else f"states no unit of `{name}`"
        raise MeasuredError(
            recording.path, f"{statement}; {channel} is in {unit}: give `--unit`, one of {choices}"
        )
    return factor


def _differences(row: Any) -> list[str]:
    if not (math.isfinite(row.simulated) and math.isfinite(row.measured)):
        return ["-", "-"]
    ratio = row.simulated / row.measured if row.unit != "dB" and row.measured else math.nan
    return [_number(row.simulated - row.measured), _number(ratio)]


def _number(value: float) -> str:
    return significant(value, 4) if math.isfinite(value) else "-"


def _json(value: float) -> float | None:
    return value if math.isfinite(value) else None
