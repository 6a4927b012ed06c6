"""`bearingsim analyze`: a measured signal, its verdict and the evidence."""

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from bearingsim.cli.opening import short_path
from bearingsim.cli.screen import print_table
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    from bearingsim.config.sections.machine import RollingParts
    from bearingsim.diagnosis import Diagnosis
    from bearingsim.diagnosis.kurtogram import Kurtogram
    from bearingsim.measured import Recording, Request

KURTOGRAM = "kurtogram"
BAND = re.compile(r"^\s*(?P<low>[\d.]+)\s*(?P<unit>k?Hz)?\s*(?:-|\.\.)\s*(?P<high>[\d.]+)\s*(?P<last>k?Hz)\s*$")
MISSING_BEARING = "bearing", {"bearing": "6205"}
"""Name of a missing bearing, and an example of its option, as ``MissingError`` takes them."""
LINE_NAMES = {"outer": "BPFO", "inner": "BPFI", "roller": "2 BSF"}
VERDICTS = {
    "outer": "outer race",
    "inner": "inner race",
    "roller": "rolling element",
    "outer or roller": "outer race or rolling element (lines within the tolerance; sidebands inconclusive)",
}

Band = tuple[float, float] | str | None


def make_request(
    rate: str | None, speed: str | None, unit: str | None, full_scale: float | None, channel: str | None
) -> "Request":
    """Return the values of the options, which replace those of the file. Raises BadParameter."""
    from bearingsim.measured import Request

    if full_scale is not None and not full_scale > 0.0:
        raise typer.BadParameter("expected a value above zero", param_hint="--full-scale")
    if full_scale is not None and unit is None:
        raise typer.BadParameter("needs the unit of the full scale, such as `--unit g`", param_hint="--full-scale")
    return Request(
        _positive("--rate", rate, "frequency"), _positive("--speed", speed, "rotation"), unit, full_scale, channel
    )


def _positive(option: str, text: str | None, dimension: Any) -> float | None:
    from bearingsim.text.units import EXPECTED, UnitError, parse

    if text is None:
        return None
    try:
        value = parse(text, dimension)
    except UnitError as error:
        raise typer.BadParameter(str(error), param_hint=option) from None
    if value <= 0.0:
        raise typer.BadParameter(f"expected {EXPECTED[dimension]} above zero, got `{text}`", param_hint=option)
    return value


def parse_tolerance(text: str) -> float:
    """Parse the relative tolerance of lines. Raises BadParameter outside the range of the thresholds."""
    from bearingsim.diagnosis.thresholds import TOLERANCES

    value = _positive("--tolerance", text, "tolerance")
    low, high = TOLERANCES
    if value is None or not low <= value <= high:
        raise typer.BadParameter(
            f"expected {100 * low:g} % to {100 * high:g} %, for which thresholds were measured, got `{text}`",
            param_hint="--tolerance",
        )
    return value


def parse_band(text: str | None) -> Band:
    """Parse a band: None, "kurtogram", or two frequencies (Hz). Raises BadParameter."""
    if text is None or text.strip() == KURTOGRAM:
        return text and KURTOGRAM
    match = BAND.match(text)
    if match:
        factors = {"Hz": 1.0, "kHz": 1e3}
        try:
            low = float(match["low"]) * factors[match["unit"] or match["last"]]
            high = float(match["high"]) * factors[match["last"]]
        except ValueError:
            low = high = 0.0
        if low < high:
            return low, high
    raise typer.BadParameter(
        f"expected a band such as `2-5 kHz`, or `kurtogram`, got `{text}`", param_hint="--band"
    )


def show(
    file: Path,
    bearing: str | None,
    request: "Request",
    tolerance: float,
    band: Band,
    figure: Path | None,
    as_json: bool,
) -> None:
    """Print the diagnosis of all channels of a file, and draw the figure of the one with the clearest result.

    Raises MissingError with all that is stated neither by the file nor by options, the bearing included.
    """
    from bearingsim.measured import MissingError, read
    from bearingsim.measured.checks import describe_dropouts
    from bearingsim.study import load_rolling_parts

    if figure is not None:
        from bearingsim.plots import measured

        measured.check_path(figure)
    try:
        recording = read(file, request, needs_speed=True)
    except MissingError as error:
        raise error if bearing is not None else error.with_missing(*MISSING_BEARING) from None
    if bearing is None:
        raise MissingError(file, dict([MISSING_BEARING]))
    parts = load_rolling_parts(bearing)
    results = _diagnose_channels(file, recording, parts, tolerance, band)
    clearest = max(results, key=lambda name: _clearness(results[name][0]))
    if figure is not None:
        canvas = measured.draw_diagnosis(recording, clearest, *results[clearest], parts.name or bearing)
        measured.write(canvas, figure)
    fs = recording.rate.value
    dropouts = (describe_dropouts(name, values, fs) for name, values in recording.channels.items())
    for text in (*recording.remarks, *filter(None, dropouts)):
        say(text, err=True)
    if as_json:
        say(json.dumps(as_dict(recording, bearing, tolerance, results, clearest), indent=1))
        return
    _print_header(recording, parts.name or bearing, tolerance, results[clearest][0])
    for name, (diagnosis, _, used_band) in results.items():
        say("")
        say(f"{name}: {verdict_text(diagnosis)}" if len(results) > 1 else verdict_text(diagnosis))
        _print_evidence(diagnosis, used_band)
    if figure is not None:
        say(f"\n{short_path(figure)}")


