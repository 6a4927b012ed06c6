"""Figures, drawn from results whose numbers are known."""

import math
import re
from typing import Any
from unittest import mock

import numpy as np
import pytest

from bearingsim.figure_kinds import KINDS
from bearingsim.plots import PlotError, PlotWarning, axes, plot, select
from bearingsim.plots.plot import draw_figures
from tests.scenes.figure_results import FIGURES, STUDY, lines, only, results, text_of

__all__ = ["results"]


def test_columns_are_features_rows_panels_and_curves_values(results):
    name, canvas = only(draw_figures(results()))
    assert name == "fig1-velocity-bpfo-vs-defect-length"
    assert len(canvas.axes) == 4
    assert [ax.get_title(loc="left") for ax in canvas.axes] == [
        "(a) model static",
        "(b) model static",
        "(c) model ring",
        "(d) model ring",
    ]
    assert text_of(canvas) == ["load 150 N", "load 300 N", "healthy"]


def test_values_are_in_readable_units(results):
    _, canvas = only(draw_figures(results()))
    low, high = lines(canvas.axes[0])
    assert list(low.get_xdata()) == pytest.approx([3.0, 6.0, 9.0])
    assert list(low.get_ydata()) == pytest.approx([7.0, 13.0, 19.0])  # um/s
    assert list(high.get_ydata()) == pytest.approx([8.0, 14.0, 20.0])
    assert canvas.axes[2].get_xlabel() == "Defect length (mm)"
    assert " ".join(canvas.axes[0].get_ylabel().split()) == "Velocity amplitude at BPFO (µm/s, 0-peak)"
    assert canvas.axes[0].get_ylim()[0] == 0.0


def test_level_hidden_by_the_axis_is_named_in_the_legend(results):
    """A line at zero lies on the axis; on a log axis it does not."""
    opened = results()
    healthy = [entry["job"] for entry in opened.plan["jobs"] if entry["twin"]]
    opened.frame.loc[healthy, "features/velocity@BPFO"] = 1e-12
    opened._table.loc[opened._table["job"].isin(healthy), "velocity@BPFO"] = 1e-12
    for log, text in (([], "healthy (about zero)"), (["y"], "healthy")):
        axes_options = {"x": "defect.length", "by": ["load"], "panels": ["model"], "log": log}
        ((_, canvas),) = draw_figures(opened, None, (), y=["velocity@BPFO"], **axes_options)
        assert text_of(canvas)[-1] == text


def test_change_from_healthy_is_complex_difference(results):
    _, canvas = only(draw_figures(results()))
    first = lines(canvas.axes[1])[0].get_ydata()[0]
    assert first == pytest.approx(abs(7.0 * np.exp(-0.5j) - 0.5))


def test_healthy_cases_are_no_points(results):
    opened = results()
    assert len(select.case_rows(opened)) == 12
    assert len(opened.table()) == 16


def test_unassigned_swept_parameter_becomes_curves(results):
    text = STUDY + "figures: [{y: velocity@BPFO, x: defect.length, by: load}]\n"
    _, canvas = only(draw_figures(results(text)))
    assert len(lines(canvas.axes[0])) == 4
    assert text_of(canvas) == ["load 150 N", "load 300 N", "model static", "model ring", "healthy"]


def test_parameter_zipped_with_x_makes_no_curves(results):
    text = STUDY.replace(
        "  defect.length: [3 mm, 6 mm, 9 mm]\n",
        "  zip: {defect.length: [3 mm, 6 mm, 9 mm], defect.width: [0.3 mm, 0.6 mm, 0.9 mm]}\n",
    )
    sheets = draw_figures(results(text), x="defect.length", by=["load", "model"])
    assert len(lines(only(sheets)[1].axes[0])) == 4


