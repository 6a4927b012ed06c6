"""Equations of the theory pages: numbered once, cited by the functions that compute them."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGES = {
    "M": ("model", "defects"),
    "C": ("contact",),
    "P": ("planar",),
    "S": ("spatial",),
    "R": ("ring",),
    "F": ("form",),
}
"""Pages of the equations of each letter."""
NUMBER = re.compile(rf"\(([{''.join(PAGES)}])(\d+)\)")
TAG = re.compile(r"\\tag\{([A-Z])(\d+)\}$", re.MULTILINE)


def equation_numbers(page: str) -> list[int]:
    """Return the numbers of the equations of a page, in its order."""
    return [int(number) for _, number in TAG.findall((ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8"))]


def citations() -> Iterator[tuple[str, str, int]]:
    """List page, letter and number of each citation; the pages are all that its docstring names."""
    for path in sorted((ROOT / "bearingsim").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef):
                text = ast.get_docstring(node) or ""
                pages = re.findall(r"docs/(\w+)\.md", text)
                for letter, number in NUMBER.findall(text):
                    yield " ".join(pages), letter, int(number)


@pytest.mark.parametrize("letter", PAGES)
def test_equations_are_numbered_once_and_in_order(letter: str) -> None:
    of_pages = [equation_numbers(page) for page in PAGES[letter]]
    numbers = sorted(number for of_page in of_pages for number in of_page)
    assert numbers
    assert numbers == list(range(1, len(numbers) + 1))
    assert of_pages == [sorted(of_page) for of_page in of_pages]


@pytest.mark.parametrize("letter", PAGES)
def test_every_equation_is_cited_where_it_is_computed(letter: str) -> None:
    numbers = {number for page in PAGES[letter] for number in equation_numbers(page)}
    assert numbers == {number for _, cited, number in citations() if cited == letter}


def test_a_citation_names_the_page_of_its_equation() -> None:
    cited = list(citations())
    assert cited
    page_of = {(k, n): page for k, pages in PAGES.items() for page in pages for n in equation_numbers(page)}
    assert [(pages, k, n) for pages, k, n in cited if page_of[k, n] not in pages.split()] == []


def test_other_pages_number_no_equation() -> None:
    """Each equation has one number, to which pages of evidence refer."""
    pages = {page.relative_to(ROOT / "docs").as_posix() for page in (ROOT / "docs").rglob("*.md")}
    numbered = {page for page in pages if TAG.search((ROOT / "docs" / page).read_text(encoding="utf-8"))}
    assert numbered == {f"{page}.md" for pages in PAGES.values() for page in pages}
