"""Figures asked for on the command line: what is refused, what files they go to, how axes compare."""

import pytest

from bearingsim.plots import PlotError, PlotWarning
from bearingsim.plots.plot import draw_figures
from tests.scenes.figure_results import FIGURES, STUDY, lines, only, results

__all__ = ["results"]

TEXT = STUDY + FIGURES


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"where": {"laod": "150 N"}}, "no swept path `laod`.*did you mean `load`"),
        ({"kind": "spectrum", "where": {"laod": "150 N"}}, "no swept path `laod`.*did you mean `load`"),
        *(({"y": [name]}, f"no feature `{name}`") for name in ("status", "job", "unit", "healthy", "reason")),
        ({"kind": "series", "y": ["velocity.rms"]}, "did not record `velocity.rms`"),
        ({"kind": "series", "by": ["laod"]}, "no swept path `laod`.*did you mean `load`"),
        ({"kind": "phase", "y": ["velocity.rms"]}, "`velocity.rms` has no phase"),
        ({"x": "load", "by": ["load"]}, "`load` can be only one of"),
        ({"by": ["load"], "panels": ["load"]}, "`load` can be only one of"),
    ],
)
def test_undrawable_figure_is_refused(results, options, message):
    with pytest.raises(PlotError, match=message):
        draw_figures(results(TEXT), **options)


def test_jobs_are_selected_by_id_or_where(results):
    opened = results()
    with pytest.raises(PlotError, match="named jobs cannot be filtered"):
        draw_figures(opened, kind="series", jobs=opened.jobs[:1], where={"load": "150 N"})
    _, canvas = only(draw_figures(opened, kind="spectrum", where={"load": "300 N", "model": "ring"}))
    titles = [ax.get_title(loc="left") for ax in canvas.axes]
    assert titles == [f"length {length} mm, load 300 N, model ring" for length in (3, 6, 9)]


def test_all_finished_jobs_can_be_drawn(results):
    stored = results(TEXT, lost={0: "failed"})
    with pytest.warns(PlotWarning, match="series without 1 of 12 cases, which failed or are not computed yet"):
        name, canvas = only(draw_figures(stored, kind="series", jobs=["all"]))
    assert name == "series-all"
    assert len(canvas.axes) == 11


def test_phase_figure_accepts_name_of_line(results):
    _, canvas = only(draw_figures(results(), kind="phase", y=["velocity@BPFO"]))
    assert canvas.axes[0].get_ylabel() == "Velocity phase at BPFO (°)"


def test_words_on_x_follow_order_of_study(results):
    _, canvas = only(draw_figures(results(STUDY), x="model"))
    assert [list(line.get_xdata()) for line in lines(canvas.axes[0])] == [[0.0, 1.0]] * 6


@pytest.mark.parametrize(
    ("options", "name"),
    [
        ({}, "fig1-velocity-bpfo-vs-defect-length"),
        ({"x": "defect.length"}, "plot1-velocity-bpfo-vs-defect-length"),
        ({"by": ["model"]}, "plot1-velocity-bpfo-vs-defect-length-by-model"),
        ({"panels": ["load"]}, "plot1-velocity-bpfo-vs-defect-length-panels-load"),
        ({"y": ["velocity.rms", "velocity@BPFO"]}, "plot1-velocity-rms-velocity-bpfo-vs-defect-length"),
        ({"where": {"load": "150 N"}}, "plot1-velocity-bpfo-vs-defect-length-where-load-150-n"),
    ],
)
def test_figure_by_options_overwrites_no_figure_of_study(results, options, name):
    assert only(draw_figures(results(), **options))[0] == name


def test_file_names_contain_job_ids(results):
    opened = results()
    first = [job[:8] for job in opened.jobs]
    assert only(draw_figures(opened, kind="series", jobs=opened.jobs[:2]))[0] == f"series-{first[0]}-{first[1]}"
    name, _ = only(draw_figures(opened, kind="series", jobs=opened.jobs[:6]))
    assert name.startswith("-".join(["series", *first[:4], "and-2-more"]))


def test_file_names_of_many_jobs_differ(results):
    opened = results()
    few, other = opened.jobs[:5], [*opened.jobs[:4], opened.jobs[5]]
    names = [only(draw_figures(opened, kind="series", jobs=jobs))[0] for jobs in (few, other)]
    assert names[0] != names[1]


def test_panels_of_different_magnitude_have_own_axes(results):
    """With 150 N and 30 kN on one axis the curves of the smaller would be flat."""
    text = STUDY.replace("[150 N, 300 N]", "[150 N, 30 kN]")
    _, canvas = only(draw_figures(results(text), x="defect.length", panels=["load"], y=["velocity@BPFO"]))
    small, large = (ax.get_ylim()[1] for ax in canvas.axes)
    assert large > 200.0
    assert small < 50.0


def test_axes_have_no_offset_text(results):
    text = STUDY.replace("load: [150 N, 300 N]", "load: [1e-7 N, 2e-7 N]").replace("[static, ring]", "[static]")
    opened = results(text)
    _, canvas = only(draw_figures(opened, x="load", y=["velocity@BPFO-scatter"]))
    canvas.draw_without_rendering()
    [ax] = canvas.axes
    assert ax.yaxis.get_offset_text().get_text() == ""
    assert ax.get_yticklabels()[-1].get_text().endswith("e-13")
    assert ax.get_ylabel() == "Standard error of velocity at BPFO\n(µm/s)"
