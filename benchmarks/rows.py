"""Rows of measurements as CSV."""

import csv
import sys
from collections.abc import Collection, Iterable, Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import Any


def write_csv(
    rows: Iterable[Mapping[str, Any]], path: str | Path | None, names: Collection[str] = (), digits: int = 0
) -> None:
    """Write rows to a file, or to stdout if there is none, each as soon as it is measured.

    names: columns, those of the first row if empty; digits: significant digits of floats, all if 0.
    """
    with open(path, "w", newline="", encoding="utf-8") if path else nullcontext(sys.stdout) as file:
        table: csv.DictWriter | None = None
        for row in rows:
            if table is None:
                table = csv.DictWriter(file, names or row.keys(), lineterminator="\n")
                table.writeheader()
            table.writerow(rounded(row, digits) if digits else row)
            file.flush()


def rounded(row: Mapping[str, Any], digits: int) -> dict[str, Any]:
    """Format the floats of a row with some significant digits."""
    return {name: f"{value:.{digits}g}" if isinstance(value, float) else value for name, value in row.items()}
