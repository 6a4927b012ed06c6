"""Errors and statements on results that are smaller or more certain than what is known."""

from math import inf, nan
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from bearingsim.plots.error_bounds import error_texts, numerical_errors, with_errors
from bearingsim.runner.promises import accuracy_notes, selection_notes, withdrawals
from bearingsim.runner.variations import variation_effects
from bearingsim.sensitivity import Effects, Estimate, describe_effects
from bearingsim.store import all_zero, is_zero, spread
from bearingsim.store.nearness import error_bounds, feature_bounds
from bearingsim.study.uncertainty import RIGID_RING
from tests.store.test_nearness import AUDIT, LINE, RMS, frame, plan

CHANGE = f"{LINE}-healthy"
ERRORS = {LINE: 0.01, RMS: 0.01}


def notes(goal: dict[str, Any], results: pd.DataFrame) -> str:
    return "\n".join(accuracy_notes(goal, results))


# A part that is unknown for one of several features


@pytest.mark.parametrize("scatter", [inf, nan])
def test_unknown_scatter_of_one_feature_is_not_replaced_by_that_of_another(scatter: float) -> None:
    """The scatter is infinite under 16 ball passes, NaN under two."""
    columns = {LINE: [1.0, 2.0, 2.0], RMS: [1.0] * 3, f"{LINE}-scatter": [scatter, 0.0, 0.0]}
    columns |= {"chaotic": [1.0, 0.0, 0.0], "rms_scatter": [0.0] * 3}
    goal, results = plan([LINE, RMS], ERRORS), frame(columns)
    bounds = error_bounds(goal, results)
    assert bounds["error"].isna().tolist() == [True, False, False]
    assert bounds["error.scatter"].isna().tolist() == [True, False, False]
    assert notes(goal, results).startswith("2 of 3 cases are within 5 %")


@pytest.mark.parametrize("columns", [{RMS: [1.0] * 3}, {RMS: [1.0] * 3, LINE: [nan, nan, nan]}])
def test_requested_feature_without_a_value_leaves_the_accuracy_unknown(columns: dict[str, list[float]]) -> None:
    """Lines other than multiples of BPFO are NaN in a short record."""
    goal, results = plan([LINE, RMS], ERRORS), frame(columns)
    assert error_bounds(goal, results)["error"].isna().all()
    assert notes(goal, results).startswith("0 of 3 cases are within 5 %")
    assert "3 cases: accuracy unknown, because a feature named in `of` has no value" in notes(goal, results)


def test_change_whose_healthy_baseline_failed_leaves_the_accuracy_unknown() -> None:
    """A healthy bearing, here `c`, has no change, and keeps the error of its other features."""
    results = frame({CHANGE: [1.0, nan, nan], RMS: [1.0] * 3}, healthy=["x", "y", ""])
    results.loc["x"] = {"status": "done", "healthy": "", f"features/{RMS}": 1.0}
    results[f"features/{LINE}"] = 1.0
    bounds = error_bounds(plan([CHANGE, RMS], {RMS: 0.01}), results)
    assert bounds["error"].iloc[:3].isna().tolist() == [False, True, False]


@pytest.mark.parametrize("of", [[LINE], [LINE, "outer_force.max"]])
def test_unknown_error_of_the_start_is_not_zero(of: list[str]) -> None:
    """It is NaN on a ramp, and with fewer than four ball passes."""
    columns = {LINE: [1.0] * 3, "outer_force.max": [1.0] * 3, "error.start": [nan, 0.0, 0.0]}
    goal, results = plan(of, {LINE: 0.01}), frame(columns | {"error.start.force": [0.0] * 3})
    assert error_bounds(goal, results)["error"].isna().tolist() == [True, False, False]
    assert "1 case: accuracy unknown, because `error.start` is unknown" in notes(goal, results)


# Errors of the healthy baseline


def change(**columns: list[float]) -> pd.DataFrame:
    """Return three jobs of amplitude 1 that differ from their baseline `d`, of amplitude 1.05, by 0.05."""
    values = {LINE: [1.0, 1.0, 1.0, 1.05], CHANGE: [0.05, 0.05, 0.05, nan]}
    return frame(values | columns, healthy=["d", "d", "d", ""])


