"""Scans in a case and in a study: sizes, digests, ids, and messages with a place."""

import re
from pathlib import Path
from typing import Any

import h5py
import pytest
from pydantic import ValidationError

from bearingsim.assemble.defects import build_depth_map
from bearingsim.config import Case
from bearingsim.config.scan import repair
from bearingsim.config.scan.file import read_file
from bearingsim.config.scan.notes import notes
from bearingsim.config.scan.repair import read_scan
from bearingsim.core.defects import traced
from bearingsim.core.defects.envelope import trace_path
from bearingsim.study import load_study
from bearingsim.study.jobs import case_id
from bearingsim.study.schema import json_schema
from bearingsim.text.yamlfile import StudyError
from tests.scenes.bombs import DATASETS
from tests.scenes.scan_files import STUDY, S, Z, bowl, refusal, write_grid

pytestmark = pytest.mark.usefixtures("constant_candidates")

# In a case and in a study


def case_with(file: Path, **fields: Any) -> Case:
    base = {"bearing": "nf308", "speed": "1800 rpm", "load": "150 N"}
    return Case.model_validate(base | {"defect": {"shape": "scan", "file": str(file)} | fields})


def test_sizes_of_a_defect_are_those_of_the_file(tmp_path: Path) -> None:
    file = write_grid(tmp_path / "a.csv", bowl(noise=0.1))
    test_case = case_with(file, angle="10 deg", offset="1 mm")
    assert test_case.defects[0].length == read_scan(file).sizes[0]
    assert Case.model_validate(test_case.model_dump()) == test_case
    assert notes([test_case, test_case]) == [f"a.csv: {note}" for note in read_scan(file).notes]
    assert notes([test_case.model_copy(update={"defects": ()})]) == []


@pytest.mark.parametrize(
    ("fields", "unit", "part"),
    [
        ({"length": "3 mm"}, "um", "a scan's length comes from its file"),
        ({"edge": {"radius": "20 um"}}, "um", "a scan already contains its edges"),
        ({"grown": "50 %"}, "um", "only a spall has `grown`"),
        ({}, "mm", "a defect 50 mm deep goes through the outer ring (6.5 mm)"),
        ({"offset": "9 mm"}, "um", "beyond the roller's end"),
    ],
)
def test_scan_that_does_not_fit_the_case_is_refused(
    tmp_path: Path, fields: dict[str, str], unit: str, part: str
) -> None:
    file = write_grid(tmp_path / "a.csv", bowl(), f"depth [{unit}] | z [mm] | s [mm]")
    with pytest.raises(ValidationError, match=part.replace("(", r"\(").replace(")", r"\)")):
        case_with(file, **fields)


@pytest.mark.parametrize(
    ("fields", "part"),
    [
        ({}, "a scan's digest comes from its file"),
        ({"length": "3 mm", "width": "1 mm", "depth": "20 um"}, "a scan's length comes from its file"),
        ({"length": 6e-3, "width": 2e-3, "depth": 20e-6}, "a scan's depth comes from its file"),
        ({"length": 6e-3, "width": 2e-3}, "a scan's length comes from its file"),
    ],
)
def test_digest_and_sizes_must_equal_those_of_the_file(tmp_path: Path, fields: dict[str, Any], part: str) -> None:
    """Digest and sizes are accepted only if they equal those of the file."""
    file = write_grid(tmp_path / "a.csv", bowl())
    digest = read_scan(file).digest
    sizes = dict(zip(("length", "width", "depth"), read_scan(file).sizes, strict=True))
    test_case = case_with(file, digest=digest, **sizes)
    assert test_case == case_with(file)
    with pytest.raises(ValidationError, match=part):
        case_with(file, digest=digest, **fields)


def test_a_digest_in_a_study_is_refused(tmp_path: Path) -> None:
    digest = read_scan(write_grid(tmp_path / "a.csv", bowl())).digest
    path = tmp_path / "study.yaml"
    path.write_text(STUDY.replace("FILE", f"a.csv, digest: {digest}, length: 3 mm, width: 1 mm, depth: 20 um"))
    with pytest.raises(StudyError, match=r"defect\.length: a scan's length comes from its file"):
        load_study(path)
    path.write_text(STUDY.replace("FILE", f"a.csv, digest: {digest}"))
    with pytest.raises(StudyError, match=r"defect\.digest: a scan's digest comes from its file \(remove `digest`"):
        load_study(path)
    assert "digest" not in json_schema()["$defs"]["Defect"]["properties"]


def test_id_depends_on_the_content_of_the_file(tmp_path: Path) -> None:
    file, same = write_grid(tmp_path / "a.csv", bowl()), write_grid(tmp_path / "b.csv", bowl())
    other = write_grid(tmp_path / "c.csv", 0.9 * bowl())
    assert case_id(case_with(file)) == case_id(case_with(same)) != case_id(case_with(other))


def test_file_changed_after_reading_is_refused(tmp_path: Path) -> None:
    file = write_grid(tmp_path / "a.csv", bowl())
    dumped = case_with(file).model_dump()
    write_grid(file, 0.9 * bowl())
    with pytest.raises(ValidationError, match="has changed since"):
        Case.model_validate(dumped)


