"""No command changes a file of the user."""

import json
import shutil
from inspect import signature
from pathlib import Path

import pytest

from bearingsim.cli.app import app
from tests.scenes.commands import STUDY, type_, write_signal
from tests.scenes.design_results import run_design

USER_FILES = [
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
"""Names that the program never writes, so that the files are the user's even in a results folder."""
PROGRAM_FILES = [
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
"""Names that the program writes, too."""

ONE_MODEL = STUDY.partition("quick:")[0].replace("  model: [static, ring]\n", "").replace(", by: model", "")
TEXTS = {
    "study.yaml": STUDY,
    "small.yaml": STUDY,
    "accurate.yaml": STUDY.replace("  model: [static, ring]\n", "")
    .replace(", by: model", "")
    .replace("quick:", "accuracy: 5 %\n#"),
}


def write_files(folder, names):
    """Write files of the user, each with its own text, and a link to a folder outside."""
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(TEXTS.get(name, json.dumps({"mine": name, "jobs": [1], "study": "x"})))
    outside = folder.parent / "outside"
    outside.mkdir(exist_ok=True)
    (outside / "0123456789abcdef.h5").write_text("outside")
    (folder / "archive").symlink_to(outside)


def read_files(folder, names):
    return {name: (folder / name).read_bytes() for name in [*names, "archive/0123456789abcdef.h5"]}


@pytest.fixture
def user_folder(tmp_path, monkeypatch):
    """A folder of the user, with 47 files and a link, that is the working folder."""
    folder = tmp_path / "users"
    write_files(folder, [*USER_FILES, *PROGRAM_FILES])
    monkeypatch.chdir(folder)
    return folder


COMMAND_LINES = {
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
    "report": [
        ["report", "."],
        ["report", "DONE", "--out", "thesis.tex"],
        ["report", "DONE", "--out", "data"],
        ["report", "DONE", "--out", "results.csv", "--series", "JOB"],
    ],
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
    "analyze": [["analyze", "SIGNAL", "--bearing", "nf308", "--figure", "figures/thesis.png"]],
    "compare": [["compare", "DONE", "SIGNAL", "--job", "JOB", "--unit", "m/s", "--figure", "figures/thesis.png"]],
}
"""Commands that would write into a folder or over a file of the user. DONE, PLANE, JOB, SIGNAL: placeholders."""
WITHOUT_FOLDER = {"freq", "warm"}
"""Commands that write no files into folders of the user."""
REMEDIES = ("--out", "another", "name a file", "contains no results", "--force", "not a folder")


@pytest.fixture(scope="session")
def plane(tmp_path_factory):
    return run_design(tmp_path_factory.mktemp("plane") / "fake", n=16)


@pytest.fixture(scope="session")
def signal(tmp_path_factory):
    path = tmp_path_factory.mktemp("measured") / "signal.npz"
    write_signal(path)
    return path


def commands():
    """Return the functions of all commands by name."""
    return {
        str(command.name or command.callback.__name__): command.callback
        for command in app.registered_commands
        if command.callback
    }


def test_every_command_and_option_that_names_a_path_is_tried():
    assert {*COMMAND_LINES, *WITHOUT_FOLDER} == {*commands()}
    for name, lines in COMMAND_LINES.items():
        options = {
            option
            for option, parameter in signature(commands()[name]).parameters.items()
            if "Path" in str(parameter)
        }
        tried_options = {word.removeprefix("--") for line in lines for word in line if word.startswith("--")}
        assert options - {"study", "results", "path", "folders", "file"} <= tried_options, name


@pytest.mark.parametrize("words", [line for lines in COMMAND_LINES.values() for line in lines], ids=" ".join)
def test_user_folder_is_unchanged(user_folder, done, plane, signal, words):
    job = json.loads((done / "plan.json").read_text())["jobs"][0]["job"]
    placeholders = {"DONE": str(done), "PLANE": str(plane), "JOB": job, "SIGNAL": str(signal)}
    before = read_files(user_folder, [*USER_FILES, *PROGRAM_FILES])
    paths = sorted(user_folder.parent.rglob("*"))
    _, stderr = type_(*(placeholders.get(word, word) for word in words), code=2)
    message = " ".join(stderr.replace("│", " ").split())
    assert any(phrase in message for phrase in REMEDIES), message
    assert read_files(user_folder, [*USER_FILES, *PROGRAM_FILES]) == before
    assert sorted(user_folder.parent.rglob("*")) == paths  # and no file is added


def test_separate_folder_is_proposed(user_folder):
    stderr = type_("run", "small.yaml", "--out", ".", code=2)[1]
    assert "use a separate folder for the results, such as --out results/small" in " ".join(stderr.split())
    stderr = type_("run", "small.yaml", "--out", ".", "--quick", code=2)[1]
    assert "such as --out results/small-quick" in " ".join(stderr.split())
    write_files(user_folder / "results/small", ["mine.txt"])
    assert "such as --out results/small-2" in " ".join(type_("run", "small.yaml", code=2)[1].split())


def test_lock_with_content_counts_as_user_file(user_folder):
    write_files(user_folder / "locked", [".lock"])
    assert "contains files of your own (.lock" in " ".join(
        type_("run", "small.yaml", "--out", "locked", code=2)[1].split()
    )


RESULTS_LINES = [
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


@pytest.mark.parametrize("words", RESULTS_LINES, ids=" ".join)
def test_user_files_in_a_results_folder_are_unchanged(tmp_path, monkeypatch, done, words):
    monkeypatch.chdir(tmp_path)
    Path("small.yaml").write_text(STUDY)
    Path("other.yaml").write_text(STUDY.replace("study: small", "study: other"))
    shutil.copytree(done, "ours")
    write_files(tmp_path / "ours", USER_FILES)
    before = read_files(tmp_path / "ours", USER_FILES)
    type_(*(str(done) if word == "DONE" else word for word in words), *(["--jobs", "1"] * (words[0] == "run")))
    assert read_files(tmp_path / "ours", USER_FILES) == before
    if "--fresh" in words:
        assert not (tmp_path / "ours/units/00").exists()


def test_fresh_removes_results_and_names_their_study(tmp_path, monkeypatch, done):
    monkeypatch.chdir(tmp_path)
    Path("other.yaml").write_text(STUDY.replace("study: small", "study: other"))
    shutil.copytree(done, "ours")
    units = {path.stem for path in Path("ours").glob("units/*/*.h5")}
    stderr = " ".join(type_("run", "other.yaml", "--out", "ours", "--quick", "--jobs", "1", code=2)[1].split())
    assert f"ours contains results of the study `small` ({len(units)} units, 0 failures)" in stderr
    assert "such as --out results/other-quick, or delete them by `run --fresh`" in stderr
    assert {path.stem for path in Path("ours").glob("units/*/*.h5")} == units
    stderr = type_("run", "other.yaml", "--out", "ours", "--quick", "--jobs", "1", "--fresh")[1]
    assert f"the results of the study `small` ({len(units)} units, 0 failures)" in stderr
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


def test_study_file_in_its_results_folder_is_unchanged(tmp_path, monkeypatch, done):
    """Earlier versions allowed `run study.yaml --out .`."""
    shutil.copytree(done, tmp_path / "ours")
    monkeypatch.chdir(tmp_path / "ours")
    mine = STUDY.replace("\n", "\r\n").encode()
    Path("study.yaml").write_bytes(mine)
    Path("bearingsim.json").unlink()
    type_("run", "study.yaml", "--out", ".", "--jobs", "1", "--quick")
    assert Path("study.yaml").read_bytes() == mine
    Path("../other.yaml").write_text(STUDY.replace("study: small", "study: other"))
    stderr = type_("run", "../other.yaml", "--out", ".", "--jobs", "1", "--quick", "--fresh", code=2)[1]
    assert "such as --out results/other-quick, or move the file" in " ".join(stderr.split())
    assert Path("study.yaml").read_bytes() == mine


def test_study_file_in_its_results_folder_is_unchanged_from_any_place(tmp_path, monkeypatch, done):
    """The working folder may be another one, and the results folder may have been moved."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(done, "ours")
    mine = STUDY.replace("300 N", "310 N") + "# my notes\n"
    Path("ours/study.yaml").write_text(mine)
    type_("run", "ours/study.yaml", "--out", "ours", "--jobs", "1", "--quick")
    Path("elsewhere").mkdir()
    Path("ours").rename("moved")
    monkeypatch.chdir("elsewhere")
    Path("other.yaml").write_text(STUDY)
    stderr = type_("run", "other.yaml", "--out", "../moved", "--jobs", "1", "--quick", code=2)[1]
    assert "is the study file of an earlier run" in " ".join(stderr.split())
    assert Path("../moved/study.yaml").read_text() == mine
    Path("other.yaml").write_text(mine)  # nothing would be lost
    type_("run", "other.yaml", "--out", "../moved", "--jobs", "1", "--quick")


def test_study_file_beside_a_damaged_plan_is_unchanged(tmp_path, monkeypatch, done):
    """Only the plan tells whether it is the user's."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(done, "ours")
    mine = STUDY + "# my notes\n"
    Path("ours/study.yaml").write_text(mine)
    type_("run", "ours/study.yaml", "--out", "ours", "--jobs", "1", "--quick")
    plan = Path("ours/plan.json").read_bytes()
    Path("ours/plan.json").write_bytes(plan[: len(plan) // 2])
    Path("other.yaml").write_text(STUDY)
    stderr = type_("run", "other.yaml", "--out", "ours", "--jobs", "1", "--quick", code=2)[1]
    assert "may be the study file of an earlier run" in " ".join(stderr.split())
    assert Path("ours/study.yaml").read_text() == mine
    type_("run", "ours/study.yaml", "--out", "ours", "--jobs", "1", "--quick")
    assert Path("ours/plan.json").read_bytes() == plan


def test_existing_figure_is_replaced(done, tmp_path):
    for file_format in ("png", "svg", "pdf"):
        first = type_("plot", done, "--out", tmp_path, "--format", file_format)[0]
        assert type_("plot", done, "--out", tmp_path, "--format", file_format)[0] == first


@pytest.mark.parametrize("kind", ["link", "folder"])
def test_link_or_folder_is_not_replaced_by_a_figure(done, tmp_path, kind):
    path = tmp_path / "fig1-velocity-bpfo-vs-load.png"
    if kind == "link":
        path.symlink_to(tmp_path / "nowhere")
    else:
        path.mkdir()
    stderr = type_("plot", done, "--out", tmp_path, code=2)[1]
    assert "is not a figure of bearingsim" in " ".join(stderr.split())
    assert path.is_symlink() or path.is_dir()


def test_figure_suffix_may_be_upper_case(plane, tmp_path):
    type_("sensitivity", plane, "--of", "velocity@BPFO", "--out", tmp_path / "plane.PNG")
    assert (tmp_path / "plane.PNG").read_bytes().startswith(b"\x89PNG")


def test_force_replaces_an_export(done, tmp_path):
    table = tmp_path / "table.csv"
    table.write_text("mine")
    assert "use --force to overwrite it" in " ".join(type_("export", done, "--features", table, code=2)[1].split())
    assert table.read_text() == "mine"
    type_("export", done, "--features", table, "--force")
    assert len(table.read_text().splitlines()) == 9
