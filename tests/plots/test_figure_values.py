"""Limits, levels, scales and marks of figures of signals; figures that a study names."""

import math
import re

import numpy as np
import pytest

from bearingsim.figure_kinds import View, parse_limits, parse_view
from bearingsim.plots.labels import PlotError
from bearingsim.plots.passage import passages
from bearingsim.plots.plot import draw_figures
from bearingsim.plots.recorded import case_of, load_jobs
from bearingsim.plots.window import passage_of
from bearingsim.study import StudyError, restore_figure
from tests.scenes.figure_results import long_curves, only, results, text_of
from tests.scenes.signal_results import STUDY, make_results, record_of

__all__ = ["make_results", "results"]


def test_limits_share_a_unit():
    assert parse_limits("0..2 kHz", "frequency") == (0.0, 2000.0)
    assert parse_limits("500 Hz .. 2 kHz", "frequency") == (500.0, 2000.0)
    assert parse_limits("-5..5 deg", "angle") == pytest.approx((-math.radians(5.0), math.radians(5.0)))


def test_level_is_relative_to_the_reference_value_of_iso_1683(make_results):
    """1 m/s2 is 120 dB over 1 um/s2 (ISO 1683)."""
    _, canvas = only(
        draw_figures(make_results(), kind="spectrum", db=True, where={"load": "150 N", "defect.length": "3 mm"})
    )
    damaged, healthy = long_curves(canvas.axes[0])
    assert max(damaged.get_ydata()) == pytest.approx(120.0, abs=0.1)
    assert max(healthy.get_ydata()) == pytest.approx(120.0 - 20.0 * math.log10(2.0), abs=0.1)


def test_healthy_curve_is_thinner_and_drawn_on_top(make_results):
    _, canvas = only(
        draw_figures(make_results(), kind="spectrum", where={"load": "150 N", "defect.length": "3 mm"})
    )
    damaged, healthy = long_curves(canvas.axes[0])
    assert healthy.get_zorder() > damaged.get_zorder()
    assert healthy.get_linewidth() < damaged.get_linewidth()


@pytest.mark.parametrize(
    ("kind", "db"), [("series", False), ("spectrum", False), ("spectrum", True), ("envelope", True)]
)
def test_damaged_and_healthy_panels_have_equal_scales(make_results, monkeypatch, kind, db):
    def quiet(case):
        result = record_of(case)
        result.series = {name: values * (1.0 if case.defects else 1e-3) for name, values in result.series.items()}
        return result

    stored = make_results()
    monkeypatch.setattr("tests.scenes.figure_results.record", quiet)
    stored.path.rename(stored.path.with_name("first"))
    where = {"load": "150 N", "defect.length": "3 mm"}
    _, canvas = only(draw_figures(make_results(), kind=kind, db=db, healthy="below", where=where))
    damaged, healthy = canvas.axes
    assert damaged.get_ylim() == healthy.get_ylim()
    low, high = damaged.get_ylim()
    assert low < max(damaged.lines[0].get_ydata()) <= high
    assert not db or high - low <= 110.0


def test_labels_of_rows_do_not_overlap(make_results):
    _, canvas = only(
        draw_figures(
            make_results(),
            kind="spectrum",
            y=["ring.acceleration", "ring.acceleration.y"],
            where={"load": "150 N"},
        )
    )
    canvas.draw_without_rendering()
    boxes = [ax.yaxis.label.get_window_extent() for ax in canvas.axes]
    assert len(boxes) == 6
    assert not [box for n, box in enumerate(boxes) if any(box.overlaps(other) for other in boxes[:n])]


def test_marks_show_their_frequency_and_do_not_overlap(make_results):
    stored = make_results()
    where = {"load": "150 N", "defect.length": "3 mm"}
    _, near = only(draw_figures(stored, kind="spectrum", where=where, range="0..500 Hz"))
    names = [text.get_text() for text in near.axes[0].texts]
    assert names == ["BPFO 159.0 Hz", "2 BPFO 318.0 Hz", "3 BPFO 477.0 Hz"]
    _, far = only(draw_figures(stored, kind="spectrum", where=where, range="0..20 kHz"))
    assert 1 < len(far.axes[0].texts) < 15
    assert len(far.axes[0].lines) < 60


