"""From what was typed to the results meant."""

from pathlib import Path
from typing import TYPE_CHECKING

from bearingsim.errors import UserError

if TYPE_CHECKING:
    from bearingsim.store import Results

__all__ = ["job_meant", "near", "opened"]


def opened(folder: Path | None) -> "Results":
    """The results in a folder, or the newest in ./results. Raises UserError."""
    from bearingsim.store import open_results

    return open_results(folder if folder is not None else _newest())


def _newest() -> Path:
    plans = list(Path("results").glob("*/plan.json"))
    if not plans:
        raise UserError("there are no results in ./results: name a folder, or run a study first")
    return max(plans, key=lambda plan: max(file.stat().st_mtime for file in plan.parent.glob("*"))).parent


def job_meant(results: "Results", word: str) -> str:
    """The id of the job whose id begins with ``word``. Raises UserError if none does, or several do."""
    found = [job for job in results.jobs if job.startswith(word.lower())]
    if len(found) != 1:
        problem = f"{len(found)} jobs begin with" if found else "no job begins with"
        raise UserError(f"{problem} `{word}`: `bearingsim show {near(results.path)}` lists them")
    return found[0]


def near(path: Path) -> str:
    """A path as seen from the working folder."""
    here, whole = Path.cwd(), path.resolve()
    return str(whole.relative_to(here)) if whole.is_relative_to(here) else str(whole)
