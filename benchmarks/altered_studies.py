"""Seeded changes of study files, letter by letter, line by line, value by value: most are no study any more."""

import re
from collections.abc import Iterator
from pathlib import Path
from random import Random

from benchmarks.malformed import with_

HOME = Path(__file__).resolve().parents[1]
UNITS = ["N", "kN", "mm", "um", "m", "rpm", "Hz", "kHz", "s", "ms", "us", "deg", "rad", "N/m", "kg", "%", "GPa"]
SYNTAX = (
    *(
        "[",
        "]",
        "{",
        "}",
        "&a ",
        "*a",
        "!",
        "!!int ",
        "|",
        ">",
        "'",
        '"',
        "%",
        "@",
        "`",
        ": ",
        "- ",
        "#",
        "?",
        ",",
    ),
    *("<<: ", "\t", "\n", "---\n", "...", "~", "\\", "=", "\u00b5", "\u2028", "\ufeff"),
)
NUMBER = re.compile(rb"-?\d+\.?\d*(e-?\d+)?")
VALUE = re.compile(rb"(?<=: )[^\n#,{}\[\]]+")
UNIT = re.compile(rb"(?<=\d )(N s/m|N/m|[A-Za-z%]+)")


def flip(text: bytes, random: Random) -> bytes:
    """Some bits are turned."""
    found = bytearray(text)
    for _ in range(random.choice((1, 1, 2, 8))):
        found[random.randrange(len(found))] ^= 1 << random.randrange(8)
    return bytes(found)


def cut(text: bytes, random: Random) -> bytes:
    """Some bytes are gone."""
    start = random.randrange(len(text))
    return text[:start] + text[start + random.choice((1, 1, 3, 30, len(text))) :]


def line(text: bytes, random: Random) -> bytes:
    """A line is there twice, or missing, or elsewhere."""
    lines = text.splitlines(keepends=True)
    one = random.choice(lines)
    if random.random() < 0.5:
        lines.remove(one)
    if random.random() < 0.7:
        lines.insert(random.randrange(len(lines) + 1), one)
    return b"".join(lines)


def swapped(pattern: re.Pattern[bytes], text: bytes, random: Random, other: bytes | None = None) -> bytes:
    """What a pattern finds at one place, put at another; or ``other`` put there."""
    found = list(pattern.finditer(text))
    if not found:
        return flip(text, random)
    there = random.choice(found)
    new = random.choice(found)[0] if other is None else other
    return text[: there.start()] + new + text[there.end() :]


def value(text: bytes, random: Random) -> bytes:
    """A value stands where another was."""
    return swapped(VALUE, text, random)


def unit(text: bytes, random: Random) -> bytes:
    """A value has another unit."""
    return swapped(UNIT, text, random, random.choice(UNITS).encode())


def number(text: bytes, random: Random) -> bytes:
    """A number is another, or none."""
    odd = ("0", "-1", "1e9", "1e-9", "1e300", "1e400", "nan", "inf", "9" * 300, "", "1,5", "0x1", "1e", ".", "007")
    return swapped(NUMBER, text, random, random.choice(odd).encode())


def syntax(text: bytes, random: Random) -> bytes:
    """Marks of YAML are put in."""
    for _ in range(random.choice((1, 1, 2, 5))):
        start = random.randrange(len(text))
        text = text[:start] + random.choice(SYNTAX).encode() * random.choice((1, 1, 1, 40)) + text[start:]
    return text


def twice(text: bytes, random: Random) -> bytes:
    """A part of the file is repeated."""
    start = random.randrange(len(text))
    part = text[start : start + random.randrange(1, 200)]
    return text[:start] + part * random.choice((2, 2, 20)) + text[start:]


CHANGES = (flip, cut, line, value, unit, number, syntax, twice)
KINDS = {"bearings": "bearing", "rigs": "rig"}
"""How a study names a file of `configs/`."""


def mutants(folder: Path, count: int, seed: int) -> Iterator[tuple[str, Path]]:
    """Seeded mutants of the shipped files, and what was changed; a config's is named by a study of its own."""
    random = Random(seed)
    files = sorted([*HOME.glob("studies/*.yaml"), *HOME.glob("configs/*/*.yaml")])
    for n in range(count):
        source, change = random.choice(files), CHANGES[n % len(CHANGES)]
        text = change(source.read_bytes(), random)
        path = folder / f"mutant-{n}.yaml"
        path.write_bytes(text)
        kind = source.parent.name
        if kind != "studies":
            says = with_(f"{KINDS[kind]}: {path}") if kind in KINDS else of_material(path)
            path = folder / f"names-mutant-{n}.yaml"
            path.write_text(says)
        yield f"{change.__name__} {kind} {source.stem}", path


def of_material(path: Path) -> str:
    """A study whose bearing is of another material."""
    bearing = (HOME / "configs" / "bearings" / "nf308.yaml").read_text().replace("steel", str(path))
    indented = "".join(f"  {text}\n" for text in bearing.splitlines() if not text.startswith("#"))
    return with_("bearing:") + indented
