"""Loading of study files: a validated `Study`, or all problems at once."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import NamedTuple

from bearingsim import extensions
from bearingsim.catalogue import REFERENCE
from bearingsim.config import Case
from bearingsim.config.case_fields import OLD_WORDS
from bearingsim.config.fields import described
from bearingsim.study.figures import Figure, band_features, check_known, parse_figures
from bearingsim.study.goal import Goal, asks_for_reference, check_goal, ended_early, parse_goal
from bearingsim.study.jobs import Study
from bearingsim.study.plan import Plan
from bearingsim.study.uncertainty import Uncertain, check_possible, parse_uncertainty
from bearingsim.text import files_read
from bearingsim.text.yamlfile import Node, Problem, StudyError, argument_mark, parse, problem, read_text

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}", re.ASCII)
PATH_KEYS = ("x", "by", "panels")
"""Keys of a figure whose values are paths of the study."""


def load_study(
    path: str | FilePath,
    overrides: Mapping[str, str] | None = None,
    quick: bool = False,
    reading: Callable[[int], None] | None = None,
) -> Study:
    """Read and validate a study file.

    `overrides` maps paths to values as written in a file, such as `{"load": "200 N"}`; `quick` selects the reduced
    grid of the file, if it has one; `reading` is called with the number of combinations before all of them are
    validated. A sample of the cases is validated first, so that most problems are reported without building all
    cases. Raises StudyError with every problem, and BrokenExtension.
    """
    extensions.refuse_broken()
    opened = _opened(FilePath(path), overrides or {})
    settings = _settings(opened)
    samples = [plan.first_look() for plan in opened.plans]
    _check(opened, settings, samples[0], [case for sample in samples for case in sample] if all(samples) else [])
    for plan in opened.plans:
        plan.check_words()
    _refuse(opened, settings)
    reduced = quick and "quick" in opened.root.mapping
    plan = opened.plans[-1 if reduced else 0]
    if reading is not None:
        reading(plan.count)
    swept_cases = tuple(plan.cases())
    _refuse(opened, settings)
    cases = [case for case, _ in swept_cases]
    _check(opened, settings, [] if reduced else cases, cases)
    if REFERENCE in settings.models:
        models = {case.model for case in (*cases, *(case for sample in samples for case in sample))}
        check_known(opened.root.mapping.get("figures"), models, settings.problems)
    _refuse(opened, settings)
    study = Study(
        name=settings.name,
        path=str(path),
        text=opened.text,
        overrides=opened.overrides,
        quick=reduced,
        figures=settings.figures,
        units=plan.units(),
        swept_cases=swept_cases,
        notes=(*opened.notes, *(plan.drawn.notes() if plan.drawn is not None else ())),
        uncertainty=()
        if reduced and settings.uncertain
        else settings.uncertain,  # no variations of a reduced grid
        left_out=(settings.uncertain or ()) if reduced else (),
        files=opened.files,
        drawn=plan.drawn,
    )
    return study if settings.goal is None else _with_goal(study, settings.goal, plan)


def _with_goal(study: Study, goal: Goal, plan: Plan) -> Study:
    """Add the accuracy to a study; records end early once their standard errors are well below it."""

    def otherwise(changes: Mapping[str, str]) -> list[Case | None]:
        return [case and ended_early(case, goal, study.figures) for case in plan.otherwise(changes)]

    swept = tuple((ended_early(case, goal, study.figures), values) for case, values in study.swept_cases)
    return replace(study, swept_cases=swept, goal=goal, otherwise=otherwise)


class _Settings(NamedTuple):
    """Settings of a study apart from its cases, the models that it names, and the problems so far."""

    name: str
    figures: tuple[Figure, ...]
    uncertain: tuple[Uncertain, ...] | None
    goal: Goal | None
    swept: dict[str, Node]
    models: set[str]
    problems: list[Problem]


def _settings(opened: "_Opened") -> _Settings:
    """Parse the settings of a study apart from its cases, which is fast."""
    problems, plans, entries = list(opened.flaws), opened.plans, opened.root.mapping
    swept = {path: node for plan in plans for path, node in plan.entries().items()}
    uncertain = parse_uncertainty(entries.get("uncertainty"), problems)
    wrong = sorted({path for plan in plans for path in plan.named} - swept.keys())  # reported with the sweep
    figures = parse_figures(entries.get("figures"), [*swept, *wrong], problems)
    name = _name(opened.root, problems)
    goal = parse_goal(opened.whole.mapping.get("accuracy"), figures, problems)
    models = {model for plan in plans for model in plan.models()}
    if REFERENCE not in models:
        check_known(entries.get("figures"), models, problems)
    return _Settings(name, figures, uncertain, goal, swept, models, problems)


def _check(opened: "_Opened", settings: _Settings, own: Sequence[Case], every: Sequence[Case]) -> None:
    """Add the problems of cases; own: cases that `uncertainty` varies; every: cases that `accuracy` concerns."""
    named = "accuracy" not in opened.whole.mapping
    check_possible(opened.root.mapping.get("uncertainty"), own, settings.uncertain or (), settings.problems, named)
    if settings.goal is not None and every:
        check_goal(opened.whole, every, settings.swept, opened.overrides, settings.problems)


def _refuse(opened: "_Opened", settings: _Settings) -> None:
    """Raise StudyError if there are problems so far."""
    problems = [*settings.problems, *(entry for plan in opened.plans for entry in plan.all_problems())]
    if problems:
        raise StudyError(_in_order(problems, opened.path))


class Outline(NamedTuple):
    """Properties of a study that are known before its cases are built; ``files``: all files that it reads."""

    name: str
    overrides: dict[str, str]
    quick: bool
    files: Mapping[str, str | None]


def outline(path: FilePath, overrides: Mapping[str, str], quick: bool) -> Outline | None:
    """Read the outline of a study file; None if the file has problems."""
    try:
        opened = _opened(path, overrides)
    except StudyError:
        return None
    named = opened.root.mapping.get("study")
    if opened.flaws or named is None:
        return None
    return Outline(named.text, opened.overrides, quick and "quick" in opened.root.mapping, opened.files)


class _Opened(NamedTuple):
    """Opened study file: its tree as written (``whole``) and as computed (``root``), and its plans.

    overrides: values that replace those of the file, by path.
    """

    path: str
    text: str
    whole: Node
    root: Node
    flaws: Sequence[Problem]
    notes: tuple[str, ...]
    overrides: dict[str, str]
    plans: list[Plan]
    files: Mapping[str, str | None]


def _opened(path: FilePath, overrides: Mapping[str, str]) -> _Opened:
    with files_read.noted() as files:
        files_read.note(path)
        text = read_text(path)
        root, flaws = parse(text, str(path))
        if not isinstance(root.value, dict):
            raise StudyError(
                [*flaws, problem(root.mark, "expected `key: value` lines, as `bearingsim new` writes")]
            )
        notes, root = _notes_on(root, overrides), _renamed(root)
        renamed = {_new_path(path): value for path, value in _texts(overrides).items()}
        computed = band_features(root)
        whole, root = root, asks_for_reference(root) if "accuracy" in root.mapping else root
        # Both are checked, so that a problem in `quick` is reported now and not at its first use.
        modes = (False, True) if "quick" in root.mapping else (False,)
        plans = [Plan.of(root, path.parent, renamed, reduced, computed) for reduced in modes]
        for plan in plans:
            plan.open_files()
    return _Opened(str(path), text, whole, root, flaws, notes, renamed, plans, files)


def _renamed(node: Node, is_path: bool = False) -> Node:
    """Replace deprecated keys in a file: keys of sections, paths of a sweep and paths of figures."""
    if isinstance(node.value, dict):
        new = {key: _new_path(key) for key in node.value}
        # A file with both keys is rejected by the validation of the case.
        kept = {key: key if word in node.value else word for key, word in new.items()}
        return replace(
            node, value={kept[key]: _renamed(inner, key in PATH_KEYS) for key, inner in node.value.items()}
        )
    if isinstance(node.value, tuple):
        return replace(node, value=tuple(_renamed(inner, is_path) for inner in node.value))
    return replace(node, value=_new_path(node.value)) if is_path else node


def _new_path(path: str) -> str:
    """Replace a deprecated first word of a path such as `defect.width`."""
    head, dot, rest = path.partition(".")
    return OLD_WORDS.get(head, head) + dot + rest


def _notes_on(root: Node, overrides: Mapping[str, str]) -> tuple[str, ...]:
    """List a note for each deprecated key in a file and its overrides."""
    keys = {*_keys(root), *overrides}
    replaced = {old: new for old, new in OLD_WORDS.items() if old in keys}
    return tuple(f"`{old}` is now `{new}`; the old word is still read" for old, new in replaced.items())


def _keys(node: Node) -> set[str]:
    return set(node.mapping).union(*map(_keys, [*node.mapping.values(), *node.items]))


def _texts(overrides: Mapping[str, str]) -> dict[str, str]:
    """Return the overrides as a dictionary. Raises StudyError for paths or values that are not strings."""
    wrong = [
        problem(
            argument_mark(f"--set {path}={value}", len("--set ") + 1),
            f"{path}: an override is a text as it would stand in the file, got {described(value)}",
            'as in `{"load": "200 N"}`',
        )
        for path, value in overrides.items()
        if not isinstance(value, str) or not isinstance(path, str)
    ]
    if wrong:
        raise StudyError(wrong)
    return dict(overrides)


def _name(root: Node, problems: list[Problem]) -> str:
    node = root.mapping.get("study")
    if node is None:
        problems.append(problem(root.mark, "`study` is missing", "give the study a name, as in `study: first`"))
        return ""
    if not isinstance(node.value, str) or not NAME.fullmatch(node.value):
        message = f"study: expected a name of letters, digits, `-`, `_` and `.`, got `{node.text}`"
        problems.append(problem(node.mark, message))
    return node.text


def _in_order(problems: Iterable[Problem], main: str) -> list[Problem]:
    """Sort problems by their position in the file, without duplicates; problems of other files follow."""
    return sorted(dict.fromkeys(problems), key=lambda p: (p.file != main, p.file, p.line, p.column))
