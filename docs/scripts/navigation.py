"""Navigation of the site: its headings and their pages, from mkdocs.yml."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

DOCS = Path(__file__).parents[1]


class _Loader(yaml.SafeLoader):
    """Loader of mkdocs.yml, which names a Python function."""


_Loader.add_multi_constructor("tag:yaml.org,2002:python/", lambda loader, suffix, node: suffix)


def navigation() -> dict[str, list[str]]:
    """Return the pages below each heading of the navigation, relative to docs/."""
    config = yaml.load((DOCS.parent / "mkdocs.yml").read_text(encoding="utf-8"), _Loader)
    return {heading: list(_pages(entries)) for section in config["nav"] for heading, entries in section.items()}


def _pages(entry: Any) -> Iterator[str]:
    """Yield the pages below an entry."""
    if isinstance(entry, str):
        yield entry
    else:
        for inner in entry.values() if isinstance(entry, dict) else entry:
            yield from _pages(inner)
