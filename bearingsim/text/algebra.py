"""Algebra of formulas: dimensions as exponents of m, kg, s, K and rad, operators and functions."""

import ast
import math
import operator
from collections.abc import Callable
from fractions import Fraction
from typing import NamedTuple

from bearingsim.text.units import EXPECTED, UNITS, Dimension, split

MAX_CHARACTERS, MAX_DEPTH = 400, 100
"""Limits of the characters and the nesting of a formula, for Python's parser and for recursion."""
EQUALITY_TOLERANCE = 1e-11
"""Relative tolerance of equality, because 3 * 10 um differs from 30 um by rounding."""

Kind = tuple[Fraction, ...]
"""Dimension of a value as exponents of m, kg, s, K and rad; empty for a Boolean."""
BOOLEAN: Kind = ()

_BASES = ("m", "kg", "s", "K", "rad")
_SYMBOLS: dict[str, tuple[int, ...]] = {
    "m": (1, 0, 0, 0, 0),
    "kg": (0, 1, 0, 0, 0),
    "s": (0, 0, 1, 0, 0),
    "K": (0, 0, 0, 1, 0),
    "rad": (0, 0, 0, 0, 1),
    "N": (1, 1, -2, 0, 0),
    "Pa": (-1, 1, -2, 0, 0),
    "Hz": (0, 0, -1, 0, 0),
}
DIMENSIONLESS: Kind = (Fraction(0),) * len(_BASES)


def kind_of(dimension: Dimension) -> Kind:
    """Return the exponents of a dimension's SI unit; shares and numbers are dimensionless."""
    unit = next((unit for unit, factor in UNITS[dimension].items() if factor == (1, False, 0)), "")
    numerator, *denominators = unit.replace("^2", "2").replace("^3", "3").split("/")
    powers = list(DIMENSIONLESS)
    for sign, factors in ((1, numerator), *((-1, denominator) for denominator in denominators)):
        for factor in factors.replace("1", "").split():
            symbol, power = factor.rstrip("23"), int(factor[-1]) if factor[-1] in "23" else 1
            powers = [p + sign * power * exponent for p, exponent in zip(powers, _SYMBOLS[symbol], strict=True)]
    return tuple(powers)


DIMENSIONS: dict[str, Dimension] = {word: dimension for dimension in UNITS for word in UNITS[dimension] if word}
"""Dimension of each unit. `Hz` is a frequency; speeds in formulas need rpm or rad/s."""
KINDS = {dimension: kind_of(dimension) for dimension in UNITS}
_KIND_DIMENSIONS = {kind: dimension for dimension, kind in KINDS.items()}


class Function(NamedTuple):
    """Function available in formulas: limits of the number of its arguments, its value, and the value's kind."""

    min_arguments: int
    max_arguments: int
    call: Callable[..., float]
    kind: Callable[[Kind], Kind] = lambda argument: argument


FUNCTIONS = {
    "sqrt": Function(1, 1, math.sqrt, lambda argument: power_kind(argument, Fraction(1, 2))),
    "abs": Function(1, 1, abs),
    "min": Function(2, MAX_CHARACTERS, min),
    "max": Function(2, MAX_CHARACTERS, max),
}
CONSTANTS = {"pi": math.pi}
SUMS: dict[type[ast.operator], Callable[[float, float], float]] = {ast.Add: operator.add, ast.Sub: operator.sub}
PRODUCTS: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
BINARY = SUMS | PRODUCTS | {ast.Pow: operator.pow}
OPERATION_NAMES: dict[type[ast.operator], str] = {
    ast.Add: "a sum",
    ast.Sub: "a difference",
    ast.Mult: "a product",
    ast.Div: "a quotient",
    ast.Pow: "a power",
}
SIGNS: dict[type[ast.unaryop], Callable[[float], float]] = {ast.USub: operator.neg, ast.UAdd: operator.pos}


def is_close(a: float, b: float) -> bool:
    """Check if two values are equal within ``EQUALITY_TOLERANCE``."""
    return math.isclose(a, b, rel_tol=EQUALITY_TOLERANCE, abs_tol=0.0)


COMPARISONS: dict[type[ast.cmpop], Callable[[float, float], bool]] = {
    ast.Lt: lambda a, b: a < b and not is_close(a, b),
    ast.LtE: lambda a, b: a < b or is_close(a, b),
    ast.Gt: lambda a, b: a > b and not is_close(a, b),
    ast.GtE: lambda a, b: a > b or is_close(a, b),
    ast.Eq: is_close,
    ast.NotEq: lambda a, b: not is_close(a, b),
}


def power_kind(kind: Kind, power: Fraction) -> Kind:
    """Return the kind of a power of a value."""
    return tuple(power * exponent for exponent in kind)


def kind_text(kind: Kind) -> str:
    """Describe a kind in words: `a length`, `in m^2`, `true or false`."""
    if kind == BOOLEAN:
        return "true or false"
    if kind == DIMENSIONLESS:
        return "a plain number"
    if kind in _KIND_DIMENSIONS:
        return EXPECTED[_KIND_DIMENSIONS[kind]].split(" such as ")[0]
    powers = [(base, power) for base, power in zip(_BASES, kind, strict=True) if power]
    return "in " + " ".join(base if power == 1 else f"{base}^{power}" for base, power in powers)


def dimension(quantity: str) -> Dimension:
    """Return the dimension of a quantity in text, such as `3 mm`."""
    return DIMENSIONS[split(quantity)[1]]
