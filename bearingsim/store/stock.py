"""Check of the units of a results folder, for runs, table and export.

`prune` and `merge` remove and copy units, so they do not rely on the table and read every unit themselves.

A unit with the size and modification time noted in the table was checked against its digest before, and its rows
are in the table: it is not read again. All others are read completely.
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
class Stock:
    """Sound units by name, ``in_table`` or just ``read``, with their rows; and damaged ones by path."""

    in_table: set[str] = field(default_factory=set)
    read: "dict[str, pd.DataFrame]" = field(default_factory=dict)
    damaged: dict[Path, str] = field(default_factory=dict)


def judged(units: Iterable[Path], table: "pd.DataFrame | None", read: Rows, everything: bool = False) -> Stock:
    """Check units. table: its columns ``unit`` and ``stamp``; read: rows read before, by unit.

    everything: also read the units that are in the table.
    """
    stock, remembered = Stock(), {} if everything else _remembered(table)
    for path in units:
        stamp = _stamp(path)
        if remembered.get(path.stem) == stamp:
            stock.in_table.add(path.stem)
        elif path.stem in read and read[path.stem]["stamp"].iloc[0].startswith(f"{stamp} "):
            stock.read[path.stem] = read[path.stem]
        else:
            _read(path, stamp, stock)
    return stock


def _read(path: Path, stamp: str, stock: Stock) -> None:
    import pandas as pd

    try:
        rows = pd.DataFrame({**read_unit(path), "unit": path.stem}).set_index("job")
    except DamagedUnit as damage:
        stock.damaged[path] = str(damage)
    else:
        stock.read[path.stem] = rows.assign(stamp=f"{stamp} {len(rows)}")


def _stamp(path: Path) -> str:
    status = path.lstat()
    return f"{status.st_size} {status.st_mtime_ns}"


def _remembered(table: "pd.DataFrame | None") -> dict[str, str]:
    """Return the stamp of each unit with all of its jobs in the table, by name.

    The table of a narrower plan lacks some jobs of a unit.
    """
    if table is None:
        return {}
    counts = table["unit"].value_counts()
    stamps = table.drop_duplicates("unit").set_index("unit")["stamp"].str.rpartition(" ")
    whole = stamps[2] == counts.reindex(stamps.index).astype(str)
    return dict(stamps[0][whole])
