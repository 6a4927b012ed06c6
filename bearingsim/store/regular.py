"""Files of a results folder, opened to be read: no link, no pipe, and not more than memory holds.

A results folder may come from anyone. A link in it would lead what is read out of it, a pipe would never end.
"""

import hashlib
import os
import stat
from io import BufferedReader
from pathlib import Path

from bearingsim import memory
from bearingsim.errors import UserError

__all__ = ["BLOCK", "COST", "Unreadable", "digest", "open_regular", "read_regular"]

COST = 32
"""Bytes of memory that what is read of a file may take, over the file's own. Results take up to 13 times."""
BLOCK = 1 << 20
_FLAGS = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)


class Unreadable(UserError):
    """A file is not as it was written, or is of another version: the text says which."""


def open_regular(path: Path) -> BufferedReader:
    """Open a file to be read. Raises Unreadable if it is a link, no file, or larger than memory; OSError."""
    if path.is_symlink():
        raise Unreadable("it is a link: copy the folder with what its links stand for (`cp -rL`)")
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
    """Read a text file. Raises as ``open_regular``, and Unreadable at the first zero byte."""
    blocks = []
    with open_regular(path) as file:
        while block := file.read(BLOCK):
            if b"\0" in block:  # a hole reads as zeros, and takes no room on the disk
                raise Unreadable("it is no text")
            blocks.append(block)
    return b"".join(blocks)
