"""Designs in a sweep: paths over ranges, whose values move together as the points of a cube do.

    sobol: {n: 64, seed: 1, over: {load: [100 N, 200 N], defect.width: {log: [0.2 mm, 2 mm]}}}

A range is `[a, b]` or `{uniform: [a, b]}`, `{log: [a, b]}` (its logarithm is uniform), or
`{normal: [mean, standard deviation], within: [a, b]}` (cut there). A coordinate of the cube is the share of values
below: so each is taken by the inverse of its distribution function. The values have 12 digits and lie within their
ranges.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from decimal import Context, Decimal
from typing import TYPE_CHECKING, NamedTuple

from bearingsim.designs import EXTENDED, Kind, block, cube
from bearingsim.study.paths import dimension
from bearingsim.study.sweep import Axis, Wrong, number_in, written
from bearingsim.study.words import Words
from bearingsim.text.units import UNITS, UnitError, parse, split, suggestion
from bearingsim.text.yamlfile import Node, Problem, problem

if TYPE_CHECKING:
    from numpy.typing import NDArray

MAX_SEED = 999_999_999
VALUES_A_ROW = 10
"""Of the largest design: more paths leave room for fewer rows."""
KEYS = ("n", "seed", "over")
EXAMPLE = "{n: 64, over: {load: [100 N, 200 N]}}"
COUNTED: dict[Kind, str] = {
    "lhs": "points",
    "sobol": "points",
    "saltelli": "base points",
    "morris": "trajectories",
}
IN_BLOCKS: tuple[Kind, ...] = ("saltelli", "morris")
"""Designs whose rows are worth something in whole blocks only."""


@dataclass(frozen=True)
class Design:
    """A design that a study sweeps: ``ids`` of the jobs of all its rows, in order; two rows may be one job.

    kind, n, seed: as ``designs.cube`` takes them; paths: one for each column of it; ranges: their bounds (SI).
    Beside `lhs` and `sobol` a study may sweep more, and drop combinations: then ``ids`` has each combination that
    is left, the design's row slowest.
    """

    kind: Kind
    n: int
    seed: int
    paths: tuple[str, ...]
    ranges: tuple[tuple[float, float], ...]
    ids: tuple[str, ...]

    def __str__(self) -> str:
        count = f"{self.n} {COUNTED[self.kind]}" if self.n > 1 else f"1 {COUNTED[self.kind][:-1]}"
        many = len(self.paths) > 1
        return f"{self.kind}, {count} of {len(self.paths)} path{'s' * many}, seed {self.seed}"


@dataclass(frozen=True)
class Drawn:
    """A design that has been drawn; ``cases``: of each row the number of its case, once these have been made."""

    kind: Kind
    n: int
    seed: int
    paths: tuple[str, ...]
    ranges: tuple[tuple[float, float], ...]
    cases: tuple[int, ...] = ()

    def notes(self) -> Iterator[str]:
        """What is to be known of it before one thinks of a larger one."""
        if self.kind not in EXTENDED:
            yield f"{self.kind}: another `n` gives other points, and all jobs anew; `sobol` keeps its points"
        if self.kind in ("sobol", "saltelli") and self.n & (self.n - 1):
            yield f"{self.kind}: points fill the space evenly where `n` is a power of two, and {self.n} is none"


def drawn(kind: Kind, entry: Node, most: int, problems: list[Problem]) -> tuple[Drawn, Axis] | None:
    """What a study asks for as ``kind``, and its axis; None if it is wrong, which is noted.

    entry: with right paths in `over`; most: rows that a study may have.
    """
    try:
        return _drawn(kind, entry, most)
    except Wrong as wrong:
        problems.append(problem(wrong.node.mark, f"sweep.{kind}{wrong}", wrong.hint))
        return None


def _drawn(kind: Kind, entry: Node, most: int) -> tuple[Drawn, Axis]:
    if not isinstance(entry.value, dict):
        raise Wrong(entry, f": expected a mapping such as `{EXAMPLE}`")
    for key, node in entry.mapping.items():
        if key not in KEYS:
            near = suggestion(key, KEYS) or f"known: {', '.join(KEYS)}"
            raise Wrong(_at_key(node), f": unknown key `{key}`", near)
    missing = next((key for key in ("n", "over") if key not in entry.mapping), None)
    if missing:
        raise Wrong(_at_key(entry), f": `{missing}` is missing", f"as in `{kind}: {EXAMPLE}`")
    over = entry.mapping["over"]
    if not over.mapping:
        raise Wrong(over, ".over: expected paths with their ranges, as in `{load: [100 N, 200 N]}`")
    n, seed = _count(kind, entry, most), _seed(entry)
    ranges = [_range(path, node) for path, node in over.mapping.items()]
    columns = [each.nodes(column) for each, column in zip(ranges, cube(kind, n, len(ranges), seed).T, strict=True)]
    paths = tuple(over.mapping)
    axis = Axis(paths, tuple(zip(*columns, strict=True)), tuple(over.mapping.values()))
    return Drawn(kind, n, seed, paths, tuple(map(_ends, paths, ranges))), axis


def _count(kind: Kind, entry: Node, most: int) -> int:
    node = entry.mapping["n"]
    if (
        not isinstance(node.value, str)
        or not re.fullmatch(r"\d{1,99}", node.value, re.ASCII)
        or int(node.text) < 1
    ):
        raise Wrong(
            node, f".n: expected the number of {COUNTED[kind]}, a whole number above zero, got `{node.text}`"
        )
    n, d = int(node.text), len(entry.mapping["over"].mapping)
    rows = n * block(kind, d)
    if rows > most:
        every = f"{node.text} {COUNTED[kind]} of {d} path{'s' * (d > 1)} are {rows} cases"
        raise Wrong(node, f".n: {every}; at most {most} are possible")
    if rows * d > VALUES_A_ROW * most:
        message = (
            f".n: {rows} cases of {d} paths are {rows * d} values; at most {VALUES_A_ROW * most} are possible"
        )
        raise Wrong(node, message)
    return n


def _seed(entry: Node) -> int:
    node = entry.mapping.get("seed")
    if node is None:
        return 0
    if not isinstance(node.value, str) or not re.fullmatch(r"\d{1,9}", node.value, re.ASCII):
        raise Wrong(node, f".seed: expected a whole number from 0 to {MAX_SEED}, got `{node.text}`")
    return int(node.text)


def _at_key(node: Node) -> Node:
    """A node that a message points at by its key."""
    return Node(node.value, node.key or node.mark)


def beside(kind: Kind, axes: Sequence[Axis], words: Words) -> Iterator[Problem]:
    """What a study sweeps or says beside a design, and would break its blocks."""
    why = f"beside `{kind}`, whose rows are compared in whole blocks"
    for axis in (axis for axis in axes if len(axis.rows) > 1):
        mark = axis.keys[0].key or axis.keys[0].mark
        yield problem(mark, f"`{axis.paths[0]}` is swept {why}", "give it one value, or a range in `over`")
    for word, advice in NOT_IN_BLOCKS.items():
        if word in words:
            yield problem(words[word].key or words[word].mark, f"`{word}` {why}", advice)


NOT_IN_BLOCKS = {
    "where": "leave it out: ranges and `derived` can keep parameters apart",
    "repeat": "leave it out, or take `sobol`",
}


# Ranges


class Range(NamedTuple):
    """Values between two bounds (numbers of ``unit``): ``at`` gives those of shares in [0, 1)."""

    first: Node
    last: Node
    low: float
    high: float
    unit: str
    at: Callable[["NDArray"], Sequence[float]]

    def nodes(self, shares: "NDArray") -> tuple[Node, ...]:
        """The values as they would stand in the file; equal ones are one object, for designs repeat them."""
        import numpy as np

        different, places = np.unique(shares, return_inverse=True)
        made = [self._node(number) for number in self.at(different)]
        return tuple(made[place] for place in places.tolist())

    def _node(self, number: float) -> Node:
        found = written(number, self.unit, self.first)
        rounded = float(split(found.text)[0])
        if rounded < self.low:
            return self.first
        return self.last if rounded > self.high else found


def _range(path: str, node: Node) -> Range:
    try:
        return _range_of(path, node)
    except Wrong as wrong:
        raise Wrong(wrong.node, f".over.{path}: {wrong}", wrong.hint) from None


def _range_of(path: str, node: Node) -> Range:
    if dimension(path) is None:
        raise Wrong(_at_key(node), "only a quantity has a range", f"list values, as in `{path}: [...]` in `sweep`")
    if isinstance(node.value, tuple):
        return _uniform(path, node)
    for word, make in DISTRIBUTIONS.items():
        if word in node.mapping:
            extra = next((k for k in node.mapping if k != word and (word, k) != ("normal", "within")), None)
            if extra is not None:
                raise Wrong(_at_key(node.mapping[extra]), f"unknown key `{extra}` beside `{word}`")
            return make(path, node)
    words = list(node.mapping)
    near = suggestion(words[0], DISTRIBUTIONS) if words else ""
    expected = (
        "expected a range such as `[a, b]`, `{log: [a, b]}` or `{normal: [mean, deviation], within: [a, b]}`"
    )
    raise Wrong(node, expected, near or None)


def _pair(path: str, node: Node) -> tuple[Node, Node, float, float, str]:
    """Two values of a path, as numbers of the first one's unit, and that."""
    if len(node.items) != 2:
        raise Wrong(node, "expected two values, as in `[a, b]`")
    first, second = node.items
    for one in (first, second):
        _check(path, one)
    a, unit = number_in(first, None)
    b, _ = number_in(second, unit)
    return first, second, a, b, unit


