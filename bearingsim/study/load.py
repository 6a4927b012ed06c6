"""A study file in, a checked `Study` out, or every problem at once."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import NamedTuple

from bearingsim import extensions
from bearingsim.catalogue import REFERENCE
from bearingsim.config import Case
from bearingsim.config.fields import described
from bearingsim.study import aliases
from bearingsim.study.figures import check_known, of_bands, parse_figures
from bearingsim.study.goal import Goal, asks_for_reference, check_goal, parse_goal
from bearingsim.study.jobs import Figure, Study
from bearingsim.study.plan import Plan
from bearingsim.study.uncertainty import Uncertain, check_possible, parse_uncertainty
from bearingsim.text import files_read
from bearingsim.text.yamlfile import Node, Problem, StudyError, argument_mark, parse, problem, read_text

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}", re.ASCII)


def load_study(
    path: str | FilePath,
    overrides: Mapping[str, str] | None = None,
    quick: bool = False,
    reading: Callable[[int], None] | None = None,
) -> Study:
    """Read and check a study file.

    `overrides` maps paths to values as they would stand in the file (`{"load": "200 N"}`); `quick` takes the
    file's reduced grid, if it has one; `reading` is called with the number of combinations before all of them are
    read. Raises StudyError with what is wrong, and BrokenExtension. What a few cases show is refused before the
    others are read.
    """
    extensions.refuse_broken()
    opened = _opened(FilePath(path), overrides or {})
    said = _said(opened)
    looks = [plan.first_look() for plan in opened.plans]
    _check(opened, said, looks[0], [case for look in looks for case in look] if all(looks) else [])
    for plan in opened.plans:
        plan.check_words()
    _refuse(opened, said)
    reduced = quick and "quick" in opened.root.mapping
    plan = opened.plans[-1 if reduced else 0]
    if reading is not None:
        reading(plan.count)
    swept_cases = tuple(plan.cases())
    _refuse(opened, said)
    cases = [case for case, _ in swept_cases]
    _check(opened, said, [] if reduced else cases, cases)
    if REFERENCE in said.models:
        known = {case.model for case in (*cases, *(case for look in looks for case in look))}
        check_known(opened.root.mapping.get("figures"), known, said.problems)
    _refuse(opened, said)
    study = Study(
        name=said.name,
        path=str(path),
        text=opened.text,
        overrides=opened.given,
        quick=reduced,
        figures=said.figures,
        units=plan.units(),
        swept_cases=swept_cases,
        notes=(*opened.notes, *(plan.drawn.notes() if plan.drawn is not None else ())),
        uncertainty=() if reduced and said.uncertain else said.uncertain,  # a first look tries nothing else
        left_out=(said.uncertain or ()) if reduced else (),
        files=opened.files,
        drawn=plan.drawn,
    )
    return study if said.goal is None else replace(study, goal=said.goal, otherwise=plan.otherwise)


class _Said(NamedTuple):
    """What a study says besides its cases, the models that it names, and what is wrong so far."""

    name: str
    figures: tuple[Figure, ...]
    uncertain: tuple[Uncertain, ...] | None
    goal: Goal | None
    swept: dict[str, Node]
    models: set[str]
    problems: list[Problem]


def _said(opened: "_Opened") -> _Said:
    """What a study says besides its cases; what is wrong with it costs nothing to find."""
    problems, plans, entries = list(opened.flaws), opened.plans, opened.root.mapping
    swept = {path: node for plan in plans for path, node in plan.entries().items()}
    uncertain = parse_uncertainty(entries.get("uncertainty"), problems)
    wrong = sorted({path for plan in plans for path in plan.asked} - swept.keys())  # told where they are swept
    figures = parse_figures(entries.get("figures"), [*swept, *wrong], problems)
    name = _name(opened.root, problems)
    goal = parse_goal(opened.whole.mapping.get("accuracy"), figures, problems)
    models = {model for plan in plans for model in plan.models()}
    if REFERENCE not in models:
        check_known(entries.get("figures"), models, problems)
    return _Said(name, figures, uncertain, goal, swept, models, problems)


def _check(opened: "_Opened", said: _Said, own: Sequence[Case], every: Sequence[Case]) -> None:
    """Note what cannot be with some cases: own: those that `uncertainty` varies; every: those of an accuracy."""
    named = "accuracy" not in opened.whole.mapping
    check_possible(opened.root.mapping.get("uncertainty"), own, said.uncertain or (), said.problems, named)
    if said.goal is not None and every:
        check_goal(opened.whole, every, said.swept, opened.given, said.problems)


def _refuse(opened: "_Opened", said: _Said) -> None:
    """Raise StudyError if anything is wrong so far."""
    problems = [*said.problems, *(found for plan in opened.plans for found in plan.all_problems())]
    if problems:
        raise StudyError(_in_order(problems, opened.path))


class Outline(NamedTuple):
    """What is known of a study before its cases are made: ``files`` are those that it is made of."""

    name: str
    overrides: dict[str, str]
    quick: bool
    files: Mapping[str, str | None]


def outline(path: FilePath, overrides: Mapping[str, str], quick: bool) -> Outline | None:
    """That of a study file; None of one in which something is wrong."""
    try:
        opened = _opened(path, overrides)
    except StudyError:
        return None
    named = opened.root.mapping.get("study")
    if opened.flaws or named is None:
        return None
    return Outline(named.text, opened.given, quick and "quick" in opened.root.mapping, opened.files)


class _Opened(NamedTuple):
    """A study file: its tree as written (``whole``) and as it is computed, its plans without and with `quick`.

    given: what is said instead of the file's values.
    """

    path: str
    text: str
    whole: Node
    root: Node
    flaws: Sequence[Problem]
    notes: tuple[str, ...]
    given: dict[str, str]
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
        notes, root = aliases.notes(root, overrides), aliases.renamed(root)
        given = {aliases.new_path(path): value for path, value in _texts(overrides).items()}
        computed = of_bands(root)
        whole, root = root, asks_for_reference(root) if "accuracy" in root.mapping else root
        # Both are checked, so that a mistake in `quick` is told now and not when it is first used.
        modes = (False, True) if "quick" in root.mapping else (False,)
        plans = [Plan.of(root, path.parent, given, reduced, computed) for reduced in modes]
        for plan in plans:
            plan.open_files()
    return _Opened(str(path), text, whole, root, flaws, notes, given, plans, files)


def _texts(overrides: Mapping[str, str]) -> dict[str, str]:
    """The overrides. Raises StudyError for those from Python that are no texts."""
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
    """Each problem once, in the order of the file; other files after it."""
    return sorted(dict.fromkeys(problems), key=lambda p: (p.file != main, p.file, p.line, p.column))
