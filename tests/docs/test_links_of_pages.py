"""Links of the README and the documentation: each leads to an existing file and heading, on the site too."""

import re
from collections import Counter
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest
from pymdownx.slugs import slugify

from docs.scripts.navigation import DOCS, navigation
from tests.conftest import ROOT

PAGES = sorted(DOCS.rglob("*.md"))
TOP_PAGES = sorted(ROOT.glob("*.md"))
CODE = re.compile(r"^(```+).*?^\1$|^(~~~+).*?^\2$|(`+).+?\3", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(\s*<?([^)\s>]+)[^)]*\)|^\[[^\]]+\]:\s+(\S+)|\b(?:href|src)=\"([^\"]+)\"", re.MULTILINE)
HEADING = re.compile(r"^#{1,6} +(.+?)[ #]*$", re.MULTILINE)
FENCE = re.compile(r"^(```+).*?^\1$|^(~~~+).*?^\2$", re.MULTILINE | re.DOTALL)


class Link(NamedTuple):
    """Link of a page: the file and the anchor in it; ``file`` is the page itself for an anchor alone."""

    page: Path
    file: Path
    anchor: str


def links(page: Path) -> list[Link]:
    """List the links of a page, except those to other hosts and those in code."""
    text = CODE.sub("code", page.read_text(encoding="utf-8"))
    targets = [next(filter(None, groups)) for groups in LINK.findall(text)]
    relative = [target.partition("#") for target in targets if not re.match(r"[a-z]+:", target)]
    return [Link(page, (page.parent / path).resolve() if path else page, anchor) for path, _, anchor in relative]


@cache
def anchors(page: Path) -> Counter[str]:
    """Count the anchors of a page's headings, as GitHub and pymdownx.slugs make them."""
    return Counter(anchor(heading) for heading in HEADING.findall(FENCE.sub("", page.read_text(encoding="utf-8"))))


def anchor(heading: str) -> str:
    """Return the anchor of a heading."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
    return re.sub(r"[^\w\- ]", "", text.lower()).strip().replace(" ", "-")


ALL_LINKS = [link for page in (*TOP_PAGES, *PAGES) for link in links(page)]


def test_pages_have_links() -> None:
    assert len(ALL_LINKS) > 100
    assert any(link.anchor for link in ALL_LINKS)


def test_every_link_leads_to_a_file() -> None:
    assert [link for link in ALL_LINKS if not link.file.exists()] == []


def test_every_anchor_is_that_of_one_heading() -> None:
    """Equal headings of a page are numbered in another way on GitHub than on the site."""
    linked = [link for link in ALL_LINKS if link.anchor and link.file.suffix == ".md"]
    assert [link for link in linked if anchors(link.file)[link.anchor] != 1] == []


def test_links_of_the_documentation_stay_inside_it() -> None:
    """The site contains docs/ only; other files are named as code."""
    inside = [link for link in ALL_LINKS if link.page.is_relative_to(DOCS)]
    assert [link for link in inside if not link.file.is_relative_to(DOCS) or link.file.is_dir()] == []


@pytest.mark.parametrize(
    ("heading", "expected"),
    [
        ("Reasons for 2.5 us instead of chi = 50 s/m", "reasons-for-25-us-instead-of-chi--50-sm"),
        ("`planar`: rollers, cage", "planar-rollers-cage"),
        ("1. Data of [the paper](x.md), and `bearing_x`", "1-data-of-the-paper-and-bearing_x"),
    ],
)
def test_anchor_is_that_of_github(heading: str, expected: str) -> None:
    assert anchor(heading) == expected


def test_anchors_of_the_site_are_those_of_github() -> None:
    headings = [heading for page in PAGES for heading in HEADING.findall(FENCE.sub("", page.read_text()))]
    slug = slugify(case="lower")
    plain = [re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading) for heading in headings]
    assert [text for text in plain if slug(text, "-") != anchor(text)] == []


def test_navigation_has_each_page_once() -> None:
    listed = [page for pages in navigation().values() for page in pages]
    assert Counter(listed) == Counter(str(page.relative_to(DOCS)) for page in PAGES)
