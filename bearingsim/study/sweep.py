"""The `sweep:` section: lists, linspace, range, logspace, their product, `zip`, and `repeat`."""

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


@dataclass(frozen=True)
class Axis:
    """Paths that move together, and the rows of values that they take."""

    paths: tuple[str, ...]
    rows: tuple[tuple[Node, ...], ...]
    keys: tuple[Node, ...]  # the entries in the file, for messages

    @property
    def zipped(self) -> bool:
        """Whether this came from a `zip:` block."""
        return len(self.paths) > 1


def parse_sweep(sweep: Node, problems: list[Problem]) -> list[Axis]:
    """The axes of a sweep section, in the written order."""
    if not isinstance(sweep.value, dict):
        problems.append(problem(sweep.mark, "sweep: expected a mapping such as `{load: [150 N, 300 N]}`"))
    axes = []
    for key, node in ((key, node) for key, node in sweep.mapping.items() if key not in WORDS):
        for block in _blocks(key, node, problems):
            axes.append(_axis(block, problems))
    return [axis for axis in axes if axis is not None]


def written_paths(sweep: Node) -> set[str]:
    """The paths that a sweep section names, right or wrong."""
    entries = {key: node for key, node in sweep.mapping.items() if key not in WORDS}
    blocks = [block for key, node in entries.items() for block in _blocks(key, node, [])]
    return {path for block in blocks for path in block} | named_by(sweep.mapping)


def rows_of(axes: list[Axis]) -> Iterator[list[tuple[str, Node]]]:
    """Every combination of the axes' rows, the last axis fastest, as pairs of path and value."""
    for rows in product(*(axis.rows for axis in axes)):
        yield [pair for axis, row in zip(axes, rows, strict=True) for pair in zip(axis.paths, row, strict=True)]


def dropped(axes: list[Axis], paths: Collection[str]) -> list[Axis]:
    """The axes less some paths."""
    return [kept for axis in axes for kept in _without(axis, paths)]


def single_axis(path: str, entry: Node, problems: list[Problem]) -> Axis | None:
    """The axis of one path."""
    return _axis({path: entry}, problems)


def is_sweep(node: Node) -> bool:
    """Whether a value stands for several: a list, or `{linspace: ...}` and its like."""
    return isinstance(node.value, tuple) or bool(node.mapping.keys() & GENERATORS.keys())


def replaced(axes: list[Axis], new: Axis) -> list[Axis]:
    """The axes with the new one in place of its paths' old values; at the end if they had none."""
    found: list[Axis] = []
    placed = False
    for axis in axes:
        clashes = not set(map(unspelled, axis.paths)).isdisjoint(map(unspelled, new.paths))
        if clashes and not placed:
            found.append(new)
            placed = True
        found += _without(axis, new.paths) if clashes else [axis]
    return found if placed else [*found, new]


def _without(axis: Axis, paths: Collection[str]) -> list[Axis]:
    """The axis less some paths, however they are spelled; nothing if none is left."""
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
        first = next(iter(entries.values()))
        problems.append(problem(first.key or first.mark, f"zip: lists of unequal length ({counts})"))
        return None
    return Axis(tuple(entries), tuple(zip(*columns, strict=True)), tuple(entries.values()))


def _values(path: str, node: Node, problems: list[Problem]) -> tuple[Node, ...]:
    """The values of one entry; none if the entry is wrong, which is noted."""
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
    """An entry of a sweep is wrong: where, and what would mend it."""

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
    """The number of a quantity, in `unit` if one is asked for, and its unit. Raises Wrong."""
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


def _between(first: Node, last: Node, count: Node, at: Callable[[float, float, float], float]) -> tuple[Node, ...]:
    """Values from the first to the last; `at(a, b, t)` lies between them at the fraction t."""
    a, unit = number_in(first, None)
    b, _ = number_in(last, unit)
    n = _count(count)
    if at is _geometric and not (a > 0.0 and b > 0.0):
        raise Wrong(first, "logspace needs values above zero")
    middle = [written(at(a, b, i / (n - 1)), unit, first) for i in range(1, n - 1)]
    return (first, *middle, last)


def _linear(a: float, b: float, t: float) -> float:
    return a + (b - a) * t


def _geometric(a: float, b: float, t: float) -> float:
    return float(a * (b / a) ** t)


def repeated(node: Node, problems: list[Problem]) -> list[Axis]:
    """The axis of `repeat: N`: the seeds 1 to N; none if that is wrong, which is noted."""
    whole = isinstance(node.value, str) and re.fullmatch(r"\d{1,6}", node.value, re.ASCII)
    if not whole or not 1 <= int(node.text) <= MAX_VALUES:
        message = f"sweep.repeat: expected a whole number from 1 to {MAX_VALUES}, got {described(plain(node))}"
        problems.append(problem(node.mark, message))
        return []
    seeds = tuple((Node(str(seed), node.mark, node.key),) for seed in range(1, int(node.text) + 1))
    return [Axis(("seed",), seeds, (node,))]


def _range(first: Node, last: Node, step: Node) -> tuple[Node, ...]:
    a, unit = number_in(first, None)
    b, _ = number_in(last, unit)
    h, _ = number_in(step, unit)
    steps = (b - a) / h if h else math.nan
    if not 0.0 <= steps < MAX_VALUES:
        raise Wrong(step, f"a step of `{step.text}` does not lead from `{first.text}` to `{last.text}`")
    count = math.floor(steps + 1e-9)
    return (first, *(written(a + i * h, unit, first) for i in range(1, count + 1)))


def written(number: float, unit: str, first: Node) -> Node:
    """A number as it would stand in the file: 12 digits, as ids have, so that they are equal everywhere."""
    return Node(f"{number:.12g} {unit}".strip(), first.mark)


GENERATORS: dict[str, Callable[[Node, Node, Node], tuple[Node, ...]]] = {
    "linspace": partial(_between, at=_linear),
    "logspace": partial(_between, at=_geometric),
    "range": _range,
}
_EXAMPLES = {
    "linspace": "[150 N, 300 N, 4]",
    "logspace": "[0.05 um, 50 um, 7]",
    "range": "[0 deg, 60 deg, 10 deg]",
}
