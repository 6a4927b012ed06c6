"""The chart of a small study, computed; and a solver of another package on our equations."""

import csv

import pytest

from bearingsim.bench import external, measure, plan, scene
from bearingsim.bench.plan import POINT, Run, Setting
from tests.scenes.commands import type_

STUDY = """\
# A small slot
study: tiny
bearing: nf308
speed: 1800 rpm
load: 150 N
defect: {shape: rectangular, length: 12 mm, width: 0.8 mm, depth: 0.05 mm}
duration: 40 ms
settle: 10 ms
"""


@pytest.fixture
def small_plan(monkeypatch):
    """A plan of few methods, and no model above `rollers` but the reference."""
    small = plan.Plan(
        {"verlet": (Setting(step=16.0), Setting(step=1.0))},
        {"verlet": (Setting(step=0.25),), "rk4": (Setting(step=0.25),)},
        {"scipy-dop853": (Setting(tolerance=1e-5),)},
    )
    monkeypatch.setattr(plan, "make_plan", lambda case, quick: small)


def test_chart_of_a_study(study_folder, write, small_plan):
    path = write(STUDY)
    stdout, _ = type_("bench", path, "--out", "charted")
    assert "A small slot" in stdout
    with (study_folder / "charted/chart.csv").open() as file:
        rows = list(csv.DictReader(file))
    models = list(dict.fromkeys(row["variant"] for row in rows))
    assert models == ["planar", "rollers", "ring", "static"]
    jobs = {row["variant"]: row for row in rows if row["role"] == "job"}
    assert float(jobs["planar"]["total.line"]) < 0.01
    assert float(jobs["rollers"]["total.force"]) < 0.01
    assert float(jobs["ring"]["total.force"]) > 0.3  # without rollers' mass nothing strikes the far edge
    assert [row["failure"] for row in rows if row["setting"] == "16 of the automatic step"] == ["refused"] * 3
    peer = next(row for row in rows if row["role"] == "peer")
    assert float(peer["numerical.line"]) < 0.01
    assert float(peer["cpu_per_s"]) > 0.0
    text = (study_folder / "charted/speed-accuracy.md").read_text()
    assert "**Within 1 %:** `rollers`" in text


def test_external_solver_agrees_with_own_method(write):
    study_scene = scene.load_scenes(write(STUDY), quick=False)[0]
    case = next(variant.case for variant in study_scene.variants if variant.name == "rollers")
    assert case is not None
    features, cpu, simulated = external.solve(case, external.SOLVERS["scipy-dop853"], 1e-7)
    run = Run("s", "rollers", "rollers", POINT, "dop853", Setting(tolerance=1e-7), study_scene.line, case)
    own_row = measure.compute_rows(run)[0]
    assert features[study_scene.line] == pytest.approx(own_row["line"], rel=1e-4)
    assert features["velocity.rms"] == pytest.approx(own_row["rms"], rel=1e-4)
    assert features["outer_force.max"] == pytest.approx(own_row["force"], rel=2e-3)
    assert cpu > 0.0
    assert 0.05 <= simulated < 0.1
