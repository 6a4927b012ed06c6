"""Error bounds and audits of a study with `accuracy`."""

import math
from typing import Any

import pandas as pd
import pytest

from bearingsim.runner.promises import accuracy_notes, withdrawals
from bearingsim.store.nearness import audit_results, error_bounds, feature_bounds, scales, withdrawn_errors
from bearingsim.study.uncertainty import RIGID_RING

LINE, RMS, FORCE = "velocity@BPFO", "velocity.rms", "outer_force.max"


def plan(of: list[str], error: dict[str, float] | None = None, **others: Any) -> dict[str, Any]:
    jobs = {name: {"model": "ring", "why": "", "error": error or {}} for name in ("a", "b", "c")}
    curves = others.pop("curves", [{"feature": name, "jobs": ["a", "b"]} for name in of])
    accuracy = {
        "within": 0.05,
        "of": of,
        "jobs": jobs,
        "curves": curves,
        "audits": others.pop("audits", []),
        "notes": [],
    }
    return {"accuracy": accuracy, "assumptions": [], **others}


def frame(columns: dict[str, list[float]], **others: list[Any]) -> pd.DataFrame:
    count = len(next(iter(columns.values())))
    index = pd.Index(list("abcde")[:count], name="job")
    feature_columns = {f"features/{name}": values for name, values in columns.items()}
    return pd.DataFrame(feature_columns | {"status": ["done"] * count} | others, index=index)


def test_no_error_bounds_without_an_accuracy() -> None:
    assert error_bounds({}, frame({LINE: [1.0]})).shape == (1, 0)


def test_errors_are_relative_to_the_lowest_maximum_of_the_curves() -> None:
    curves = [{"feature": LINE, "jobs": ["a", "b"]}, {"feature": LINE, "jobs": ["b", "c"]}]
    largest = scales(plan([LINE], curves=curves), frame({LINE: [1.0, 2.0, -5.0, 7.0]}), LINE)
    assert largest.tolist() == [2.0, 2.0, 5.0, 7.0]  # d is on no curve
    with_gap = scales(plan([LINE], curves=curves), frame({LINE: [1.0, math.nan, 5.0, 7.0]}), LINE)
    assert with_gap.tolist()[::2] == [1.0, 5.0]


@pytest.mark.parametrize("quantity", ["velocity", "displacement"])
def test_errors_of_a_quiet_line_are_relative_to_a_thousandth_of_the_rms(quantity: str) -> None:
    """At 2e-4 of the RMS 1 % of 1e-3 of the RMS is 5 % of the line; a loud line is its own reference."""
    columns = {
        LINE: [2e-4, 0.5],
        "displacement@BPFO": [4e-7, 1e-3],
        RMS: [1.0, 1.0],
        "step_error.line": [0.01, 0.01],
    }
    curves = [{"feature": f"{quantity}@BPFO", "jobs": [job]} for job in "ab"]
    results = frame(columns | {"error.start": [0.002, 0.002]}, **{"parameters/x": [1.0, 2.0]})
    parts = error_bounds(plan([f"{quantity}@BPFO"], curves=curves), results)
    assert parts["error.step"].loc[["a", "b"]].tolist() == pytest.approx([0.05, 0.01])
    assert parts["error.start"].loc[["a", "b"]].tolist() == pytest.approx([0.01, 0.002])


@pytest.mark.parametrize(
    ("feature", "column"),
    [
        (LINE, "line"),
        ("displacement@BPFI", "line"),
        (RMS, "rms"),
        ("acceleration.rms", "record"),
        ("displacement.rms", "record"),
        (FORCE, "force"),
    ],
)
def test_each_feature_has_its_step_error(feature: str, column: str) -> None:
    steps = {f"step_error.{name}": [0.5, 0.5, 0.5] for name in ("line", "rms", "force", "record")}
    bounds = error_bounds(
        plan([feature]), frame({feature: [1.0, 2.0, 4.0]} | steps | {f"step_error.{column}": [0.01] * 3})
    )
    assert bounds["error.step"].tolist() == pytest.approx([0.005, 0.01, 0.01])


