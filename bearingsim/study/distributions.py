"""Ranges of a design: bounds and distribution of the values of a path.

A range is `[a, b]` or `{uniform: [a, b]}`, `{log: [a, b]}` (log-uniform), or
`{normal: [mean, standard deviation], within: [a, b]}` (truncated normal).
"""

import math
from collections.abc import Callable, Sequence
from decimal import Context, Decimal
from typing import TYPE_CHECKING, NamedTuple

from bearingsim.study.paths import dimension
from bearingsim.study.sweep import EntryError, difference_in, number_in, number_node
from bearingsim.text.units import UNITS, UnitError, parse, split, suggestion
from bearingsim.text.yamlfile import Node

if TYPE_CHECKING:
    from numpy.typing import NDArray


class Range(NamedTuple):
    """Distribution between two bounds, as nodes and as numbers in ``unit``; ``quantiles``: quantile function."""

    lower: Node
    upper: Node
    low: float
    high: float
    unit: str
    quantiles: Callable[["NDArray"], Sequence[float]]

    def nodes(self, probabilities: "NDArray") -> tuple[Node, ...]:
        """Return the values at cumulative ``probabilities`` (n,) as nodes; equal values share a node."""
        import numpy as np

        unique, indices = np.unique(probabilities, return_inverse=True)
        nodes = [self._node(number) for number in self.quantiles(unique)]
        return tuple(nodes[index] for index in indices.tolist())

    def _node(self, number: float) -> Node:
        value = number_node(number, self.unit, self.lower)
        rounded = float(split(value.text)[0])
        if rounded < self.low:
            return self.lower
        return self.upper if rounded > self.high else value


def range_of(path: str, node: Node) -> Range:
    """Read the range of a path. Raises EntryError."""
    try:
        return _read(path, node)
    except EntryError as error:
        raise EntryError(error.node, f".over.{path}: {error}", error.hint) from None


def _read(path: str, node: Node) -> Range:
    if dimension(path) is None:
        raise EntryError(
            at_key(node), "only a quantity has a range", f"list values, as in `{path}: [...]` in `sweep`"
        )
    if isinstance(node.value, tuple):
        return _uniform(path, node)
    for kind, reader in DISTRIBUTIONS.items():
        if kind in node.mapping:
            extra_key = next(
                (key for key in node.mapping if key != kind and (kind, key) != ("normal", "within")), None
            )
            if extra_key is not None:
                raise EntryError(at_key(node.mapping[extra_key]), f"unknown key `{extra_key}` next to `{kind}`")
            return reader(path, node)
    keys = list(node.mapping)
    hint = suggestion(keys[0], DISTRIBUTIONS) if keys else ""
    expected = (
        "expected a range such as `[a, b]`, `{log: [a, b]}` or `{normal: [mean, deviation], within: [a, b]}`"
    )
    raise EntryError(node, expected, hint or None)


def at_key(node: Node) -> Node:
    """Return a node whose mark is that of its key, if it has one."""
    return Node(node.value, node.key or node.mark)


def _pair(path: str, node: Node) -> tuple[Node, Node, float, float, str]:
    """Return two values of a path: as nodes, as numbers in the unit of the first, and this unit."""
    if len(node.items) != 2:
        raise EntryError(node, "expected two values, as in `[a, b]`")
    low, high = node.items
    for bound in (low, high):
        _check(path, bound)
    a, unit = number_in(low, None)
    b, _ = number_in(high, unit)
    return low, high, a, b, unit


def si_bounds(path: str, bounds: Range) -> tuple[float, float]:
    """Return the bounds of a range in SI."""
    kind = dimension(path)
    assert kind is not None
    return parse(bounds.lower.text, kind), parse(bounds.upper.text, kind)


def _check(path: str, node: Node) -> None:
    kind = dimension(path)
    assert kind is not None
    if not isinstance(node.value, str):
        raise EntryError(node, "expected a number with its unit")
    try:
        parse(node.value, kind)
    except UnitError as error:
        raise EntryError(node, f"expected {error.expected}, got `{node.value}`", error.hint) from None


