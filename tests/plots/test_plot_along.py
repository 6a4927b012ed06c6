"""Captions of figures: parameters that vary along curves without an axis, and the band of the records."""

import pytest

from bearingsim.plots.plot import draw_figures
from tests.scenes.figure_results import STUDY, lines, only, results, text_of

__all__ = ["results"]

ZIP = STUDY[: STUDY.index("sweep:")] + (
    "sweep:\n  zip: {defect.length: [3 mm, 6 mm, 9 mm], load: [150 N, 200 N, 300 N]}\n  model: [static, ring]\n"
)


def caption_of(canvas):
    return canvas.get_supxlabel().replace("\u00a0", " ").replace("\n", " ")


def draw(results, text, figure):
    return only(draw_figures(results(f"{text}figures: [{figure}]\n")))[1]


def test_caption_gives_range_of_parameter_zipped_with_x(results):
    canvas = draw(results, ZIP, "{y: velocity@BPFO, x: defect.length, by: model}")
    assert "load varies with x: 150 to 300 N" in caption_of(canvas)
    assert text_of(canvas) == ["model static", "model ring", "healthy"]


def test_caption_names_parameter_zipped_with_curves(results):
    canvas = draw(results, ZIP, "{y: velocity@BPFO, x: model, by: defect.length}")
    assert "load varies with defect length: 150 to 300 N" in caption_of(canvas)


def test_caption_names_parameter_zipped_with_panels(results):
    canvas = draw(results, ZIP, "{y: velocity@BPFO, x: model, panels: load}")
    assert "defect length varies with load: 3 to 9 mm" in caption_of(canvas)


def test_caption_names_derived_parameter(results):
    text = STUDY.replace(
        "  model: [static, ring]\n", "  model: [static]\n  derived: {defect.depth: defect.length / 100}\n"
    )
    canvas = draw(results, text, "{y: velocity@BPFO, x: load, by: defect.length}")
    assert "defect depth varies with defect length: 0.03 to 0.09 mm" in caption_of(canvas)
    assert len(lines(canvas.axes[0])) == 3


def test_caption_lists_zipped_words(results):
    text = (
        STUDY[: STUDY.index("sweep:")]
        + "sweep: {zip: {load: [150 N, 200 N, 300 N], model: [static, ring, static]}}\n"
    )
    canvas = draw(results, text, "{y: velocity@BPFO, x: load}")
    assert "model varies with x: static / ring" in caption_of(canvas)
    assert len(lines(canvas.axes[0])) == 1


@pytest.mark.parametrize(
    "figure", ["{y: velocity@BPFO, x: defect.length, by: [load, model]}", "{y: velocity@BPFO, x: model}"]
)
def test_caption_names_no_drawn_parameter_as_varying(results, figure):
    assert "varies with" not in caption_of(draw(results, STUDY, figure))


def test_caption_gives_constant_zipped_parameter_as_fixed(results):
    canvas = draw(results, ZIP, "{y: velocity@BPFO, x: model, where: {load: 200 N}}")
    assert "varies with" not in caption_of(canvas)
    assert "load 200 N" in caption_of(canvas)


@pytest.mark.parametrize(
    ("more", "band"),
    [
        ("", "RMS of 0 to 4.1 kHz"),
        ("sampling: 20 kHz\n", "RMS of 0 to 8 kHz"),
        ("antialias: false\n", "RMS of raw samples"),
    ],
)
def test_caption_gives_band_of_statistic(results, more, band):
    text = f"{STUDY}{more}figures: [{{y: [velocity.rms, velocity@BPFO], x: defect.length}}]\n"
    opened = results(text)
    assert band in caption_of(only(draw_figures(opened))[1])
    line = draw_figures(opened, x="defect.length", y=["velocity@BPFO"])
    assert "kHz" not in caption_of(only(line)[1])
