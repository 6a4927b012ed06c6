"""Spectral lines that figures show and mark, and axes of words."""

from unittest import mock

import numpy as np
import pandas as pd
import pytest

from bearingsim.plots import PlotError, lines, select
from bearingsim.plots.axes import MODEL_MARK
from bearingsim.plots.plot import draw_figures
from bearingsim.plots.ticks import set_log_ticks
from bearingsim.report import columns
from tests.scenes.figure_results import STUDY, only, record, results, text_of

__all__ = ["results"]

NF308 = {"speed": np.pi * 60.0, "bearing.rollers": 13.0, "bearing.roller_diameter": 0.012} | {
    "bearing.pitch_diameter": 0.065
}
INNER, ROLLER = {"defects.1.race": "inner"}, {"defects.1.race": "roller"}
PAIRS = """\
  zip:
    excitation: [envelope, envelope, half-sine-pulse, soft-edge, impulse-train]
    model: [static, ring, rollers, planar, impulse]
    friction: [none, none, none, traction, none]
"""


def frequency_of(name, race):
    """The frequency of a mark of the NF308 at 1800 rpm."""
    return {mark.name: mark.frequency for mark in lines.marks(NF308 | race, 1000.0)}[name]


def test_marks_are_at_fault_frequencies():
    """159.0, 231.0, 156.96, 12.23 and 30 Hz: BPFO, BPFI, 2 BSF, FTF and shaft (`bearingsim freq nf308`)."""
    assert frequency_of("2 BPFO", {}) == pytest.approx(318.0, abs=1e-9)
    assert frequency_of("BPFI", INNER) == pytest.approx(231.0, abs=1e-9)
    assert frequency_of("BPFI - fr", INNER) == pytest.approx(201.0, abs=1e-9)
    assert frequency_of("2 BPFI + fr", INNER) == pytest.approx(492.0, abs=1e-9)
    assert frequency_of("2 BSF", ROLLER) == pytest.approx(156.96, abs=5e-3)
    assert frequency_of("4 BSF + FTF", ROLLER) == pytest.approx(313.92 + 12.23, abs=1e-2)


def test_last_lower_sideband_is_marked_below_its_harmonic():
    """3 BPFI is at 693 Hz, 3 BPFI - fr at 663 Hz."""
    names = [mark.name for mark in lines.marks(NF308 | INNER, 690.0)]
    assert names[-1] == "3 BPFI - fr"
    assert "3 BPFI" not in names


def test_marks_of_defects_on_several_elements_are_ordered():
    jobs = [{"defects.1.race": "roller", "defects.2.race": "inner"}, {"defects.1.race": "outer"}]
    assert lines.races(*jobs) == ["outer", "inner", "roller"]
    assert lines.races({"defects.1.race": "", "load": 1.0}) == []
    assert {mark.race for mark in lines.marks(NF308 | jobs[0], 300.0)} == {"inner", "roller"}


def test_marks_of_healthy_bearing_are_at_bpfo():
    assert lines.fundamental_lines(pd.DataFrame({"load": [1.0]})) == ["BPFO"]
    assert [mark.name for mark in lines.marks(NF308, 400.0)] == ["BPFO", "2 BPFO"]


@pytest.fixture
def of_race(results, monkeypatch):
    """A function that makes results of a study whose defect is on some element, with all lines in them."""

    def with_lines(case):
        result = record(case)
        for line in ("BPFI", "2BSF"):
            result.features |= {f"velocity@{line}": 1e-6, f"velocity@{line}.phase": 1.0}
        return result

    def make(race, change=("", "")):
        monkeypatch.setattr("tests.scenes.figure_results.record", with_lines)
        return results(STUDY.replace("shape:", f"race: {race}, shape:").replace(*change))

    return make


@pytest.mark.parametrize(("race", "line"), [("outer", "BPFO"), ("inner", "BPFI"), ("roller", "2BSF")])
def test_default_figures_plot_line_of_damaged_element(of_race, race, line):
    opened = of_race(race)
    _, canvas = draw_figures(opened)[0]
    labels = [" ".join(ax.get_ylabel().split()) for ax in canvas.axes[:2]]
    assert labels[0].startswith(f"Velocity amplitude at {line}")
    assert labels[1].startswith(f"Velocity at {line}, change from healthy")
    _, canvas = draw_figures(opened, kind="phase")[0]
    labels = [" ".join(ax.get_ylabel().split()) for ax in canvas.axes[:2]]
    assert labels == [f"Velocity phase at {line} (°)", f"Phase of velocity at {line}, change from healthy (°)"]


