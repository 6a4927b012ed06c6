"""Plan of a study: its base tree and its axes."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
from pathlib import Path as FilePath

from bearingsim.catalogue import DEFAULT_MODEL, FEATURES
from bearingsim.config import Case
from bearingsim.config.fields import Path
from bearingsim.designs import KINDS
from bearingsim.extensions import owner
from bearingsim.study.case_builder import MAX_INVALID_CASES, CaseBuilder, SweptValues, swept_values
from bearingsim.study.design import BLOCK_DESIGNS, SampledDesign, block_conflicts, draw_design
from bearingsim.study.diagnose import STUDY_KEYS, Problems, check_replaced
from bearingsim.study.expand import expand_tree
from bearingsim.study.figures import add_features
from bearingsim.study.first_look import vary_one_axis
from bearingsim.study.jobs import identity
from bearingsim.study.paths import LIST_VALUED, dimension, normal_form, parse_path, put
from bearingsim.study.quick import quick_problems, quick_values
from bearingsim.study.relations import Relations, Row, parse_relations
from bearingsim.study.sweep import (
    Axis,
    combinations,
    drop_paths,
    is_list_of_lists,
    is_sweep,
    named_paths,
    parse_sweep,
    repeat_axes,
    replace_axis,
    single_axis,
    unit_of,
    with_one_seed,
)
from bearingsim.study.sweep_settings import (
    COMMAND_LINE_SETTINGS,
    SWEEP_SETTINGS,
    SweepSettings,
    assigned_entries,
    assigned_paths,
    remove_path,
    update_setting,
)
from bearingsim.study.used import is_random
from bearingsim.text.yamlfile import Mark, Node, Problem, StudyError, argument_mark, parse_argument, problem

MAX_CASES = 1_000_000
"""Limit of the cases of a study."""
MAX_PATHS = 100
"""Limit of the paths that a study sweeps: with more, the search for suggestions takes too long."""


@dataclass
class Plan:
    """Study under construction: base tree, axes, and problems so far.

    settings: keys of the sweep that are not paths, from which ``sampled_design`` and ``relations`` are built;
    case_problems: problems of single cases; repeated: numbers of combinations, by the paths in which they differ
    from the first one with an equal case; duplicates: numbers of combinations equal in all values, by the paths
    whose lists repeat a value; named_paths: paths named by a sweep, valid or not; key_paths: locations
    of the valid ones in a case; notes: remarks on the sweep; variants: cache of ``cases_with``.
    """

    base: Node
    folder: FilePath
    axes: list[Axis] = field(default_factory=list)
    settings: SweepSettings = field(default_factory=dict)
    sampled_design: SampledDesign | None = None
    relations: Relations = field(default_factory=Relations)
    problems: list[Problem] = field(default_factory=list)
    case_problems: Problems = field(default_factory=dict)
    repeated: Counter[tuple[str, ...]] = field(default_factory=Counter)
    duplicates: Counter[tuple[str, ...]] = field(default_factory=Counter)
    named_paths: set[str] = field(default_factory=set)
    key_paths: dict[str, Path] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    variants: dict[tuple, list[Case | None]] = field(default_factory=dict)

    @classmethod
    def build(
        cls, root: Node, folder: FilePath, overrides: Mapping[str, str], quick: bool, features: Mapping[str, Node]
    ) -> "Plan":
        """Build the plan of a file: base and sweep, changed by `quick` and the overrides, with ``features``."""
        entries = {key: node for key, node in root.mapping.items() if key not in STUDY_KEYS}
        plan = cls(Node(entries, root.mark), folder)
        plan.expand()
        if "sweep" in root.mapping:
            plan.axes = plan.read_sweep(root.mapping["sweep"])
        if quick and "quick" in root.mapping:
            plan.apply_quick(root.mapping["quick"])
        for path, text in overrides.items():
            plan.override(path, text)
        plan.base = add_features(plan.base, features)
        plan.add_design()
        plan.axes = [axis for axis in plan.axes if plan.check_axis(axis)]
        plan.add_relations()
        plan.check_count()
        return plan

    def expand(self) -> None:
        """Read the files referenced by the base tree."""
        self.base = expand_tree(self.base, self.folder, self.problems)

    def read_sweep(self, sweep: Node) -> list[Axis]:
        """Parse a section `sweep`; return its axes."""
        paths = named_paths(sweep)
        if len(paths) > MAX_PATHS:
            message = f"sweep: {len(paths)} parameters; at most {MAX_PATHS} are possible"
            self.problems.append(problem(sweep.key or sweep.mark, message))
            return []
        self.named_paths |= set(map(self.swept_spelling, paths))
        designs = [node for key, node in sweep.mapping.items() if key in KINDS]
        if len(designs) > 1:
            message = "sweep: a second design; a study has one"
            self.problems.append(problem(designs[1].key or designs[1].mark, message))
        for key in (key for key in sweep.mapping if key in SWEEP_SETTINGS):
            self.settings = update_setting(self.settings, key, sweep.mapping[key])
        axes = parse_sweep(sweep, self.problems)
        return [replace(axis, paths=tuple(map(self.swept_spelling, axis.paths))) for axis in axes]

    def apply_quick(self, quick: Node) -> None:
        """Apply the entries of the section `quick`."""
        sweep = quick.mapping.get("sweep")
        axes = [] if sweep is None else self.read_sweep(sweep)
        self.problems += quick_problems(quick, axes)
        if any(axis.zipped for axis in axes):
            self.axes = [axis for axis in self.axes if not axis.zipped]
        if sweep is not None:
            self.axes = drop_paths(self.axes, assigned_paths(sweep.mapping))
        for axis in axes:
            self.sweep_over(axis)
        # Sections before their parts, because the order of the keys in a file must not matter.
        for key, node in sorted(quick_values(quick).items(), key=lambda item: len(normal_form(item[0]))):
            self.set_value(key, node, node.key or node.mark)

    def sweep_over(self, axis: Axis) -> None:
        """Replace all sweeps of an axis' paths by the axis; add a note if this splits a `zip`."""
        for other in self.axes:
            remaining = drop_paths([other], axis.paths)
            if len(axis.rows) > 1 and remaining not in ([], [other]):
                names = " and ".join(f"`{path}`" for path in remaining[0].paths)
                paths = " and ".join(f"`{path}`" for path in axis.paths)
                self.notes.append(f"{paths} no longer varies together with {names}: all combinations are computed")
        self.settings = reduce(remove_path, axis.paths, self.settings)
        self.axes = replace_axis(self.axes, axis)

    def override(self, path: str, text: str) -> None:
        """Apply a value from the command line."""
        argument = f"--set {path}={text}"
        path = self.swept_spelling(path)
        try:
            value, problems = parse_argument(text, argument)
        except StudyError as error:
            self.problems += error.problems
            return
        self.problems += problems
        mark = argument_mark(argument, len("--set ") + 1)
        if path in COMMAND_LINE_SETTINGS:
            self.apply_setting(path, Node(value.value, value.mark, mark))
        elif is_sweep(value) and (path not in LIST_VALUED or is_list_of_lists(value)):
            axis = single_axis(path, Node(value.value, value.mark, mark), self.problems)
            if axis is not None:
                self.sweep_over(axis)
        else:
            self.set_value(path, value, mark)

    def apply_setting(self, path: str, value: Node) -> None:
        """Apply `repeat`, or a key of the design such as `sobol.n`."""
        kind, _, key = path.partition(".")
        if not key:
            self.settings = update_setting(self.settings, kind, value)
        elif kind in self.settings:
            self.settings = update_setting(
                self.settings, kind, Node({key: value}, value.mark, self.settings[kind].key)
            )
        else:
            mark = value.key or value.mark
            self.problems.append(problem(mark, f"the study has no `{kind}`", "name it in `sweep`"))

    def set_value(self, path: str, value: Node, mark: Mark) -> None:
        """Set the value at a path of the base tree, which also replaces a sweep of the path.

        In a section that is swept as a whole, the value replaces that of every swept section.
        """
        key_path = self.key_path(path, mark)
        if key_path is None:
            return
        self.base = put(self.base, key_path, value)
        self.expand()
        path = self.swept_spelling(path)
        self.settings = remove_path(self.settings, path)
        location = normal_form(path)
        swept = [normal_form(other) for axis in self.axes for other in axis.paths]
        if any(location[: len(section)] == section for section in swept):
            self.axes = replace_axis(self.axes, Axis((path,), ((value,),), (value,)))

    def swept_spelling(self, path: str) -> str:
        """Return a path in the spelling of the axes, which figures and results use."""
        swept = (spelling for axis in self.axes for spelling in axis.paths)
        return next((spelling for spelling in swept if normal_form(spelling) == normal_form(path)), path)

    def key_path(self, path: str, mark: Mark) -> Path | None:
        """Locate a path in a case. For an invalid path, add a problem and return None."""
        try:
            return self.locate(path)
        except ValueError as error:
            self.problems.append(problem(mark, str(error)))
            return None

    def add_design(self) -> None:
        """Add the axes of the design, which varies slowest, and of `repeat`, which varies fastest."""
        kind = next((kind for kind in KINDS if kind in self.settings), None)
        if kind in BLOCK_DESIGNS:
            self.problems += block_conflicts(kind, self.axes, self.settings)
        if "repeat" in self.settings:
            self.axes += repeat_axes(self.settings["repeat"], self.problems)
        if kind is None:
            return
        entry = self.settings[kind]
        marks = {path: node.key or node.mark for path, node in assigned_entries(kind, entry).items()}
        if None not in [self.key_path(path, mark) for path, mark in marks.items()]:
            design = draw_design(kind, entry, MAX_CASES, self.problems)
            if design is not None:
                self.sampled_design, axis = design
                self.axes.insert(0, axis)

    def add_relations(self) -> None:
        """Parse `derived` and `where`, which depend on the swept paths."""
        swept_key_paths = set(self.key_paths.values())
        self.relations = parse_relations(self.settings, self.locate, swept_key_paths.__contains__, self.problems)
        self.key_paths |= {derived.path: derived.key_path for derived in self.relations.derived}
        for path, entry in self.entries().items():
            if path in FEATURES:  # the table would have two columns of this name
                message = f"`{path}` is also a feature of the extension `{owner(FEATURES[path].compute)}`"
                self.problems.append(problem(entry.key or entry.mark, message, "rename the feature"))

    def locate(self, path: str) -> Path:
        """Locate a path in a case. Raises ValueError for an invalid path."""
        return parse_path(path, self.base)

    def check_axis(self, axis: Axis) -> bool:
        """Return True if the paths of an axis are valid and not swept twice; add valid ones to ``key_paths``."""
        problem_count = len(self.problems)
        for path, node in zip(axis.paths, axis.keys, strict=True):
            mark = node.key or node.mark
            key_path = self.key_path(path, mark)
            if key_path in self.key_paths.values():
                self.problems.append(problem(mark, f"`{path}` is swept twice"))
            elif key_path:
                self.key_paths[path] = key_path
        return len(self.problems) == problem_count

    def open_files(self) -> None:
        """Read the files referenced by swept values."""
        for axis in self.axes:
            for path in axis.paths:
                if dimension(path) is None:
                    self._open_column(path, axis)

    def _open_column(self, path: str, axis: Axis) -> None:
        for row in axis.rows:
            with suppress(StudyError):  # reported when the case is built
                value = row[axis.paths.index(path)]
                expand_tree(put(self.base, self.key_paths[path], value), self.folder, [])

    @cached_property
    def builder(self) -> CaseBuilder:
        """Builder of the cases of a complete plan, which adds their problems to those of the plan."""
        return CaseBuilder(
            self.base, self.folder, self.key_paths, self.relations, self.problems, self.case_problems
        )

    @property
    def count(self) -> int:
        """Number of combinations of the axes."""
        return math.prod(len(axis.rows) for axis in self.axes)

    def check_count(self) -> None:
        """Add a problem and remove the axes if there are too many combinations."""
        if self.count > MAX_CASES:
            mark = self.axes[0].keys[0].mark
            self.problems.append(problem(mark, f"sweep: {self.count} cases; at most {MAX_CASES} are possible"))
            self.axes = []

    def models(self) -> set[str]:
        """Return the models that the study names, valid or not."""
        values = [
            row[axis.paths.index("model")] for axis in self.axes if "model" in axis.paths for row in axis.rows
        ]
        base = self.base.mapping.get("model")
        return {node.text for node in values or ([base] if base else [])} or {DEFAULT_MODEL}

    def sample_cases(self) -> list[Case]:
        """Build a sample of the cases, which reveals most problems."""
        check_replaced(self.base, frozenset(self.key_paths.values()), self.case_problems)
        sample = (self.builder.case(row) for row in self.builder.rows(vary_one_axis(self.axes)))
        return [case for case in sample if case is not None]

    def cases(self) -> list[tuple[Case, SweptValues]]:
        """Build the distinct cases, with their swept values; add the problems of invalid ones."""
        cases: dict[str, tuple[Case, SweptValues]] = {}
        numbers: dict[str, int] = {}
        first_rows: dict[str, Row] = {}
        indices: list[int] = []
        invalid = 0
        for row in self.builder.rows(combinations(self.axes)):
            case = self.builder.case(row)
            if case is not None:
                key, values = identity(case), swept_values(case, row, self.key_paths)
                _, first_values = cases.setdefault(key, (case, values))
                differing = tuple(path for path in values if values[path] != first_values[path])
                self.repeated[differing] += 1
                if (first_row := first_rows.setdefault(key, row)) is not row and not differing:
                    self.duplicates[self._repeated_paths(row, first_row)] += 1
                indices.append(numbers.setdefault(key, len(numbers)))
            elif (invalid := invalid + 1) == MAX_INVALID_CASES:
                break
        if self.sampled_design is not None:
            self.sampled_design = replace(self.sampled_design, cases=tuple(indices))
        return list(cases.values())

    def _repeated_paths(self, row: Row, first_row: Row) -> tuple[str, ...]:
        """Return the paths in which two rows have different entries of a list; those of a design are omitted."""
        drawn_axes = 0 if self.sampled_design is None else 1  # the axis of a design is the first
        listed = {path for axis in self.axes[drawn_axes:] for path in axis.paths}
        pairs = zip(row, first_row, strict=True)
        return tuple(path for (path, node), (_, other) in pairs if path in listed and node is not other)

    def repetition_notes(self) -> Iterator[str]:
        """Yield a remark on the combinations omitted because their case is equal to that of another one."""
        total = self.repeated.total()
        reasons = ((" with repeated values of", self.duplicates), (", equal to cases with another", self.repeated))
        for reason, counts in reasons:
            for paths, count in counts.items():
                if paths:
                    words = " and ".join(f"`{path}`" for path in paths)
                    yield f"left out: {count} of {total} combinations{reason} {words}"

    def check_settings(self) -> None:
        """Add a problem if `where` excludes every case, or if no case is random although `repeat` is used."""
        if self.problems or self.case_problems:
            return
        self.relations.excluded.clear()
        reads_seed = self.relations.reads("seed")
        axes = self.axes if reads_seed else list(map(with_one_seed, self.axes))
        cases = filter(None, map(self.builder.case, self.builder.rows(combinations(axes))))
        example = next(cases, None)
        if example is None and self.relations.excluded:
            self.problems.append(self.relations.no_cases_problem())
        node = self.settings.get("repeat")
        if node is None or example is None or reads_seed:
            return
        if not any(map(is_random, (example, *cases))):
            message = "repeat: nothing in this study depends on `seed`"
            advice = "only `excitation: random-impulses` and rollers with play in a free cage (`model: planar`) do"
            self.problems.append(problem(node.key or node.mark, message, advice))

    def cases_with(self, values: Mapping[str, str]) -> list[Case | None]:
        """Build the same cases with other values at some paths; None for an invalid case. The result is cached."""
        key = tuple(values.items())
        if key not in self.variants:
            self.variants[key] = self._cases_with(values)
        return self.variants[key]

    def _cases_with(self, values: Mapping[str, str]) -> list[Case | None]:
        key_paths = {path: self.locate(path) for path in values}
        changed = CaseBuilder(self.base, self.folder, self.key_paths | key_paths)
        changes = [(path, Node(text, self.base.mark)) for path, text in values.items()]
        cases: dict[str, Case | None] = {}
        for row in self.builder.rows(combinations(self.axes)):
            case = self.builder.case(row)
            if case is not None:
                unchanged = [pair for pair in row if self.key_paths[pair[0]] not in key_paths.values()]
                cases.setdefault(identity(case), changed.case(unchanged + changes))
        return list(cases.values())

    def entries(self) -> dict[str, Node]:
        """Return the swept and derived paths, each with its entry in the file."""
        swept = {path: node for axis in self.axes for path, node in zip(axis.paths, axis.keys, strict=True)}
        return swept | {derived.path: derived.entry for derived in self.relations.derived}

    def units(self) -> dict[str, str]:
        """Return the unit of the first value of each swept path; empty for words."""
        first_values = {
            path: node for axis in self.axes for path, node in zip(axis.paths, axis.rows[0], strict=True)
        }
        derived = {relation.path: relation.unit for relation in self.relations.derived}
        return {path: unit_of(path, node) for path, node in first_values.items()} | derived

    def all_problems(self) -> list[Problem]:
        """List all problems, except for values that are missing because their sweep is invalid."""
        invalid, problems = self.named_paths - self.key_paths.keys(), self.case_problems.items()
        return self.problems + [
            p for (_, path, kind), p in problems if not (kind == "missing" and path in invalid)
        ]
