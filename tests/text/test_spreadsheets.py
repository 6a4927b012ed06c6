"""CSV without text that a spreadsheet would read as a formula, with unchanged numbers and words."""

import io

import numpy as np
import pandas as pd
import pytest

from bearingsim.text.spreadsheets import csv_text

ATTACKS = [
    "=1+1",
    '=HYPERLINK("http://x","y")',
    "+1+cmd|' /C calc'!A0",
    "-2+3",
    "@SUM(A1)",
    "\t=1",
    "\r=1",
    "\n=1",
    "\x1b=1",
]


@pytest.mark.parametrize("text", ATTACKS)
def test_a_text_that_begins_as_a_formula_is_quoted(text: str) -> None:
    [[head], [cell]] = pd.read_csv(io.StringIO(csv_text(pd.DataFrame({text: [text]}))), header=None).to_numpy()
    assert head == cell
    assert cell[0] == "'"
    assert cell[1:] in (text, text.strip("\r\x1b"))


def test_control_characters_are_left_out() -> None:
    assert csv_text(pd.DataFrame({"reason": ["\x1b[31m=1"]})) == "reason\n[31m=1\n"


def test_numbers_and_words_survive_a_round_trip() -> None:
    words = ["", "rollers", "0.8 mm", "a, b", 'say "a"', "two\nlines", "-1.5", "+2", "-1e-9", "'=1"]
    numbers = [-1.5, 0.1 + 0.2, np.nan, -np.inf, 1e-300, 5e22, -0.0, 1.0, 2.0, 3.0]
    mixed = [1.5, "none", *[None] * 8]
    table = pd.DataFrame({"word": words, "number": numbers, "mixed": mixed, "velocity@BPFO": range(10)})
    assert csv_text(table) == table.to_csv(index=False)
    again = pd.read_csv(
        io.StringIO(csv_text(table)), dtype={"word": str}, keep_default_na=False, na_values={"number": ""}
    )
    assert list(again["word"]) == words
    assert list(again["velocity@BPFO"]) == list(range(10))
