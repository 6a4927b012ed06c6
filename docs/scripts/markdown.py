"""Markdown of the reference pages."""

import re
from collections.abc import Iterable, Sequence

NOTE = "<!-- Written by `make docs-reference` from the program. Do not edit. -->"


def page(title: str, *parts: str) -> str:
    """Return the text of a page from its title and parts."""
    return "\n\n".join((f"# {title}", NOTE, *parts)) + "\n"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table; columns without any content are left out."""
    cells = [[_cell(text) for text in row] for row in rows]
    kept = [i for i in range(len(head)) if any(row[i] for row in cells)]
    lines = [[head[i] for i in kept], ["---"] * len(kept), *([row[i] for i in kept] for row in cells)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def code(*words: str) -> str:
    """Return words as code, joined by commas."""
    return ", ".join(f"`{word}`" for word in words)


def _cell(text: str) -> str:
    """Return text as content of a cell; `<` outside of code would begin a tag."""
    parts = re.split("(`[^`]*`)", text.replace("|", "\\|").replace("\n", " "))
    return "".join(part if part.startswith("`") else part.replace("<", "&lt;") for part in parts)
