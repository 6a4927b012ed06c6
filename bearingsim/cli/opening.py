"""Results and jobs named by the arguments of a command."""

import os
import shlex
from collections.abc import Callable
from contextlib import suppress
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bearingsim.errors import UserError
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    from bearingsim.store import Results

Command = Callable[..., None]
MAX_QUOTE = 200
"""Largest number of characters quoted from an error in a message."""
DATA_ERRORS = (ArithmeticError, AttributeError, LookupError, MemoryError, RecursionError, TypeError, ValueError)
"""Errors that malformed results raise in a command that reads them."""


def reads_results(command: Command) -> Command:
    """Decorate a command that reads results: malformed ones raise a UserError."""

    @wraps(command)
    def wrapper(*arguments: Any, **options: Any) -> None:
        try:
            command(*arguments, **options)
        except UserError:
            raise
        except DATA_ERRORS as error:
            problem = f"these results cannot be used ({type(error).__name__}: {str(error)[:MAX_QUOTE]})"
            causes = "they are damaged or of another version, or this is a bug (-v shows where)"
            raise UserError(f"{problem}: {causes}").with_traceback(error.__traceback__) from error

    return wrapper


def find_results(folder: Path | None) -> "Results":
    """Open the results in a folder, or the newest valid results in ./results.

    Raises UserError, as ``open_results``.
    """
    from bearingsim.store import LinkInFolder, ResultsError, open_results

    if folder is not None:
        return open_results(folder)
    for results_folder in result_folders():
        try:
            return open_results(results_folder)
        except (ResultsError, LinkInFolder) as error:
            say(f"{error} (skipped)", err=True)
    raise UserError("no results in ./results; name a folder, or run a study first")


def result_folders() -> list[Path]:
    """List the results folders in ./results, newest first."""
    folders = [plan.parent for plan in Path("results").glob("*/plan.json")]
    return sorted(folders, key=_last_change, reverse=True)


def _last_change(folder: Path) -> float:
    """Return the time (s) of the last change of a file in a folder."""
    latest = 0.0
    for file in folder.glob("*"):
        with suppress(FileNotFoundError):  # a run renames and removes its temporary files
            latest = max(latest, file.lstat().st_mtime)
    return latest


def find_job(results: "Results", word: str) -> str:
    """Return the id of the only job whose id begins with ``word``.

    Raises UserError if there is no such job, or more than one.
    """
    matches = [job for job in results.planned if job.startswith(word.lower())]
    if len(matches) != 1:
        problem = f"{len(matches)} jobs begin with" if matches else "no job begins with"
        raise UserError(f"{problem} `{word}`: `bearingsim show {shell_path(results.path)}` lists them")
    return matches[0]


def check_writable(folder: Path, option: str) -> None:
    """Raise UserError, with the option that names another folder, if a results folder is not writable."""
    existing = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not os.access(existing, os.W_OK | os.X_OK):
        raise UserError(f"{short_path(existing)} is read-only for you: name another path, as in `{option}`")


def shell_path(path: Path) -> str:
    """Return ``short_path`` as an argument of a command that the user can copy."""
    return shlex.quote(short_path(path))


def short_path(path: Path) -> str:
    """Return a path relative to the working folder, or absolute if it lies outside."""
    folder, absolute = Path.cwd(), path.resolve()
    return str(absolute.relative_to(folder)) if absolute.is_relative_to(folder) else str(absolute)
