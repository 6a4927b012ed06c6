"""The page of results: its content, and what it may not do."""

import hashlib
import json
import re
from importlib.resources import files

import numpy as np
import pytest

from bearingsim.report.charts import round_values
from bearingsim.report.designs import make_design_chart
from bearingsim.report.figures import collect
from bearingsim.report.headline import feature_results
from bearingsim.report.page import make_page
from bearingsim.report.render import embed_json, render_html, security_policy
from bearingsim.store import open_results, read_plan
from bearingsim.store.sealed import write_json
from bearingsim.study import Figure
from tests.plots.test_plot_designs import SOBOL
from tests.scenes.figure_results import FIGURES, STUDY, record, results

__all__ = ["results"]

ECHARTS = "9eb822a9ab762e8cf1c8723b821a5efbfa1518431d850c2133bc49b094168d79"
"""SHA-256 of echarts.min.js as built by `make report-assets`."""


def data_of(text):
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', text).group(1))


def test_bundle_of_echarts_has_the_hash_of_the_build():
    bundle = files("bearingsim.report").joinpath("assets/echarts.min.js").read_bytes()
    assert hashlib.sha256(bundle).hexdigest() == ECHARTS
    assert b"</script" not in bundle


def test_own_script_is_short():
    lines = files("bearingsim.report").joinpath("assets/report.js").read_text().splitlines()
    assert len(lines) <= 250
    assert max(map(len, lines)) <= 100


def test_points_are_those_of_the_table(results):
    opened = results(STUDY + FIGURES)
    chart = data_of(render_html(make_page(opened)))["charts"][0]
    table = opened.table().set_index("job")
    ids = {job[:8]: job for job in table.index}
    for number, job in enumerate(chart["points"]["job"]):
        row = table.loc[ids[job]]
        for panel, feature in zip(chart["panels"], ("velocity@BPFO", "velocity@BPFO-healthy"), strict=True):
            assert panel["columns"]["y"][number] == pytest.approx(1e6 * row[feature], rel=1e-5)  # um/s
        setting = chart["combinations"][chart["points"]["combination"][number]]
        texts = [control["options"][i] for control, i in zip(chart["controls"], setting, strict=True)]
        assert texts == [row["model"]]
        assert chart["curves"][chart["points"]["curve"][number]]["name"] == f"load {row['load']:.0f} N"


def test_nan_and_infinity_become_null():
    assert round_values([1.23456789e-7, np.nan, np.inf]) == [1.23457e-7, None, None]
    with pytest.raises(ValueError, match="JSON"):
        embed_json({"a": np.nan})


def test_texts_cannot_end_the_script():
    assert embed_json({"a": "</script><!-- & \u2028\u202e"}) == (
        '{"a":"\\u003c/script\\u003e\\u003c!-- \\u0026 \\\\u2028\\\\u202e"}'
    )


def test_control_of_a_panel_lists_computed_settings_only(results):
    text = STUDY.replace("  load: [150 N, 300 N]\n  model: [static, ring]\n",
                         "  zip: {load: [150 N, 300 N], model: [static, ring]}\n")  # fmt: skip
    figures = "figures: [{y: velocity@BPFO, x: defect.length, panels: model}]\n"
    opened = results(text + figures)
    chart = collect(opened, ()).charts[0]
    [control] = chart.controls
    assert control.name == "Model and load"
    assert control.options == ["static, 150 N", "ring, 300 N"]
    assert chart.combinations == [[0], [1]]


def test_uncomputed_settings_are_not_offered(results):
    opened = results(STUDY + FIGURES, lost=dict.fromkeys((1, 3, 5, 7, 9, 11), "missing"))  # of the model `ring`
    chart = collect(opened, ()).charts[0]
    assert [control.options for control in chart.controls] == [["static"]]
    assert chart.combinations == [[0]]
    assert set(chart.points["mark"]) == {""}


def test_settings_with_a_failed_job_are_offered(results):
    lost = dict.fromkeys((1, 3, 5, 7, 9), "missing") | {11: "failed"}
    [control] = collect(results(STUDY + FIGURES, lost=lost), ()).charts[0].controls
    assert control.options == ["static", "ring"]


@pytest.mark.parametrize(
    ("ramp", "name"),
    [
        ("", "velocity@BPFO (159 Hz)"),
        ("ramp: {to: 3000 rpm, time: 1 s}\ncage: {guide: centred}\n", "velocity@BPFO"),
    ],
)
def test_result_has_the_frequency_of_its_line_unless_that_changes(results, ramp, name):
    opened = results(
        STUDY.replace("[static, ring]", "[planar]") + ramp + "figures: [{y: velocity@BPFO, x: load}]\n"
    )
    assert [result.name for result in make_page(opened).results] == [name]


