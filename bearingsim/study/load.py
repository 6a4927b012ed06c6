"""Loading of study files: a validated `Study`, or all problems at once."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from os.path import exists
from pathlib import Path as FilePath
from typing import NamedTuple

from bearingsim import extensions
from bearingsim.catalogue import REFERENCE
from bearingsim.config import Case
from bearingsim.config.case_fields import DEPRECATED_KEYS
from bearingsim.config.fields import describe_value
from bearingsim.shipped import matching_studies
from bearingsim.study.case_builder import SweptValues
from bearingsim.study.figures import Figure, band_features, check_computed, check_recorded, parse_figures
from bearingsim.study.goal import Goal, add_early_end, check_goal, parse_goal, with_reference_model
from bearingsim.study.jobs import Study
from bearingsim.study.measured_values import MeasuredSet
from bearingsim.study.paths import intended_paths
from bearingsim.study.plan import Plan
from bearingsim.study.uncertainty import UncertainParameter, check_uncertainty, parse_uncertainty
from bearingsim.text import files_read
from bearingsim.text.units import suggestion
from bearingsim.text.yamlfile import Mark, Node, Problem, StudyError, argument_mark, parse, problem, read_text

STUDY_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}", re.ASCII)
"""Pattern of the name of a study, which is also that of its results folder."""
PATH_KEYS = ("x", "by", "panels")
"""Keys of a figure whose values are paths of the study."""


def load_study(
    path: str | FilePath,
    overrides: Mapping[str, str] | None = None,
    quick: bool = False,
    on_count: Callable[[int], None] | None = None,
) -> Study:
    """Read and validate a study file.

    `overrides` maps paths to values as written in a file, such as `{"load": "200 N"}`; `quick` selects the reduced
    grid of the file, if it has one; `on_count` is called with the number of combinations before all of them are
    validated. A sample of the cases is validated first, so that most problems are reported without building all
    cases. Raises StudyError with every problem, and BrokenExtension.
    """
    extensions.raise_if_broken()
    file = _open(FilePath(path), overrides or {})
    settings = _settings(file)
    samples = [plan.sample_cases() for plan in file.plans]
    _check(file, settings, samples[0], [case for sample in samples for case in sample] if all(samples) else [])
    for plan in file.plans:
        plan.check_settings()
    _raise_problems(file, settings)
    reduced = quick and "quick" in file.root.mapping
    plan = file.plans[-1 if reduced else 0]
    if on_count is not None:
        on_count(plan.count)
    swept_cases = tuple(plan.cases())
    _raise_problems(file, settings)
    cases = [case for case, _ in swept_cases]
    _check(file, settings, [] if reduced else cases, cases)
    if REFERENCE in settings.models:
        models = {case.model for case in (*cases, *(case for sample in samples for case in sample))}
        check_computed(file.root.mapping.get("figures"), models, settings.problems)
    check_recorded(file.root.mapping.get("figures"), cases, settings.problems)
    measured, remarks = _measured(file, plan, swept_cases, settings.problems)
    _raise_problems(file, settings)
    study = Study(
        name=settings.name,
        path=str(path),
        text=file.text,
        overrides=file.overrides,
        quick=reduced,
        figures=settings.figures,
        units=plan.units(),
        swept_cases=swept_cases,
        notes=(*file.notes, *plan.notes, *_design_notes(plan), *plan.repetition_notes(), *remarks),
        uncertainty=()
        if reduced and settings.uncertain
        else settings.uncertain,  # no variations of a reduced grid
        left_out=(settings.uncertain or ()) if reduced else (),
        files=file.files,
        sampled_design=plan.sampled_design,
        measured=measured,
        cases_with=plan.cases_with,
    )
    return study if settings.goal is None else _with_goal(study, settings.goal, plan)


def _design_notes(plan: Plan) -> Iterator[str]:
    """Yield the remarks on the design of a study, if it has one."""
    if plan.sampled_design is not None:
        yield from plan.sampled_design.notes()


def _measured(
    file: "_StudyFile", plan: Plan, swept_cases: Sequence[tuple[Case, SweptValues]], problems: list[Problem]
) -> tuple[tuple[MeasuredSet, ...], tuple[str, ...]]:
    """Read the measured values of a study, if it has any, with remarks on them."""
    if "measured" not in file.root.mapping:
        return (), ()
    from bearingsim.study.measured import Cases, parse_measured  # imports h5py

    cases = Cases(swept_cases, plan.locate, plan.swept_spelling, tuple(band_features(file.root)))
    return parse_measured(file.root.mapping["measured"], FilePath(file.path).parent, cases, problems)


def _measured_files(root: Node, folder: FilePath) -> Iterator[FilePath]:
    """Yield the possible paths of the files of measured values, whether or not they exist: in the working
    directory, and in the folder of the study."""
    section = root.mapping.get("measured")
    for entry in section.items if section is not None else ():
        signals = entry.mapping.get("signals")
        named = [item.mapping.get("file") for item in signals.items] if signals is not None else []
        for name in (entry.mapping.get("points"), *named):
            if name is not None and isinstance(name.value, str):
                yield from (FilePath() / name.value, folder / name.value)


def _with_goal(study: Study, goal: Goal, plan: Plan) -> Study:
    """Add the accuracy to a study; records end early once their standard errors are well below it."""

    variants: dict[tuple[tuple[str, str], ...], list[Case | None]] = {}  # cache: changes recur for each case

    def cases_with(changes: Mapping[str, str]) -> list[Case | None]:
        key = tuple(changes.items())
        if key not in variants:
            variants[key] = [
                case and add_early_end(case, goal, study.figures) for case in plan.cases_with(changes)
            ]
        return variants[key]

    swept = tuple((add_early_end(case, goal, study.figures), values) for case, values in study.swept_cases)
    return replace(study, swept_cases=swept, goal=goal, cases_with=cases_with)


class _Settings(NamedTuple):
    """Settings of a study apart from its cases, the models that it names, and the problems so far."""

    name: str
    figures: tuple[Figure, ...]
    uncertain: tuple[UncertainParameter, ...] | None
    goal: Goal | None
    swept: dict[str, Node]
    models: set[str]
    problems: list[Problem]


def _settings(file: "_StudyFile") -> _Settings:
    """Parse the settings of a study apart from its cases, which is fast."""
    problems, plans, entries = list(file.syntax_problems), file.plans, file.root.mapping
    swept = {path: node for plan in plans for path, node in plan.entries().items()}
    parameters = parse_uncertainty(entries.get("uncertainty"), problems)
    # Invalid and misspelt paths are reported with the sweep.
    invalid = sorted({path for plan in plans for path in plan.named_paths} - swept.keys())
    intended = [path for entry in (*swept, *invalid) for path in intended_paths(entry)]
    figures = parse_figures(entries.get("figures"), [*swept, *invalid, *intended], problems)
    name = _name(file.root, problems)
    goal = parse_goal(file.source.mapping.get("accuracy"), figures, problems)
    models = {model for plan in plans for model in plan.models()}
    if REFERENCE not in models:
        check_computed(entries.get("figures"), models, problems)
    return _Settings(name, figures, parameters, goal, swept, models, problems)


def _check(
    file: "_StudyFile", settings: _Settings, varied_cases: Sequence[Case], goal_cases: Sequence[Case]
) -> None:
    """Add the problems of cases.

    varied_cases: cases that `uncertainty` varies; goal_cases: cases that `accuracy` concerns.
    """
    has_models = "accuracy" not in file.source.mapping
    check_uncertainty(
        file.root.mapping.get("uncertainty"), varied_cases, settings.uncertain or (), settings.problems, has_models
    )
    if settings.goal is not None and goal_cases:
        check_goal(file.source, goal_cases, settings.swept, file.overrides, settings.problems)


def _raise_problems(file: "_StudyFile", settings: _Settings) -> None:
    """Raise StudyError if there are problems so far."""
    problems = [*settings.problems, *(entry for plan in file.plans for entry in plan.all_problems())]
    if problems:
        raise StudyError(_sort(problems, file.path))


class Outline(NamedTuple):
    """Properties of a study that are known before its cases are built.

    files: all files that it reads or looks for; cases: number of its cases before `where` leaves some out.
    """

    name: str
    overrides: dict[str, str]
    quick: bool
    files: Mapping[str, str | None]
    cases: int


def read_outline(path: FilePath, overrides: Mapping[str, str], quick: bool) -> Outline | None:
    """Read the outline of a study file; None if the file has problems."""
    try:
        file = _open(path, overrides)
    except StudyError:
        return None
    name = file.root.mapping.get("study")
    if file.syntax_problems or name is None:
        return None
    reduced = quick and "quick" in file.root.mapping
    return Outline(name.text, file.overrides, reduced, file.files, file.plans[-1 if reduced else 0].count)


class _StudyFile(NamedTuple):
    """Opened study file: its tree as written (``source``) and as computed (``root``), and its plans.

    overrides: values that replace those of the file, by path.
    """

    path: str
    text: str
    source: Node
    root: Node
    syntax_problems: Sequence[Problem]
    notes: tuple[str, ...]
    overrides: dict[str, str]
    plans: list[Plan]
    files: Mapping[str, str | None]


def _missing_file_hint(path: FilePath) -> str:
    """Return a hint for a missing file: the shipped study of its name if there is one, else a similar file."""
    matches = matching_studies(path.name)
    if len(matches) == 1:
        return f"a shipped study has this name: `bearingsim new --from {matches[0]}`"
    with suppress(OSError):  # a name longer than the file system allows
        return suggestion(str(path), [str(file) for file in path.parent.glob("*.y*ml")])
    return ""


def _open(path: FilePath, overrides: Mapping[str, str]) -> _StudyFile:
    with files_read.recorded_files() as files:
        files_read.record(path)
        if not exists(path) and (hint := _missing_file_hint(path)):
            raise StudyError([problem(Mark(str(path)), "no such file", hint)])
        text = read_text(path)
        root, syntax_problems = parse(text, str(path))
        if not isinstance(root.value, dict):
            raise StudyError(
                [*syntax_problems, problem(root.mark, "expected `key: value` lines, as `bearingsim new` writes")]
            )
        notes, root = _notes_on(root, overrides), _rename_keys(root)
        new_overrides = {_new_path(path): value for path, value in _texts(overrides).items()}
        bands = band_features(root)
        source, root = root, with_reference_model(root) if "accuracy" in root.mapping else root
        # Both are checked, so that a problem in `quick` is reported now and not at its first use.
        modes = (False, True) if "quick" in root.mapping else (False,)
        plans = [Plan.build(root, path.parent, new_overrides, reduced, bands) for reduced in modes]
        for plan in plans:
            plan.open_files()
        for named_file in _measured_files(root, path.parent):
            files_read.record(named_file)
    return _StudyFile(str(path), text, source, root, syntax_problems, notes, new_overrides, plans, files)


def _rename_keys(node: Node, is_path: bool = False) -> Node:
    """Replace deprecated keys in a file: keys of sections, paths of a sweep and paths of figures."""
    if isinstance(node.value, dict):
        new = {key: _new_path(key) for key in node.value}
        # A file with both keys is rejected by the validation of the case.
        new_keys = {key: key if new_key in node.value else new_key for key, new_key in new.items()}
        return replace(
            node, value={new_keys[key]: _rename_keys(inner, key in PATH_KEYS) for key, inner in node.value.items()}
        )
    if isinstance(node.value, tuple):
        return replace(node, value=tuple(_rename_keys(inner, is_path) for inner in node.value))
    return replace(node, value=_new_path(node.value)) if is_path else node


def _new_path(path: str) -> str:
    """Replace a deprecated key at the beginning of a path."""
    head, dot, rest = path.partition(".")
    return DEPRECATED_KEYS.get(head, head) + dot + rest


def _notes_on(root: Node, overrides: Mapping[str, str]) -> tuple[str, ...]:
    """List a note for each deprecated key in a file and its overrides."""
    keys = {*_keys(root), *overrides}
    replaced = {old: new for old, new in DEPRECATED_KEYS.items() if old in keys}
    return tuple(f"`{old}` is now `{new}`; the old word is still read" for old, new in replaced.items())


def _keys(node: Node) -> set[str]:
    return set(node.mapping).union(*map(_keys, [*node.mapping.values(), *node.items]))


def _texts(overrides: Mapping[str, str]) -> dict[str, str]:
    """Return the overrides as a dictionary. Raises StudyError for paths or values that are not strings."""
    problems = [
        problem(
            argument_mark(f"--set {path}={value}", len("--set ") + 1),
            f"{path}: expected an override as text, as in the file, got {describe_value(value)}",
            'as in `{"load": "200 N"}`',
        )
        for path, value in overrides.items()
        if not isinstance(value, str) or not isinstance(path, str)
    ]
    if problems:
        raise StudyError(problems)
    return dict(overrides)


def _name(root: Node, problems: list[Problem]) -> str:
    node = root.mapping.get("study")
    if node is None:
        problems.append(problem(root.mark, "`study` is missing", "give the study a name, as in `study: first`"))
        return ""
    if not isinstance(node.value, str) or not STUDY_NAME.fullmatch(node.value):
        message = f"study: expected a name of letters, digits, `-`, `_` and `.`, got `{node.text}`"
        problems.append(problem(node.mark, message))
    return node.text


def _sort(problems: Iterable[Problem], path: str) -> list[Problem]:
    """Sort problems by their position in the file, without duplicates; problems of other files follow."""
    return sorted(dict.fromkeys(problems), key=lambda p: (p.file != path, p.file, p.line, p.column))
