"""Equations of the theory pages: numbered once, cited by the functions that compute them."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGES = {"M": "model", "C": "contact", "P": "planar", "S": "spatial", "R": "ring"}
NUMBER = re.compile(rf"\(([{''.join(PAGES)}])(\d+)\)")


def equation_numbers(letter: str) -> list[int]:
    """Return the numbers at the ends of the equations of a page, in order."""
    lines = (ROOT / "docs" / f"{PAGES[letter]}.md").read_text(encoding="utf-8").splitlines()
    matches = [re.search(rf"   \({letter}(\d+)\)$", line) for line in lines if line.startswith("    ")]
    return [int(match[1]) for match in matches if match]


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
def test_equations_of_a_page_are_numbered_in_order(letter: str) -> None:
    numbers = equation_numbers(letter)
    assert numbers
    assert numbers == list(range(1, len(numbers) + 1))


@pytest.mark.parametrize("letter", PAGES)
def test_every_equation_is_cited_where_it_is_computed(letter: str) -> None:
    assert set(equation_numbers(letter)) == {number for _, cited, number in citations() if cited == letter}


def test_a_citation_names_its_page() -> None:
    cited = list(citations())
    assert cited
    assert [(pages, letter) for pages, letter, _ in cited if PAGES[letter] not in pages.split()] == []
