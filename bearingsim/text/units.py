"""Conversion of quantities: text with a unit to floats in SI, and back.

The table contains only the units of this field. Ambiguous or invalid text is rejected: a decimal comma, a missing
unit, a unit of another dimension, NaN and infinity. Conversion uses exact fractions and rounds once (twice for
units with pi), so `0.8 mm` and `800 um` give the same float.

The program uses rad for angles, rad/s for rotation speeds and Hz for frequencies.
"""

import math
import re
from collections.abc import Collection
from fractions import Fraction
from functools import lru_cache
from typing import Literal, NamedTuple

from bearingsim.errors import UserError

Dimension = Literal[
    "length",
    "angle",
    "rotation",
    "force",
    "time",
    "frequency",
    "stiffness",
    "stiffness per length",
    "damping",
    "velocity",
    "inverse velocity",
    "mass",
    "density",
    "pressure",
    "viscosity",
    "pressure coefficient",
    "temperature",
    "unbalance",
    "torsional stiffness",
    "torsional damping",
    "number",
    "coefficient in N, mm and s",
    "share",
    "tolerance",
]


class Factor(NamedTuple):
    """SI value of a unit: an exact fraction, times pi if `pi` is set; zero: SI value of zero, such as 0 C."""

    exact: Fraction
    pi: bool = False
    zero: Fraction = Fraction(0)


def _decimal(**powers: int) -> dict[str, Factor]:
    return {unit: Factor(Fraction(10) ** power) for unit, power in powers.items()}


def _per(
    numerators: dict[str, Factor], denominators: dict[str, Factor], separator: str = "/"
) -> dict[str, Factor]:
    return {
        f"{a}{separator}{b}": Factor(fa.exact / fb.exact)
        for a, fa in numerators.items()
        for b, fb in denominators.items()
    }


_METRES = _decimal(m=0, mm=-3, um=-6)
_NEWTONS = _decimal(N=0, kN=3)

UNITS: dict[Dimension, dict[str, Factor]] = {
    "length": _METRES | _decimal(nm=-9),
    "angle": {"deg": Factor(Fraction(1, 180), pi=True)} | _decimal(rad=0, mrad=-3, urad=-6),
    "rotation": {
        "rpm": Factor(Fraction(1, 30), pi=True),
        "r/min": Factor(Fraction(1, 30), pi=True),
        "Hz": Factor(Fraction(2), pi=True),
        "deg/s": Factor(Fraction(1, 180), pi=True),
        "rad/s": Factor(Fraction(1)),
    },
    "force": _NEWTONS,
    "time": _decimal(s=0, ms=-3, us=-6, ns=-9) | {"min": Factor(Fraction(60))},
    "frequency": _decimal(Hz=0, kHz=3),
    "stiffness": _per(_NEWTONS | _decimal(MN=6), _METRES),
    "stiffness per length": _decimal(**{"N/m/m": 0, "N/m^2": 0, "N/mm/mm": 6, "N/mm^2": 6}),
    "damping": _per(_NEWTONS, _METRES, separator=" s/"),
    "inverse velocity": _per(_decimal(s=0), _decimal(m=0, mm=-3)),
    "velocity": _per(_METRES, _decimal(s=0)),
    "mass": _decimal(kg=0, g=-3),
    "density": _decimal(**{"kg/m^3": 0, "g/cm^3": 3}),
    "pressure": _decimal(Pa=0, MPa=6, GPa=9) | {"N/mm^2": Factor(Fraction(10) ** 6)},
    "viscosity": _decimal(**{"Pa s": 0, "mPa s": -3}),
    "pressure coefficient": _decimal(**{"1/Pa": 0, "1/MPa": -6, "1/GPa": -9}),
    "temperature": {
        "K": Factor(Fraction(1)),
        "C": Factor(Fraction(1), zero=Fraction(27315, 100)),
        "degC": Factor(Fraction(1), zero=Fraction(27315, 100)),
    },
    "unbalance": _decimal(**{"kg m": 0, "kg mm": -3, "g m": -3, "g mm": -6}),
    "torsional stiffness": _decimal(**{"N m/rad": 0, "N mm/rad": -3}),
    "torsional damping": _decimal(**{"N m s/rad": 0, "N mm s/rad": -3}),
    "number": {"": Factor(Fraction(1))},
    "coefficient in N, mm and s": {"": Factor(Fraction(1))},
    "share": {"%": Factor(Fraction(1, 100))},
    "tolerance": {"": Factor(Fraction(1)), "%": Factor(Fraction(1, 100))},
}