def at_two_speeds(make_results):
    return make_results(STUDY.replace("load: [150 N, 300 N]", "speed: [1800 rpm, 900 rpm]"))


@pytest.mark.parametrize("kind", ["spectrum", "envelope"])
def test_marks_at_another_speed_are_named_again(make_results, kind):
    """BPFO is proportional to the speed; rows of equal speed share the names above the first."""
    stored = at_two_speeds(make_results)
    _, canvas = only(draw_figures(stored, kind=kind, y=["ring.acceleration"], jobs=["all"], range="0..500 Hz"))
    names = [[text.get_text() for text in ax.texts][:1] for ax in canvas.axes]
    assert names == [["BPFO 159.0 Hz"], ["BPFO 79.5 Hz"]] * 3
    caption = " ".join(canvas.get_supxlabel().replace("\N{NO-BREAK SPACE}", " ").split())
    assert caption.count("Hann window") == 1


def test_marks_of_a_waterfall_at_another_speed_are_named_again(make_results):
    _, canvas = only(draw_figures(at_two_speeds(make_results), kind="waterfall", by=["defect.length"]))
    assert {ax.texts[0].get_text() for ax in canvas.axes} == {"BPFO 159.0 Hz", "BPFO 79.5 Hz"}


def test_series_at_two_speeds_end_together(make_results):
    """Eight ball passes of the slower job: 8/79.5 s exceeds the record of 100 ms."""
    stored = at_two_speeds(make_results)
    _, canvas = only(draw_figures(stored, kind="series", y=["ring.acceleration"], jobs=["all"]))
    ends = [line.get_xdata()[-1] for ax in canvas.axes for line in ax.lines]
    assert ends == pytest.approx([100.0] * 12, abs=0.05)  # ms


@pytest.mark.parametrize("kind", ["series", "roller", "spectrum", "spectrogram"])
def test_caption_says_that_contact_forces_have_no_low_pass(make_results, kind):
    _, canvas = only(draw_figures(make_results(), kind=kind, y=["roller.1.outer_force"]))
    caption = " ".join(canvas.get_supxlabel().replace("\N{NO-BREAK SPACE}", " ").split())
    assert "sampled at 51.2 kHz (without a low-pass)" in caption
    assert "flat to" not in caption
    assert ("between which the table may have larger ones" in caption) == (kind in ("series", "roller"))


def test_caption_of_a_force_and_an_acceleration_names_both_bands(make_results):
    _, canvas = only(draw_figures(make_results(), kind="series", y=["ring.acceleration", "roller.1.outer_force"]))
    caption = " ".join(canvas.get_supxlabel().replace("\N{NO-BREAK SPACE}", " ").split())
    assert "sampled at 51.2 kHz (flat to 20.5 kHz; contact forces without a low-pass)" in caption
    assert "drawn through a low-pass" in caption


def test_impact_is_passage_of_roller_over_defect(make_results):
    """Roller 1 starts at -0.2 rad and passes the defect at 0 rad at the speed of the cage."""
    _, canvas = only(
        draw_figures(
            make_results(), kind="roller", around="impact", where={"load": "150 N", "defect.length": "3 mm"}
        )
    )
    low, high = canvas.axes[0].get_xlim()
    assert low < 0.0 < high
    assert high - low == pytest.approx(math.degrees(4.5 * 0.8 / 38.5), rel=0.01)


@pytest.mark.parametrize(("where", "count"), [({"defect.length": "3 mm"}, 1), ({}, 0)])
def test_caption_explains_the_grey_band_if_it_is_drawn(make_results, where, count):
    """Of jobs whose contacts are over their defects at different times no band is drawn."""
    text = STUDY.replace("defect.length: [3 mm, 6 mm, 9 mm]", "defect.width: [0.8 mm, 2 mm]")
    where = {"load": "150 N", "defect.width": "2 mm"} if where else {"load": "150 N"}
    [(_, canvas)] = draw_figures(
        make_results(text), kind="series", by=["defect.width"], around="impact", where=where
    )
    assert all(len(ax.patches) == count for ax in canvas.axes)
    assert ("grey" in canvas.get_supxlabel()) == bool(count)