def _ends(path: str, found: Range) -> tuple[float, float]:
    """The bounds of a range in SI."""
    known = dimension(path)
    assert known is not None
    return parse(found.first.text, known), parse(found.last.text, known)


def _check(path: str, node: Node) -> None:
    known = dimension(path)
    assert known is not None
    if not isinstance(node.value, str):
        raise Wrong(node, "expected a number with its unit")
    try:
        parse(node.value, known)
    except UnitError as error:
        raise Wrong(node, f"expected {error.expected}, got `{node.value}`", error.hint) from None


def _bounds(path: str, node: Node) -> tuple[Node, Node, float, float, str]:
    first, last, low, high, unit = _pair(path, node)
    if not low < high:
        raise Wrong(last, f"expected a value above `{first.text}`, got `{last.text}`")
    return first, last, low, high, unit


def _uniform(path: str, node: Node) -> Range:
    first, last, low, high, unit = _bounds(path, node.mapping.get("uniform", node))
    return Range(first, last, low, high, unit, lambda shares: [low + (high - low) * t for t in shares.tolist()])


def _log(path: str, node: Node) -> Range:
    first, last, low, high, unit = _bounds(path, node.mapping["log"])
    if low <= 0.0:
        raise Wrong(first, "`log` needs values above zero")
    if unit in UNITS["temperature"]:
        raise Wrong(first, "a temperature has no logarithm", "take `uniform`")
    return Range(first, last, low, high, unit, lambda shares: _geometric(low, high, shares.tolist()))


