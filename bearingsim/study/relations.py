"""Derived values of a case (`derived`), and conditions that exclude cases (`where`)."""

import re
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from graphlib import CycleError, TopologicalSorter

from bearingsim.config.fields import Path
from bearingsim.study.paths import dimension, node_at, put
from bearingsim.study.sweep_settings import SweepSettings
from bearingsim.text.algebra import BOOLEAN, DIMENSIONLESS, Kind, kind_of, kind_text
from bearingsim.text.expressions import Expression, ExpressionError, read
from bearingsim.text.units import DISPLAY, EXPECTED, UnitError, display, parse
from bearingsim.text.yamlfile import Node, Problem, problem

MAX_CONDITIONS = 100
"""Limit of the conditions of a study; each is evaluated for every case."""
KeyPathOf = Callable[[str], Path]
"""Function that locates a path in a case, and raises ValueError for an invalid path."""
Row = list[tuple[str, Node]]
"""Pairs of paths of a case and their values."""


@dataclass(frozen=True)
class Derived:
    """Path whose value is computed by a formula."""

    path: str
    key_path: Path
    formula: Expression
    entry: Node

    @property
    def unit(self) -> str:
        """Unit in which the values are written."""
        kind = dimension(self.path)
        return DISPLAY[kind] if kind else ""

    def node(self, value: float) -> Node:
        """Return a value (SI) as written in a file, with 12 digits."""
        kind, unit = dimension(self.path), self.unit
        number = display(value, unit, kind) if kind else value
        return Node(f"{number + 0.0:.12g} {unit}".strip(), self.formula.node.mark, self.entry.key)


@dataclass(frozen=True)
class Relations:
    """Relations of a study: ``derived`` values in order of evaluation, and conditions ``where``.

    excluded: number of cases excluded by each condition.
    """

    derived: tuple[Derived, ...] = ()
    where: tuple[Expression, ...] = ()
    key_path: KeyPathOf = lambda path: ()
    excluded: Counter[int] = field(default_factory=Counter)

    def __bool__(self) -> bool:
        return bool(self.derived or self.where)

    def reads(self, path: str) -> bool:
        """Return True if a formula contains a path."""
        formulas = (*(derived.formula for derived in self.derived), *self.where)
        return any(name == path for formula in formulas for name, _ in formula.names())

    def complete(self, tree: Node) -> Row | None:
        """Compute the derived values of a case; None if a condition excludes the case. Raises UndefinedValue."""
        row: Row = []
        for relation in self.derived:
            node = relation.node(self._value(f"derived.{relation.path}", relation.formula, tree))
            row.append((relation.path, node))
            tree = put(tree, relation.key_path, node)
        for number, condition in enumerate(self.where):
            if not self._value("where", condition, tree):
                self.excluded[number] += 1
                return None
        return row

    def no_cases_problem(self) -> Problem:
        """Return the problem that no case is left, located at the condition that excludes most cases."""
        (number, _), *_ = self.excluded.most_common(1)
        count = self.excluded.total()
        subject = f"all {count} combinations are" if count > 1 else "the only combination is"
        return problem(self.where[number].node.mark, f"where: {subject} excluded")

    def _value(self, label: str, formula: Expression, tree: Node) -> float:
        try:
            return formula.value(lambda path: _number(path, node_at(tree, self.key_path(path))))
        except ExpressionError as error:
            values = [(path, node_at(tree, self.key_path(path))) for path in dict(formula.names())]
            operands = ", ".join(f"{path} = {node.text}" for path, node in values if node is not None)
            message = f"{label}: {error}" + (f", at {operands}" if operands else "")
            raise UndefinedValue(problem(error.mark, message, error.hint)) from None


class UndefinedValue(Exception):
    """Error for a formula that has no value in a case; ``problem``: the reason."""

    def __init__(self, reason: Problem) -> None:
        self.problem = reason
        super().__init__(reason.message)


def _number(path: str, node: Node | None) -> float:
    """Return the value (SI) at a path. Raises ValueError if there is none, or if it is not a number."""
    if node is None:
        raise ValueError(f"the study has no value of `{path}` for a formula")
    number = _number_of(path, node.value) if isinstance(node.value, str) else None
    if number is None:
        raise ValueError(f"`{path}` is not a number: `{node.text}`")
    return number


@lru_cache(maxsize=1 << 12)
def _number_of(path: str, text: str) -> float | None:
    kind = dimension(path)
    try:
        return parse(text, kind) if kind else float(text) if re.fullmatch(r"\d{1,9}", text, re.ASCII) else None
    except UnitError:
        return None


