"""An operator's signature is resolved once for each combination of types, an implementation's each time."""

import operator
from typing import Any, NamedTuple

import pytest
from numba import float64, int64, typeof
from numba.core.registry import cpu_target

from bearingsim.core.jit import generic
from bearingsim.core.resolving import HAS_INTERNALS, cache_signatures, resolve

CONTEXT = cpu_target.typing_context


class Halved(NamedTuple):
    """A parameter type of this test's."""


@generic
def halved(parameters: Any, x: float) -> float:
    """Something that has an implementation."""


@halved.register(Halved)
def _halved(parameters, x):
    return 0.5 * x


def type_of(function: Any) -> Any:
    """A function's type, with all its templates."""
    CONTEXT.refresh()
    return CONTEXT.resolve_value_type(function)


class Counted:
    """``resolve``, which counts its calls."""

    def __init__(self) -> None:
        self.calls = 0
        self.resolve = cache_signatures(self)

    def __call__(self, *call: Any) -> Any:
        self.calls += 1
        return resolve(*call)

    def signatures(self, function: Any, *arguments: Any) -> list[Any]:
        """Those of two calls in turn."""
        return [self.resolve(function, CONTEXT, arguments, {}) for _ in range(2)]


def test_the_numba_of_the_lock_file_is_made_as_is_expected_of_it() -> None:
    """With another one nothing is kept; then ``resolving.py`` is to be looked at."""
    assert HAS_INTERNALS


@pytest.mark.parametrize("types", [(float64, float64), (int64, float64), (float64, int64)])
@pytest.mark.parametrize("function", [operator.mul, operator.truediv, operator.lt])
def test_an_operator_is_resolved_once(function: Any, types: tuple[Any, Any]) -> None:
    counted, of = Counted(), type_of(function)
    assert counted.signatures(of, *types) == [resolve(of, CONTEXT, types, {})] * 2
    assert counted.calls == 1


def test_other_types_have_another_signature() -> None:
    counted, of = Counted(), type_of(operator.add)
    whole, real = counted.signatures(of, int64, int64), counted.signatures(of, float64, float64)
    assert [whole[1].return_type, real[1].return_type] == [int64, float64]


def test_an_implementation_is_resolved_each_time() -> None:
    """Its caller's flags may differ."""
    counted = Counted()
    assert counted.signatures(type_of(halved), typeof(Halved()), float64)[1].return_type == float64
    assert counted.calls == 2


def test_a_function_that_has_gained_templates_is_resolved_anew() -> None:
    counted, of = Counted(), type_of(operator.mul)
    counted.signatures(of, float64, float64)
    counted.signatures(of.augment(of), float64, float64)
    assert counted.calls == 2


def test_types_without_an_operator_are_refused_each_time() -> None:
    counted, of = Counted(), type_of(operator.mul)
    for _ in range(2):
        with pytest.raises(Exception, match="No implementation of function"):
            counted.signatures(of, typeof(Halved()), float64)