def test_where_selects_rows(results):
    text = STUDY + "figures: [{y: velocity@BPFO, x: defect.length, where: {load: 0.3 kN, model: ring}}]\n"
    _, canvas = only(draw_figures(results(text)))
    [line] = lines(canvas.axes[0])
    assert list(line.get_ydata()) == pytest.approx([8.0, 14.0, 20.0])


@pytest.mark.parametrize("value", ["auto", "50 ms", "0.05 s"])
def test_where_selects_among_words_and_numbers(results, value):
    stored = results(STUDY.replace("load: [150 N, 300 N]", "settle: [auto, 50 ms]"))
    rows = select.matching_rows(select.case_rows(stored), {"settle": value}, stored.plan["units"])
    assert set(rows["settle"]) == {"auto" if value == "auto" else 0.05}
    assert len(rows) == 6


def test_failed_and_missing_jobs_are_marked_at_their_x(results):
    _, canvas = only(draw_figures(results(lost={0: "failed", 11: "missing"})))
    failed = [line for line in canvas.axes[0].lines if line.get_marker() == "x"]
    missing = [line for line in canvas.axes[2].lines if line.get_marker() == "|"]
    assert [list(line.get_xdata()) for line in failed] == [[3.0]]
    assert [list(line.get_xdata()) for line in missing] == [[9.0]]
    assert text_of(canvas)[-2:] == ["failed", "not computed"]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("status", "reason"), [("failed", ": 16 failed, the first with: the ring left"), ("missing", "$")]
)
def test_figure_without_finished_job_gives_the_reason(results, kind, status, reason):
    opened = results(STUDY, lost=dict.fromkeys(range(16), status))  # 12 cases, 4 healthy cases
    with pytest.raises(PlotError, match=f"no job is done, so there is nothing to draw{reason}"):
        draw_figures(opened, kind=kind)


def test_chaotic_results_are_ringed_and_explained_in_legend(results):
    stored = results()
    assert "chaotic, uncertain" not in text_of(only(draw_figures(stored))[1])
    table = stored.table()
    table["chaotic"] = 0.0
    table["rms_scatter"] = 1.0
    for name in (name for name in table if "@" in name and f"{name}.phase" in table):
        table[f"{name}-scatter"] = table[name]
    table.loc[(table["defect.length"] == 6e-3) & (table["load"] == 300.0), "chaotic"] = 1.0
    with mock.patch.object(type(stored), "table", return_value=table):
        _, canvas = only(draw_figures(stored))
    rings = [line for ax in canvas.axes for line in ax.lines if line.get_markersize() == axes.CHAOTIC_RING["ms"]]
    assert len(rings) == 4  # two features, two models
    assert {tuple(ring.get_xdata()) for ring in rings} == {(6.0,)}
    assert text_of(canvas)[-1] == "chaotic, uncertain"


def test_error_bars_and_model_marks_of_study_with_accuracy(results):
    stored = results()
    table = stored.table().assign(**{"error.model": 0.03}, model="planar")
    table.loc[table["defect.length"] == 6e-3, "model"] = "rollers"
    stored.plan["accuracy"] = accuracy_of(stored, 0.04)
    with mock.patch.object(type(stored), "table", return_value=table):
        _, canvas = only(draw_figures(stored, panels=["load"], by=[]))
    ax = canvas.axes[0]
    (bars,) = [collection for collection in ax.collections if len(collection.get_segments()) > 1]
    lengths = [abs(b[1] - a[1]) for a, b in bars.get_segments()]
    assert lengths == pytest.approx([2 * 0.04 * max(ax.lines[0].get_ydata())] * len(lengths))
    assert text_of(canvas)[-2:] == ["planar", "rollers"]
    marks = [line for line in ax.lines if line.get_markersize() == axes.MODEL_MARK["ms"]]
    positions = {line.get_marker(): set(line.get_xdata()) for line in marks}
    assert positions == {"o": {3.0, 9.0}, "s": {6.0}}


