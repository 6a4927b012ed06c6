"""Figures in print and to colour-blind readers: colours, line styles, and sizes of texts on the page."""

import itertools

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.text import Text

from bearingsim.plots import style
from bearingsim.plots.plot import draw_figures
from tests.scenes.figure_results import STUDY, only, results

__all__ = ["results"]

# Machado, Oliveira and Fernandes (2009), IEEE Trans. Vis. Comput. Graph. 15(6), severity 1, for linear sRGB
SIGHT = {
    "normal": np.eye(3),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "tritanopia": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    ),
}
TO_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)  # sRGB, IEC 61966-2-1, D65
APART = 15.0  # CIE76 colour difference of curves that differ in colour only
PRINTED_MM, MIN_PT = {1: 85.0, 2: 180.0, 3: 180.0}, 6.0  # width of a figure on the page, size of its texts


def lab(colour, sight):
    """Return CIE L*, a*, b* of a colour as seen."""
    channels = np.array(to_rgb(colour))
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    t = TO_XYZ @ np.clip(SIGHT[sight] @ linear, 0.0, 1.0) / TO_XYZ.sum(axis=1)
    x, y, z = np.where(t > (6.0 / 29.0) ** 3, np.cbrt(t), t * (29.0 / 6.0) ** 2 / 3.0 + 4.0 / 29.0)
    return np.array([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)])


def difference(first, second):
    """Return the minimum CIE76 difference of two colours over all simulations, and in grey (CIE lightness)."""
    seen = [lab(first, sight) - lab(second, sight) for sight in SIGHT]
    return min(*(np.linalg.norm(vector) for vector in seen), abs(seen[0][0]))


def are_distinct(first, second):
    """Check that two curves differ in marker, fill or line style, or in colour in every simulation."""
    return first[1:] != second[1:] or difference(first[0], second[0]) >= APART


@pytest.mark.parametrize("sight", SIGHT)
def test_colours_are_distinct_with_colour_blindness(sight):
    pairs = itertools.combinations(style.COLOURS, 2)
    assert min(np.linalg.norm(lab(a, sight) - lab(b, sight)) for a, b in pairs) >= APART


@pytest.mark.parametrize("by_line", [1, 2, 5])
@pytest.mark.parametrize("ordered", [False, True])
def test_neighbouring_curves_differ_in_every_simulation_and_in_grey(by_line, ordered):
    for by_colour in range(1, 13):
        table = style.curve_styles(by_colour, by_line, ordered)
        looks = [(look.colour, look.marker, look.fill, str(look.line)) for row in table for look in row]
        assert all(are_distinct(*pair) for pair in itertools.pairwise(looks))


@pytest.mark.parametrize("count", [2, 6])
def test_neighbouring_signals_differ_in_every_simulation_and_in_grey(results, count):
    angles = ", ".join(f"{5 * number} deg" for number in range(count))
    study = f"{STUDY[: STUDY.index('sweep:')]}record: [ring.velocity]\nsweep: {{defect.angle: [{angles}]}}\n"
    figure = "figures: [{kind: series, y: ring.velocity, by: defect.angle, healthy: off}]\n"
    _, canvas = only(draw_figures(results(study + figure)))
    looks = [(line.get_color(), str(line._unscaled_dash_pattern)) for line in canvas.axes[0].lines]
    assert len(looks) >= count
    assert all(are_distinct(*pair) for pair in itertools.pairwise(looks))


@pytest.mark.parametrize("count", [1, 2, 3])
def test_texts_are_large_enough_on_the_page(results, count):
    names = ", ".join(["velocity@BPFO", "velocity.rms", "seconds"][:count])
    figure = f"figures: [{{y: [{names}], x: defect.length, by: [load, model], title: Length}}]\n"
    _, canvas = only(draw_figures(results(STUDY + figure)))
    canvas.draw_without_rendering()
    scale = min(1.0, PRINTED_MM[count] / (25.4 * canvas.get_size_inches()[0]))
    sizes = [text.get_fontsize() for text in canvas.findobj(Text) if text.get_visible() and text.get_text()]
    assert scale * min(sizes) >= MIN_PT
    legend = canvas.legends[0].get_window_extent()
    others = [ax.get_tightbbox() for ax in canvas.axes] + [canvas._suptitle.get_window_extent()]
    assert not [box for box in others if legend.overlaps(box)], legend
    assert canvas.bbox.padded(1.0).containsx(legend.x1)
