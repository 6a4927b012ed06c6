"""Results folder: unit files, table, resuming, leftovers."""

import errno
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest
import xarray as xr

from bearingsim import store
from bearingsim.cli.opening import find_job
from bearingsim.config import Case
from bearingsim.store import files
from bearingsim.store.columns import make_columns
from bearingsim.store.files import temporary, write_bytes
from bearingsim.store.names import parameter_attributes
from bearingsim.store.own_files import FAILURES, OwnFiles
from bearingsim.store.sealed import create_hdf5
from tests.scenes.fake_studies import PROVENANCE, FakeCase, FakeJob, FakeStudy, case_id, record_of, store_jobs


def test_unit_file_returns_what_was_stored(tmp_path: Path, study: FakeStudy) -> None:
    [path] = store_jobs(tmp_path, study)
    job = study.jobs()[1]
    series, record = store.read_series(path, job.id), record_of(job.case)
    np.testing.assert_array_equal(series.time, record.time)
    np.testing.assert_array_equal(series["ring.velocity.y"], record.series["ring.velocity.y"].astype("f4"))
    assert series.units == {"ring.velocity.x": "m/s", "ring.velocity.y": "m/s"}
    assert path == store.unit_path(tmp_path, store.unit_name(job.id for job in study.jobs()))


def test_series_are_a_mapping_of_channels(tmp_path: Path, study: FakeStudy) -> None:
    [path] = store_jobs(tmp_path, study)
    series = store.read_series(path, study.jobs()[1].id)
    assert list(series) == ["ring.velocity.x", "ring.velocity.y"]
    assert (len(series), "ring.velocity.x" in series, "ring.velocity.z" in series, "time" in series) == (
        *(2, True, False, False),
    )
    as_dict = dict(series)
    assert as_dict.keys() == series.channels.keys()
    np.testing.assert_array_equal(as_dict["ring.velocity.x"], series.channels["ring.velocity.x"])
    with pytest.raises(KeyError):
        series["ring.velocity.z"]


class VariedStudy(FakeStudy):
    """Study with one variation of each job."""

    def jobs(self) -> list[Any]:
        """Return cases and healthy cases, then variations."""
        return [*super().jobs(), *(variation.job for variation in self.variations())]

    def variations(self) -> list[Any]:
        """Return each case with twice the width."""
        nominal = [job for job in super().jobs() if not job.is_baseline]
        cases = [replace(job.case, width=2.0 * job.case.width, seconds=1.0) for job in nominal]
        jobs = [FakeJob(case_id(case), case, {}, None, is_variation=True) for case in cases]
        return [
            SimpleNamespace(of=job.id, what="damping", value=1e-6, job=varied_job)
            for job, varied_job in zip(nominal, jobs, strict=True)
        ]


def test_jobs_are_the_rows_of_the_table_and_planned_includes_variations(tmp_path: Path) -> None:
    study = VariedStudy()
    for is_varied in (False, True):
        store_jobs(tmp_path, study, [job for job in study.jobs() if job.is_variation == is_varied])
    results = store.open_results(tmp_path)
    ids, nominal = [job.id for job in study.jobs()], [job.id for job in study.jobs() if not job.is_variation]
    assert results.jobs == tuple(nominal) == tuple(results.table()["job"])
    assert results.planned == tuple(ids)
    assert len(ids) > len(nominal)
    assert store.planned_jobs(tmp_path) == set(ids)
    assert not store.find_removable(tmp_path).paths  # variations are not pruned
    variation = study.variations()[0].job.id
    assert find_job(results, variation) == variation
    assert len(results.series(variation)) == 2


def test_unit_file_is_compressed_and_has_checksums(tmp_path: Path, study: FakeStudy) -> None:
    [path] = store_jobs(tmp_path, study)
    with h5py.File(path) as file:
        channel = file["ring.velocity.x"]
        assert (channel.dtype, file["time"].dtype) == (np.float32, np.float64)
        assert (channel.compression, channel.shuffle, channel.fletcher32) == ("gzip", True, True)
        names = list(file["feature"].asstr())
        assert names == ["velocity.rms", "velocity@BPFO", "velocity@BPFO.phase"]
        assert (file["features"].shape, file["features"].dtype) == ((4, 3), np.float64)
        assert list(file["feature_units"].asstr()) == ["m/s", "m/s", "rad"]
        assert (
            dict(zip(file["parameter"].asstr(), file["parameter_units"].asstr(), strict=True))["defects.1.width"]
            == "m"
        )
        assert file.attrs["model_version"] == 1
        assert file["provenance/study_text"].asstr()[()] == PROVENANCE["study_text"]


