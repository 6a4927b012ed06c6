"""Memory limit: the smaller of the machine's memory and the limits of the control groups of this process."""

from functools import cache
from math import inf
from pathlib import Path

PROGRAM_BYTES = 300e6
"""Memory (bytes) of a process before its first job: the program, its libraries and compiled code."""
ROOT = Path("/")
CGROUP_V1, CGROUP_V2 = ("sys/fs/cgroup/memory", "memory.limit_in_bytes"), ("sys/fs/cgroup", "memory.max")
"""Folder of the control groups by version, and name of the file with the limit of a group (bytes)."""


@cache
def limit() -> float:
    """Return the memory limit (bytes) for all processes together; inf if the system reports none."""
    return limit_in(ROOT)


def limit_in(root: Path) -> float:
    """Return the memory limit (bytes) according to the system files in the folder ``root``."""
    return min(_physical_memory(root), *_group_limits(root), inf)


def _physical_memory(root: Path) -> float:
    for line in _read_lines(root / "proc/meminfo"):
        name, _, amount = line.partition(":")
        if name == "MemTotal":
            return 1024.0 * float(amount.split()[0])
    return inf


def _group_limits(root: Path) -> list[float]:
    """Return the limits of the control groups of this process and of their visible parents."""
    limits = [inf]
    for line in _read_lines(root / "proc/self/cgroup"):
        _, controllers, group = line.split(":", 2)
        if not controllers or "memory" in controllers.split(","):
            folder, file = CGROUP_V1 if controllers else CGROUP_V2
            base = root / folder
            group_folder = base / group.lstrip("/")
            levels = {
                base,
                *(level for level in (group_folder, *group_folder.parents) if level.is_relative_to(base)),
            }
            limits += [float(text) for level in levels for text in _read_lines(level / file) if text.isdigit()]
    return limits


def _read_lines(file: Path) -> list[str]:
    """Read the lines of a file; return an empty list if it cannot be read."""
    try:
        return file.read_text(encoding="utf-8").splitlines()
    except OSError:
        return []
