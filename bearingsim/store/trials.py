"""Trials of models, and the choices based on them: plain JSON, each file whole or absent.

``trials/<unit>.json`` holds the trials of a unit of work, ``choices.json`` one choice for each case, with the name
of the plan for which it was made.
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

CHOICES, TRIALS, PLAN = "choices.json", "trials", "plan"


class DamagedChoices(UserError):
    """``choices.json`` cannot be read, so the models of earlier results are unknown."""


def write_trials(root: Path, unit: str, trials: Mapping[str, Trial | None]) -> None:
    """Write the trials of a unit, by id; None for a failed trial."""
    entries = {name: None if trial is None else _plain(trial) for name, trial in trials.items()}
    write_json(root / TRIALS / f"{unit}.json", {TRIALS: entries}, indent=None)


def read_trials(root: Path, features: Collection[str] = ()) -> dict[str, Trial | None]:
    """Read the trials of a folder that contain the given ``features``, by id.

    Unreadable files and trials without these features count as absent: they are made again.
    """
    by_id: dict[str, Trial | None] = {}
    for path in own_files.TRIALS.of(root):
        try:
            entries = read_json(path)
            entries = entries[TRIALS]
            check(layouts.Trials, entries)
            trials = {name: None if values is None else _trial(values) for name, values in entries.items()}
        except UNREADABLE:
            continue
        by_id |= {name: trial for name, trial in trials.items() if trial is None or trial.tells(features)}
    return by_id


def copy_trials(source: Path, root: Path) -> None:
    """Copy the trials of another results folder, except existing and unreadable files.

    A file of the same name is kept without comparison: its trials are of the same cases.
    """
    for path in own_files.TRIALS.of(source):
        with suppress(*UNREADABLE):
            read_json(path)
            if not (root / TRIALS / path.name).exists():
                write_bytes(root / TRIALS / path.name, read_regular(path))


def _plain(trial: Trial) -> dict[str, Any]:
    lines = {name: [[a.real, a.imag] for a in parts.tolist()] for name, parts in trial.lines.items()}
    powers = {name: parts.tolist() for name, parts in trial.powers.items()}
    entries = {
        "passes": trial.passes,
        "turns": trial.turns,
        "repeats": trial.repeats,
        "forces": trial.forces.tolist(),
    }
    return entries | {"lines": lines, "powers": powers, "method": trial.method, "step": trial.step}


def _trial(entries: Mapping[str, Any]) -> Trial:
    lines = {name: np.array([complex(*pair) for pair in parts]) for name, parts in entries["lines"].items()}
    powers = {name: np.array(parts) for name, parts in entries["powers"].items()}
    stepped = entries.get("method", ""), entries.get("step", 0.0)
    trial = Trial(
        entries["passes"],
        entries["turns"],
        entries["repeats"],
        lines,
        powers,
        np.array(entries["forces"]),
        *stepped,
    )
    if not trial.is_whole:
        raise Unreadable("the parts of a trial do not fit each other")
    return trial


def write_choices(root: Path, choices: Choices, plans: Mapping[str, str] | None = None) -> None:
    """Write the choices; plans: name of the plan for which each choice was made."""
    named = plans or {}
    entries = {name: asdict(choice) | {PLAN: named.get(name, "")} for name, choice in sorted(choices.items())}
    write_json(root / CHOICES, {"choices": entries})


def add_choices(root: Path, new: Choices, plan: str) -> tuple[Choices, dict[str, str]]:
    """Add new choices for a plan to those of a folder, which have precedence; return choices and plans by name.

    Raises DamagedChoices.
    """
    with lock(root):
        choices, plans = new | read_choices(root), dict.fromkeys(new, plan) | read_plans(root)
        write_choices(root, choices, plans)
    return choices, plans


def read_choices(root: Path) -> Choices:
    """Read the choices of a folder; none if it has no ``choices.json``. Raises DamagedChoices."""
    return {name: choice for name, (choice, _) in _read(root).items()}


def read_plans(root: Path) -> dict[str, str]:
    """Read the name of the plan of each choice in a folder. Raises DamagedChoices."""
    return {name: plan for name, (_, plan) in _read(root).items()}


def _read(root: Path) -> dict[str, tuple[Choice, str]]:
    path = root / CHOICES
    try:
        entries = read_json(path)
        entries = entries.get("choices", entries)
        check(layouts.Choices, entries)
        return {name: _choice(choice) for name, choice in entries.items()}
    except FileNotFoundError:
        return {}
    except UNREADABLE as error:
        raise DamagedChoices(
            f"{path} cannot be read ({error}): restore it, or remove it to choose again (results are kept)"
        ) from error


def _choice(entries: dict[str, Any]) -> tuple[Choice, str]:
    plan = entries.pop(PLAN, "")
    return Choice(**entries), str(plan)
