"""Notes on the repairs of measured files, for messages."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, Protocol

from bearingsim.config.scan.repair import read_scan
from bearingsim.config.scan.roundness import read_roundness, remarks


class HasFiles(Protocol):
    """Object with defects and surfaces, such as a case."""

    @property
    def defects(self) -> Sequence[Any]: ...

    @property
    def surfaces(self) -> Any: ...


def notes(cases: Iterable[HasFiles]) -> list[str]:
    """List the repairs and assumptions of all scans and roundness profiles of the cases, without duplicates.

    Raises ScanError if a file is invalid or missing.
    """
    scans: dict[str, None] = {}
    profiles: dict[tuple[str, tuple[int, int]], None] = {}
    for case in cases:
        scans |= dict.fromkeys(defect.file for defect in case.defects if defect.file is not None)
        roundness_sections = case.surfaces.profiles.values() if case.surfaces is not None else ()
        profiles |= dict.fromkeys((roundness.file, roundness.orders) for roundness in roundness_sections)
    texts = [(file, note) for file in scans for note in read_scan(file).notes]
    texts += [(file, note) for file, orders in profiles for note in remarks(read_roundness(file), orders)]
    return list(dict.fromkeys(f"{Path(file).name}: {note}" for file, note in texts))
