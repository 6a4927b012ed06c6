"""Figures, drawn from results whose numbers are known."""

import math
import re
from types import SimpleNamespace
from unittest import mock

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from bearingsim import signals, store
from bearingsim.figure_kinds import KINDS
from bearingsim.plots import PlotError, PlotWarning, axes, labels, plot, select, style
from bearingsim.plots.plot import drawn
from bearingsim.plots.recorded import Signal
from bearingsim.plots.spectra import whole_periods
from bearingsim.study import load_study

STUDY = """\
study: known
bearing: nf308
speed: 1800 rpm
load: 150 N
clearance: 5 um
defect: {shape: circular, length: 3 mm, width: 0.8 mm, depth: 0.05 mm}
sweep:
  defect.length: [3 mm, 6 mm, 9 mm]
  load: [150 N, 300 N]
  model: [static, ring]
duration: 0.2 s
"""
FIGURES = """\
figures:
  - {y: [velocity@BPFO, velocity@BPFO-healthy], x: defect.length, by: load, panels: model}
"""
BPFO = 159.0


def amplitude(case):
    """The line (m/s) of a made-up result: 2 um/s per mm and 1 um/s per 150 N; healthy 0.5 um/s."""
    if not case.defects:
        return 0.5e-6
    return 2e-3 * case.defects[0].length + case.load / 150.0 * 1e-6


def phase(case):
    """Phase (rad) of the made-up line: that of a defect that turns with its angle; healthy 0."""
    return -13.0 * case.defects[0].angle - 0.5 if case.defects else 0.0


def record(case):
    time = np.arange(round(case.duration * case.sampling)) / case.sampling
    wave = amplitude(case) * np.cos(2.0 * math.pi * BPFO * time)
    series = {"ring.velocity.x": wave, "ring.velocity.y": 0.0 * wave} if case.record else {}
    features = {
        "velocity@BPFO": amplitude(case),
        "velocity@BPFO.phase": phase(case),
        "velocity@BPFO-scatter": 1e-19 * (1.0 + case.load),
        "velocity.rms": 1e3 * amplitude(case),
    }
    return SimpleNamespace(time=time, series=series, features=features, info={"cpu_s": 0.1})


@pytest.fixture
def results(tmp_path):
    """A function that makes a results folder of a study text; ``lost`` maps the number of a job to its status."""

    def make(text=STUDY + FIGURES, lost=None, **options):
        file = tmp_path / "study.yaml"
        file.write_text(text)
        study, root = load_study(file, **options), tmp_path / "results"
        root.mkdir()
        jobs, lost = study.jobs(), lost or {}
        store.store_scans(root, [job.case for job in jobs])
        store.write_plan(root, study, jobs)
        done = [(job, record(job.case)) for number, job in enumerate(jobs) if number not in lost]
        store.write_units(root, done, {})
        for number, status in lost.items():
            if status == "failed":
                store.Failure(jobs[number].id, "the ring left", "shorten the step").write(root)
        return store.open_results(root)

    return make


def only(sheets):
    [(name, canvas)] = sheets
    return name, canvas


def lines(ax):
    """Curves of axes by x and y, without markers of lost jobs and levels of the healthy bearing."""
    curves = [line for line in ax.lines if line.get_gid() != "healthy"]
    return [line for line in curves if line.get_marker() not in ("x", "|") or len(line.get_xdata()) > 2]


def text_of(canvas):
    return [entry.get_text() for entry in canvas.legends[0].get_texts()]


def test_columns_are_features_rows_panels_and_curves_values(results):
    name, canvas = only(drawn(results()))
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
    _, canvas = only(drawn(results()))
    low, high = lines(canvas.axes[0])
    assert list(low.get_xdata()) == pytest.approx([3.0, 6.0, 9.0])
    assert list(low.get_ydata()) == pytest.approx([7.0, 13.0, 19.0])  # um/s
    assert list(high.get_ydata()) == pytest.approx([8.0, 14.0, 20.0])
    assert canvas.axes[2].get_xlabel() == "Defect length (mm)"
    assert " ".join(canvas.axes[0].get_ylabel().split()) == "Velocity amplitude at BPFO (µm/s, 0-peak)"
    assert canvas.axes[0].get_ylim()[0] == 0.0


def test_change_from_healthy_is_complex_difference(results):
    _, canvas = only(drawn(results()))
    first = lines(canvas.axes[1])[0].get_ydata()[0]
    assert first == pytest.approx(abs(7.0 * np.exp(-0.5j) - 0.5))


