"""Statements on the results at the end of a run: accuracy, warnings, assumptions, details."""

import re
from collections.abc import Iterator, Mapping, Sequence
from math import ceil, inf
from typing import TYPE_CHECKING, Any

from bearingsim import store
from bearingsim.config.names import NO_VALUE, STEP_ACCURACY
from bearingsim.config.rules import damping
from bearingsim.runner.progress import duration
from bearingsim.runner.promises import accuracy_notes, selection_notes, withdrawals
from bearingsim.runner.summary import Findings
from bearingsim.runner.variations import variation_effects
from bearingsim.store import NOTABLE_ERROR, has_error_estimate, is_uncertain, relative_error
from bearingsim.store.spread import chaotic_jobs
from bearingsim.study import plotted_features
from bearingsim.study.uncertainty import (
    NO_OIL,
    NO_SLIP,
    RIGID_RING,
    SMOOTH_SURFACES,
    WITHOUT_FRICTION,
    damping_remark,
    sweeps_damping,
)
from bearingsim.text.numbers import percent, span

if TYPE_CHECKING:
    import pandas as pd

DURATION = re.compile(r"(?<=`duration` of )([-+.e\d]+)(?= s)")
"""Duration, in s, in the reason why a line has no value."""
LARGEST_STEP_ERRORS = "largest step errors"
"""Beginning of a statement that the page of results omits, because it lists the numerical error of each result."""


