"""From what was typed to the results meant."""

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bearingsim.errors import UserError
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    from bearingsim.store import Results

__all__ = ["job_meant", "near", "opened", "reading"]

Command = Callable[..., None]
LONGEST = 200
"""Letters of an error that a message repeats."""
UNUSABLE = (ArithmeticError, AttributeError, LookupError, MemoryError, RecursionError, TypeError, ValueError)
"""What a command raises where results are other than they should be."""


def reading(command: Command) -> Command:
    """Let a command that reads results end with a sentence where they are such as no run leaves behind."""

    @wraps(command)
    def read(*arguments: Any, **options: Any) -> None:
        try:
            command(*arguments, **options)
        except UserError:
            raise
        except UNUSABLE as error:
            what = f"these results cannot be used ({type(error).__name__}: {str(error)[:LONGEST]})"
            causes = "they are damaged or of another version, or this is an error of the program (-v shows where)"
            raise UserError(f"{what}: {causes}").with_traceback(error.__traceback__) from error

    return read


def opened(folder: Path | None) -> "Results":
    """The results in a folder, or the newest sound ones in ./results. Raises UserError, as ``open_results``."""
    from bearingsim.store import LinkWithin, ResultsError, open_results

    if folder is not None:
        return open_results(folder)
    for root in _newest_first():
        try:
            return open_results(root)
        except (ResultsError, LinkWithin) as error:
            say(f"{error} (left out)", err=True)
    raise UserError("there are no results in ./results: name a folder, or run a study first")


def _newest_first() -> list[Path]:
    roots = [plan.parent for plan in Path("results").glob("*/plan.json")]
    return sorted(roots, key=lambda root: max(file.lstat().st_mtime for file in root.glob("*")), reverse=True)


def job_meant(results: "Results", word: str) -> str:
    """The id of the job whose id begins with ``word``. Raises UserError if none does, or several do."""
    found = [job for job in results.planned if job.startswith(word.lower())]
    if len(found) != 1:
        problem = f"{len(found)} jobs begin with" if found else "no job begins with"
        raise UserError(f"{problem} `{word}`: `bearingsim show {near(results.path)}` lists them")
    return found[0]


def near(path: Path) -> str:
    """A path as seen from the working folder."""
    here, whole = Path.cwd(), path.resolve()
    return str(whole.relative_to(here)) if whole.is_relative_to(here) else str(whole)