def test_error_is_the_largest_sum_over_the_features() -> None:
    columns = {
        LINE: [1.0, 2.0, 2.0],
        RMS: [1.0, 1.0, 1.0],
        f"{LINE}-scatter": [0.1, 0.2, 0.0],
        "chaotic": [1.0, 1.0, 0.0],
        "rms_scatter": [0.0, 0.0, 0.0],
        "step_error.line": [0.01, 0.01, math.nan],
        "step_error.rms": [0.02, 0.0, 0.0],
    }
    bounds = error_bounds(plan([LINE, RMS], {LINE: 0.03, RMS: 0.001}), frame(columns))
    assert bounds["error.model"].tolist() == pytest.approx([0.03] * 3)
    assert bounds["error.step"].tolist() == pytest.approx([0.02, 0.01, 0.0])
    assert bounds["error.scatter"].tolist() == pytest.approx([0.05, 0.1, 0.0])
    assert bounds["error"].tolist() == pytest.approx([0.03 + 0.005 + 0.05, 0.03 + 0.01 + 0.1, 0.03])


@pytest.mark.parametrize(("feature", "suffix"), [(LINE, ""), (RMS, ".rms"), (FORCE, ".force")])
def test_the_error_of_the_start_is_added(feature: str, suffix: str) -> None:
    """The start error of a non-periodic motion includes the scatter, so only the excess is added."""
    columns = {f"error.start{name}": [0.5, 0.5, 0.5] for name in ("", ".rms", ".force")}
    columns |= {feature: [1.0, 2.0, 4.0], f"error.start{suffix}": [0.01, 0.02, 0.02], "chaotic": [0.0, 1.0, 1.0]}
    columns |= {f"{feature}-scatter": [0.0, 0.01, 0.2]} if feature == LINE else {"rms_scatter": [0.0] * 3}
    bounds = error_bounds(plan([feature]), frame(columns))
    assert bounds["error.start"].tolist() == pytest.approx(
        {LINE: [0.005, 0.015, 0.0], RMS: [0.005, 0.02, 0.02], FORCE: [0.005, 0.0, 0.0]}[feature]
    )
    assert bounds["error"].tolist() == pytest.approx(
        [0.005, 0.02, 0.05] if feature == LINE else [0.005, 0.02, 0.02]
    )


def test_unknown_error_of_nodes_leaves_no_total_error() -> None:
    goal = plan([LINE], {LINE: 0.01})
    goal["accuracy"]["jobs"]["a"]["nodes"] = {LINE: 0.02}
    goal["accuracy"]["jobs"]["b"]["nodes"] = {LINE: None}
    bounds = error_bounds(goal, frame({LINE: [1.0, 2.0, 2.0]}))
    assert bounds["error.nodes"].tolist() == pytest.approx([0.02, math.nan, 0.0], nan_ok=True)
    assert bounds["error"].tolist() == pytest.approx([0.03, math.nan, 0.01], nan_ok=True)


@pytest.mark.parametrize("assumptions", [[], [RIGID_RING]])
def test_case_counts_by_the_error_of_each_feature(assumptions: list[str]) -> None:
    """The error of the model of one feature is not added to the step error of another."""
    steps = {"step_error.line": [0.0] * 3, "step_error.rms": [0.03, 0.03, 0.06]}
    results = frame({LINE: [1.0] * 3, RMS: [1.0] * 3} | steps)
    goal = plan([LINE, RMS], {LINE: 0.03}) | {"assumptions": assumptions}
    expected = f"2 of 3 cases are within 5 % of the reference model, the others within 6 %; {RELATIVE}"
    assert next(iter(accuracy_notes(goal, results))) == expected