def test_error_of_a_change_includes_that_of_its_baseline() -> None:
    goal = plan([CHANGE], {CHANGE: 0.001})
    step = error_bounds(goal, change(**{"step_error.line": [0.01, 0.0, 0.0, 0.02]}))
    assert step["error.step"].iloc[:3].tolist() == pytest.approx([0.62, 0.42, 0.42])
    start = error_bounds(goal, change(**{"error.start": [0.01, 0.0, 0.0, 0.02]}))
    assert start["error.start"].iloc[:3].tolist() == pytest.approx([0.62, 0.42, 0.42])
    chaos = {"chaotic": [1.0, 0.0, 0.0, 1.0], f"{LINE}-scatter": [0.04, 0.0, 0.0, 0.03]}
    assert error_bounds(goal, change(**chaos))["error.scatter"].iloc[:3].tolist() == pytest.approx([1.0, 0.6, 0.6])
    unknown = error_bounds(goal, change(**chaos | {f"{LINE}-scatter": [0.04, 0.0, 0.0, inf]}))
    assert unknown["error"].isna().all()


# Audits


def test_audit_of_a_value_of_zero_does_not_pass() -> None:
    """The model states 0, its reference 2 mm/s; 2e-3 is no relative difference."""
    goal, results = plan([LINE], audits=AUDIT), frame({LINE: [0.0, 0.0, 1.0, 2e-3]})
    assert "withdrawn for 2 of 3 cases" in "\n".join(withdrawals(goal, results))
    assert "audit: 0 of 1 jobs" in "\n".join(selection_notes(goal, results))


@pytest.mark.parametrize(
    ("columns", "status"),
    [
        ({LINE: [1.0, 2.0, 2.0, 1.0, nan]}, "failed"),
        ({LINE: [1.0, 2.0, 2.0, 1.0, nan]}, "done"),
        ({LINE: [1.0, nan, 2.0, 1.0, 2.0]}, "done"),
    ],
)
def test_audits_that_compare_nothing_are_counted(columns: dict[str, list[float]], status: str) -> None:
    goal = plan([LINE, RMS], audits=[{"of": "a", "job": "d"}, {"of": "b", "job": "e"}])
    results = frame(columns | {RMS: [1.0] * 5}, status=["done"] * 4 + [status])
    assert "1 of 2 audits failed, are missing or have no value" in "\n".join(selection_notes(goal, results))


# Statements


def test_the_others_do_not_include_cases_of_unknown_accuracy() -> None:
    goal = plan([LINE], {LINE: 0.01})
    for job, nodes in {"a": None, "b": 0.09}.items():
        goal["accuracy"]["jobs"][job]["nodes"] = {LINE: nodes}
    text = notes(goal, frame({LINE: [1.0, 2.0, 2.0]}))
    assert "1 of 3 cases are within 5 % of the reference model, 1 more within 10 %" in text
    assert "1 case: accuracy unknown, because `error.nodes` is unknown" in text
    assert "chaotic" not in text


def test_error_bar_has_no_unknown_part() -> None:
    """The audit of `a` finds a difference of 6 % of the largest value; the scatter of `b` is unknown."""
    columns = {LINE: [1.88, 2.0, 2.0, 2.0], "chaotic": [0.0, 1.0, 0.0, 0.0]}
    columns |= {f"{LINE}-scatter": [0.0, inf, 0.0, 0.0]}
    goal = plan([LINE], {LINE: 0.01}, audits=[{"of": "a", "job": "d"}])
    assert feature_bounds(goal, frame(columns))[LINE].tolist() == pytest.approx([0.06, inf, 0.01])


def test_error_bar_of_a_feature_is_the_sum_of_its_own_parts() -> None:
    """The model changes the line by 3 %, the step the RMS by 3 %: neither is off by 6 %.

    They are relative to the reference, also if that has a rigid ring.
    """
    columns = {LINE: [1.0, 1.0, 1.0], RMS: [1.0, 1.0, 1.0], "step_error.rms": [0.03, 0.0, 0.0]}
    goal = plan([LINE, RMS], {LINE: 0.03, RMS: 0.0}) | {"assumptions": [RIGID_RING]}
    bounds = feature_bounds(goal, frame(columns))
    assert bounds[LINE].tolist() == pytest.approx([0.03] * 3)
    assert bounds[RMS].tolist() == pytest.approx([0.03, 0.0, 0.0])


