"""Figures of designs: points over each parameter, without a line through them, and their medians."""

import math

import numpy as np
import pytest

from bearingsim.figure_kinds import OptionError
from bearingsim.plots import PlotError, design
from bearingsim.plots.plot import draw_figures
from tests.plots.test_plot_along import caption_of
from tests.scenes.figure_results import STUDY, only, results, text_of

__all__ = ["results"]

HEAD = STUDY[: STUDY.index("sweep:")]
OVER = "over: {load: [150 N, 300 N], defect.length: [3 mm, 9 mm], defect.angle: [0 deg, 30 deg]}"
SOBOL = f"{HEAD}sweep:\n  sobol: {{n: 32, seed: 1, {OVER}}}\n"


def points_of(ax):
    """The clouds of points, by their x and y; not the lines through them, nor rings."""
    return [
        line.get_xydata() for line in ax.lines if line.get_linestyle() == "None" and line.get_markersize() < 4.0
    ]


def trends_of(ax):
    return [line for line in ax.lines if line.get_linestyle() != "None"]


def test_design_has_one_panel_per_parameter_with_all_points(results):
    name, canvas = only(draw_figures(results(SOBOL), kind="design", y=["velocity@BPFO"]))
    assert name == "design-velocity-bpfo"
    assert [ax.get_xlabel() for ax in canvas.axes] == ["Load (N)", "Defect length (mm)", "Defect angle (°)"]
    for ax in canvas.axes:
        [points] = points_of(ax)
        assert len(points) == 32
        assert len(trends_of(ax)) == len(ax.collections) == 1
    by_load = points_of(canvas.axes[0])[0]
    by_length = points_of(canvas.axes[1])[0]
    np.testing.assert_allclose(sorted(by_load[:, 1]), sorted(by_length[:, 1]))  # the same jobs
    assert "sobol design of 32 points, seed 1, line: running median" in caption_of(canvas)
    assert "varies with" not in caption_of(canvas)
    assert "load" not in caption_of(canvas)


def test_caption_over_one_parameter_names_the_other_varied_ones(results):
    text = SOBOL + "figures: [{y: [velocity@BPFO, velocity.rms], x: load}]\n"
    name, canvas = only(draw_figures(results(text)))
    assert name == "fig1-velocity-bpfo-vs-load"
    assert [len(points_of(ax)[0]) for ax in canvas.axes] == [32, 32]
    assert "defect length varies: 3." in caption_of(canvas)
    assert "defect angle varies: 0." in caption_of(canvas)
    assert not canvas.legends


def test_study_of_only_a_design_draws_it_by_default(results):
    names = [name for name, _ in draw_figures(results(SOBOL))]
    assert names == ["design-velocity-bpfo", "design-velocity-bpfo-healthy"]


def test_parameter_swept_besides_a_design_is_coloured(results):
    opened = results(SOBOL + "  model: [static, ring]\n")
    _, canvas = only(draw_figures(opened, kind="design", y=["velocity@BPFO"]))
    assert text_of(canvas) == ["model static", "model ring"]
    assert [len(points) for points in points_of(canvas.axes[0])] == [32, 32]
    _, canvas = only(draw_figures(opened, kind="design", y=["velocity@BPFO"], where={"model": "ring"}))
    assert [len(points) for points in points_of(canvas.axes[0])] == [32]
    _, canvas = only(draw_figures(opened, x="model", y=["velocity@BPFO"]))
    assert [len(points) for points in points_of(canvas.axes[0])] == [64]
    assert "load varies: 15" in caption_of(canvas)


def test_points_of_two_parameters_swept_besides_a_design_are_visible_and_differ(results):
    opened = results(SOBOL + "  model: [static, ring]\n  speed: [900 rpm, 1200 rpm, 1800 rpm]\n")
    _, canvas = only(draw_figures(opened, kind="design", y=["velocity@BPFO"]))
    clouds = [line for line in canvas.axes[0].lines if line.get_linestyle() == "None"]
    assert all(line.get_markerfacecolor() != "white" or line.get_markeredgewidth() > 0.0 for line in clouds)
    looks = {(line.get_color(), line.get_fillstyle(), line.get_markerfacecolor()) for line in clouds}
    assert len(looks) == len(clouds) == 6


@pytest.mark.parametrize("kind", ["saltelli", "morris"])
def test_repeated_design_values_make_no_curves(results, kind):
    derived = "  derived: {defect.width: defect.length / 10}\n"
    opened = results(f"{HEAD}sweep:\n  {kind}: {{n: 8, seed: 1, {OVER}}}\n{derived}")
    cases = len(set(opened.plan["design"]["ids"]))
    for options in ({"kind": "design"}, {"x": "load"}):
        _, canvas = only(draw_figures(opened, y=["velocity@BPFO"], **options))
        assert [len(points) for points in points_of(canvas.axes[0])] == [cases]
        assert not canvas.legends


def test_caption_lists_parameter_derived_from_design_as_varying(results):
    opened = results(SOBOL + "  derived: {defect.width: defect.length / 10}\n")
    for options in ({"kind": "design"}, {"x": "load"}):
        _, canvas = only(draw_figures(opened, y=["velocity@BPFO"], **options))
        assert len(points_of(canvas.axes[0])) == 1
        assert "defect width varies: " in caption_of(canvas)


