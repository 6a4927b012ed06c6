"""Words of the documentation by heading and page: a report, no test.

Reading pages are those that a user reads: Start, How-to, Explanation, and Reference as far as written by hand.
Words of tables and of code are counted apart. A formula in a line counts as a word, a displayed equation as none.
"""

import re
from collections.abc import Iterable
from typing import NamedTuple

from docs.scripts.markdown import NOTE
from docs.scripts.navigation import DOCS, navigation

READING = ("Start", "How-to", "Explanation", "Reference")
CODE = re.compile(r"^(```+).*?^\1$|^    [^\n]*$", re.MULTILINE | re.DOTALL)
DISPLAYED = re.compile(r"^\$\$.*?^\$\$", re.MULTILINE | re.DOTALL)
INLINE = re.compile(r"\$[^$\n]+\$")
TABLE = re.compile(r"^\|.*$", re.MULTILINE)
WORD = re.compile(r"\w[\w'.@^/-]*")
MAX_WORDS = {"How-to": 400, "Explanation": 1200}
"""Words of a page from which it is marked."""


class Count(NamedTuple):
    """Words of a page, or of several."""

    text: int
    tables: int
    code: int


def count(page: str) -> Count:
    """Count the words of a page of docs/."""
    text = INLINE.sub("x", DISPLAYED.sub("", (DOCS / page).read_text(encoding="utf-8")))
    without_code = re.sub(CODE, "", text)
    without_tables = re.sub(TABLE, "", without_code)
    words, less_code, prose = (len(WORD.findall(part)) for part in (text, without_code, without_tables))
    return Count(prose, less_code - prose, words - less_code)


def total(counts: Iterable[Count]) -> Count:
    """Add counts."""
    return Count(*map(sum, zip(*counts, strict=True)))


def is_generated(page: str) -> bool:
    """Check if a page is written by a script."""
    return NOTE in (DOCS / page).read_text(encoding="utf-8")


def main() -> None:
    """Print the words of each page and heading, and those of all reading pages."""
    reading: list[Count] = []
    others: list[Count] = []
    print(f"{'':44}{'text':>8}{'tables':>8}{'code':>8}")
    for heading, pages in navigation().items():
        counts = {page: count(page) for page in pages}
        _print(heading, total(counts.values()))
        for page, words in sorted(counts.items(), key=lambda item: -sum(item[1])):
            is_read = heading in READING and not is_generated(page)
            (reading if is_read else others).append(words)
            most = MAX_WORDS.get(heading)
            remark = f"  over {most}" if most and sum(words) > most else ""
            _print(f"  {page}", words, "  generated" if is_generated(page) else remark)
    for title, parts in (("reading pages", reading), ("all others", others)):
        words = total(parts)
        _print(title, words, f"  together {sum(words)}")


def _print(title: str, words: Count, remark: str = "") -> None:
    print(f"{title:44}{words.text:8}{words.tables:8}{words.code:8}{remark}")


if __name__ == "__main__":
    main()