def test_default_features_are_of_damaged_element(of_race):
    opened = of_race("inner")
    chosen = columns.default_features(opened, opened.table())
    assert chosen == ["velocity@BPFI", "velocity@BPFI-healthy", "velocity.rms"]


def test_each_damaged_element_has_a_column(of_race):
    opened = of_race("outer", change=("model: [static, ring]", "defect.race: [outer, inner]"))
    _, canvas = draw_figures(opened, x="load")[0]
    labels = [" ".join(ax.get_ylabel().split()) for ax in canvas.axes[:2]]
    assert labels == ["Velocity amplitude at BPFO (µm/s, 0-peak)", "Velocity amplitude at BPFI (µm/s, 0-peak)"]


def test_caption_names_damaged_element(of_race):
    _, canvas = draw_figures(of_race("roller"))[0]
    assert "circular defect of roller 1" in canvas.get_supxlabel().replace("\u00a0", " ").replace("\n", " ")


@pytest.mark.parametrize("kind", ["spectrum", "envelope"])
def test_sidebands_are_marked_and_named(of_race, kind):
    opened = of_race("inner")
    _, canvas = only(draw_figures(opened, kind=kind, jobs=opened.jobs[:1]))
    [ax] = canvas.axes
    marks = sorted(line.get_xdata()[0] for line in ax.lines if len(line.get_xdata()) == 2)
    assert marks[:7] == pytest.approx([30.0, 201.0, 231.0, 261.0, 432.0, 462.0, 492.0])
    assert text_of(canvas) == ["with defect", "healthy", "± fr (30 Hz)"]
    names = {text.get_text() for text in ax.texts}
    assert {"BPFI 231.0 Hz", "BPFI + fr 261.0 Hz"} <= names
    assert ("fr 30.0 Hz" in names) == (kind == "envelope")  # in the wide range of a spectrum it has no room


def test_names_of_marks_do_not_overlap(of_race):
    opened = of_race("inner")
    for limits in ("0..500 Hz", "0..1 kHz", "0..4 kHz", "150..300 Hz"):
        _, canvas = only(draw_figures(opened, kind="spectrum", jobs=opened.jobs[:1], range=limits))
        canvas.draw_without_rendering()
        boxes = [text.get_window_extent() for text in canvas.axes[0].texts]
        assert boxes
        assert not [box for n, box in enumerate(boxes) if any(box.overlaps(other) for other in boxes[:n])]
    names = [text.get_text() for text in canvas.axes[0].texts]
    assert names == ["BPFI - fr 201.0 Hz", "BPFI + fr 261.0 Hz", "BPFI 231.0 Hz"]


# Words on x


def with_pairs(more="figures: [{y: [velocity@BPFO, seconds], x: excitation, log: y}]\n"):
    head = STUDY.partition("sweep:\n")[0]
    return f"{head}duration: 0.2 s\nsweep:\n{PAIRS}{more}"


def names_of(ax):
    return [label.get_text() for label in ax.get_yticklabels()]


def test_zipped_words_share_category_labels(results):
    name, canvas = only(draw_figures(results(with_pairs())))
    assert name == "fig1-velocity-bpfo-vs-excitation-model-friction"
    assert len(canvas.axes) == 2
    assert names_of(canvas.axes[0]) == [
        "envelope, static",
        "envelope, ring",
        "half-sine-pulse, rollers",
        "soft-edge, planar, traction",
        "impulse-train, impulse",
    ]
    assert canvas.axes[0].yaxis_inverted()
    assert not canvas.legends


def test_cpu_time_of_jobs_is_drawn(results):
    _, canvas = only(draw_figures(results(with_pairs())))
    cost = canvas.axes[1]
    assert cost.get_xlabel() == "CPU time of a job (ms)"
    assert list(cost.lines[0].get_xdata()) == pytest.approx([100.0] * 5)
    assert list(cost.lines[0].get_ydata()) == [0, 1, 2, 3, 4]
    assert cost.get_xscale() == "log"
    assert [text.get_text() for text in cost.texts] == ["100"] * 5


def test_independently_swept_words_are_curves(results):
    text = STUDY.replace("  load", "  excitation: [envelope, soft-edge]\n  load").replace(
        "[static, ring]", "[ring, rollers]"
    )
    _, canvas = only(draw_figures(results(text), x="excitation", y=["velocity.rms"], by=["model", "load"]))
    texts = text_of(canvas)
    assert "model ring" in texts
    assert any(text.startswith("load 150 N") for text in texts)
    assert [label.get_text() for label in canvas.axes[0].get_xticklabels()] == ["envelope", "soft-edge"]
    lines = dict(zip(texts, canvas.legends[0].get_lines(), strict=True))
    assert {line.get_linestyle() for text, line in lines.items() if text != "healthy"} == {"None"}