def parse_relations(
    settings: SweepSettings, key_path: KeyPathOf, is_swept: Callable[[Path], bool], problems: list[Problem]
) -> Relations:
    """Parse `derived` and `where`; invalid entries are omitted, and their problems added.

    is_swept: function that returns True for a location in a case that the study sweeps.
    """
    derived = [
        _parse_derived(path, node, key_path, is_swept, problems)
        for path, node in _derived_entries(settings, problems)
    ]
    where = [_parse_condition(node, key_path, problems) for node in _conditions(settings, problems)]
    formulas = [formula for formula in derived if formula is not None]
    conditions = tuple(condition for condition in where if condition is not None)
    return Relations(_sort(formulas, key_path, problems), conditions, key_path)


def _derived_entries(settings: SweepSettings, problems: list[Problem]) -> Iterator[tuple[str, Node]]:
    section = settings.get("derived")
    if section is None:
        return
    if not isinstance(section.value, dict):
        example = "expected a mapping such as `{defect.depth: defect.width / 4}`"
        problems.append(problem(section.mark, f"derived: {example}"))
    yield from section.mapping.items()


def _conditions(settings: SweepSettings, problems: list[Problem]) -> tuple[Node, ...]:
    section = settings.get("where")
    if section is None:
        return ()
    if isinstance(section.value, dict):
        problems.append(problem(section.mark, "where: expected a list such as `[defect.width < 3 mm]`"))
        return ()
    conditions = section.items if isinstance(section.value, tuple) else (section,)
    if len(conditions) > MAX_CONDITIONS:
        message = f"where: {len(conditions)} conditions; at most {MAX_CONDITIONS} are possible"
        problems.append(problem(section.mark, message))
        return ()
    return conditions


def _parse_derived(
    path: str, node: Node, key_path: KeyPathOf, is_swept: Callable[[Path], bool], problems: list[Problem]
) -> Derived | None:
    key = node.key or node.mark
    try:
        location = key_path(path)
        if is_swept(location):
            problems.append(problem(key, f"`{path}` is both swept and derived"))
            return None
        formula = read(node)
        kind, expected_kind = formula.kind(lambda name: _kind(name, key_path)), dimension(path)
    except ExpressionError as error:
        problems.append(problem(error.mark, f"derived.{path}: {error}", error.hint))
        return None
    except ValueError as error:
        problems.append(problem(key, str(error)))
        return None
    if kind != (kind_of(expected_kind) if expected_kind else DIMENSIONLESS):
        expected = EXPECTED[expected_kind] if expected_kind else "a plain number"
        problems.append(problem(node.mark, f"derived.{path}: expected {expected}, got {kind_text(kind)}"))
        return None
    return Derived(path, location, formula, node)


def _parse_condition(node: Node, key_path: KeyPathOf, problems: list[Problem]) -> Expression | None:
    try:
        formula = read(node)
        kind = formula.kind(lambda name: _kind(name, key_path))
    except ExpressionError as error:
        problems.append(problem(error.mark, f"where: {error}", error.hint))
        return None
    if kind != BOOLEAN:
        expected = "expected a comparison such as `defect.width < 3 mm`"
        problems.append(problem(node.mark, f"where: {expected}, got {kind_text(kind)}"))
        return None
    return formula


def _kind(path: str, key_path: KeyPathOf) -> Kind:
    """Return the kind of the values at a path; words instead of numbers are detected during evaluation."""
    key_path(path)
    quantity = dimension(path)
    return kind_of(quantity) if quantity else DIMENSIONLESS


def _sort(derived: list[Derived], key_path: KeyPathOf, problems: list[Problem]) -> tuple[Derived, ...]:
    """Sort derived values by their dependences; add problems for duplicates and circular dependences."""
    by_key_path: dict[Path, Derived] = {}
    for value in derived:
        if value.key_path in by_key_path:
            problems.append(problem(value.entry.key or value.entry.mark, f"`{value.path}` is derived twice"))
        by_key_path.setdefault(value.key_path, value)
    names = {
        location: [key_path(name) for name, _ in value.formula.names()] for location, value in by_key_path.items()
    }
    dependences = {
        location: [operand for operand in operands if operand in by_key_path]
        for location, operands in names.items()
    }
    try:
        return tuple(by_key_path[location] for location in TopologicalSorter(dependences).static_order())
    except CycleError as error:
        cycle = [by_key_path[location] for location in error.args[1][:0:-1]]  # each depends on the next
        start = cycle.index(min(cycle, key=lambda value: list(by_key_path).index(value.key_path)))
        head, *others = cycle[start:] + cycle[:start]
        chain = ", which follows from ".join(f"`{value.path}`" for value in (*others, head))
        message = f"derived: `{head.path}` depends on {chain}, which is circular"
        problems.append(problem(head.entry.key or head.entry.mark, message))
        return ()