def test_start_error_is_not_the_part_of_a_study_with_an_accuracy() -> None:
    """The column of the table is the excess over the scatter, relative to the curve; the feature is 3 %."""
    values = {"error.start": pd.Series([0.03], index=["a"])}
    rows = pd.DataFrame({"job": ["a"], LINE: [1.0], "error.start": [0.0], "chaotic": [0.0]})
    results = SimpleNamespace(values=lambda name: values[name])
    [text] = error_texts(results, rows, [LINE])  # type: ignore[arg-type]
    assert text.startswith("start error of the")
    assert text.endswith("up to 3 % of its value (3 % of the largest)")


def test_caption_counts_unknown_errors() -> None:
    columns = {LINE: [1.0] * 3, f"{LINE}-scatter": [inf, 0.0, 0.0], "chaotic": [1.0, 0.0, 0.0]}
    rows = pd.DataFrame(columns | {RMS: [1.0] * 3, "step_error.line": [nan, 0.02, 0.001], "job": list("abc")})
    results = SimpleNamespace(values=lambda _: pd.Series(dtype=float))
    numerical, scatter = error_texts(results, rows, [LINE])  # type: ignore[arg-type]
    assert numerical.startswith("numerical error of the velocity amplitude at BPFO up to 2 % of its value")
    assert scatter == "statistical scatter of the velocity amplitude at BPFO unknown in 1 of 3"


def test_caption_names_the_scatter_of_chaotic_responses_and_the_effect_of_the_step_apart() -> None:
    """Two standard errors of 0.04 m/s, and 12 % of the RMS that the scatter hides."""
    columns = {LINE: [1.0, 1.0], f"{LINE}-scatter": [0.04, 0.0], RMS: [2.0, 2.0], "chaotic": [1.0, 0.0]}
    columns |= {
        "step_error.line": [nan, 0.001],
        "step_error.rms": [0.12, 0.001],
        "standard_error.rms": [0.002, nan],
    }
    results = SimpleNamespace(values=lambda _: pd.Series(dtype=float))
    rows = pd.DataFrame(columns | {"job": list("ab")})
    line, rms = error_texts(results, rows, [LINE, RMS])  # type: ignore[arg-type]
    assert line == (
        "statistical scatter of the velocity amplitude at BPFO up to 8 % of its value (8 % of the largest)"
    )
    assert rms.startswith("unresolved step error of the")
    assert rms.endswith("up to 12 % of its value (12 % of the largest)")


def test_response_within_rounding_has_no_numerical_error() -> None:
    """5e-18 m/s, of which rounding explains 5e-16 m/s; 1e-12 m/s is a motion."""
    columns = {RMS: [5e-18, 1e-12], "velocity.rounding": [5e-16, 5e-16], "chaotic": [0.0, 0.0]}
    rows = pd.DataFrame(columns | {"step_error.rms": [nan, 0.02], "job": list("ab")})
    errors = numerical_errors(SimpleNamespace(), rows, RMS)  # type: ignore[arg-type]
    assert errors is not None
    assert errors.step.tolist() == pytest.approx([0.0, 2e-14])
    assert is_zero(rows, RMS).tolist() == [True, False]
    assert not all_zero(rows, RMS)
    assert all_zero(rows[:1], RMS)


BAND = "velocity.rms@10-1000Hz"


@pytest.mark.parametrize(
    ("feature", "value", "zero"),
    [
        (LINE, 0.9e-5, True),  # 1 % of a thousandth of the RMS
        (LINE, 1.1e-5, False),
        (f"{LINE}.phase", 0.0, False),
        (f"{LINE}-scatter", 0.0, False),
        (f"{BAND}-healthy", 0.9e-7, True),
        (f"{BAND}-healthy", 1.1e-7, False),
        ("velocity.crest", 0.0, False),
        ("outer_force.max", 1e-9, False),
    ],
)
def test_value_is_zero_within_the_errors_of_its_kind(feature: str, value: float, zero: bool) -> None:
    rows = pd.DataFrame({RMS: [1.0], BAND: [1.0], "velocity.rounding": [1e-16]} | {feature: [value]})
    assert bool(is_zero(rows, feature).iloc[0]) == zero


