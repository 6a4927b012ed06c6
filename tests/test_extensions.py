"""Another package adds a law, a method, a model, a shape and a feature: a file and a line each."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

TOYS = Path(__file__).parent / "toys"
STUDY = """\
study: toys
bearing: nf308
speed: 1800 rpm
load: 150 N
duration: 20 ms
settle: 10 ms
step_check: false
defect: {shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 50 um}
"""
ADDED = {
    "contact law": "contact: {stiffness: {law: quadratic, coefficient: 1e7}}",
    "damping law": "contact: {damping: {law: viscous, c: 200 N s/m}}",
    "damping law, implicit": "contact: {damping: viscous}\nmethod: rodas",
    "method": "method: leapfrog",
    "model": "model: one-mass",
    "shape": "defect: {shape: wedge, length: 12 mm, width: 0.8 mm, depth: 50 um}",
}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the toys as an installed package."""
    folder = tmp_path_factory.mktemp("site")
    shutil.copytree(TOYS, folder, dirs_exist_ok=True)
    return folder


def type_(site: Path, *words: str | Path) -> subprocess.CompletedProcess[str]:
    """Run a command where the toys are installed."""
    path = os.pathsep.join([str(site), os.environ["PYTHONPATH"]])
    environment = os.environ | {"PYTHONPATH": path, "BEARINGSIM_CACHE": str(site / "cache"), "COLUMNS": "200"}
    command = [sys.executable, "-m", "bearingsim", *map(str, words)]
    return subprocess.run(command, env=environment, capture_output=True, text=True, cwd=site)


def write(site: Path, more: str) -> Path:
    """A study of the toys; what ``more`` says stands instead of the same key."""
    keys = {line.split(":")[0] for line in more.splitlines()}
    lines = [line for line in STUDY.splitlines() if line.split(":")[0] not in keys]
    path = site / "toys.yaml"
    path.write_text("\n".join([*lines, more, ""]))
    return path


def table(site: Path, more: str) -> pd.DataFrame:
    """The results of a study of the toys."""
    shutil.rmtree(site / "out", ignore_errors=True)
    done = type_(site, "run", write(site, more), "--jobs", "1", "--out", "out")
    assert done.returncode == 0, done.stdout + done.stderr
    return pd.read_csv(site / "out" / "results.csv", comment="#")


@pytest.fixture(scope="module")
def usual(site: Path) -> float:
    """The RMS without any of the toys."""
    return float(table(site, "")["velocity.rms"][0])


@pytest.mark.parametrize("what", ADDED)
def test_a_study_runs_with_each(site: Path, usual: float, what: str) -> None:
    checked = type_(site, "check", write(site, ADDED[what]))
    assert checked.returncode == 0, checked.stdout + checked.stderr
    found = table(site, ADDED[what])
    assert (found["velocity.span"] > 0.0).all()
    assert found["velocity.rms"][0] != usual  # it is not the program's own that has run


def test_the_schema_knows_them(site: Path) -> None:
    schema = type_(site, "check", "--schema").stdout
    assert json.loads(schema)["properties"]["model"]["enum"][-1] == "one-mass"
    assert all(word in schema for word in ("quadratic", "viscous", "leapfrog", "wedge", "velocity.span"))


def test_a_wrong_word_is_answered_with_them(site: Path) -> None:
    said = type_(site, "check", write(site, "method: leapfrogg")).stderr
    assert "leapfrog" in said


def test_a_figure_draws_a_feature(site: Path) -> None:
    """Its jobs are computed by two processes, which find the extension too."""
    more = "sweep: {load: [150 N, 200 N]}\nfigures: [{y: velocity.span, x: load}]\nmodel: one-mass"
    shutil.rmtree(site / "out", ignore_errors=True)
    done = type_(site, "run", write(site, more), "--jobs", "2", "--out", "out")
    assert done.returncode == 0, done.stdout + done.stderr
    drawn = type_(site, "plot", "out")
    assert drawn.returncode == 0, drawn.stderr
    assert list((site / "out" / "figures").glob("*.png"))


def test_a_law_without_its_derivatives_is_refused_by_name(site: Path) -> None:
    study = write(site, "contact: {damping: unfinished}\nmethod: rodas")
    refused = type_(site, "check", study)
    assert refused.returncode != 0
    assert (
        "the damping law `unfinished` has no `slopes`, which rodas solves with" in refused.stdout + refused.stderr
    )
    assert type_(site, "check", write(site, "contact: {damping: unfinished}")).returncode == 0


def test_an_edited_law_gives_its_new_number(site: Path) -> None:
    """Compiled code and results are kept between processes, but not beyond a change of anybody's law."""
    before = table(site, ADDED["damping law"])["velocity.rms"]
    study = write(site, ADDED["damping law"])
    law = site / "toy_bearing" / "viscous.py"
    text = law.read_text()
    try:
        law.write_text(text.replace("SHARE = 1.0", "SHARE = 3.0"))
        assert "2 done of 2 jobs" in type_(site, "run", study, "--jobs", "1", "--out", "out").stdout
        after = pd.read_csv(site / "out" / "results.csv", comment="#")["velocity.rms"]
    finally:
        law.write_text(text)
    assert abs(after / before - 1.0).max() > 0.01


def test_an_extension_that_does_not_load_is_told_in_one_line(site: Path, tmp_path: Path) -> None:
    broken = tmp_path / "site"
    shutil.copytree(TOYS, broken)
    (broken / "toy_bearing" / "__init__.py").write_text("import nothing_of_that_name\n")
    said = type_(broken, "check", write(broken, ""))
    assert said.returncode == 2
    assert "the extension `toys` (toy_bearing) does not load" in said.stderr
    assert "Traceback" not in said.stderr