@pytest.mark.parametrize(("race", "sense"), [("outer", 1.0), ("inner", -1.0)])
def test_grey_band_of_a_growing_spall_lies_where_the_contact_crosses_it(make_results, race, sense):
    """It begins at the edge that rollers meet first; on the inner race they move towards -s."""
    shape = f"race: {race}, shape: spall, grown: 30 %"
    stored = make_results(STUDY.replace("race: outer, shape: circular", shape) + "settle: 0 ms\n")
    name = stored.jobs[0]
    job = load_jobs(stored, [name])[name]
    passage = passage_of(stored, name, job, "ring.acceleration")
    low, high = passage.defect.s
    assert abs(low + high) > 0.2 * (high - low)
    ends = sorted(passage.time + sense * s / passage.speed for s in (low, high))
    assert passage.crossing == pytest.approx(ends)


def test_passage_of_a_rotating_defect_is_the_most_loaded(make_results):
    """The defect meets a roller at any angle to the load; the figure shows the one nearest the load line."""
    stored = make_results(STUDY.replace("race: outer", "race: inner") + "settle: 0 ms\n")
    name = stored.jobs[0]
    job = load_jobs(stored, [name])[name]
    case = case_of(stored, name, job.parameters)
    passage = passage_of(stored, name, job, "ring.acceleration", 4e-3)
    every = [p for number in range(1, 13) for p in passages(job, case, number, "")]
    assert len(every) > 10
    shown = [p for p in every if 1e-3 <= p.time <= job.series.time[-1] - 3e-3]
    assert passage in shown
    assert math.cos(passage.angle) == max(math.cos(p.angle) for p in shown)
    assert math.cos(min(every, key=lambda p: p.time).angle) < math.cos(passage.angle)


def test_a_sweep_shows_the_level_of_the_healthy_bearing(make_results):
    stored = make_results()
    _, canvas = only(draw_figures(stored, x="defect.length", y=["velocity@BPFO"]))
    [level] = [line for line in canvas.axes[0].lines if line.get_gid() == "healthy"]
    assert list(level.get_ydata()) == [0.5] * 3
    assert text_of(canvas)[-1] == "healthy"
    _, without = only(draw_figures(stored, x="defect.length", y=["velocity@BPFO"], healthy="off"))
    assert not [line for line in without.axes[0].lines if line.get_gid() == "healthy"]
    _, change = only(draw_figures(stored, x="defect.length", y=["velocity@BPFO-healthy"]))
    assert not [line for line in change.axes[0].lines if line.get_gid() == "healthy"]


def test_rounding_errors_are_labelled_as_zero(make_results, monkeypatch):
    def tiny(case):
        result = record_of(case)
        result.features["velocity@BPFO"] = 1e-14
        return result

    stored = make_results()
    _, canvas = only(draw_figures(stored, x="load", y=["velocity@BPFO"]))
    assert not canvas.axes[0].texts
    monkeypatch.setattr("tests.scenes.figure_results.record", tiny)
    stored.path.rename(stored.path.with_name("first"))
    _, canvas = only(draw_figures(make_results(), x="load", y=["velocity@BPFO"]))
    assert [text.get_text() for text in canvas.axes[0].texts] == ["zero within numerical errors"]


SIGNALS = """\
figures:
  - {y: velocity@BPFO, x: load}
  - {kind: spectrum, y: ring.acceleration, range: 0 Hz..2 kHz, db: true, by: load, where: {defect.length: 3 mm}}
  - {kind: series, around: impact, mean: 0, healthy: off, where: {load: 150 N}}
"""


