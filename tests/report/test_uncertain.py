"""Uncertain parameters on the page: ranges of the features of the figures, and their position on the page."""

import re

import numpy as np
import pandas as pd
import pytest

from bearingsim.plots.labels import format_quantity
from bearingsim.report.headline import feature_results
from bearingsim.report.page import make_page
from bearingsim.report.render import render_html
from bearingsim.report.statements import assumption_texts
from bearingsim.text.numbers import significant
from tests.scenes.figure_results import STUDY, results

__all__ = ["results"]

UNCERTAIN = STUDY.replace("model: [static, ring]", "model: [ring]") + (
    "uncertainty: {damping: [1 us, 5 us], clearance: [0 um, 5 um]}\n"
    "figures: [{y: [acceleration.rms, velocity@BPFO], x: defect.length}]\n"
)


@pytest.fixture
def uncertain(results):
    """Results of a study with variations; column ``features/acceleration.rms`` is the number of the job (m/s²)."""
    opened = results(UNCERTAIN)
    opened.frame["features/acceleration.rms"] = np.arange(1.0, len(opened.frame) + 1.0)
    opened._table["acceleration.rms"] = (
        opened.frame["features/acceleration.rms"].reindex(opened._table["job"]).values
    )
    return opened


def test_each_feature_has_its_range_over_all_cases(uncertain):
    [rms, line] = feature_results(uncertain)
    numbers = uncertain.frame["features/acceleration.rms"]
    cases = [entry["job"] for entry in uncertain.plan["jobs"] if not entry["twin"] | entry["variation"]]
    for quantity, values in (("damping", "1 to 5 µs"), ("clearance", "0 to 5 µm")):
        jobs = [v["job"] for v in uncertain.variations if v["what"] == quantity]
        ends = numbers[[*cases, *jobs]]
        text = f"with {quantity} {values}: {ends.min():.3g} to {ends.max():.3g} m/s²"
        assert any(remark.startswith(f"{text}, the ranges of all cases overlap at ") for remark in rms.remarks)
        assert any(remark.startswith(f"with {quantity} ") for remark in line.remarks)


def set_features(uncertain, values):
    """Set the acceleration (m/s²) of jobs by their ids."""
    features = uncertain.frame["features/acceleration.rms"].copy()
    features.update(values)
    uncertain.frame["features/acceleration.rms"] = features
    uncertain._table["acceleration.rms"] = features.reindex(uncertain._table["job"]).values


def cases_of(uncertain):
    return [entry["job"] for entry in uncertain.plan["jobs"] if not entry["twin"] | entry["variation"]]


def test_value_that_all_ranges_share_is_named(uncertain):
    nominal = dict.fromkeys(cases_of(uncertain), 2.0)
    varied = {v["job"]: 1.0 if v["value"] < 2e-6 else 3.0 for v in uncertain.variations if v["job"] not in nominal}
    set_features(uncertain, pd.Series(nominal | varied))
    [rms, _] = feature_results(uncertain)
    assert rms.remarks[-2] == "with damping 1 to 5 µs: 1 to 3 m/s², the ranges of all cases overlap at 1 to 3 m/s²"


def test_cases_without_a_common_value_are_separate_and_keep_their_order(uncertain):
    cases = cases_of(uncertain)
    nominal = {job: 1.0 + number for number, job in enumerate(cases)}
    varied = {v["job"]: nominal[v["of"]] + 0.1 for v in uncertain.variations if v["job"] not in nominal}
    exception = next(v for v in uncertain.variations if v["of"] == cases[0] and v["what"] == "damping")
    set_features(uncertain, pd.Series(nominal | varied | {exception["job"]: 100.0}))
    [rms, _] = feature_results(uncertain)
    assert rms.remarks[-1].endswith(", the ranges of some cases do not overlap")
    assert rms.remarks[1].endswith(" (for 2 of 3 values of damping, all values of clearance)")


def test_unknown_range_is_named_in_the_card_with_its_reason(uncertain):
    uncertain.frame["features/chaotic"] = 1.0
    uncertain.frame["features/rms_scatter"] = np.inf
    [rms, _] = feature_results(uncertain)
    assert "with damping 1 to 5 µs: unknown in 6 of 6 cases (chaotic and too short)" in rms.remarks
    damped = [v["job"] for v in uncertain.variations if v["what"] == "damping" and v["job"] != v["of"]]
    uncertain.frame.loc[damped[0], "features/acceleration.rms"] = np.nan
    [rms, _] = feature_results(uncertain)
    reasons = "variation missing, or chaotic and too short"
    assert f"with damping 1 to 5 µs: unknown in 6 of 6 cases ({reasons})" in rms.remarks


