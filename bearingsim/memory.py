"""How much memory there is: the smaller of the machine's and of what its control group allows."""

from functools import cache
from math import inf
from pathlib import Path

PROGRAM = 300e6
"""Bytes that a process takes before its first job: the program, its libraries, and what it has compiled."""
ROOT = Path("/")
VERSION_1, VERSION_2 = ("sys/fs/cgroup/memory", "memory.limit_in_bytes"), ("sys/fs/cgroup", "memory.max")
"""Where control groups lie, and the name of the file with a group's limit."""


@cache
def limit() -> float:
    """Bytes that all processes may take together; infinite where nothing tells."""
    return limit_in(ROOT)


def limit_in(root: Path) -> float:
    """``limit`` as the files under ``root`` tell it."""
    return min(_of_machine(root), *_of_groups(root), inf)


def _of_machine(root: Path) -> float:
    for line in _lines(root / "proc/meminfo"):
        name, _, amount = line.partition(":")
        if name == "MemTotal":
            return 1024.0 * float(amount.split()[0])
    return inf


def _of_groups(root: Path) -> list[float]:
    """The limits of this process's group and of all above it; those that its container shows as the highest."""
    found = [inf]
    for line in _lines(root / "proc/self/cgroup"):
        _, controllers, group = line.split(":", 2)
        if not controllers or "memory" in controllers.split(","):
            folder, file = VERSION_1 if controllers else VERSION_2
            top = root / folder
            own = top / group.lstrip("/")
            levels = {top, *(level for level in (own, *own.parents) if level.is_relative_to(top))}
            found += [float(text) for level in levels for text in _lines(level / file) if text.isdigit()]
    return found


def _lines(file: Path) -> list[str]:
    """The lines of a file; none if it cannot be read."""
    try:
        return file.read_text(encoding="utf-8").splitlines()
    except OSError:
        return []
