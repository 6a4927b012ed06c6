"""Other runs in the same folder: what they have sealed meanwhile is not computed again."""

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from bearingsim import store

LOOK_S = 0.5
"""Least time between two looks into the folder (s): each lists all units."""


@dataclass
class OtherRuns:
    """Jobs that other runs have sealed in a folder since this one began.

    known: names of the units that were judged then. Of its own units a run begins no job that it has sealed.
    """

    root: Path
    known: frozenset[str]
    _jobs: set[str] = field(default_factory=set, init=False)
    _looked: float = field(default=-LOOK_S, init=False)

    def have(self, job: str) -> bool:
        """Check if another run has sealed a job, as seen at most LOOK_S ago."""
        if time.monotonic() - self._looked >= LOOK_S:
            others = store.unit_names(self.root) - self.known
            self._jobs = {name for unit in others for name in _jobs(store.unit_path(self.root, unit))}
            self._looked = time.monotonic()
        return job in self._jobs


@cache
def _jobs(path: Path) -> list[str]:
    """Return the ids of the jobs of a unit, which never changes; none if it cannot be read."""
    try:
        return store.jobs_named(path)
    except store.DamagedUnit:
        return []


def notes(root: Path, plan: Mapping[str, Any], elsewhere: int) -> Iterator[str]:
    """Yield what other runs in the folder did meanwhile; plan: of this run; elsewhere: number of their jobs."""
    if elsewhere:
        jobs = f"{elsewhere} jobs were" if elsewhere > 1 else "1 job was"
        yield f"{jobs} computed by another run in this folder meanwhile"
    now = store.planned_jobs(root)
    ours = {entry["job"] for entry in plan["jobs"]}
    if now != ours:
        lacking = f"lacks {len(ours - now)} of this run's {len(ours)} jobs" if ours - now else "has more jobs"
        yield (
            f"another run has replaced the plan of this folder meanwhile: its table {lacking}"
            " (all results are kept: give this command again for the table of its plan)"
        )