def accuracy_of(stored, error):
    """Make the accuracy of a plan with a curve over the length of the defect for each load and model.

    error: that of the model of each case, relative to the largest value of a curve.
    """
    rows = select.case_rows(stored)
    names = ["velocity@BPFO", "velocity@BPFO-healthy"]
    groups = [list(part["job"]) for _, part in rows.groupby(["load", "model"])]
    curves = [{"feature": name, "jobs": jobs} for name in names for jobs in groups]
    choice = {"model": "ring", "error": dict.fromkeys(names, error)}
    return {
        "of": names,
        "within": 0.05,
        "jobs": dict.fromkeys(rows["job"], choice),
        "curves": curves,
        "audits": [],
    }


@pytest.mark.parametrize(
    ("options", "bars"),
    [
        ({"x": "defect.length"}, [0.19] * 3),
        ({"x": "defect.length", "where": {"defect.length": "3 mm"}}, [0.19]),
        ({"x": "load", "where": {"defect.length": "3 mm"}}, [0.19, 0.2]),
        ({"x": "defect.length", "y": ["velocity.rms"]}, []),
        ({"x": "defect.length", "y": ["seconds"]}, []),
        ({"x": "defect.length", "kind": "phase"}, []),
    ],
)
def test_error_bars_are_relative_to_the_curves_of_the_study(results, options, bars):
    """1 % of the largest value over the length, 19 and 20 um/s, only for features that the accuracy covers."""
    stored = results(STUDY)
    table = stored.table()
    stored.plan["accuracy"] = accuracy_of(stored, 0.01)
    table = table[
        table["job"].isin([job["job"] for job in stored.plan["jobs"] if job["swept"]["model"] == "ring"])
    ]
    where = {"load": "150 N"} if options["x"] != "load" else {}
    options = {"y": ["velocity@BPFO"], **options, "where": options.get("where", {}) | where}
    if "kind" in options:
        del options["y"]
    with mock.patch.object(type(stored), "table", return_value=table):
        _, canvas = only(draw_figures(stored, **options))
    drawn_bars = [segment for part in canvas.axes[0].collections for segment in part.get_segments()]
    assert [(top[1] - low[1]) / 2.0 for low, top in drawn_bars] == pytest.approx(bars)


def test_study_without_figures_has_one_per_swept_number(results):
    sheets = draw_figures(results(STUDY))
    assert [name for name, _ in sheets] == ["fig1-velocity-bpfo-vs-defect-length", "fig2-velocity-bpfo-vs-load"]


def test_too_many_curves_become_panels(results):
    text = STUDY.replace("[150 N, 300 N]", "{linspace: [100 N, 300 N, 6]}")
    _, canvas = draw_figures(results(text))[0]
    assert len(canvas.axes) == 4  # two models, two features
    assert len(lines(canvas.axes[0])) == 6


def test_parameter_zipped_with_x_makes_no_panels(results):
    zipped = "zip: {load: [1 N, 2 N, 3 N, 4 N, 5 N], defect.width: [1 mm, 2 mm, 3 mm, 4 mm, 5 mm]}"
    text = STUDY.replace("load: [150 N, 300 N]", zipped)
    _, canvas = only(draw_figures(results(text), x="load"))
    assert len(canvas.axes) == 2
    assert len(lines(canvas.axes[0])) == 6


def test_options_change_figure_of_study(results):
    opened = results()
    _, canvas = only(draw_figures(opened, y=["velocity.rms"], panels=["load"], where={"model": "ring"}))
    assert [ax.get_title(loc="left") for ax in canvas.axes] == ["(a) load 150 N", "(b) load 300 N"]
    assert [len(lines(ax)) for ax in canvas.axes] == [1, 1]
    _, canvas = only(draw_figures(opened, by=["model"], y=["velocity.rms"]))
    assert text_of(canvas) == ["model static", "model ring", "load 150 N", "load 300 N", "healthy"]


