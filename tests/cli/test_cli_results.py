"""Commands that show and export the results of a study: text, exit code, files."""

import json
import re
import shutil
import subprocess
import sys
from io import BytesIO, StringIO
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pandas as pd
import pytest
from scipy.io import loadmat

from bearingsim.cli import exporting, tables
from bearingsim.errors import UserError
from bearingsim.store import open_results
from tests.scenes.commands import type_


def ids(results):
    return pd.read_csv(results / "results.csv")["job"]


def test_plot_writes_the_figures_of_the_study(done, tmp_path):
    stdout, _ = type_("plot", done, "--out", tmp_path, "--format", "svg")
    assert stdout.split() == [str(tmp_path / "fig1-velocity-bpfo-vs-load.svg")]
    assert (tmp_path / "fig1-velocity-bpfo-vs-load.svg").stat().st_size > 10_000


def test_plot_takes_the_newest_results(done, monkeypatch):
    monkeypatch.chdir(done.parents[1])
    stdout, _ = type_("plot", "--kind", "spectrum", "--job", ids(done)[0][:9])
    assert stdout.split() == [f"results/small/figures/spectrum-{ids(done)[0][:8]}.png"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["--kind", "pie"],
            "sweep, phase, design, waterfall, series, spectrum, envelope, spectrogram, roller, load, pit or ring",
        ),
        (["--format", "gif"], "png, svg or pdf"),
        (["--x", "laod"], "did you mean `load`?"),
        (["--kind", "series", "--job", "xyz"], "no job begins with `xyz`"),
        (["--kind", "series", "--span", "20"], "expected a time such as `50 ms`"),
        (["--kind", "series", "--span", "0 ms"], "expected a time above zero, got `0 ms`"),
        (["--kind", "pit", "--span", "20 ms"], "a pit has no option `span`"),
        (["--kind", "spectrum", "--range", "2 kHz"], "Invalid value for --range: expected two limits"),
    ],
)
def test_plot_refuses_wrong_options(done, words, message):
    _, stderr = type_("plot", done, *words, code=2)
    assert message in " ".join(stderr.replace("│", " ").split())


def test_plot_reports_omitted_figures(done, tmp_path):
    words = ["--where", "model=rollers", "--where", "load=150 N"]
    assert "no case has model rollers, load 150 N" in type_("plot", done, *words, "--out", tmp_path, code=2)[1]
    stdout, stderr = type_("plot", done, "--where", "model=ring", "--panels", "model", "--out", tmp_path)
    assert len(stdout.splitlines()) == 1
    assert stderr == ""


def test_closed_stdout_pipe_is_no_error(done):
    command = f"{sys.executable} -m bearingsim show {done} | head -c 1"
    result = subprocess.run(["bash", "-c", command], capture_output=True, text=True)
    assert result.stderr == ""


@pytest.mark.parametrize("command", ["plot", "show", "export"])
def test_without_results_there_is_a_message(study_folder, command):
    assert "no results in ./results" in type_(command, code=2)[1]
    assert "contains no results" in type_(command, study_folder, code=2)[1]


def test_show_prints_a_row_per_job(done):
    stdout, _ = type_("show", done)
    lines = stdout.splitlines()
    assert "velocity@BPFO (µm/s)" in lines[0]
    assert sum(line.startswith(tuple(job[:8] for job in ids(done))) for line in lines) == 8
    remarks = lines[lines.index("8 jobs: 8 done") + 1 :]  # a job may need a pass more than the record has
    assert re.match(r"[78] of 8 responses are periodic: 1 to ", remarks[0])
    assert lines[-1].startswith("damping: c/k 2.5 us (plausible: 0.3 to 25), ratio 0.0581 to 0.0596;")


def test_show_marks_chaotic_jobs_and_counts_them(done, capsys):
    results = open_results(done)
    job = results.table()["job"][0]
    results._table.loc[results._table["job"] == job, "chaotic"] = 1.0
    results.frame.loc[job, ["features/chaotic", "features/step_error.rms"]] = 1.0, 0.29
    tables.show_jobs(results, ["load"], False, False)
    tables.show_jobs(results, ["status"], False, False)
    stdout = capsys.readouterr().out
    assert re.findall(".*chaotic$", stdout, re.MULTILINE) == [f"{job[:8]}   done, chaotic"]
    assert "1 of 8 jobs are chaotic, so only their RMS is checked: " in stdout
    assert "effect of the step, as far as resolved, up to 29 %" in stdout


def test_variations_that_are_cases_too_are_not_counted_twice():
    """Case `b` is also a variation; of the others `w` has no result. The rest is audits."""
    jobs: Any = SimpleNamespace(
        info=lambda: pd.DataFrame(index=["a", "b", "v", "x"]),
        variations=[{"job": "b"}, {"job": "v"}, {"job": "w"}],
        jobs=["a", "b"],
        planned=["a", "b", "v", "w", "x"],
    )
    assert tables._text_of_further_jobs(jobs) == ", and 2 variations (1 without a result), and 1 audit"


