"""`bearingsim new --from` and `--list`: copies of the shipped studies."""

from pathlib import Path

import pytest

from bearingsim.cli.new import find_study, write_copy
from bearingsim.errors import UserError
from bearingsim.shipped import shipped_studies
from bearingsim.study import SCHEMA_COMMENT, SCHEMA_FILE, load_study, read_outline
from tests.conftest import ROOT
from tests.scenes.commands import type_
from tests.scenes.editor import schema_errors


@pytest.fixture
def empty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def files_read(study: Path) -> dict[str, str]:
    """The digests of the files that a study reads beside its own, by name."""
    read = read_outline(study, {}, quick=False)
    assert read is not None
    return {Path(name).name: digest for name, digest in read.files.items() if digest and name != str(study)}


def test_copied_study_reads_the_same_files(empty: Path) -> None:
    for name, source in shipped_studies().items():
        write_copy(name, None)
        assert files_read(empty / f"{name}.yaml") == files_read(source)
    study = load_study("shapes.yaml")
    assert study.cases() == load_study(ROOT / "studies/shapes.yaml").cases()
    assert schema_errors(study.text) == []


def test_files_that_a_study_reads_are_copied_with_it(empty: Path) -> None:
    stdout, _ = type_("new", "--from", "shapes", "mine.yaml")
    assert stdout == "mine.yaml and scans/spall.csv written; next: bearingsim check mine.yaml\n"
    assert Path("mine.yaml").read_text() == SCHEMA_COMMENT + (ROOT / "studies/shapes.yaml").read_text()
    assert Path("scans/spall.csv").read_text() == (ROOT / "studies/scans/spall.csv").read_text()
    assert Path(SCHEMA_FILE).is_file()
    assert "written" in type_("new", "--from", "shapes", "second.yaml")[0]  # the same scan serves both


def test_existing_file_with_the_name_of_a_scan_is_kept(empty: Path) -> None:
    Path("scans").mkdir()
    Path("scans/spall.csv").write_text("mine")
    _, stderr = type_("new", "--from", "shapes", code=2)
    assert stderr.startswith("scans/spall.csv exists, and the study needs another file of this name")
    assert Path("scans/spall.csv").read_text() == "mine"
    assert not Path("shapes.yaml").exists()


def test_an_existing_study_is_kept(empty: Path) -> None:
    Path("spall.yaml").write_text("mine")
    assert "spall.yaml exists; name another file" in type_("new", "--from", "spall", code=2)[1]
    assert Path("spall.yaml").read_text() == "mine"


@pytest.mark.parametrize(
    ("name", "file"), [("fig16", "fig16_angle.yaml"), ("length", "length.yaml"), ("inner-race", "inner_race.yaml")]
)
def test_the_beginning_of_a_name_is_enough(name: str, file: str) -> None:
    assert find_study(name).name == file


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("inner_rcae", " (did you mean `inner_race`?)"),
        ("sensitvity", " (did you mean `sensitivity`?)"),
        ("ring", " (`ring_bends` or `ring_trends`)"),
        ("gearbox", ""),
    ],
)
def test_an_unknown_name_is_refused(empty: Path, name: str, hint: str) -> None:
    _, stderr = type_("new", "--from", name, code=2)
    assert stderr == f"no study `{name}`{hint}: `bearingsim new --list` lists all\n"
    assert list(empty.iterdir()) == []
    with pytest.raises(UserError):
        find_study(name)


def test_the_list_has_a_title_and_the_cases_of_each_study() -> None:
    lines = {line.split()[0]: line for line in type_("new", "--list")[0].splitlines() if line.strip()}
    for name, path in shipped_studies().items():
        title, separator = path.read_text().splitlines()[:2]
        assert separator == "#", f"{name}: the title is not a paragraph of its own"
        assert len(title) <= 82, f"{name}: the title is longer than a line of a terminal"
        assert title.strip("# .") in lines[name]
    assert lines["fig16_angle"].split()[-1] == "156"
    counts = [int(line.split()[-1]) for name, line in lines.items() if name in shipped_studies()]
    assert counts == sorted(counts)
