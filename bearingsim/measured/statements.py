"""Statements of sampling rate, speed and unit in the lines above a table of numbers, and in column headers."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from bearingsim.measured.arrays import RATES, SPEEDS, STEPS, word_of
from bearingsim.measured.content import Stated, contradiction
from bearingsim.measured.si import FACTORS, HERTZ, SECONDS, TURNS

HEADER = re.compile(r"^\s*(?P<name>.*?)\s*(?:[\[(](?P<unit>[^\])]*)[\])])?\s*$")
"""Header of a column: name, and unit in brackets."""
MARKS = "#%/ \t'\""
"""Characters that begin a line of comment, and quotes."""
STATEMENT = re.compile(
    r"^(?P<name>[^:=;,\t]*?)\s*[:=;,\t]\s*[\"']?(?P<value>[+-]?\d+(?:\.\d*)?(?:[eE][+-]?\d+)?)[\"']?"
    r"(?:[\s;,]*(?P<unit>[^\s;,\"']+))?"
)
"""Name, number and unit, such as `Sampling rate: 12800 Hz`."""
UNIT = re.compile(r"^(?:y[ _]?)?units?\s*[:=;,\t]\s*(?P<units>.*)", re.IGNORECASE)
WORD = re.compile(r"(?<![^\s;,\"'])[^\s;,\"'(\[][^\s;,\"']*")
"""Word behind the name of a unit, except in brackets."""
THOUSANDS = re.compile(r"(?<![\d.])[1-9]\d{0,2}\.\d{3}(?!\d)")
"""Number whose point may separate thousands, in a table with decimal commas."""
SPEED_WORDS = (*SPEEDS, "speed", "shaftspeed", "rotationalspeed", "rotationspeed", "rotatingspeed", "drehzahl")
COMMA = re.compile(r"(?<=\d),(?=\d)")
"""Comma between two digits."""
MAX_LENGTH = 40
"""Largest number of characters of a line that is printed as a source."""


class Statements(NamedTuple):
    """Sampling rate (Hz), speed (rad/s) and unit, None each if no line states it; other_rate, other_speed: a
    second statement, which differs from the first."""

    rate: Stated[float] | None = None
    speed: Stated[float] | None = None
    unit: str | None = None
    other_rate: Stated[float] | None = None
    other_speed: Stated[float] | None = None


def statements(lines: Sequence[str], decimal: str = ".", separator: str | None = None) -> Statements:
    """Read the first statement of each value in lines of text; lines with unknown or several units are ignored.

    decimal, separator: decimal sign and separator of the table below. A number such as `12,800` is ignored unless
    its comma is one of both, because it may be 12.8 or 12800. After a colon it does not separate cells. Likewise
    `12.800` above a table with decimal commas is ignored.
    """
    rates: list[Stated[float]] = []
    speeds: list[Stated[float]] = []
    unit = None
    for line in (line.strip(MARKS) for line in lines):
        if decimal == ",":
            if THOUSANDS.search(line):
                continue
            line = COMMA.sub(".", line)
        unit_match = UNIT.match(line)
        words = set(WORD.findall(unit_match["units"])) if unit_match else set()
        if unit is None and len(words) == 1 and any(words <= units.keys() for units in FACTORS.values()):
            (unit,) = words
        match = STATEMENT.match(line)
        header = HEADER.match(match["name"]) if match else None
        if match is None or header is None or _is_ambiguous(match, separator):
            continue
        word, value = word_of(header["name"]), float(match["value"])
        own_unit, source = (header["unit"] or match["unit"] or "").lower(), f"the line `{line[:MAX_LENGTH]}`"
        if word in RATES and own_unit in HERTZ:
            rates.append(Stated(HERTZ[own_unit] * value, source))
        elif word in STEPS and own_unit in SECONDS and value > 0.0:
            rates.append(Stated(1.0 / (SECONDS[own_unit] * value), source))
        elif is_speed(word, own_unit):
            speeds.append(Stated(speed_factor(word, own_unit) * value, source))
    rate, speed = (stated[0] if stated else None for stated in (rates, speeds))
    return Statements(rate, speed, unit, contradiction(rates), contradiction(speeds))


def _is_ambiguous(match: re.Match[str], separator: str | None) -> bool:
    """Check if a comma splits the digits of a number and does not separate two cells, as before the number."""
    begin, end = match.span("value")
    between = match.string[match.end("name") : begin]
    is_cell = separator == "," and "," in between and not set(between) & set("\"'")
    return bool(COMMA.match(match.string, end)) and not is_cell


def is_speed(word: str, unit: str) -> bool:
    """Check if a word names a speed of the shaft, with a known unit in lower case, or contains `rpm` and has no
    unit."""
    return word in SPEED_WORDS and (unit in TURNS or (not unit and "rpm" in word))


def speed_factor(word: str, unit: str) -> float:
    """Return the factor to rad/s of a speed."""
    return TURNS[unit or "rpm"]
