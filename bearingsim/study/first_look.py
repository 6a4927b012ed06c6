"""The few combinations of a sweep that show most of what is wrong with it: they are read before all others."""

from collections.abc import Iterator, Sequence

from bearingsim.study.paths import dimension
from bearingsim.study.relations import Row
from bearingsim.study.sweep import Axis
from bearingsim.text.units import UnitError, parse
from bearingsim.text.yamlfile import Node

MOST_OF_AN_AXIS = 50
"""Rows of an axis that are looked at: of a hundred axes these are as many cases as take a second or two."""


def one_at_a_time(axes: Sequence[Axis]) -> Iterator[Row]:
    """Combinations in which one axis at a time takes its telling rows, all others their first; and the last.

    Those of an axis are its ends, its least and greatest numbers, each of its words, and what is no quantity.
    """
    first, last = [axis.rows[0] for axis in axes], [axis.rows[-1] for axis in axes]
    yield _pairs(axes, first)
    for place, axis in enumerate(axes):
        for number in telling_rows(axis):
            yield _pairs(axes, [*first[:place], axis.rows[number], *first[place + 1 :]])
    yield _pairs(axes, last)


def _pairs(axes: Sequence[Axis], rows: Sequence[tuple[Node, ...]]) -> Row:
    return [pair for axis, row in zip(axes, rows, strict=True) for pair in zip(axis.paths, row, strict=True)]


def telling_rows(axis: Axis) -> list[int]:
    """The numbers of an axis' rows that are looked at, in order; the first row is left out."""
    rows = {len(axis.rows) - 1: None}
    for column, path in enumerate(axis.paths):
        rows |= dict.fromkeys(_extremes_and_words(path, [row[column] for row in axis.rows]))
    return sorted(row for row in [*rows][:MOST_OF_AN_AXIS] if row > 0)


def _extremes_and_words(path: str, column: Sequence[Node]) -> list[int]:
    """The rows of a column with the least and greatest number, and the first with each word."""
    first_with_word: dict[str, int] = {}
    first_with_number: dict[float, int] = {}
    unit_kind = dimension(path)
    for row, node in enumerate(column):
        try:
            if unit_kind:
                first_with_number.setdefault(parse(node.text, unit_kind), row)
                continue
        except UnitError:
            pass  # a word, or a mistake
        first_with_word.setdefault(node.text, row)
    ends = [pick(first_with_number.items())[1] for pick in (min, max) if first_with_number]
    return [*ends, *first_with_word.values()]