def test_show_columns(done):
    stdout, _ = type_("show", done, "--columns", "load", "--columns", "velocity.rms")
    assert stdout.splitlines()[0].split() == ["job", "load", "velocity.rms", "(µm/s)"]
    assert "did you mean `velocity.rms`?" in type_("show", done, "--columns", "velocity.rmse", code=2)[1]
    assert "`gain` (`--json` prints all columns)" in type_("show", done, "--columns", "gain", code=2)[1]
    stderr = type_("show", done, "--columns", "step_er", code=2)[1]
    assert "`step_er` (columns with this word: `step_error.line`, `step_error.rms`, " in stderr
    assert "`error` (needs `accuracy` in the study)" in type_("show", done, "--columns", "error", code=2)[1]


def test_each_column_is_shown_once(done):
    words = ["show", done, "--columns", "load", "--columns", "job", "--columns", "load"]
    assert type_(*words)[0].splitlines()[0].split() == ["job", "load"]
    stdout, stderr = type_(*words, "--json")
    assert [list(row) for row in json.loads(stdout)] == [["job", "load"]] * 8
    assert stderr == ""


def test_show_json(done):
    rows = json.loads(type_("show", done, "--json")[0])
    assert {row["load"] for row in rows} == {150.0, 300.0}
    assert all(row["status"] == "done" for row in rows)


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_features_are_exported(done, tmp_path, suffix):
    file = tmp_path / f"features.{suffix}"
    assert type_("export", done, "--features", file)[0].strip() == str(file)
    read = pd.read_csv if suffix == "csv" else pd.read_parquet
    table, expected = read(file), pd.read_csv(done / "results.csv")
    head = "velocity@BPFO (m/s)" if suffix == "csv" else "velocity@BPFO"
    assert list(table["job"]) == list(expected["job"])
    assert table[head].to_numpy() == pytest.approx(expected["velocity@BPFO"].to_numpy())


def test_numbers_and_words_of_a_path_are_text_in_parquet(done):
    table = open_results(done).table().assign(clearance=["C3", 1e-05] * 4)
    read = pd.read_parquet(BytesIO(exporting._to_parquet(table)))
    assert list(read["clearance"]) == ["C3", "1e-05"] * 4
    pd.testing.assert_frame_equal(read.drop(columns="clearance"), table.drop(columns="clearance"))


def test_swept_speeds_are_exported_without_rounding_errors():
    rpm = np.arange(100.0, 6000.0, 100.0)
    table = exporting._with_units(pd.DataFrame({"speed": rpm * np.pi / 30.0}), {"speed": "rpm"})
    assert list(table["speed (rpm)"]) == list(rpm)


def test_exported_speed_follows_a_ramp(done):
    """From 1800 rpm to 3600 rpm within 20 ms, of which 10 ms are before the record."""
    results = open_results(done)
    job = results.jobs[0]
    results._parameters[["ramp.to", "ramp.time"]] = 120.0 * np.pi, 0.02
    results.frame["info/settle_s"] = 0.01
    table = pd.read_csv(BytesIO(exporting._to_csv({job: results.series(job)}, results)))
    expected = np.minimum(2700.0 + 900.0 * table["time [s]"] / 0.01, 3600.0)
    assert table["speed [rpm]"].to_numpy() == pytest.approx(expected.to_numpy())


