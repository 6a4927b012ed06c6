"""Mutation test of the test suite: detection of changes by the tests of a package, of all packages (in the root of
tests/), and of its neighbour.

    python -m benchmarks.mutants [--seed 1] [--count 40] [--only 3,17] [--limit 150] [--csv docs/data/mutants.csv]

Each mutant is one change of a module's syntax tree, drawn from ``--seed``, in a copy of the source tree (in
results/mutants, a fixed path, because numba's cache depends on it). It counts as killed if a test fails within the
limit; test files that mention the module run first. At the end all tests that failed must pass without a mutant,
in modules that are rewritten from their syntax tree like a mutant, without comments.

mutmut switches between mutants within rewritten functions, so it omits module constants and decorated functions,
and it has no sampling. cosmic-ray changes files in place, runs one command for all modules, deletes no statements,
and needs a filter for sampling. Both would also need the copy, the order of tests and the limit, which are most of
this file.
"""

import argparse
import ast
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from copy import deepcopy
from itertools import chain, islice
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

HOME = Path(__file__).resolve().parents[1]
COPY = HOME / "results" / "mutants"
LIMIT_S = 150.0
"""Longest wall time (s) of the tests of a mutant on an otherwise idle machine."""
MODULES = {
    "selection/decide.py": ("selection", "study"),
    "simulation/choice.py": ("simulation", "cli"),
    "simulation/repetition.py": ("simulation", "store"),
    "simulation/integration.py": ("simulation", "store"),
    "store/table.py": ("store", "cli"),
    "study/plan.py": ("study", "cli"),
    "cli/plan.py": ("cli", "study"),
}
"""Folders of the tests of each module: that of its package, then that of a neighbouring package."""

OPPOSITE: dict[type, type] = {
    ast.Lt: ast.GtE,
    ast.GtE: ast.Lt,
    ast.Gt: ast.LtE,
    ast.LtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
BOUNDARY: dict[type, type] = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt}
ARITHMETIC: dict[type, type] = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}


class Mutant(NamedTuple):
    """Change of the node with index ``node`` in a walk through the tree of ``module``."""

    module: str
    node: int
    kind: str
    new: ast.AST


class Outcome(NamedTuple):
    """Row of the table: the change, the first test that failed ("" if none), and the CPU time of all (s)."""

    number: int
    module: str
    line: int
    kind: str
    before: str
    after: str
    killed_by: str
    cpu_s: float


