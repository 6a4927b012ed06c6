"""Statements on the results at the end of a run: accuracy, warnings, assumptions, details."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, Any

from bearingsim import store
from bearingsim.config.names import NO_VALUE
from bearingsim.config.rules import damping
from bearingsim.runner.promises import held, promises, withdrawals
from bearingsim.runner.summary import chaos, repetitions, step_errors, unsettled
from bearingsim.runner.unknowns import assumed, moved
from bearingsim.study.uncertainty import NO_OIL, NO_SLIP, RIGID, sweeps_damping

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Findings:
    """Statements on results.

    withdrawn: promises that audits refuted; held: accuracy of the results; assumed: names of assumptions.
    """

    withdrawn: tuple[str, ...] = ()
    held: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()
    details: tuple[str, ...] = ()

    @property
    def everything(self) -> tuple[str, ...]:
        """All sentences."""
        return (*self.withdrawn, *self.held, *self.warnings, *self.details)


def findings(plan: Mapping[str, Any], frame: "pd.DataFrame") -> Findings:
    """Collect the statements on the results of a plan; ``frame``: of ``store.job_frame``."""
    own = frame.loc[[entry["job"] for entry in plan["jobs"] if not entry["variation"]]]
    info = store.info(own)
    of_damping = list(damping.of_jobs(info))
    warned = [text for text in (*of_damping, *_assumptions(plan)) if text.startswith(damping.WARNING)]
    drawn = list(dict.fromkeys(name for figure in plan["figures"] for name in figure["y"]))
    within = plan["accuracy"]["within"] if plan.get("accuracy") else inf
    flagged = chaos(own, drawn, min(store.NOTABLE, within / 2.0))
    return Findings(
        withdrawn=tuple(withdrawals(plan, frame)),
        held=(*(held(plan, frame) if plan.get("accuracy") else _step_errors(own)), *moved(plan, frame)),
        warnings=(
            *warned,
            *flagged,
            *step_errors(own),
            *unsettled(own),
            *without_value(info),
        ),
        assumed=tuple(_assumed(plan, own)),
        details=(
            *promises(plan, frame),
            *repetitions(info),
            *(text for text in of_damping if text not in warned),
            *(text for text in assumed(plan, frame) if text not in warned),
        ),
    )


def _step_errors(own: "pd.DataFrame") -> Iterator[str]:
    """Yield the largest changes that a shorter step makes, over the jobs whose step was checked."""
    names = {"line": "the line", "rms": "RMS", "force": "the largest force"}
    errors = {text: own[f"features/step_error.{name}"].max() for name, text in names.items() if _has(own, name)}
    if errors:
        each = ", ".join(f"{text} {100.0 * error:.2g} %" for text, error in errors.items())
        yield f"numerical errors, at most: {each}"


def _has(own: "pd.DataFrame", name: str) -> bool:
    return f"features/step_error.{name}" in own and bool(own[f"features/step_error.{name}"].notna().any())


def _assumed(plan: Mapping[str, Any], own: "pd.DataFrame") -> Iterator[str]:
    """Yield the names of uncertain quantities that have a single value in the study."""
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
        for sentence, name in ((RIGID, "rigid ring"), (NO_SLIP, "no slip"), (NO_OIL, "no oil drag"))
        if sentence in _assumptions(plan)
    )


def _assumptions(plan: Mapping[str, Any]) -> tuple[str, ...]:
    return tuple(plan.get("assumptions", ()))


def without_value(info: "pd.DataFrame") -> Iterator[str]:
    """Yield the features of other packages that have no value in some jobs.

    info: of finished jobs, a row each.
    """
    for column in (name for name in map(str, info) if name.startswith(NO_VALUE)):
        reasons = info[column][info[column] != ""]
        for reason, jobs in reasons.groupby(reasons):
            count = f"{len(jobs)} of {len(info)} jobs"
            feature = column.removeprefix(NO_VALUE)
            yield f"feature `{feature}` has no value in {count}: {reason} (for example {jobs.index[0]})"