def test_a_job_of_3_kb_of_series_takes_less_than_8_kb(tmp_path: Path) -> None:
    cases = [FakeCase(width=1e-3 * n, duration=0.0375) for n in range(100)]  # 384 samples, twice, as float32
    jobs: list[Any] = [FakeJob(case_id(case), case, {}, None) for case in cases]
    records = [record_of(case) for case in cases]
    for number, record in enumerate(records):
        values = np.random.default_rng(number).normal(size=120)
        record.features |= {f"feature {n} of a hundred": value for n, value in enumerate(values)}
        record.info |= {f"fact {n}": f"word {n % 3}" for n in range(25)}
    [path] = store.write_units(tmp_path, list(zip(jobs, records, strict=True)), PROVENANCE)
    assert path.stat().st_size / 100 < 8000


def test_xarray_opens_a_unit(tmp_path: Path, study: FakeStudy) -> None:
    [path] = store_jobs(tmp_path, study)
    with xr.open_dataset(path, engine="h5netcdf") as data:
        assert data["ring.velocity.x"].dims == ("job", "time")
        assert data["ring.velocity.x"].attrs == {"units": "m/s", "long_name": "velocity of the outer ring x"}
        assert list(data["job"].values) == sorted(job.id for job in study.jobs())
        assert data["time"].attrs["units"] == "s"
        by_id = {job.id: 1e-3 if job.is_baseline else job.case.width for job in study.jobs()}
        assert data["features"].dims == ("job", "feature")
        assert list(data["features"].sel(feature="velocity@BPFO").values) == [
            by_id[job] for job in data["job"].values
        ]


def test_jobs_of_other_time_axes_get_their_own_unit(tmp_path: Path) -> None:
    cases = [FakeCase(duration=0.02), FakeCase(duration=0.04), FakeCase(record=()), FakeCase(width=2e-3)]
    jobs: list[Any] = [FakeJob(case_id(case), case, {}, None) for case in cases]
    units = store.write_units(tmp_path, [(job, record_of(job.case)) for job in jobs], PROVENANCE)
    assert sorted(len(store.check_unit(unit)) for unit in units) == [1, 1, 2]
    holdings = store.read_holdings(tmp_path)
    assert (holdings.sealed, holdings.damaged) == ({job.id for job in jobs}, [])
    [unit_without_series] = [unit for unit in units if jobs[2].id in store.check_unit(unit)]
    assert store.read_series(unit_without_series, jobs[2].id).channels == {}


def test_columns_keep_strings_and_mark_missing_values() -> None:
    arrays = make_columns([{"a": 1.0, "step": "auto"}, {"a": 2, "step": 0.5}, {"b": 3.0}])
    assert list(arrays["step"]) == ["auto", "0.5", ""]
    np.testing.assert_array_equal(arrays["a"], [1.0, 2.0, np.nan])


def test_parameters_are_flat_and_in_si() -> None:
    assert store.flat_parameters(FakeCase(width=8e-4, action="none")) == {
        "action": "none",
        "seconds": 0.0,
        "duration": 0.02,
        "sampling": 10240.0,
        "record": "ring.velocity",
        "bearing.name": "fake",
        "bearing.roller_diameter": 0.014,
        "defects.1.race": "outer",
        "defects.1.width": 8e-4,
    }


def test_parameters_carry_their_si_unit() -> None:
    bearing = {"name": "b", "rollers": 9, "roller_diameter": 0.01, "roller_length": 0.01, "pitch_diameter": 0.05}
    sizes = {"bore": 0.03, "outside_diameter": 0.07, "width": 0.015}
    defects = [{"shape": "rectangular", "length": 2e-3, "width": 1e-3, "depth": 1e-4}]
    case = Case.model_validate({"bearing": bearing | sizes, "speed": 100.0, "load": 50.0, "defects": defects})
    units = {name: parameter_attributes(name).get("units") for name in store.flat_parameters(case)}
    expected = {"bearing.roller_diameter": "m", "bearing.material.density": "kg/m^3", "defects.1.angle": "rad"}
    expected |= {"speed": "rad/s", "load": "N", "contact.damping.beta": "s", "rig.bracket_damping": "N s/m"}
    assert {name: units[name] for name in expected} == expected
    assert units["model"] is None
    assert units["bearing.rollers"] is None
    assert parameter_attributes("defect.grown") == {}


