"""Cache of operator signatures for each combination of types, which saves a quarter of the compilation time.

numba resolves ``a + b`` by trying the templates of ``+`` (strings, lists, ufuncs ...) one after another, for each
line of code. An operator that numba lowers itself always has the same signature for the same types, so this
signature is cached. An implementation that is compiled depends on the flags of its caller, so it is resolved each
time. The generated code is bit-for-bit identical.

This relies on internals of numba's type system. If one is missing, nothing is cached.
"""

from typing import Any

try:
    from numba.core.types.functions import BaseFunction

    resolve: Any = BaseFunction.get_call_type
    HAS_INTERNALS = True
except (ImportError, AttributeError):  # another version of numba
    HAS_INTERNALS = False


def cache_operator_signatures() -> None:
    """Cache the signatures of operators that numba lowers itself."""
    if HAS_INTERNALS:
        BaseFunction.get_call_type = cache_signatures(resolve)  # type: ignore[method-assign]


def cache_signatures(resolve: Any) -> Any:
    """Cache ``resolve`` (function, context, arguments, keywords) for each combination of types."""
    signatures: dict[tuple, tuple[Any, Any]] = {}

    def get_call_type(function: Any, context: Any, arguments: Any, keywords: Any) -> Any:
        key = (function.typing_key, context, tuple(arguments), tuple(keywords.items()))
        cached_function, signature = signatures.get(key, (None, None))
        if cached_function is function:  # numba makes a new function type when templates are added
            return signature
        signature = resolve(function, context, arguments, keywords)
        if is_lowered_by_numba(function, signature):
            signatures[key] = function, signature
        return signature

    return get_call_type


def is_lowered_by_numba(function: Any, signature: Any) -> bool:
    """Check if a signature belongs to an operator lowered by numba, not to an implementation compiled for it."""
    return getattr(function, "_impl_keys", {}).get(signature.args) is function.typing_key