_DIGITS = Context(prec=25)
"""Logarithm and power in decimals, which are rounded rightly: those of floats differ between machines."""


def _geometric(low: float, high: float, shares: Sequence[float]) -> list[float]:
    a, b = (_DIGITS.ln(Decimal(bound)) for bound in (low, high))
    ratio = _DIGITS.subtract(b, a)
    return [float(_DIGITS.exp(_DIGITS.fma(ratio, Decimal(t), a))) for t in shares]


NORMAL_DIGITS = 9
"""Of a normal deviate: what the machines' own functions agree on."""


def _normal(path: str, node: Node) -> Range:
    from scipy.stats import truncnorm

    if "within" not in node.mapping:
        raise Wrong(
            _at_key(node.mapping["normal"]), "`within` is missing", "a normal distribution is cut at bounds"
        )
    _, spread, mean, _, unit = _pair(path, node.mapping["normal"])
    deviation = _difference(spread, unit)
    if deviation <= 0.0:
        raise Wrong(spread, f"expected a standard deviation above zero, got `{spread.text}`")
    first, last, low, high, own = _bounds(path, node.mapping["within"])
    if own != unit:
        low, high = number_in(first, unit)[0], number_in(last, unit)[0]
    a, b = (low - mean) / deviation, (high - mean) / deviation
    if a > MOST_DEVIATIONS or b < -MOST_DEVIATIONS:
        raise Wrong(node.mapping["within"], f"these are over {MOST_DEVIATIONS} standard deviations from the mean")

    def at(shares: "NDArray") -> Sequence[float]:
        found = truncnorm.ppf(shares, a, b).tolist()
        return [mean + deviation * round(z, NORMAL_DIGITS) for z in found]

    return Range(first, last, low, high, unit, at)


MOST_DEVIATIONS = 8
"""From the mean to the nearer bound: beyond, a normal distribution is none that anybody knows."""


def _difference(node: Node, unit: str) -> float:
    """A difference of two values, in `unit`: one of 5 K is one of 5 C."""
    word = split(node.text)[1]
    zero = Node(f"0 {word}".strip(), node.mark)
    return number_in(node, unit)[0] - number_in(zero, unit)[0]


DISTRIBUTIONS: dict[str, Callable[[str, Node], Range]] = {"uniform": _uniform, "log": _log, "normal": _normal}
