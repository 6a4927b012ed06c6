"""Values of random formulas, compared with Python."""

import math
import re
from collections.abc import Callable
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from bearingsim.text.algebra import DIMENSIONLESS, MAX_CHARACTERS
from bearingsim.text.expressions import ExpressionError, read
from bearingsim.text.yamlfile import Mark, Node

# Against Python

NUMBERS = st.one_of(
    st.integers(0, 20).map(lambda whole: f"{whole}.0"),
    st.floats(0.0, 10.0).map(lambda number: f"{number:.6f}"),
    st.sampled_from(["a.x", "b", "pi"]),
)
NAMES = {"a.x": 2.5, "b": -3.0}


def larger(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    """Expressions composed of expressions."""
    pairs = st.tuples(inner, st.sampled_from(["+", "-", "*", "/", "**"]), inner)
    calls = st.tuples(st.sampled_from(["min", "max"]), inner, inner)
    return st.one_of(
        pairs.map(lambda p: f"({p[0]}) {p[1]} ({p[2]})"),
        pairs.map("".join),
        calls.map(lambda c: f"{c[0]}({c[1]}, {c[2]})"),
        inner.map(lambda operand: f"-({operand})"),
        inner.map(lambda operand: f"abs({operand})"),
        inner.map(lambda operand: f"sqrt({operand})"),
    )


ARITHMETIC = st.recursive(NUMBERS, larger, max_leaves=8)
COMPARISONS = st.tuples(
    ARITHMETIC, st.sampled_from(["<", "<=", ">", ">=", "==", "!="]), ARITHMETIC, st.sampled_from(["", " < 2.0"])
).map("".join)
CONDITIONS = st.recursive(
    COMPARISONS,
    lambda inner: st.one_of(
        inner.map(lambda text: f"not ({text})"),
        st.tuples(inner, st.sampled_from([" and ", " or "]), inner).map("".join),
    ),
    max_leaves=4,
)


class Finite(float):
    """Float whose arithmetic fails as that of formulas: at infinity and at complex roots.

    Two of them are equal if they differ by at most 1e-11 of the larger one.
    """

    __hash__ = float.__hash__

    def __eq__(self, other: object) -> bool:
        a, b = float(self), float(other)  # type: ignore[arg-type]
        return abs(a - b) <= 1e-11 * max(abs(a), abs(b))

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __lt__(self, other: float) -> bool:
        return self != other and float(self) < float(other)

    def __gt__(self, other: float) -> bool:
        return self != other and float(self) > float(other)

    def __le__(self, other: float) -> bool:
        return not self > other

    def __ge__(self, other: float) -> bool:
        return not self < other

    def __neg__(self) -> "Finite":
        return Finite(-float(self))

    def __abs__(self) -> "Finite":
        return Finite(abs(float(self)))


def checked(operation: str) -> Callable[[Finite, float], Finite]:
    """Operation of floats; ArithmeticError unless the result is finite."""

    def call(a: Finite, b: float) -> Finite:
        result = getattr(float, operation)(float(a), float(b))
        if isinstance(result, complex) or not math.isfinite(result):
            raise ArithmeticError
        return Finite(result)

    return call


for name in ("__add__", "__sub__", "__mul__", "__truediv__", "__pow__"):
    setattr(Finite, name, checked(name))


def by_python(text: str) -> float | bool | None:
    """Value of a formula in Python; None if it is no finite number."""
    floats = re.sub(r"\d+\.\d+", r"F(\g<0>)", text.replace("a.x", "a_x"))
    namespace: dict[str, Any] = {"F": Finite, "a_x": Finite(2.5), "b": Finite(-3.0), "pi": Finite(math.pi)}
    namespace |= {"sqrt": lambda x: Finite(math.sqrt(x))}
    namespace |= {
        "min": lambda a, b: Finite(min(float(a), float(b))),
        "max": lambda a, b: Finite(max(float(a), float(b))),
    }
    namespace["abs"] = abs
    try:
        result: float | bool = eval(floats, {"__builtins__": {}}, namespace)
    except (ArithmeticError, ValueError):
        return None
    return result if isinstance(result, bool) else float(result)


@given(st.one_of(ARITHMETIC, CONDITIONS).filter(lambda text: len(text) <= MAX_CHARACTERS))
def test_values_are_those_of_python(text: str) -> None:
    result = read(Node(text, Mark("f")))
    result.kind(lambda _: DIMENSIONLESS)
    try:
        ours: float | bool | None = result.value(NAMES.__getitem__)
    except ExpressionError:
        ours = None
    theirs = by_python(text)
    assert (ours, type(ours)) == (theirs, type(theirs))