def test_failed_case_is_marked_at_its_category(results):
    _, canvas = only(draw_figures(results(with_pairs(), lost={2: "failed"})))
    [lost] = [line for line in canvas.axes[0].lines if line.get_marker() == "x"]
    assert list(lost.get_ydata()) == [2]


def test_curves_over_categories_are_offset(results):
    text = with_pairs("  load: [150 N, 300 N]\nfigures: [{y: velocity@BPFO, x: excitation}]\n")
    _, canvas = only(draw_figures(results(text)))
    low, high = canvas.axes[0].lines[:2]
    assert text_of(canvas) == ["load 150 N", "load 300 N"]
    assert np.subtract(high.get_ydata(), low.get_ydata()) == pytest.approx([0.25] * 5)


def test_negative_values_beside_names_are_inside_their_axis(results, monkeypatch):
    def slipping(case):
        result = record(case)
        result.features["cage.slip.mean"] = -case.load / 15e3
        return result

    monkeypatch.setattr("tests.scenes.figure_results.record", slipping)
    text = with_pairs("  load: [150 N, 300 N]\n")
    _, canvas = only(draw_figures(results(text), x="excitation", y=["cage.slip.mean"]))
    [ax] = canvas.axes
    low, high = ax.get_xlim()
    points = np.concatenate([line.get_xdata() for line in ax.lines])
    assert points.min() == pytest.approx(-2.0)  # per cent
    assert low < points.min() < points.max() < high


@pytest.mark.parametrize("has_errors", [False, True])
def test_names_have_error_bars_models_and_measured_values(results, has_errors):
    measured = "measured: [{label: rig, points: [{excitation: envelope, model: ring, friction: none, load: 150 N, "
    measured += "velocity@BPFO: 9 um/s}]}]\n"
    stored = results(with_pairs("  load: [150 N, 300 N]\n") + measured)
    table = stored.table()
    if has_errors:
        table["error.model"] = 0.1
        jobs = [list(part["job"]) for _, part in select.case_rows(stored).groupby("load")]
        curves = [{"feature": "velocity@BPFO", "jobs": group} for group in jobs]
        choice = {"model": "ring", "error": {"velocity@BPFO": 0.1}}
        choices = {job: choice for group in jobs for job in group}
        goal = {"of": ["velocity@BPFO"], "within": 0.1, "jobs": choices, "curves": curves, "audits": []}
        stored.plan["accuracy"] = goal
    with mock.patch.object(type(stored), "table", return_value=table):
        _, canvas = only(draw_figures(stored, x="excitation", y=["velocity@BPFO"]))
    [ax] = canvas.axes
    bars = [segment for part in ax.collections for segment in part.get_segments()]
    assert {round(float(np.ptp(bar[:, 0])) / 2.0, 9) for bar in bars} == ({0.7, 0.8} if has_errors else set())
    marked = {line.get_marker() for line in ax.lines if line.get_markersize() == MODEL_MARK["ms"]}
    assert len(marked) == (5 if has_errors else 0)
    [mark] = [line for line in ax.lines if line.get_gid() == "measured"]
    assert (list(mark.get_xdata()), list(mark.get_ydata())) == ([pytest.approx(9.0)], [1.0])
    assert "rig" in text_of(canvas)


@pytest.mark.parametrize(("low", "high", "most"), [(9.0, 12.0, 6), (1.0, 80.0, 8), (1e-3, 1e4, 12)])
def test_log_axis_has_two_to_twelve_ticks(results, low, high, most):
    opened = results(STUDY.replace("load: [150 N, 300 N]", f"load: [{low} N, {high} N]"))
    _, canvas = only(
        draw_figures(opened, x="load", y=["velocity.rms"], where={"model": "ring", "defect.length": "3 mm"})
    )
    [ax] = canvas.axes
    ax.set_yscale("log")
    ax.set_ylim(low, high)
    set_log_ticks(ax.yaxis, low, high)
    ticks = [tick for tick in ax.get_yticks() if low <= tick <= high]
    assert 2 <= len(ticks) <= most


def test_axis_from_zero_ends_above_largest_point(results):
    opened = results(STUDY.replace("[3 mm, 6 mm, 9 mm]", "[9 mm, 9.01 mm]"))
    _, canvas = only(
        draw_figures(opened, x="defect.length", y=["velocity@BPFO"], where={"model": "ring", "load": "300 N"})
    )
    assert canvas.axes[0].get_ylim()[1] > 1.02 * canvas.axes[0].dataLim.y1


def test_an_unknown_line_is_refused(results):
    with pytest.raises(PlotError, match="did you mean"):
        draw_figures(results(), y=["velocity@BPF"])