def test_export_names_its_file(done, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert type_("export", done, "--format", "parquet")[0] == "small-features.parquet\n"
    assert Path("small-features.parquet").is_file()


def test_series_are_exported_to_csv(done, tmp_path):
    first, second = ids(done)[:2]
    type_("export", done, "--series", first, "--series", second, "--out", tmp_path / "both.csv")
    table = pd.read_csv(tmp_path / "both.csv")
    names = ("ring.velocity.x [m/s]", "ring.velocity.y [m/s]", "speed [rpm]")
    heads = [f"{job}/{name}" for job in (first, second) for name in names]
    assert list(table) == ["time [s]", *heads]
    assert set(table[heads[2]]) == {1800.0}
    assert len(table) == 307  # 30 ms at 10240 Hz
    assert np.diff(table["time [s]"]) == pytest.approx(1.0 / 10240.0)
    assert table[heads[0]].abs().max() > 1e-6


def test_series_of_all_jobs_are_exported(done, tmp_path):
    type_("export", done, "--series", "all", "--out", tmp_path / "all.csv")
    written = pd.read_csv(tmp_path / "all.csv")
    assert {name.split("/")[0] for name in map(str, written) if "/" in name} == set(ids(done))
    results = open_results(done)
    for job in ids(done):
        expected = results.series(job)["ring.velocity.x"]
        np.testing.assert_allclose(written[f"{job}/ring.velocity.x [m/s]"], expected, rtol=1e-6)


def test_jobs_that_are_not_done_have_no_series(capsys):
    table = pd.DataFrame({"job": ["a", "b", "c"], "status": ["done", "failed", "missing"]})
    results: Any = SimpleNamespace(jobs=("a", "b", "c"), table=lambda: table)
    assert exporting.finished_jobs(results) == ["a"]
    assert "2 of 3 jobs omitted, because not done" in capsys.readouterr().err
    results.jobs = ("b", "c")
    with pytest.raises(UserError, match="no job is done: `bearingsim show --failed` lists failures"):
        exporting.finished_jobs(results)
    results.jobs = ("c",)  # of a run that was killed before its first job
    table["status"] = "missing"
    with pytest.raises(UserError, match="no job is done: repeat `bearingsim run`"):
        exporting.finished_jobs(results)


def test_series_are_exported_to_matlab(done, tmp_path):
    job = ids(done)[1]
    type_("export", done, "--series", job[:10], "--out", tmp_path / "one.mat")
    struct = loadmat(tmp_path / "one.mat", simplify_cells=True)[f"job_{job}"]
    assert set(struct) == {"time", "ring_velocity_x", "ring_velocity_y", "units", "parameters"}
    assert struct["units"] == {"time": "s", "ring_velocity_x": "m/s", "ring_velocity_y": "m/s"}
    assert struct["parameters"]["defects_1_width"] == pytest.approx(0.0008)
    assert struct["parameters"]["load"] == 150.0
    assert struct["parameters"]["model"] == "ring"
    assert len(struct["ring_velocity_x"]) == len(struct["time"]) == 307


def test_numbers_of_a_path_with_words_are_numbers_in_matlab(done):
    """A settling time of 50 ms beside `auto` is stored as text, of whose letters MATLAB would compute."""
    results = open_results(done)
    first, second = results.jobs[:2]
    names = dict.fromkeys(results.jobs, "auto") | {second: "0.05"}
    results._parameters["settle"] = pd.Series(names)
    results._parameters["bearing.name"] = "6205"
    content = exporting._to_mat({job: results.series(job) for job in (first, second)}, results)
    structs = loadmat(cast(Any, BytesIO(content)), simplify_cells=True)
    assert structs[f"job_{first}"]["parameters"]["settle"] == "auto"
    assert structs[f"job_{second}"]["parameters"]["settle"] == 0.05
    assert structs[f"job_{second}"]["parameters"]["bearing_name"] == "6205"


def test_two_values_of_a_path_are_refused(done):
    words = ("--where", "load=150 N", "--where", "load=300 N")
    assert "a path is given twice" in type_("plot", done, *words, code=2)[1]


def test_tables_go_to_stdout(done, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    stdout, stderr = type_("export", done, "--features", "-")
    heads, rows = stdout.split("\n", 1)
    assert "load (N)" in heads
    assert (rows, stderr) == ((done / "results.csv").read_text().split("\n", 1)[1], "")
    job = ids(done)[0]
    stdout, stderr = type_("export", done, "--series", job, "--out", "-", "--features", "own.csv")
    assert pd.read_csv(StringIO(stdout)).columns[0] == "time [s]"
    assert stderr == "own.csv\n"
    assert [path.name for path in tmp_path.iterdir()] == ["own.csv"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--features", "-", "--format", "parquet"], "only csv can go to stdout, not parquet"),
        (["--features", "-", "--series", "JOB", "--out", "-"], "only one can go to stdout"),
        (["--out", "x.csv"], "`--out` is for time series; name a job with `--series`"),
    ],
)
def test_unsuitable_exports_to_stdout_are_refused(done, words, message):
    assert (
        message in type_("export", done, *(ids(done)[0] if word == "JOB" else word for word in words), code=2)[1]
    )


@pytest.mark.parametrize("series", ["one.csv", "./one.csv"])
def test_table_and_series_in_one_file_are_refused(done, tmp_path, monkeypatch, series):
    monkeypatch.chdir(tmp_path)
    words = ["--features", "one.csv", "--series", ids(done)[0], "--out", series, "--force"]
    assert "is named for the table and for the time series" in type_("export", done, *words, code=2)[1]
    words = ["--features", "small-series.csv", *words[2:4], "--force"]  # the default name of the series
    assert "small-series.csv is named for the table" in type_("export", done, *words, code=2)[1]
    words = ["--features", "table.csv", "--series", ids(done)[0], "--out", "one.wav"]  # nothing is written either
    assert "ends in .csv or .mat" in type_("export", done, *words, code=2)[1]
    assert not list(tmp_path.iterdir())


def test_missing_table_is_written_when_results_are_opened(done, tmp_path):
    folder = shutil.copytree(done, tmp_path / "ours")
    expected = (folder / "results.csv").read_text()
    (folder / "results.csv").unlink()
    type_("show", folder)
    assert (folder / "results.csv").read_text() == expected


def test_export_refuses_other_formats(done, tmp_path):
    assert "ends in .csv or .parquet" in type_("export", done, "--features", tmp_path / "a.xlsx", code=2)[1]
    words = ["--series", ids(done)[0], "--out", tmp_path / "a.wav"]
    assert "ends in .csv or .mat" in type_("export", done, *words, code=2)[1]
