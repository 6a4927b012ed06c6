"""Trials of models, and what was chosen by them: plain JSON, each file whole or absent.

``trials/<unit>.json`` holds the trials of a unit of work, ``choices.json`` one choice for each case, and
what names the plan of the study that it was made for.
"""

from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from bearingsim.errors import UserError
from bearingsim.selection import Choice, Choices
from bearingsim.simulation.trial import Trial
from bearingsim.store import layouts, own_files
from bearingsim.store.files import lock, write_bytes
from bearingsim.store.layouts import check
from bearingsim.store.regular import Unreadable, read_regular
from bearingsim.store.sealed import UNREADABLE, read_json, write_json

__all__ = [
    "DamagedChoices",
    "add_choices",
    "copy_trials",
    "read_choices",
    "read_plans",
    "read_trials",
    "write_choices",
    "write_trials",
]

CHOICES, TRIALS, PLAN = "choices.json", "trials", "plan"


class DamagedChoices(UserError):
    """``choices.json`` cannot be read: who decided, and what, is not known."""


def write_trials(root: Path, unit: str, found: Mapping[str, Trial | None]) -> None:
    """Write the trials of a unit, by id; None for one that failed."""
    told = {name: None if one is None else _plain(one) for name, one in found.items()}
    write_json(root / TRIALS / f"{unit}.json", {TRIALS: told}, indent=None)


def read_trials(root: Path, asked: Collection[str] = ()) -> dict[str, Trial | None]:
    """All trials of a folder that have the features ``asked``, by id.

    A file that cannot be read, and a trial without these features, count as absent: they are made again.
    """
    found: dict[str, Trial | None] = {}
    for path in own_files.TRIALS.of(root):
        try:
            told = read_json(path)
            told = told[TRIALS]
            check(layouts.Trials, told)
            trials = {name: None if one is None else _trial(one) for name, one in told.items()}
        except UNREADABLE:
            continue
        found |= {name: one for name, one in trials.items() if one is None or one.tells(asked)}
    return found


def copy_trials(source: Path, root: Path) -> None:
    """Copy the trials of another results folder, less those that are there, or cannot be read.

    A file of the same name stays as it is, and is not compared: its trials are of the same cases.
    """
    for path in own_files.TRIALS.of(source):
        with suppress(*UNREADABLE):
            read_json(path)
            if not (root / TRIALS / path.name).exists():
                write_bytes(root / TRIALS / path.name, read_regular(path))


def _plain(one: Trial) -> dict[str, Any]:
    lines = {name: [[a.real, a.imag] for a in parts.tolist()] for name, parts in one.lines.items()}
    powers = {name: parts.tolist() for name, parts in one.powers.items()}
    told = {"passes": one.passes, "turns": one.turns, "repeats": one.repeats, "forces": one.forces.tolist()}
    return told | {"lines": lines, "powers": powers, "method": one.method, "step": one.step}


def _trial(told: Mapping[str, Any]) -> Trial:
    lines = {name: np.array([complex(*pair) for pair in parts]) for name, parts in told["lines"].items()}
    powers = {name: np.array(parts) for name, parts in told["powers"].items()}
    stepped = told.get("method", ""), told.get("step", 0.0)
    trial = Trial(
        told["passes"], told["turns"], told["repeats"], lines, powers, np.array(told["forces"]), *stepped
    )
    if not trial.is_whole:
        raise Unreadable("the parts of a trial do not fit each other")
    return trial


def write_choices(root: Path, choices: Choices, plans: Mapping[str, str] | None = None) -> None:
    """Write what was chosen, all at once; plans: what names the plan that each choice was made for."""
    named = plans or {}
    told = {name: asdict(one) | {PLAN: named.get(name, "")} for name, one in sorted(choices.items())}
    write_json(root / CHOICES, {"choices": told})


def add_choices(root: Path, found: Choices, plan: str) -> tuple[Choices, dict[str, str]]:
    """Add choices made for a plan to those of a folder, which stay; all choices, and what names the plan of each.

    Raises DamagedChoices.
    """
    with lock(root):
        choices, plans = found | read_choices(root), dict.fromkeys(found, plan) | read_plans(root)
        write_choices(root, choices, plans)
    return choices, plans


def read_choices(root: Path) -> Choices:
    """What was chosen in a folder; nothing yet if it has no ``choices.json``. Raises DamagedChoices."""
    return {name: choice for name, (choice, _) in _read(root).items()}


def read_plans(root: Path) -> dict[str, str]:
    """What names the plan of the study that each choice in a folder was made for. Raises DamagedChoices."""
    return {name: plan for name, (_, plan) in _read(root).items()}


def _read(root: Path) -> dict[str, tuple[Choice, str]]:
    path = root / CHOICES
    try:
        told = read_json(path)
        told = told.get("choices", told)
        check(layouts.Choices, told)
        return {name: _choice(one) for name, one in told.items()}
    except FileNotFoundError:
        return {}
    except UNREADABLE as error:
        raise DamagedChoices(
            f"{path} cannot be read ({error}): put it back, or remove it to decide again (results stay)"
        ) from error


def _choice(told: dict[str, Any]) -> tuple[Choice, str]:
    plan = told.pop(PLAN, "")
    return Choice(**told), str(plan)
