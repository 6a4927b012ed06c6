"""Text for a terminal has no control characters, and all output is filtered."""

import re
from pathlib import Path

import pytest

from bearingsim.cli.screen import print_table
from bearingsim.text.terminal import is_line, plain, say

PACKAGE = Path(__file__).parents[2] / "bearingsim"
EXCEPT = {"text/terminal.py", "core/jit.py", "cli/exporting.py"}
"""Where text is printed, a folder of the user's own is named, and CSV goes to stdout."""
ATTACKS = {
    "\x1b[2J\x1b]0;title\x07": "[2J]0;title",
    "\x9b31mred": "31mred",
    "fdc\u202eexe.txt": "fdcexe.txt",
    "a\rb\x08c\x00": "abc",
    "\u2066x\u2069\u200b\ufeff": "x",
    "half \ud800": "half ",
}


@pytest.mark.parametrize("text", ATTACKS)
def test_control_characters_are_left_out(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert plain(text) == ATTACKS[text]
    assert not is_line(text)
    say(f"{text}\n\tmore")
    say(text, err=True)
    print_table([text, "b"], [[text, "1"]])
    printed = capsys.readouterr()
    assert printed.out.startswith(f"{ATTACKS[text]}\n\tmore\n")
    assert printed.err == f"{ATTACKS[text]}\n"
    assert printed.out.replace("\n", "").replace("\t", "").isprintable()


def test_other_text_is_unchanged() -> None:
    text = "µm, °, Kräfte, 軸受, 0.8 mm: `a`\n\tnext line\n"
    assert plain(text) == text
    assert is_line("µm, Kräfte, 軸受")
    assert not is_line("")


def test_no_module_prints_without_the_filter() -> None:
    printing = re.compile(r"(?<![.\w])print\(|typer\.echo\(|std(out|err)\.write\(")
    sources = {path.relative_to(PACKAGE).as_posix(): path for path in PACKAGE.rglob("*.py")}
    modules = {name for name, path in sources.items() if printing.search(path.read_text(encoding="utf-8"))}
    assert modules == EXCEPT
