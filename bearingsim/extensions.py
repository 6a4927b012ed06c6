"""Extensions: installed packages that add entries to the catalogue.

A package declares an entry point in the group ``bearingsim.extensions`` (docs/extending.md). An extension that
fails to load is listed in ``BROKEN``. Results can then still be read, but every command that computes calls
``refuse_broken`` first, because a part of the catalogue is missing.
"""

import os
from functools import cache
from typing import TYPE_CHECKING

from bearingsim.errors import UserError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

GROUP = "bearingsim.extensions"
"""Group of the entry points."""
SKIP = "BEARINGSIM_SKIP_EXTENSIONS"
"""Environment variable: names of entry points to skip, separated by commas."""
BROKEN: dict[str, str] = {}
"""Error message of each extension that fails to load, by the name of its entry point."""


class BrokenExtension(UserError):
    """An extension fails to load, or its code fails."""


def skipped() -> set[str]:
    """Return the names of the extensions to skip."""
    return {name.strip() for name in os.environ.get(SKIP, "").split(",")} - {""}


@cache
def installed() -> "tuple[EntryPoint, ...]":
    """Return the entry points of all extensions except the skipped ones, sorted by name."""
    from importlib.metadata import entry_points  # a tenth of `--help`, which needs none

    entries = (entry for entry in entry_points(group=GROUP) if entry.name not in skipped())
    return tuple(sorted(entries, key=lambda entry: entry.name))


def package(reference: str) -> str:
    """Return the top-level package of ``package.module:name``."""
    return reference.partition(":")[0].partition(".")[0].strip()


def owner(reference: str) -> str:
    """Return the name of the extension whose package defines ``reference``, or else the name of the package."""
    root = package(reference)
    return next((entry.name for entry in installed() if package(entry.value) == root), root)


def reason(error: BaseException) -> str:
    """Return the type and the first line of an error."""
    text = str(error).strip().partition("\n")[0]
    return f"{type(error).__name__}: {text}".rstrip(": ")


def load() -> None:
    """Import the module of each extension, which registers its entries; list those that fail in ``BROKEN``."""
    for entry in installed():
        try:
            entry.load()
        except (Exception, SystemExit) as error:  # any failure of another package
            leave_out(entry.name, f"the extension `{entry.name}` ({entry.value}) does not load: {reason(error)}")


def leave_out(name: str, message: str) -> None:
    """List an extension in ``BROKEN``; message: error message. Only the first error of an extension is kept."""
    BROKEN.setdefault(name, message)


def refuse_broken() -> None:
    """Raise BrokenExtension if an extension failed to load, because its entries are missing."""
    if BROKEN:
        names = ",".join(sorted(skipped() | BROKEN.keys()))
        sentences = "\n".join(BROKEN.values())
        raise BrokenExtension(f"{sentences}; fix it, or set {SKIP}={names} to compute without it")