def test_healthy_cases_are_no_points(results):
    opened = results()
    assert len(select.case_rows(opened)) == 12
    assert len(opened.table()) == 16


def test_unassigned_swept_parameter_becomes_curves(results):
    text = STUDY + "figures: [{y: velocity@BPFO, x: defect.length, by: load}]\n"
    _, canvas = only(drawn(results(text)))
    assert len(lines(canvas.axes[0])) == 4
    assert text_of(canvas) == ["load 150 N", "load 300 N", "model static", "model ring", "healthy"]


def test_parameter_zipped_with_x_makes_no_curves(results):
    text = STUDY.replace(
        "  defect.length: [3 mm, 6 mm, 9 mm]\n",
        "  zip: {defect.length: [3 mm, 6 mm, 9 mm], defect.width: [0.3 mm, 0.6 mm, 0.9 mm]}\n",
    )
    sheets = drawn(results(text), x="defect.length", by=["load", "model"])
    assert len(lines(only(sheets)[1].axes[0])) == 4


def test_where_selects_rows(results):
    text = STUDY + "figures: [{y: velocity@BPFO, x: defect.length, where: {load: 0.3 kN, model: ring}}]\n"
    _, canvas = only(drawn(results(text)))
    [line] = lines(canvas.axes[0])
    assert list(line.get_ydata()) == pytest.approx([8.0, 14.0, 20.0])


def test_failed_and_missing_jobs_are_marked_at_their_x(results):
    _, canvas = only(drawn(results(lost={0: "failed", 11: "missing"})))
    failed = [line for line in canvas.axes[0].lines if line.get_marker() == "x"]
    missing = [line for line in canvas.axes[2].lines if line.get_marker() == "|"]
    assert [list(line.get_xdata()) for line in failed] == [[3.0]]
    assert [list(line.get_xdata()) for line in missing] == [[9.0]]
    assert text_of(canvas)[-2:] == ["failed", "not computed"]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("status", "reason"), [("failed", ": 16 failed, one for this: the ring left"), ("missing", "$")]
)
def test_figure_without_finished_job_gives_the_reason(results, kind, status, reason):
    opened = results(STUDY, lost=dict.fromkeys(range(16), status))  # 12 cases, 4 healthy cases
    with pytest.raises(PlotError, match=f"no job is done, so there is nothing to draw{reason}"):
        drawn(opened, kind=kind)


def test_chaotic_results_are_ringed_and_explained_in_legend(results):
    stored = results()
    assert "chaotic, uncertain" not in text_of(only(drawn(stored))[1])
    table = stored.table()
    table["chaotic"] = 0.0
    table["rms_scatter"] = 1.0
    for name in (name for name in table if "@" in name and f"{name}.phase" in table):
        table[f"{name}-scatter"] = table[name]
    table.loc[(table["defect.length"] == 6e-3) & (table["load"] == 300.0), "chaotic"] = 1.0
    with mock.patch.object(type(stored), "table", return_value=table):
        _, canvas = only(drawn(stored))
    rings = [line for ax in canvas.axes for line in ax.lines if line.get_markersize() == axes.RING["ms"]]
    assert len(rings) == 4  # two features, two models
    assert {tuple(ring.get_xdata()) for ring in rings} == {(6.0,)}
    assert text_of(canvas)[-1] == "chaotic, uncertain"


@pytest.mark.parametrize(("total", "is_drawn"), [(math.nan, 0.04), (0.04, 0.04), (0.2, 0.2)])  # 0.2: by an audit
def test_error_bars_and_model_marks_of_study_with_accuracy(results, total, is_drawn):
    stored = results()
    table = stored.table()
    errors = {**dict.fromkeys(store.ERROR_PARTS, 0.0), "error.model": 0.03, "error.step": 0.01, "error": total}
    for name, share in errors.items():
        table[name] = share
    table["model"] = "planar"
    table.loc[table["defect.length"] == 6e-3, "model"] = "rollers"
    with mock.patch.object(type(stored), "table", return_value=table):
        _, canvas = only(drawn(stored, panels=["load"], by=[]))
    ax = canvas.axes[0]
    (bars,) = [collection for collection in ax.collections if len(collection.get_segments()) > 1]
    lengths = [abs(b[1] - a[1]) for a, b in bars.get_segments()]
    assert lengths == pytest.approx([2 * is_drawn * max(ax.lines[0].get_ydata())] * len(lengths))
    assert text_of(canvas)[-2:] == ["planar", "rollers"]
    marks = [line for line in ax.lines if line.get_markersize() == axes.MODEL_MARK["ms"]]
    positions = {line.get_marker(): set(line.get_xdata()) for line in marks}
    assert positions == {"o": {3.0, 9.0}, "s": {6.0}}


