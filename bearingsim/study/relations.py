"""What follows from the values of a case (`derived`), and which cases a study leaves out (`where`)."""

import re
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from graphlib import CycleError, TopologicalSorter

from bearingsim.config.rules.conflicts import Path
from bearingsim.study.paths import dimension, node_at, put
from bearingsim.study.words import Words
from bearingsim.text.expressions import PLAIN, TRUTH, Expression, ExpressionError, Kind, kind_of, read, said
from bearingsim.text.units import DISPLAY, EXPECTED, UnitError, display, parse
from bearingsim.text.yamlfile import Node, Problem, problem

MAX_CONDITIONS = 100
Place = Callable[[str], Path]
"""Where a path leads; ValueError if nowhere."""
Row = list[tuple[str, Node]]
"""Paths of a case, and their values."""


@dataclass(frozen=True)
class Derived:
    """A path whose value a formula gives."""

    path: str
    place: Path
    formula: Expression
    entry: Node

    @property
    def unit(self) -> str:
        """In which its values are written."""
        known = dimension(self.path)
        return DISPLAY[known] if known else ""

    def node(self, value: float) -> Node:
        """A value (SI) as it would stand in the file, 12 digits."""
        known, word = dimension(self.path), self.unit
        number = display(value, word, known) if known else value
        return Node(f"{number + 0.0:.12g} {word}".strip(), self.formula.node.mark, self.entry.key)


@dataclass(frozen=True)
class Relations:
    """All of a study: ``derived`` in an order in which each follows from what is before it.

    dropped: how many cases each condition of ``where`` has left out.
    """

    derived: tuple[Derived, ...] = ()
    where: tuple[Expression, ...] = ()
    place: Place = lambda path: ()
    dropped: Counter[int] = field(default_factory=Counter)

    def __bool__(self) -> bool:
        return bool(self.derived or self.where)

    def completed(self, tree: Node) -> Row | None:
        """What follows for a case; None if the study leaves it out. Raises Valueless."""
        row: Row = []
        for one in self.derived:
            node = one.node(self._value(f"derived.{one.path}", one.formula, tree))
            row.append((one.path, node))
            tree = put(tree, one.place, node)
        for number, condition in enumerate(self.where):
            if not self._value("where", condition, tree):
                self.dropped[number] += 1
                return None
        return row

    def nothing_left(self) -> Problem:
        """What is said where all cases are left out: at the condition that leaves out most."""
        (number, _), *_ = self.dropped.most_common(1)
        count = self.dropped.total()
        every = f"all {count} combinations are" if count > 1 else "the only combination is"
        return problem(self.where[number].node.mark, f"where: {every} left out")

    def _value(self, what: str, formula: Expression, tree: Node) -> float:
        try:
            return formula.value(lambda path: _number(path, node_at(tree, self.place(path))))
        except ExpressionError as error:
            values = [(path, node_at(tree, self.place(path))) for path in dict(formula.names())]
            told = ", ".join(f"{path} = {node.text}" for path, node in values if node is not None)
            message = f"{what}: {error}" + (f", at {told}" if told else "")
            raise Valueless(problem(error.mark, message, error.hint)) from None


class Valueless(Exception):
    """A formula has no value in a case; ``problem`` says why."""

    def __init__(self, found: Problem) -> None:
        self.problem = found
        super().__init__(found.message)


def _number(path: str, node: Node | None) -> float:
    """The value (SI) at a path; ValueError where there is none, or no number."""
    if node is None:
        raise ValueError(f"the study writes no value of `{path}`, which a formula could use")
    found = _number_of(path, node.value) if isinstance(node.value, str) else None
    if found is None:
        raise ValueError(f"`{path}` is no number here: `{node.text}`")
    return found


@lru_cache(maxsize=1 << 12)
def _number_of(path: str, text: str) -> float | None:
    known = dimension(path)
    try:
        return parse(text, known) if known else float(text) if re.fullmatch(r"\d{1,9}", text, re.ASCII) else None
    except UnitError:
        return None