def changes(node: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    """Yield the possible changes of a node: kind of change, and new node."""
    match node:
        case ast.Compare(left=left, ops=[operator], comparators=comparators):
            yield "comparison flipped", ast.Compare(left, [OPPOSITE[type(operator)]()], comparators)
            if type(operator) in BOUNDARY:
                yield "boundary", ast.Compare(left, [BOUNDARY[type(operator)]()], comparators)
        case ast.Constant(value=bool(value)):
            yield "constant", ast.Constant(not value)
        case ast.Constant(value=int(value)):
            yield "constant", ast.Constant(value + 1)
        case ast.Constant(value=float(value)):
            yield "constant", ast.Constant(2.0 * value or 1.0)
        case ast.BoolOp(op=operator, values=values):
            yield "and/or", ast.BoolOp(ast.Or() if isinstance(operator, ast.And) else ast.And(), values)
        case ast.BinOp(left=left, op=operator, right=right) if type(operator) in ARITHMETIC:
            yield "arithmetic", ast.BinOp(left, ARITHMETIC[type(operator)](), right)
        case ast.Return(value=ast.expr()):
            yield "return value", ast.Return(ast.Constant(None))
        case ast.If() | ast.IfExp() | ast.While():
            altered = deepcopy(node)
            altered.test = ast.UnaryOp(ast.Not(), altered.test)
            yield "condition negated", altered
        case ast.Expr(value=ast.Call()) | ast.AugAssign() | ast.Raise() | ast.Continue() | ast.Break():
            yield "statement deleted", ast.Pass()
        case ast.Assign(targets=[target], value=value) if is_bound_before(target, value):
            yield "statement deleted", ast.Pass()


def is_bound_before(target: ast.expr, value: ast.expr) -> bool:
    """Check if a target has a value before its assignment, so that the module runs without it."""
    if isinstance(target, ast.Name):
        return any(isinstance(name, ast.Name) and name.id == target.id for name in ast.walk(value))
    return isinstance(target, ast.Attribute | ast.Subscript)


def nodes(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield the executed nodes of a tree, without annotations, decorators and imports for types."""
    yield tree
    for name, value in ast.iter_fields(tree):
        if name in ("annotation", "returns", "decorator_list"):
            continue
        for child in value if isinstance(value, list) else [value]:
            is_for_types = isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING"
            if isinstance(child, ast.AST) and not is_for_types:
                yield from nodes(child)


def draw(seed: int, count: int) -> list[Mutant]:
    """Draw mutants from each module in turn."""
    rng, groups = random.Random(seed), []
    for module in MODULES:
        numbered = enumerate(nodes(parse(module)))
        mutants = [Mutant(module, index, *change) for index, node in numbered for change in changes(node)]
        rng.shuffle(mutants)
        groups.append(mutants)
    return list(islice(chain.from_iterable(zip(*groups, strict=False)), count))


def parse(module: str) -> ast.Module:
    """Parse a module of the package."""
    return ast.parse((HOME / "bearingsim" / module).read_text())


def list_test_files(module: str) -> list[list[str]]:
    """List test files in groups: those that mention a module (by frequency), others of its package, those of all
    packages, those of its neighbour."""
    folders = (COPY / "tests" / MODULES[module][0], COPY / "tests", COPY / "tests" / MODULES[module][1])
    package, common, neighbour = (sorted(folder.glob("test_*.py")) for folder in folders)
    word = re.compile(rf"\b{Path(module).stem}\b")
    counts = {path: len(word.findall(path.read_text())) for path in (*package, *common)}
    namesake = folders[0] / f"test_{Path(module).name}"
    mentioning = sorted(filter(counts.get, counts), key=lambda path: (path != namesake, -counts[path]))
    others = ([path for path in group if counts[path] == 0] for group in (package, common))
    return [[str(path) for path in group] for group in (mentioning, *others, neighbour)]


def stages(module: str) -> Iterator[list[str]]:
    """Yield the arguments of successive pytest runs."""
    return ([*paths, "-m", mark] for paths in list_test_files(module) if paths for mark in ("not slow", "slow"))


def first_failure(stages: Iterable[list[str]], limit_s: float = inf) -> str:
    """Run pytest in the copy with the arguments of each stage; return the first failing test, or "".

    Tests still running after ``limit_s`` of total wall time count as passed.
    """
    deadline, environment = time.monotonic() + limit_s, os.environ | {"CI": "1", "PYTHONDONTWRITEBYTECODE": "1"}
    for arguments in stages:
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-rfE", "-p", "no:cacheprovider", *arguments]
        pipes: Any = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
        tests = subprocess.Popen(command, cwd=COPY, env=environment, start_new_session=True, **pipes)
        try:
            output, _ = tests.communicate(
                timeout=None if deadline == inf else max(deadline - time.monotonic(), 0.0)
            )
        except subprocess.TimeoutExpired:
            os.killpg(tests.pid, signal.SIGKILL)
            tests.communicate()
            return ""
        if tests.returncode not in (0, 5):  # 5: no tests selected
            test = re.search(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", output, re.MULTILINE)
            return test[1] if test else output.strip().splitlines()[-1]
    return ""


def rewrite_modules() -> None:
    """Write the modules of the copy from their syntax trees, as each mutant is written, but without a change."""
    for module in MODULES:
        (COPY / "bearingsim" / module).write_text(ast.unparse(parse(module)))


def cpu_of_children() -> float:
    """Return the CPU time (s) of finished child processes."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def run_tests(number: int, mutant: Mutant, limit_s: float) -> Outcome:
    """Write a mutant into the copy and test it."""
    module, tree = COPY / "bearingsim" / mutant.module, parse(mutant.module)
    old = list(nodes(tree))[mutant.node]

    class Change(ast.NodeTransformer):
        def visit(self, node: ast.AST) -> ast.AST:
            return mutant.new if node is old else self.generic_visit(node)

    source = module.read_bytes()
    module.write_text(ast.unparse(ast.fix_missing_locations(Change().visit(tree))))
    began = cpu_of_children()
    try:
        test = first_failure(stages(mutant.module), limit_s)
    finally:
        module.write_bytes(source)
    seconds = round(cpu_of_children() - began, 1)
    before, after = (" ".join(ast.unparse(node).split())[:100] for node in (old, mutant.new))
    return Outcome(number, mutant.module, getattr(old, "lineno", 0), mutant.kind, before, after, test, seconds)


def copy() -> None:
    """Copy the tree again, with file times, which numba uses to validate its cache."""
    shutil.rmtree(COPY, ignore_errors=True)
    ignored = shutil.ignore_patterns(".*", "results", "__pycache__")
    shutil.copytree(HOME, COPY, ignore=ignored)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--only", type=lambda text: set(map(int, text.split(","))), help="numbers of mutants")
    parser.add_argument("--limit", type=float, default=LIMIT_S, help="s, longer if other programs run")
    parser.add_argument("--csv", type=Path, help="with --only its rows are replaced")
    options = parser.parse_args()
    copy()
    chosen = [
        (number, mutant)
        for number, mutant in enumerate(draw(options.seed, options.count), 1)
        if not options.only or number in options.only
    ]
    rows = []
    for number, mutant in chosen:
        rows.append(run_tests(number, mutant, options.limit))
        print(*rows[-1], sep="  ", flush=True)
    killers = sorted({row.killed_by for row in rows if row.killed_by})
    print(f"{sum(bool(row.killed_by) for row in rows)} of {len(rows)} mutants are killed")
    if options.csv:
        table = pd.DataFrame(rows)
        if options.only and options.csv.exists():
            before = pd.read_csv(options.csv, keep_default_na=False)
            table = pd.concat([before[~before["number"].isin(table["number"])], table]).sort_values("number")
        table.to_csv(options.csv, index=False, lineterminator="\n")
    rewrite_modules()
    if killers and (test := first_failure([killers])):
        print(f"{test} fails without a mutant, too")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
