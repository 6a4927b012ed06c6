"""Models chosen for the cases of a study, stored in ``choices.json`` with the plan of each choice."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from bearingsim.errors import UserError
from bearingsim.store import layouts
from bearingsim.store.files import lock
from bearingsim.store.layouts import check
from bearingsim.store.sealed import UNREADABLE, read_json, write_json

CHOICES_FILE, PLAN_KEY = "choices.json", "plan"


class DamagedChoices(UserError):
    """``choices.json`` cannot be read, so the models of earlier results are unknown."""


@dataclass(frozen=True)
class Choice:
    """Model chosen for a case.

    candidate: name of the candidate, or `reference`; model: name of the resulting model; why: reason for the
    choice; error, nodes, friction: relative errors by feature, None if unknown, of the model, of its
    discretisation and due to neglected friction; inferred: True if ``friction`` is inferred from other cases of
    the curve; values, scales: by feature, absolute value of the reference in its trial and value to which the
    errors are relative (SI), None if unknown, both empty in files of earlier versions.
    """

    candidate: str
    model: str
    why: str
    error: Mapping[str, float]
    nodes: Mapping[str, float | None] = field(default_factory=dict)
    friction: Mapping[str, float | None] = field(default_factory=dict)
    inferred: bool = False
    values: Mapping[str, float | None] = field(default_factory=dict)
    scales: Mapping[str, float | None] = field(default_factory=dict)


Choices = dict[str, Choice]
"""Choices by ``selection.choices.key`` of the case."""


def write_choices(root: Path, choices: Choices, plans: Mapping[str, str] | None = None) -> None:
    """Write the choices; plans: name of the plan for which each choice was made."""
    plan_names = plans or {}
    entries = {
        name: asdict(choice) | {PLAN_KEY: plan_names.get(name, "")} for name, choice in sorted(choices.items())
    }
    write_json(root / CHOICES_FILE, {"choices": entries})


def add_choices(root: Path, new: Choices, plan: str) -> tuple[Choices, dict[str, str]]:
    """Add the choices of a plan to a folder; existing choices take precedence. Return choices and plans by key.

    Raises DamagedChoices.
    """
    with lock(root):
        choices, plans = new | read_choices(root), dict.fromkeys(new, plan) | read_plans(root)
        write_choices(root, choices, plans)
    return choices, plans


def read_choices(root: Path) -> Choices:
    """Read the choices of a folder; empty without ``choices.json``. Raises DamagedChoices."""
    return {name: choice for name, (choice, _) in _read_entries(root).items()}


def read_plans(root: Path) -> dict[str, str]:
    """Read the name of the plan of each choice in a folder. Raises DamagedChoices."""
    return {name: plan for name, (_, plan) in _read_entries(root).items()}


def _read_entries(root: Path) -> dict[str, tuple[Choice, str]]:
    """Read the choices of a folder with their plans, by key. Raises DamagedChoices."""
    path = root / CHOICES_FILE
    try:
        entries = read_json(path)
        entries = entries.get("choices", entries)
        check(layouts.Choices, entries)
        return {name: _split_entry(entry) for name, entry in entries.items()}
    except FileNotFoundError:
        return {}
    except UNREADABLE as error:
        raise DamagedChoices(
            f"{path} cannot be read ({error}): restore it, or remove it to choose again (results are kept)"
        ) from error


def _split_entry(entries: dict[str, Any]) -> tuple[Choice, str]:
    """Return the choice and the plan of an entry of ``choices.json``."""
    plan = entries.pop(PLAN_KEY, "")
    return Choice(**entries), str(plan)
