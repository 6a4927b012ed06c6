"""What a results folder holds: which units are sound. Runs, table and export go by it.

`prune` and `merge` remove and copy what they judge, so they trust no table: they read every unit themselves.

A unit whose size and time of last change are those that the table remembers was compared with its digest before,
and its rows are in the table: it is not read again. All others are read whole.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from bearingsim.store.units import DamagedUnit, read_unit

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Stock", "judged"]

Rows = Mapping[str, "pd.DataFrame"]


@dataclass(frozen=True)
class Stock:
    """Sound units, by name: ``known`` to the table, or ``read`` just now, with their rows; and damaged ones."""

    known: set[str] = field(default_factory=set)
    read: "dict[str, pd.DataFrame]" = field(default_factory=dict)
    damaged: dict[Path, str] = field(default_factory=dict)


def judged(units: Iterable[Path], known: "pd.DataFrame | None", read: Rows, everything: bool = False) -> Stock:
    """Judge units. known: the columns ``unit`` and ``stamp`` of the table; read: rows read before, by unit.

    everything: read what is known, too.
    """
    stock, remembered = Stock(), {} if everything else _remembered(known)
    for path in units:
        stamp = _stamp(path)
        if remembered.get(path.stem) == stamp:
            stock.known.add(path.stem)
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
    told = path.lstat()
    return f"{told.st_size} {told.st_mtime_ns}"


def _remembered(known: "pd.DataFrame | None") -> dict[str, str]:
    """Size and time of each unit all of whose jobs are in the table: a narrower plan has left some out."""
    if known is None:
        return {}
    counts = known["unit"].value_counts()
    stamps = known.drop_duplicates("unit").set_index("unit")["stamp"].str.rpartition(" ")
    whole = stamps[2] == counts.reindex(stamps.index).astype(str)
    return dict(stamps[0][whole])
