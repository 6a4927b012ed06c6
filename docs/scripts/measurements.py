"""Measurements in ``docs/data``, and the format of their numbers in tables."""

import pandas as pd

from docs.scripts.navigation import DOCS


def read(name: str) -> pd.DataFrame:
    """Read a table of measurements."""
    return pd.read_csv(DOCS / "data" / f"{name}.csv")


def digits(value: float) -> str:
    """Return a number with three digits; whole numbers in full."""
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"


def percent(share: float) -> str:
    """Return a share in per cent with two digits; whole numbers in full."""
    return f"{100 * share:.0f}" if share >= 1 else f"{100 * share:.2g}"