def test_remedies_apply_to_each_feature() -> None:
    """More nodes do not bring the line within 5 %; twice its scatter is 4 times the duration."""
    goal = plan([LINE, RMS])
    goal["accuracy"]["jobs"]["a"] |= {"error": {LINE: 0.06}, "nodes": {RMS: 0.03}}
    goal["accuracy"]["jobs"]["b"] |= {"error": {LINE: 0.03, RMS: 0.045}}
    columns = {LINE: [1.0] * 3, RMS: [1.0] * 3, f"{LINE}-scatter": [0.0, 0.04, 0.0], "chaotic": [0.0, 1.0, 0.0]}
    assert list(accuracy_notes(goal, frame(columns | {"rms_scatter": [0.0] * 3}))) == [
        f"1 of 3 cases are within 5 % of the reference model, the others within 7 %; {RELATIVE}",
        "  1 more would be within the accuracy with 4.0 times the `duration`",
    ]


RELATIVE = "relative to the largest value of the curve"


def test_more_nodes_are_recommended_where_they_suffice() -> None:
    goal = plan([LINE], {LINE: 0.01})
    for job, nodes in {"a": 0.03, "b": 0.045, "c": 0.5}.items():
        goal["accuracy"]["jobs"][job]["nodes"] = {LINE: nodes}
    goal["accuracy"]["jobs"]["c"]["error"] = {LINE: 0.06}  # too far off without more nodes
    assert list(accuracy_notes(goal, frame({LINE: [1.0, 2.0, 2.0]}))) == [
        f"1 of 3 cases are within 5 % of the reference model, the others within 56 %; {RELATIVE}",
        "  1 more would be within the accuracy with more `contact.length_nodes` (slices, harmonics)",
    ]


def test_chaotic_line_with_unknown_scatter_has_no_total_error() -> None:
    columns = {"velocity@2BSF": [1.0, 2.0, 2.0], RMS: [1.0, 1.0, 1.0], "chaotic": [1.0, 0.0, 0.0]}
    goal = plan(["velocity@2BSF", RMS], {RMS: 0.03})
    bounds = error_bounds(goal, frame(columns))
    assert bounds["error.scatter"].isna().tolist() == [True, False, False]
    assert bounds["error"].isna().tolist() == [True, False, False]
    assert bounds["error.model"].tolist() == [0.03] * 3
    notes = list(accuracy_notes(goal, frame(columns)))
    assert f"2 of 3 cases are within 5 % of the reference model; {RELATIVE}" in notes
    assert "1 chaotic case: standard error of a line unknown, and thus the accuracy" in notes


def test_no_total_error_for_a_ring_assumed_to_be_rigid() -> None:
    bounds = error_bounds(
        plan([LINE], {LINE: 0.03}) | {"assumptions": [RIGID_RING]}, frame({LINE: [1.0, 2.0, 2.0]})
    )
    assert bounds["error"].isna().all()
    assert bounds["error.model"].tolist() == [0.03] * 3


def test_failed_jobs_have_no_errors() -> None:
    bounds = error_bounds(
        plan([LINE], {LINE: 0.03}), frame({LINE: [1.0, 2.0, 2.0]}, status=["done", "failed", "done"])
    )
    assert bounds.loc["b"].isna().all()
    assert bounds["error"].notna().sum() == 2


AUDIT = [{"of": "a", "job": "d"}]


def test_difference_of_an_audit_is_relative_to_the_curve() -> None:
    (results,) = audit_results(plan([LINE], audits=AUDIT), frame({LINE: [1.0, 2.0, 2.0, 1.1]}))
    assert results == ("a", LINE, pytest.approx(0.05), 0.0)


@pytest.mark.parametrize("audit", [math.nan, None])
def test_audit_without_values_has_no_result(audit: float | None) -> None:
    """Otherwise it would count as within the accuracy."""
    healthy = f"{LINE}-healthy"
    columns = frame({healthy: [1.0, 2.0, 2.0, math.nan]} if audit is not None else {LINE: [1.0] * 4})
    assert not list(audit_results(plan([healthy], audits=AUDIT), columns))
    missing = frame({LINE: [1.0, 2.0, 2.0, 1.1]}, status=["done", "done", "done", "failed"])
    assert not list(audit_results(plan([LINE], audits=AUDIT), missing))


# An audit that fails


