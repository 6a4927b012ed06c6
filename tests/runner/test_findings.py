"""Warnings at the end of a run: chaotic results, step errors, and records whose parts differ."""

import math
from typing import Any

import pandas as pd
import pytest

from bearingsim.runner.findings import (
    assumption_notes,
    findings,
    rest_notes,
    scatter_warnings,
    step_warnings,
    transient_warnings,
    unknown_transients,
)

JOB = "0" * 16


def warnings(within: float | None, error: float) -> tuple[str, ...]:
    """Return the warnings of one chaotic job, whose line has a relative standard error."""
    features = {"velocity@BPFO": 1.0, "velocity@BPFO-scatter": error, "velocity.rms": 1.0, "rms_scatter": 0.0}
    row = {**features, "chaotic": 1.0, "standard_error.line": error, "standard_error.rms": 0.0}
    frame = pd.DataFrame([row], index=[JOB]).add_prefix("features/").assign(status="done")
    accuracy = {"within": within, "of": ["velocity@BPFO"], "jobs": {}, "curves": [], "audits": [], "notes": []}
    plan = {
        "jobs": [{"job": JOB, "healthy": "", "twin": False, "variation": False, "swept": {}}],
        "figures": [{"y": ["velocity@BPFO"], "x": "load"}],
        "units": {},
        "accuracy": None if within is None else accuracy,
    }
    return findings(plan, frame).warnings


@pytest.mark.parametrize(
    ("within", "error", "is_flagged"),
    [(None, 0.004, False), (None, 0.006, True), (0.05, 0.006, True), (0.006, 0.004, True), (0.006, 0.002, False)],
)
def test_chaotic_result_is_reported_relative_to_the_accuracy(
    within: float | None, error: float, is_flagged: bool
) -> None:
    assert any("chaotic" in text for text in warnings(within, error)) == is_flagged


def test_record_whose_parts_differ_is_reported_with_its_remedy() -> None:
    """A longer record helps a short one with a rotating defect, where a longer `settle` does not."""
    frame = pd.DataFrame(
        {"features/error.start": [0.03, 0.002, 0.02], "features/error.start.rms": [0.0, 0.001, 0.05]}
    )
    assert list(transient_warnings(frame)) == [
        "2 jobs: error of the velocity line up to 3 % (`error.start`), of the velocity RMS up to 5 %"
        " (`error.start.rms`), because the record is short or not settled; use a longer `duration` or `settle`"
        " (docs/settling.md)"
    ]
    frame["features/error.start"] = 0.003  # an error within 1 % is not attributed to the line
    assert [text.partition(",")[0] for text in transient_warnings(frame)] == [
        "1 job: error of the velocity RMS up to 5 % (`error.start.rms`)"
    ]
    frame["features/cage.slip.mean"] = 0.1  # scatter of a free cage is reported as a standard error
    assert not list(transient_warnings(frame))


def test_record_too_short_to_show_its_error_is_reported_except_on_a_ramp() -> None:
    frame = pd.DataFrame(
        {
            "features/velocity.rms": [1.0, 1.0, 1.0, math.nan],  # the last job failed
            "features/error.start.rms": [math.nan, 0.2, math.nan, math.nan],
            "parameters/ramp.to": [math.nan, math.nan, 100.0, math.nan],
        }
    )
    assert [text.partition(" (")[0] for text in unknown_transients(frame)] == ["1 job: unknown error of the start"]


def test_models_without_a_method_have_an_unknown_step_error() -> None:
    entries = [{"job": job, "healthy": "", "twin": False, "variation": False, "swept": {}} for job in "ab"]
    columns = {"info/method": ["", "verlet"], "features/step_error.line": [math.nan, 0.001], "status": "done"}
    plan = {"jobs": entries, "figures": [], "units": {}, "accuracy": None}
    texts = findings(plan, pd.DataFrame(columns, index=["a", "b"])).accuracy
    assert any(
        text.startswith("1 of 2 jobs: step error unknown, because the model has no method") for text in texts
    )


@pytest.mark.parametrize(
    ("features", "statement"),
    [({"velocity@BPFO-scatter": float("inf")}, "unknown; try a longer `duration`"), ({}, "not estimated")],
)
def test_longer_duration_is_advised_only_where_the_error_is_estimated(
    features: dict[str, float], statement: str
) -> None:
    row = {"velocity@BPFO": 1.0, "chaotic": 1.0, **features}
    frame = pd.DataFrame([row], index=[JOB]).add_prefix("features/")
    [text] = scatter_warnings(frame, ["velocity@BPFO"])
    assert text == f"1 of 1 jobs chaotic: standard error of velocity@BPFO {statement}"


def test_responses_within_rounding_are_counted() -> None:
    columns = {"features/velocity.rms": [5e-18, 1e-12], "features/velocity.rounding": [5e-16, 5e-16]}
    [text] = rest_notes(pd.DataFrame(columns))
    assert text == "1 of 2 responses are zero within rounding (`velocity.rounding`)"


