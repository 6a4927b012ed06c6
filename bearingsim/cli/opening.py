"""Results and jobs named by the arguments of a command."""

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bearingsim.errors import UserError
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    from bearingsim.store import Results

Command = Callable[..., None]
LONGEST = 200
"""Largest number of characters quoted from an error in a message."""
UNUSABLE = (ArithmeticError, AttributeError, LookupError, MemoryError, RecursionError, TypeError, ValueError)
"""Errors that malformed results raise in a command that reads them."""


def reading(command: Command) -> Command:
    """Decorate a command that reads results: malformed results raise a UserError."""

    @wraps(command)
    def read(*arguments: Any, **options: Any) -> None:
        try:
            command(*arguments, **options)
        except UserError:
            raise
        except UNUSABLE as error:
            problem = f"these results cannot be used ({type(error).__name__}: {str(error)[:LONGEST]})"
            causes = "they are damaged or of another version, or this is a bug (-v shows where)"
            raise UserError(f"{problem}: {causes}").with_traceback(error.__traceback__) from error

    return read


def opened(folder: Path | None) -> "Results":
    """Open the results in a folder, or the newest valid results in ./results.

    Raises UserError, as ``open_results``.
    """
    from bearingsim.store import LinkWithin, ResultsError, open_results

    if folder is not None:
        return open_results(folder)
    for root in _newest_first():
        try:
            return open_results(root)
        except (ResultsError, LinkWithin) as error:
            say(f"{error} (left out)", err=True)
    raise UserError("no results in ./results; name a folder, or run a study first")


def _newest_first() -> list[Path]:
    roots = [plan.parent for plan in Path("results").glob("*/plan.json")]
    return sorted(roots, key=lambda root: max(file.lstat().st_mtime for file in root.glob("*")), reverse=True)


def job_meant(results: "Results", word: str) -> str:
    """Return the id of the only job whose id begins with ``word``.

    Raises UserError if there is no such job, or more than one.
    """
    matches = [job for job in results.planned if job.startswith(word.lower())]
    if len(matches) != 1:
        problem = f"{len(matches)} jobs begin with" if matches else "no job begins with"
        raise UserError(f"{problem} `{word}`: `bearingsim show {near(results.path)}` lists them")
    return matches[0]


def near(path: Path) -> str:
    """Return a path relative to the working folder, or absolute if it lies outside."""
    folder, whole = Path.cwd(), path.resolve()
    return str(whole.relative_to(folder)) if whole.is_relative_to(folder) else str(whole)
