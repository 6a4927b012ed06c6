"""Measured points and signals in figures, in `show` and in the report of a computed study."""

import json
import re

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import bearingsim as bs
from bearingsim.cli import tables
from bearingsim.cli.app import app
from bearingsim.plots import overlay
from bearingsim.plots.plot import draw_figures
from bearingsim.study import Figure
from tests.study.test_measured_section import BPFO, STUDY

SECTION = """\
record: [ring.acceleration]
figures:
  - {y: [velocity@BPFO, velocity.rms], x: load, by: defect.width}
  - {kind: series, y: ring.acceleration}
measured:
  - points:
      - {load: 150 N, defect.width: 0.8 mm, velocity@BPFO: 12 um/s}
      - {load: 200 N, velocity@BPFO: 9 um/s}
      - {load: 500 N, defect.width: 0.4 mm, velocity@BPFO: 30 um/s}
      - {load: 150 N, defect.width: 0.6 mm, velocity@BPFO: 77 um/s}
    label: test rig
  - signals: [{file: run.npz, at: {load: 300 N, defect.width: 0.4 mm}, unit: m/s^2}]
    label: sensor
    scale: true
"""


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("measured")
    t = np.arange(51200) / 25600.0
    noise = 0.05 * np.random.default_rng(2).normal(size=len(t))
    np.savez(folder / "run.npz", a=np.sin(2 * np.pi * BPFO * t) + noise, fs=25600.0)
    (folder / "rig.yaml").write_text(STUDY + SECTION)
    return bs.run(bs.load_study(folder / "rig.yaml"), jobs=1, out=folder / "out")


def marks(ax):
    return [line for line in ax.lines if line.get_gid() == "measured"]


def test_marks_are_at_their_values_in_the_colours_of_their_curves(results):
    (_, canvas), *_ = draw_figures(results)
    ax, beside = canvas.axes
    places = [(line.get_xdata()[0], line.get_ydata()[0], line.get_markeredgecolor()) for line in marks(ax)]
    assert np.array([place[:2] for place in places]) == pytest.approx(np.array([(150, 12), (200, 9), (500, 30)]))
    colours = [line.get_color() for line in ax.lines if line.get_marker() in ("o", "s") and not line.get_gid()][:2]
    assert places[0][2] == colours[1]
    assert places[2][2] == colours[0]
    assert places[1][2] not in colours
    assert not marks(beside)
    assert {text.get_text() for text in canvas.legends[0].get_texts()} >= {"test rig"}


def test_a_figure_of_signals_shows_the_job_with_a_measured_one(results):
    (_, canvas) = draw_figures(results)[1]
    names = [line.get_label() for line in canvas.axes[0].lines]
    factor = results.measured[1].factor
    assert f"sensor, times {factor:.3g}, run.npz" in names
    measured = canvas.axes[0].lines[names.index(f"sensor, times {factor:.3g}, run.npz")]
    assert np.ptp(measured.get_ydata()) == pytest.approx(2 * factor, rel=0.3)
    assert "load 300 N" in canvas.axes[0].get_title(loc="left")


def test_the_factor_makes_the_medians_of_the_features_equal(results):
    entry = results.measured[1]
    ratios = [
        item.simulated / entry.scaled(item.feature, item.measured)
        for item in entry.comparisons
        if item.feature in ("acceleration.rms", "acceleration.peak", "acceleration@BPFO")
    ]
    assert len(ratios) == 3
    assert np.median(ratios) == pytest.approx(1.0)


def test_a_lost_file_is_a_warning(results, tmp_path):
    file = results.path.parent / "run.npz"
    file.rename(tmp_path / "run.npz")
    try:
        with pytest.warns(UserWarning, match="measured signal skipped.*No such file"):
            draw_figures(results, "spectrum")
    finally:
        (tmp_path / "run.npz").rename(file)


def test_a_file_that_changed_since_the_run_is_a_warning(results):
    file = results.path.parent / "run.npz"
    content = file.read_bytes()
    try:
        np.savez(file, a=10.0 * np.load(file)["a"], fs=25600.0)
        with pytest.warns(UserWarning, match="measured signal skipped.*has changed since `bearingsim run`"):
            (_, canvas), *_ = draw_figures(results, "spectrum")
        assert not any("sensor" in str(line.get_label()) for ax in canvas.axes for line in ax.lines)
    finally:
        file.write_bytes(content)


def test_a_word_in_other_case_is_at_its_category():
    rows = pd.DataFrame({"job": ["a", "b"], "bearing": ["nf308", "6205"]})
    drawing = overlay.FigureData(Figure(x="bearing", y=("velocity@BPFO",)), rows, {"bearing": ""})
    assert overlay.position_on_x(drawing, rows, {"parameters": {"bearing": "NF308"}}) == 0.0
    assert overlay.position_on_x(drawing, rows, {"parameters": {"bearing": "6206"}}) is None


