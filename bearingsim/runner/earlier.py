"""A study that has changed since models were chosen: which cases keep what was chosen before."""

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from bearingsim import selection

if TYPE_CHECKING:
    from bearingsim.selection import Choice, Choices
    from bearingsim.study import Study

__all__ = ["kept", "plan_name"]


def plan_name(study: "Study", keys: Sequence[str]) -> str:
    """16 hex digits that name the cases of a study, by their keys, and the curves that they are judged by."""
    curves = [[one.feature, sorted(keys[n] for n in one.cases)] for one in selection.curves(study)]
    text = json.dumps([sorted(keys), sorted(curves)])
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def kept(study: "Study", keys: Sequence[str], choices: "Choices", plans: Mapping[str, str]) -> Iterator[str]:
    """How many cases keep a choice of an earlier plan, and on how many curves it differs from what is chosen now.

    keys: of the cases; plans: what names the plan that each choice was made for.
    """
    now = plan_name(study, keys)
    before = sum(plans[name] != now for name in keys)
    if not before:
        return
    cases = (
        f"{before} of {len(keys)} cases keep the model"
        if before > 1
        else f"1 of {len(keys)} cases keeps the model"
    )
    yield f"{cases} that was chosen for an earlier plan, by its curves (without choices.json all are chosen anew)"
    curves = [[keys[n] for n in one.cases] for one in selection.curves(study)]
    apart = [names for names in curves if _differ(names, choices, plans)]
    if apart:
        models = dict.fromkeys(_told(choices[name]) for names in apart for name in names)
        yield (
            f"on {len(apart)} of {len(curves)} curves other models were chosen then than now: {', '.join(models)};"
            " a step between them may come from that"
        )


def _differ(names: Sequence[str], choices: "Choices", plans: Mapping[str, str]) -> bool:
    """Whether on a curve the models that were chosen for one plan are others than those for another plan."""
    found: dict[str, set[str]] = {}
    for name in names:
        found.setdefault(plans[name], set()).add(choices[name].candidate)
    return len(set(map(frozenset, found.values()))) > 1


def _told(choice: "Choice") -> str:
    return f"`{choice.model}`" + (f" ({choice.candidate})" if choice.candidate != choice.model else "")
