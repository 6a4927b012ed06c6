"""Extensions, that is, installed packages that register models, methods, laws, shapes and features.

A package declares an entry point in the group ``bearingsim.extensions`` (docs/extending.md). An extension that
fails to load or registers an invalid entry is listed in ``BROKEN``. Results can then still be read, but every
command that computes calls ``raise_if_broken`` first, because entries of the broken extension are missing.
"""

import os
from functools import cache
from itertools import takewhile
from typing import TYPE_CHECKING

from bearingsim.errors import UserError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

GROUP = "bearingsim.extensions"
"""Group of the entry points."""
SKIP = "BEARINGSIM_SKIP_EXTENSIONS"
"""Environment variable with the names of the entry points to skip, comma-separated."""
BROKEN: dict[str, str] = {}
"""Error message of each extension that fails to load or registers an invalid entry, by name (see ``owner``)."""


class BrokenExtension(UserError):
    """Error of an extension that cannot be loaded or whose code fails."""


def skipped() -> set[str]:
    """Return the names of the extensions to skip."""
    return {name.strip() for name in os.environ.get(SKIP, "").split(",")} - {""}


@cache
def enabled() -> "tuple[EntryPoint, ...]":
    """Return the entry points of all extensions except the skipped ones, sorted by name."""
    from importlib.metadata import entry_points  # slow, and not needed by commands such as `--help`

    entries = (entry for entry in entry_points(group=GROUP) if entry.name not in skipped())
    return tuple(sorted(entries, key=lambda entry: entry.name))


def package(reference: str) -> str:
    """Return the top-level package of an object reference ``package.module:name``.

    The format is that of the entry points specification (packaging.python.org).
    """
    return _module_parts(reference)[0]


def _module_parts(reference: str) -> list[str]:
    """Return the dotted parts of the module of an object reference."""
    return reference.partition(":")[0].strip().split(".")


def owner(reference: str) -> str:
    """Return the name of the extension that defines the object of a reference, or else the name of its package.

    If a package has several entry points, the one is chosen whose module shares the most leading components
    with that of the reference.
    """
    parts, root = _module_parts(reference), package(reference)

    def common_parts(entry: "EntryPoint") -> int:
        pairs = zip(parts, _module_parts(entry.value), strict=False)
        return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], pairs))

    entries = [entry for entry in enabled() if package(entry.value) == root]
    return max(entries, key=common_parts).name if entries else root


def reason(error: BaseException) -> str:
    """Return the type of an error and the first line of its message."""
    text = str(error).strip().partition("\n")[0]
    return f"{type(error).__name__}: {text}".rstrip(": ")


def load() -> None:
    """Import the module of each extension, which registers its entries; record failures in ``BROKEN``."""
    for entry in enabled():
        try:
            entry.load()
        except (Exception, SystemExit) as error:  # another package may raise anything
            record_failure(
                entry.name, f"the extension `{entry.name}` ({entry.value}) does not load: {reason(error)}"
            )


def record_failure(name: str, message: str) -> None:
    """Store the error message of an extension in ``BROKEN``; a message stored earlier is kept."""
    BROKEN.setdefault(name, message)


def raise_if_broken() -> None:
    """Raise BrokenExtension if an extension is in ``BROKEN``, because its entries are missing.

    The advice to skip extensions is given only if every broken extension has an entry point, because entries
    registered without one cannot be skipped.
    """
    if not BROKEN:
        return
    noun = "extension" if len(BROKEN) == 1 else "extensions"
    if BROKEN.keys() <= {entry.name for entry in enabled()}:
        names = ",".join(sorted(skipped() | BROKEN.keys()))
        advice = f"Fix the {noun}, or set {SKIP}={names} to run without the {noun}"
    else:
        advice = f"Fix or uninstall the {noun}."
    raise BrokenExtension("\n".join([*BROKEN.values(), advice]))