def parse_relations(
    words: Words, place: Place, swept: Callable[[Path], bool], problems: list[Problem]
) -> Relations:
    """What a study says in `derived` and `where`; what is wrong is noted, and left out.

    swept: whether the study sweeps what lies at a place.
    """
    derived = [_derived(path, node, place, swept, problems) for path, node in _entries(words, problems)]
    where = [_condition(node, place, problems) for node in _conditions(words, problems)]
    found = [one for one in derived if one is not None]
    return Relations(_in_order(found, place, problems), tuple(one for one in where if one is not None), place)


def _entries(words: Words, problems: list[Problem]) -> Iterator[tuple[str, Node]]:
    section = words.get("derived")
    if section is None:
        return
    if not isinstance(section.value, dict):
        example = "expected a mapping such as `{defect.depth: defect.width / 4}`"
        problems.append(problem(section.mark, f"derived: {example}"))
    yield from section.mapping.items()


def _conditions(words: Words, problems: list[Problem]) -> tuple[Node, ...]:
    section = words.get("where")
    if section is None:
        return ()
    if isinstance(section.value, dict):
        problems.append(problem(section.mark, "where: expected a list such as `[defect.width < 3 mm]`"))
        return ()
    found = section.items if isinstance(section.value, tuple) else (section,)
    if len(found) > MAX_CONDITIONS:
        message = f"where: {len(found)} conditions; at most {MAX_CONDITIONS} are possible"
        problems.append(problem(section.mark, message))
        return ()
    return found


def _derived(
    path: str, node: Node, place: Place, swept: Callable[[Path], bool], problems: list[Problem]
) -> Derived | None:
    key = node.key or node.mark
    try:
        where = place(path)
        if swept(where):
            problems.append(problem(key, f"`{path}` is swept, and derived"))
            return None
        formula = read(node)
        found, known = formula.kind(lambda name: _kind(name, place)), dimension(path)
    except ExpressionError as error:
        problems.append(problem(error.mark, f"derived.{path}: {error}", error.hint))
        return None
    except ValueError as error:
        problems.append(problem(key, str(error)))
        return None
    if found != (kind_of(known) if known else PLAIN):
        expected = EXPECTED[known] if known else "a plain number"
        problems.append(problem(node.mark, f"derived.{path}: expected {expected}, and this is {said(found)}"))
        return None
    return Derived(path, where, formula, node)


def _condition(node: Node, place: Place, problems: list[Problem]) -> Expression | None:
    try:
        formula = read(node)
        found = formula.kind(lambda name: _kind(name, place))
    except ExpressionError as error:
        problems.append(problem(error.mark, f"where: {error}", error.hint))
        return None
    if found != TRUTH:
        expected = "expected a comparison such as `defect.width < 3 mm`"
        problems.append(problem(node.mark, f"where: {expected}, and this is {said(found)}"))
        return None
    return formula


def _kind(path: str, place: Place) -> Kind:
    """What the values at a path are; whether a word stands there is seen with the value."""
    place(path)
    known = dimension(path)
    return kind_of(known) if known else PLAIN


def _in_order(derived: list[Derived], place: Place, problems: list[Problem]) -> tuple[Derived, ...]:
    """Each behind those that it follows from."""
    by_place: dict[Path, Derived] = {}
    for one in derived:
        if one.place in by_place:
            problems.append(problem(one.entry.key or one.entry.mark, f"`{one.path}` is derived twice"))
        by_place.setdefault(one.place, one)
    names = {where: [place(name) for name, _ in one.formula.names()] for where, one in by_place.items()}
    needs = {where: [named for named in all_named if named in by_place] for where, all_named in names.items()}
    try:
        return tuple(by_place[where] for where in TopologicalSorter(needs).static_order())
    except CycleError as error:
        circle = [by_place[where] for where in error.args[1][:0:-1]]  # each follows from the next
        at = circle.index(min(circle, key=lambda one: list(by_place).index(one.place)))
        first, *others = circle[at:] + circle[:at]
        chain = ", which follows from ".join(f"`{one.path}`" for one in (*others, first))
        message = f"derived: `{first.path}` follows from {chain}: none can be first"
        problems.append(problem(first.entry.key or first.entry.mark, message))
        return ()