def test_a_study_names_figures_of_signals(make_results):
    sheets = draw_figures(make_results(STUDY + SIGNALS))
    assert [name.split("-")[0] for name, _ in sheets] == ["fig1", "fig2", "fig3"]
    _, spectrum, series = (canvas for _, canvas in sheets)
    assert spectrum.axes[0].get_xlim() == (0.0, 2000.0)
    assert len(spectrum.axes) == 1
    assert len(series.axes) == 3
    assert series.axes[-1].get_xlabel() == "Time from the centre of the defect (ms)"


def test_options_of_the_command_replace_those_of_the_study(make_results):
    stored = make_results(STUDY + "figures: [{y: velocity@BPFO, x: load, healthy: off}]\n")
    _, canvas = only(draw_figures(stored, healthy="beside"))
    assert [line for line in canvas.axes[0].lines if line.get_gid() == "healthy"]
    assert not stored.plan["figures"][0]["view"]["db"]


@pytest.mark.parametrize(
    ("figure", "message"),
    [
        ("{kind: spectrun, y: ring.acceleration}", r"no kind of figure `spectrun`.*did you mean `spectrum`"),
        ("{kind: spectrum, y: ring.acceleration, range: 1 kHz}", r"figures.range: expected two limits"),
        ("{kind: spectrum, y: ring.acceleration, band: 0..1 kHz}", r"figures.band: a spectrum has no option"),
        ("{kind: spectrum, y: ring.acceleration, x: load}", r"figures.x: a spectrum has no option `x`"),
        ("{kind: spectrum, y: ring.velocity}", r"the channel `ring.velocity` is not recorded.*add it to `record`"),
        ("{kind: spectrum, y: ring.acelleration}", r"no channel `ring.acelleration`.*did you mean"),
        ("{y: velocity@BPFO, x: load, range: 0..1 kHz}", r"figures.range: a sweep has no option `range`"),
    ],
)
def test_invalid_figure_of_a_study_is_refused_at_its_position(make_results, figure, message):
    with pytest.raises(StudyError) as caught:
        make_results(f"{STUDY}figures:\n  - {figure}\n")
    text = " ".join(str(caught.value).split())
    assert re.search(message, text), text
    assert "^" in str(caught.value)


def test_figures_of_plans_without_kind_are_sweeps():
    entry = {"y": ["velocity@BPFO"], "x": "load", "by": [], "panels": [], "where": {}, "title": None, "log": []}
    figure = restore_figure(entry)
    assert (figure.kind, figure.view) == ("sweep", View())
    assert figure.features == ("velocity@BPFO",)


def test_a_stored_view_is_restored():
    view = parse_view("spectrum", {"range": "0..2 kHz", "db": "true", "from": "1 ms"})
    entry = {"y": [], "x": "", "by": [], "panels": [], "where": {}, "title": None, "log": [], "kind": "spectrum",
             "view": {"range": [0.0, 2000.0], "db": True, "start": 1e-3, "of a later version": 1}}  # fmt: skip
    assert restore_figure(entry).view == view


def marks_of(ax):
    """Positions of the vertical lines in axes."""
    return [float(line.get_xdata()[0]) for line in ax.lines if len(line.get_xdata()) == 2]


@pytest.mark.parametrize("limits", [(-60.0, 60.0), (-180.0, 180.0), (80.0, 200.0)])
def test_angles_of_a_roller_and_its_defect_are_within_the_range(make_results, limits):
    """The range is that of the axis also if ticks at 90 deg lie beyond it; 250 deg is -110 deg."""
    stored = make_results(STUDY.replace("angle: 0 deg", "angle: 250 deg"))
    low, high = limits
    where = {"load": "150 N", "defect.length": "3 mm"}
    _, canvas = only(draw_figures(stored, kind="roller", range=f"{low} deg..{high} deg", where=where))
    [ax] = canvas.axes
    assert ax.get_xlim() == pytest.approx(limits)
    assert [mark for mark in marks_of(ax) if low <= mark <= high] == pytest.approx(
        [-110.0] if low < -110.0 else []
    )
    angles = long_curves(ax)[0].get_xdata()
    assert np.nanmin(angles) == pytest.approx(low, abs=0.5)
    assert np.nanmax(angles) == pytest.approx(high, abs=0.5)


