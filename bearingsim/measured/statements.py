"""Statements of sampling rate, speed and unit in the lines above a table of numbers, and in column headers."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from bearingsim.measured.arrays import RATE_NAMES, RPM_NAMES, STEP_NAMES, normalize
from bearingsim.measured.content import Stated, find_contradiction
from bearingsim.measured.si import FACTORS, FREQUENCY_FACTORS, SPEED_FACTORS, TIME_FACTORS

HEADER = re.compile(r"^\s*(?P<name>.*?)\s*(?:[\[(](?P<unit>[^\])]*)[\])])?\s*$")
"""Header of a column: name, and unit in brackets."""
COMMENT_MARKS = "#%/ \t'\""
"""Characters that are removed from both ends of a line: comment marks, blanks and quotes."""
STATEMENT = re.compile(
    r"^(?P<name>[^:=;,\t]*?)\s*[:=;,\t]\s*[\"']?(?P<value>[+-]?\d+(?:\.\d*)?(?:[eE][+-]?\d+)?)[\"']?"
    r"(?:[\s;,]*(?P<unit>[^\s;,\"']+))?"
)
"""Name, number and unit, such as `Sampling rate: 12800 Hz`; text behind the unit is ignored."""
REPETITION = re.compile(r"(?P<first>[^\t]+\t(?P<value>[^\t]+))(?:\t(?P=value))+")
"""Line of a name and equal values, one for each column, such as those of the header of LabVIEW."""
UNIT = re.compile(r"^(?:y[ _]?)?units?\s*[:=;,\t]\s*(?P<units>.*)", re.IGNORECASE)
"""Line that states units, such as `Unit: g`."""
WORD = re.compile(r"(?<![^\s;,\"'])[^\s;,\"'(\[][^\s;,\"']*")
"""Word of a list of units; words in brackets are remarks."""
THOUSANDS = re.compile(r"(?<![\d.])[1-9]\d{0,2}\.\d{3}(?!\d)")
"""Number whose point may separate thousands, in a table with decimal commas."""
SPEED_NAMES = (*RPM_NAMES, "speed", "shaftspeed", "rotationalspeed", "rotationspeed", "rotatingspeed", "drehzahl")
"""Names of the speed of the shaft as ``normalize`` returns them."""
INNER_COMMA = re.compile(r"(?<=\d),(?=\d)")
"""Comma between two digits."""
MAX_SOURCE_LENGTH = 40
"""Largest number of characters of a line quoted as the source of a value."""


class Statements(NamedTuple):
    """Values stated by lines of text, None each if no line states it.

    rate: sampling rate (Hz); speed (rad/s); unit: of all channels; other_rate, other_speed: further statements,
    which contradict the former.
    """

    rate: Stated[float] | None = None
    speed: Stated[float] | None = None
    unit: str | None = None
    other_rate: Stated[float] | None = None
    other_speed: Stated[float] | None = None


def parse_statements(lines: Sequence[str], decimal: str = ".", separator: str | None = None) -> Statements:
    """Parse the first statement of each value in lines of text; lines with unknown or several units are ignored.

    decimal, separator: decimal sign and separator of the table below the lines. Ambiguous numbers are ignored:
    `12,800`, unless the comma is the decimal sign or separates cells, and `12.800` if the decimal sign is a comma.
    """
    rates: list[Stated[float]] = []
    speeds: list[Stated[float]] = []
    unit = None
    for line in (line.strip(COMMENT_MARKS) for line in lines):
        if decimal == ",":
            if THOUSANDS.search(line):
                continue
            line = INNER_COMMA.sub(".", line)
        repetition = REPETITION.fullmatch(line)
        line = repetition["first"] if repetition else line
        unit_match = UNIT.match(line)
        words = set(WORD.findall(unit_match["units"])) if unit_match else set()
        if unit is None and len(words) == 1 and any(words <= units.keys() for units in FACTORS.values()):
            (unit,) = words
        match = STATEMENT.match(line)
        header = HEADER.match(match["name"]) if match else None
        if match is None or header is None or _is_ambiguous(match, separator):
            continue
        name, value = normalize(header["name"]), float(match["value"])
        own_unit, source = (
            (header["unit"] or match["unit"] or "").lower(),
            f"the line `{line[:MAX_SOURCE_LENGTH]}`",
        )
        if name in RATE_NAMES and own_unit in FREQUENCY_FACTORS:
            rates.append(Stated(FREQUENCY_FACTORS[own_unit] * value, source))
        elif name in STEP_NAMES and own_unit in TIME_FACTORS and value > 0.0:
            rates.append(Stated(1.0 / (TIME_FACTORS[own_unit] * value), source))
        elif is_speed(name, own_unit):
            speeds.append(Stated(speed_factor(own_unit) * value, source))
    rate, speed = (stated[0] if stated else None for stated in (rates, speeds))
    return Statements(rate, speed, unit, find_contradiction(rates), find_contradiction(speeds))


def _is_ambiguous(match: re.Match[str], separator: str | None) -> bool:
    """Check if the comma between a number and a digit may be a decimal sign or separate thousands.

    It separates cells if the separator is a comma and another comma, without quotes, precedes the number.
    """
    begin, end = match.span("value")
    between = match.string[match.end("name") : begin]
    is_cell = separator == "," and "," in between and not set(between) & set("\"'")
    return bool(INNER_COMMA.match(match.string, end)) and not is_cell


def is_speed(name: str, unit: str) -> bool:
    """Check if a normalized name and a unit in lower case are those of a speed of the shaft.

    The unit may be missing ("") if the name contains `rpm`.
    """
    return name in SPEED_NAMES and (unit in SPEED_FACTORS or (not unit and "rpm" in name))


def speed_factor(unit: str) -> float:
    """Return the factor to rad/s of a speed; its unit is rpm if it is missing ("")."""
    return SPEED_FACTORS[unit or "rpm"]
