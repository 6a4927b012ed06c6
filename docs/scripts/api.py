"""Reference page of the Python API, from the source of its functions and classes."""

import ast
import inspect
from collections.abc import Iterator
from typing import Any

import bearingsim as bs
from bearingsim.simulation.record import Record
from bearingsim.store import Results
from bearingsim.store.spectra import Spectrum
from bearingsim.store.units import Series
from bearingsim.study import Study
from docs.scripts.markdown import page, table

FUNCTIONS = (bs.load_study, bs.run, bs.open_results, bs.simulate, bs.spectrum, bs.envelope_spectrum)
CLASSES = (Study, bs.Case, Record, Results, Series, Spectrum)


def api_page() -> str:
    """Return the page of functions and classes of the package."""
    return page(
        "Python API",
        "`import bearingsim as bs` gives the functions below and `bs.Case`, whose fields are the"
        " [keys of a case](keys.md#keys-of-a-case). Arrays and numbers are in SI.",
        "## Functions",
        *(_function(_node(function), f"bs.{function.__name__}") for function in FUNCTIONS),
        *(_class(_node(cls)) for cls in CLASSES),
    )


def _node(target: Any) -> Any:
    """Return the definition of a function or class in the source of its module."""
    tree = ast.parse(inspect.getsource(inspect.getmodule(target)))  # type: ignore[arg-type]
    return next(node for node in tree.body if getattr(node, "name", "") == target.__name__)


def _function(node: ast.FunctionDef, name: str) -> str:
    return f"### `{name}`\n\n```python\n{_signature(node, name)}\n```\n\n{_text(node)}"


def _class(node: ast.ClassDef) -> str:
    members = [member for member in node.body if isinstance(member, ast.FunctionDef) and _is_public(member)]
    properties = [member for member in members if _is_property(member)]
    rows = [(f"`{name}`", text) for name, text in (*_fields(node), *((m.name, _text(m)) for m in properties))]
    parts = [f"## `{node.name}`", _text(node), table(("attribute", "content"), rows) if rows else ""]
    methods = [member for member in members if member not in properties]
    parts += [_function(method, f"{node.name}.{method.name}") for method in methods]
    return "\n\n".join(filter(None, parts))


def _fields(node: ast.ClassDef) -> Iterator[tuple[str, str]]:
    """Yield the fields of a class with their types; those of a case are keys of a study."""
    for member in node.body:
        if isinstance(member, ast.AnnAssign) and not ast.unparse(member.target).startswith("_"):
            yield ast.unparse(member.target), f"`{_unquoted(member.annotation)}`"


def _signature(node: ast.FunctionDef, name: str) -> str:
    arguments = ast.unparse(node.args).removeprefix("self").removeprefix(", ").replace("'", "")
    return f"{name}({arguments})" + (f" -> {_unquoted(node.returns)}" if node.returns else "")


def _unquoted(annotation: ast.expr) -> str:
    """Return a type as text; types known to checkers only are strings."""
    return ast.unparse(annotation).replace("'", "")


def _text(node: ast.FunctionDef | ast.ClassDef) -> str:
    return (ast.get_docstring(node) or "").replace("``", "`")


def _is_public(node: ast.FunctionDef) -> bool:
    return not node.name.startswith("_")


def _is_property(node: ast.FunctionDef) -> bool:
    return any("property" in ast.unparse(decorator) for decorator in node.decorator_list)