def _diagnose_channels(
    file: Path, recording: "Recording", parts: "RollingParts", tolerance: float, band: Band
) -> "dict[str, tuple[Diagnosis, Kurtogram, tuple[float, float]]]":
    """Return diagnosis, kurtogram and band (Hz) of each channel. Raises MeasuredError for an unsuitable one."""
    from bearingsim.diagnosis import Lines, diagnose
    from bearingsim.diagnosis.envelopes import default_band
    from bearingsim.diagnosis.kurtogram import kurtogram
    from bearingsim.diagnosis.size import refuse_width_across_load
    from bearingsim.diagnosis.suitability import Unsuitable, refuse_unsuitable
    from bearingsim.measured import MeasuredError
    from bearingsim.measured.checks import refuse_unusable

    fs, shaft = recording.rate.value, recording.shaft
    results = {}
    for name, values in recording.channels.items():
        refuse_unusable(file, name, values, fs)
        image = kurtogram(values, fs)
        used_band = image.best if band == KURTOGRAM else band if isinstance(band, tuple) else default_band(fs)
        try:
            refuse_unsuitable(len(values), fs, Lines.of(parts, shaft), used_band)
        except Unsuitable as error:
            advice = source_of_low_rate(recording) + _other_channel(recording, name)
            raise MeasuredError(file, f"`{name}`: {error}{advice}") from None
        diagnosis = diagnose(values, fs, parts, shaft, tolerance, used_band)
        unit = recording.units[name].value
        same_unit = {
            key: series for key, series in recording.channels.items() if recording.units[key].value == unit
        }
        size = refuse_width_across_load(diagnosis.size, name, same_unit, fs)
        results[name] = diagnosis._replace(size=size), image, used_band
    return results


def source_of_low_rate(recording: "Recording") -> str:
    """Return the source of a sampling rate below that of a diagnosis, with the remedy; else empty.

    Times in ms, or numbers of samples, without a unit are taken in s, and yield such a rate.
    """
    from bearingsim.diagnosis.suitability import MIN_RATE_HZ
    from bearingsim.measured.content import UNSPECIFIED

    option, rate = UNSPECIFIED.name("rate"), recording.rate
    if rate.value >= MIN_RATE_HZ or rate.source == option:
        return ""
    return f"; this rate follows from {rate.source}: if it is wrong, give the right one by `{option}`"


def _other_channel(recording: "Recording", name: str) -> str:
    """Return the advice to name the longest channel if it is longer than the unsuitable one; else empty."""
    lengths = {channel: len(values) for channel, values in recording.channels.items()}
    longest = max(lengths, key=lambda channel: lengths[channel])
    return f"; or name a longer one, `--channel {longest}`" if lengths[longest] > lengths[name] else ""


def _clearness(diagnosis: "Diagnosis") -> tuple[bool, float]:
    """Return the sort key of a channel: whether a race is named, then the score's excess over the threshold."""
    score = diagnosis.findings[diagnosis.best].comb.score
    return diagnosis.verdict in VERDICTS, score - diagnosis.threshold


def verdict_text(diagnosis: "Diagnosis") -> str:
    """Format the verdict of a channel, with its frequency."""
    from bearingsim.diagnosis import NONE, RHYTHM
    from bearingsim.diagnosis.thresholds import decibels

    needed = f"{decibels(diagnosis.threshold):.1f} dB"
    if diagnosis.verdict == RHYTHM:
        other = f"a periodicity of {diagnosis.strongest_other.frequency:.2f} Hz"
        if diagnosis.is_of_shaft:
            order = round(diagnosis.strongest_other.frequency / diagnosis.lines.shaft)
            line = LINE_NAMES[diagnosis.best]
            return f"verdict: {other}, order {order} of the shaft, whose harmonics explain {line}; check the shaft"
        return f"verdict: {other} that matches no line of this bearing at this speed; check bearing and speed"
    finding = diagnosis.findings[diagnosis.best]
    if diagnosis.verdict == NONE and finding.comb.score > diagnosis.threshold:
        share = f"{100.0 * diagnosis.crowded:.0f} %"
        return f"verdict: none found; {share} of all periodicities of this record are as strong"
    if diagnosis.verdict == NONE:
        return f"verdict: none found; a line would need {needed} over the local median"
    score = f"{decibels(finding.comb.score):.1f} dB, threshold {needed}"
    healthy = ", or a healthy bearing with clearance" if diagnosis.clearance_may_cause else ""
    return f"verdict: {VERDICTS[diagnosis.verdict]}{healthy}, {finding.comb.frequency:.2f} Hz ({score})"