def test_passage_over_a_defect_opposite_the_load_is_complete(make_results):
    stored = make_results(STUDY.replace("angle: 0 deg", "angle: 180 deg"))
    where = {"load": "150 N", "defect.length": "3 mm"}
    _, canvas = only(draw_figures(stored, kind="roller", around="impact", where=where))
    [ax] = canvas.axes
    low, high = ax.get_xlim()
    [mark] = marks_of(ax)
    angles = long_curves(ax)[0].get_xdata()
    assert low < mark < high
    assert mark % 360.0 == pytest.approx(180.0)
    assert (angles[0] - low, high - angles[-1]) == pytest.approx((0.0, 0.0), abs=0.3)


def test_spectra_over_a_tied_parameter_are_stacked(make_results):
    text = STUDY.partition("sweep:")[0]
    text += "sweep: {zip: {defect.length: [3 mm, 6 mm, 9 mm], load: [150 N, 200 N, 250 N]}}\n"
    _, canvas = only(draw_figures(make_results(text), kind="waterfall", by=["load"]))
    [ax] = canvas.axes
    assert [label.get_text() for label in ax.get_yticklabels()] == ["150 N", "200 N", "250 N"]
    caption = " ".join(canvas.get_supxlabel().split())  # x is the frequency
    assert "defect length varies with load: 3 to 9 mm" in caption


def test_curves_over_a_tied_parameter_share_a_row(make_results):
    """Length and width vary together, so jobs of another length are not in another row for their width."""
    head = STUDY.partition("sweep:")[0]
    zipped = "zip: {defect.length: [3 mm, 6 mm], defect.width: [1 mm, 2 mm]}"
    stored = make_results(f"{head}sweep: {{{zipped}, load: [150 N, 200 N]}}\n")
    _, canvas = only(draw_figures(stored, kind="series", by=["defect.length"], jobs=["all"]))
    assert [ax.get_title(loc="left") for ax in canvas.axes] == ["load 150 N", "load 200 N"]
    assert text_of(canvas) == ["length 3 mm, width 1 mm", "length 6 mm, width 2 mm"]


def test_jobs_of_a_design_have_rows_of_their_own(make_results):
    """Each of its values occurs once, which ties no other parameter to it."""
    head = STUDY.partition("sweep:")[0]
    over = "{load: [150 N, 200 N], defect.length: [3 mm, 6 mm]}"
    stored = make_results(f"{head}sweep: {{lhs: {{n: 3, over: {over}}}}}\n")
    _, canvas = only(draw_figures(stored, kind="series", by=["load"], jobs=["all"]))
    assert len(canvas.axes) == 3


def waterfall_at_levels(make_results, monkeypatch, levels):
    """Draw in dB the spectra of three lengths, whose amplitudes have these levels (dB), by length (m)."""

    def at_level(case):
        result = record_of(case)
        factor = 10.0 ** (levels.get(case.defects[0].length if case.defects else 0.0, 0.0) / 20.0)
        result.series = {name: factor * values for name, values in result.series.items()}
        return result

    monkeypatch.setattr("tests.scenes.figure_results.record", at_level)
    text = STUDY.replace("  load: [150 N, 300 N]\n", "")
    _, canvas = only(draw_figures(make_results(text), kind="waterfall", db=True))
    return canvas


@pytest.mark.parametrize("change", [-60.0, -20.0, 20.0])
def test_label_of_a_waterfall_of_levels_is_at_the_median_of_its_curve(make_results, monkeypatch, change):
    """Medians rise by 25 dB or more, and a curve spans at most two offsets."""
    canvas = waterfall_at_levels(make_results, monkeypatch, {6e-3: change, 9e-3: 2.0 * change})
    [ax] = canvas.axes
    height = max(np.ptp(curve.get_ydata()) for curve in long_curves(ax))
    offset = np.ceil(max(0.5 * height, 25.0 - min(change, 0.0)))
    assert [label.get_text() for label in ax.get_yticklabels()] == ["3 mm", "6 mm", "9 mm"]
    medians = [np.median(curve.get_ydata()) for curve in long_curves(ax)]
    assert list(ax.get_yticks()) == pytest.approx(medians)
    assert np.diff(medians) == pytest.approx([offset + change] * 2, abs=0.01)
    assert min(min(curve.get_ydata()) for curve in long_curves(ax)) == pytest.approx(0.0)
    assert f"curves offset by {offset:g} dB" in " ".join(canvas.get_supxlabel().split())


