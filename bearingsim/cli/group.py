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
from bearingsim.cli.streams import stdout_is_closed
from bearingsim.errors import NO_ROOM, DamageWarning, UserError
from bearingsim.text.terminal import say

EXIT_ERROR = 2  # exit code of errors of the user or the system

CAUSES = {
    errno.ENOENT: "there is no such file or folder",
    errno.EEXIST: "this is a file, not a folder",
    errno.ENOTDIR: "a part of this path is a file, not a folder",
    errno.EACCES: "you are not allowed to read or write here",
    errno.EPERM: "you are not allowed to read or write here",
    errno.EROFS: "the disk is read-only: name a path on another disk",
    errno.ENOSPC: "the disk is full",
    errno.EDQUOT: "the disk quota is exceeded",
    errno.EFBIG: "the file exceeds the size limit (`ulimit -f`)",
    errno.EPIPE: "the process that reads the output has ended (broken pipe): run the command again",
}


def error_text(error: OSError) -> str:
    """Format an error of the operating system: path and cause in words."""
    if not error.filename or error.errno is None:
        target = " (stdout, or a file that the system does not name)" if error.errno in NO_ROOM else ""
        return f"bearingsim: {CAUSES.get(error.errno or 0, error)}{target}"
    path = Path(os.fsdecode(error.filename))
    if error.errno in NO_ROOM:
        from bearingsim.store.files import describe_full_disk

        return f"{describe_full_disk(path, error.errno)}: free some space, or name another folder"
    if error.errno == errno.ENOENT and not path.parent.exists():
        return f"{path}: there is no folder {path.parent}"
    return f"{path}: {CAUSES.get(error.errno, error.strerror)}"


def _show_warning(message: Warning | str, *origin: Any, **options: Any) -> None:
    """Print a warning on stderr: a DamageWarning as plain text, others in Python's format."""
    text = str(message) if isinstance(message, DamageWarning) else warnings.formatwarning(message, *origin[:3])
    say(text, err=True)


@contextmanager
def _reporting_broken_extensions() -> Iterator[None]:
    """Report extensions that did not load when the command ends, unless it fails because of one."""
    try:
        yield
    except extensions.BrokenExtension:
        raise
    except BaseException:
        _report_broken_extensions()
        raise
    else:
        _report_broken_extensions()


def _report_broken_extensions() -> None:
    for text in extensions.BROKEN.values():
        say(f"{text} (skipped)", err=True)


@contextmanager
def _errors_as_messages(ctx: Any) -> Iterator[None]:
    """Convert expected errors to a message and exit code 2, and signals to exit code 128 + their number."""
    try:
        yield
    except KeyboardInterrupt as interruption:
        say(str(interruption) or "interrupted", err=True)
        raise typer.Exit(128 + getattr(interruption, "number", signal.SIGINT)) from None
    except (OSError, UserError) as error:
        if isinstance(error, BrokenPipeError) and stdout_is_closed():
            raise  # typer ends without a message
        if ctx.params.get("verbose"):
            say("Traceback (most recent call last):", err=True)
            traceback.print_tb(error.__traceback__)
        say(error_text(error) if isinstance(error, OSError) else str(error), err=True)
        raise typer.Exit(EXIT_ERROR) from None


class Commands(TyperGroup):
    """Commands whose errors end with a message and an exit code."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Accept `-v` anywhere among the arguments; print the help or the version if requested."""
        verbose_flags = [word for word in args if word in ("-v", "--verbose")]
        with _errors_as_messages(ctx):
            return super().parse_args(
                ctx, verbose_flags[:1] + [word for word in args if word not in verbose_flags]
            )

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        with _errors_as_messages(ctx), warnings.catch_warnings(), _reporting_broken_extensions():
            warnings.simplefilter("once", DamageWarning)
            warnings.filterwarnings("ignore", message=".*joblib will operate in serial mode")  # as --jobs 1
            warnings.showwarning = _show_warning
            return super().invoke(ctx)