@pytest.mark.parametrize(("velocity", "zero"), [(3.5e-8, False), (6e-9, True)])
@pytest.mark.parametrize("ending", ["", "-healthy"])
def test_line_of_any_quantity_is_zero_if_that_of_the_velocity_is(velocity: float, zero: bool, ending: str) -> None:
    """The RMS acceleration of impacts is of far higher frequencies than the line (30 Hz) of an inner defect."""
    names, omega = ("displacement@fr", "velocity@fr", "acceleration@fr"), 188.5
    amplitudes = dict(zip(names, (velocity / omega, velocity, omega * velocity), strict=True))
    levels = {"displacement.rms": 1e-7, RMS: 6.8e-4, "acceleration.rms": 13.0, "acceleration.rounding": 1e-4}
    changes = {f"{name}-healthy": value for name, value in amplitudes.items()}
    rows = pd.DataFrame([levels | amplitudes | changes])
    assert [bool(is_zero(rows, name + ending).iloc[0]) for name in names] == [zero] * 3


def test_line_without_that_of_the_velocity_is_relative_to_its_own_rms() -> None:
    rows = pd.DataFrame({"acceleration.rms": [1.0, 1.0], "acceleration@fr": [0.9e-5, 1.1e-5]})
    assert is_zero(rows, "acceleration@fr").tolist() == [True, False]


def test_chaotic_line_has_the_step_error_that_the_rms_resolves() -> None:
    """Its own is NaN, which is no error of zero."""
    columns = {LINE: [1.0] * 3, f"{LINE}-scatter": [0.0] * 3, "chaotic": [1.0, 0.0, 0.0]}
    columns |= {"step_error.line": [nan, 0.01, 0.0], "step_error.rms": [0.07, 0.03, 0.0]}
    bounds = error_bounds(plan([LINE]), frame(columns))
    assert bounds["error.step"].iloc[:3].tolist() == pytest.approx([0.07, 0.01, 0.0])


def test_error_of_a_phase_is_an_angle() -> None:
    """A relative error of 2 % of a complex amplitude turns it by up to 0.02 rad, its change by up to 0.08."""
    columns = {LINE: [1.0], f"{LINE}.phase": [3.0], CHANGE: [0.25], f"{CHANGE}.phase": [0.001]}
    rows = pd.DataFrame(columns | {"step_error.line": [0.02], "chaotic": [0.0], "job": ["a"]})
    results: Any = SimpleNamespace(values=lambda _: pd.Series(dtype=float))
    phase, change = error_texts(results, rows, [f"{LINE}.phase", f"{CHANGE}.phase"])
    assert phase == "numerical error of the velocity phase at BPFO up to 1.15°"
    assert change.endswith("up to 4.58°")
    assert not list(error_texts(results, rows.assign(**{"step_error.line": 0.002}), [f"{LINE}.phase"]))


def test_line_of_the_acceleration_has_the_relative_error_of_that_of_the_velocity() -> None:
    columns = {LINE: [1e-3], "acceleration@BPFO": [1.0], "step_error.line": [0.02], "chaotic": [0.0]}
    errors = numerical_errors(SimpleNamespace(), pd.DataFrame(columns), "acceleration@BPFO")  # type: ignore[arg-type]
    assert errors is not None
    assert errors.step.tolist() == pytest.approx([0.02])


def test_caption_does_not_count_cases_without_a_value() -> None:
    columns = {LINE: [1.0, 1.0, nan], "step_error.line": [0.001, 0.02, nan], "chaotic": [0.0] * 3}
    results = SimpleNamespace(values=lambda _: pd.Series(dtype=float))
    [text] = error_texts(results, pd.DataFrame(columns | {"job": list("abc")}), [LINE])  # type: ignore[arg-type]
    assert text.endswith("up to 2 % of its value (2 % of the largest)")


