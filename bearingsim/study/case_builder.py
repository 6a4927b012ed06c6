"""Cases of a study, each from its base tree and one combination of swept values."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path as FilePath

from bearingsim.config import Case
from bearingsim.config.fields import Path
from bearingsim.study.diagnose import Problems, Sections, case_of, mark_of
from bearingsim.study.expand import expand_tree
from bearingsim.study.paths import dimension, put, value_at
from bearingsim.study.relations import Relations, Row, UndefinedValue
from bearingsim.study.sweep import is_word
from bearingsim.text.units import parse as quantity
from bearingsim.text.yamlfile import Node, Problem, StudyError

MAX_INVALID_CASES = 500
"""Limit of the invalid cases that are reported: each takes milliseconds, and most have the same problem."""
SweptValues = dict[str, float | str]
"""Swept values of a case by path: numbers in SI, all others as written."""


@dataclass
class CaseBuilder:
    """Builder of the cases of a study.

    base: tree of the values that are not swept; folder: of the study file; key_paths: locations of the swept and
    derived paths in a case; problems: of files named by swept values; case_problems: of single cases; sections:
    cache of validated sections.
    """

    base: Node
    folder: FilePath
    key_paths: Mapping[str, Path]
    relations: Relations = field(default_factory=Relations)
    problems: list[Problem] = field(default_factory=list)
    case_problems: Problems = field(default_factory=dict)
    sections: Sections = field(default_factory=Sections)

    def rows(self, combinations: Iterable[Row]) -> Iterator[Row]:
        """Yield the combinations that `where` keeps, with their derived values; add problems of formulas."""
        invalid = 0
        for row in combinations:
            try:
                derived = self.relations.complete(self.tree(row)) if self.relations else []
            except UndefinedValue as error:
                self.case_problems.setdefault((mark_of(error.problem), "", "no value"), error.problem)
                if (invalid := invalid + 1) == MAX_INVALID_CASES:
                    return
                continue
            if derived is not None:
                yield row + derived

    def tree(self, row: Row) -> Node:
        """Return the base tree with the values of one combination."""
        tree = self.base
        for path, value in sorted(row, key=lambda pair: len(self.key_paths[pair[0]])):  # sections before parts
            tree = put(tree, self.key_paths[path], value)
            if dimension(path) is None:
                tree = expand_tree(tree, self.folder, self.problems)
        return tree

    def case(self, row: Row) -> Case | None:
        """Build the case of one combination of values. If it is invalid, add its problems and return None."""
        tree = self.tree(row)
        try:
            swept = frozenset(self.key_paths[path] for path, _ in row)
            return case_of(tree, swept, self.case_problems, self.sections)
        except StudyError as error:  # invalid YAML in a file named by the row
            self.problems += error.problems
            return None


def swept_values(case: Case, row: Row, key_paths: Mapping[str, Path]) -> SweptValues:
    """Return the swept values of a case by path: numbers in SI, all others as written."""
    values: SweptValues = {}
    for path, node in row:
        value, kind = value_at(case, key_paths[path]), dimension(path)
        if value is None and kind and not is_word(path, node):
            value = quantity(node.text, kind)  # in an omitted section, as at zero misalignment
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        values[path] = float(value) if is_number and not is_word(path, node) else node.text
    return values