def test_failed_and_missing_jobs_are_marked_on_the_axis(results):
    _, canvas = only(
        draw_figures(results(SOBOL, lost={3: "failed", 4: "missing"}), kind="design", y=["velocity@BPFO"])
    )
    assert text_of(canvas) == ["failed", "not computed"]
    assert np.isfinite(points_of(canvas.axes[0])[0][:, 1]).sum() == 30


def test_caption_counts_points_without_a_value(results):
    """A line is NaN in a record too short to separate it, at speeds that the axis then lacks."""
    opened = results(SOBOL)
    rows = opened.table()["velocity@BPFO"].copy()
    _, canvas = only(draw_figures(opened, kind="design", y=["velocity@BPFO"]))
    assert "without a value" not in caption_of(canvas)
    opened._table["velocity@BPFO"] = rows.where(rows.index >= 3)
    for options in ({"kind": "design"}, {"x": "load"}):
        _, canvas = only(draw_figures(opened, y=["velocity@BPFO"], **options))
        assert "velocity amplitude at BPFO without a value in 3 of 32" in caption_of(canvas)


def test_caption_describes_medians_only_if_they_are_drawn(results):
    opened = results(SOBOL)
    for by, is_drawn in (([], True), (["defect.angle"], False)):
        _, canvas = only(draw_figures(opened, x="load", by=by, y=["velocity@BPFO"]))
        assert ("running median" in caption_of(canvas)) == is_drawn


def test_printed_value_selects_the_point_of_a_design(results):
    """Values have 12 digits, of which tables and figures print 5."""
    opened = results(SOBOL)
    load = sorted({row["swept"]["load"] for row in opened.plan["jobs"] if not row["twin"]})[4]
    printed = f"{load:.5g} N"
    assert float(printed.split()[0]) != load
    _, canvas = only(draw_figures(opened, kind="pit", where={"load": printed}))
    assert canvas
    with pytest.raises(PlotError, match=rf"no case has load {load + 0.01:.6g} N \(nearest: .*{printed}"):
        draw_figures(opened, kind="pit", where={"load": f"{load + 0.01:.6g} N"})


def test_trend_is_median_and_quartiles():
    rng = np.random.default_rng(1)
    x = rng.uniform(0.0, 1.0, 400)
    y = 2.0 * x + rng.uniform(-0.5, 0.5, 400)
    medians = design.compute_trend(list(x), [*y[:-1], math.nan])
    assert len(medians.x) == 19
    np.testing.assert_allclose(medians.median, 2.0 * medians.x, atol=0.25)
    np.testing.assert_allclose(medians.high - medians.low, 0.5, atol=0.3)


def test_trend_has_one_median_per_x_if_x_has_few_values():
    x = [0.0, 1.0, 5.0] * 9
    medians = design.compute_trend(x, [3.0 * value + k for k in range(9) for value in (0.0, 1.0, 5.0)])
    assert list(medians.x) == [0.0, 1.0, 5.0]
    assert list(medians.median) == [4.0, 7.0, 19.0]
    assert list(medians.high - medians.low) == [4.0, 4.0, 4.0]


@pytest.mark.parametrize("x", [list(range(23)), [1.0] * 40])
def test_too_few_points_have_no_trend(x):
    assert design.compute_trend(x, x) is None


def test_design_figure_refuses_other_options(results):
    opened = results()
    with pytest.raises(PlotError, match="the study sweeps no design"):
        draw_figures(opened, kind="design")
    for option in ({"x": "load"}, {"panels": ["load"]}, {"span": 1.0}):
        with pytest.raises(OptionError, match="a design has no option"):
            draw_figures(opened, kind="design", **option)


def test_design_without_varying_parameter_is_refused(results):
    opened = results(SOBOL)
    row = opened.table().iloc[0]
    with pytest.raises(PlotError, match="no parameter of the design varies"):
        draw_figures(opened, kind="design", where={"load": f"{row['load']:.17g} N"})


def test_log_sampled_range_has_log_axis(results):
    even = np.linspace(1.0, 40.0, 64)
    assert design.is_logarithmic(list(np.geomspace(1.0, 40.0, 64)))
    assert not design.is_logarithmic(list(even))
    assert not design.is_logarithmic(list(even - 1.0))
    assert not design.is_logarithmic(list(np.geomspace(1.0, 3.0, 64)))
    text = SOBOL.replace("defect.length: [3 mm, 9 mm]", "contact.damping.beta: {log: [0.5 us, 10 us]}")
    _, canvas = only(draw_figures(results(text), kind="design", y=["velocity@BPFO"]))
    assert [ax.get_xscale() for ax in canvas.axes] == ["linear", "log", "linear"]


def test_several_figures_of_a_design_have_names_of_their_own(results):
    text = SOBOL + "  model: [static, ring]\nfigures:\n"
    text += "".join(
        f"  - {{kind: design, y: velocity@BPFO, where: {{model: {model}}}}}\n" for model in ("static", "ring")
    )
    names = [name for name, _ in draw_figures(results(text))]
    assert names == ["fig1-design-velocity-bpfo", "fig2-design-velocity-bpfo"]
