"""Whatever command is typed, not one byte of the user's own files changes."""

import json
import shutil
from inspect import signature
from pathlib import Path

import pytest

from bearingsim.cli import app
from tests.scenes.commands import STUDY, type_
from tests.scenes.design_results import run_design

ANYWHERE = [
    "thesis.tex",
    "notes.md",
    "movie.part",
    "movie.mp4.part",
    "run.started",
    "run.lab-pc-17-today.started",
    "photo.damaged",
    "0123456789abcdef.h5",
    "units/lab.h5",
    "units/ab/lab.h5",
    "units/ab/lab.damaged",
    "units/ab/movie.part",
    "units/ab/0123456789ABCDEF.h5",
    "units/ab/0123456789abcdef.h5",
    "units/my/0123456789abcdef.damaged",
    "units/01/0123456789abcdef.h5/notes.txt",
    "failed/0123456789abcdef.json/notes.txt",
    "trials/0123456789abcdef.json/notes.txt",
    "units/notes/0123456789abcdef.txt",
    "failed/notes.txt",
    "failed/motor.json",
    "failed/motor.damaged",
    "trials/notes.txt",
    "trials/tuesday.json",
    "trials/tuesday.json.part",
    "scans/surface.csv",
    "scans/surface.part",
    "figures/thesis.png",
    "figures/drawing.svg",
    "figures/drawing.part",
    "journal-of-vibration.pdf",
    "data/long.csv",
]
"""Names that the program does not make, and so are the user's even in a results folder."""
ELSEWHERE = [
    "study.yaml",
    "small.yaml",
    "accurate.yaml",
    "plan.json",
    "results.csv",
    "study.h5",
    "choices.json",
    "stability.csv",
    "runs.csv",
    "chart.csv",
    "provenance.json",
    "speed-accuracy.md",
    "units/ab/abcdef0123456789.h5",
    "failed/abcdef0123456789.json",
    "figures/fig1-velocity-bpfo-vs-load.png",
]
"""Names that the program makes, too."""

ONE_MODEL = STUDY.partition("quick:")[0].replace("  model: [static, ring]\n", "").replace(", by: model", "")
TEXTS = {
    "study.yaml": STUDY,
    "small.yaml": STUDY,
    "accurate.yaml": STUDY.replace("  model: [static, ring]\n", "")
    .replace(", by: model", "")
    .replace("quick:", "accuracy: 5 %\n#"),
}


def put(folder, names):
    """Files of the user, each with a text of its own, and a link to a folder outside."""
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(TEXTS.get(name, json.dumps({"mine": name, "jobs": [1], "study": "x"})))
    outside = folder.parent / "outside"
    outside.mkdir(exist_ok=True)
    (outside / "0123456789abcdef.h5").write_text("outside")
    (folder / "archive").symlink_to(outside)


def bytes_of(folder, names):
    return {name: (folder / name).read_bytes() for name in [*names, "archive/0123456789abcdef.h5"]}


@pytest.fixture
def users(tmp_path, monkeypatch):
    """A folder of the user, with 47 files and a link, that is the working folder."""
    folder = tmp_path / "users"
    put(folder, [*ANYWHERE, *ELSEWHERE])
    monkeypatch.chdir(folder)
    return folder


INTO_IT = {
    "check": [["check", "accurate.yaml", "--pilots", "--out", "."]],
    "run": [
        ["run", "small.yaml", "--out", "."],
        ["run", "small.yaml", "--out", ".", "--fresh"],
        ["run", "small.yaml", "--out", ".", "--quick", "--verify", "--retry-failed", "--set", "load=160 N"],
        ["run", "small.yaml", "--out", ".", "--shard", "1/2", "--fail-fast", "--max-cpu", "1 min"],
        ["run", "small.yaml", "--out", "thesis.tex"],
        ["run", "small.yaml", "--out", "units"],
        ["run", "small.yaml", "--out", "archive", "--fresh"],
    ],
    "merge": [
        ["merge", "DONE", "--out", "."],
        ["merge", "DONE", "--out", "archive"],
        ["merge", ".", "--out", "new"],
    ],
    "prune": [["prune", ".", "--no-dry-run"]],
    "plot": [["plot", "."], ["plot", "DONE", "--out", "figures"], ["plot", "DONE", "--out", "thesis.tex"]],
    "show": [["show", "."]],
    "sensitivity": [
        ["sensitivity", "."],
        ["sensitivity", "PLANE", "--of", "velocity@BPFO", "--out", "figures/thesis.png"],
        ["sensitivity", "PLANE", "--of", "velocity@BPFO", "--out", "figures/drawing.svg"],
    ],
    "export": [
        ["export", "."],
        ["export", "DONE", "--features", "results.csv"],
        ["export", "DONE", "--features", "data/long.csv"],
        ["export", "DONE", "--series", "JOB", "--out", "data/long.csv"],
    ],
    "stability": [["stability", "--quick", "--out", "."], ["stability", "--quick", "--out", "archive"]],
    "bench": [["bench", "--quick", "--out", "."], ["bench", "small.yaml", "--quick", "--out", "archive"]],
    "new": [["new", "study.yaml"], ["new", "thesis.tex"]],
}
"""By command: what would write into a folder of the user, or over a file. DONE, PLANE, JOB stand for results."""
NO_FOLDER = {"freq", "warm"}
"""Commands that write into no folder of the user."""
WAY_OUT = ("--out", "another", "holds no results", "--force", "not a folder")


