"""Another package adds a law, a method, a model, a shape and a feature: a file and a line each."""

import json
import os
import shutil
import subprocess
import sys
from math import hypot, pi, sqrt
from pathlib import Path

import pandas as pd
import pytest

from bearingsim import extensions, load_study

TOYS = Path(__file__).parent / "toys"
STUDY = """\
study: toys
bearing: nf308
speed: 1800 rpm
load: 150 N
duration: 20 ms
settle: 10 ms
clearance: 0 um
step_check: false
"""
DEFECT = "defect: {shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 50 um}\n"
QUADRATIC = "stiffness: {law: quadratic, coefficient: 1e7}"
DASHPOTS = f"contact: {{{QUADRATIC}, damping: {{law: viscous, c: 200 N s/m}}}}\n{DEFECT}"
WIDE_DEFECT = DASHPOTS.replace("0.8 mm, depth: 50 um", "2 mm, depth: 20 um")  # a roller touches its floor
UNFINISHED = f"contact: {{{QUADRATIC}, damping: unfinished}}\n"
STATIC = "model: static\n"
ONE_MASS = "model: one-mass\nrig: {ring_mass: 1 kg}\n"
RING = "model: ring\nsweep: {contact.damping.c: [200 N s/m, 400 N s/m]}\n"
TOY_STUDIES = {
    "contact law": f"contact: {{{QUADRATIC}}}\n{STATIC}sweep: {{contact.stiffness.coefficient: [1e7, 4e7]}}",
    "damping law": f"{DASHPOTS}{RING}method: leapfrog",
    "damping law, implicit": f"{DASHPOTS}{RING}method: velocity-implicit-euler",
    "method and model": f"{DASHPOTS}{ONE_MASS}sweep: {{method: [leapfrog, verlet]}}",
    "shape": f"{WIDE_DEFECT}{STATIC}sweep: {{defect.shape: [wedge, rectangular]}}",
    "figure": f"{DASHPOTS}{STATIC}sweep: {{load: [150 N, 200 N]}}\nfigures: [{{y: velocity.span, x: load}}]",
}
"""Studies of the toys. All have the same contact, whatever they are about: another one would be compiled anew."""
WRONG_STUDIES = {
    "word": "method: leapfrogg",
    "unfinished": UNFINISHED,
    "unfinished, implicit": f"{UNFINISHED}method: rodas",
}
OWN_STUDIES = {"own": f"{STATIC}{DEFECT}"}
"""A study of the program's own."""
TYPE = """\
import json, sys
from typer.testing import CliRunner
from bearingsim.cli.app import app
said = []
for words in json.load(sys.stdin):
    done = CliRunner().invoke(app, words)
    said.append((done.exit_code, done.stdout, done.stderr))
print(json.dumps(said))
"""
Outputs = dict[tuple[str, ...], tuple[int, str, str]]
"""Of commands: exit code, stdout and stderr."""


def run_python(site: Path, *words: str, stdin: str = "") -> subprocess.CompletedProcess[str]:
    """A process where the toys are installed."""
    path = os.pathsep.join([str(site), os.environ["PYTHONPATH"]])
    environment = os.environ | {"PYTHONPATH": path, "BEARINGSIM_CACHE": str(site / "cache"), "COLUMNS": "200"}
    return subprocess.run(
        [sys.executable, *words], env=environment, capture_output=True, text=True, cwd=site, input=stdin
    )


def type_commands(site: Path, *commands: tuple[str, ...]) -> Outputs:
    """Return the outputs of commands run one after the other in a new process."""
    process = run_python(site, "-c", TYPE, stdin=json.dumps(commands))
    assert process.returncode == 0, process.stdout + process.stderr
    return {words: tuple(output) for words, output in zip(commands, json.loads(process.stdout), strict=True)}


