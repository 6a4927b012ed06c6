"""What is said at the end of a run of what is not known of the bearing: how far it moves the results."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from bearingsim.runner.progress import duration
from bearingsim.store import errors
from bearingsim.study.uncertainty import UNKNOWNS, unexamined

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["examined"]

BRIEFLY = {"": "the line", ".rms": "the RMS", ".force": "the largest force"}


def examined(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Iterator[str]:
    """How far the unknown moves the results of some jobs; of damping, if it was not tried, what that would take.

    plan: of ``store.read_plan``; frame: of ``store.build_table``.
    """
    found, values = errors(plan, frame), dict[str, list[float]]()
    for one in plan["variations"]:
        values.setdefault(one["what"], []).append(one["value"])
    for what, tried in values.items():
        columns = {text: f"error.{what}{ending}" for ending, text in BRIEFLY.items()}
        known = {text: found[name].dropna() for text, name in columns.items() if name in found}
        jobs_of = {one["job"] for one in plan["variations"] if one["what"] == what}
        lacking = int((frame["status"].reindex(list(jobs_of)) != "done").sum()) if "status" in frame else 0
        if lacking:
            yield f"{lacking} of {len(jobs_of)} variations of the {what} have no result, and their jobs no range"
        moved = ", ".join(f"{text} by {_percent(column.max())}" for text, column in known.items())
        if moved:
            jobs = max(len(column) for column in known.values())
            most = f" (at most, of {jobs} jobs)" if jobs > 1 else ""
            yield f"{what} of {UNKNOWNS[what].range_text(tried)} moves {moved}{most}{_chaotic(plan, frame, what)}"
    swept = any(path.startswith("contact.damping") for path in plan["units"])
    if "damping" not in values and not plan["nothing_uncertain"] and not swept:
        yield from _unexamined(plan, frame)


def _percent(part: float) -> str:
    return f"{100.0 * part:.0f} %" if part >= 0.1 else f"{100.0 * part:.2g} %"


def _chaotic(plan: Mapping[str, Any], frame: "pd.DataFrame", what: str) -> str:
    """How many of the variations are chaotic, if any is."""
    jobs = {one["job"] for one in plan["variations"] if one["what"] == what}
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