def test_undrawable_figure_is_skipped_with_warning(results):
    text = STUDY + FIGURES + "  - {y: velocity@BPFO, x: load, where: {model: rollers}}\n"
    opened = results(text)
    with pytest.warns(PlotWarning, match="figure 2 skipped: no case has model rollers"):
        assert len(draw_figures(opened)) == 1
    with pytest.raises(PlotError, match="no case has load 1 N"):
        draw_figures(opened, where={"load": "1 N"})


def test_figure_over_fixed_x_is_replaced(results):
    sheets = draw_figures(results(overrides={"defect.length": "6 mm"}))
    assert [name for name, _ in sheets] == ["fig1-velocity-bpfo-vs-load"]


def test_words_are_ticks_in_order_of_study(results):
    _, canvas = only(draw_figures(results(STUDY), x="model"))
    assert [label.get_text() for label in canvas.axes[0].get_xticklabels()] == ["static", "ring"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"x": "defect.lenght"}, "did you mean `defect.length`?"),
        ({"y": ["velocity@BPFI"]}, "no feature `velocity@BPFI` in these results (available: "),
        ({"by": ["laod"]}, "did you mean `load`?"),
    ],
)
def test_unknown_name_is_refused_with_suggestion(results, options, message):
    with pytest.raises(PlotError, match=re.escape(message)):
        draw_figures(results(), **options)


def test_study_without_sweep_is_refused(results):
    with pytest.raises(PlotError, match="sweeps no parameter"):
        draw_figures(results(STUDY, overrides={"defect.length": "3 mm", "load": "150 N", "model": "ring"}))


def test_log_option_sets_log_axes(results):
    text = STUDY + "figures: [{y: velocity@BPFO, x: defect.length, log: [x, y]}]\n"
    _, canvas = only(draw_figures(results(text)))
    assert (canvas.axes[0].get_xscale(), canvas.axes[0].get_yscale()) == ("log", "log")


def test_panels_of_equal_magnitude_share_axis(results):
    _, canvas = only(draw_figures(results(), panels=["load"], by=["model"], y=["velocity@BPFO"]))
    low, high = canvas.axes
    assert low.get_ylim() == high.get_ylim()
    assert high.get_ylim()[1] > 20.0


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_figures_are_written_with_their_names(results, suffix):
    opened = results()
    [path] = plot(opened, file_format=suffix)
    assert path == opened.path / "figures" / f"fig1-velocity-bpfo-vs-defect-length.{suffix}"
    head = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[suffix]
    assert path.read_bytes().startswith(head)
    if suffix == "svg":
        assert "Defect length (mm)" in path.read_text()


@pytest.mark.parametrize("log", ["x", "y"])
def test_logarithmic_axis_without_room_for_a_point_is_refused(results, log):
    """A point at zero would be outside the axis."""
    stored = results(STUDY.replace("load: [150 N, 300 N]", "load_across: [0 N, 10 N, 100 N]"))
    table = stored.table().assign(**{"velocity.rms": 0.0})
    message = {
        "x": "a logarithmic axis cannot show load across 0 N",
        "y": "no value of `velocity.rms` is above zero",
    }[log]
    with mock.patch.object(type(stored), "table", return_value=table), pytest.raises(PlotError, match=message):
        draw_figures(stored, x="load_across", y=["velocity.rms"], log=[log], where={"model": "ring"})