@pytest.fixture(scope="session")
def plane(tmp_path_factory):
    return run_design(tmp_path_factory.mktemp("plane") / "fake", n=16)


def commands():
    """The functions of all commands by name."""
    return {
        str(one.name or one.callback.__name__): one.callback for one in app.registered_commands if one.callback
    }


def test_every_command_and_option_that_names_a_path_is_tried():
    assert {*INTO_IT, *NO_FOLDER} == {*commands()}
    for name, lines in INTO_IT.items():
        options = {one for one, about in signature(commands()[name]).parameters.items() if "Path" in str(about)}
        typed = {word.removeprefix("--") for line in lines for word in line if word.startswith("--")}
        assert options - {"study", "results", "path", "folders"} <= typed, name


@pytest.mark.parametrize("words", [line for lines in INTO_IT.values() for line in lines], ids=" ".join)
def test_a_folder_of_the_user_stays_as_it_is(users, done, plane, words):
    job = json.loads((done / "plan.json").read_text())["jobs"][0]["job"]
    stand_for = {"DONE": str(done), "PLANE": str(plane), "JOB": job}
    before = bytes_of(users, [*ANYWHERE, *ELSEWHERE])
    everything = sorted(users.parent.rglob("*"))
    _, told = type_(*(stand_for.get(word, word) for word in words), code=2)
    message = " ".join(told.replace("│", " ").split())
    assert any(way in message for way in WAY_OUT), message
    assert bytes_of(users, [*ANYWHERE, *ELSEWHERE]) == before
    assert sorted(users.parent.rglob("*")) == everything  # and nothing is laid beside them


def test_a_proposed_folder_is_named(users):
    told = type_("run", "small.yaml", "--out", ".", code=2)[1]
    assert "use a separate folder for the results, such as --out results/small" in " ".join(told.split())
    told = type_("run", "small.yaml", "--out", ".", "--quick", code=2)[1]
    assert "such as --out results/small-quick" in " ".join(told.split())
    put(users / "results/small", ["mine.txt"])
    assert "such as --out results/small-2" in " ".join(type_("run", "small.yaml", code=2)[1].split())


def test_a_lock_with_content_is_a_file_of_the_user(users):
    put(users / "locked", [".lock"])
    assert "holds files of your own (.lock" in " ".join(
        type_("run", "small.yaml", "--out", "locked", code=2)[1].split()
    )


IN_RESULTS = [
    ["run", "small.yaml", "--out", "ours"],
    ["run", "small.yaml", "--out", "ours", "--set", "load=170 N", "--quick"],
    ["run", "small.yaml", "--out", "ours", "--verify", "--retry-failed"],
    ["run", "small.yaml", "--out", "ours", "--fresh", "--quick"],
    ["run", "other.yaml", "--out", "ours", "--fresh", "--quick"],
    ["merge", "DONE", "--out", "ours"],
    ["prune", "ours"],
    ["prune", "ours", "--no-dry-run"],
    ["plot", "ours"],
    ["plot", "ours", "--kind", "spectrum", "--format", "svg"],
    ["show", "ours"],
    ["export", "ours", "--features", "ours/table.csv"],
]


@pytest.mark.parametrize("words", IN_RESULTS, ids=" ".join)
def test_files_of_the_user_in_a_results_folder_stay_as_they_are(tmp_path, monkeypatch, done, words):
    monkeypatch.chdir(tmp_path)
    Path("small.yaml").write_text(STUDY)
    Path("other.yaml").write_text(STUDY.replace("study: small", "study: other"))
    shutil.copytree(done, "ours")
    put(tmp_path / "ours", ANYWHERE)
    before = bytes_of(tmp_path / "ours", ANYWHERE)
    type_(*(str(done) if word == "DONE" else word for word in words), *(["--jobs", "1"] * (words[0] == "run")))
    assert bytes_of(tmp_path / "ours", ANYWHERE) == before
    if "--fresh" in words:
        assert not (tmp_path / "ours/units/00").exists()


