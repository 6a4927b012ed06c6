"""Choices of models kept from an earlier plan of a study."""

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from bearingsim import selection

if TYPE_CHECKING:
    from bearingsim.selection import Choice, Choices
    from bearingsim.study import Study


def plan_name(study: "Study", keys: Sequence[str]) -> str:
    """Return 16 hex digits that identify the cases of a study and the curves by which models are judged.

    keys: of the cases.
    """
    curves = [[curve.feature, sorted(keys[n] for n in curve.cases)] for curve in selection.curves(study)]
    text = json.dumps([sorted(keys), sorted(curves)])
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def kept(study: "Study", keys: Sequence[str], choices: "Choices", plans: Mapping[str, str]) -> Iterator[str]:
    """Yield the number of cases that keep a choice of an earlier plan, and curves on which models differ by that.

    keys: of the cases; plans: ``plan_name`` for which each choice was made, by key.
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
    curves = [[keys[n] for n in curve.cases] for curve in selection.curves(study)]
    apart = [names for names in curves if _differ(names, choices, plans)]
    if apart:
        models = dict.fromkeys(_model_text(choices[name]) for names in apart for name in names)
        yield (
            f"on {len(apart)} of {len(curves)} curves other models were chosen then than now: {', '.join(models)};"
            " a step between them may come from that"
        )


def _differ(names: Sequence[str], choices: "Choices", plans: Mapping[str, str]) -> bool:
    """Return True if the models on a curve that were chosen for one plan differ from those of another plan."""
    candidates: dict[str, set[str]] = {}
    for name in names:
        candidates.setdefault(plans[name], set()).add(choices[name].candidate)
    return len(set(map(frozenset, candidates.values()))) > 1


def _model_text(choice: "Choice") -> str:
    return f"`{choice.model}`" + (f" ({choice.candidate})" if choice.candidate != choice.model else "")
