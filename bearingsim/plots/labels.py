"""Texts of figures and tables: names of paths and features, values with readable units."""

from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING

from bearingsim.errors import UserError
from bearingsim.text.units import DISPLAY, UNITS, Dimension, display

if TYPE_CHECKING:
    from bearingsim.text.yamlfile import Node

PRINTED_UNITS = {
    "um": "µm",
    "nm": "nm",
    "deg": "°",
    "um/s": "µm/s",
    "us": "µs",
    "m/s^2": "m/s²",
    "mm/s^2": "mm/s²",
    "N/m/m": "N/m²",
    "N/m^2": "N/m²",
    "N/mm/mm": "N/mm²",
    "N/mm^2": "N/mm²",
    "C": "°C",
    "degC": "°C",
}
NAMES = {  # paths that do not name their quantity
    "bearing.roller_profile": "roller profile",
    "contact.damping.beta": "damping time c/k",
    "misalignment.inner": "inner ring misalignment",
    "misalignment.outer": "outer ring misalignment",
    "rig.load": "load path",
    "rig.ring.bends": "ring bending",
}
KINDS = ("law", "by", "shape", "on")  # keys of a mapping whose value is the type of the object
SWITCHES = {"true": "on", "false": "off"}
NONE = "none"
"""Value of a key that is omitted."""
SCALES: dict[str, tuple[tuple[str, float], ...]] = {  # readable units of a feature's SI unit, largest first
    "m": (("mm", 1e3), ("µm", 1e6), ("nm", 1e9)),
    "m/s": (("m/s", 1.0), ("mm/s", 1e3), ("µm/s", 1e6)),
    "m/s^2": (("m/s²", 1.0), ("mm/s²", 1e3)),
    "m^2/s^4": (("m²/s⁴", 1.0),),
    "N": (("N", 1.0),),
    "N/m": (("N/mm", 1e-3), ("N/m", 1.0)),
    "s": (("s", 1.0), ("ms", 1e3)),
    "rad": (("°", 57.29577951308232),),
    "%": (("%", 1e2),),
}
SMALL_ANGLE_WORDS = ("tilt", "skew", "lean", "rotation")  # quantities in mrad instead of degrees
SMALL_ANGLES = (("mrad", 1e3), ("µrad", 1e6), ("nrad", 1e9))
SHARES = ("cage.slip",)  # dimensionless quantities shown in per cent, as are their statistics
DIGITS = 5  # significant digits of a number in a text
NO_BREAK = "\u00a0"  # space at which no line is broken
COST, COST_UNIT, COST_TEXT = "seconds", "s", "CPU time of a job"
"""Column of the table that is drawn like a feature: name, unit, text."""


class PlotError(UserError):
    """Error for a figure that cannot be drawn from the results."""


class PlotWarning(UserWarning):
    """Warning of a figure that is skipped."""


def format_unit(unit: str) -> str:
    """Format a unit as printed: µ for u, the degree sign, superscripts."""
    return PRINTED_UNITS.get(unit, unit)


def format_quantity(quantity: str) -> str:
    """Format a quantity with its unit as printed: `0.35 µm (3 samples)` for `0.35 um (3 samples)`."""
    value, bracket, remark = quantity.partition(" (")
    number, space, unit = value.rpartition(" ")
    return f"{number}{space}{format_unit(unit)}{bracket}{remark}"


def name_text(path: str) -> str:
    """Return a path in words: `defect length` for ``defect.length``, `defect 2 width` for ``defects.2.width``."""
    if path in NAMES:
        return NAMES[path]
    words = path.removeprefix("contact.damping.").removeprefix("contact.").replace("defects.", "defect ")
    return words.replace(".", " ").replace("_", " ")


@cache
def _dimension(path: str) -> Dimension | None:
    from bearingsim.study import dimension

    try:
        return dimension(path)
    except KeyError:
        return None


def unit_of(path: str, units: Mapping[str, str]) -> str:
    """Return the display unit of a path: the unit used in the study, else the default of the field."""
    dimension = _dimension(path)
    written = units.get(path, "")
    if dimension is None or written in UNITS[dimension]:
        return written
    return DISPLAY[dimension]


def table_unit(name: str, units: Mapping[str, str]) -> str:
    """Return the unit of a column of an exported table: SI; for a swept speed, the unit of the study."""
    if name not in units:
        return _feature_unit(name)
    dimension = _dimension(name)
    if dimension == "rotation":
        return unit_of(name, units)
    si = (unit for unit, factor in UNITS[dimension].items() if factor == (1, False, 0)) if dimension else ()
    return next(iter(si), "")


def to_unit(path: str, value: float, unit: str) -> float:
    """Convert an SI value of a path to ``unit``."""
    return display(value, unit, _dimension(path)) if unit else value


def number_text(value: float, digits: int = DIGITS) -> str:
    """Format a number with a few significant digits, without exponent below a million: `2e6`, `1e-5`."""
    rounded = float(f"{value:.{digits}g}")
    text = f"{rounded:.0f}" if 10**digits <= abs(rounded) < 1e6 else f"{rounded:.{digits}g}"
    mantissa, exponential, exponent = text.partition("e")
    return f"{mantissa}e{int(exponent)}" if exponential else text