def test_feature_without_a_value_above_zero_leaves_the_others_of_a_logarithmic_figure(results):
    """The force is zero in all cases, the RMS in those of one panel."""
    stored = results()
    table = stored.table().assign(**{"outer_force.max": 0.0})
    table.loc[table["model"] == "static", "velocity.rms"] = 0.0
    options: dict[str, Any] = {"x": "defect.length", "by": ["load"], "panels": ["model"], "log": ["y"]}
    with mock.patch.object(type(stored), "table", return_value=table):
        _, canvas = only(draw_figures(stored, y=["velocity@BPFO", "velocity.rms", "outer_force.max"], **options))
    canvas.draw_without_rendering()
    has_note = ["no value above zero" in [text.get_text() for text in ax.texts] for ax in canvas.axes]
    assert has_note == [False, True, True, False, False, True]
    boxes = [text.get_window_extent() for text in canvas.axes[2].texts]
    assert len(boxes) == 2
    assert not boxes[0].overlaps(boxes[1])
    low, high = canvas.axes[4].get_ylim()
    assert low < min(lines(canvas.axes[4])[0].get_ydata()) == pytest.approx(7.0)
    assert 20.0 < high < 100.0
    assert {ax.get_yscale() for ax in canvas.axes} == {"log"}


@pytest.mark.parametrize("log", [[], ["y"]])
def test_panels_of_named_cases_share_an_axis_with_room_for_all(results, log):
    """Values of 1 um/s in the first panel, of 10 um/s and, linearly, -5 um/s in the second."""
    pulses = (
        "envelope, rectangular-pulse, half-sine-pulse, piecewise-pulse, pressure-share, soft-edge, elastic-edge"
    )
    sweep = f"sweep: {{excitation: [{pulses}], load: [150 N, 300 N]}}\n"
    stored = results(STUDY[: STUDY.index("sweep:")] + sweep)
    table = stored.table()
    values = np.where(table["load"] == 150.0, 1e-6, 1e-5)
    values[-1] = 1e-5 if log else -5e-6
    table = table.assign(**{"velocity@BPFO": values})
    with mock.patch.object(type(stored), "table", return_value=table):
        _, canvas = only(draw_figures(stored, x="excitation", panels=["load"], y=["velocity@BPFO"], log=log))
    canvas.draw_without_rendering()
    for ax in canvas.axes:
        low, high = ax.get_xlim()
        assert all(low < value < high for line in lines(ax) for value in line.get_xdata())
        assert ax.get_xlim() == canvas.axes[0].get_xlim()
        assert high < (100.0 if log else 20.0)


def test_points_over_words_differ_by_the_fill_of_their_markers(results):
    _, canvas = only(draw_figures(results(STUDY), x="model", y=["velocity@BPFO"], by=["load", "defect.length"]))
    curves = lines(canvas.axes[0])
    looks = {(line.get_color(), line.get_fillstyle(), line.get_markerfacecolor()) for line in curves}
    assert len(looks) == len(curves) == 6


PULSES = "envelope, rectangular-pulse, half-sine-pulse, piecewise-pulse, pressure-share, soft-edge, elastic-edge"


@pytest.mark.parametrize("excitations", ["envelope, soft-edge", PULSES])
def test_uncertain_ranges_of_words_are_bars(results, monkeypatch, excitations):
    """The line is 1 um/s per um of clearance, which varies from 2 to 8 um; no band joins the words."""
    monkeypatch.setattr("tests.scenes.figure_results.amplitude", lambda case: case.clearance)
    text = f"sweep: {{excitation: [{excitations}]}}\nuncertainty: {{clearance: [2 um, 8 um]}}\n"
    _, canvas = only(draw_figures(results(STUDY[: STUDY.index("sweep:")] + text), y=["velocity@BPFO"]))
    [ax] = canvas.axes
    [bars] = ax.collections
    ends = np.array(bars.get_segments())
    names = excitations.split(", ")
    along, across = (0, 1) if len(names) > 2 else (1, 0)
    np.testing.assert_allclose(np.sort(ends[:, :, along]), [[2.0, 8.0]] * len(names))
    np.testing.assert_allclose(ends[:, 0, across], range(len(names)))
    low, high = ax.get_xlim() if along == 0 else ax.get_ylim()
    assert low < 2.0 < 8.0 < high
    assert "bands and bars: clearance 2 to 8 µm" in canvas.get_supxlabel().replace("\N{NO-BREAK SPACE}", " ")


