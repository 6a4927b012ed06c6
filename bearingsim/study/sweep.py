"""The section `sweep:` of a study file: lists, linspace, range, logspace, their product, `zip`, and `repeat`."""

import math
import re
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import product

from bearingsim.config.fields import described
from bearingsim.designs import KINDS
from bearingsim.study.paths import unspelled
from bearingsim.study.words import WORDS, named_by
from bearingsim.text.units import UnitError, common_dimension, display, parse, split, suggestion
from bearingsim.text.yamlfile import Node, Problem, plain, problem

MAX_VALUES = 100_000
"""Limit of the values that a range or `repeat` makes; lists are limited by their file."""
Interpolation = Callable[[float, float, float], float]
"""Function (a, b, t) of a value between a and b at the fraction t."""


@dataclass(frozen=True)
class Axis:
    """Paths swept together, and the rows of their values."""

    paths: tuple[str, ...]
    rows: tuple[tuple[Node, ...], ...]
    keys: tuple[Node, ...]  # the entries in the file, for messages

    @property
    def zipped(self) -> bool:
        """True for an axis of several paths."""
        return len(self.paths) > 1


def parse_sweep(sweep: Node, problems: list[Problem]) -> list[Axis]:
    """Parse the axes of a sweep section, in the order written."""
    if not isinstance(sweep.value, dict):
        problems.append(problem(sweep.mark, "sweep: expected a mapping such as `{load: [150 N, 300 N]}`"))
    axes = []
    for key, node in ((key, node) for key, node in sweep.mapping.items() if key not in WORDS):
        for block in _blocks(key, node, problems):
            axes.append(_axis(block, problems))
    return [axis for axis in axes if axis is not None]


def written_paths(sweep: Node) -> set[str]:
    """Return the paths named by a sweep section, valid or not."""
    entries = {key: node for key, node in sweep.mapping.items() if key not in WORDS}
    blocks = [block for key, node in entries.items() for block in _blocks(key, node, [])]
    return {path for block in blocks for path in block} | named_by(sweep.mapping)


def rows_of(axes: list[Axis]) -> Iterator[list[tuple[str, Node]]]:
    """Yield every combination of the axes' rows, the last axis fastest, as pairs of path and value."""
    for rows in product(*(axis.rows for axis in axes)):
        yield [pair for axis, row in zip(axes, rows, strict=True) for pair in zip(axis.paths, row, strict=True)]


def dropped(axes: list[Axis], paths: Collection[str]) -> list[Axis]:
    """Remove some paths from the axes."""
    return [kept for axis in axes for kept in _remove_paths(axis, paths)]


def single_axis(path: str, entry: Node, problems: list[Problem]) -> Axis | None:
    """Parse the axis of one path."""
    return _axis({path: entry}, problems)


def is_sweep(node: Node) -> bool:
    """Return True for a value that stands for several: a list, or a generator such as `{linspace: ...}`."""
    return isinstance(node.value, tuple) or bool(node.mapping.keys() & GENERATORS.keys())


def replaced(axes: list[Axis], new: Axis) -> list[Axis]:
    """Replace the axes of the new one's paths by the new axis, which is appended if there are none."""
    axes_left: list[Axis] = []
    placed = False
    for axis in axes:
        clashes = not set(map(unspelled, axis.paths)).isdisjoint(map(unspelled, new.paths))
        if clashes and not placed:
            axes_left.append(new)
            placed = True
        axes_left += _remove_paths(axis, new.paths) if clashes else [axis]
    return axes_left if placed else [*axes_left, new]


def _remove_paths(axis: Axis, paths: Collection[str]) -> list[Axis]:
    """Remove some paths, however spelled, from an axis; return no axis if no path is left."""
    gone = set(map(unspelled, paths))
    kept = [i for i, path in enumerate(axis.paths) if unspelled(path) not in gone]
    if not kept:
        return []
    rows = tuple(tuple(row[i] for i in kept) for row in axis.rows)
    return [Axis(tuple(axis.paths[i] for i in kept), rows, tuple(axis.keys[i] for i in kept))]


def _blocks(key: str, node: Node, problems: list[Problem]) -> list[dict[str, Node]]:
    if key != "zip":
        return [{key: node}]
    blocks = node.items if isinstance(node.value, tuple) else (node,)
    if not all(block.mapping for block in blocks):
        problems.append(problem(node.mark, "zip: expected a mapping of paths to lists of equal length"))
    return [block.mapping for block in blocks if block.mapping]


def _axis(entries: dict[str, Node], problems: list[Problem]) -> Axis | None:
    columns = [_values(path, node, problems) for path, node in entries.items()]
    lengths = [len(column) for column in columns]
    if not all(lengths):
        return None
    if len(set(lengths)) > 1:
        counts = ", ".join(f"`{path}` has {n}" for path, n in zip(entries, lengths, strict=True))
        entry = next(iter(entries.values()))
        problems.append(problem(entry.key or entry.mark, f"zip: lists of unequal length ({counts})"))
        return None
    return Axis(tuple(entries), tuple(zip(*columns, strict=True)), tuple(entries.values()))


def _values(path: str, node: Node, problems: list[Problem]) -> tuple[Node, ...]:
    """Read the values of one entry; none for an invalid entry, with the problem added."""
    if "over" in node.mapping:
        near = suggestion(path, KINDS) or f"known: {', '.join(KINDS)}"
        problems.append(problem(node.key or node.mark, f"sweep: there is no design `{path}`", near))
        return ()
    try:
        return _listed(node) if isinstance(node.value, tuple) else _generated(node)
    except Wrong as wrong:
        problems.append(problem(wrong.node.mark, f"sweep.{path}: {wrong}", wrong.hint))
        return ()


