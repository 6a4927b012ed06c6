"""The built wheel: its files and metadata; CITATION.cff and the other files for a host of the repository."""

import email.message
import email.parser
import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
import yaml
from hatchling.builders.wheel import WheelBuilder

import bearingsim
from hatch_build import without_relative_links
from tests.conftest import ROOT


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> zipfile.ZipFile:
    folder = tmp_path_factory.mktemp("dist")
    (file,) = WheelBuilder(str(ROOT)).build(directory=str(folder))
    return zipfile.ZipFile(file)


def metadata(wheel: zipfile.ZipFile) -> email.message.Message:
    (name,) = (name for name in wheel.namelist() if name.endswith(".dist-info/METADATA"))
    return email.parser.Parser().parsestr(wheel.read(name).decode())


@pytest.mark.parametrize("folder", ["configs", "studies"])
def test_it_contains_the_library_and_the_studies(wheel: zipfile.ZipFile, folder: str) -> None:
    files = [path for path in sorted((ROOT / folder).rglob("*")) if path.is_file()]
    names = [f"bearingsim/{path.relative_to(ROOT)}" for path in files]
    assert [wheel.read(name) for name in names] == [path.read_bytes() for path in files]
    assert names


def test_it_is_typed_and_has_only_the_package(wheel: zipfile.ZipFile) -> None:
    assert "bearingsim/py.typed" in wheel.namelist()
    assert {name.partition("/")[0] for name in wheel.namelist()} == {
        "bearingsim",
        f"bearingsim-{bearingsim.__version__}.dist-info",
    }


def test_commands_run_from_the_wheel(wheel: zipfile.ZipFile, done: Path, tmp_path: Path) -> None:
    """`make wheel-check` runs all of them, in environments of their own."""
    wheel.extractall(tmp_path / "site")
    (tmp_path / "work").mkdir()
    environment = os.environ | {"PYTHONPATH": str(tmp_path / "site")}
    script = "import bearingsim; print(bearingsim.__file__); from bearingsim.cli import main; main()"
    for words in (["new", "--from", "shapes"], ["freq", "nu206"], ["show", str(done)], ["plot", str(done)]):
        process = subprocess.run(
            [sys.executable, "-c", script, *words],
            cwd=tmp_path / "work",
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        assert (process.returncode, process.stderr) == (0, "")
        assert process.stdout.startswith(str(tmp_path / "site"))
    assert (tmp_path / "work/scans/spall.csv").is_file()


def test_metadata_name_version_licence_and_no_address(wheel: zipfile.ZipFile) -> None:
    fields = metadata(wheel)
    assert fields["Version"] == bearingsim.__version__
    assert fields["License-Expression"] == "MIT"
    assert fields.get_all("Project-URL") is None
    assert {fields["Author"], fields["Author-email"], fields["Home-page"]} == {None}


def test_description_has_no_link_into_the_source(wheel: zipfile.ZipFile) -> None:
    text = str(metadata(wheel).get_payload())
    assert text.startswith("# bearingsim")
    assert re.findall(r"\]\((?![a-z]+:)[^)]*\)", text) == []
    assert "source distribution" in text


def test_links_to_hosts_are_kept_and_pictures_removed() -> None:
    text = "![a picture](x.png)\n\n*Caption.*\n\n[page](docs/x.md#a) and [host](https://example.org)\n"
    assert without_relative_links(text) == "page and [host](https://example.org)\n"


def test_citation_names_the_program_and_its_paper() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert {"cff-version", "message", "title", "authors"} <= citation.keys()
    assert citation["title"] == "bearingsim"
    (paper,) = citation["references"]
    assert {"type", "title", "authors"} <= paper.keys()
    named = re.search(r"a paper by (.*?) on ", (ROOT / "docs/model.md").read_text(), re.DOTALL)
    assert named is not None
    names = [author["family-names"] for author in paper["authors"]]
    assert names == re.split(r",\s+|\s+and\s+", named[1])


@pytest.mark.parametrize(
    "path", sorted((ROOT / ".github/ISSUE_TEMPLATE").glob("*.md")), ids=lambda path: path.stem
)
def test_issue_template_has_a_name_and_a_description(path: Path) -> None:
    head = yaml.safe_load(path.read_text().split("---\n")[1])
    assert head["name"]
    assert head["about"]
