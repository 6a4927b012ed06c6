"""Rows of `bearingsim bench`: stored, truncated and repeated runs, and the files of the command."""

from dataclasses import replace
from math import nan
from typing import NamedTuple

from bearingsim.bench import errors, measure, plan, report, scene, table, verdict
from bearingsim.bench.plan import AUTOMATIC, JOB
from bearingsim.cli import bench as command
from bearingsim.simulation import SimulationError
from tests.scenes.bench_rows import reference_rows

SCENES = scene.built_in_scenes(["healthy"], quick=True)


def test_stored_rows_are_not_recomputed(tmp_path, computed_runs, monkeypatch):
    first = table.compute(SCENES, tmp_path, quick=True)
    count = len(computed_runs)
    assert count == len(list(plan.plan_runs(SCENES[0], quick=True)))
    repeat = table.compute(SCENES, tmp_path, quick=True)
    assert len(computed_runs) == count
    assert [row["key"] for row in repeat] == [row["key"] for row in first]
    monkeypatch.setattr(plan, "code_version", lambda: "another")
    table.compute(SCENES, tmp_path, quick=True)
    assert len(computed_runs) == 2 * count


def test_truncated_row_is_recomputed(tmp_path, computed_runs):
    table.compute(SCENES, tmp_path, quick=True)
    count, path = len(computed_runs), tmp_path / table.RUNS_FILE
    path.write_text(path.read_text()[:-20])
    table.compute(SCENES, tmp_path, quick=True)
    assert len(computed_runs) == count + 1
    assert len(table.read(path)) == count


def test_job_without_second_row_is_recomputed(tmp_path, computed_runs):
    table.compute(SCENES, tmp_path, quick=True)
    count, path = len(computed_runs), tmp_path / table.RUNS_FILE
    lines = path.read_text().splitlines(keepends=True)
    first = next(n for n, line in enumerate(lines) if f",{AUTOMATIC}," in line)
    path.write_text("".join(lines[:first] + lines[first + 1 :]))
    rows = table.compute(SCENES, tmp_path, quick=True)
    assert len(computed_runs) == count + 1
    assert len(rows) == len(lines) - 1
    assert len(table.compute(SCENES, tmp_path, quick=True)) == len(rows)
    assert len(computed_runs) == count + 1


def test_row_truncated_within_its_reason_does_not_hide_later_rows(tmp_path, computed_runs):
    expected = table.compute(SCENES, tmp_path, quick=True)
    path = tmp_path / table.RUNS_FILE
    lines = path.read_text().splitlines(keepends=True)
    cut = lines[-3].rstrip() + '"over the limit, and'  # the reason is the last column
    path.write_text("".join(lines[:-3]) + cut)
    assert len(table.compute(SCENES, tmp_path, quick=True)) == len(expected)


class FakeRecord(NamedTuple):
    """Record of a job by Verlet's method."""

    info: dict
    features: dict


def test_job_is_kept_if_its_full_integration_stops(monkeypatch):
    info = {"method": "verlet", "step_s": 1e-6, "tolerance": nan, "cpu_s": 9.0, "period_passes": 1}
    features = {"velocity@BPFO": 1.0, "velocity.rms": 2.0, "outer_force.max": 3.0, "chaotic": 0.0}

    def simulate(case):
        if case.periodic:
            return FakeRecord(info, features)
        raise SimulationError("the roller leaves the bearing", "use another step", time=0.1)

    monkeypatch.setattr(measure, "simulate", simulate)
    monkeypatch.setattr(measure, "compile_solvers", lambda cases: None)
    run = next(run for run in plan.plan_runs(SCENES[0], quick=True) if (run.variant, run.role) == ("ring", JOB))
    job, full = measure.compute_rows(run)
    assert (job["role"], job["failure"], job["force"]) == (JOB, "", 3.0)
    assert (full["role"], full["method"], full["failure"]) == (AUTOMATIC, "verlet", "stopped")
    assert job["key"] == full["key"] == run.key
    rows = errors.with_errors([job | {"variant": "planar"}, full | {"variant": "planar"}, *reference_rows()])
    assert report._choice_rows(report.Section("s", "a scene", rows, 0.3))[0][5] == "unknown"
    assert verdict.compare_with_front(rows, errors.NUMERICAL) == []


def test_another_step_or_model_is_another_run():
    first, *others = plan.plan_runs(SCENES[0], quick=True)
    assert len({run.key for run in (first, *others)}) == len(others) + 1
    assert replace(first, case=first.case.model_copy(update={"load": 1.0})).key != first.key


def test_the_command_writes_table_figures_text_and_provenance(tmp_path, computed_runs, capsys):
    files = command.draw_chart(None, ["healthy"], True, tmp_path / "out", 1)
    assert [file.name for file in files] == [
        "chart.csv",
        "speed-accuracy-healthy.png",
        "speed-accuracy.md",
        "provenance.json",
    ]
    assert all(file.exists() for file in files)
    assert "all three within 5 %" in capsys.readouterr().out