def test_caption_gives_parameters_of_law(results):
    law = "contact: {damping: {law: general, coefficient: 1e4, indentation_exponent: 1.5}}\n"
    _, canvas = only(drawn(results(STUDY + law + FIGURES)))
    caption = canvas.get_supxlabel().replace("\u00a0", " ").replace("\n", " ")
    assert "damping general, coefficient 10000, m2 1, m3 1.5" in caption


def test_study_without_figures_has_one_per_swept_number(results):
    sheets = drawn(results(STUDY))
    assert [name for name, _ in sheets] == ["fig1-velocity-bpfo-vs-defect-length", "fig2-velocity-bpfo-vs-load"]


def test_too_many_curves_become_panels(results):
    text = STUDY.replace("[150 N, 300 N]", "{linspace: [100 N, 300 N, 6]}")
    _, canvas = drawn(results(text))[0]
    assert len(canvas.axes) == 4  # two models, two features
    assert len(lines(canvas.axes[0])) == 6


def test_parameter_zipped_with_x_makes_no_panels(results):
    zipped = "zip: {load: [1 N, 2 N, 3 N, 4 N, 5 N], defect.width: [1 mm, 2 mm, 3 mm, 4 mm, 5 mm]}"
    text = STUDY.replace("load: [150 N, 300 N]", zipped)
    _, canvas = only(drawn(results(text), x="load"))
    assert len(canvas.axes) == 2
    assert len(lines(canvas.axes[0])) == 6


def test_options_change_figure_of_study(results):
    opened = results()
    _, canvas = only(drawn(opened, y=["velocity.rms"], panels=["load"], where={"model": "ring"}))
    assert [ax.get_title(loc="left") for ax in canvas.axes] == ["(a) load 150 N", "(b) load 300 N"]
    assert [len(lines(ax)) for ax in canvas.axes] == [1, 1]
    _, canvas = only(drawn(opened, by=["model"], y=["velocity.rms"]))
    assert text_of(canvas) == ["model static", "model ring", "load 150 N", "load 300 N", "healthy"]


def test_undrawable_figure_is_skipped_with_warning(results):
    text = STUDY + FIGURES + "  - {y: velocity@BPFO, x: load, where: {model: rollers}}\n"
    opened = results(text)
    with pytest.warns(PlotWarning, match="figure 2 left out: no case has model rollers"):
        assert len(drawn(opened)) == 1
    with pytest.raises(PlotError, match="no case has load 1 N"):
        drawn(opened, where={"load": "1 N"})


def test_figure_over_fixed_x_is_replaced(results):
    sheets = drawn(results(overrides={"defect.length": "6 mm"}))
    assert [name for name, _ in sheets] == ["fig1-velocity-bpfo-vs-load"]


def test_words_are_ticks_in_order_of_study(results):
    _, canvas = only(drawn(results(STUDY), x="model"))
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
        drawn(results(), **options)


def test_study_without_sweep_is_refused(results):
    with pytest.raises(PlotError, match="sweeps no parameter"):
        drawn(results(STUDY, overrides={"defect.length": "3 mm", "load": "150 N", "model": "ring"}))


def test_caption_gives_fixed_but_not_drawn_parameters(results):
    _, canvas = only(drawn(results()))
    caption = canvas.get_supxlabel().replace("\u00a0", " ").replace("\n", " ")
    assert "circular defect, width 0.8 mm, depth 0.05 mm" in caption
    assert "clearance 5 µm" in caption
    assert "1800 rpm" in caption
    assert "length 3" not in caption
    assert "model" not in caption


def test_caption_omits_drawn_parameters_if_one_job_is_finished(results):
    _, canvas = only(drawn(results(lost=dict.fromkeys(range(1, 12), "missing"))))
    assert not {"length", "load", "model"} & set(canvas.get_supxlabel().replace("\u00a0", " ").split())


