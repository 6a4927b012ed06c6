"""Summary at the end of a run: counts, results, next command."""

import shlex
from pathlib import Path

import pytest

from bearingsim.report.headline import feature_results
from bearingsim.runner import run
from bearingsim.store import open_results
from tests.scenes.commands import STUDY, type_
from tests.scenes.trials import ENGINE, accuracy_study

ASSUMED = "5 assumptions not varied, strongest first: rigid ring, smooth surfaces, clearance, damping, bracket"


def test_a_run_ends_with_its_results_and_the_next_command(study_folder):
    stdout, _ = type_("run", "small.yaml", "--jobs", "1")
    lines = stdout.splitlines()
    assert lines[0].startswith("small: 8 of 8 jobs done in ")
    assert lines[0].endswith(" s, in results/small")
    table = open_results("results/small").table()
    velocity = 1e6 * table["velocity@BPFO"]
    line, healthy = velocity.iloc[:4], velocity.iloc[4:]
    assert lines[1].startswith(
        f"  velocity@BPFO (159 Hz): {line.min():.3g} to {line.max():.3g} µm/s, numerical error "
    )
    assert lines[2] == f"    healthy: {healthy.min():.3g} to {healthy.max():.3g} µm/s"
    for text, row in zip(lines[3:5], (line.argmax(), line.argmin()), strict=True):
        table_row = table.iloc[int(row)]
        assert text.partition(": ")[2] == f"load {table_row['load']:.0f} N, model {table_row['model']}"
    assert lines[-3] == ASSUMED
    assert lines[-1] == "next: bearingsim plot results/small"
    assert len(lines) <= 24
    assert all(len(text) <= 100 for text in lines)


def test_commands_quote_a_folder_with_blanks(study_folder):
    Path("small.yaml").write_text(STUDY.partition("sweep:")[0] + "duration: 30 ms\nsettle: 10 ms\n")
    lines = type_("run", "small.yaml", "--jobs", "1", "--out", "two words")[0].splitlines()
    commands = [shlex.split(line.partition("bearingsim ")[2]) for line in lines if "bearingsim " in line]
    assert [words[:2] for words in commands] == [["show", "two words"], ["plot", "two words"]]


def test_numerical_errors_are_no_results(study_folder, monkeypatch):
    type_("run", "small.yaml", "--jobs", "1")
    results = open_results("results/small")
    table = results.table()
    table.loc[4:, "velocity@BPFO"] = 1.6e-12
    monkeypatch.setattr(type(results), "table", lambda _: table)
    [result] = feature_results(results)
    assert result.remarks[0] == "healthy: zero within numerical errors"
    assert " to " in result.values


def test_reduced_grid_is_named_and_has_no_variations(study_folder):
    text = STUDY.replace("quick: {sweep: {model: [static]}}", "quick: {sweep: {model: [ring]}}")
    Path("small.yaml").write_text(f"{text}uncertainty: {{damping: [1 us, 5 us]}}\n")
    lines = type_("run", "small.yaml", "--jobs", "1", "--quick")[0].splitlines()
    assert ASSUMED in lines
    assert lines[-2] == "this was the reduced grid; run without --quick for the whole study"


def test_features_after_the_first_three_are_counted(study_folder):
    drawn = "[velocity@BPFO, velocity.rms, velocity.peak, outer_force.max, velocity.crest]"
    Path("small.yaml").write_text(STUDY.replace("y: velocity@BPFO", f"y: {drawn}"))
    lines = type_("run", "small.yaml", "--jobs", "1")[0].splitlines()
    assert sum(line.startswith("  ") and ": " in line and line[2] != " " for line in lines) == 5
    assert "  and 2 more: bearingsim show results/small" in lines


def test_a_run_without_a_sweep_ends_with_a_command_that_draws(study_folder):
    Path("small.yaml").write_text(STUDY.partition("sweep:")[0] + "duration: 30 ms\nsettle: 10 ms\n")
    command = type_("run", "small.yaml", "--jobs", "1")[0].splitlines()[-1]
    assert command == "next: bearingsim plot results/small --kind spectrum"
    assert "spectrum" in type_(*command.split()[2:])[0]
    Path("small.yaml").write_text(Path("small.yaml").read_text() + "record: []\n")
    command = type_("run", "small.yaml", "--jobs", "1")[0].splitlines()[-1]
    assert command == "next: bearingsim show results/small"
    type_(*command.split()[2:])


def test_verbose_prints_details(study_folder):
    lines = type_("run", "small.yaml", "--jobs", "1")[0].splitlines()[1:]
    verbose_lines = type_("-v", "run", "small.yaml", "--jobs", "1")[0].splitlines()
    assert set(lines) <= set(verbose_lines)
    assert any("responses are periodic" in line for line in verbose_lines)
    assert not any("responses are periodic" in line for line in lines)
    assumptions = type_("show", "results/small", "--assumptions")[0].splitlines()
    assert assumptions[0].startswith("rigid ring assumed")
    assert any(line.startswith("damping not varied; amplitudes at light load ") for line in assumptions)
    for name, values in {"clearance": "[0 um, 10 um]", "bracket": "[0.5, 2]"}.items():
        advice = f"; `uncertainty: {{{name}: {values}}}` varies it"
        assert any(f"{name} " in line and line.endswith(advice) for line in assumptions)
        study_text = Path("small.yaml").read_text() + f"uncertainty: {{{name}: {values}}}\n"
        Path("varied.yaml").write_text(study_text)
        type_("check", "varied.yaml")


BOTH = "uncertainty: {damping: [1 us, 5 us], clearance: [0 um, 5 um]}"


@pytest.mark.parametrize(
    ("varied", "left"),
    [
        (BOTH, "3 assumptions not varied, strongest first: rigid ring, smooth surfaces, bracket"),
        ("uncertainty: none", "2 assumptions not"),
    ],
)
def test_varied_parameters_are_not_assumptions(study_folder, varied, left):
    text = STUDY.replace("model: [static, ring]", "model: [static]") + varied + "\n"
    Path("small.yaml").write_text(text)
    stdout = type_("run", "small.yaml", "--jobs", "1")[0]
    assert left in stdout


def test_jobs_done_by_trials_are_not_counted_as_earlier(write, tmp_path, monkeypatch):
    """A first run does not count its own trials as jobs done before."""
    study = accuracy_study(write)
    summary = run(study, tmp_path / "out", jobs=1, progress=False, engine=ENGINE)
    assert summary.resumed == 0
    assert "before" not in summary.headline
    again = run(accuracy_study(write), tmp_path / "out", jobs=1, progress=False, engine=ENGINE)
    assert again.resumed == again.planned
    assert again.headline.endswith(f", {again.planned} of them already stored")


def test_a_study_with_harmonics_of_a_race_ends_with_its_results(study_folder):
    form = "surfaces: {outer: {harmonics: [{order: 12, amplitude: 20 nm, phase: 30 deg}]}}\n"
    Path("small.yaml").write_text(STUDY.replace("model: [static, ring]", "model: [ring]") + form)
    lines = type_("run", "small.yaml", "--jobs", "1")[0].splitlines()
    assert lines[0].startswith("small: 4 of 4 jobs done")
    assert not any("smooth surfaces" in line for line in lines)
    columns = open_results("results/small").table().columns
    assert "velocity@BPFO-healthy" in columns
    assert not any("surfaces" in name and name.endswith("-healthy") for name in columns)
