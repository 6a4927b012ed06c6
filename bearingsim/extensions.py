"""Other packages that extend the program: which are installed, and which of them do not load.

A package is found by its entry point in the group ``bearingsim.extensions`` (docs/extending.md). One that does not
load is left out and kept in ``BROKEN``. Results are read all the same; whatever computes calls ``refuse_broken``
first, because a part of the catalogue is missing.
"""

import os
from functools import cache
from importlib.metadata import EntryPoint, entry_points

from bearingsim.errors import UserError

GROUP = "bearingsim.extensions"
"""Group of the entry points."""
SKIP = "BEARINGSIM_SKIP_EXTENSIONS"
"""Environment variable: names of entry points that are not loaded, separated by commas."""
BROKEN: dict[str, str] = {}
"""The error of each extension that does not load, as a sentence, by the name of its entry point."""


class BrokenExtension(UserError):
    """An extension that does not load, or whose code does not."""


def skipped() -> set[str]:
    """Return the names of the extensions that are not to be loaded."""
    return {name.strip() for name in os.environ.get(SKIP, "").split(",")} - {""}


@cache
def installed() -> tuple[EntryPoint, ...]:
    """Return the entry points of all extensions but the skipped ones, by name."""
    left = (entry for entry in entry_points(group=GROUP) if entry.name not in skipped())
    return tuple(sorted(left, key=lambda entry: entry.name))


def package(place: str) -> str:
    """Return the top-level package of ``package.module:name``."""
    return place.partition(":")[0].partition(".")[0].strip()


def owner(place: str) -> str:
    """Return the name of the extension whose package holds ``place``; that of the package if none does."""
    root = package(place)
    return next((entry.name for entry in installed() if package(entry.value) == root), root)


def reason(error: BaseException) -> str:
    """Return the kind and the first line of an error."""
    text = str(error).strip().partition("\n")[0]
    return f"{type(error).__name__}: {text}".rstrip(": ")


def load() -> None:
    """Import the module of each extension, which registers what it adds; leave out those that fail."""
    for entry in installed():
        try:
            entry.load()
        except (Exception, SystemExit) as error:  # whatever another package does
            leave_out(entry.name, f"the extension `{entry.name}` ({entry.value}) does not load: {reason(error)}")


def leave_out(name: str, why: str) -> None:
    """Count an extension among those that do not load; ``why``: a sentence. The first error of each is kept."""
    BROKEN.setdefault(name, why)


def refuse_broken() -> None:
    """Raise BrokenExtension if an extension does not load: what it adds would be missing from the results."""
    if BROKEN:
        names = ",".join(sorted(skipped() | BROKEN.keys()))
        sentences = "\n".join(BROKEN.values())
        raise BrokenExtension(f"{sentences}; mend it, or set {SKIP}={names} to compute without it")