def test_long_legend_does_not_shrink_axes(results):
    text = STUDY.replace("[static, ring]", "[ring]").replace(
        "  load", "  contact.damping.chi: [1 s/m, 2 s/m]\n  load"
    )
    _, canvas = only(drawn(results(text), x="defect.length"))
    canvas.draw_without_rendering()
    assert min(ax.get_window_extent().width / canvas.dpi for ax in canvas.axes) > 2.3


def test_log_option_sets_log_axes(results):
    text = STUDY + "figures: [{y: velocity@BPFO, x: defect.length, log: [x, y]}]\n"
    _, canvas = only(drawn(results(text)))
    assert (canvas.axes[0].get_xscale(), canvas.axes[0].get_yscale()) == ("log", "log")


def test_panels_of_equal_magnitude_share_axis(results):
    _, canvas = only(drawn(results(), panels=["load"], by=["model"], y=["velocity@BPFO"]))
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


def test_axes_and_legend_fit_on_the_sheet(results):
    _, canvas = only(drawn(results(lost={0: "failed"})))
    canvas.draw_without_rendering()
    sheet = canvas.bbox.padded(1.0)
    boxes = [ax.get_tightbbox() for ax in canvas.axes] + [canvas.legends[0].get_window_extent()]
    assert all(sheet.x0 <= b.x0 and b.x1 <= sheet.x1 and sheet.y0 <= b.y0 and b.y1 <= sheet.y1 for b in boxes)


@pytest.mark.parametrize(
    ("first", "second", "ordered"), [(3, 1, False), (2, 3, False), (9, 1, True), (5, 2, True)]
)
def test_curve_styles_are_distinct_in_grey(first, second, ordered):
    table = [look for row in style.curve_styles(first, second, ordered) for look in row]
    assert len({(look.marker, look.filled, str(look.line)) for look in table}) == first * second
    assert len({look.colour for look in table}) == first


def test_shades_become_lighter():
    shades = [sum(to_rgb(row[0].colour)) for row in style.curve_styles(9, 1, True)]
    assert shades == sorted(shades)


@pytest.mark.parametrize(
    ("name", "largest", "unit", "factor"),
    [
        ("velocity@BPFO", 9.1e-6, "µm/s", 1e6),
        ("velocity.rms", 2.5e-3, "mm/s", 1e3),
        ("velocity.rms", 0.0, "µm/s", 1e6),
        ("displacement.rms", 4e-8, "nm", 1e9),
        ("acceleration.peak", 12.0, "m/s²", 1.0),
        ("outer_force.max", 434.0, "N", 1.0),
        ("velocity@BPFO.phase", 1.0, "°", 180.0 / math.pi),
        ("velocity.kurtosis", 30.0, "", 1.0),
        ("cage.slip.mean", 0.003, "%", 100.0),
        ("load_zone.extent", 2.0, "°", 180.0 / math.pi),
        ("seconds", 0.02, "ms", 1e3),
        ("seconds", 20.0, "s", 1.0),
    ],
)
def test_units_follow_the_magnitude(name, largest, unit, factor):
    assert labels.feature_axis(name, largest) == (unit, pytest.approx(factor))


def test_text_of_swept_value():
    swept = {"defect.shape": "circular", "defect.width": 0.0008, "defects.2.angle": math.pi / 6.0, "load": 150.0}
    text = labels.described(swept, {"defect.width": "um", "defects.2.angle": "deg"})
    assert text == "circular, width 800 µm, defect 2 angle 30°, load 150 N"


@pytest.mark.parametrize(
    ("path", "value", "text"),
    [
        ("rig.load", "{by: point}", "load path point"),
        ("rig.load", "{by: pads, angles: [-45 deg, 45 deg]}", "load path pads (angles -45° and 45°)"),
        (
            "rig.load",
            "{by: housing, stiffness: 1e10 N/m/m, fit: -10 um}",
            "load path housing (stiffness 1e10 N/m², fit -10 µm)",
        ),
        ("contact.damping", "{indentation_exponent: 0, law: general}", "damping general (indentation exponent 0)"),
        ("contact.damping", "{law: film, oil: VG 68}", "damping film (oil VG 68)"),
        ("rig.ring.bends", "false", "ring bending off"),
        ("contact.damping.beta", 1e-5, "damping time c/k 10 µs"),
        ("defect.length", "none", ""),
        ("friction", "none", "friction none"),
        ("defect.file", "{a: b: c}", "file a: b: c"),
        ("tolerance", 1e-5, "tolerance 1e-5"),
    ],
)
def test_text_of_swept_option_is_readable(path, value, text):
    assert labels.described({path: value}, {"contact.damping.beta": "us"}) == text