def test_range_of_a_line_without_a_standard_error_does_not_need_a_longer_record(uncertain):
    """Of the lines, only multiples of BPFO have a standard error in a chaotic motion."""
    uncertain.frame["features/chaotic"] = 1.0
    del uncertain.frame["features/velocity@BPFO-scatter"]
    [_, result] = feature_results(uncertain)
    reason = "chaotic; `velocity@BPFO` has no standard error then"
    assert f"with damping 1 to 5 µs: unknown in 6 of 6 cases ({reason})" in result.remarks


def test_rms_of_a_recorded_acceleration_has_a_numerical_error(uncertain):
    uncertain._table[["step_error.record", "chaotic"]] = 0.004, 0.0
    [rms, _] = feature_results(uncertain)
    assert not rms.error
    uncertain._parameters["record"] = "ring.velocity, ring.acceleration"
    [rms, _] = feature_results(uncertain)
    assert rms.error == "numerical error 0.4 %"


def test_varied_damping_is_stated_once(uncertain):
    page = make_page(uncertain)
    facts = dict(page.studied)
    assert facts["Varied (uncertainty)"] == (
        "damping 1 to 5 µs (3 values, nominal: kraemer, beta 2.5 µs); "
        "clearance 0 to 5 µm (3 values, nominal: 5 µm); one at a time"
    )
    others = [*(value for name, value in facts.items() if name != "Varied (uncertainty)"), *page.assumptions]
    assert not any(word in text for text in others for word in ("damping", "beta", "c/k", "clearance"))


def test_bearing_has_its_dimensions_and_frequencies(results):
    """Frequencies from the textbook: half the shaft frequency times the rollers, less or more the ratio."""
    opened = results()
    facts = dict(make_page(opened).studied)
    assert facts["Bearing"].startswith(
        "NF308, Z = 13 rollers, D_w 12 mm, L 12 mm, pitch diameter 65 mm, bore 40 mm"
    )
    assert facts["Bearing"].endswith("clearance 5 µm")
    parameters = opened.parameters().iloc[0]
    ratio = parameters["bearing.roller_diameter"] / parameters["bearing.pitch_diameter"]
    fr, z = 30.0, parameters["bearing.rollers"]
    expected = {
        "BPFO": z / 2 * fr * (1 - ratio),
        "BPFI": z / 2 * fr * (1 + ratio),
        "2BSF": fr / ratio * (1 - ratio**2),
        "FTF": fr / 2 * (1 - ratio),
        "fr": fr,
    }
    assert facts["Frequencies"] == ", ".join(f"{name} {value:.3g} Hz" for name, value in expected.items())
    assert facts["Defect"].startswith("outer race, circular defect, width 0.8 mm")


def test_assumptions_are_free_of_settings_and_pages_of_the_documentation(results):
    page = make_page(results())
    assert "clearance 5 µm, not varied; amplitudes at light load depend on it several-fold" in page.assumptions
    assert any(text.startswith("stiffness of the bracket 1e7 N/m, not varied; ") for text in page.assumptions)
    assert not any("uncertainty:" in text or "docs/" in text for text in page.assumptions)


def test_smooth_surfaces_are_assumed_unless_a_study_has_their_form(results):
    opened = results()
    smooth = "smooth surfaces assumed; waviness can change amplitudes at light load several-fold"
    assert smooth in make_page(opened).assumptions


def test_healthy_bearing_is_named_in_the_table(results):
    heads, cells = zip(*make_page(results()).table.columns, strict=True)
    column = cells[heads.index("defect length")]
    assert column.count("healthy") == 4
    assert "" not in column


@pytest.mark.parametrize(
    ("clearance", "offered"),
    [("C3", "45 um, 70 um"), ("40 um", "30 um, 50 um"), ("0 um", "0 um, 10 um"), ("-4 um", "-14 um, 6 um")],
)
def test_offered_range_of_clearance_contains_that_of_the_study(results, clearance, offered):
    opened = results(re.sub("clearance: .*", f"clearance: {clearance}", STUDY))
    assert f"`uncertainty: {{clearance: [{offered}]}}`" in "\n".join(assumption_texts(opened))


@pytest.mark.parametrize(
    ("value", "text"), [(352851.0, "353000"), (1234.0, "1230"), (12.34, "12.3"), (999.6, "1000"), (2e6, "2e+06")]
)
def test_numbers_have_three_significant_digits(value, text):
    assert significant(value) == text


def test_missing_error_bound_is_stated(results):
    assert "numerical error: not estimated" in render_html(make_page(results()))


def test_caption_counts_the_cases_of_unknown_range(uncertain):
    uncertain.frame["features/chaotic"] = 0.0
    uncertain.frame["features/rms_scatter"] = np.inf
    uncertain.frame.loc[uncertain.variations[0]["of"], "features/chaotic"] = 1.0
    [chart] = [chart for chart in make_page(uncertain).charts if chart.kind == "line"]
    text = "shaded: damping 1 to 5 µs and clearance 0 to 5 µm, range unknown in 1 of 6 cases"
    assert chart.names["band"].startswith(text)


