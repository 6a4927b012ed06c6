"""Record of the files that a study reads or looks for."""

import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

_files: ContextVar[dict[str, str | None] | None] = ContextVar("files", default=None)


@contextmanager
def recorded_files() -> Iterator[dict[str, str | None]]:
    """Collect the SHA-256 of each file recorded in the context, by absolute path; None for a missing file."""
    files: dict[str, str | None] = {}
    token = _files.set(files)
    try:
        yield files
    finally:
        _files.reset(token)


def record(path: Path) -> None:
    """Record a file that is read or looked for."""
    files, absolute = _files.get(), os.path.abspath(path)
    if files is not None and absolute not in files:
        files[absolute] = digest(absolute)


def digest(path: str | Path) -> str | None:
    """Return the SHA-256 of a file; None if it is missing or cannot be read."""
    try:
        if not os.path.isfile(path):
            return None
        with Path(path).open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return None