# Phase, series, spectrum


def test_phase_of_change_follows_defect_angle(results):
    text = STUDY.replace(
        "  defect.length: [3 mm, 6 mm, 9 mm]\n", "  defect.angle: {range: [0 deg, 60 deg, 5 deg]}\n"
    )
    _, canvas = only(drawn(results(text), kind="phase", x="defect.angle"))
    assert canvas.axes[0].get_ylabel() == "Velocity phase at BPFO (°)"
    x, y = (np.asarray(data) for data in lines(canvas.axes[1])[0].get_data())
    line, healthy = 7.0 * np.exp(1j * (-13.0 * np.radians(x) - 0.5)), 0.5
    expected = np.degrees(np.angle(line - healthy))
    is_finite = ~np.isnan(x)
    assert y[is_finite] == pytest.approx(expected[is_finite])
    assert np.isnan(x).sum() >= 1  # broken where the phase wraps
    assert np.nanmax(np.abs(np.diff(y))) <= 180.0


def test_spectrum_of_sine_peaks_at_its_amplitude():
    time = np.arange(5000) / 10240.0
    wave = 3e-6 * np.sin(2.0 * math.pi * BPFO * time) + 1.0
    frequency, height = signals.spectrum(*whole_periods(Signal(time, wave), BPFO))
    peak = height.argmax()
    assert frequency[peak] == pytest.approx(BPFO, abs=1e-2)
    assert height[peak] == pytest.approx(3e-6, rel=1e-3)
    assert height[0] < 1e-9


def test_spectrum_peaks_at_mark_of_bpfo(results):
    opened = results()
    name, canvas = only(drawn(opened, kind="spectrum", jobs=[opened.jobs[0]]))
    [ax] = canvas.axes
    curve = next(line for line in ax.lines if line.get_label() == "with defect")
    peak = np.argmax(curve.get_ydata())
    marks = [line.get_xdata()[0] for line in ax.lines if len(line.get_xdata()) == 2]
    assert name == f"spectrum-{opened.jobs[0][:8]}"
    assert marks == pytest.approx([BPFO * k for k in range(1, 13)])
    assert curve.get_xdata()[peak] == pytest.approx(BPFO, abs=0.1)
    assert curve.get_ydata()[peak] == pytest.approx(7.0, rel=1e-3)


def test_series_shows_first_passes_with_healthy_case(results):
    opened = results()
    _, canvas = only(drawn(opened, kind="series", jobs=opened.jobs[:2]))
    assert len(canvas.axes) == 2
    assert [line.get_label() for line in canvas.axes[0].lines] == ["with defect", "healthy"]
    assert canvas.axes[0].lines[0].get_xdata()[-1] == pytest.approx(1e3 * 8 / BPFO, rel=2e-3)
    assert canvas.axes[0].get_title(loc="left") == "length 3 mm, load 150 N, model static"


def test_series_without_named_jobs_shows_three(results):
    _, canvas = only(drawn(results(), kind="series"))
    assert len(canvas.axes) == 3


def test_series_is_along_sensor_angle(results):
    text = STUDY + "rig: {sensor_angle: 60 deg}\n"
    opened = results(text)
    _, canvas = only(drawn(opened, kind="series", jobs=opened.jobs[:1]))
    assert max(canvas.axes[0].lines[0].get_ydata()) == pytest.approx(3.5, rel=1e-3)


def test_series_of_study_without_record_is_refused(results):
    opened = results(STUDY + "record: []\n")
    with pytest.raises(PlotError, match="did not record any channel: add one to `record`"):
        drawn(opened, kind="series", jobs=opened.jobs[:1])


def test_caption_gives_misalignment_and_roller_profile(results):
    text = STUDY.replace("[static, ring]", "[spatial]") + "misalignment: {inner: 0.2 mrad}\n"
    sheets = drawn(results(text, overrides={"bearing.roller_profile": "logarithmic"}), x="load")
    caption = only(sheets)[1].get_supxlabel().replace("\u00a0", " ").replace("\n", " ")
    assert "inner ring misaligned by 0.2 mrad, roller profile logarithmic" in caption
    assert "outer ring" not in caption