def test_too_few_spectra_are_refused_before_they_are_computed(make_results, monkeypatch):
    monkeypatch.setattr("bearingsim.plots.waterfall.compute_spectrum", lambda *_: pytest.fail("computed"))
    with pytest.raises(PlotError, match="a waterfall needs 3 spectra or more over `load`"):
        draw_figures(make_results(), kind="waterfall", by=["load"])


def test_caption_has_the_segments_of_all_speeds(make_results):
    """A ball pass takes 1/79.5 s and 1/159 s; a segment is an eighth of it."""
    stored = make_results(STUDY.replace("load: [150 N, 300 N]", "speed: [900 rpm, 1800 rpm]"))
    _, canvas = only(draw_figures(stored, kind="spectrogram", where={"defect.length": "3 mm"}))
    assert " ".join(canvas.get_supxlabel().split()).startswith("Hann segments of 0.79 to 1.6 ms, 87.5 % overlap")


@pytest.mark.parametrize("mean", [0, 0.0, "0"])
def test_mean_is_subtracted_for_a_number_too(make_results, mean):
    _, canvas = only(draw_figures(make_results(), kind="series", mean=mean, where={"load": "150 N"}))
    assert long_curves(canvas.axes[0])[0].get_ydata().mean() == pytest.approx(0.0, abs=0.01)


def test_zero_of_the_time_axis_is_named(make_results):
    """The angle of a roller defect is unknown, so no passage is found."""
    stored = make_results(STUDY.replace("race: outer", "race: roller, roller: 1"))
    _, canvas = only(
        draw_figures(stored, kind="series", around="impact", where={"load": "150 N", "defect.length": "3 mm"})
    )
    assert canvas.axes[-1].get_xlabel() == "Time from the largest deviation (ms)"


def test_label_of_the_colours_lies_in_the_figure(make_results):
    _, canvas = only(
        draw_figures(make_results(), kind="spectrogram", where={"load": "150 N", "defect.length": "3 mm"})
    )
    canvas.draw_without_rendering()
    label = canvas.axes[-1].yaxis.label.get_window_extent()
    assert 0.0 <= label.y0 < label.y1 <= canvas.bbox.height
    assert label.x1 <= canvas.bbox.width


def test_sideband_without_its_harmonic_is_marked(make_results):
    """BPFI - fr of 201 Hz, below BPFI of 231 Hz."""
    stored = make_results(STUDY.replace("race: outer", "race: inner"))
    where = {"load": "150 N", "defect.length": "3 mm"}
    _, canvas = only(draw_figures(stored, kind="spectrum", range="120 Hz..220 Hz", where=where))
    assert marks_of(canvas.axes[0]) == pytest.approx([201.0])


def test_labels_of_close_ticks_differ(make_results, monkeypatch):
    """A force of 100 N that varies by 1 mN."""

    def steady(case):
        result = record_of(case)
        wave = 100.0 + 1e-3 * np.sin(1e3 * result.time)
        result.series = dict.fromkeys(result.series, wave)
        return result

    stored = make_results()
    monkeypatch.setattr("tests.scenes.figure_results.record", steady)
    stored.path.rename(stored.path.with_name("first"))
    where = {"load": "150 N", "defect.length": "3 mm"}
    _, canvas = only(draw_figures(make_results(), kind="series", y=["roller.1.outer_force"], where=where))
    canvas.draw_without_rendering()
    [axis] = [ax.yaxis for ax in canvas.axes]
    texts = [text.get_text() for text in axis.get_ticklabels()]
    assert len(set(texts)) == len(texts)
    assert [float(text) for text in texts] == pytest.approx(list(axis.get_ticklocs()), abs=1e-5)
