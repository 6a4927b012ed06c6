"""Opening of a results folder's files for reading: no links, no pipes, nothing larger than memory.

A results folder may come from anyone. A link would lead out of it, a pipe would never end.
"""

import hashlib
import os
import stat
from io import BufferedReader
from pathlib import Path

from bearingsim import memory
from bearingsim.errors import UserError

COST = 32
"""Largest ratio of the memory for the contents of a file to its size. Results need up to 13."""
BLOCK = 1 << 20  # bytes read at a time
_FLAGS = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)


class Unreadable(UserError):
    """A file is not as it was written, or is of another version; the text gives the reason."""


def open_regular(path: Path) -> BufferedReader:
    """Open a file for reading.

    Raises Unreadable for a link, a special file, or one larger than memory; OSError.
    """
    if path.is_symlink():
        raise Unreadable("it is a link; copy the folder with its link targets (`cp -rL`)")
    descriptor = os.open(path, _FLAGS)
    try:
        status = os.fstat(descriptor)
        if not stat.S_ISREG(status.st_mode):
            raise Unreadable("it is no file")
        if status.st_size > memory.limit():
            raise Unreadable(f"its {status.st_size / 1e9:.3g} GB are more than the memory of this machine")
    except BaseException:
        os.close(descriptor)
        raise
    return os.fdopen(descriptor, "rb")


def digest(path: Path) -> str:
    """Return the SHA-256 of a file in hex digits. Raises as ``open_regular``."""
    with open_regular(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def read_regular(path: Path) -> bytes:
    """Read a text file. Raises as ``open_regular``, and Unreadable for a zero byte."""
    blocks = []
    with open_regular(path) as file:
        while block := file.read(BLOCK):
            if b"\0" in block:  # holes of sparse files read as zeros, of any size
                raise Unreadable("it is no text")
            blocks.append(block)
    return b"".join(blocks)