def value_text(path: str, value: object, units: Mapping[str, str]) -> str:
    """Format a value of a path with its unit: `0.8 mm`, `rollers`, `housing (stiffness 1e10 N/m²)`."""
    if not isinstance(value, int | float):
        return phrase(str(value))
    unit = unit_of(path, units)
    if _dimension(path) is None and float(value).is_integer():  # a seed or a count, which is not rounded
        return f"{value:.0f}"
    return with_unit(number_text(to_unit(path, float(value), unit)), unit)


def with_unit(number: str, unit: str) -> str:
    """Join a number and its printed unit: `0.8 mm`, `30°`."""
    return f"{number}{'' if unit in ('deg', '') else ' '}{format_unit(unit)}"


def phrase(text: str) -> str:
    """Write a value of a study file in words; a mapping as its kind, then its other keys in brackets.

    Examples: `housing (stiffness 1e10 N/m²)` for ``{by: housing, stiffness: 1e10 N/m/m}``, `on` for ``true``.
    """
    from bearingsim.text.yamlfile import StudyError, parse

    if not text.startswith(("{", "[")):
        return _word(text)
    try:
        return _words(parse(text, "").root)
    except StudyError:  # text with a colon or bracket, which the study file has in quotation marks
        return text.strip("{}")


def _words(node: "Node") -> str:
    if isinstance(node.value, tuple):
        texts = [_words(item) for item in node.value]
        return " and ".join(filter(None, [", ".join(texts[:-1]), *texts[-1:]]))
    if not isinstance(node.value, dict):
        return _word(node.text)
    kinds = [_words(item) for key, item in node.value.items() if key in KINDS]
    rest = ", ".join(
        f"{key.replace('_', ' ')} {_words(item)}" for key, item in node.value.items() if key not in KINDS
    )
    return f"{' '.join(kinds)} ({rest})" if kinds and rest else " ".join(kinds) or rest


def _word(text: str) -> str:
    """Format a scalar of a study file: its unit as in a figure, `true` and `false` as `on` and `off`."""
    number, _, unit = text.partition(" ")
    is_quantity = number[-1:].isdigit() and any(unit in units for units in UNITS.values())
    return with_unit(number, unit) if is_quantity else SWITCHES.get(text, text)


def swept_text(swept: Mapping[str, object], units: Mapping[str, str]) -> str:
    """Join swept values in one line: `circular, length 3 mm, load 150 N, model rollers`.

    Keys that a defect does not have are omitted.
    """
    paths = [path for path in swept if not (swept[path] == NONE and path.startswith("defect"))]
    return ", ".join(f"{_short(path)} {value_text(path, swept[path], units)}".strip() for path in paths)


def _short(path: str) -> str:
    """Shorten the name of a path in front of its value, without `defect` for a single defect."""
    return "" if path == "defect.shape" else name_text(path.removeprefix("defect."))


def square_unit(unit: str) -> str:
    """Return the square of a printed unit: `µm²/s²`."""
    above, _, below = unit.partition("/")
    return "/".join(
        f"{part.removesuffix('²')}{'⁴' if part.endswith('²') else '²'}" for part in (above, below) if part
    )


def feature_text(name: str) -> str:
    """Return the long name of a feature, capitalised for an axis label: `Velocity amplitude at BPFO`."""
    from bearingsim.config import FEATURES

    line = name.removesuffix("-healthy.phase")
    if line != name:
        text = f"phase of {line.replace('@', ' at ')}, change from healthy"
    elif name == COST:
        text = COST_TEXT
    else:
        text = FEATURES[name].long_name if name in FEATURES else name
    return text[:1].upper() + text[1:]


def in_sentence(text: str) -> str:
    """Return the long name of a feature without its capital letter, except that of an abbreviation."""
    return text if text[1:2].isupper() else text[:1].lower() + text[1:]


def feature_axis(name: str, largest: float) -> tuple[str, float]:
    """Choose unit and factor from SI for a feature by its largest value; ``("", 1.0)`` without a unit."""
    return choose_unit(COST_UNIT if name == COST else _feature_unit(name), name, largest)


def _feature_unit(name: str) -> str:
    from bearingsim.config import FEATURES

    return "rad" if name.endswith(".phase") else FEATURES[name].unit if name in FEATURES else ""


def choose_unit(unit: str, name: str, largest: float) -> tuple[str, float]:
    """Choose unit and factor from SI for a quantity by its name and largest value."""
    if any(name == share or name.startswith(f"{share}.") for share in SHARES):
        unit = "%"
    if unit not in SCALES:
        return unit, 1.0
    scales = SMALL_ANGLES if set(SMALL_ANGLE_WORDS) & set(name.split(".")) else SCALES[unit]
    return next(((unit, factor) for unit, factor in scales if largest * factor >= 1.0), scales[-1])