def test_no_file_remains_after_a_write_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(descriptor: int) -> None:
        raise OSError("the cable is out")

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(OSError, match="cable"):
        write_bytes(tmp_path / "a.txt", b"half")
    assert list(tmp_path.iterdir()) == []


# Resuming


@pytest.mark.parametrize("kept_length", [0, 100, 0.5, 0.999])
def test_truncated_unit_is_marked_damaged(tmp_path: Path, study: FakeStudy, kept_length: float) -> None:
    first, second = study.jobs()[:2], study.jobs()[2:]
    [damaged_unit], [_] = store_jobs(tmp_path, study, first), store_jobs(tmp_path, study, second)
    content = damaged_unit.read_bytes()
    damaged_unit.write_bytes(content[: int(kept_length if kept_length >= 1 else kept_length * len(content))])
    holdings = store.read_holdings(tmp_path)
    assert holdings.sealed == {job.id for job in second}
    assert holdings.damaged == [str(damaged_unit.relative_to(tmp_path))]
    assert not damaged_unit.exists()
    assert damaged_unit.with_suffix(".damaged").exists()
    [journal] = tmp_path.glob("journal-*.jsonl")
    assert json.loads(journal.read_text())["file"] == holdings.damaged[0]


def test_unit_under_another_name_is_damaged(tmp_path: Path, study: FakeStudy) -> None:
    [path] = store_jobs(tmp_path, study)
    moved = path.rename(path.with_name("0123456789abcdef.h5"))
    with pytest.raises(store.DamagedUnit, match="ids"):
        store.check_unit(moved)


def test_unit_with_a_missing_row_is_damaged(tmp_path: Path, study: FakeStudy) -> None:
    [path] = store_jobs(tmp_path, study)
    with h5py.File(path) as original, create_hdf5(path) as file:
        for name in original:
            original.copy(name, file)
        file.attrs["status"] = "complete"
        shortened = file["ring.velocity.x"][1:]
        del file["ring.velocity.x"]
        file["ring.velocity.x"] = shortened
    with pytest.raises(store.DamagedUnit, match="shape"):
        store.check_unit(path)


UNIT = "cafe" * 4
LEFTOVER_SCRIPT = """import os, sys, time; from pathlib import Path; from bearingsim.store.files import temporary
with temporary(Path(sys.argv[1]), "ab" * 8 + ".h5", "part") as file: print(flush=True); {}
"""


def test_sweep_removes_files_of_ended_writers_only(tmp_path: Path) -> None:
    folder = tmp_path / "units" / "ab"
    subprocess.run(
        [sys.executable, "-c", LEFTOVER_SCRIPT.format("os._exit(9)"), str(folder)], check=False, stdout=-1
    )
    [leftover] = folder.iterdir()
    command = [sys.executable, "-c", LEFTOVER_SCRIPT.format("time.sleep(60)"), str(folder)]
    with (
        subprocess.Popen(command, stdout=subprocess.PIPE) as process,
        temporary(folder, f"{UNIT}.h5", "part") as own_file,
    ):
        assert process.stdout is not None
        process.stdout.readline()
        assert store.remove_leftovers(tmp_path) == [leftover]
        assert len(list(folder.iterdir())) == 2
        process.kill()
        os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)  # dead, but not yet waited for
        assert len(store.remove_leftovers(tmp_path)) == 1
        assert [str(path) for path in folder.iterdir()] == [own_file.name]
    assert not list(folder.iterdir())


def test_sweep_before_the_lock_costs_one_temporary_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    original, swept = files._lock_file, list[str]()

    def take(file: Any, wait: bool) -> bool:
        if not swept:
            swept.append(file.name)
            Path(file.name).unlink()
        return original(file, wait)

    monkeypatch.setattr(files, "_lock_file", take)
    write_bytes(tmp_path / "a", b"whole")
    assert (tmp_path / "a").read_bytes() == b"whole"
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_no_file_counts_as_leftover_without_locks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*arguments: Any) -> None:
        raise OSError(errno.ENOLCK, "no locks available")

    monkeypatch.setattr("fcntl.flock", fail)
    (tmp_path / "plan.json.host-1-0123abcd.part").touch()
    write_bytes(tmp_path / "b", b"whole")
    assert store.remove_leftovers(tmp_path) == []
    with pytest.raises(store.FolderInUse, match="on a disk without locks"):
        store.discard(tmp_path, "study")


