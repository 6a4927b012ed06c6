"""Statements on the results at the end of a run: accuracy, warnings, assumptions, details."""

from collections.abc import Iterator, Mapping, Sequence
from math import ceil, inf
from typing import TYPE_CHECKING, Any

from bearingsim import store
from bearingsim.config.names import NO_VALUE, STEP_ACCURACY
from bearingsim.config.rules import damping
from bearingsim.runner.progress import duration
from bearingsim.runner.promises import accuracy_notes, selection_notes, withdrawals
from bearingsim.runner.summary import Findings
from bearingsim.store import NOTABLE_ERROR, errors, is_uncertain, relative_error
from bearingsim.study.uncertainty import (
    NO_OIL,
    NO_SLIP,
    PARAMETER_KINDS,
    RIGID_RING,
    damping_remark,
    group_by_kind,
    sweeps_damping,
)

if TYPE_CHECKING:
    import pandas as pd


def findings(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Findings:
    """Collect the statements on the results of a plan; frame: from ``store.job_frame``."""
    own = frame.loc[[entry["job"] for entry in plan["jobs"] if not entry["variation"]]]
    info = store.info(own)
    of_damping = list(damping.job_sentences(info))
    warned = [text for text in (*of_damping, *_assumptions(plan)) if text.startswith(damping.WARNING)]
    drawn = list(dict.fromkeys(name for figure in plan["figures"] for name in figure["y"]))
    within = plan["accuracy"]["within"] if plan.get("accuracy") else inf
    flagged = scatter_warnings(own, drawn, min(NOTABLE_ERROR, within / 2.0))
    return Findings(
        withdrawn=tuple(withdrawals(plan, frame)),
        accuracy=(
            *(accuracy_notes(plan, frame) if plan.get("accuracy") else _largest_step_errors(own)),
            *variation_effects(plan, frame),
        ),
        warnings=(
            *warned,
            *flagged,
            *step_warnings(own),
            *transient_warnings(own),
            *missing_values(info),
        ),
        assumptions=tuple(_assumption_names(plan, own)),
        details=(
            *selection_notes(plan, frame),
            *periodicity_notes(info),
            *(text for text in of_damping if text not in warned),
            *(text for text in assumption_notes(plan, frame) if text not in warned),
        ),
    )


def _largest_step_errors(own: "pd.DataFrame") -> Iterator[str]:
    """Yield the largest step errors of the jobs whose time step was checked."""
    names = {"line": "line amplitude", "rms": "RMS", "force": "largest force"}
    errors = {text: own[f"features/step_error.{name}"].max() for name, text in names.items() if _has(own, name)}
    if errors:
        each = ", ".join(f"{text} {100.0 * error:.2g} %" for text, error in errors.items())
        yield f"largest step errors: {each}"


def _has(own: "pd.DataFrame", name: str) -> bool:
    return f"features/step_error.{name}" in own and bool(own[f"features/step_error.{name}"].notna().any())


def _assumption_names(plan: Mapping[str, Any], own: "pd.DataFrame") -> Iterator[str]:
    """Yield the names of uncertain quantities that the study does not vary, and of neglected effects."""
    varied = {variation["what"] for variation in plan.get("variations", ())}
    damped = "info/damping_time_s" in own and bool(own["info/damping_time_s"].notna().any())
    held_by_bracket = "parameters/rig.bracket_stiffness" in own and bool(
        (own["parameters/rig.bracket_stiffness"] > 0.0).any()
    )
    if not plan.get("nothing_uncertain"):
        if damped and "damping" not in varied and not sweeps_damping(plan["units"]):
            yield "damping"
        if "clearance" not in {*varied, *plan["units"]}:
            yield "clearance"
        if held_by_bracket and "bracket" not in varied:
            yield "bracket"
    yield from (
        name
        for sentence, name in ((RIGID_RING, "rigid ring"), (NO_SLIP, "no slip"), (NO_OIL, "no oil drag"))
        if sentence in _assumptions(plan)
    )


def _assumptions(plan: Mapping[str, Any]) -> tuple[str, ...]:
    return tuple(plan.get("assumptions", ()))


def missing_values(info: "pd.DataFrame") -> Iterator[str]:
    """Yield the features of other packages that have no value in some jobs, with the reason.

    info: one row per finished job.
    """
    for column in (name for name in map(str, info) if name.startswith(NO_VALUE)):
        reasons = info[column][info[column] != ""]
        for reason, jobs in reasons.groupby(reasons):
            count = f"{len(jobs)} of {len(info)} jobs"
            feature = column.removeprefix(NO_VALUE)
            yield f"feature `{feature}` has no value in {count}: {reason} (for example {jobs.index[0]})"


LINE_AND_RMS = ("velocity@BPFO", "velocity.rms")


def scatter_warnings(
    frame: "pd.DataFrame", drawn: Sequence[str] = (), notable: float = NOTABLE_ERROR
) -> Iterator[str]:
    """Yield the standard error of the results of chaotic jobs, and the duration that would reduce it.

    frame: from ``store.build_table``; drawn: features of the figures; notable: smallest relative standard error
    that is reported.
    """
    import pandas as pd

    table = frame.filter(regex="^features/").rename(columns=lambda name: name.partition("/")[2])
    names = [name for name in drawn or LINE_AND_RMS if name in table]
    if not names or "chaotic" not in table:
        return
    standard = pd.DataFrame(
        {name: relative_error(table, name).where(is_uncertain(table, name, notable), 0.0) for name in names}
    )
    unknown = standard.isna() | (standard == inf)
    bounded = standard.mask(unknown, 0.0)
    if (bounded.to_numpy() > 0.0).any():
        worst = float(bounded.to_numpy().max())
        factor = ceil((worst / notable) ** 2)
        longer = f"{100.0 * notable:.2g} % needs {factor} times the `duration`"
        yield f"{_job_counts(bounded > 0.0)} has standard error {100.0 * worst:.2g} %; {longer}"
    if unknown.to_numpy().any():
        yield f"{_job_counts(unknown)} has unknown standard error; try a longer `duration`"


def _job_counts(flags: "pd.DataFrame") -> str:
    """Format jobs and a feature, as `2 of 8 jobs chaotic: velocity.rms`; flags: jobs by features."""
    names = [str(name) for name in flags if flags[name].any()]
    more = f" (and {len(names) - 1} more)" if len(names) > 1 else ""
    return f"{flags.any(axis=1).sum()} of {len(flags)} jobs chaotic: {names[0]}{more}"


LESS_SURE = {
    "step_error.force": "the largest force",
    "step_error.record": "the RMS of another recorded channel",
}


def step_warnings(frame: "pd.DataFrame") -> Iterator[str]:
    """Yield step errors above ``STEP_ACCURACY`` of the largest force and of the RMS of other channels."""
    for name, what in LESS_SURE.items():
        if f"features/{name}" not in frame:
            continue
        values = frame[f"features/{name}"]
        error = values[(frame["features/chaotic"] == 0.0) & (values > STEP_ACCURACY)]
        if len(error):
            jobs = f"{len(error)} job{'s' * (len(error) > 1)}"
            yield f"{jobs}: {what} has a step error of up to {100.0 * error.max():.2g} % (`{name}`)"


def transient_warnings(frame: "pd.DataFrame") -> Iterator[str]:
    """Yield the number of jobs whose initial transient changes line or RMS by more than ``STEP_ACCURACY``.

    Jobs with random scatter (a standard error, or cage slip) are left out.
    """
    columns = [name for name in ("features/error.start", "features/error.start.rms") if name in frame]
    if not columns:
        return
    by_chance = frame.filter(items=["features/standard_error.line", "features/cage.slip.mean"]).notna().any(axis=1)
    errors = frame.loc[~by_chance, columns].max(axis=1)
    errors = errors[errors > STEP_ACCURACY]
    if len(errors):
        jobs = f"{len(errors)} jobs have" if len(errors) > 1 else "1 job has"
        yield (
            f"{jobs} not settled, with an error of up to {100.0 * errors.max():.2g} % (`error.start`);"
            " use `settle: auto` or a longer one"
        )


def periodicity_notes(info: "pd.DataFrame") -> Iterator[str]:
    """Yield the numbers of periodic and non-periodic responses; info: one row per finished job."""
    if "period_passes" not in info:
        return
    checked = info[info["period_passes"].notna()]
    repeating = checked[checked["period_passes"] > 0]
    if len(repeating):
        passes = _span(repeating["passes_computed"], "{:.0f}")
        yield (
            f"{len(repeating)} of {len(checked)} responses are periodic: {passes} of"
            f" {_span(repeating['passes'], '{:.0f}')} ball passes computed (`periodic: false` computes all)"
        )
    ended = checked[(checked["period_passes"] == 0) & (checked["passes_computed"] < checked["passes"])]
    if len(ended):
        passes = _span(ended["passes_computed"], "{:.0f}")
        yield f"{len(ended)} of {len(checked)} jobs were accurate enough after {passes} ball passes"
    others = checked[(checked["passes_computed"] == checked["passes"]) & (checked["last_difference"] > 0.0)]
    if len(others):
        yield (
            f"{len(others)} of {len(checked)} responses are not periodic: successive passes differ by"
            f" {_span(100.0 * others['last_difference'], '{:.2g}')} % of peak-to-peak (`last_difference`)"
        )


def _span(values: "pd.Series[float]", form: str) -> str:
    low, high = form.format(values.min()), form.format(values.max())
    return low if low == high else f"{low} to {high}"


BRIEFLY = {"": "line amplitude", ".rms": "RMS", ".force": "largest force"}
"""Names of the features with `error.*` columns, by suffix of the column."""


def variation_effects(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Iterator[str]:
    """Yield the change of the results over the variations of each uncertain quantity.

    plan: from ``store.read_plan``; frame: from ``store.build_table``.
    """
    changes = errors(plan, frame)
    values = group_by_kind((variation["what"], variation["value"]) for variation in plan.get("variations", ()))
    for what, tried in values.items():
        columns = {text: f"error.{what}{ending}" for ending, text in BRIEFLY.items()}
        by_feature = {text: changes[name].dropna() for text, name in columns.items() if name in changes}
        yield from _lacking(plan, frame, what)
        ranges = ", ".join(f"{text} by {_percent(column.max())}" for text, column in by_feature.items())
        if ranges:
            most = "by up to" if max(len(column) for column in by_feature.values()) > 1 else "by"
            values_text = "" if PARAMETER_KINDS[what].choices else f" {PARAMETER_KINDS[what].range_text(tried)}"
            yield f"{what}{values_text} changes {ranges.replace('by', most, 1)}"
            yield from _chaotic(plan, frame, what)


def assumption_notes(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Iterator[str]:
    """Yield the assumptions of a study, and the cost of varying the damping if it is not varied."""
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
        yield f"{count} of {len(jobs)} variations of the {what} have no result; their jobs have no error band"


def _chaotic(plan: Mapping[str, Any], frame: "pd.DataFrame", what: str) -> Iterator[str]:
    """Yield the number of chaotic variations, if any."""
    jobs = _variations(plan, what)
    if "features/chaotic" not in frame:
        return
    count = int((frame["features/chaotic"][frame.index.isin(jobs)] == 1.0).sum())
    if count:
        yield f"{count} of {len(jobs)} {what} variations are chaotic; the change includes their standard error"


def _unexamined(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Iterator[str]:
    cases = [entry["job"] for entry in plan["jobs"] if not entry["twin"] and not entry["variation"]]
    if "info/damping_time_s" not in frame or "info/cpu_s" not in frame:
        return
    damped = frame.loc[cases][frame.loc[cases]["info/damping_time_s"].notna()]
    if len(damped):
        yield damping_remark(len(damped), duration, float(damped["info/cpu_s"].sum()))