def _print_header(recording: "Recording", bearing: str, tolerance: float, diagnosis: "Diagnosis") -> None:
    from bearingsim.plots.labels import format_unit

    rate, speed, lines = recording.rate, recording.speed, diagnosis.lines
    seconds = sorted({len(values) / rate.value for values in recording.channels.values()})
    duration = " to ".join(f"{value:.4g}" for value in dict.fromkeys((seconds[0], seconds[-1])))
    say(f"{short_path(recording.path)}: {duration} s at {rate.value:g} Hz ({rate.source})")
    units: dict[str, list[str]] = {}
    for name, unit in recording.units.items():
        units.setdefault(f"{format_unit(unit.value) or 'no unit'} ({unit.source})", []).append(name)
    for text, names in units.items():
        say(f"unit of {', '.join(names[:4])}{' ...' if len(names) > 4 else ''}: {text}")
    if speed is not None:
        say(f"{bearing} at {lines.shaft * 60.0:.6g} rpm ({speed.source}), lines within {100.0 * tolerance:g} %")


def _print_evidence(diagnosis: "Diagnosis", band: tuple[float, float]) -> None:
    from bearingsim.diagnosis.detection import MAX_CROWDED
    from bearingsim.diagnosis.thresholds import decibels

    headers = [
        "line", "expected (Hz)", "found (Hz)", "deviation", "harmonics (dB)", "levelled (dB)", "score (dB)",
        "± fr (dB)", "± FTF (dB)",
    ]  # fmt: skip
    rows = []
    for race, finding in diagnosis.findings.items():
        envelope, levelled = (
            ", ".join(f"{round(power_db(height))}" for height in heights) for heights in finding.comb.heights
        )
        sidebands = (
            ", ".join(f"{round(_log_power_db(value))}" for value in values[1:])
            for values in (finding.shaft_sidebands, finding.cage_sidebands)
        )
        rows.append(
            [
                LINE_NAMES[race], f"{finding.expected:.2f}", f"{finding.comb.frequency:.2f}",
                f"{100.0 * finding.deviation:+.2f} %", envelope, levelled, f"{decibels(finding.comb.score):.1f}",
                *sidebands,
            ]
        )  # fmt: skip
    print_table(headers, rows)
    low, high = band
    say(f"harmonics: envelope of {low / 1e3:.3g} to {high / 1e3:.3g} kHz; levelled: whole band, tones removed")
    other, line = diagnosis.strongest_other, LINE_NAMES[diagnosis.best]
    count = f"{100.0 * diagnosis.crowded:.0f} %" if diagnosis.crowded > 0.0 else "none"
    say(
        f"strongest other periodicity: {other.frequency:.2f} Hz, {decibels(other.score):.1f} dB; "
        f"{count} of the other periodicities score as high as {line} (limit {100.0 * MAX_CROWDED:.0f} %)"
    )
    _print_remarks(diagnosis)