@pytest.mark.parametrize("number", [errno.EROFS, errno.EACCES, errno.ENOSPC])
def test_stale_table_is_rebuilt_in_memory_if_nothing_can_be_written(
    tmp_path: Path, study: FakeStudy, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    store_jobs(tmp_path, study)
    table = store.open_results(tmp_path).table()
    (tmp_path / "study.h5").write_bytes(b"stale")

    def refuse(*arguments: Any, **options: Any) -> None:
        raise OSError(number, "cannot be written")

    monkeypatch.setattr(files, "_create_locked", refuse)
    monkeypatch.setattr("filelock.FileLock.acquire", refuse)
    assert store.open_results(tmp_path).table().equals(table)


def test_fresh_start_refuses_a_folder_in_use(tmp_path: Path, study: FakeStudy) -> None:
    [path] = store_jobs(tmp_path, study)
    with store.start_marker(tmp_path, path.stem), pytest.raises(store.FolderInUse, match="another run"):
        store.discard(tmp_path, study.name)
    store.discard(tmp_path, study.name)
    assert not path.exists()


def test_marker_of_an_ended_process_names_the_running_job(tmp_path: Path) -> None:
    code = "import os, sys; from pathlib import Path; from bearingsim import store\n"
    code += "with store.start_marker(Path(sys.argv[1]), 'cafe' * 4) as note: note('a'); note('b'); os._exit(9)"
    subprocess.run([sys.executable, "-c", code, str(tmp_path)], check=False)
    with store.start_marker(tmp_path, UNIT) as note:
        note("mine")
        assert store.take_suspects(tmp_path, [UNIT]) == {"b"}
        assert store.take_suspects(tmp_path, [UNIT]) == set()
    assert not list(tmp_path.rglob("*.started"))


def test_an_error_names_the_file_instead_of_its_temporary_name(tmp_path):
    path = tmp_path / f"{'a' * 250}.csv"  # the suffix of the temporary name exceeds the limit of 255 letters
    with pytest.raises(OSError, match="too long") as caught:
        write_bytes(path, b"")
    assert caught.value.filename == str(path)


def test_case_is_rebuilt_from_a_column_of_words_and_numbers() -> None:
    """The numbers of `step: [auto, 2 us]` are stored as text; a name of digits remains a text."""
    sizes = {"rollers": 9, "roller_diameter": 0.01, "roller_length": 0.01, "pitch_diameter": 0.05}
    bearing = {"name": "6205", "bore": 0.03, "outside_diameter": 0.07, "width": 0.015} | sizes
    base = Case.model_validate({"bearing": bearing, "speed": 100.0, "load": 50.0})
    cases = [base, base.model_copy(update={"step": 2e-6}), base.model_copy(update={"settle": 0.1})]
    stored = make_columns([store.flat_parameters(case) for case in cases])
    rows = [{name: values[row] for name, values in stored.items()} for row in range(len(cases))]
    rebuilt = [store.case_of(row) for row in rows]
    assert [(case.step, case.settle) for case in rebuilt] == [("auto", "auto"), (2e-6, "auto"), ("auto", 0.1)]
    assert {case.bearing.name for case in rebuilt} == {"6205"}


def test_marker_removed_by_its_writer_does_not_stop_a_sweep(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A writer closes its marker, which releases the lock, before removing it."""
    original = files.lock_leftover

    @contextmanager
    def removed_meanwhile(path: Path) -> Iterator[bool]:
        with original(path) as is_leftover:
            path.unlink()
            yield is_leftover

    monkeypatch.setattr(files, "lock_leftover", removed_meanwhile)
    monkeypatch.setattr("bearingsim.store.journal.lock_leftover", removed_meanwhile)
    folder = tmp_path / "units" / "ab"
    folder.mkdir(parents=True)
    for take in (store.remove_leftovers, lambda root: store.take_suspects(root, [UNIT])):
        (folder / f"{UNIT}.host-1-00000000.started").write_text("")
        take(tmp_path)
        assert not list(folder.iterdir())


def test_failure_cleared_by_another_run_does_not_stop_the_table(
    tmp_path: Path, study: FakeStudy, monkeypatch: pytest.MonkeyPatch
) -> None:
    store_jobs(tmp_path, study, study.jobs()[:3])
    store.Failure(study.jobs()[3].id, "left").write(tmp_path)
    original = OwnFiles.find

    def remove_meanwhile(kind: OwnFiles, root: Path) -> list[Path]:
        paths = original(kind, root)
        if kind is FAILURES:
            store.clear_failure(root, study.jobs()[3].id)
        return paths

    monkeypatch.setattr(OwnFiles, "find", remove_meanwhile)
    assert list(store.build_table(tmp_path)["status"]) == ["done"] * 3 + ["missing"]
