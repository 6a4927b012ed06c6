"""The caption of a figure: what moves along its curves and stands on no axis, the band of its records."""

import pytest

from bearingsim.plots.plot import drawn
from tests.plots.test_plots import STUDY, lines, only, results, text_of

__all__ = ["results"]

ZIP = STUDY[: STUDY.index("sweep:")] + (
    "sweep:\n  zip: {defect.length: [3 mm, 6 mm, 9 mm], load: [150 N, 200 N, 300 N]}\n  model: [static, ring]\n"
)


def caption_of(canvas):
    return canvas.get_supxlabel().replace("\u00a0", " ").replace("\n", " ")


def draw(results, text, figure):
    return only(drawn(results(f"{text}figures: [{figure}]\n")))[1]


def test_what_a_zip_moves_with_x_is_named_with_its_range(results):
    canvas = draw(results, ZIP, "{y: velocity@BPFO, x: defect.length, by: model}")
    assert "load moves along: 150 to 300 N" in caption_of(canvas)
    assert text_of(canvas) == ["model static", "model ring", "healthy"]


def test_what_a_zip_moves_from_curve_to_curve_is_named_with_its_curves(results):
    canvas = draw(results, ZIP, "{y: velocity@BPFO, x: model, by: defect.length}")
    assert "load moves along with defect length: 150 to 300 N" in caption_of(canvas)


def test_what_a_zip_moves_from_panel_to_panel_is_named_with_them(results):
    canvas = draw(results, ZIP, "{y: velocity@BPFO, x: model, panels: load}")
    assert "defect length moves along with load: 3 to 9 mm" in caption_of(canvas)


def test_what_is_derived_is_named(results):
    text = STUDY.replace(
        "  model: [static, ring]\n", "  model: [static]\n  derived: {defect.depth: defect.length / 100}\n"
    )
    canvas = draw(results, text, "{y: velocity@BPFO, x: load, by: defect.length}")
    assert "defect depth moves along with defect length: 0.03 to 0.09 mm" in caption_of(canvas)
    assert len(lines(canvas.axes[0])) == 3


def test_words_that_move_along_are_told_one_by_one(results):
    text = (
        STUDY[: STUDY.index("sweep:")]
        + "sweep: {zip: {load: [150 N, 200 N, 300 N], model: [static, ring, static]}}\n"
    )
    canvas = draw(results, text, "{y: velocity@BPFO, x: load}")
    assert "model moves along: static / ring" in caption_of(canvas)
    assert len(lines(canvas.axes[0])) == 1


@pytest.mark.parametrize(
    "figure", ["{y: velocity@BPFO, x: defect.length, by: [load, model]}", "{y: velocity@BPFO, x: model}"]
)
def test_nothing_moves_along_where_all_is_drawn(results, figure):
    assert "moves along" not in caption_of(draw(results, STUDY, figure))


def test_what_is_constant_in_the_figure_does_not_move_along(results):
    canvas = draw(results, ZIP, "{y: velocity@BPFO, x: model, where: {load: 200 N}}")
    assert "moves along" not in caption_of(canvas)
    assert "load 200 N" in caption_of(canvas)


@pytest.mark.parametrize(
    ("more", "band"),
    [
        ("", "RMS of 0 to 4.1 kHz"),
        ("sampling: 20 kHz\n", "RMS of 0 to 8 kHz"),
        ("antialias: false\n", "RMS of raw samples"),
    ],
)
def test_the_band_of_a_statistic_stands_in_the_caption(results, more, band):
    text = f"{STUDY}{more}figures: [{{y: [velocity.rms, velocity@BPFO], x: defect.length}}]\n"
    opened = results(text)
    assert band in caption_of(only(drawn(opened))[1])
    line = drawn(opened, x="defect.length", y=["velocity@BPFO"])
    assert "kHz" not in caption_of(only(line)[1])
