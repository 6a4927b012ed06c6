"""Ranges of a design: over what a path goes, and how its values are distributed there.

A range is `[a, b]` or `{uniform: [a, b]}`, `{log: [a, b]}` (its logarithm is uniform), or
`{normal: [mean, standard deviation], within: [a, b]}` (cut there).
"""

import math
from collections.abc import Callable, Sequence
from decimal import Context, Decimal
from typing import TYPE_CHECKING, NamedTuple

from bearingsim.study.paths import dimension
from bearingsim.study.sweep import Wrong, number_in, written
from bearingsim.text.units import UNITS, UnitError, parse, split, suggestion
from bearingsim.text.yamlfile import Node

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["DISTRIBUTIONS", "Range", "at_key", "ends", "range_of"]


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


def range_of(path: str, node: Node) -> Range:
    """What a design says of a path. Raises Wrong."""
    try:
        return _read(path, node)
    except Wrong as wrong:
        raise Wrong(wrong.node, f".over.{path}: {wrong}", wrong.hint) from None


def _read(path: str, node: Node) -> Range:
    if dimension(path) is None:
        raise Wrong(at_key(node), "only a quantity has a range", f"list values, as in `{path}: [...]` in `sweep`")
    if isinstance(node.value, tuple):
        return _uniform(path, node)
    for word, make in DISTRIBUTIONS.items():
        if word in node.mapping:
            extra = next((k for k in node.mapping if k != word and (word, k) != ("normal", "within")), None)
            if extra is not None:
                raise Wrong(at_key(node.mapping[extra]), f"unknown key `{extra}` beside `{word}`")
            return make(path, node)
    words = list(node.mapping)
    near = suggestion(words[0], DISTRIBUTIONS) if words else ""
    expected = (
        "expected a range such as `[a, b]`, `{log: [a, b]}` or `{normal: [mean, deviation], within: [a, b]}`"
    )
    raise Wrong(node, expected, near or None)


def at_key(node: Node) -> Node:
    """A node that a message points at by its key."""
    return Node(node.value, node.key or node.mark)


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


def ends(path: str, found: Range) -> tuple[float, float]:
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
    if not math.isfinite(high - low):
        raise Wrong(node, "the range is larger than any number")
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
            at_key(node.mapping["normal"]), "`within` is missing", "a normal distribution is cut at bounds"
        )
    _, spread, mean, _, unit = _pair(path, node.mapping["normal"])
    deviation = _difference(spread, unit)
    if deviation <= 0.0:
        raise Wrong(spread, f"expected a standard deviation above zero, got `{spread.text}`")
    first, last, low, high, own = _bounds(path, node.mapping["within"])
    if own != unit:
        low, high = number_in(first, unit)[0], number_in(last, unit)[0]
    if deviation > MOST_RANGES * (high - low):
        told = f"a standard deviation over {MOST_RANGES} times the range is none that shows"
        raise Wrong(spread, told, "take `uniform`")
    a, b = (low - mean) / deviation, (high - mean) / deviation
    if a > MOST_DEVIATIONS or b < -MOST_DEVIATIONS:
        raise Wrong(node.mapping["within"], f"these are over {MOST_DEVIATIONS} standard deviations from the mean")

    def at(shares: "NDArray") -> Sequence[float]:
        found = truncnorm.ppf(shares, a, b).tolist()
        return [mean + deviation * round(z, NORMAL_DIGITS) for z in found]

    return Range(first, last, low, high, unit, at)


MOST_DEVIATIONS = 8
"""From the mean to the nearer bound: beyond, a normal distribution is none that anybody knows."""


MOST_RANGES = 1000
"""Of which a standard deviation may be: beyond, the density is even within 1 %, and values get lost."""


def _difference(node: Node, unit: str) -> float:
    """A difference of two values, in `unit`: one of 5 K is one of 5 C."""
    word = split(node.text)[1]
    zero = Node(f"0 {word}".strip(), node.mark)
    return number_in(node, unit)[0] - number_in(zero, unit)[0]


DISTRIBUTIONS: dict[str, Callable[[str, Node], Range]] = {"uniform": _uniform, "log": _log, "normal": _normal}