EXPECTED: dict[Dimension, str] = {
    "length": "a length such as `0.8 mm`",
    "angle": "an angle such as `5 deg`",
    "rotation": "a rotation speed such as `1800 rpm`",
    "force": "a force such as `150 N`",
    "time": "a time such as `50 ms`",
    "frequency": "a frequency such as `10240 Hz`",
    "stiffness": "a stiffness such as `1e7 N/m`",
    "stiffness per length": "a stiffness per metre of circumference such as `1e10 N/m/m`",
    "damping": "a damping coefficient such as `200 N s/m`",
    "velocity": "a velocity such as `0.1 m/s`",
    "inverse velocity": "an inverse velocity such as `50 s/m`",
    "mass": "a mass such as `0.6 kg`",
    "density": "a density such as `7850 kg/m^3`",
    "pressure": "a pressure such as `207 GPa`",
    "viscosity": "a dynamic viscosity such as `0.05 Pa s`",
    "pressure coefficient": "a pressure coefficient of viscosity such as `20 1/GPa`",
    "temperature": "a temperature such as `55 C`",
    "unbalance": "an unbalance such as `100 g mm`",
    "torsional stiffness": "a torsional stiffness such as `1e4 N m/rad`",
    "torsional damping": "a torsional damping such as `0.1 N m s/rad`",
    "number": "a plain number such as `1.5`",
    "coefficient in N, mm and s": "a plain number, in N, mm and s, such as `1e4`",
    "share": "a percentage such as `1 %`",
    "tolerance": "a tolerance such as `0.01 %`",
}

DISPLAY: dict[Dimension, str] = {
    "length": "mm",
    "angle": "deg",
    "rotation": "rpm",
    "force": "N",
    "time": "s",
    "frequency": "Hz",
    "stiffness": "N/m",
    "stiffness per length": "N/m/m",
    "damping": "N s/m",
    "velocity": "m/s",
    "inverse velocity": "s/m",
    "mass": "kg",
    "density": "kg/m^3",
    "pressure": "GPa",
    "viscosity": "Pa s",
    "pressure coefficient": "1/GPa",
    "temperature": "C",
    "unbalance": "g mm",
    "torsional stiffness": "N m/rad",
    "torsional damping": "N m s/rad",
    "number": "",
    "coefficient in N, mm and s": "",
    "share": "%",
    "tolerance": "",
}
"""Default unit of display of each dimension."""

MAX_DIGITS = 100
"""Limit of the characters of a number. Floats have 17 digits; Python rejects integers of more than 4300."""
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+", re.ASCII)
SPELLING = str.maketrans({"µ": "u", "μ": "u", "°": "deg", "·": " ", "*": " ", "²": "^2", "³": "^3"})
"""ASCII spelling of characters in units, as in ``UNITS``."""


class UnitError(UserError, ValueError):
    """Error for text that is not a quantity of the required dimension.

    expected: description of a valid quantity, with an example; hint: the mistake, or None; nearest: the most
    similar valid unit, or None.
    """

    def __init__(self, text: str, expected: str, hint: str | None = None, nearest: str | None = None) -> None:
        self.text, self.expected, self.hint, self.nearest = text, expected, hint, nearest
        super().__init__(f"expected {expected}, got `{text}`" + (f" ({hint})" if hint else ""))


def split(text: str) -> tuple[str, str]:
    """Split a quantity into number and unit, as in `("0.8", "mm")`; the unit is spelt as in ``UNITS``.

    Raises UnitError if the text does not begin with a number.
    """
    number = _NUMBER.match(text.strip())
    if number is None or _DECIMAL_COMMA.match(text.strip()):
        raise UnitError(text, "a number with its unit", _number_hint(text))
    if number.end() > MAX_DIGITS:
        raise UnitError(text, "a number with its unit", f"more than {MAX_DIGITS} digits")
    return number.group(), _spelling(text.strip()[number.end() :])