def run(name: str, jobs: int = 1) -> tuple[str, ...]:
    """The command that runs a study."""
    return ("run", f"{name}.yaml", "--jobs", str(jobs), "--out", f"out/{name}")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the toys as an installed package, and studies of them."""
    folder = tmp_path_factory.mktemp("site")
    shutil.copytree(TOYS, folder, dirs_exist_ok=True)
    for name, settings in (TOY_STUDIES | WRONG_STUDIES | OWN_STUDIES).items():
        (folder / f"{name}.yaml").write_text(f"{STUDY}{settings}\n")
    return folder


@pytest.fixture(scope="module")
def command_outputs(site: Path) -> Outputs:
    """Outputs of most commands of this file, run in one process that compiles once."""
    checks = [("check", f"{name}.yaml") for name in TOY_STUDIES | WRONG_STUDIES]
    return type_commands(
        site, *checks, ("check", "--schema"), *(run(name) for name in TOY_STUDIES if name != "figure")
    )


def results(site: Path, name: str) -> pd.DataFrame:
    """The table that a run leaves."""
    return pd.read_csv(site / "out" / name / "results.csv", comment="#")


def table(site: Path, command_outputs: Outputs, name: str) -> pd.DataFrame:
    """The results of a study of the toys that was checked and run."""
    for command in (("check", f"{name}.yaml"), run(name)):
        code, *output = command_outputs[command]
        assert code == 0, output
    results_ = results(site, name)
    assert (results_["status"] == "done").all()
    assert (results_["velocity.span"] > 0.0).all()
    return results_


@pytest.fixture(scope="module")
def before(site: Path, command_outputs: Outputs) -> pd.DataFrame:
    """The results with the contact law as it is."""
    return table(site, command_outputs, "contact law")


def test_a_study_runs_with_a_contact_law(before: pd.DataFrame) -> None:
    """Four times the coefficient halves the approach, but for what the rig carries: no other law does that."""
    soft, stiff = before["velocity.rms"]
    assert soft / stiff == pytest.approx(2.0, rel=0.1)


def test_a_study_runs_with_a_damping_law(site: Path, command_outputs: Outputs) -> None:
    """An explicit and an implicit method call different parts of it, and find the same."""
    explicit, implicit = (
        table(site, command_outputs, name)["velocity.rms"][:2] for name in ("damping law", "damping law, implicit")
    )
    assert abs(explicit[1] / explicit[0] - 1.0) > 0.03
    assert list(implicit) == pytest.approx(list(explicit), rel=0.01)


def test_a_study_runs_with_a_method_and_a_model(site: Path, command_outputs: Outputs) -> None:
    """The push of 1 N once a ball pass has an answer that is known; another method is not wholly the same."""
    leapfrog, verlet = table(site, command_outputs, "method and model")["velocity.rms"][:2]
    omega = 2.0 * pi * 30.0 * 13 / 2 * (1.0 - 12.0 / 65.0)
    assert leapfrog == pytest.approx(omega / sqrt(2.0) / hypot(1e8 - omega**2, 1e3 * omega), rel=0.01)
    assert leapfrog != verlet
    assert leapfrog == pytest.approx(verlet, rel=1e-3)


def test_a_study_runs_with_a_shape(site: Path, command_outputs: Outputs) -> None:
    """Its defect is neither the program's own nor none at all."""
    wedge, rectangular, healthy = table(site, command_outputs, "shape")["velocity.rms"]
    assert wedge != pytest.approx(rectangular, rel=0.01)
    assert wedge > 2.0 * healthy


def test_schema_includes_extensions(command_outputs: Outputs) -> None:
    _, schema, _ = command_outputs["check", "--schema"]
    assert json.loads(schema)["properties"]["model"]["enum"][-1] == "one-mass"
    assert all(word in schema for word in ("quadratic", "viscous", "leapfrog", "wedge", "velocity.span"))


def test_unknown_word_suggests_extensions(command_outputs: Outputs) -> None:
    code, _, answer = command_outputs["check", "word.yaml"]
    assert code != 0
    assert "leapfrog" in answer


def test_a_law_without_its_derivatives_is_refused_by_name(command_outputs: Outputs) -> None:
    code, *refused = command_outputs["check", "unfinished, implicit.yaml"]
    assert code != 0
    assert "the damping law `unfinished` lacks `derivatives`, which rodas" in "".join(refused)
    assert command_outputs["check", "unfinished.yaml"][0] == 0


@pytest.fixture(scope="module")
def edited(site: Path, before: pd.DataFrame) -> Outputs:
    """Outputs of a second process while a law is edited: it repeats a study and runs one with two workers."""
    law = site / "toy_bearing" / "quadratic.py"
    text = law.read_text()
    try:
        law.write_text(text.replace("return law.k", "return 4.0 * law.k").replace("2.0 * law.k", "8.0 * law.k"))
        return type_commands(site, run("contact law"), run("figure", jobs=2), ("plot", "out/figure"))
    finally:
        law.write_text(text)