@pytest.mark.parametrize(
    ("quantity", "text"),
    [("0.35 um (3 samples)", "0.35 µm (3 samples)"), ("0.5 to 10 us", "0.5 to 10 µs"), ("2", "2")],
)
def test_unit_of_a_range_is_printed_with_its_symbol(quantity, text):
    assert format_quantity(quantity) == text


@pytest.mark.parametrize(
    ("uncertainty", "nominal"), [("{clearance: [0 um, 5 um]}", ["with nominal clearance<"]), ("none", [])]
)
def test_page_names_the_parameters_that_are_nominal(results, uncertainty, nominal):
    page = render_html(make_page(results(f"{STUDY}uncertainty: {uncertainty}\n")))
    assert list(dict.fromkeys(re.findall(r"with nominal [\w, ]*<", page))) == nominal


def test_extremes_of_samples_are_counted_for_each_sample(results):
    """Two of three samples reverse the order of the cases."""
    sweep = STUDY.partition("sweep:")[0] + "model: planar\nsweep: {defect.length: [3 mm, 6 mm, 9 mm]}\n"
    opened = results(sweep + "uncertainty: {form: 0.35 um}\nfigures: [{y: velocity.rms, x: defect.length}]\n")
    values = {}
    for number, case in enumerate(cases_of(opened)):
        jobs = [variation["job"] for variation in opened.variations if variation["of"] == case]
        nominal, other = 1.0 + number, 10.0 - number
        values |= {case: nominal} | dict(zip(jobs, (other, other, nominal), strict=True))
    opened.frame["features/velocity.rms"] = opened.frame.index.map(values)
    opened._table["velocity.rms"] = opened._table["job"].map(values)
    [rms] = feature_results(opened)
    assert rms.remarks[:2] == [
        "largest: length 9 mm (for 1 of 3 values of form)",
        "smallest: length 3 mm (for 1 of 3 values of form)",
    ]
    assert dict(make_page(opened).studied)["Varied (uncertainty)"] == "form 0.35 µm (3 samples)"


def test_range_of_a_few_varied_cases_names_their_number(uncertain):
    """As without `uncertainty`, where the damping of three cases is varied: their range is not that of all."""
    varied = cases_of(uncertain)[1:3]
    kept = [variation for variation in uncertain.variations if variation["of"] in varied]
    uncertain.variations[:] = kept
    [rms, _] = feature_results(uncertain)
    jobs = [*varied, *(variation["job"] for variation in kept if variation["what"] == "damping")]
    ends = uncertain.frame["features/acceleration.rms"][jobs]
    text = f"with damping 1 to 5 µs in 2 of 6 cases: {ends.min():.3g} to {ends.max():.3g} m/s², "
    assert any(remark.startswith(f"{text}the ranges of these cases overlap at ") for remark in rms.remarks)


@pytest.mark.parametrize(
    ("degrees", "text"),
    [
        ((179.0, -179.0, 180.0), "179 to 181 °"),
        ((-170.0, 160.0, 170.0), "160 to 190 °"),
        ((-100.0, 0.0, 100.0), "-100 to 100 °"),
        ((-30.0, -20.0, -25.0), "-30 to -20 °"),
    ],
)
def test_range_of_a_phase_is_its_shortest_arc(results, monkeypatch, degrees, text):
    phases = dict(zip((3e-3, 6e-3, 9e-3), np.radians(degrees), strict=True))
    monkeypatch.setattr(
        "tests.scenes.figure_results.phase", lambda case: phases[case.defects[0].length] if case.defects else 0.0
    )
    opened = results(STUDY + "figures: [{y: velocity@BPFO.phase, x: defect.length, kind: phase}]\n")
    [phase] = feature_results(opened)
    assert phase.values == text


def test_cases_with_the_same_extreme_are_counted(results):
    """The line does not depend on the model: each extreme is that of two cases."""
    [line] = feature_results(results(STUDY + "figures: [{y: velocity@BPFO, x: defect.length}]\n"))
    assert line.remarks[1:] == [
        "largest: length 9 mm, load 300 N, model static, and 1 other",
        "smallest: length 3 mm, load 150 N, model static, and 1 other",
    ]


def test_jobs_without_a_step_error_are_counted(uncertain):
    cases = cases_of(uncertain)
    uncertain._table["chaotic"] = 0.0
    uncertain._table["step_error.line"] = np.where(uncertain._table["job"] == cases[-1], 0.01, np.nan)
    [_, line] = feature_results(uncertain)
    assert line.error == "numerical error 1 % (not estimated for 5 jobs)"