@lru_cache(maxsize=8192)
def parse(text: str, dimension: Dimension) -> float:
    """Convert a quantity from text to SI.

    Raises UnitError for a decimal comma, NaN, infinity, and a missing, unknown or incompatible unit.
    """
    try:
        number, unit = split(text)
    except UnitError as error:
        raise UnitError(text, EXPECTED[dimension], error.hint) from None
    factor = UNITS[dimension].get(unit)
    if factor is None:
        raise UnitError(text, EXPECTED[dimension], *_unit_hint(unit, dimension))
    return _convert(text, number, factor, dimension)


def pattern(dimension: Dimension) -> str:
    """Return the regular expression (ECMA 262) of quantities that ``parse`` accepts for a dimension."""
    units = "|".join(map(_spellings, UNITS[dimension]))
    return rf"{_NUMBER.pattern}[\s·*]*({units})\s*"


def _spellings(unit: str) -> str:
    """Return the pattern of all spellings of a unit; `N s/m` may be written `N·s / m`."""
    patterns = {
        " ": r"[\s.·*]*",
        "/": r"\s*/\s*",
        "u": "[uµμ]",
        "^2": "(\\^?2|²)",
        "^3": "(\\^?3|³)",
        "deg": "(deg|°)",
    }
    return re.sub(r"deg|\^[23]|.", lambda match: patterns.get(match[0], match[0]), unit)


def display(value: float, unit: str, dimension: Dimension | None = None) -> float:
    """Convert an SI value to `unit`.

    `dimension` is needed only for an ambiguous unit: Hz is a frequency or a rotation speed. Raises UnitError for
    an unknown or ambiguous unit.
    """
    name = _spelling(unit)
    factors = {d: f[name] for d, f in UNITS.items() if name in f}
    if dimension is not None and dimension not in factors:
        raise UnitError(unit, f"a unit of {dimension}", *_unit_hint(name, dimension))
    candidates = {factors[dimension]} if dimension else set(factors.values())
    if len(candidates) != 1:
        raise UnitError(unit, "a unit with one meaning", "state the dimension")
    return _in_unit(value, candidates.pop())


def show(value: float, unit: str, dimension: Dimension | None = None) -> str:
    """Format an SI value in `unit` with six digits: `show(0.0008, "mm")` is `0.8 mm`."""
    return f"{display(value, unit, dimension):.6g} {unit}".strip()


def common_dimension(unit: str, other: str) -> Dimension | None:
    """Return a dimension with both unit words, or None."""
    return next((d for d, words in UNITS.items() if unit in words and other in words), None)


def nearest_word(word: str, words: Collection[str]) -> str | None:
    """Return the element of `words` most similar to a misspelt `word`, ignoring case; None if none is similar."""
    return next(iter(nearest_words(word, words)), None)


def suggestion(word: str, words: Collection[str]) -> str:
    """Suggest the elements of `words` most similar to a misspelt `word`; empty if none is similar."""
    quoted = [f"`{similar}`" for similar in nearest_words(word, words)[:MAX_SUGGESTIONS]]
    return f"did you mean {' or '.join(quoted)}?" if quoted else ""


MAX_SUGGESTIONS = 3
ERROR_LENGTHS = (3, 9, 14)
"""Minimum lengths of words that may contain one, two and three typing errors."""
_SIMILAR_CHARACTERS = str.maketrans("01", "ol")


def nearest_words(typed: str, words: Collection[str]) -> list[str]:
    """List the words with the fewest typing errors, or else the only word with this prefix."""
    folded = typed.lower()
    distances = {
        word: _edit_distance(folded, word.lower())
        for word in sorted(words)
        if _may_be_misspelt(folded, word.lower())
    }
    close = {word: distance for word, distance in distances.items() if distance <= _max_distance(folded, word)}
    if close:
        return [word for word, distance in close.items() if distance == min(close.values())]
    completions = [word for word in words if len(typed) > 1 and word.lower().startswith(folded)]
    # `N m/rad` completes `N m`; `N mm/rad` does not
    whole_words = [word for word in completions if not word[len(typed)].isalnum()]
    candidates = whole_words or completions
    return candidates if len(candidates) == 1 and candidates[0][len(typed)] not in "_-" else []


