"""Check of the units of a results folder, for runs, table and export.

A unit whose size and modification time match the table has already been checked against its digest, and its rows
are in the table, so it is not read again. All other units are read completely.

`prune` and `merge` remove and copy units, so they do not rely on the table but read every unit themselves.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from bearingsim.store.units import DamagedUnit, read_unit

if TYPE_CHECKING:
    import pandas as pd

Rows = Mapping[str, "pd.DataFrame"]


@dataclass(frozen=True)
class CheckedUnits:
    """Result of a check: names of units in the table, rows of units not in it, errors of damaged units by path."""

    in_table: set[str] = field(default_factory=set)
    rows: "dict[str, pd.DataFrame]" = field(default_factory=dict)
    damaged: dict[Path, str] = field(default_factory=dict)


def check_units(
    units: Iterable[Path], table: "pd.DataFrame | None", known_rows: Rows, verify: bool = False
) -> CheckedUnits:
    """Check units, and read those whose rows are not known.

    table: with the columns ``unit`` and ``stamp``; known_rows: rows read before, by unit; verify: also read the
    units in the table.
    """
    checked, known_stamps = CheckedUnits(), {} if verify else _known_stamps(table)
    for path in units:
        try:
            stamp = _stamp(path)
        except FileNotFoundError:  # another run has renamed it, because it is damaged
            continue
        if known_stamps.get(path.stem) == stamp:
            checked.in_table.add(path.stem)
        elif path.stem in known_rows and known_rows[path.stem]["stamp"].iloc[0].startswith(f"{stamp} "):
            checked.rows[path.stem] = known_rows[path.stem]
        else:
            _read_rows(path, stamp, checked)
    return checked


def _read_rows(path: Path, stamp: str, checked: CheckedUnits) -> None:
    """Read the rows of a unit, or the error of a damaged one, and add them to ``checked``."""
    import pandas as pd

    try:
        rows = pd.DataFrame({**read_unit(path), "unit": path.stem}).set_index("job")
    except DamagedUnit as damage:
        checked.damaged[path] = str(damage)
    else:
        checked.rows[path.stem] = rows.assign(stamp=f"{stamp} {len(rows)}")


def _stamp(path: Path) -> str:
    """Return size (bytes) and modification time (ns) of a file; in a table the number of jobs follows."""
    status = path.lstat()
    return f"{status.st_size} {status.st_mtime_ns}"


def _known_stamps(table: "pd.DataFrame | None") -> dict[str, str]:
    """Return the stamps of the units whose jobs are all in the table, by name.

    Some jobs of a unit may not be in the table, because they are not in its plan.
    """
    if table is None:
        return {}
    counts = table["unit"].value_counts()
    stamps = table.drop_duplicates("unit").set_index("unit")["stamp"].str.rpartition(" ")
    complete = stamps[2] == counts.reindex(stamps.index).astype(str)
    return dict(stamps[0][complete])
