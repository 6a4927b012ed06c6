"""Table of the results, plan, series and parameters of a results folder."""

import os
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from filelock import FileLock

from bearingsim import store
from bearingsim.store import files
from tests.scenes.fake_studies import FakeStudy, record_of, store_jobs
from tests.scenes.reading import EVERY_DIGIT

# The table


def test_table_has_one_row_per_job_in_order(tmp_path: Path, study: FakeStudy) -> None:
    store_jobs(tmp_path, study, study.jobs()[2:])
    failure = store.Failure(study.jobs()[0].id, "no steady state", attempts=2)
    failure.write(tmp_path)
    store.build_table(tmp_path)
    table = store.open_results(tmp_path).table()
    assert list(table["job"]) == [job.id for job in study.jobs()]
    assert list(table["status"]) == ["failed", "missing", "done", "done"]
    assert list(table["reason"]) == ["no steady state", "", "", ""]
    np.testing.assert_array_equal(table["defect.width"], [1e-3, 2e-3, 3e-3, np.nan])
    np.testing.assert_array_equal(table["velocity@BPFO"], [np.nan, np.nan, 3e-3, 1e-3])
    assert store.open_results(tmp_path).failures() == {failure.job: failure}


def test_difference_from_the_healthy_case_is_complex(tmp_path: Path, study: FakeStudy) -> None:
    store_jobs(tmp_path, study)
    table = store.open_results(tmp_path).table()
    expected = [abs(1j * width - 1e-3) for width in study.widths]  # a quarter turn from a healthy 1 mm/s
    np.testing.assert_allclose(table["velocity@BPFO-healthy"], [*expected, np.nan], rtol=1e-12)
    assert "velocity.rms-healthy" not in table


def test_csv_reads_back_exactly(tmp_path: Path, study: FakeStudy) -> None:
    import pandas as pd

    store_jobs(tmp_path, study)
    store.build_table(tmp_path)
    csv = pd.read_csv(tmp_path / "results.csv", dtype={"job": str}, **EVERY_DIGIT)
    table = store.open_results(tmp_path).table()
    assert list(csv.columns[:2]) == ["job", "defect.width"]
    for name in ("velocity@BPFO", "velocity.rms", "velocity@BPFO-healthy", "seconds"):
        np.testing.assert_array_equal(csv[name], table[name])


def test_missing_damaged_or_stale_table_is_rebuilt(tmp_path: Path, study: FakeStudy) -> None:
    jobs = study.jobs()
    store_jobs(tmp_path, study, jobs[:2])
    assert list(store.open_results(tmp_path).table()["status"]) == ["done", "done", "missing", "missing"]
    store_jobs(tmp_path, study, jobs[2:])
    table = store.open_results(tmp_path).table()
    assert set(table["status"]) == {"done"}
    (tmp_path / "study.h5").write_bytes(b"not HDF5")
    assert store.open_results(tmp_path).table().equals(table)
    (tmp_path / "study.h5").unlink()
    assert store.open_results(tmp_path).table().equals(table)


def test_current_table_is_read_without_the_units(tmp_path: Path, study: FakeStudy) -> None:
    [path] = store_jobs(tmp_path, study)
    first = store.open_results(tmp_path).table()
    written, unit = (tmp_path / "study.h5").stat().st_mtime_ns, path.stat()
    path.write_bytes(b"x" * unit.st_size)
    os.utime(path, ns=(unit.st_atime_ns, unit.st_mtime_ns))
    assert store.open_results(tmp_path).table().equals(first)
    assert (tmp_path / "study.h5").stat().st_mtime_ns == written


def test_altered_csv_is_written_again_and_a_current_one_is_left(tmp_path: Path, study: FakeStudy) -> None:
    store_jobs(tmp_path, study)
    store.build_table(tmp_path)
    path = tmp_path / "results.csv"
    text = path.read_text()
    path.write_text(text.replace("done", "gone"))
    store.build_table(tmp_path)
    assert path.read_text() == text
    written = path.stat().st_mtime_ns
    store.build_table(tmp_path)
    assert path.stat().st_mtime_ns == written


@pytest.mark.parametrize(
    "action", [store.build_table, store.remove_leftovers, lambda root: store.discard(root, "study")]
)
def test_processes_that_share_a_folder_wait_for_the_lock(
    tmp_path: Path, study: FakeStudy, action: Callable[[Path], Any]
) -> None:
    store_jobs(tmp_path, study)
    thread = threading.Thread(target=action, args=(tmp_path,))
    with store.lock(tmp_path):
        thread.start()
        thread.join(0.3)
        assert thread.is_alive()
    thread.join(10.0)
    assert not thread.is_alive()


def test_damaged_unit_is_missing_from_the_table_with_a_warning(tmp_path: Path, study: FakeStudy) -> None:
    [path] = store_jobs(tmp_path, study)
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.warns(UserWarning, match="cannot be read"):
        table = store.open_results(tmp_path).table()
    assert set(table["status"]) == {"missing"}


def test_job_in_two_units_is_counted_once(tmp_path: Path, study: FakeStudy) -> None:
    store_jobs(tmp_path, study, study.jobs()[:2])
    store_jobs(tmp_path, study)
    assert len(store.open_results(tmp_path).table()) == 4