def test_a_sweep_over_many_scans_reads_and_traces_each_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The cache contains all of them and their paths."""
    files = [write_grid(tmp_path / f"{n}.csv", (0.5 + 0.001 * n) * bowl()[::4, ::4], s=S[::4], z=Z[::4]) for n in
             range(100)]  # fmt: skip
    counts = {"read": 0, "traced": 0}

    def reading(path: Path) -> Any:
        counts["read"] += 1
        return read_file(path)

    def tracing(*parts: Any) -> Any:
        counts["traced"] += 1
        return trace_path(*parts)

    monkeypatch.setattr(repair, "read_file", reading)
    monkeypatch.setattr(traced, "trace_path", tracing)
    for _ in range(2):
        for file in files:
            (defect,) = case_with(file).defects
            traced.trace_paths(build_depth_map(defect), 0.006, (0.0,))
    assert counts == {"read": 100, "traced": 100}


def test_file_is_found_in_the_folder_of_the_study(tmp_path: Path) -> None:
    (tmp_path / "scans").mkdir()
    write_grid(tmp_path / "scans" / "a.csv", bowl())
    write_grid(tmp_path / "scans" / "b.csv", 0.5 * bowl())
    path = tmp_path / "study.yaml"
    path.write_text(STUDY.replace("FILE", "scans/a.csv") + "sweep: {defect.file: [scans/a.csv, scans/b.csv]}\n")
    cases = load_study(path).cases()
    assert [round(1e6 * test_case.defects[0].depth) for test_case in cases] == [50, 25]
    assert [swept["defect.file"] for _, swept in load_study(path).swept_cases] == ["scans/a.csv", "scans/b.csv"]


def test_working_folder_takes_precedence_over_that_of_the_study(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for folder, share in (("here", 1.0), ("study", 0.5)):
        (tmp_path / folder).mkdir()
        write_grid(tmp_path / folder / "a.csv", share * bowl())
    (tmp_path / "study" / "study.yaml").write_text(STUDY.replace("FILE", "a.csv"))
    depths = []
    for folder in ("here", "."):
        monkeypatch.chdir(tmp_path / folder)
        (test_case,) = load_study(tmp_path / "study" / "study.yaml").cases()
        depths.append(round(1e6 * test_case.defects[0].depth))
    assert depths == [50, 25]


@pytest.mark.parametrize(
    ("file", "message"),
    [
        (
            "none.csv",
            "defect.file: no file `none.csv` (a path is relative to the working folder, or else to the study)",
        ),
        ("bad.csv", "defect.file: the unit of `s` is missing (write `s [um]`, or mm, m, nm)"),
        (
            "deep.csv",
            "defect.file: a defect 50 mm deep goes through the outer ring (6.5 mm) (is the scan's unit right?)",
        ),
    ],
)
def test_invalid_file_is_reported_at_its_position(tmp_path: Path, file: str, message: str) -> None:
    (tmp_path / "bad.csv").write_text("s,z [mm],depth [um]\n1,1,1\n")
    write_grid(tmp_path / "deep.csv", bowl(), "depth [mm] | z [mm] | s [mm]")
    path = tmp_path / "study.yaml"
    path.write_text(STUDY.replace("FILE", file))
    with pytest.raises(StudyError) as caught:
        load_study(path)
    (problem,) = caught.value.problems
    assert str(problem).splitlines()[0] == f"{path}:5:{problem.column}: {message}"


@pytest.mark.parametrize("kind", DATASETS)
def test_hdf5_dataset_with_a_false_header_is_refused(tmp_path: Path, kind: str) -> None:
    add, message = DATASETS[kind]
    with h5py.File(tmp_path / "a.h5", "w") as file:
        add(file, "depth", tmp_path / "other.h5")
        is_link = not isinstance(file.get("depth", getlink=True), h5py.HardLink)
        for name, n in zip("zs", (1, 1) if is_link else file["depth"].shape, strict=True):
            file.create_dataset(name, (n,), "f8", chunks=True)
        for name in "sz" if is_link else ("s", "z", "depth"):
            file[name].attrs["units"] = "um"
    assert re.search(f"{message}|points; at most", refusal(tmp_path / "a.h5"))


def test_a_scan_of_many_points_is_refused_before_it_is_read(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for name, shape in (("s", (2_000_000_000,)), ("z", (2,)), ("depth", (2, 2_000_000_000))):
            file.create_dataset(name, shape, "f8", chunks=True, compression="gzip").attrs["units"] = "um"
    assert "4000000000 points; at most 4000000 (use fewer points)" in refusal(tmp_path / "a.h5")
    (tmp_path / "a.csv").write_bytes(b"s [mm],z [mm],depth [um]\n" + b",,\n" * 3_000_000)
    assert "more than 4000000 cells" in refusal(tmp_path / "a.csv")


def test_oversized_scan_is_not_read(tmp_path: Path) -> None:
    for name in ("a.csv", "a.h5"):
        with (tmp_path / name).open("wb") as file:
            file.truncate(300_000_000_000)
        assert "has more than 200 MB" in refusal(tmp_path / name)
