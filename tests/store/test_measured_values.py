"""Measured features beside simulated ones: equal parameters, interpolation, factor."""

from math import isclose, pi
from types import SimpleNamespace
from typing import Any

import pandas as pd
import pytest

from bearingsim.report.measured import DIFFERENCE, make_measured_tables
from bearingsim.store.measured import difference, measured_sets

LINE, ENVELOPE, KURTOSIS = "velocity@BPFO", "envelope@BPFO", "velocity.kurtosis"


def table(widths=(1.0,), loads=(100.0, 200.0, 300.0)) -> pd.DataFrame:
    """Return cases whose line is 2 load + width."""
    rows = [
        {"job": f"{width}{load}", "status": "done", "load": load, "width": width, LINE: 2 * load + width}
        for width in widths
        for load in loads
    ]
    healthy = {"job": "healthy", "status": "done", "load": 100.0, "width": float("nan"), LINE: 7.0}
    return pd.DataFrame([*rows, healthy])


def sets(points, rows, scale=False):
    jobs = [{"job": job, "twin": job == "healthy"} for job in rows["job"]]
    entry = {"label": "rig", "scale": scale, "points": [{"place": "p", **point} for point in points]}
    return measured_sets({"measured": [entry], "jobs": jobs, "units": {"load": "N", "width": "mm"}}, rows)


def test_a_point_is_compared_with_the_case_at_its_parameters():
    (entry,) = sets(
        [{"parameters": {"load": 200.0 * (1 + 1e-8), "width": 1.0}, "features": {LINE: 5.0}}], table((1.0, 2.0))
    )
    assert [(item.job, item.simulated) for item in entry.comparisons] == [("1.0200.0", 401.0)]


def test_a_point_between_cases_is_compared_with_the_straight_line():
    (entry,) = sets([{"parameters": {"load": 230.0, "width": 1.0}, "features": {LINE: 5.0}}], table())
    (item,) = entry.comparisons
    assert item.job == ""
    assert isclose(item.simulated, 461.0)


def test_phases_are_compared_on_the_shorter_arc():
    rows, phase = table(), f"{LINE}.phase"
    rows[phase] = [3.0, -2.9, -2.0, 0.0][: len(rows)]
    (entry,) = sets([{"parameters": {"load": 150.0, "width": 1.0}, "features": {phase: 3.0}}], rows)
    (item,) = entry.comparisons
    halfway = 3.0 + 0.5 * (2.0 * pi - 5.9) - 2.0 * pi  # from 3 to -2.9 + 2 pi
    assert isclose(item.simulated, halfway)
    assert isclose(difference(phase, -3.0, 3.0), 2.0 * pi - 6.0)
    assert difference(LINE, -3.0, 3.0) == -6.0


def test_phases_have_a_difference_but_no_ratio():
    """-3 rad are 16.2 deg past 3 rad; the ratio of two phases depends on their zero."""
    rows, phase = table(), f"{LINE}.phase"
    rows[phase] = -3.0
    features = {phase: 3.0, LINE: 100.5}
    opened = sets([{"parameters": {"load": 100.0, "width": 1.0}, "features": features}], rows)
    results: Any = SimpleNamespace(plan={"units": {"load": "N", "width": "mm"}}, measured=opened)
    [shown] = make_measured_tables(results)
    difference_column = shown.headers.index(DIFFERENCE)
    ratios = {row[0]: tuple(row[difference_column : difference_column + 2]) for row in shown.rows}
    assert ratios == {phase: ("16.23", "-"), LINE: ("100.5", "2")}


@pytest.mark.parametrize("parameters", [{"load": 90.0, "width": 1.0}, {"load": 310.0, "width": 1.0}])
def test_a_point_outside_the_cases_is_not_compared(parameters):
    (entry,) = sets([{"parameters": parameters, "features": {LINE: 5.0}}], table())
    assert not entry.comparisons


def test_a_point_off_two_parameters_is_not_compared():
    (entry,) = sets([{"parameters": {"load": 150.0, "width": 1.5}, "features": {LINE: 5.0}}], table((1.0, 2.0)))
    assert not entry.comparisons


def test_a_point_that_leaves_a_parameter_open_is_compared_at_each_of_its_values():
    (entry,) = sets([{"parameters": {"load": 150.0}, "features": {LINE: 5.0}}], table((1.0, 2.0)))
    assert [(item.others["width"], item.simulated) for item in entry.comparisons] == [(1.0, 301.0), (2.0, 302.0)]


def test_cases_that_are_not_done_and_healthy_ones_are_not_compared():
    rows = table()
    rows.loc[1, "status"] = "failed"
    (entry,) = sets([{"parameters": {"load": 200.0}, "features": {LINE: 5.0}}], rows)
    assert [item.simulated for item in entry.comparisons] == [401.0]  # between 100 N and 300 N
    assert all(item.job != "healthy" for item in entry.comparisons)


def test_the_factor_is_the_median_ratio_and_acts_by_the_power_of_a_feature():
    rows = table()
    rows[ENVELOPE], rows[KURTOSIS] = 16.0, 3.0
    ratios = (2.0, 4.0, 40.0)
    points = [
        {"parameters": {"load": load}, "features": {LINE: (2 * load + 1) / ratio}}
        for load, ratio in zip((100.0, 200.0, 300.0), ratios, strict=True)
    ]
    (entry,) = sets(points, rows, scale=True)
    assert isclose(entry.factor, 4.0)
    assert isclose(entry.scaled(LINE, 1.0), 4.0)
    assert isclose(entry.scaled(ENVELOPE, 1.0), 16.0)
    assert entry.scaled(KURTOSIS, 3.0) == 3.0
    assert entry.legend == "rig, times 4"
    (squared,) = sets([{"parameters": {"load": 100.0}, "features": {ENVELOPE: 1.0}}], rows, scale=True)
    assert isclose(squared.factor, 4.0)


def test_nothing_is_scaled_without_request():
    (entry,) = sets([{"parameters": {"load": 100.0}, "features": {LINE: 5.0}}], table())
    assert entry.factor == 1.0
    assert entry.legend == "rig"
