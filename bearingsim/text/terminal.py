"""Output to the terminal without control characters.

Escape sequences can move the cursor, set titles and inject input; bidirectional control characters change the
displayed order of a text. Results folders of unknown origin may contain both.
"""

import sys

MAX_LINE = 1000  # characters
LINE_WIDTH = 60  # characters to which a rewritten line is padded, so that it covers the previous text


def plain(text: str) -> str:
    """Remove control characters, bidirectional marks and surrogates from a text; keep line breaks and tabs."""
    return "\n".join(line if line.isprintable() else _printable(line) for line in text.split("\n"))


def _printable(line: str) -> str:
    return "".join(letter for letter in line if letter.isprintable() or letter == "\t")


def is_line(text: str) -> bool:
    """Check if a text is a single line of limited length without control characters."""
    return 0 < len(text) <= MAX_LINE and text.isprintable()


def say(text: str, err: bool = False) -> None:
    """Print a text, filtered by ``plain``, to stdout or stderr."""
    print(plain(text), file=sys.stderr if err else sys.stdout, flush=True)


def rewrite_line(text: str) -> None:
    """Replace the last line on stderr by a text, where a carriage return does this, as in a notebook."""
    print(f"\r{plain(text):{LINE_WIDTH}}", end="", file=sys.stderr, flush=True)
