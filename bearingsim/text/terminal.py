"""Text on its way to a terminal, and names that may stand there: no control characters.

Escape sequences move the cursor, set titles and type in the user's name; marks of direction (bidi) show a text
in another order than it has. A results folder of somebody else may hold both.
"""

import sys

LONGEST_LINE = 1000  # letters of a text on one line


def plain(text: str) -> str:
    """Return a text without control characters, marks of direction and surrogates; lines and tabs stay."""
    return "\n".join(line if line.isprintable() else _printable(line) for line in text.split("\n"))


def _printable(line: str) -> str:
    return "".join(letter for letter in line if letter.isprintable() or letter == "\t")


def is_line(text: str) -> bool:
    """Check if a text is a single line without control characters."""
    return 0 < len(text) <= LONGEST_LINE and text.isprintable()


def say(text: str, err: bool = False) -> None:
    """Print a text to stdout, or to stderr, as ``plain`` leaves it."""
    print(plain(text), file=sys.stderr if err else sys.stdout, flush=True)
