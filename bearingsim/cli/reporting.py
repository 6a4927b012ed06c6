"""`bearingsim report`: the page of a study, written to a file."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from bearingsim.cli.opening import short_path
from bearingsim.text.terminal import say

if TYPE_CHECKING:
    from bearingsim.store import Results

FILE = "report.html"


def write(results: "Results", out: Path | None, jobs: Sequence[str] = ()) -> None:
    """Write the page of a study to a file, by default in its results folder."""
    from bearingsim.report.page import page_of
    from bearingsim.report.render import html
    from bearingsim.store import write_text

    path = out or results.path / FILE
    text = html(page_of(results, jobs))
    write_text(path, text)
    say(f"{short_path(path)}: {len(text.encode()) / 1e6:.2g} MB")
