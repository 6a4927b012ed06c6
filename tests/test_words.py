"""Words of the interface: study keys, columns of results, commands and their options.

Scripts and study files of users depend on them. ``docs/data/words.csv`` lists them, so that none is added, renamed
or lost without notice; a word that is replaced keeps its old form as an alias.
"""

import csv
from collections.abc import Iterator
from pathlib import Path

import typer

from bearingsim.cli.app import app
from bearingsim.config import names
from bearingsim.config.case_fields import DEPRECATED_KEYS
from bearingsim.study.paths import known_paths

TABLE = Path(__file__).parents[1] / "docs/data/words.csv"


def words() -> Iterator[tuple[str, str, str]]:
    """Yield every word as the program has it: kind, word, and what it is an alias of."""
    yield from (("key", path, "") for path in known_paths())
    yield from (("key", old, new) for old, new in DEPRECATED_KEYS.items())
    yield from (("column", feature, "") for feature in names.FEATURES)
    for command, content in typer.main.get_command(app).commands.items():  # type: ignore[attr-defined]
        yield "command", command, ""
        for parameter in content.params:
            yield from (("option", f"{command} {name}", "") for name in parameter.opts if name.startswith("-"))


def test_table_lists_every_word_of_the_interface() -> None:
    with TABLE.open(newline="", encoding="utf-8") as file:
        listed = {(row["kind"], row["word"], row["alias of"]) for row in csv.DictReader(file)}
    added, lost = sorted(set(words()) - listed), sorted(listed - set(words()))
    assert (added, lost) == ([], []), "change docs/data/words.csv and the changelog, too"


def test_aliases_replace_words_of_the_same_kind() -> None:
    assert set(DEPRECATED_KEYS.values()) <= known_paths().keys()
    assert not DEPRECATED_KEYS.keys() & known_paths().keys()
