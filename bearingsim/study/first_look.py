"""Sample of a sweep's combinations that reveals most problems, and is validated before all others."""

from collections.abc import Iterator, Sequence

from bearingsim.study.paths import dimension
from bearingsim.study.relations import Row
from bearingsim.study.sweep import Axis
from bearingsim.text.units import UnitError, parse
from bearingsim.text.yamlfile import Node

MAX_AXIS_VALUES = 50
"""Limit of the sampled rows of an axis: with 100 axes, validation takes one or two seconds."""


def vary_one_axis(axes: Sequence[Axis]) -> Iterator[Row]:
    """Yield combinations that vary one axis at a time over its sampled rows; all others are at their first row.

    The first and the last combination of the sweep are included.
    """
    base = [axis.rows[0] for axis in axes]
    yield _pairs(axes, base)
    for index, axis in enumerate(axes):
        for number in sample_rows(axis):
            yield _pairs(axes, [*base[:index], axis.rows[number], *base[index + 1 :]])
    yield _pairs(axes, [axis.rows[-1] for axis in axes])


def _pairs(axes: Sequence[Axis], rows: Sequence[tuple[Node, ...]]) -> Row:
    return [pair for axis, row in zip(axes, rows, strict=True) for pair in zip(axis.paths, row, strict=True)]


def sample_rows(axis: Axis) -> list[int]:
    """List the indices of an axis' sampled rows, ascending, without 0.

    They are the last row, the rows of the extremes of each path, and the first row with each word or invalid text.
    """
    rows = {len(axis.rows) - 1: None}
    for column, path in enumerate(axis.paths):
        rows |= dict.fromkeys(_extremes_and_words(path, [row[column] for row in axis.rows]))
    return sorted(row for row in [*rows][:MAX_AXIS_VALUES] if row > 0)


def _extremes_and_words(path: str, column: Sequence[Node]) -> list[int]:
    """List the rows of a column with the smallest and the largest number, and the first row with each word."""
    first_with_word: dict[str, int] = {}
    first_with_number: dict[float, int] = {}
    unit_kind = dimension(path)
    for row, node in enumerate(column):
        try:
            if unit_kind:
                first_with_number.setdefault(parse(node.text, unit_kind), row)
                continue
        except UnitError:
            pass  # a word, or invalid text
        first_with_word.setdefault(node.text, row)
    ends = [pick(first_with_number.items())[1] for pick in (min, max) if first_with_number]
    return [*ends, *first_with_word.values()]
