"""Numbers as text, for tables and messages."""


def significant(value: float, digits: int = 3) -> str:
    """Format a number with a few significant digits, without exponent up to 1e6; `-` for nan or infinity."""
    if value != value or value in (float("inf"), float("-inf")):
        return "-"
    rounded = float(f"{value:.{digits}g}")
    return f"{rounded:.0f}" if 10**digits <= abs(rounded) < 1e6 else f"{rounded:.{digits}g}"