def test_two_long_names_have_room_beside_a_long_axis_label(results):
    text = "sweep: {contact.damping: [{law: kraemer, beta: 2.5 us}, {law: film, oil: VG 68, temperature: 55 C}]}\n"
    stored = results(STUDY[: STUDY.index("sweep:")] + text)
    _, canvas = only(draw_figures(stored, y=["velocity@BPFO", "velocity.rms", "velocity@BPFO-healthy"]))
    canvas.draw_without_rendering()
    first, second = (label.get_window_extent() for label in canvas.axes[0].get_yticklabels())
    assert second.y1 < first.y0


def test_panels_after_the_26th_have_two_letters(results):
    lengths = ", ".join(f"{3.0 + 0.1 * n:.1f} mm" for n in range(28))
    stored = results(STUDY.replace("3 mm, 6 mm, 9 mm", lengths).replace("[static, ring]", "[ring]"))
    _, canvas = only(draw_figures(stored, x="load", y=["velocity@BPFO"], panels=["defect.length"]))
    assert [ax.get_title(loc="left").split()[0] for ax in canvas.axes[24:]] == ["(y)", "(z)", "(aa)", "(ab)"]


def test_curves_of_long_seeds_are_told_apart(results):
    text = STUDY.replace("load: [150 N, 300 N]", "defect.seed: [20240101, 20240102, 20240103]")
    stored = results(text.replace("shape: circular, length: 3 mm", "shape: spall, length: 3 mm, seed: 1"))
    where = {"model": "ring"}
    _, canvas = only(draw_figures(stored, x="defect.length", y=["velocity@BPFO"], by=["defect.seed"], where=where))
    assert text_of(canvas) == [*(f"seed {20240101 + n}" for n in range(3)), "healthy"]
    assert len({line.get_color() for line in lines(canvas.axes[0])}) == 3
    _, canvas = only(draw_figures(stored, x="defect.seed", y=["velocity@BPFO"], where=where))
    canvas.draw_without_rendering()
    ticks = {text.get_text() for text in canvas.axes[0].get_xticklabels()}
    assert ticks <= {"20240101", "20240102", "20240103"}
    assert len(ticks) >= 2


def test_baselines_that_are_missing_at_one_point_are_one_line(results):
    stored = results()
    table = stored.table()
    healthy = [entry["job"] for entry in stored.plan["jobs"] if entry["twin"]]
    table.loc[table["job"].isin(healthy[:2]), "velocity@BPFO"] = math.nan
    with mock.patch.object(type(stored), "table", return_value=table):
        _, canvas = only(draw_figures(stored, x="load", y=["velocity@BPFO"], where={"model": "ring"}))
    levels = [line for line in canvas.axes[0].lines if line.get_gid() == "healthy"]
    assert [line.get_color() for line in levels] == ["0.35"]


def test_a_measured_point_at_no_case_of_a_tied_sweep_has_no_mark(results):
    """Cases with 0.8 mm and with 150 N exist, but none with both."""
    text = STUDY.replace(
        "  load: [150 N, 300 N]\n", "  zip: {defect.width: [0.4 mm, 0.8 mm], load: [150 N, 300 N]}\n"
    )
    points = [
        f"{{load: 150 N, defect.width: {width} mm, defect.length: 3 mm, velocity@BPFO: {value} um/s}}"
        for width, value in ((0.4, 4.0), (0.8, 8.0))
    ]
    stored = results(text + f"measured: [{{label: rig, points: [{', '.join(points)}]}}]\n")
    _, canvas = only(
        draw_figures(stored, x="defect.length", y=["velocity@BPFO"], by=["load"], where={"model": "ring"})
    )
    marks = [line.get_ydata() for line in canvas.axes[0].lines if line.get_gid() == "measured"]
    assert [list(values) for values in marks] == [[pytest.approx(4.0)]]
