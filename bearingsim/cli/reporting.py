"""`bearingsim report`: the page of a study, written to a file."""

import time
import webbrowser
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from bearingsim.cli.opening import check_writable, short_path
from bearingsim.errors import UserError
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    from bearingsim.store import Results

FILE, PLAN = "report.html", "plan.json"
"""Default name of the page, and the file of a results folder that a run writes first."""
PERIOD_S = 10.0
"""Time (s) between two versions of a page that follows a run."""


def show(results: "Results", out: Path | None, jobs: Sequence[str], follow: bool, in_browser: bool) -> None:
    """Write the page of a study, by default into its results folder.

    jobs: ids of those whose signals are shown; follow: rewrite the page until no job is missing; in_browser:
    open the page. Raises UserError for an existing file that is not a report.
    """
    path = out or results.path / FILE
    check_replaceable(path)
    if out is None:
        check_writable(results.path, "--out page.html")
    is_complete = write(results, path, jobs, follow)
    if in_browser and not webbrowser.open(path.resolve().as_uri()):
        say(f"cannot start a browser; the page is {short_path(path)}", err=True)
    if follow and not is_complete:
        say("following the run; Ctrl-C ends this command, not the run", err=True)
    while follow and not is_complete:
        time.sleep(PERIOD_S)
        is_complete = write(type(results)(results.path), path, jobs, follow)


def wait_for_plan(folder: Path) -> None:
    """Wait until the run of a folder has written its plan."""
    if not (folder / PLAN).is_file():
        say(f"waiting for a run in {short_path(folder)}; Ctrl-C ends this command", err=True)
    while not (folder / PLAN).is_file():
        time.sleep(PERIOD_S / 10.0)


def write(results: "Results", path: Path, jobs: Sequence[str], follow: bool) -> bool:
    """Write the current page atomically; return whether all jobs are done or failed."""
    from bearingsim.report.page import make_page
    from bearingsim.report.render import render_html
    from bearingsim.store import write_text

    page = make_page(results, jobs)
    text = render_html(page, PERIOD_S if follow and not page.complete else None)
    write_text(path, text)
    say(f"{short_path(path)}: {page.counts}, {len(text.encode()) / 1e6:.2g} MB")
    return page.complete


def check_replaceable(path: Path) -> None:
    """Raise UserError unless a path does not exist or is a report of bearingsim."""
    from bearingsim.report.render import MARK

    if path.is_dir():
        raise UserError(f"{path} is a folder: name a file, such as {path / FILE}")
    if path.is_symlink() or path.exists():
        is_page = path.is_file() and not path.is_symlink() and MARK.encode() in path.read_bytes()
        if not is_page:
            raise UserError(
                f"{path} exists and is not a report of bearingsim; use another --out, or move the file"
            )
