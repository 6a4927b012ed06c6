"""Model chosen for each case, stored in ``choices.json`` with the name of the plan for which it was chosen."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from bearingsim.errors import UserError
from bearingsim.store import layouts
from bearingsim.store.files import lock
from bearingsim.store.layouts import check
from bearingsim.store.sealed import UNREADABLE, read_json, write_json

CHOICES, PLAN = "choices.json", "plan"


class DamagedChoices(UserError):
    """``choices.json`` cannot be read, so the models of earlier results are unknown."""


@dataclass(frozen=True)
class Choice:
    """Model chosen for a case.

    candidate: name of the candidate, or `reference`; model: name of the resulting model; why: reason for the
    choice. Relative errors by feature, None if unknown: error: of the model; nodes: of its discretisation;
    friction: due to neglected friction. inferred: True if ``friction`` is inferred from other cases of the curve.
    values, scales: by feature, absolute value of the reference in its trial, and the value to which the errors are
    relative (SI), None if unknown; empty in files of earlier versions.
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
"""Choices by the ``selection.choices.key`` of the case."""


def write_choices(root: Path, choices: Choices, plans: Mapping[str, str] | None = None) -> None:
    """Write the choices; plans: name of the plan for which each choice was made."""
    plan_names = plans or {}
    entries = {name: asdict(choice) | {PLAN: plan_names.get(name, "")} for name, choice in sorted(choices.items())}
    write_json(root / CHOICES, {"choices": entries})


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
        return {name: _choice(entry) for name, entry in entries.items()}
    except FileNotFoundError:
        return {}
    except UNREADABLE as error:
        raise DamagedChoices(
            f"{path} cannot be read ({error}): restore it, or remove it to choose again (results are kept)"
        ) from error


def _choice(entries: dict[str, Any]) -> tuple[Choice, str]:
    plan = entries.pop(PLAN, "")
    return Choice(**entries), str(plan)