def test_edited_law_is_recompiled(site: Path, before: pd.DataFrame, edited: Outputs) -> None:
    """Compiled code and results are kept between processes, but not beyond a change of anybody's law."""
    assert "2 of 2 jobs done" in edited[run("contact law")][1]
    after = results(site, "contact law")["velocity.rms"]
    assert after[0] == pytest.approx(before["velocity.rms"][1])
    assert after[0] != pytest.approx(before["velocity.rms"][0], rel=0.1)


def test_a_figure_draws_a_feature(site: Path, edited: Outputs) -> None:
    """Its jobs are computed by two workers, which find the extension too."""
    for command in (run("figure", jobs=2), ("plot", "out/figure")):
        code, *words = edited[command]
        assert code == 0, words
    assert list((site / "out" / "figure" / "figures").glob("*.png"))


def test_a_feature_without_a_finite_value_is_named(site: Path, command_outputs: Outputs) -> None:
    """A healthy bearing has no depth: the number is left out, not stored as inf, and the run says so."""
    results_ = table(site, command_outputs, "shape")
    healthy = results_["healthy"].isna()
    assert results_["velocity.per_depth"].isna().equals(healthy)
    assert f"feature `velocity.per_depth` has no value in {healthy.sum()} of 3 jobs: computed as inf" in "".join(
        command_outputs[run("shape")][1:]
    )


@pytest.fixture(scope="module")
def broken(site: Path, before: pd.DataFrame, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with results of the toys, whose package does not load any more."""
    folder = tmp_path_factory.mktemp("broken") / "site"
    shutil.copytree(site, folder, ignore=shutil.ignore_patterns("cache"))
    (folder / "toy_bearing" / "__init__.py").write_text("import nothing_of_that_name\n")
    return folder


REASON = (
    "the extension `toys` (toy_bearing) does not load: ModuleNotFoundError: No module named 'nothing_of_that_name'"
)
RESULTS = "out/contact law"
WITHOUT = [
    ("--help",),
    ("new", "new.yaml"),
    ("freq", "nf308"),
    ("check", "--schema"),
    ("show", RESULTS),
    ("export", RESULTS, "--features", "-"),
    ("plot", RESULTS, "--y", "velocity.rms"),
    ("prune", RESULTS),
]
"""Commands that need no extension."""
COMPUTING = [("check", "own.yaml"), run("own"), ("stability", "--quick")]


def test_study_without_the_extension_runs(broken: Path) -> None:
    """A line on stderr names the extension and its error; what computes ends with it, and with the way out."""
    outputs = type_commands(broken, *WITHOUT, *COMPUTING)
    for words in WITHOUT:
        code, stdout, stderr = outputs[words]
        assert (code, stderr) == (0, f"{REASON} (skipped)\n" if words != ("--help",) else ""), words
        assert stdout, words
    for words in COMPUTING:
        advice = "Fix the extension, or set BEARINGSIM_SKIP_EXTENSIONS=toys to run without the extension"
        assert outputs[words] == (2, "", f"{REASON}\n{advice}\n"), words


IDS = "from bearingsim import load_study\nprint(*(job.id for job in load_study('own.yaml').jobs()))"


def test_an_edited_feature_gives_other_jobs(site: Path, broken: Path) -> None:
    """Of a study, too, that uses nothing else of an extension; one that is skipped leaves the ids of none."""
    feature = site / "toy_bearing" / "span.py"
    text = feature.read_text()
    ids = [run_python(site, "-c", IDS).stdout.split()]
    try:
        feature.write_text(text.replace("velocity.max() -", "velocity.max() +"))
        ids.append(run_python(site, "-c", IDS).stdout.split())
    finally:
        feature.write_text(text)
    assert len({*ids[0], *ids[1]}) == 4
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(extensions.SKIP, "other, toys")
        without = run_python(broken, "-c", IDS).stdout.split()
    assert without == [job.id for job in load_study(site / "own.yaml").jobs()]
    assert not {*without} & {*ids[0], *ids[1]}
