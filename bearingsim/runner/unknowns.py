"""Influence of uncertain quantities of the bearing on the results, for the end of a run."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from bearingsim.runner.progress import duration
from bearingsim.store import errors
from bearingsim.study.uncertainty import UNKNOWNS, by_kind, sweeps_damping, unexamined

if TYPE_CHECKING:
    import pandas as pd

BRIEFLY = {"": "the line", ".rms": "the RMS", ".force": "the largest force"}


def moved(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Iterator[str]:
    """Yield the change of the results over the variations of each uncertain quantity.

    plan: of ``store.read_plan``; frame: of ``store.build_table``.
    """
    changes = errors(plan, frame)
    values = by_kind((variation["what"], variation["value"]) for variation in plan.get("variations", ()))
    for what, tried in values.items():
        columns = {text: f"error.{what}{ending}" for ending, text in BRIEFLY.items()}
        by_feature = {text: changes[name].dropna() for text, name in columns.items() if name in changes}
        yield from _lacking(plan, frame, what)
        ranges = ", ".join(f"{text} by {_percent(column.max())}" for text, column in by_feature.items())
        if ranges:
            jobs = max(len(column) for column in by_feature.values())
            most = f" (at most, of {jobs} jobs)" if jobs > 1 else ""
            yield f"{UNKNOWNS[what].tried_text(what, tried)} moves {ranges}{most}{_chaotic(plan, frame, what)}"


def assumed(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Iterator[str]:
    """Yield the assumptions of a study, and the cost of varying damping if it is not varied."""
    values = {variation["what"] for variation in plan.get("variations", ())}
    if "damping" not in values and not plan.get("nothing_uncertain") and not sweeps_damping(plan["units"]):
        yield from _unexamined(plan, frame)
    yield from plan.get("assumptions", ())


def _percent(part: float) -> str:
    return f"{100.0 * part:.0f} %" if part >= 0.1 else f"{100.0 * part:.2g} %"


def _variations(plan: Mapping[str, Any], what: str) -> list[str]:
    """List the ids of the jobs in which a quantity is varied."""
    return list({variation["job"]: None for variation in plan.get("variations", ()) if variation["what"] == what})


def _lacking(plan: Mapping[str, Any], frame: "pd.DataFrame", what: str) -> Iterator[str]:
    """Yield the number of variations without a result, if any."""
    jobs = _variations(plan, what)
    count = int((frame["status"].reindex(jobs) != "done").sum()) if "status" in frame else 0
    if count:
        yield f"{count} of {len(jobs)} variations of the {what} have no result, and their jobs no range"


def _chaotic(plan: Mapping[str, Any], frame: "pd.DataFrame", what: str) -> str:
    """Return a remark on the number of chaotic variations, or "" without any."""
    jobs = _variations(plan, what)
    if "features/chaotic" not in frame:
        return ""
    count = int((frame["features/chaotic"][frame.index.isin(jobs)] == 1.0).sum())
    return (
        f"; {count} of {len(jobs)} variations moved chaotically: the standard error of line and RMS counts"
        * bool(count)
    )


def _unexamined(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Iterator[str]:
    cases = [entry["job"] for entry in plan["jobs"] if not entry["twin"] and not entry["variation"]]
    if "info/damping_time_s" not in frame or "info/cpu_s" not in frame:
        return
    damped = frame.loc[cases][frame.loc[cases]["info/damping_time_s"].notna()]
    if len(damped):
        yield unexamined(len(damped), duration, float(damped["info/cpu_s"].sum()))
