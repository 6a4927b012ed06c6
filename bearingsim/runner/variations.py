"""Effect of the variations of `uncertainty:` on the results, in words."""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from bearingsim.store import default_ranges, relative_range
from bearingsim.study.uncertainty import PARAMETER_KINDS, group_by_kind
from bearingsim.text.numbers import percent

if TYPE_CHECKING:
    import pandas as pd

MEANING = "(largest minus smallest value of a case, relative to nominal; docs/uncertainty.md)"


def variation_effects(
    plan: Mapping[str, Any], frame: "pd.DataFrame", features: Sequence[str] = ()
) -> Iterator[str]:
    """Yield the relative change of features over the variations of each uncertain quantity.

    plan: from ``store.read_plan``; frame: from ``store.job_frame``; features: those of the figures; without any,
    the line of the defect, the RMS of the velocity and the largest force.
    """
    values = group_by_kind((variation["what"], variation["value"]) for variation in plan.get("variations", ()))
    for quantity, tried_values in values.items():
        ranges = (
            {name: relative_range(plan, frame, name, quantity) for name in features if f"features/{name}" in frame}
            if features
            else default_ranges(plan, frame, quantity)
        )
        effects = [_Effect.of(name, changes) for name, changes in ranges.items() if len(changes)]
        yield from _missing_variations(plan, frame, quantity)
        for name in ranges:
            yield from _variations_without_value(plan, frame, quantity, name)
        if effects:
            preposition = "by up to" if max(effect.cases for effect in effects) > 1 else "by"
            values_text = (
                ""
                if PARAMETER_KINDS[quantity].choices
                else f" {PARAMETER_KINDS[quantity].range_text(tried_values)}"
            )
            effects_text = re.sub("by(?! an unknown)", preposition, ", ".join(map(str, effects)), count=1)
            yield f"{quantity}{values_text} changes {effects_text} {MEANING}"
            yield from _chaotic_variations(plan, frame, quantity)


class _Effect(NamedTuple):
    """Largest relative change of a feature (NaN if unknown), number of cases, and of those with unknown range."""

    feature: str
    change: float
    cases: int
    unknown: int

    @classmethod
    def of(cls, feature: str, changes: "pd.Series[float]") -> "_Effect":
        return cls(feature, float(changes.max()), len(changes), int(changes.isna().sum()))

    def __str__(self) -> str:
        if self.unknown == self.cases:
            return f"{self.feature} by an unknown amount"
        exception = f" (range unknown in {self.unknown} of {self.cases} cases)" if self.unknown else ""
        return f"{self.feature} by {percent(self.change)}{exception}"


def _variations(plan: Mapping[str, Any], quantity: str) -> list[str]:
    """List the ids of the jobs in which a quantity has another than its nominal value."""
    entries = [entry for entry in plan.get("variations", ()) if entry["what"] == quantity]
    return list(dict.fromkeys(entry["job"] for entry in entries if entry["job"] != entry["of"]))


def _missing_variations(plan: Mapping[str, Any], frame: "pd.DataFrame", quantity: str) -> Iterator[str]:
    """Yield the number of variations without a result, if any."""
    jobs = _variations(plan, quantity)
    count = int((frame["status"].reindex(jobs) != "done").sum()) if "status" in frame else 0
    if count:
        yield f"{count} of {len(jobs)} variations of the {quantity} have no result; their jobs have no error band"


def _variations_without_value(
    plan: Mapping[str, Any], frame: "pd.DataFrame", quantity: str, feature: str
) -> Iterator[str]:
    """Yield the number of cases without a range because a finished variation has no value of a feature."""
    entries = [entry for entry in plan.get("variations", ()) if entry["what"] == quantity]
    values, status = frame.get(f"features/{feature}"), frame.get("status")
    if values is None or status is None:
        return
    lost = {
        entry["of"]
        for entry in entries
        if values.get(entry["of"]) == values.get(entry["of"])  # not NaN
        and status.get(entry["job"]) == "done"
        and values[entry["job"]] != values[entry["job"]]
    }
    if lost:
        count = f"{len(lost)} of {len({entry['of'] for entry in entries})} cases"
        yield f"{count} have no range of {feature}: a variation of the {quantity} has no value of it"


def _chaotic_variations(plan: Mapping[str, Any], frame: "pd.DataFrame", quantity: str) -> Iterator[str]:
    """Yield the number of chaotic variations, if any."""
    jobs = _variations(plan, quantity)
    if "features/chaotic" not in frame:
        return
    count = int((frame["features/chaotic"][frame.index.isin(jobs)] == 1.0).sum())
    if count:
        chaotic = f"{count} of {len(jobs)} {quantity} variations are chaotic"
        yield f"{chaotic}; the change includes their standard errors"
