"""Robust standard streams, which may be closed, have a narrow encoding or have lost their reader."""

import codecs
import os
import select
import sys
from io import TextIOWrapper
from typing import Any

ERROR_HANDLER = "bearingsim.spell"
"""Name of the error handler of both streams."""


class Messages(TextIOWrapper):
    """Stderr that drops messages if its reader has closed it or its disk is full."""

    def write(self, text: str) -> int:
        """Write a text, or drop it on errors."""
        try:
            return super().write(text)
        except OSError:
            return len(text)

    def flush(self) -> None:
        """Flush, or drop the buffer on errors."""
        try:
            super().flush()
        except OSError:
            return


def prepare() -> None:
    """Connect closed streams to the null device, and set an encoder that never fails on stdout and stderr."""
    _reserve_descriptors()
    codecs.register_error(ERROR_HANDLER, _spell_out)
    sys.stdout = sys.stdout or os.fdopen(1, "w", closefd=False)
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors=ERROR_HANDLER)
    if sys.stderr is None:
        sys.stderr = Messages(os.fdopen(2, "wb", closefd=False), errors=ERROR_HANDLER)
    elif type(sys.stderr) is TextIOWrapper:
        sys.stderr = Messages(sys.stderr.buffer, sys.stderr.encoding, ERROR_HANDLER, line_buffering=True)


def _reserve_descriptors() -> None:
    """Open the null device on closed descriptors 0 to 2, so that no results file gets one of them."""
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= 2:
        os.set_inheritable(descriptor, True)
    os.close(descriptor)


def _spell_out(error: UnicodeError) -> tuple[str, int]:
    """Spell units as study files may (µm: um), and escape other characters missing from an encoding."""
    from bearingsim.text.units import SPELLING

    if not isinstance(error, UnicodeEncodeError):
        raise error
    text = error.object[error.start : error.end].translate(SPELLING)
    return text.encode("ascii", "backslashreplace").decode(), error.end


def stdout_is_closed() -> bool:
    """Return True if stdout is a pipe closed at the other end, as after `| head`, or if this cannot be
    determined."""
    if not hasattr(select, "poll"):
        return True
    poller: Any = select.poll()
    poller.register(1, 0)
    return any(event & (select.POLLERR | select.POLLHUP) for _, event in poller.poll(0))
