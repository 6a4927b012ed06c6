"""Memory limit: the smaller of the machine's memory and the limits of the control groups of this process."""

from functools import cache
from math import inf
from pathlib import Path

PROGRAM_BYTES = 300e6
"""Memory (bytes) of a process before its first job: the program, its libraries and compiled code."""
ROOT = Path("/")
VERSION_1, VERSION_2 = ("sys/fs/cgroup/memory", "memory.limit_in_bytes"), ("sys/fs/cgroup", "memory.max")
"""Folder of the control groups, and name of the file with the limit of a group (bytes)."""


@cache
def limit() -> float:
    """Return the memory limit (bytes) for all processes together; inf if the system reports none."""
    return limit_in(ROOT)


def limit_in(root: Path) -> float:
    """Return the memory limit (bytes) according to the system files under ``root``."""
    return min(_available_memory(root), *_group_limits(root), inf)


def _available_memory(root: Path) -> float:
    for line in _lines(root / "proc/meminfo"):
        name, _, amount = line.partition(":")
        if name == "MemTotal":
            return 1024.0 * float(amount.split()[0])
    return inf


def _group_limits(root: Path) -> list[float]:
    """Return the limits of the control groups of this process and of their parents, as far as they are visible."""
    limits = [inf]
    for line in _lines(root / "proc/self/cgroup"):
        _, controllers, group = line.split(":", 2)
        if not controllers or "memory" in controllers.split(","):
            folder, file = VERSION_1 if controllers else VERSION_2
            base = root / folder
            group_folder = base / group.lstrip("/")
            levels = {
                base,
                *(level for level in (group_folder, *group_folder.parents) if level.is_relative_to(base)),
            }
            limits += [float(text) for level in levels for text in _lines(level / file) if text.isdigit()]
    return limits


def _lines(file: Path) -> list[str]:
    """Read the lines of a file; return an empty list if it cannot be read."""
    try:
        return file.read_text(encoding="utf-8").splitlines()
    except OSError:
        return []