def _may_be_misspelt(typed: str, word: str) -> bool:
    """Check if lengths are similar and numbers equal, because `6204` is not a misspelt `6205`."""
    numbers = {"".join(filter(str.isdecimal, text)) for text in (typed, word)} - {""}
    return abs(len(typed) - len(word)) <= _max_distance(typed, word) and len(numbers) < 2


def _max_distance(typed: str, word: str) -> int:
    return sum(max(len(typed), len(word)) >= length for length in ERROR_LENGTHS)


def _edit_distance(typed: str, word: str) -> int:
    """Count wrong, missing, extra and transposed letters (optimal string alignment distance)."""
    typed, word = typed.translate(_SIMILAR_CHARACTERS), word.translate(_SIMILAR_CHARACTERS)
    previous, row = [0] * (len(word) + 1), list(range(len(word) + 1))
    for i, a in enumerate(typed, 1):
        before_previous, previous, row = previous, row, [i]
        for j, b in enumerate(word, 1):
            distance = min(previous[j] + 1, row[j - 1] + 1, previous[j - 1] + (a != b))
            if i > 1 and j > 1 and a == word[j - 2] and typed[i - 2] == b:
                distance = min(distance, before_previous[j - 2] + 1)
            row.append(distance)
    return row[-1]


@lru_cache(maxsize=256)
def _spelling(unit: str) -> str:
    """Return a unit as in ``UNITS``; others in ASCII, with one blank between factors and none at a slash."""
    text = re.sub(r"^[\s·*]+|\s+$", "", unit)
    words = (word for units in UNITS.values() for word in units)
    name = next((word for word in words if re.fullmatch(_spellings(word), text)), None)
    return re.sub(r" ?/ ?", "/", " ".join(text.translate(SPELLING).split())) if name is None else name


def _convert(text: str, number: str, factor: Factor, dimension: Dimension) -> float:
    approximate = float(number)
    if approximate == 0.0 or math.isinf(approximate):  # 1e999999999 would be slow in exact arithmetic
        value = abs(approximate) + float(factor.zero)
    else:
        try:
            value = float(Fraction(number) * factor.exact + factor.zero) * (math.pi if factor.pi else 1.0)
        except OverflowError:
            value = math.inf
    if math.isinf(value):
        raise UnitError(text, EXPECTED[dimension], "the number is too large")
    return value


def _in_unit(value: float, factor: Factor) -> float:
    scaled = value / math.pi if factor.pi else value - float(factor.zero)
    return scaled * factor.exact.denominator / factor.exact.numerator


def _number_hint(text: str) -> str | None:
    if not text.strip():
        return "nothing is written"
    if _DECIMAL_COMMA.match(text.strip()):
        return "write a decimal point"
    if re.match(r"[+-]?\.?(nan|inf)", text.strip(), re.IGNORECASE):
        return "the number must be finite"
    return None


REVOLUTIONS_PER_SECOND = ("rps", "r/s", "rev/s", "1/s")
"""Other names of Hz for a rotation speed, which resemble `rpm`, `r/min` or `rad/s`."""


def _unit_hint(unit: str, dimension: Dimension) -> tuple[str | None, str | None]:
    """Describe the mistake in a unit; return the description and the most similar valid unit."""
    units = [name for name in UNITS[dimension] if name]
    if not unit:
        return "the unit is missing", None
    if not units:
        return "no unit here", None
    other = next((d for d in UNITS if unit in UNITS[d]), None)
    if other is not None:
        return f"`{unit}` is a unit of {other}", None
    nearest = "Hz" if dimension == "rotation" and unit in REVOLUTIONS_PER_SECOND else nearest_word(unit, units)
    if nearest and unit.endswith(nearest) and unit.removesuffix(nearest).isalpha():
        nearest = None  # the unit has an unknown prefix, without which the value would differ
    return f"did you mean `{nearest}`?" if nearest else f"units: {', '.join(units)}", nearest