def findings(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Findings:
    """Collect the statements on the results of a plan; frame: from ``store.job_frame``."""
    cases = frame.loc[[entry["job"] for entry in plan["jobs"] if not entry["variation"]]]
    info = store.info(cases)
    damping_notes = list(damping.result_remarks(info))
    damping_warnings = [text for text in (*damping_notes, *_assumptions(plan)) if text.startswith(damping.WARNING)]
    drawn_features = plotted_features(plan)
    accuracy = plan["accuracy"]["within"] if plan.get("accuracy") else inf
    chaos_warnings = scatter_warnings(cases, drawn_features, min(NOTABLE_ERROR, accuracy / 2.0))
    return Findings(
        withdrawn=tuple(withdrawals(plan, frame)),
        accuracy=(
            *(accuracy_notes(plan, frame) if plan.get("accuracy") else _step_error_notes(cases, info)),
            *chaos_notes(cases),
            *rest_notes(cases),
            *variation_effects(plan, frame, drawn_features),
        ),
        warnings=(
            *damping_warnings,
            *chaos_warnings,
            *step_warnings(cases),
            *transient_warnings(cases),
            *unknown_transients(cases),
            *missing_values(info),
        ),
        assumptions=tuple(_assumption_names(plan, cases)),
        details=(
            *selection_notes(plan, frame),
            *periodicity_notes(info),
            *(text for text in damping_notes if text not in damping_warnings),
            *(text for text in assumption_notes(plan, frame) if text not in damping_warnings),
        ),
    )


def _step_error_notes(cases: "pd.DataFrame", info: "pd.DataFrame") -> Iterator[str]:
    """Yield the largest step errors, and the number of jobs without one because their model has no method.

    info: one row per finished job. Not for a study with `accuracy`, in which the error of such a model includes
    that of its step.
    """
    yield from _largest_step_errors(cases)
    without_method = int((info["method"] == "").sum()) if "method" in info else 0
    if without_method:
        count = f"{without_method} of {len(info)} jobs"
        yield f"{count}: step error unknown, because the model has no method; compare with half the `step`"


def _largest_step_errors(cases: "pd.DataFrame") -> Iterator[str]:
    """Yield the largest step errors of all jobs whose time step was checked, except chaotic ones."""
    cases = cases[~chaotic_jobs(cases)]
    names = {"line": "velocity line", "rms": "velocity RMS", "force": "largest force"}
    errors = {
        text: cases[f"features/step_error.{name}"].max()
        for name, text in names.items()
        if _has_step_error(cases, name)
    }
    if errors:
        error_texts = ", ".join(f"{text} {percent(error)}" for text, error in errors.items())
        yield f"{LARGEST_STEP_ERRORS}: {error_texts}"


def chaos_notes(cases: "pd.DataFrame") -> Iterator[str]:
    """Yield the number of chaotic jobs, and the largest step error and scatter of their RMS.

    No step reproduces the line of a chaotic motion, so the step check compares only its RMS. It resolves an effect
    of the step only beyond the scatter (docs/step-check.md).
    """
    if "features/chaotic" not in cases:
        return
    chaotic = cases[cases["features/chaotic"] == 1.0]
    errors = [
        f"{text} {_largest_text(values)} (`{name}`)"
        for text, name in (
            ("scatter", "rms_scatter"),
            ("effect of the step, as far as resolved,", "step_error.rms"),
        )
        if len(values := chaotic.get(f"features/{name}", chaotic["features/chaotic"].iloc[:0]).dropna())
    ]
    if len(chaotic):
        count = f"{len(chaotic)} of {len(cases)} jobs are chaotic"
        yield f"{count}, so only their RMS is checked: {', '.join(errors)}" if errors else count


def _largest_text(values: "pd.Series[float]") -> str:
    """Format the largest of relative errors, as `up to 3 %`, or the number of unknown (infinite) ones."""
    unknown = int((values == inf).sum())
    return f"unknown in {unknown}" if unknown else f"up to {percent(values.max())}"


def rest_notes(cases: "pd.DataFrame") -> Iterator[str]:
    """Yield the number of jobs whose velocity is zero within rounding."""
    if not {"features/velocity.rms", "features/velocity.rounding"}.issubset(cases):
        return
    count = int((cases["features/velocity.rms"] <= cases["features/velocity.rounding"]).sum())
    if count:
        yield f"{count} of {len(cases)} responses are zero within rounding (`velocity.rounding`)"


def _has_step_error(cases: "pd.DataFrame", name: str) -> bool:
    return f"features/step_error.{name}" in cases and bool(cases[f"features/step_error.{name}"].notna().any())


def _assumption_names(plan: Mapping[str, Any], cases: "pd.DataFrame") -> Iterator[str]:
    """Yield the names of uncertain quantities that the study does not vary, and of neglected effects.

    They are ordered by their typical influence on amplitudes, the strongest first (docs/uncertainty.md).
    """
    assumptions = _assumptions(plan)
    varied_quantities = {variation["what"] for variation in plan.get("variations", ())}
    is_uncertain = not plan.get("nothing_uncertain")
    if RIGID_RING in assumptions:
        yield "rigid ring"
    if _has_smooth_surfaces(plan, cases):
        yield "smooth surfaces"
    if is_uncertain and "clearance" not in {*varied_quantities, *plan["units"]}:
        yield "clearance"
    has_damping = "info/damping_time_s" in cases and bool(cases["info/damping_time_s"].notna().any())
    if is_uncertain and has_damping and "damping" not in varied_quantities and not sweeps_damping(plan["units"]):
        yield "damping"
    has_bracket = "parameters/rig.bracket_stiffness" in cases and bool(
        (cases["parameters/rig.bracket_stiffness"] > 0.0).any()
    )
    if is_uncertain and has_bracket and "bracket" not in varied_quantities:
        yield "bracket"
    yield from (
        name for sentence, name in ((NO_SLIP, "no slip"), (NO_OIL, "no oil drag")) if sentence in assumptions
    )
    if any(text.endswith(WITHOUT_FRICTION) for text in assumptions):
        yield from ("no slip (effect: `error.friction`)", "no oil drag")


def _has_smooth_surfaces(plan: Mapping[str, Any], frame: "pd.DataFrame") -> bool:
    """Check if no job of a study has a form of its surfaces."""
    form = frame[[name for name in frame if str(name).startswith("parameters/surfaces.")]]
    has_form = bool((form.notna() & (form != "")).to_numpy().any())  # "": text that is not set
    return not has_form and not any(variation["what"] == "form" for variation in plan.get("variations", ()))


def _assumptions(plan: Mapping[str, Any]) -> tuple[str, ...]:
    return tuple(plan.get("assumptions", ()))


def missing_values(info: "pd.DataFrame") -> Iterator[str]:
    """Yield the lines of defects and the features of extensions without a value in some jobs, with the reason.

    Reasons that differ only in a duration are one reason, with the longest duration, which is sufficient for all
    these jobs. info: one row per finished job.
    """
    for column in (name for name in map(str, info) if name.startswith(NO_VALUE)):
        reasons = info[column][info[column] != ""].sort_index()
        for _, alike in reasons.groupby(reasons.str.replace(DURATION, "", regex=True)):
            count = f"{len(alike)} of {len(info)} jobs"
            feature, job = column.removeprefix(NO_VALUE), max(alike.index, key=lambda job: _duration(alike[job]))
            example = f" (for example {job})" if len(alike) > 1 else f" ({job})"
            yield f"feature `{feature}` has no value in {count}: {alike[job]}{example}"


def _duration(reason: str) -> float:
    """Return the duration (s) in a reason, 0 if it has none."""
    match = DURATION.search(reason)
    return float(match[1]) if match else 0.0


DEFAULT_FEATURES = ("velocity@BPFO", "velocity.rms")
"""Features whose standard error is reported if the study has no figures."""


def scatter_warnings(
    frame: "pd.DataFrame", drawn_features: Sequence[str] = (), notable: float = NOTABLE_ERROR
) -> Iterator[str]:
    """Yield the standard error of the results of chaotic jobs, and the duration that would reduce it.

    frame: from ``store.build_table``; drawn_features: features of the figures; notable: smallest relative standard
    error that is reported.
    """
    import pandas as pd

    table = frame.filter(regex="^features/").rename(columns=lambda name: name.partition("/")[2])
    names = [name for name in drawn_features or DEFAULT_FEATURES if name in table]
    if not names or "chaotic" not in table:
        return
    standard_errors = pd.DataFrame(
        {name: relative_error(table, name).where(is_uncertain(table, name, notable), 0.0) for name in names}
    )
    unknown = standard_errors.isna() | (standard_errors == inf)
    known_errors = standard_errors.mask(unknown, 0.0)
    if (known_errors.to_numpy() > 0.0).any():
        largest = float(known_errors.to_numpy().max())
        factor = ceil((largest / notable) ** 2)
        remedy = f"a `duration` {factor} times as long reduces it to {percent(notable)} (docs/step-check.md)"
        yield f"{_job_counts(known_errors > 0.0)} up to {percent(largest)}; {remedy}"
    is_estimated = pd.Series({name: has_error_estimate(table, name) for name in names})
    if (unknown & is_estimated).to_numpy().any():
        yield f"{_job_counts(unknown & is_estimated)} unknown; try a longer `duration`"
    if (unknown & ~is_estimated).to_numpy().any():
        yield f"{_job_counts(unknown & ~is_estimated)} not estimated"


def _job_counts(flags: "pd.DataFrame") -> str:
    """Format a number of jobs and a feature, as `2 of 8 jobs chaotic: standard error of velocity.rms`.

    flags: (jobs, features) bool.
    """
    names = [str(name) for name in flags if flags[name].any()]
    more = f" (and {len(names) - 1} more)" if len(names) > 1 else ""
    return f"{flags.any(axis=1).sum()} of {len(flags)} jobs chaotic: standard error of {names[0]}{more}"


OTHER_STEP_ERRORS = {
    "step_error.force": "the largest force",
    "step_error.record": "the RMS of displacement, acceleration or a recorded channel",
}
"""Quantities whose step errors ``step_warnings`` reports, by column."""


def step_warnings(frame: "pd.DataFrame") -> Iterator[str]:
    """Yield step errors above ``STEP_ACCURACY`` of the largest force and of the RMS of other channels.

    The largest force of a chaotic motion is left out, because no step reproduces it.
    """
    for name, quantity in OTHER_STEP_ERRORS.items():
        if f"features/{name}" not in frame:
            continue
        values = frame[f"features/{name}"]
        is_checked = (frame["features/chaotic"] == 0.0) | (name != "step_error.force")
        exceeding = values[is_checked & (values > STEP_ACCURACY)]
        if len(exceeding):
            jobs = f"{len(exceeding)} job{'s' * (len(exceeding) > 1)}"
            yield f"{jobs}: {quantity} has a step error of up to {percent(exceeding.max())} (`{name}`)"


START_ERROR_NAMES = {"error.start": "velocity line", "error.start.rms": "velocity RMS"}
"""Quantities whose errors of the start ``transient_warnings`` reports, by column."""


def transient_warnings(frame: "pd.DataFrame") -> Iterator[str]:
    """Yield the number of jobs in which parts of the record differ in line or RMS by more than ``STEP_ACCURACY``.

    The cause is the initial transient, or a record of few revolutions of a defect or unbalance. Jobs with random
    scatter (a standard error, or cage slip) are left out.
    """
    is_random = frame.filter(items=["features/standard_error.line", "features/cage.slip.mean"]).notna().any(axis=1)
    errors = frame.loc[~is_random].filter(items=[f"features/{name}" for name in START_ERROR_NAMES])
    exceeding = errors.where(errors > STEP_ACCURACY).dropna(how="all").dropna(how="all", axis=1)
    if len(exceeding):
        jobs = f"{len(exceeding)} job{'s' * (len(exceeding) > 1)}"
        columns = {str(column).removeprefix("features/"): exceeding[column].max() for column in exceeding}
        texts = [
            f"of the {START_ERROR_NAMES[name]} up to {percent(error)} (`{name}`)"
            for name, error in columns.items()
        ]
        yield (
            f"{jobs}: error {', '.join(texts)}, because the record is short or not"
            " settled; use a longer `duration` or `settle` (docs/settling.md)"
        )


def unknown_transients(frame: "pd.DataFrame") -> Iterator[str]:
    """Yield the number of jobs whose record is too short to estimate the error of its RMS; ramps are left out."""
    if not {"features/velocity.rms", "features/error.start.rms"}.issubset(frame):
        return
    ramps = frame.filter(items=["parameters/ramp.to"]).notna().any(axis=1)
    is_unknown = frame["features/error.start.rms"].isna() & frame["features/velocity.rms"].notna() & ~ramps
    if count := int(is_unknown.sum()):
        yield (
            f"{count} job{'s' * (count > 1)}: unknown error of the start (`error.start.rms`), because the record"
            " has too few ball passes or revolutions of a defect or unbalance; use a longer `duration`"
            " (docs/settling.md)"
        )


def periodicity_notes(info: "pd.DataFrame") -> Iterator[str]:
    """Yield the numbers of periodic and non-periodic responses; info: one row per finished job."""
    if "period_passes" not in info:
        return
    checked = info[info["period_passes"].notna()]
    periodic = checked[checked["period_passes"] > 0]
    if len(periodic):
        passes = _range_text(periodic["passes_computed"], "{:.0f}")
        yield (
            f"{len(periodic)} of {len(checked)} responses are periodic: {passes} of"
            f" {_range_text(periodic['passes'], '{:.0f}')} ball passes computed (`periodic: false` computes all)"
        )
    ended_early = checked[(checked["period_passes"] == 0) & (checked["passes_computed"] < checked["passes"])]
    if len(ended_early):
        passes = _range_text(ended_early["passes_computed"], "{:.0f}")
        yield f"{len(ended_early)} of {len(checked)} jobs ended early, accurate enough after {passes} ball passes"
    non_periodic = checked[(checked["passes_computed"] == checked["passes"]) & (checked["last_difference"] > 0.0)]
    if len(non_periodic):
        yield (
            f"{len(non_periodic)} of {len(checked)} responses are not periodic: successive passes differ by"
            f" {_range_text(100.0 * non_periodic['last_difference'], '{:.2g}')} %"
            " of peak-to-peak (`last_difference`)"
        )


def _range_text(values: "pd.Series[float]", template: str) -> str:
    return span(values.min(), values.max(), template.format)


def assumption_notes(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Iterator[str]:
    """Yield the assumptions of a study, and the cost of varying the damping if it is not varied."""
    values = {variation["what"] for variation in plan.get("variations", ())}
    yield from plan.get("assumptions", ())
    if _has_smooth_surfaces(plan, frame):
        yield SMOOTH_SURFACES
    if "damping" not in values and not plan.get("nothing_uncertain") and not sweeps_damping(plan["units"]):
        yield from _damping_note(plan, frame)


def _damping_note(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Iterator[str]:
    cases = [entry["job"] for entry in plan["jobs"] if not entry["twin"] and not entry["variation"]]
    if "info/damping_time_s" not in frame or "info/cpu_s" not in frame:
        return
    rows = frame.loc[cases]
    damped_cases = rows[rows["info/damping_time_s"].notna()]
    if len(damped_cases):
        # The plan does not state which of the other cases depend on damping.
        finished = int((rows["status"] == "done").sum())
        scope = "" if finished == len(rows) else f" for the {finished} finished of {len(rows)} cases"
        yield damping_remark(len(damped_cases), duration, float(damped_cases["info/cpu_s"].sum()), scope)