@pytest.mark.parametrize(
    ("feature", "errors", "statements"),
    [
        ("velocity@BPFO", ["numerical error 0.2 %"], []),
        ("outer_force.max", [], ["largest step errors: velocity line 0.2 %, velocity RMS 0.1 %"]),
    ],
)
def test_step_errors_are_stated_once(results, monkeypatch, feature, errors, statements):
    """The largest force has no value here, so there is no result whose error could be stated."""

    def made(case):
        result = record(case)
        result.features |= {"step_error.line": 0.002, "step_error.rms": 0.001, "chaotic": 0.0}
        return result

    monkeypatch.setattr("tests.scenes.figure_results.record", made)
    shown = make_page(results(f"{STUDY}figures: [{{y: {feature}, x: load}}]\n"))
    assert [result.error for result in shown.results] == errors
    assert shown.accuracy == statements


def test_band_is_named_if_all_records_have_it(results):
    figures = "figures: [{y: velocity.rms, x: load}]\n"
    [rms] = make_page(results(STUDY + figures)).results
    assert rms.name == "velocity.rms (0-4.1 kHz)"


def test_band_is_not_named_if_records_differ(results):
    text = STUDY.replace("model: [static, ring]", "sampling: [10240 Hz, 20480 Hz]")
    [rms] = make_page(results(text + "figures: [{y: velocity.rms, x: load}]\n")).results
    assert rms.name == "velocity.rms"


def test_error_of_chaotic_jobs_without_a_standard_error_is_unknown(results):
    opened = results(STUDY.replace("[static, ring]", "[ring]") + "figures: [{y: velocity@BPFO, x: load}]\n")
    opened._table[["step_error.line", "chaotic", "velocity@BPFO-scatter"]] = 0.004, 1.0, np.nan
    assert [result.error for result in feature_results(opened)] == ["statistical scatter unknown (chaotic)"]


def test_error_bound_of_a_case_is_the_largest_of_its_features_in_per_cent(results):
    """2.5 % of the line, 4 % of the RMS, each relative to the value of the case, which is on no curve."""
    opened = results(STUDY + FIGURES)
    errors = {"velocity@BPFO": 0.025, "velocity.rms": 0.04}
    choices = {job: {"model": "ring", "why": "", "error": errors} for job in opened.jobs}
    opened.plan["accuracy"] = {
        "of": list(errors), "within": 0.05, "jobs": choices, "curves": [], "audits": [], "notes": [],
    }  # fmt: skip
    columns = dict(make_page(opened).table.columns)
    assert set(columns["error bound (%)"]) == {"4"}


def test_study_is_that_of_the_results(results):
    """An edited study.yaml in the results folder describes the next run."""
    finished = results()
    (finished.path / "study.yaml").write_text("study: another\n")
    assert make_page(finished, []).text == STUDY + FIGURES
    plan = {name: entry for name, entry in read_plan(finished.path).items() if name != "text"}
    write_json(finished.path / "plan.json", plan)  # as an earlier version wrote it
    assert make_page(open_results(finished.path), []).text == "study: another\n"


def test_phases_are_points(results):
    phase = "figures: [{y: velocity@BPFO.phase, x: defect.length, kind: phase}]\n"
    [chart, *_] = collect(results(STUDY + phase), ()).charts
    assert (chart.kind, chart.panels[0].axis.phase) == ("points", True)


def test_points_of_a_design_are_coloured_from_the_smallest_to_the_largest_value(results):
    opened = results(SOBOL)
    chart = make_design_chart(opened, Figure(y=("velocity@BPFO",), x="", kind="design"))
    load = np.array(chart.x[0], dtype=float)
    assert chart.shades[0] == pytest.approx((load - load.min()) / np.ptp(load), abs=1e-5)


def test_signal_is_of_the_case_with_the_largest_line_and_sidebands_have_no_name(results):
    text = STUDY.replace("shape: circular", "race: inner, shape: circular")
    opened = results(text + "figures: [{y: velocity@BPFO, x: load}]\n")
    [*_, spectrum] = collect(opened, ()).charts
    assert spectrum.title.startswith("Envelope spectrum: length 9 mm, load 300 N")
    names = {round(hertz): name for hertz, name in spectrum.marks}
    assert (names[201], names[231], names[261]) == ("", "BPFI 231 Hz", "")


def test_policy_allows_only_the_content_of_the_page():
    """Digests of `a` and `b` by `printf a | openssl dgst -sha256 -binary | base64`."""
    assert security_policy(["a"], ["b"]).split("; ") == [
        "default-src 'none'",
        "script-src 'sha256-ypeBEsobvcr6wjGzmiPcTaeG7/gUfE5yuYB3ha/uSLs='",
        "style-src 'sha256-PiPoFgA5WUoziU9lZOGxNIu9egCI1CxKy3PurtWcAJ0='",
        "img-src data:",
        "base-uri 'none'",
        "form-action 'none'",
    ]