def test_failed_audit_withdraws_the_accuracy_of_its_curve() -> None:
    """Job `c` is on no curve, and keeps its own error."""
    goal = plan([LINE], {LINE: 0.01}, audits=AUDIT)
    results = frame({LINE: [1.0, 2.0, 2.0, 1.4]})  # a is 20 % of the curve's largest value off
    assert withdrawn_errors(goal, results) == pytest.approx({"a": 0.2, "b": 0.2})
    bounds = error_bounds(goal, results)
    assert bounds["error"].iloc[:3].tolist() == pytest.approx([0.2, 0.2, 0.01])
    assert bounds["error.model"].iloc[:3].tolist() == pytest.approx([0.2, 0.01, 0.01])
    assert list(withdrawals(goal, results)) == [
        "accuracy of 5 % withdrawn for 2 of 3 cases: velocity@BPFO is 20 % different from its reference",
        "  in job a; `model: reference` instead of `accuracy` computes all cases with the reference",
    ]
    assert list(accuracy_notes(goal, results)) == [
        "1 of the other 1 cases are within 5 % according to their trials"
    ]


def test_error_of_an_audited_case_is_at_least_the_difference_found() -> None:
    """Job `a` is 4 % of the largest value off, within the accuracy; its trial has promised 1 %."""
    goal = plan([LINE, RMS], {LINE: 0.01, RMS: 0.01}, audits=AUDIT)
    columns = {LINE: [1.0, 2.0, 2.0, 1.08], RMS: [1.0, 1.0, 1.0, 1.005]}
    bounds = error_bounds(goal, frame(columns))
    assert bounds["error"].iloc[:3].tolist() == pytest.approx([0.04, 0.01, 0.01])
    assert feature_bounds(goal, frame(columns)).loc["a"].to_dict() == pytest.approx({LINE: 0.04, RMS: 0.01})
    assert not withdrawn_errors(goal, frame(columns))


def test_scatter_explains_the_difference_of_an_audit() -> None:
    """Two standard errors of both runs are 0.02 of the largest value, the rest of 0.04 is due to the model."""
    goal = plan([LINE], {LINE: 0.01}, audits=AUDIT)
    scatter = 0.01 * 2.0 / 2.0**0.5
    columns = {
        LINE: [1.0, 2.0, 2.0, 1.08],
        f"{LINE}-scatter": [scatter, 0, 0, scatter],
        "chaotic": [1.0, 0, 0, 1.0],
    }
    assert error_bounds(goal, frame(columns))["error.model"].iloc[0] == pytest.approx(0.02 - scatter / 2.0)


@pytest.mark.parametrize(("audit", "is_failed"), [(1.099, False), (1.101, True), (0.901, False), (0.899, True)])
def test_audit_fails_beyond_the_accuracy(audit: float, is_failed: bool) -> None:
    goal, values = plan([LINE], audits=AUDIT), frame({LINE: [1.0, 2.0, 2.0, audit]})
    assert bool(withdrawn_errors(goal, values)) == is_failed
    assert any("of the reference" in text for text in accuracy_notes(goal, values)) != is_failed


def test_audit_passes_within_the_scatter_of_both_runs() -> None:
    columns = {LINE: [1.0, 2.0, 2.0, 1.4], f"{LINE}-scatter": [0.15, 0.0, 0.0, 0.1], "chaotic": [1.0] * 4}
    assert not withdrawn_errors(plan([LINE], audits=AUDIT), frame(columns))


@pytest.mark.parametrize(("baseline", "count"), [("d", 1), ("e", 0)])
def test_audit_of_a_change_includes_the_scatter_of_its_baselines(baseline: str, count: int) -> None:
    """Job `a` and its audit `c` differ by 0.3; two standard errors of 0.1 in each baseline are 0.28."""
    change = f"{LINE}-healthy"
    columns = {change: [1.0, 1.0, 1.3, math.nan, math.nan], LINE: [1.0] * 5, "chaotic": [0.0, 0.0, 0.0, 1.0, 1.0]}
    columns[f"{LINE}-scatter"] = [0.0, 0.0, 0.0, 0.1, 0.1]
    goal = plan([change], audits=[{"of": "a", "job": "c"}], curves=[])
    results = frame(columns, healthy=["d", "", baseline, "", ""])
    assert len(withdrawn_errors(goal, results)) == count