def _print_remarks(diagnosis: "Diagnosis") -> None:
    """Print other possible causes of the line and of the strongest other periodicity, and the defect's width."""
    from bearingsim.diagnosis import NONE
    from bearingsim.diagnosis.size import size_remark
    from bearingsim.diagnosis.thresholds import clear_score, decibels, revolutions_range

    other, line = diagnosis.strongest_other, LINE_NAMES[diagnosis.best]
    if diagnosis.verdict == NONE and diagnosis.has_other_rhythm:
        say(
            "this periodicity matches no line of this bearing at this speed: its cause is another part of the "
            "machine, or the bearing or the speed is wrong"
        )
    elif diagnosis.verdict == NONE and diagnosis.threshold < other.score < clear_score(diagnosis.threshold):
        say(
            "noise may be its cause: the strongest of many periodicities exceeds the threshold, "
            "which is for three lines"
        )
    if diagnosis.is_sideband:
        say(
            "this periodicity is a sideband of BPFI: if bearing and speed are right, the inner race may be damaged"
        )
    if diagnosis.other_race is not None:
        say(f"it is {LINE_NAMES[diagnosis.other_race]}: the {VERDICTS[diagnosis.other_race]} may be damaged, too")
    if diagnosis.shaft_may_cause:
        say(f"orders of the shaft score about as high as {line}, so a knock once per revolution may be its cause")
    if diagnosis.is_of_shaft:
        say(
            f"a knock once per revolution raises {line}, too, and may hide a defect: "
            "a longer record separates their lines if these differ"
        )
    if diagnosis.is_extrapolated:
        low, high = revolutions_range()
        say(
            f"threshold extrapolated: measured for {low:g} to {high:g} revolutions of the shaft, the record has "
            f"{diagnosis.revolutions:.4g}{_equivalent(diagnosis)}"
        )
    if diagnosis.may_be_doubled:
        half = f"{diagnosis.half_comb.frequency:.2f} Hz, {decibels(diagnosis.half_comb.score):.1f} dB"
        say(f"half of this line ({half}) is about as strong: the true speed may be half of the stated one")
    width = size_remark(diagnosis.size)
    if width is not None:
        say(width)
    if diagnosis.clearance_may_cause:
        say("clearance alone causes BPFO as well: compare with a record of the healthy bearing")


def _equivalent(diagnosis: "Diagnosis") -> str:
    """Return a remark on the equivalent number of revolutions of a bearing with many rollers; empty for others."""
    revolutions = diagnosis.equivalent_revolutions
    is_larger = revolutions > diagnosis.revolutions
    return f", equal to {revolutions:.4g} for the orders of its lines" if is_larger else ""


def power_db(height: float) -> float:
    """Convert the height of a line, the ratio of its power to the local median, to dB."""
    from math import log10

    return 10.0 * log10(max(height, 1e-3))


def _log_power_db(value: float) -> float:
    """Convert log(1 + height) to dB."""
    from math import expm1

    return power_db(expm1(value))


def as_dict(
    recording: "Recording",
    bearing: str,
    tolerance: float,
    results: "Mapping[str, tuple[Diagnosis, Kurtogram, tuple[float, float]]]",
    clearest: str,
) -> dict[str, Any]:
    """Return the values of `--json`: those of the clearest channel, and of all in `channels`."""
    channels = {name: _channel_dict(recording, name, *result) for name, result in results.items()}
    speed = recording.speed
    return {
        "file": str(recording.path),
        "bearing": bearing,
        "rate_hz": recording.rate.value,
        "rate_source": recording.rate.source,
        "speed_rpm": recording.shaft * 60.0,
        "speed_source": speed.source if speed else None,
        "tolerance": tolerance,
        "channel": clearest,
        **channels[clearest],
        "channels": channels,
    }


def _channel_dict(
    recording: "Recording", name: str, diagnosis: "Diagnosis", image: "Kurtogram", band: tuple[float, float]
) -> dict[str, Any]:
    from bearingsim.diagnosis.size import json_entries
    from bearingsim.diagnosis.thresholds import decibels

    unit, count = recording.units[name], len(recording.channels[name])
    return {
        "verdict": diagnosis.verdict,
        "unit": unit.value or None,
        "unit_source": unit.source,
        "seconds": count / recording.rate.value,
        "turns": diagnosis.revolutions,
        "band_hz": list(band),
        "kurtogram_band_hz": list(image.best),
        "threshold_db": decibels(diagnosis.threshold),
        "threshold_extrapolated": diagnosis.is_extrapolated,
        "races": {
            race: {
                "expected_hz": finding.expected,
                "found_hz": finding.comb.frequency,
                "deviation": finding.deviation,
                "score_db": decibels(finding.comb.score),
                "envelope_db": [power_db(height) for height in finding.comb.heights[0]],
                "levelled_db": [power_db(height) for height in finding.comb.heights[1]],
                "shaft_sidebands_db": [_log_power_db(value) for value in finding.shaft_sidebands],
                "cage_sidebands_db": [_log_power_db(value) for value in finding.cage_sidebands],
            }
            for race, finding in diagnosis.findings.items()
        },
        "rival": {
            "hz": diagnosis.strongest_other.frequency,
            "score_db": decibels(diagnosis.strongest_other.score),
            "crowded": diagnosis.crowded,
            "is_sideband": diagnosis.is_sideband,
            "is_of_shaft": diagnosis.is_of_shaft,
            "race": diagnosis.other_race,
        },
        **json_entries(diagnosis.size),
        "clearance_may_cause": diagnosis.clearance_may_cause,
        "shaft_may_cause": diagnosis.shaft_may_cause,
        "speed_may_be_doubled": diagnosis.may_be_doubled,
    }
