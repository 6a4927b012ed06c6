"""Remarks on the effect of the variations of `uncertainty:` on the results."""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from bearingsim.store import default_ranges, relative_range
from bearingsim.study.uncertainty import PARAMETER_KINDS, group_by_kind
from bearingsim.text.numbers import percent

if TYPE_CHECKING:
    import pandas as pd

CHANGE_MEANING = "(largest minus smallest value of a case, relative to nominal; docs/uncertainty.md)"


def variation_effects(
    plan: Mapping[str, Any], frame: "pd.DataFrame", features: Sequence[str] = ()
) -> Iterator[str]:
    """Yield remarks on the relative change of features over the variations of each uncertain quantity.

    plan: from ``store.read_plan``; frame: from ``store.job_frame``; features: those of the figures; if empty, the
    velocity amplitude at the line of the defect, the velocity RMS and the largest outer force.
    """
    values = group_by_kind((variation["what"], variation["value"]) for variation in plan.get("variations", ()))
    for quantity, varied_values in values.items():
        ranges = (
            {name: relative_range(plan, frame, name, quantity) for name in features if f"features/{name}" in frame}
            if features
            else default_ranges(plan, frame, quantity)
        )
        effects = [_Effect.from_changes(name, changes) for name, changes in ranges.items() if len(changes)]
        yield from _missing_variations(plan, frame, quantity)
        for name in ranges:
            yield from _variations_without_value(plan, frame, quantity, name)
        if effects:
            by_words = "by up to" if max(effect.cases for effect in effects) > 1 else "by"
            values_text = (
                ""
                if PARAMETER_KINDS[quantity].choices
                else f" {PARAMETER_KINDS[quantity].range_text(varied_values)}"
            )
            # Only the first known change has the words, which then apply to the whole list.
            effects_text = re.sub(" by (?!an unknown)", f" {by_words} ", ", ".join(map(str, effects)), count=1)
            yield f"{quantity}{values_text} changes {effects_text} {CHANGE_MEANING}"
            yield from _chaotic_variations(plan, frame, quantity)


class _Effect(NamedTuple):
    """Largest relative change of a feature over its cases, NaN if it is unknown in all of them.

    cases: number of cases; unknown: number of cases in which the change is unknown.
    """

    feature: str
    change: float
    cases: int
    unknown: int

    @classmethod
    def from_changes(cls, feature: str, changes: "pd.Series[float]") -> "_Effect":
        return cls(feature, float(changes.max()), len(changes), int(changes.isna().sum()))

    def __str__(self) -> str:
        if self.unknown == self.cases:
            return f"{self.feature} by an unknown amount"
        unknown_cases = f" (range unknown in {self.unknown} of {self.cases} cases)" if self.unknown else ""
        return f"{self.feature} by {percent(self.change)}{unknown_cases}"


def _varied_jobs(plan: Mapping[str, Any], quantity: str) -> list[str]:
    """List the ids of the jobs in which a quantity differs from its nominal value."""
    entries = [entry for entry in plan.get("variations", ()) if entry["what"] == quantity]
    return list(dict.fromkeys(entry["job"] for entry in entries if entry["job"] != entry["of"]))


def _missing_variations(plan: Mapping[str, Any], frame: "pd.DataFrame", quantity: str) -> Iterator[str]:
    """Yield a remark on the variations without a result, if there are any."""
    jobs = _varied_jobs(plan, quantity)
    count = int((frame["status"].reindex(jobs) != "done").sum()) if "status" in frame else 0
    if count:
        yield f"{count} of {len(jobs)} variations of the {quantity} have no result; their jobs have no error band"


def _variations_without_value(
    plan: Mapping[str, Any], frame: "pd.DataFrame", quantity: str, feature: str
) -> Iterator[str]:
    """Yield a remark on cases without a range because a finished variation has no value of a feature."""
    entries = [entry for entry in plan.get("variations", ()) if entry["what"] == quantity]
    values, status = frame.get(f"features/{feature}"), frame.get("status")
    if values is None or status is None:
        return
    cases_without_range = {
        entry["of"]
        for entry in entries
        if values.get(entry["of"]) == values.get(entry["of"])  # not NaN
        and status.get(entry["job"]) == "done"
        and values[entry["job"]] != values[entry["job"]]
    }
    if cases_without_range:
        count = f"{len(cases_without_range)} of {len({entry['of'] for entry in entries})} cases"
        yield f"{count} have no range of {feature}: a variation of the {quantity} has no value of it"


def _chaotic_variations(plan: Mapping[str, Any], frame: "pd.DataFrame", quantity: str) -> Iterator[str]:
    """Yield a remark on the chaotic variations, if there are any."""
    jobs = _varied_jobs(plan, quantity)
    if "features/chaotic" not in frame:
        return
    count = int((frame["features/chaotic"][frame.index.isin(jobs)] == 1.0).sum())
    if count:
        variations_text = f"{count} of {len(jobs)} {quantity} variations"
        yield f"{variations_text} are chaotic; the change includes their standard errors"