def test_numerical_error_of_a_change_is_that_of_the_whole_value() -> None:
    """1 % of 2 m/s, of which 0.5 m/s are the change from healthy."""
    columns = {LINE: [2.0], CHANGE: [0.5], "step_error.line": [0.01], "chaotic": [0.0]}
    errors = numerical_errors(SimpleNamespace(), pd.DataFrame(columns), CHANGE)  # type: ignore[arg-type]
    assert errors is not None
    assert errors.step.tolist() == pytest.approx([0.02])


def test_error_bars_are_relative_to_the_largest_value_of_the_curve() -> None:
    """1 % of 2 m/s for `a` and `b`; `c` is on no curve, so its bar is relative to its own value."""
    goal, results = plan([LINE], {LINE: 0.01}), frame({LINE: [1.0, 2.0, 5.0]})
    stored: Any = SimpleNamespace(plan=goal, frame=results, has_feature=lambda _: True)
    rows = with_errors(stored, pd.DataFrame({"job": ["c", "b", "a"]}), [LINE])
    assert rows[f"error {LINE}"].tolist() == pytest.approx([0.05, 0.02, 0.02])


# Variations


VARIED = {
    "variations": [
        {"of": of, "what": "damping", "value": 1e-6, "job": job} for of, job in {"a": "c", "b": "d"}.items()
    ]
}


def test_finished_variation_without_a_value_is_reported() -> None:
    texts = list(variation_effects(VARIED, frame({LINE: [1.0, 1.0, 1.1, nan]}), [LINE]))
    assert f"1 of 2 cases have no range of {LINE}: a variation of the damping has no value of it" in texts


# Sensitivity


def test_small_effects_are_not_printed_as_zero() -> None:
    """For example those of the cage slip, a share."""
    estimate = Estimate(*(np.array([value, 1e-6]) for value in (0.004, 0.003, 0.005)))
    assert "mu* 0.004 (0.003 to 0.005)" in describe_effects(Effects(estimate, estimate, estimate), "x", ["p", "q"])


def test_unknown_effect_is_not_stated_as_a_limit() -> None:
    """A range relative to zero is unknown; that of the RMS is 50 % in the case `b`."""
    results = frame({LINE: [0.0, 0.0, 1.0, 1.0], "velocity.rms": [1.0, 1.0, 1.1, 1.5]})
    [text] = variation_effects(VARIED, results, [LINE, "velocity.rms"])
    assert f"changes {LINE} by an unknown amount, velocity.rms by up to 50 % (" in text


def test_case_without_a_value_has_no_range() -> None:
    """The range of its variations alone could be taken for that of the case."""
    assert spread(VARIED, frame({LINE: [nan, 1.0, 3.0, 1.2]}), LINE).index.tolist() == ["b"]


def test_unknown_scatter_of_an_extreme_value_is_not_that_of_a_chaotic_line() -> None:
    """Job `a` ended early: its largest force might be larger in a longer record."""
    force = "outer_force.max"
    early: dict[str, list[float]] = {"info/passes": [200] * 3, "info/passes_computed": [100, 200, 200]}
    early |= {"info/standard_error_rms": [0.01] * 3, "info/standard_error_line": [0.01] * 3}
    goal, results = plan([force], {force: 0.01}), frame({force: [1.0] * 3, "chaotic": [0.0] * 3}, **early)
    assert error_bounds(goal, results)["error"].isna().tolist() == [True, False, False]
    assert notes(goal, results).splitlines()[1:] == [
        "1 case: accuracy unknown, because `error.scatter` is unknown"
    ]


def test_numerical_error_of_a_quiet_line_is_relative_to_a_thousandth_of_the_rms() -> None:
    """At 2e-4 of an RMS of 1 an error of 1 % of 1e-3."""
    rows = pd.DataFrame({LINE: [2e-4], "velocity.rms": [1.0], "step_error.line": [0.01], "chaotic": [0.0]})
    rows[f"{LINE}-scatter"] = 0.0
    error = numerical_errors(None, rows, LINE)  # type: ignore[arg-type]
    assert error is not None
    assert error.step.tolist() == pytest.approx([1e-5])