def test_table_file_opens_in_xarray(tmp_path: Path, study: FakeStudy) -> None:
    store_jobs(tmp_path, study)
    store.build_table(tmp_path)
    with xr.open_dataset(tmp_path / "study.h5", engine="h5netcdf") as data:
        assert data["features"].sel(feature="velocity@BPFO-healthy").dims == ("job",)
        assert data["feature_units"].sel(feature="velocity@BPFO") == "m/s"
        assert all(data[name].dims == ("job",) for name in ("status", "reason", "healthy", "unit"))


def test_plan_contains_the_study_and_its_jobs(tmp_path: Path, study: Any) -> None:
    store.write_plan(tmp_path, study, study.jobs())
    plan = store.read_plan(tmp_path)
    assert (tmp_path / "study.yaml").read_text() == study.text
    assert (plan["study"], plan["overrides"], plan["units"]) == ("fake", {"load": "200 N"}, {"defect.width": "mm"})
    assert plan["jobs"][0] == {
        "job": study.jobs()[0].id,
        "healthy": study.jobs()[3].id,
        "twin": False,
        "variation": False,
        "swept": {"defect.width": 1e-3},
    }
    assert [entry["twin"] for entry in plan["jobs"]] == [False, False, False, True]


# Results


def test_a_plan_of_an_older_version_is_refused(tmp_path: Path, study: Any) -> None:
    store.write_plan(tmp_path, study, study.jobs())
    plan = (tmp_path / "plan.json").read_text()
    (tmp_path / "plan.json").write_text(plan.replace('"twin"', '"unknown"'))
    with pytest.raises(store.ResultsError, match="run the study again"):
        store.open_results(tmp_path)


def test_results_return_series_and_parameters(tmp_path: Path, study: FakeStudy) -> None:
    store_jobs(tmp_path, study)
    results = store.open_results(str(tmp_path))
    job = results.jobs[2]
    record = record_of(study.jobs()[2].case)
    np.testing.assert_array_equal(
        results.series(job)["ring.velocity.x"], record.series["ring.velocity.x"].astype("f4")
    )
    assert results.parameters().loc[job, "defects.1.width"] == 3e-3
    assert results.info().loc[job, "step_s"] == 5e-7


def test_results_convert_to_one_dataset(tmp_path: Path, study: FakeStudy) -> None:
    store_jobs(tmp_path, study, study.jobs()[:2])
    store_jobs(tmp_path, study, study.jobs()[2:])
    data = store.open_results(tmp_path).to_xarray()
    assert dict(data.sizes) == {"job": 4, "time": 205}
    assert data["defect.width"].attrs["units"] == "m"
    assert data["velocity@BPFO"].attrs["units"] == "m/s"
    wide = data.sel(job=study.jobs()[2].id)
    expected = record_of(study.jobs()[2].case).series["ring.velocity.y"].astype("f4")
    np.testing.assert_array_equal(wide["ring.velocity.y"], expected)


def test_missing_xarray_is_reported_with_the_command_to_install_it(
    tmp_path: Path, study: FakeStudy, monkeypatch: pytest.MonkeyPatch
) -> None:
    store_jobs(tmp_path, study)
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(store.ResultsError, match="pip install xarray"):
        store.open_results(tmp_path).to_xarray()


def test_missing_results_are_reported(tmp_path: Path, study: FakeStudy) -> None:
    with pytest.raises(store.ResultsError, match="contains no results"):
        store.open_results(tmp_path)
    store_jobs(tmp_path, study, study.jobs()[1:])
    results = store.open_results(tmp_path)
    with pytest.raises(store.ResultsError, match="not computed yet"):
        results.series(study.jobs()[0].id)
    with pytest.raises(store.ResultsError, match="no job nonsense"):
        results.series("nonsense")


def test_unit_of_another_machine_is_stored_unchanged(tmp_path: Path, study: FakeStudy) -> None:
    [path] = store_jobs(tmp_path / "there", study)
    content = path.read_bytes()
    copy = store.store_unit(tmp_path / "here", path.stem, content)
    assert copy.read_bytes() == content
    assert copy.relative_to(tmp_path / "here") == path.relative_to(tmp_path / "there")
    for wrong_content, unit in ((content[:-200], path.stem), (flip_bit(content), path.stem), (content, "0" * 16)):
        with pytest.raises(store.DamagedUnit, match="as received"):
            store.store_unit(tmp_path / "other", unit, wrong_content)
    assert not (tmp_path / "other").exists()


def flip_bit(content: bytes) -> bytes:
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :]


def test_wait_for_a_lock_names_its_holder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(files, "LOCK_REPORT_S", 0.1)
    (tmp_path / "run.elsewhere-123-abcdef01.started").touch()
    other_lock, released = FileLock(tmp_path / ".lock"), threading.Event()

    def hold() -> None:
        with other_lock:
            locked.set()
            released.wait()

    locked = threading.Event()
    thread = threading.Thread(target=hold)
    thread.start()
    locked.wait()
    threading.Timer(0.4, released.set).start()
    with store.lock(tmp_path):
        assert (
            f"waiting for another run (elsewhere-123), which has locked {tmp_path / '.lock'}"
            in capsys.readouterr().err
        )
    thread.join()
