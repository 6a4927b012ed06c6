"""Numbers as text, for tables and messages."""


def significant(value: float, digits: int = 3) -> str:
    """Format a number with a few significant digits, as an integer up to 1e6; `-` for nan or infinity."""
    if value != value or value in (float("inf"), float("-inf")):
        return "-"
    return f"{value:.{digits}g}" if abs(value) < 10**digits or abs(value) >= 1e6 else f"{value:.0f}"
