"""Labels of ticks: none overlaps its neighbour, whatever the range and the width of the axes."""

import itertools

import pytest
from matplotlib.figure import Figure

from bearingsim.plots.axes import share_scales
from bearingsim.plots.style import drawing
from bearingsim.plots.ticks import digits_of, set_linear_ticks, set_log_ticks

RANGES = [(50.0, 22000.0), (200.0, 1e5), (1e-5, 3e-4), (0.2, 50.0), (1.1, 2.3), (99990.0, 100020.0), (1e-9, 1e9)]
WIDTHS = [0.8, 1.5, 3.0]  # inches


@pytest.mark.parametrize(("low", "high"), RANGES)
@pytest.mark.parametrize("scale", ["log", "linear"])
def test_tick_labels_do_not_overlap(low, high, scale):
    with drawing():
        for width, name in itertools.product(WIDTHS, "xy"):
            canvas = Figure(figsize=(width, width))
            ax = canvas.add_axes((0.0, 0.0, 1.0, 1.0))
            ax.set(**{f"{name}scale": scale, f"{name}lim": (low, high)})
            axis = ax.xaxis if name == "x" else ax.yaxis
            set_log_ticks(axis, low, high) if scale == "log" else set_linear_ticks(axis, [low, 1.01 * low, high])
            canvas.draw_without_rendering()
            boxes = [
                tick.label1.get_window_extent()
                for tick in axis.get_major_ticks()
                if tick.get_visible() and low <= tick.get_loc() <= high
            ]
            assert len(boxes) >= 1
            ends = sorted((box.x0, box.x1) if name == "x" else (box.y0, box.y1) for box in boxes)
            assert all(end < start for (_, end), (start, _) in itertools.pairwise(ends)), (width, name)


def test_few_values_each_have_a_tick():
    with drawing():
        canvas = Figure(figsize=(3.0, 3.0))
        ax = canvas.subplots()
        ax.set_xlim(2.5, 12.5)
        set_linear_ticks(ax.xaxis, [3.0, 6.0, 9.0, 12.0])
        canvas.draw_without_rendering()
        assert [tick.get_text() for tick in ax.get_xticklabels()] == ["3", "6", "9", "12"]


@pytest.mark.parametrize(
    ("ticks", "digits"),
    [
        ([0.0, 50.0, 100.0], 5),
        ([1.0, 1.00125, 1.0025], 6),  # 1.0013 is 4 % of a step off
        ([123456.0, 123456.5, 123457.0], 7),
        ([100.0], 5),
    ],
)
def test_labels_deviate_from_ticks_by_at_most_a_hundredth_of_a_step(ticks, digits):
    assert digits_of(ticks) == digits


@pytest.mark.parametrize("bottom", [None, 0.0])
def test_curves_are_off_the_edge_of_shared_axes(bottom):
    """The margin of a nearly constant curve is small against the range that it shares."""
    with drawing():
        low, high = Figure().subplots(2, 1)
        low.plot([0.0, 1.0], [0.1 if bottom == 0.0 else 0.0, 1.0])  # nearer to zero than the margin
        high.plot([0.0, 1.0], [48.6, 48.7])
        for ax in (low, high):
            ax.set_ylim(bottom=bottom)
        share_scales([[low], [high]], float("inf"))
    assert low.get_ylim() == high.get_ylim()
    assert low.get_ylim()[1] > 48.7 + 1.0
    assert low.get_ylim()[0] == 0.0 if bottom == 0.0 else low.get_ylim()[0] < -1.0
