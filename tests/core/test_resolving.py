"""Signatures of operators are cached for each combination of types, those of implementations are not."""

import operator
from typing import Any, NamedTuple

import pytest
from numba import float64, int64, typeof
from numba.core.registry import cpu_target

from bearingsim.core.jit import generic
from bearingsim.core.resolving import HAS_INTERNALS, cache_signatures, resolve

CONTEXT = cpu_target.typing_context


class Halved(NamedTuple):
    """Parameter type of this test."""


@generic
def halved(parameters: Any, x: float) -> float:
    """Halve a number."""


@halved.register(Halved)
def _halved(parameters, x):
    return 0.5 * x


def type_of(function: Any) -> Any:
    """Return a function's type, with all its templates."""
    CONTEXT.refresh()
    return CONTEXT.resolve_value_type(function)


class CountingResolve:
    """``resolve`` with a counter of calls."""

    def __init__(self) -> None:
        self.calls = 0
        self.resolve = cache_signatures(self)

    def __call__(self, *call: Any) -> Any:
        self.calls += 1
        return resolve(*call)

    def signatures(self, function: Any, *arguments: Any) -> list[Any]:
        """Return the signatures of two successive calls."""
        return [self.resolve(function, CONTEXT, arguments, {}) for _ in range(2)]


def test_locked_numba_has_the_required_internals() -> None:
    """With another numba nothing is cached; ``resolving.py`` must then be adapted."""
    assert HAS_INTERNALS


@pytest.mark.parametrize("types", [(float64, float64), (int64, float64), (float64, int64)])
@pytest.mark.parametrize("function", [operator.mul, operator.truediv, operator.lt])
def test_an_operator_is_resolved_once(function: Any, types: tuple[Any, Any]) -> None:
    counter, kind = CountingResolve(), type_of(function)
    assert counter.signatures(kind, *types) == [resolve(kind, CONTEXT, types, {})] * 2
    assert counter.calls == 1


def test_other_types_have_another_signature() -> None:
    counter, kind = CountingResolve(), type_of(operator.add)
    int_signatures, float_signatures = (
        counter.signatures(kind, int64, int64),
        counter.signatures(kind, float64, float64),
    )
    assert [int_signatures[1].return_type, float_signatures[1].return_type] == [int64, float64]


def test_an_implementation_is_resolved_each_time() -> None:
    """The flags of its caller may differ."""
    counter = CountingResolve()
    assert counter.signatures(type_of(halved), typeof(Halved()), float64)[1].return_type == float64
    assert counter.calls == 2


def test_a_function_that_has_gained_templates_is_resolved_anew() -> None:
    counter, kind = CountingResolve(), type_of(operator.mul)
    counter.signatures(kind, float64, float64)
    counter.signatures(kind.augment(kind), float64, float64)
    assert counter.calls == 2


def test_types_without_an_operator_are_refused_each_time() -> None:
    counter, kind = CountingResolve(), type_of(operator.mul)
    for _ in range(2):
        with pytest.raises(Exception, match="No implementation of function"):
            counter.signatures(kind, typeof(Halved()), float64)
