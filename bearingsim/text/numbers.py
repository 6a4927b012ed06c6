"""Numbers as text, for tables and messages."""

from collections.abc import Callable
from math import isfinite


def significant(value: float, digits: int = 3) -> str:
    """Format a number with a few significant digits, without exponent below 1e6; `-` for nan or infinity."""
    if not isfinite(value):
        return "-"
    rounded = float(f"{value:.{digits}g}") + 0.0  # -0.0 reads 0
    return f"{rounded:.0f}" if 10**digits <= abs(rounded) < 1e6 else f"{rounded:.{digits}g}"


def span(low: float, high: float, form: Callable[[float], str]) -> str:
    """Format a range as `0.31 to 0.42`, or as one number if both ends are formatted equally."""
    return " to ".join(dict.fromkeys((form(low), form(high))))


def percent(share: float, digits: int = 2) -> str:
    """Format a share in percent with a few significant digits, without exponent: `0.12 %`, `1100 %`, `inf %`."""
    return f"{significant(100.0 * share, digits) if isfinite(share) else share} %"


def is_number(text: str) -> bool:
    """Check if Python reads a text as a number; `nan` and `inf` are numbers."""
    try:
        float(text)
    except ValueError:
        return False
    return True