class Wrong(Exception):
    """An entry of a sweep is invalid; ``node``: its position, ``hint``: the remedy."""

    def __init__(self, node: Node, message: str, hint: str | None = None) -> None:
        self.node, self.hint = node, hint
        super().__init__(message)


def _listed(node: Node) -> tuple[Node, ...]:
    if not node.items:
        raise Wrong(node, "the list is empty")
    return node.items


def _generated(node: Node) -> tuple[Node, ...]:
    words = list(node.mapping)
    if len(words) != 1 or words[0] not in GENERATORS:
        hint = f"write `[{node.text}]`" if isinstance(node.value, str) else None
        near = suggestion(words[0], list(GENERATORS)) if words else ""
        expected = "expected a list, or `linspace`, `logspace` or `range` with three numbers"
        raise Wrong(node, expected, near or hint)
    arguments = node.mapping[words[0]]
    if len(arguments.items) != 3:
        raise Wrong(arguments, f"expected three values, as in `{words[0]}: {_EXAMPLES[words[0]]}`")
    return GENERATORS[words[0]](*arguments.items)


def number_in(node: Node, unit: str | None) -> tuple[float, str]:
    """Return the number of a quantity, in ``unit`` unless that is None, and its unit as written. Raises Wrong."""
    if not isinstance(node.value, str):
        raise Wrong(node, "expected a number with its unit")
    try:
        number, word = split(node.value)
        return (float(number), word) if unit in (None, word) else (_converted(node.value, word, str(unit)), word)
    except UnitError as error:
        raise Wrong(node, f"expected {error.expected}, got `{node.value}`", error.hint) from None


def _converted(text: str, word: str, unit: str) -> float:
    dimension = common_dimension(word, unit)
    if dimension is None:
        raise UnitError(text, f"the unit `{unit}` as in the first value")
    return display(parse(text, dimension), unit, dimension)


def _count(node: Node) -> int:
    written = isinstance(node.value, str) and re.fullmatch(r"\d{1,9}", node.value, re.ASCII)
    if not written or not 2 <= int(node.text) <= MAX_VALUES:
        raise Wrong(node, f"expected the number of values, from 2 to {MAX_VALUES}, got `{node.text}`")
    return int(node.text)


def _interpolated(
    start: Node, stop: Node, count: Node, interpolate: Callable[[float, float, float], float]
) -> tuple[Node, ...]:
    """Return ``count`` values from start to stop, both included."""
    a, unit = number_in(start, None)
    b, _ = number_in(stop, unit)
    n = _count(count)
    if interpolate is _geometric and not (a > 0.0 and b > 0.0):
        raise Wrong(stop if a > 0.0 else start, "logspace needs values above zero")
    middle = [written(interpolate(a, b, i / (n - 1)), unit, start) for i in range(1, n - 1)]
    return (start, *middle, stop)


def _linear(a: float, b: float, t: float) -> float:
    return a + (b - a) * t


def _geometric(a: float, b: float, t: float) -> float:
    return float(a * (b / a) ** t)


def repeated(node: Node, problems: list[Problem]) -> list[Axis]:
    """Return the axis of `repeat: N`, the seeds 1 to N; none for an invalid value, with the problem added."""
    whole = isinstance(node.value, str) and re.fullmatch(r"\d{1,6}", node.value, re.ASCII)
    if not whole or not 1 <= int(node.text) <= MAX_VALUES:
        message = f"sweep.repeat: expected a whole number from 1 to {MAX_VALUES}, got {described(plain(node))}"
        problems.append(problem(node.mark, message))
        return []
    seeds = tuple((Node(str(seed), node.mark, node.key),) for seed in range(1, int(node.text) + 1))
    return [Axis(("seed",), seeds, (node,))]


def _range(start: Node, stop: Node, step: Node) -> tuple[Node, ...]:
    a, unit = number_in(start, None)
    b, _ = number_in(stop, unit)
    h, _ = number_in(step, unit)
    steps = (b - a) / h if h else math.nan
    if not steps >= 0.0:
        raise Wrong(step, f"a step of `{step.text}` does not lead from `{start.text}` to `{stop.text}`")
    if steps >= MAX_VALUES:
        raise Wrong(step, f"a step of `{step.text}` makes more than {MAX_VALUES} values: use a larger one")
    count = math.floor(steps + 1e-9)
    return (start, *(written(a + i * h, unit, start) for i in range(1, count + 1)))


def written(number: float, unit: str, source: Node) -> Node:
    """Return a number as written in a file, at the position of ``source``.

    It has 12 digits, as in the ids of jobs, so that ids agree between machines.
    """
    return Node(f"{number:.12g} {unit}".strip(), source.mark)


GENERATORS: dict[str, Callable[[Node, Node, Node], tuple[Node, ...]]] = {
    "linspace": partial(_interpolated, interpolate=_linear),
    "logspace": partial(_interpolated, interpolate=_geometric),
    "range": _range,
}
_EXAMPLES = {
    "linspace": "[150 N, 300 N, 4]",
    "logspace": "[0.05 um, 50 um, 7]",
    "range": "[0 deg, 60 deg, 10 deg]",
}
