"""Commands: text, exit code, files."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from bearingsim import __version__
from bearingsim.cli import screen
from bearingsim.cli.app import app
from bearingsim.core.models.equilibrium import NoEquilibrium
from bearingsim.simulation import limits
from bearingsim.study import SCHEMA_FILE
from tests.scenes.commands import STUDY, type_

# The program


def run_python(code, **env):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=os.environ | env)


def test_help_imports_nothing_heavy():
    code = (
        "import sys\nfrom bearingsim.cli import main\nsys.argv = ['bearingsim', '--help']\n"
        "try: main()\nexcept SystemExit as end: assert end.code == 0\n"
        "heavy = {'numba', 'scipy', 'pandas', 'matplotlib', 'h5py', 'numpy', 'pydantic', 'yaml', 'joblib'}\n"
        "print('HEAVY', sorted(heavy & set(sys.modules)))"
    )
    stdout = run_python(code).stdout
    assert stdout.rstrip().endswith("HEAVY []")
    assert "Parametric studies" in stdout


def test_checking_a_wrong_study_imports_nothing_heavy(study_folder):
    Path("small.yaml").write_text(STUDY.replace("150 N", "150 kg"))
    code = (
        "import sys\nfrom bearingsim.cli import main\nsys.argv = ['bearingsim', 'check', 'small.yaml']\n"
        "try: main()\nexcept SystemExit as end: assert end.code == 2\n"
        "print('HEAVY', sorted({'numba', 'scipy', 'pandas', 'matplotlib', 'h5py'} & set(sys.modules)))"
    )
    assert run_python(code).stdout.rstrip().endswith("HEAVY []")


def test_python_m_is_the_command():
    result = subprocess.run([sys.executable, "-m", "bearingsim", "--version"], capture_output=True, text=True)
    assert result.stdout == f"bearingsim {__version__}\n"


def test_no_color_is_honoured(study_folder):
    code = "import sys\nfrom bearingsim.cli import main\nsys.argv = ['bearingsim', 'freq', 'nf308']\nmain()"
    assert "\x1b" in run_python(code, FORCE_COLOR="1", NO_COLOR="").stdout
    stdout = run_python(code, FORCE_COLOR="1", NO_COLOR="1").stdout
    assert "BPFO" in stdout
    assert "\x1b[3" not in stdout


@pytest.mark.parametrize("words", [["rum"], ["run"], ["check", "small.yaml", "--sett", "a=b"]])
def test_wrong_command_exits_with_2(study_folder, words):
    stdout, stderr = type_(*words, code=2)
    assert stdout == ""
    assert stderr


# new, check


def test_new_writes_a_study_that_checks(study_folder):
    stdout, _ = type_("new", "mine.yaml")
    assert "mine.yaml" in stdout
    stdout, _ = type_("check", "mine.yaml")
    assert stdout.startswith("defect-length: 15 jobs (12 cases, 3 healthy baselines)")


def test_new_writes_the_schema_that_the_study_names(study_folder):
    type_("new", "sub/mine.yaml", code=2)
    assert not Path("sub").exists()
    Path("sub").mkdir()
    assert type_("new", "sub/mine.yaml")[1] == ""
    assert Path("sub/mine.yaml").read_text().startswith(f"# yaml-language-server: $schema=./{SCHEMA_FILE}\n")
    assert Path("sub", SCHEMA_FILE).read_text() == type_("check", "--schema")[0]
    assert type_("new", "sub/second.yaml")[1] == ""  # the same schema serves both


@pytest.mark.parametrize(
    "create", [lambda path: path.write_text("{}"), Path.mkdir, lambda path: path.symlink_to("x")]
)
def test_new_keeps_another_schema(study_folder, create):
    def file_stats():
        stats = {path.name: path.lstat() for path in Path().iterdir() if path.name != "mine.yaml"}
        return {name: (stat.st_ino, stat.st_mode, stat.st_size, stat.st_mtime_ns) for name, stat in stats.items()}

    create(Path(SCHEMA_FILE))
    before = file_stats()
    _, stderr = type_("new", "mine.yaml")
    assert stderr.startswith(f"{SCHEMA_FILE} is not this version's schema and is kept")
    assert "`bearingsim check --schema`" in stderr
    assert file_stats() == before


def test_new_overwrites_nothing(study_folder):
    _, stderr = type_("new", "small.yaml", code=2)
    assert "small.yaml exists; name another file" in stderr
    assert Path("small.yaml").read_text() == STUDY


def test_check_prints_the_plan(study_folder):
    stdout, _ = type_("-v", "check", "small.yaml", "--jobs", "2")
    assert "8 jobs (4 cases, 4 healthy baselines); sweeps load, model" in stdout
    rows = {line[: line.find("  ")].strip(): line.split() for line in stdout.splitlines() if "  " in line}
    assert rows["cases"][-2:] == ["2", "2"]
    assert rows["crossing of the defect (us)"][-2:] == ["270", "270"]  # 0.8 mm at 2.959 m/s
    assert rows["step limit at rest (us)"][5] == "-"  # the static model has none
    assert "2 workers" in stdout
    assert rows["damping c/k at rest (us)"][-2:] == ["2.5", "2.5"]
    assert "\ndamping: c/k 2.5 us (plausible: 0.3 to 25), ratio 0.0581 to 0.0596;" in stdout


def test_check_prints_frequencies_and_drop(study_folder):
    """Z = 13, D_w/d_m = 12/65 at 30 Hz: FTF 15 (1 - 12/65), BPFO 13 FTF, BPFI 13 (30 - FTF)."""
    stdout, _ = type_("check", "small.yaml", "--jobs", "2")
    rows = {line[: line.find("  ")].strip(): line.split() for line in stdout.splitlines() if "  " in line}
    for name, hertz in {"BPFO": 159.0, "BPFI": 231.0, "BSF": 78.5, "FTF": 12.2308}.items():
        assert float(rows[f"{name} (Hz)"][-1]) == pytest.approx(hertz, rel=3e-3)
    assert float(rows["samples per crossing"][-1]) == pytest.approx(270e-6 * 10240, rel=0.01)
    assert max(map(len, stdout.splitlines())) < 100
    assert "by geometry, rollers drop 11.3 um and do not reach the floor at 50 um; rectangle" in stdout
    assert "step limit" not in stdout
    assert "plausible" not in stdout


@pytest.mark.parametrize(
    ("sweep", "remark"),
    [
        ("load: [150 N]", None),
        ("defect.depth: [5 um, 10 um]", "reach the floor at 5 .. 10 um: the depth matters\n"),
        ("defect.depth: [10 um, 20 um]", "reach the floor at 10 um for depth 10 µm: the depth matters there\n"),
        ("defect.width: [0.8 mm, 2 mm]", "reach the floor at 50 um for width 2 mm: the depth matters there\n"),
        (
            "defect.width: [0.8 mm, 2 mm, 3 mm, 4 mm]",
            "reach the floor at 50 um for width 2 mm to 4 mm: the depth matters there\n",
        ),
        (
            "defect.depth: [10 um, 50 um], defect.width: [0.8 mm, 2 mm]",
            "reach the floor at 10 .. 50 um in 3 of 4 cases: the depth matters there\n",
        ),
    ],
)
def test_check_names_the_cases_in_which_rollers_reach_the_floor(study_folder, sweep, remark):
    """A roller sinks 11.3 um between the rims of a slot of 0.8 mm, and 70 um in one of 2 mm."""
    Path("floor.yaml").write_text(f"{STUDY.partition('sweep:')[0]}sweep: {{{sweep}}}\n")
    stdout, _ = type_("check", "floor.yaml")
    assert (f"by geometry, rollers {remark}" in stdout) if remark else ("rollers reach" not in stdout)


@pytest.mark.parametrize(("depth", "same"), [("25 um", True), ("20 um", False)])
def test_triangle_equals_rectangle_only_with_steep_walls(study_folder, depth, same):
    """A roller sinks 11.3 um between the rims, and touches the walls of a V less than twice as deep."""
    stdout, _ = type_("check", "small.yaml", "--set", f"defect.depth={depth}")
    assert "rollers drop 11.3 um" in stdout
    assert ("rectangle and triangle agree" in stdout) == same


@pytest.mark.parametrize(("depth", "clear"), [("25 um", True), ("20 um", False)])
def test_no_remark_on_floors_if_rollers_touch_the_walls(study_folder, depth, clear):
    """The depth of a V less than twice as deep as the free drop of 11.3 um affects the path of the roller."""
    changes = ("--set", "defect.shape=triangular", "--set", f"defect.depth={depth}")
    stdout, _ = type_("check", "small.yaml", *changes)
    assert ("do not reach the floor" in stdout) == clear


def test_check_shows_the_design(study_folder):
    sweep = STUDY.replace("load: [150 N, 300 N]", "morris: {n: 6, over: {load: [150 N, 300 N]}}")
    Path("design.yaml").write_text(sweep.replace("model: [static, ring]", "model: [static]"))
    stdout, _ = type_("check", "design.yaml")
    assert stdout.splitlines()[1] == "design: morris, 6 trajectories of 1 path, seed 0; 12 rows, 4 cases"
    plan = json.loads(type_("check", "design.yaml", "--json")[0])
    assert (plan["design"]["kind"], plan["design"]["paths"]) == ("morris", ["load"])
    assert set(plan["design"]["ids"]) == {job["job"] for job in plan["jobs"] if not job["twin"]}
    assert json.loads(type_("check", "small.yaml", "--json")[0])["design"] is None


def test_a_design_of_a_billion_points_is_refused(study_folder):
    sweep = STUDY.replace("load: [150 N, 300 N]", "sobol: {n: 1000000000, over: {load: [150 N, 300 N]}}")
    Path("design.yaml").write_text(sweep)
    _, stderr = type_("check", "design.yaml", code=2)
    first, line, caret = stderr.splitlines()
    assert first.startswith("design.yaml:7:14: sweep.sobol.n: 1000000000 points of 1 path")
    assert line[caret.index("^") :].startswith("1000000000")


@pytest.mark.parametrize(
    ("values", "text"),
    [([0.2, 0.35], "0.2 .. 0.35"), ([2.0, 2.001], "2"), ([math.inf, 2.0, 0.0], "2"), ([math.inf], "-")],
)
def test_values_of_many_cases_are_a_range(values, text):
    assert screen.span(values) == text


def test_check_prints_friction_scale(study_folder):
    """0.3 of 49.6 N; slip settles in I/(2 mu' Q R^2) with I = m R^2/2, m = 10.65 g and mu' = 1.5 0.3/0.02 s/m."""
    plan = json.loads(type_("check", "small.yaml", "--set", "load=150 N", "--set", "model=planar", "--json")[0])
    limits = plan["jobs"][0]["limits"]
    assert limits["friction"] == pytest.approx(0.3 * limits["rest_load"], rel=0.01)
    assert limits["slip_settles"] == pytest.approx(0.01065 / (4.0 * 22.5 * limits["rest_load"]), rel=1e-3)
    assert plan["jobs"][0]["least_model"] == "static"
    words = ["--set", "load=150 N", "--set", "model=[ring, planar]"]
    stdout, _ = type_("-v", "check", "small.yaml", *words)
    rows = {line[: line.find("  ")].strip(): line.split() for line in stdout.splitlines() if "  " in line}
    assert rows["largest friction at rest (N)"][-2:] == ["-", "14.9"]
    assert rows["slip time constant at rest (us)"][-2:] == ["-", "2.39"]
    assert "slip time constant at rest" not in type_("-v", "check", "small.yaml")[0]


def test_check_json(study_folder):
    plan = json.loads(type_("check", "small.yaml", "--json", "--jobs", "2")[0])
    assert (plan["cases"], plan["twins"], plan["refused"]) == (4, 4, [])
    ring = [job for job in plan["jobs"] if job["model"] == "ring"]
    assert [0.0 < job["step"] < job["limits"]["at_impact"] for job in ring] == 4 * [True]
    assert plan["cpu_seconds"] == pytest.approx(sum(job["estimate"]["cpu_seconds"] for job in plan["jobs"]))
    assert plan["cpu_seconds"] / 2 <= plan["wall_seconds"] <= plan["cpu_seconds"]
    assert plan["most_cpu_seconds"] > plan["cpu_seconds"]


def test_check_lists_cases_when_asked(study_folder):
    stdout, _ = type_("check", "small.yaml", "-v")
    assert sum(line.startswith(("150 N", "300 N")) for line in stdout.splitlines()) == 4


def test_set_and_quick_change_the_plan(study_folder):
    stdout, _ = type_("check", "small.yaml", "--quick", "--set", "load=[100 N, 150 N, 200 N]")
    assert "6 jobs (3 cases, 3 healthy baselines)" in stdout


def test_check_shows_every_mistake_at_once(study_folder):
    Path("small.yaml").write_text(STUDY.replace("0.8 mm", "0,8 mm").replace("30 ms", "30"))
    stdout, stderr = type_("check", "small.yaml", code=2)
    assert stdout == ""
    assert "small.yaml:5:52: defect.width" in stderr
    assert "write a decimal point" in stderr
    assert "duration" in stderr


def test_a_step_over_the_limit_is_refused_once(study_folder):
    words = ["--set", "model=rollers", "--set", "method=verlet", "--set", "step=20 us"]
    stdout, stderr = type_("check", "small.yaml", *words, code=2)
    assert stdout == "small: 4 jobs (2 cases, 2 healthy baselines), 4 refused; sweeps load, model\n"
    [line] = stderr.splitlines()
    assert line.startswith("small.yaml: 4 jobs refused, the first at load 150 N")
    assert "of the method's limit" in line
    assert "use `step: auto`" in line


@pytest.mark.parametrize(("coefficient", "warned"), [(1e2, False), (1e6, True)])
def test_slow_contact_decay_is_reported(study_folder, coefficient, warned):
    """C/K of steel at 150 N: 0.3 ms with 1e2 N s/mm, 3 s with 1e6."""
    law = f"contact.damping={{law: general, coefficient: {coefficient}, indentation_exponent: 0}}"
    stdout, _ = type_("check", "small.yaml", "--set", "model=rollers", "--set", law)
    assert ("of the initial transient is left" in stdout) == warned


def test_refused_jobs_are_counted_in_json(study_folder):
    """The step is too long over a defect; the healthy cases take it."""
    words = ["--set", "step=200 us", "--json"]
    plan = json.loads(type_("check", "small.yaml", *words, code=2)[0])
    assert (plan["cases"], plan["twins"], plan["refused_jobs"]) == (4, 4, 4)
    assert len(plan["jobs"]) == 4
    assert len(plan["refused"]) == 2  # one of each model


def test_a_case_without_equilibrium_is_refused(study_folder, monkeypatch):
    def raise_no_equilibrium(case):
        raise NoEquilibrium(f"no equilibrium at {case.load} N")

    monkeypatch.setattr("bearingsim.simulation.limits.load_and_rates_at_rest", raise_no_equilibrium)
    for cached in (limits.step_limits, limits._common_limits):
        cached.cache_clear()
    _, stderr = type_("check", "small.yaml", code=2)
    place = "8 jobs refused, the first at load 150 N, model static"
    assert stderr == f"small.yaml: {place}: no equilibrium at 150.0 N; use a load that the rollers can carry\n"


def test_the_schema_is_json():
    schema = json.loads(type_("check", "--schema")[0])
    assert schema["title"] == "bearingsim study"


def test_check_needs_a_study():
    assert "name a study file" in type_("check", code=2)[1]


# run


def test_run_resumes(done):
    stdout, _ = type_("run", done.parents[1] / "small.yaml", "--jobs", "1", "--out", done, "--verify")
    assert stdout.startswith("small: 8 of 8 jobs done")


def test_default_results_folder(study_folder):
    stdout, _ = type_("run", "small.yaml", "--jobs", "1", "--quick", "--shard", "1/2")
    assert "2 of 2 jobs done" in stdout
    assert ", in results/small-quick\n" in stdout
    assert Path("results/small-quick/results.csv").is_file()


def test_failed_jobs_are_stored_and_reported(study_folder):
    words = ["run", "small.yaml", "--jobs", "1", "--set", "load=150 N", "--set", "model=rollers"]
    stdout, _ = type_(*words, "--set", "method=[dormand-prince, verlet]", "--set", "step=5 us", code=1)
    assert "2 of 4 jobs done" in stdout
    assert "2 jobs failed: a step of" in stdout
    stdout, _ = type_("show", "--failed")
    assert "method verlet" in stdout
    assert "of the method's limit" in stdout
    assert "again: bearingsim run small.yaml" in stdout
    table = json.loads(type_("show", "--failed", "--json")[0])
    assert [row["status"] for row in table] == ["failed", "failed"]
    assert table[0]["velocity@BPFO"] is None


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--set", "load"], "expected PATH=VALUE"),
        (["--set", "method="], "expected PATH=VALUE"),
        (["--set", "laod=150 N"], "did you mean `load`?"),
        (["--shard", "3/2"], "expected K/N"),
        (["--shard", "1/2", "--fresh"], "other shards"),
        (["--jobs", "0"], "greater than or equal to 1"),
    ],
)
def test_wrong_option_exits_with_2(study_folder, words, message):
    _, stderr = type_("run", "small.yaml", *words, code=2)
    assert message in " ".join(stderr.replace("│", " ").split())
    assert not Path("results").exists()


def test_missing_study_file(study_folder):
    assert type_("run", "none.yaml", code=2)[1] == "none.yaml: no such file\n"


@pytest.mark.parametrize("name", ["fig16", "fig16_angle.yaml", "studies/fig16-angle"])
def test_missing_file_named_as_a_shipped_study(study_folder, name):
    hint = "a shipped study has this name: `bearingsim new --from fig16_angle`"
    assert type_("run", name, code=2)[1] == f"{name}: no such file ({hint})\n"


def test_unwritable_output_folder(study_folder):
    Path("file").write_text("")
    _, stderr = type_("run", "small.yaml", "--jobs", "1", "--out", "file/results", code=2)
    assert stderr == f"{study_folder / 'file' / 'results'}: a part of this path is a file, not a folder\n"


def test_interrupt_exits_with_130_and_counts_done_jobs(study_folder, monkeypatch):
    from bearingsim import runner

    def interrupted(*_, **__):
        raise runner.Interrupted(
            runner.RunSummary("small", study_folder, 8, 1, 2, (), 0.5, 0.2, 0.4, 0.3, interrupted=2)
        )

    monkeypatch.setattr(runner, "run", interrupted)
    _, stderr = type_("run", "small.yaml", code=130)
    assert "3 of 8 jobs done in 0.5 s, 1 of them already stored, 5 left" in stderr
    assert "CPU time" not in stderr


def test_detail_shows_the_traceback_of_an_error(study_folder):
    result = CliRunner().invoke(app, ["check", "none.yaml", "-v"])
    assert result.exit_code == 2
    assert "Traceback" in result.stderr


# freq


def test_freq_prints_the_frequencies():
    stdout, _ = type_("freq", "nf308")
    rows = {line.split()[0]: line.split()[-6:] for line in stdout.splitlines()[3:]}
    assert rows["BPFO"] == ["5.3000", "159.000", "318.000", "477.000", "636.000", "795.000"]
    assert rows["BPFI"][:2] == ["7.7000", "231.000"]
    assert rows["FTF"][1] == "12.231"
    assert rows["BSF"][1] == "78.481"


def test_freq_json_at_another_speed():
    result = json.loads(type_("freq", "nf308", "--speed", "900 rpm", "--json")[0])
    assert result["shaft_hz"] == pytest.approx(15.0)
    assert result["frequencies"]["BPFO"]["hz"][1] == pytest.approx(159.0)


@pytest.mark.parametrize(
    ("words", "message"),
    [(["nf309"], "available: 6203, 6205, 6309, nf308, "), (["nf308", "--speed", "1800"], "the unit is missing")],
)
def test_freq_refuses_unknown_names_and_missing_units(words, message):
    assert message in type_("freq", *words, code=2)[1]
