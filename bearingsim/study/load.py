"""A study file in, a checked `Study` out, or every problem at once."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import NamedTuple

from bearingsim import extensions
from bearingsim.config.fields import described
from bearingsim.study import aliases
from bearingsim.study.figures import check_known, parse_figures
from bearingsim.study.goal import asks_for_reference, check_goal, parse_goal
from bearingsim.study.jobs import Study
from bearingsim.study.plan import Plan
from bearingsim.study.uncertainty import check_possible, parse_uncertainty
from bearingsim.text import files_read
from bearingsim.text.yamlfile import Node, Problem, StudyError, argument_mark, parse, problem, read_text

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}", re.ASCII)


def load_study(path: str | FilePath, overrides: Mapping[str, str] | None = None, quick: bool = False) -> Study:
    """Read and check a study file.

    `overrides` maps paths to values as they would stand in the file (`{"load": "200 N"}`); `quick` takes the
    file's reduced grid, if it has one. Raises StudyError with everything that is wrong, BrokenExtension.
    """
    extensions.refuse_broken()
    opened = _opened(FilePath(path), overrides or {})
    text, root, whole, plans = opened.text, opened.root, opened.whole, opened.plans
    given, problems = opened.given, list(opened.flaws)
    cases = [plan.cases() for plan in plans]
    swept = {path: node for plan in plans for path, node in plan.entries().items()}
    uncertain = parse_uncertainty(root.mapping.get("uncertainty"), problems)
    wrong = sorted({path for plan in plans for path in plan.asked} - swept.keys())  # told where they are swept
    figures = parse_figures(root.mapping.get("figures"), [*swept, *wrong], problems)
    name = _name(root, problems)
    goal = parse_goal(whole.mapping.get("accuracy"), figures, problems)
    if all(cases):
        models = {case.model for found in cases for case, _ in found}
        check_known(root.mapping.get("figures"), models, problems)
        own, named = [case for case, _ in cases[0]], "accuracy" not in whole.mapping
        check_possible(root.mapping.get("uncertainty"), own, uncertain or (), problems, named)
        if goal is not None:
            check_goal(whole, [case for found in cases for case, _ in found], swept, given, problems)
    problems += [found for plan in plans for found in plan.all_problems()]
    if problems:
        raise StudyError(_in_order(problems, str(path)))
    reduced = quick and "quick" in root.mapping
    chosen = -1 if reduced else 0
    units, swept_cases = plans[chosen].units(), tuple(cases[chosen])
    tried = () if reduced and uncertain else uncertain  # a first look tries nothing else
    drawn = plans[chosen].drawn
    told = (*opened.notes, *(drawn.notes() if drawn is not None else ()))
    study = Study(name, str(path), text, given, reduced, figures, units, swept_cases, told, tried, opened.files)
    study = replace(study, drawn=drawn)
    if goal is None:
        return study
    return replace(study, goal=goal, otherwise=plans[chosen].otherwise)


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
        whole, root = root, asks_for_reference(root) if "accuracy" in root.mapping else root
        # Both are checked, so that a mistake in `quick` is told now and not when it is first used.
        modes = (False, True) if "quick" in root.mapping else (False,)
        plans = [Plan.of(root, path.parent, given, reduced) for reduced in modes]
        for plan in plans:
            plan.open_files()
    return _Opened(text, whole, root, flaws, notes, given, plans, files)


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
