"""Datasets of xarray over a grid of the swept values."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bearingsim import store
from bearingsim.store import Results
from tests.scenes.fake_studies import PROVENANCE, FakeJob, FakeStudy, record_of

LOADS = [150.0, 300.0]


class GridStudy(FakeStudy):
    """Study whose cases, in order, have the swept values ``values``."""

    values: list[dict[str, Any]]

    def jobs(self) -> list[FakeJob]:
        *jobs, healthy = super().jobs()
        cases = zip(jobs, self.values, strict=True)
        swept = [FakeJob(job.id, job.case, values, job.healthy) for job, values in cases]
        return [*swept, FakeJob(healthy.id, healthy.case, {"load": 150.0}, None, is_baseline=True)]


def results_of(root: Path, values: list[dict[str, Any]], done: int | None = None) -> Results:
    """Store the first ``done`` cases with these swept values, whose widths are 1, 2, ... mm."""
    study = GridStudy([1e-3 * (1 + index) for index in range(len(values))])
    study.values = values
    jobs = study.jobs()
    store.write_plan(root, study, jobs)  # type: ignore[arg-type]
    stored = [(job, record_of(job.case)) for job in (*jobs[: len(values) if done is None else done], jobs[-1])]
    store.write_units(root, stored, PROVENANCE)  # type: ignore[arg-type]
    return store.open_results(root)


def test_each_swept_path_is_a_dimension(tmp_path: Path) -> None:
    values = [{"load": load, "model": model} for load in LOADS for model in ("static", "ring", "rollers")]
    results = results_of(tmp_path, values)
    data = results.to_xarray(grid=True)
    assert dict(data.sizes) == {"load": 2, "model": 3, "time": 205}
    assert list(data["model"].values) == ["static", "ring", "rollers"]  # as in the study
    assert data["load"].attrs["units"] == "N"
    assert data["ring.velocity.y"].attrs["units"] == "m/s"
    job = str(data["job"].sel(load=300.0, model="ring").item())
    assert list(results.table().set_index("job").loc[job, ["load", "model"]]) == [300.0, "ring"]
    np.testing.assert_array_equal(
        data["ring.velocity.y"].sel(load=300.0, model="ring"), results.series(job)["ring.velocity.y"]
    )
    assert data["velocity@BPFO"].sel(load=300.0, model="ring") == results.table()["velocity@BPFO"][4]


def test_paths_that_vary_together_share_a_dimension(tmp_path: Path) -> None:
    sizes = [(1e-3, 1e-5), (2e-3, 2e-5), (3e-3, 2e-5)]
    values = [
        {"defect.depth": depth, "defect.width": width, "load": load} for width, depth in sizes for load in LOADS
    ]
    data = results_of(tmp_path, values).to_xarray(grid=True)
    assert dict(data.sizes) == {"defect.width": 3, "load": 2, "time": 205}
    assert data["defect.depth"].dims == ("defect.width",)
    assert data["defect.depth"].values.tolist() == [1e-5, 2e-5, 2e-5]


@pytest.mark.parametrize("widths", [(1e-3, 2e-3), (1e-3, 3e-3)])
def test_path_that_follows_from_two_others_is_a_coordinate_over_both(
    tmp_path: Path, widths: tuple[float, float]
) -> None:
    """With 1 and 2 mm two combinations of load and width have one depth; with 1 and 3 mm all differ."""
    values = [
        {"load": load, "defect.width": width, "defect.depth": load * width} for load in LOADS for width in widths
    ]
    data = results_of(tmp_path, values).to_xarray(grid=True)
    assert dict(data.sizes) == {"load": 2, "defect.width": 2, "time": 205}
    assert data["defect.depth"].dims == ("load", "defect.width")
    np.testing.assert_array_equal(data["defect.depth"], np.outer(LOADS, widths))


def test_jobs_that_are_not_done_are_nan(tmp_path: Path) -> None:
    values = [{"load": load, "model": model} for load in LOADS for model in ("static", "ring")]
    data = results_of(tmp_path, values, done=3).to_xarray(grid=True)
    missing = data.sel(load=300.0, model="ring")
    assert np.isnan(missing["velocity@BPFO"])
    assert np.isnan(missing["ring.velocity.x"]).all()
    assert missing["job"].item() == ""
    assert int(np.isnan(data["velocity@BPFO"]).sum()) == 1


def test_named_job_that_is_not_done_is_nan_on_a_grid(tmp_path: Path) -> None:
    results = results_of(tmp_path, [{"load": load} for load in LOADS], done=1)
    unfinished = results.jobs[1]
    data = results.to_xarray(results.jobs[:2], grid=True)
    assert np.isnan(data["velocity@BPFO"].values).tolist() == [False, True]
    assert np.isnan(data["ring.velocity.x"].sel(load=300.0)).all()
    with pytest.raises(store.ResultsError, match=f"job {unfinished} has no series"):
        results.to_xarray([unfinished])


def test_unknown_jobs_are_listed(tmp_path: Path) -> None:
    results = results_of(tmp_path, [{"load": load} for load in LOADS])
    with pytest.raises(store.ResultsError, match="unknown jobs: a, b"):
        results.to_xarray(["b", results.jobs[0], "a"])


def test_a_single_value_is_a_dimension_too(tmp_path: Path) -> None:
    values = [{"load": load, "clearance": 1e-5} for load in LOADS]
    assert dict(results_of(tmp_path, values).to_xarray(grid=True).sizes) == {
        "load": 2,
        "clearance": 1,
        "time": 205,
    }


GRID = [{"load": load, "model": model} for load in LOADS for model in ("static", "ring")]


@pytest.mark.parametrize(
    ("values", "count"),
    [
        (GRID[:3], "cases 3, 3 of 4"),
        ([GRID[0], *GRID[:3]], "cases 4, 3 of 4"),
        ([{"load": load} for load in (*LOADS, 150.0)], "cases 3, 2 of 2"),
    ],
)
def test_cases_that_are_no_full_grid_are_refused(tmp_path: Path, values: list[dict[str, Any]], count: str) -> None:
    results = results_of(tmp_path, values)
    with pytest.raises(
        store.ResultsError, match=f"not form a full grid: values of `load` 2.*; {count} combinations"
    ):
        results.to_xarray(grid=True)
    assert dict(results.to_xarray().sizes) == {"job": 1 + len(values), "time": 205}


def test_channel_that_some_jobs_lack_is_nan_there(tmp_path: Path) -> None:
    """The healthy baseline of a study that records slices has no slices, or no series."""
    study = FakeStudy()
    records = [(job, record_of(job.case)) for job in study.jobs()]
    records[1][1].series["ring.acceleration.x"] = records[1][1].series.pop("ring.velocity.y")
    records[3][1].series.clear()
    store.write_plan(tmp_path, study, study.jobs())  # type: ignore[arg-type]
    store.write_units(tmp_path, records, PROVENANCE)
    results = store.open_results(tmp_path)
    data = results.to_xarray()
    expected = {
        "ring.velocity.x": [False, False, False, True],
        "ring.velocity.y": [False, True, False, True],
        "ring.acceleration.x": [True, False, True, True],
    }
    assert {name: np.isnan(data[name].values).all(axis=1).tolist() for name in expected} == expected
    job, other = results.jobs[1], "ring.acceleration.x"
    np.testing.assert_array_equal(data[other].sel(job=job), results.series(job)[other])
    assert set(expected) <= set(results.to_xarray(results.jobs[::-1]))
    twice = results.to_xarray([job, results.jobs[0], job])
    assert twice["job"].values.tolist() == [job, results.jobs[0]]