def test_step_errors_of_chaotic_jobs_are_stated_apart() -> None:
    """Their scatter hides effects of the step up to 29 %, which is no step error of the study."""
    columns = {"chaotic": [1.0, 0.0], "step_error.line": [0.14, 0.002], "step_error.rms": [0.29, 0.001]}
    columns |= {"rms_scatter": [0.37, 0.0]}
    frame = pd.DataFrame(columns, index=[JOB, "1" * 16]).add_prefix("features/").assign(status="done")
    jobs = [{"job": job, "healthy": "", "twin": False, "variation": False, "swept": {}} for job in frame.index]
    plan = {"jobs": jobs, "figures": [{"y": ["velocity@BPFO"], "x": "load"}], "units": {}, "accuracy": None}
    chaos = "1 of 2 jobs are chaotic, so only their RMS is checked: scatter"
    effect = "effect of the step, as far as resolved, up to 29 % (`step_error.rms`)"
    statements = findings(plan, frame).statements
    assert "largest step errors: velocity line 0.2 %, velocity RMS 0.1 %" in statements
    assert f"{chaos} up to 37 % (`rms_scatter`), {effect}" in statements
    frame.loc[JOB, "features/rms_scatter"] = float("inf")  # pilot too short
    assert f"{chaos} unknown in 1 (`rms_scatter`), {effect}" in findings(plan, frame).statements
    frame["features/chaotic"] = 0.0
    assert not any("chaotic" in text for text in findings(plan, frame).statements)


@pytest.mark.parametrize(
    ("line", "rms", "texts"),
    [
        ([], [], []),
        ([0.001, 0.0], [0.0, 0.0], []),
        (
            [0.02, 0.04, 0.0],
            [0.0, 0.0, 0.0],
            [
                "2 of 3 jobs chaotic: standard error of velocity@BPFO up to 4 %;"
                " a `duration` 64 times as long reduces it to 0.5 % (docs/step-check.md)"
            ],
        ),
        (
            [0.02],
            [0.05],
            [
                "1 of 1 jobs chaotic: standard error of velocity@BPFO (and 1 more) up to 5 %;"
                " a `duration` 100 times as long reduces it to 0.5 % (docs/step-check.md)"
            ],
        ),
        (
            [math.inf, 0.0],
            [0.01, 0.0],
            [
                "1 of 2 jobs chaotic: standard error of velocity.rms up to 1 %;"
                " a `duration` 4 times as long reduces it to 0.5 % (docs/step-check.md)",
                "1 of 2 jobs chaotic: standard error of velocity@BPFO unknown; try a longer `duration`",
            ],
        ),
    ],
)
def test_chaotic_jobs_are_reported_with_a_remedy(line: list[float], rms: list[float], texts: list[str]) -> None:
    features = {"velocity@BPFO": 2.0, "velocity@BPFO-scatter": 1.0, "velocity.rms": 3.0, "rms_scatter": 1.0}
    frame = pd.DataFrame(
        {**features, "standard_error.line": line, "standard_error.rms": rms, "chaotic": 1.0}, range(len(line))
    )
    assert list(scatter_warnings(frame.add_prefix("features/"))) == texts
    assert not list(scatter_warnings(frame.assign(chaotic=0.0).add_prefix("features/")))
    assert not list(scatter_warnings(pd.DataFrame({"status": ["failed"]})))


def test_error_of_a_change_in_a_band_is_that_of_its_own_value() -> None:
    """1 % of an RMS of 10 m/s^2 is 2 % of a change by 5 m/s^2, whatever the RMS of the velocity is."""
    name = "acceleration.rms@10-1000Hz-healthy"
    features = {"velocity.rms": 1e-3, "standard_error.rms": 0.01, "rms_scatter": 0.025, "chaotic": 1.0}
    features |= {name: 5.0, name.removesuffix("-healthy"): 10.0}
    frame = pd.DataFrame([features], index=[JOB]).add_prefix("features/")
    [text] = scatter_warnings(frame, [name])
    assert f"standard error of {name} up to 2 %; a `duration` 16 times as long" in text


@pytest.mark.parametrize(
    ("errors", "parts"),
    [
        ([0.009, math.nan], []),
        ([0.02, 0.035], ["2 jobs: the RMS of displacement, acceleration or a recorded channel", "up to 3.5 %"]),
    ],
)
def test_step_error_of_a_record_is_reported(errors: list[float], parts: list[str]) -> None:
    """It is an RMS, so that it is reported for a chaotic motion, too; a largest force is not."""
    columns = {"features/step_error.record": errors, "features/chaotic": [0.0, 1.0]}
    columns |= {"features/step_error.force": [math.nan, 0.5]}
    texts = list(step_warnings(pd.DataFrame(columns)))
    assert len(texts) == bool(parts)
    assert all(part in texts[0] for part in parts)
    assert not list(step_warnings(pd.DataFrame({"status": ["failed"]})))


def test_cost_of_varying_the_damping_names_the_finished_cases() -> None:
    """Three values of each of two cases that are done; the third has neither a cost nor a count."""
    rows = {
        "info/damping_time_s": [2.5e-6, 2.5e-6, float("nan")],
        "info/cpu_s": [1.0, 2.0, float("nan")],
        "status": ["done", "done", "missing"],
    }
    frame = pd.DataFrame(rows, index=["a", "b", "c"])
    jobs = [{"job": job, "twin": False, "variation": False} for job in frame.index]
    plan: dict[str, Any] = {"jobs": jobs, "units": {}}
    [text] = [note for note in assumption_notes(plan, frame) if note.startswith("damping not varied")]
    assert text.endswith("adds 6 jobs for the 2 finished of 3 cases, 9 s")
    plan["jobs"] = jobs[:2]
    [text] = [note for note in assumption_notes(plan, frame) if note.startswith("damping not varied")]
    assert text.endswith("adds 6 jobs, 9 s")