def test_failed_audit_withdraws_the_curve_of_its_feature_only() -> None:
    """The scatter of one feature does not excuse another."""
    curves = [{"feature": LINE, "jobs": ["a", "b"]}, {"feature": RMS, "jobs": ["a", "c"]}]
    goal = plan([LINE, RMS], audits=AUDIT, curves=curves)
    columns = {LINE: [1.0, 2.0, 2.0, 1.0], RMS: [1.0, 1.0, 1.0, 1.3]}
    scatter = {f"{LINE}-scatter": [9.0] * 4, "chaotic": [1.0] * 4, "rms_scatter": [0.0] * 4}
    assert withdrawn_errors(goal, frame(columns | scatter)) == pytest.approx({"a": 0.3, "c": 0.3})


def test_failed_audit_without_a_curve_withdraws_its_case_only() -> None:
    goal = plan([LINE], audits=AUDIT, curves=[])
    assert withdrawn_errors(goal, frame({LINE: [1.0, 2.0, 2.0, 1.4]})) == {"a": pytest.approx(0.4)}


def test_difference_of_a_failed_audit_is_no_bound_of_an_unknown_part() -> None:
    """Job `a` is 20 % of the largest value off; its error of nodes is unknown, that of `b` is zero."""
    goal = plan([LINE], {LINE: 0.01}, audits=AUDIT)
    goal["accuracy"]["jobs"]["a"]["nodes"] = {LINE: None}
    results = frame({LINE: [1.0, 2.0, 2.0, 1.4]})
    assert error_bounds(goal, results)["error"].iloc[:3].tolist() == pytest.approx(
        [math.nan, 0.2, 0.01], nan_ok=True
    )
    assert feature_bounds(goal, results)[LINE].tolist() == pytest.approx([math.inf, 0.2, 0.01])
    assert withdrawn_errors(goal, results) == pytest.approx({"a": 0.2, "b": 0.2})


def test_failed_audit_of_a_feature_leaves_the_bounds_of_others() -> None:
    """The RMS of `a` is 30 % off, its line 0.5 %."""
    goal = plan([LINE, RMS], {LINE: 0.01, RMS: 0.01}, audits=AUDIT)
    results = frame({LINE: [1.0, 2.0, 2.0, 1.01], RMS: [1.0, 1.0, 1.0, 1.3]})
    bounds = feature_bounds(goal, results)
    assert bounds[RMS].tolist() == pytest.approx([0.3, 0.3, 0.01])
    assert bounds[LINE].tolist() == pytest.approx([0.01] * 3)
    assert error_bounds(goal, results)["error"].iloc[:3].tolist() == pytest.approx([0.3, 0.3, 0.01])


def test_difference_of_a_failed_audit_is_relative_to_the_scale_of_each_job() -> None:
    """Job `a` is 2 um/s off, 20 % of the largest value of its curve; `c` also lies on a curve up to 1 um/s."""
    curves = [{"feature": LINE, "jobs": ["a", "b", "c"]}, {"feature": LINE, "jobs": ["c"]}]
    goal = plan([LINE], audits=AUDIT, curves=curves)
    results = frame({LINE: [8.0, 10.0, 1.0, 10.0]})
    assert feature_bounds(goal, results)[LINE].tolist() == pytest.approx([0.2, 0.2, 2.0])


def test_no_total_error_after_a_failed_audit_of_a_ring_assumed_to_be_rigid() -> None:
    """Bending may change the results by more than the difference found, which is reported all the same."""
    goal = plan([LINE], audits=AUDIT) | {"assumptions": [RIGID_RING]}
    results = frame({LINE: [1.0, 2.0, 2.0, 1.4]})
    assert error_bounds(goal, results)["error"].isna().all()
    assert any("velocity@BPFO is 20 % different" in text for text in withdrawals(goal, results))