def _bounds(path: str, node: Node) -> tuple[Node, Node, float, float, str]:
    lower, upper, low, high, unit = _pair(path, node)
    if not low < high:
        raise EntryError(upper, f"expected a value above `{lower.text}`, got `{upper.text}`")
    if not math.isfinite(high - low):
        raise EntryError(node, "the range is larger than any number")
    return lower, upper, low, high, unit


def _uniform(path: str, node: Node) -> Range:
    lower, upper, low, high, unit = _bounds(path, node.mapping.get("uniform", node))
    return Range(
        lower,
        upper,
        low,
        high,
        unit,
        lambda probabilities: [low + (high - low) * t for t in probabilities.tolist()],
    )


def _log(path: str, node: Node) -> Range:
    lower, upper, low, high, unit = _bounds(path, node.mapping["log"])
    if low <= 0.0:
        raise EntryError(lower, "`log` needs values above zero")
    if unit in UNITS["temperature"]:
        raise EntryError(lower, "a temperature has no logarithm", "use `uniform`")
    return Range(
        lower, upper, low, high, unit, lambda probabilities: _geometric(low, high, probabilities.tolist())
    )


_CONTEXT = Context(prec=25)
"""Context for correctly rounded logarithms and exponentials; those of floats depend on the machine."""


def _geometric(low: float, high: float, probabilities: Sequence[float]) -> list[float]:
    a, b = (_CONTEXT.ln(Decimal(bound)) for bound in (low, high))
    ratio = _CONTEXT.subtract(b, a)
    return [float(_CONTEXT.exp(_CONTEXT.fma(ratio, Decimal(t), a))) for t in probabilities]


NORMAL_DIGITS = 9
"""Decimals of a standard normal deviate that are kept, so that designs do not depend on the machine."""


def _normal(path: str, node: Node) -> Range:
    from scipy.stats import truncnorm

    if "within" not in node.mapping:
        raise EntryError(
            at_key(node.mapping["normal"]), "`within` is missing", "a normal distribution needs bounds"
        )
    _, deviation_node, mean, _, unit = _pair(path, node.mapping["normal"])
    deviation = difference_in(deviation_node, unit)
    if deviation <= 0.0:
        raise EntryError(deviation_node, f"expected a standard deviation above zero, got `{deviation_node.text}`")
    lower, upper, low, high, bounds_unit = _bounds(path, node.mapping["within"])
    if bounds_unit != unit:
        low, high = number_in(lower, unit)[0], number_in(upper, unit)[0]
    if deviation > MAX_DEVIATION_RATIO * (high - low):
        message = f"a standard deviation over {MAX_DEVIATION_RATIO} times the range has no effect"
        raise EntryError(deviation_node, message, "use `uniform`")
    a, b = (low - mean) / deviation, (high - mean) / deviation
    if a > MAX_DEVIATIONS or b < -MAX_DEVIATIONS:
        raise EntryError(
            node.mapping["within"], f"these are over {MAX_DEVIATIONS} standard deviations from the mean"
        )

    def quantiles(probabilities: "NDArray") -> Sequence[float]:
        deviates = truncnorm.ppf(probabilities, a, b).tolist()
        return [mean + deviation * round(z, NORMAL_DIGITS) for z in deviates]

    return Range(lower, upper, low, high, unit, quantiles)


MAX_DEVIATIONS = 8
"""Limit of the distance from a mean outside the bounds to the nearer one, in standard deviations; the tail beyond
contains less than 1e-15 of the distribution."""
MAX_DEVIATION_RATIO = 1000
"""Limit of the ratio of standard deviation to range; with larger ones the density is practically uniform."""


DISTRIBUTIONS: dict[str, Callable[[str, Node], Range]] = {"uniform": _uniform, "log": _log, "normal": _normal}