def test_show_prints_measured_beside_simulated(results):
    text = CliRunner().invoke(app, ["show", str(results.path), "--measured"]).output
    assert "measured: test rig" in text
    assert "between: interpolated linearly" in text
    assert "no finished case is at rig.yaml:17:9, or on both sides in one parameter" in text
    assert "without a simulated value: acceleration@2BSF" in text
    assert "measured `test rig`: rig.yaml:17:9 outside the sweep of load (150 N to 300 N)" in text
    assert "simulated" in text.partition("measured: test rig")[2].splitlines()[1]
    assert "- measured   / measured" in text
    (row,) = [line for line in text.splitlines() if line.startswith("acceleration.rms ")]
    assert row.split()[1] == "run.npz"
    rows = json.loads(CliRunner().invoke(app, ["show", str(results.path), "--measured", "--json"]).output)
    row = next(row for row in rows if row["job"] and row["parameters"]["load"] == 150.0)
    simulated = results.table().set_index("job").loc[row["job"], "velocity@BPFO"]
    assert row["simulated"] == simulated
    assert row["measured"] == pytest.approx(12e-6)


def test_show_names_where_the_rest_of_a_long_comparison_is(results, monkeypatch):
    monkeypatch.setattr(tables, "MAX_MEASURED_ROWS", 2)
    text = CliRunner().invoke(app, ["show", str(results.path), "--measured"]).output
    assert "and 2 more rows: `bearingsim show --measured --json` prints all" in text
    assert sum(line.startswith("velocity@BPFO ") for line in text.splitlines()) == 2


def test_show_of_a_study_without_measurements_says_so(results):
    folder = results.path.parent
    (folder / "plain.yaml").write_text(STUDY.replace("study: rig", "study: plain").replace("0.2 s", "20 ms"))
    bs.run(bs.load_study(folder / "plain.yaml", quick=True), jobs=1, out=folder / "plain")
    output = CliRunner().invoke(app, ["show", str(folder / "plain"), "--measured"])
    assert output.exit_code != 0
    assert "has no `measured` section" in str(output.output) + str(output.exception)


def test_report_has_the_table_and_the_marks(results):
    CliRunner().invoke(app, ["report", str(results.path)])
    page = (results.path / "report.html").read_text()
    assert "Measured and simulated values" in page
    assert "test rig" in page
    assert '"measured":true' in page
    [text] = re.findall(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)
    data = json.loads(text)
    chart = next(chart for chart in data["charts"] if "owner" in chart["points"])
    measured = [
        (x, None if owner is None else chart["curves"][owner]["name"])
        for x, owner, job in zip(chart["x"][0], chart["points"]["owner"], chart["points"]["job"], strict=True)
        if not job
    ]
    assert measured == [(150.0, "width 0.8 mm"), (200.0, None), (500.0, "width 0.4 mm")]
    assert "emptyDiamond" in page
    assert '<path class="ink open" stroke="ink" d="M14 1l5 5-5 5-5-5z"' in page


def test_measurements_change_without_computing_anew(results):
    folder, before = results.path.parent, results.table()["unit"].tolist()
    text = (folder / "rig.yaml").read_text().replace("12 um/s", "13 um/s")
    (folder / "rig2.yaml").write_text(text)
    again = bs.run(bs.load_study(folder / "rig2.yaml"), jobs=1, out=folder / "out")
    assert again.table()["unit"].tolist() == before
    assert again.measured[0].points[0]["features"]["velocity@BPFO"] == pytest.approx(13e-6)


def test_sources_without_a_point_or_a_factor_say_so(results):
    folder = results.path.parent
    rows = [
        "{load: 900 N, velocity@BPFO: 1 um/s}",
        "{speed: 900 rpm, velocity@BPFO: 1 um/s}",
        "{load: 150 N, velocity.kurtosis: 3, outer_force.max: 0.2 kN}",
    ]
    entries = [f"{{points: [{row}], label: {name}, scale: true}}" for row, name in zip(rows, "abc", strict=True)]
    text = STUDY + SECTION.split("measured:")[0] + f"measured: [{', '.join(entries)}]\n"
    (folder / "rig3.yaml").write_text(text)
    bs.run(bs.load_study(folder / "rig3.yaml"), jobs=1, out=folder / "out")
    output = CliRunner().invoke(app, ["show", str(folder / "out"), "--measured"]).output
    assert "no point is at the fixed values of the study: `bearingsim check` names them" in output
    assert output.count("`scale: true` without effect: no ratio to a simulated motion") == 3
    (_, canvas), *_ = draw_figures(bs.open_results(folder / "out"))
    assert "b" not in {label.get_text() for label in canvas.legends[0].get_texts()}
