"""Seeded mutations of study files (bits, lines, values, units, syntax), which mostly make them invalid."""

import re
from collections.abc import Iterator
from pathlib import Path
from random import Random

from benchmarks.malformed import study_with

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
    """Flip some bits."""
    content = bytearray(text)
    for _ in range(random.choice((1, 1, 2, 8))):
        content[random.randrange(len(content))] ^= 1 << random.randrange(8)
    return bytes(content)


def cut(text: bytes, random: Random) -> bytes:
    """Delete some bytes."""
    start = random.randrange(len(text))
    return text[:start] + text[start + random.choice((1, 1, 3, 30, len(text))) :]


def line(text: bytes, random: Random) -> bytes:
    """Duplicate, delete or move a line."""
    lines = text.splitlines(keepends=True)
    chosen = random.choice(lines)
    if random.random() < 0.5:
        lines.remove(chosen)
    if random.random() < 0.7:
        lines.insert(random.randrange(len(lines) + 1), chosen)
    return b"".join(lines)


def replace_match(pattern: re.Pattern[bytes], text: bytes, random: Random, other: bytes | None = None) -> bytes:
    """Replace one match of a pattern by another match, or by ``other``; flip bits if there is no match."""
    matches = list(pattern.finditer(text))
    if not matches:
        return flip(text, random)
    match = random.choice(matches)
    replacement = random.choice(matches)[0] if other is None else other
    return text[: match.start()] + replacement + text[match.end() :]


def value(text: bytes, random: Random) -> bytes:
    """Replace a value by another of the file."""
    return replace_match(VALUE, text, random)


def unit(text: bytes, random: Random) -> bytes:
    """Replace the unit of a value."""
    return replace_match(UNIT, text, random, random.choice(UNITS).encode())


def number(text: bytes, random: Random) -> bytes:
    """Replace a number by an extreme or malformed one."""
    texts = (
        "0",
        "-1",
        "1e9",
        "1e-9",
        "1e300",
        "1e400",
        "nan",
        "inf",
        "9" * 300,
        "",
        "1,5",
        "0x1",
        "1e",
        ".",
        "007",
    )
    return replace_match(NUMBER, text, random, random.choice(texts).encode())


def syntax(text: bytes, random: Random) -> bytes:
    """Insert YAML syntax characters."""
    for _ in range(random.choice((1, 1, 2, 5))):
        start = random.randrange(len(text))
        text = text[:start] + random.choice(SYNTAX).encode() * random.choice((1, 1, 1, 40)) + text[start:]
    return text


def twice(text: bytes, random: Random) -> bytes:
    """Repeat a part of the file."""
    start = random.randrange(len(text))
    part = text[start : start + random.randrange(1, 200)]
    return text[:start] + part * random.choice((2, 2, 20)) + text[start:]


CHANGES = (flip, cut, line, value, unit, number, syntax, twice)
KINDS = {"bearings": "bearing", "rigs": "rig"}
"""Keys by which a study refers to the files of `configs/`, by folder."""


def mutants(folder: Path, count: int, seed: int) -> Iterator[tuple[str, Path]]:
    """Write seeded mutants of the shipped files; yield the change and the study (or a study of the config)."""
    random = Random(seed)
    files = sorted([*HOME.glob("studies/*.yaml"), *HOME.glob("configs/*/*.yaml")])
    for number in range(count):
        source, change = random.choice(files), CHANGES[number % len(CHANGES)]
        text = change(source.read_bytes(), random)
        path = folder / f"mutant-{number}.yaml"
        path.write_bytes(text)
        kind = source.parent.name
        if kind != "studies":
            content = study_with(f"{KINDS[kind]}: {path}") if kind in KINDS else study_of_material(path)
            path = folder / f"names-mutant-{number}.yaml"
            path.write_text(content)
        yield f"{change.__name__} {kind} {source.stem}", path


def study_of_material(path: Path) -> str:
    """Return a study whose bearing has the material of a file."""
    bearing = (HOME / "configs" / "bearings" / "nf308.yaml").read_text().replace("steel", str(path))
    indented = "".join(f"  {text}\n" for text in bearing.splitlines() if not text.startswith("#"))
    return study_with("bearing:") + indented
