"""Copies of scans in a results folder, which can be drawn without the original files."""

import shutil
from pathlib import Path
from typing import Any

import pytest

from bearingsim import store
from bearingsim.config.scan.file import ScanError
from bearingsim.config.scan.repair import read_scan
from bearingsim.config.scan.roundness import read_roundness
from bearingsim.plots.plot import draw_figures
from bearingsim.runner import run
from bearingsim.store.names import case_of
from bearingsim.study import Study, load_study
from bearingsim.study.jobs import case_id
from tests.config.test_roundness import EVEN, heights, write
from tests.scenes.scan_files import bowl, write_grid

TEXT = """\
study: scans
bearing: nf308
speed: 1800 rpm
load: 150 N
defect: {shape: scan, file: scans/a.csv}
sweep: {defect.file: [scans/a.csv, scans/b.CSV]}
model: static
duration: 20 ms
settle: 0 ms
"""


@pytest.fixture
def home(tmp_path: Path) -> Path:
    """Make a folder with a study and its scans."""
    (tmp_path / "somebody" / "scans").mkdir(parents=True)
    write_grid(tmp_path / "somebody" / "scans" / "a.csv", bowl())
    write_grid(tmp_path / "somebody" / "scans" / "b.CSV", 0.5 * bowl())
    (tmp_path / "somebody" / "study.yaml").write_text(TEXT)
    return tmp_path / "somebody"


def study_of(home: Path) -> Study:
    return load_study(home / "study.yaml")


def compute(home: Path, out: Path, **options: Any) -> Any:
    return run(study_of(home), out, **{"jobs": 1, "progress": False} | options)


def digests(home: Path) -> list[str]:
    return [read_scan(home / "scans" / name).digest for name in ("a.csv", "b.CSV")]


@pytest.mark.parametrize("jobs", [1, 2])
def test_results_are_drawn_in_another_folder(home: Path, tmp_path: Path, jobs: int, monkeypatch: Any) -> None:
    assert compute(home, tmp_path / "out", jobs=jobs).done == 3
    expected = [digest + ".csv" for digest in digests(home)]
    assert sorted(path.name for path in (tmp_path / "out" / "scans").iterdir()) == sorted(expected)
    shutil.move(tmp_path / "out", tmp_path / "there")
    shutil.rmtree(home)
    monkeypatch.chdir(tmp_path / "there")
    results = store.open_results(tmp_path / "there")
    deepest = [
        canvas.axes[0].child_axes[0].get_ylim()[0] for _, canvas in draw_figures(results, "pit", jobs=["all"])
    ]
    assert sorted(deepest) == pytest.approx([25.0, 50.0], rel=1e-3)


def test_no_path_outside_the_folder_is_stored(home: Path, tmp_path: Path, monkeypatch: Any) -> None:
    compute(home, tmp_path / "out")
    assert set(store.open_results(tmp_path / "out").parameters()["defects.1.file"]) == {"a.csv", "b.CSV", ""}
    monkeypatch.chdir(home)
    run(load_study("study.yaml"), "results", jobs=1, progress=False)
    paths = store.open_results("results").parameters()["defects.1.file"]
    assert set(paths) == {"scans/a.csv", "scans/b.CSV", ""}
    contents = [
        path.read_bytes() for path in Path("results").rglob("*") if path.suffix in (".h5", ".csv", ".json")
    ]
    assert not any(str(home).encode() in content for content in contents)


def test_scans_are_stored_once(home: Path, tmp_path: Path) -> None:
    compute(home, tmp_path / "out", shard=(1, 2))
    [first_copy, second_copy] = [tmp_path / "out/scans" / f"{digest}.csv" for digest in digests(home)]
    inode = first_copy.stat().st_ino
    second_copy.write_bytes(b"torn")
    summary = compute(home, tmp_path / "out", shard=(2, 2))
    assert compute(home, tmp_path / "out").resumed == 3
    assert summary.failed == 0
    assert first_copy.stat().st_ino == inode
    assert second_copy.read_bytes() == (home / "scans" / "b.CSV").read_bytes()
    (home / "scans").rename(home / "moved")
    (home / "study.yaml").write_text(TEXT.replace("scans/", "moved/"))
    assert compute(home, tmp_path / "out").resumed == 3
    compute(home, tmp_path / "out", fresh=True)
    assert first_copy.is_file()
    assert not list((tmp_path / "out").glob("scans/*.part"))


@pytest.mark.parametrize(("new_content", "message"), [(b"else", "has changed since"), (None, "no file")])
def test_scan_missing_or_changed_before_the_run_is_reported(
    home: Path, tmp_path: Path, new_content: Any, message: str
) -> None:
    study, file = study_of(home), home / "scans" / "a.csv"
    file.unlink()
    if new_content:
        write_grid(file, 0.9 * bowl())
    with pytest.raises(ScanError, match=message):
        run(study, tmp_path / "out", jobs=1, progress=False)


def test_temporary_scan_of_an_ended_writer_is_removed(tmp_path: Path) -> None:
    (tmp_path / "scans").mkdir()
    leftover = (
        tmp_path
        / "scans"
        / f"0123456789abcdef.csv.{store.files.writer_name().rpartition('-')[0]}-4194304-0123abcd.part"
    )
    leftover.touch()
    assert store.remove_leftovers(tmp_path) == [leftover]


PROFILE = """\
study: profiles
bearing: nf308
speed: 1800 rpm
load: 150 N
surfaces: {outer: {roundness: a.csv}, inner: {roundness: {file: b.csv, orders: [2, 20]}}}
sweep: {load: [150 N, 300 N]}
model: static
duration: 20 ms
settle: 0 ms
"""


def test_profiles_are_kept_with_results(tmp_path: Path, monkeypatch: Any) -> None:
    """Shards copy the profiles, their merged folder rebuilds cases without the files, and prune keeps them."""
    home = tmp_path / "somebody"
    home.mkdir()
    names = ("a.csv", "b.csv")
    for name, order in zip(names, (12, 7), strict=True):
        write(home / name, EVEN, heights(EVEN, {order: (0.1, 0.5)}))
    (home / "study.yaml").write_text(PROFILE)
    digests = sorted(read_roundness(home / name).digest for name in names)
    for number in (1, 2):
        compute(home, tmp_path / str(number), shard=(number, 2))
    shutil.rmtree(home)
    merged = tmp_path / "merged"
    store.merge([tmp_path / "1", tmp_path / "2"], merged)
    assert sorted(path.name for path in (merged / "scans").iterdir()) == [f"{digest}.csv" for digest in digests]
    results = store.open_results(merged)
    parameters = results.parameters()
    assert set(parameters["surfaces.outer.roundness.file"]) == {"a.csv"}
    for job, row in parameters.iterrows():
        case = case_of(row.to_dict(), merged)
        assert Path(case.surfaces.inner.roundness.file).parent == merged / "scans"
        assert case_id(case) == job
    assert not store.find_removable(merged).files