def test_a_fresh_start_removes_results_and_says_whose(tmp_path, monkeypatch, done):
    monkeypatch.chdir(tmp_path)
    Path("other.yaml").write_text(STUDY.replace("study: small", "study: other"))
    shutil.copytree(done, "ours")
    units = {path.stem for path in Path("ours").glob("units/*/*.h5")}
    told = " ".join(type_("run", "other.yaml", "--out", "ours", "--quick", "--jobs", "1", code=2)[1].split())
    assert f"ours holds results of the study `small` ({len(units)} units, 0 failures)" in told
    assert "such as --out results/other-quick, or delete them by `run --fresh`" in told
    assert {path.stem for path in Path("ours").glob("units/*/*.h5")} == units
    told = type_("run", "other.yaml", "--out", "ours", "--quick", "--jobs", "1", "--fresh")[1]
    assert f"the results of the study `small` ({len(units)} units, 0 failures)" in told
    assert json.loads(Path("ours/bearingsim.json").read_text())["name"] == "other"
    assert not units & {path.stem for path in Path("ours").glob("units/*/*.h5")}


def test_results_of_an_earlier_version_are_marked_by_their_plan(tmp_path, monkeypatch, done):
    monkeypatch.chdir(tmp_path)
    Path("small.yaml").write_text(STUDY)
    shutil.copytree(done, "ours")
    Path("ours/bearingsim.json").unlink()
    assert "8 of 8 jobs done" in type_("run", "small.yaml", "--out", "ours", "--verify", "--jobs", "1")[0]
    assert json.loads(Path("ours/bearingsim.json").read_text())["name"] == "small"
    Path("ours/plan.json").write_text("{}")  # the marker suffices
    assert "8 of 8 jobs done" in type_("run", "small.yaml", "--out", "ours", "--verify", "--jobs", "1")[0]
    Path("ours/plan.json").write_text("{}")
    Path("ours/bearingsim.json").write_text("{}")
    type_("run", "small.yaml", "--out", "ours", "--jobs", "1", code=2)


def test_a_study_file_that_was_run_where_its_results_are_is_never_written(tmp_path, monkeypatch, done):
    """As earlier versions let one do: `run study.yaml --out .`."""
    shutil.copytree(done, tmp_path / "ours")
    monkeypatch.chdir(tmp_path / "ours")
    mine = STUDY.replace("\n", "\r\n").encode()
    Path("study.yaml").write_bytes(mine)
    Path("bearingsim.json").unlink()
    type_("run", "study.yaml", "--out", ".", "--jobs", "1", "--quick")
    assert Path("study.yaml").read_bytes() == mine
    Path("../other.yaml").write_text(STUDY.replace("study: small", "study: other"))
    told = type_("run", "../other.yaml", "--out", ".", "--jobs", "1", "--quick", "--fresh", code=2)[1]
    assert "such as --out results/other-quick, or move the file" in " ".join(told.split())
    assert Path("study.yaml").read_bytes() == mine


def test_a_figure_of_this_program_is_drawn_anew(done, tmp_path):
    for file_format in ("png", "svg", "pdf"):
        first = type_("plot", done, "--out", tmp_path, "--format", file_format)[0]
        assert type_("plot", done, "--out", tmp_path, "--format", file_format)[0] == first


@pytest.mark.parametrize("kind", ["link", "folder"])
def test_a_link_or_a_folder_is_no_figure(done, tmp_path, kind):
    path = tmp_path / "fig1-velocity-bpfo-vs-load.png"
    if kind == "link":
        path.symlink_to(tmp_path / "nowhere")
    else:
        path.mkdir()
    told = type_("plot", done, "--out", tmp_path, code=2)[1]
    assert "is not a figure of this program" in " ".join(told.split())
    assert path.is_symlink() or path.is_dir()


def test_a_figure_with_an_ending_in_capitals_is_drawn(plane, tmp_path):
    type_("sensitivity", plane, "--of", "velocity@BPFO", "--out", tmp_path / "plane.PNG")
    assert (tmp_path / "plane.PNG").read_bytes().startswith(b"\x89PNG")


def test_force_replaces_an_export(done, tmp_path):
    table = tmp_path / "table.csv"
    table.write_text("mine")
    assert "use --force to overwrite it" in " ".join(type_("export", done, "--features", table, code=2)[1].split())
    assert table.read_text() == "mine"
    type_("export", done, "--features", table, "--force")
    assert len(table.read_text().splitlines()) == 9
