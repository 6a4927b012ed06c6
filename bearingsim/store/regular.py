"""Safe opening of files for reading, which refuses links, special files and files larger than memory.

Results folders may come from untrusted sources. A link could point outside the folder, and reading a pipe could
block forever.
"""

import hashlib
import os
import stat
from io import BufferedReader
from pathlib import Path

from bearingsim import memory
from bearingsim.errors import UserError

MEMORY_RATIO = 32
"""Largest ratio of the memory for the contents of a file to its size; it is up to 13 for results."""
BLOCK_BYTES = 1 << 20  # bytes read at a time
_OPEN_FLAGS = (
    os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
)


class Unreadable(UserError):
    """A file is damaged or of another version; the message states the reason."""


def open_regular(path: Path) -> BufferedReader:
    """Open a file for reading.

    Raises Unreadable for a link, a special file, or a file larger than memory; OSError.
    """
    if path.is_symlink():
        raise Unreadable("it is a link; copy the folder with its link targets (`cp -rL`)")
    descriptor = os.open(path, _OPEN_FLAGS)
    try:
        status = os.fstat(descriptor)
        if not stat.S_ISREG(status.st_mode):
            raise Unreadable("it is not a file")
        if status.st_size > memory.limit():
            raise Unreadable(f"its {status.st_size / 1e9:.3g} GB are more than the memory of this machine")
    except BaseException:
        os.close(descriptor)
        raise
    return os.fdopen(descriptor, "rb")


def digest(path: Path) -> str:
    """Return the SHA-256 of a file in hex digits. Raises the errors of ``open_regular``."""
    with open_regular(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def read_regular(path: Path) -> bytes:
    """Read a text file as bytes. Raises the errors of ``open_regular``, and Unreadable for a zero byte."""
    blocks = []
    with open_regular(path) as file:
        while block := file.read(BLOCK_BYTES):
            if b"\0" in block:  # a sparse file may declare any size, and is read as zeros
                raise Unreadable("it is not a text file")
            blocks.append(block)
    return b"".join(blocks)
