"""Report on the source by package: sizes of files and functions, import cycles (``make house``). Not a test.

    python -m benchmarks.house              # of this tree
    python -m benchmarks.house ../older     # of another checkout

A line counts as text (docstring, also of a constant, or comment), blank, import, or code. The length of a function
includes signature and docstring. An import cycle is a set of modules that import one another, at the top, in a
function, or under TYPE_CHECKING. The ``__init__`` of the package, which imports lazily, is excluded.
"""

import ast
import sys
from collections import Counter, defaultdict
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import TypeGuard

LONG = 60
"""Lines of a function above which it is reported."""
COLUMNS = ("files", "lines", "code", "text", "blank", "import", "functions", "long")
PACKAGE = "bearingsim"
OTHER_FOLDERS = ("benchmarks", "tests", "docs")


def package_of(path: Path) -> str:
    """Return the package of a source file from its folder; for the core, the subpackage."""
    folders = path.parent.parts
    if folders[0] != PACKAGE:
        return folders[0]
    return "/".join(folders[1 : 3 if folders[1:2] == ("core",) else 2]) or "(top)"


def is_text(node: ast.AST) -> TypeGuard[ast.Expr]:
    """Check if a statement is a string, like a docstring."""
    return (
        isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
    )


def functions(tree: ast.Module) -> Iterator[tuple[str, int]]:
    """Yield each function's name and its number of lines."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node.name, (node.end_lineno or 0) - node.lineno + 1


def count(source: str, tree: ast.Module) -> Counter[str]:
    """Count the lines of a file by kind."""
    kinds = {}
    lines = source.splitlines()
    for number, line in enumerate(lines, 1):
        stripped = line.strip()
        kinds[number] = "blank" if not stripped else "text" if stripped.startswith("#") else "code"
    for node in ast.walk(tree):
        if is_text(node) or isinstance(node, ast.Import | ast.ImportFrom):
            kind = "text" if is_text(node) else "import"
            kinds |= dict.fromkeys(range(node.lineno, (node.end_lineno or 0) + 1), kind)
    lengths = [length for _, length in functions(tree)]
    sizes = {"files": 1, "lines": len(lines), "functions": len(lengths), "long": sum(n > LONG for n in lengths)}
    return Counter(kinds.values()) + Counter(sizes)


def imports_of(tree: ast.Module, modules: Collection[str]) -> set[str]:
    """Return the ``modules`` imported by a module; ``from a import b`` counts as ``a.b`` or, if none, ``a``."""
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            inner = [f"{node.module}.{alias.name}" for alias in node.names]
            names |= {name if name in modules else str(node.module) for name in inner}
    return names & set(modules)


def import_cycles(imports: dict[str, set[str]]) -> list[list[str]]:
    """Return the sets of modules that reach one another (strongly connected components of two or more)."""

    def reachable_from(start: str) -> frozenset[str]:
        visited, frontier = set(), [start]
        while frontier:
            for module in imports[frontier.pop()] - visited:
                visited.add(module)
                frontier.append(module)
        return frozenset(visited)

    reachable = {module: reachable_from(module) for module in imports}
    groups = {frozenset(b for b in reachable[a] if a in reachable[b]) for a in imports if a in reachable[a]}
    return sorted(sorted(group) for group in groups if len(group) > 1)


def report(root: Path) -> Iterator[str]:
    """Yield the lines of the report on a checkout."""
    packages: dict[str, Counter[str]] = defaultdict(Counter)
    trees, long_functions = {}, []
    for path in sorted(path for top in (PACKAGE, *OTHER_FOLDERS) for path in (root / top).rglob("*.py")):
        relative, source = path.relative_to(root), path.read_text(encoding="utf-8")
        tree = ast.parse(source)
        packages[package_of(relative)] += count(source, tree)
        long_functions += [f"{relative}: {name} {length}" for name, length in functions(tree) if length > LONG]
        if relative.parts[0] == PACKAGE and relative != Path(PACKAGE, "__init__.py"):
            trees[".".join(relative.with_suffix("").parts).removesuffix(".__init__")] = tree
    cycles = import_cycles({name: imports_of(tree, trees) for name, tree in trees.items()})
    packages[PACKAGE] = sum((packages[name] for name in packages if name not in OTHER_FOLDERS), Counter())
    yield f"{'package':18}" + "".join(f"{name:>10}" for name in COLUMNS) + f"{'blank+import':>14}"
    for name, sizes in packages.items():
        share = 100.0 * (sizes["blank"] + sizes["import"]) / (sizes["lines"] or 1)
        yield f"{name:18}" + "".join(f"{sizes[column]:>10}" for column in COLUMNS) + f"{share:>12.1f} %"
    yield f"\nfunctions over {LONG} lines: {len(long_functions)}\n" + "".join(
        f"  {line}\n" for line in long_functions
    )
    yield f"import cycles: {len(cycles)}\n" + "".join(f"  {', '.join(cycle)}\n" for cycle in cycles)


if __name__ == "__main__":
    print("\n".join(report(Path(sys.argv[1] if len(sys.argv) > 1 else "."))))
