"""Group of commands, which end with a message and an exit code instead of a traceback."""

import errno
import os
import signal
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperGroup

from bearingsim import extensions
from bearingsim.cli.streams import reader_is_gone
from bearingsim.errors import NO_ROOM, DamageWarning, UserError
from bearingsim.text.terminal import say

WRONG = 2  # exit code of errors of the user or the system

WORDS = {
    errno.ENOENT: "there is no such file or folder",
    errno.EEXIST: "this is a file, not a folder",
    errno.ENOTDIR: "a part of this path is a file, not a folder",
    errno.EACCES: "you are not allowed to read or write here",
    errno.EPERM: "you are not allowed to read or write here",
    errno.EROFS: "the disk can only be read",
    errno.ENOSPC: "the disk is full",
    errno.EDQUOT: "no more room is allowed on this disk",
    errno.EFBIG: "no file may grow so large here (`ulimit -f`)",
    errno.EPIPE: "a process that this one writes to has ended (broken pipe): run the command again",
}


def sentence(error: OSError) -> str:
    """Format an error of the operating system: path and cause in words."""
    if not error.filename or error.errno is None:
        target = " (stdout, or a file that the system does not name)" if error.errno in NO_ROOM else ""
        return f"bearingsim: {WORDS.get(error.errno or 0, error)}{target}"
    path = Path(os.fsdecode(error.filename))
    if error.errno in NO_ROOM:
        from bearingsim.store.files import what_is_full

        return f"{what_is_full(path, error.errno)}: make room, or name another folder"
    if error.errno == errno.ENOENT and not path.parent.exists():
        return f"{path}: there is no folder {path.parent}"
    return f"{path}: {WORDS.get(error.errno, error.strerror)}"


def _tell(message: Warning | str, *origin: Any, **more: Any) -> None:
    """Print a warning on stderr: a DamageWarning as plain text, others in Python's format."""
    text = str(message) if isinstance(message, DamageWarning) else warnings.formatwarning(message, *origin[:3])
    say(text, err=True)


@contextmanager
def _left_out_told() -> Iterator[None]:
    """Report extensions that did not load when the command ends, unless it fails because of one."""
    try:
        yield
    except extensions.BrokenExtension:
        raise
    except BaseException:
        _tell_left_out()
        raise
    else:
        _tell_left_out()


def _tell_left_out() -> None:
    for sentence in extensions.BROKEN.values():
        say(f"{sentence} (left out)", err=True)


@contextmanager
def _ended_by_message(ctx: Any) -> Iterator[None]:
    """Convert expected errors to a message and exit code 2, and signals to exit code 128 + their number."""
    try:
        yield
    except KeyboardInterrupt as stop:
        say(str(stop) or "interrupted", err=True)
        raise typer.Exit(128 + getattr(stop, "number", signal.SIGINT)) from None
    except (OSError, UserError) as error:
        if isinstance(error, BrokenPipeError) and reader_is_gone():
            raise  # typer ends without a message
        if ctx.params.get("verbose"):
            say("Traceback (most recent call last):", err=True)
            traceback.print_tb(error.__traceback__)
        say(sentence(error) if isinstance(error, OSError) else str(error), err=True)
        raise typer.Exit(WRONG) from None


class Commands(TyperGroup):
    """Commands whose errors end with a message and an exit code."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Accept `-v` anywhere among the arguments; print the help or the version if requested."""
        loud = [word for word in args if word in ("-v", "--verbose")]
        with _ended_by_message(ctx):
            return super().parse_args(ctx, loud[:1] + [word for word in args if word not in loud])

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        with _ended_by_message(ctx), warnings.catch_warnings(), _left_out_told():
            warnings.simplefilter("once", DamageWarning)
            warnings.filterwarnings("ignore", message=".*joblib will operate in serial mode")  # as --jobs 1
            warnings.showwarning = _tell
            return super().invoke(ctx)
