"""The figure of `bearingsim sensitivity`: bars and points are the numbers, whiskers their intervals."""

import numpy as np
import pytest
from matplotlib.container import BarContainer, ErrorbarContainer

from bearingsim.plots.sensitivity import draw_figure
from bearingsim.sensitivity import analyse, collect_blocks
from bearingsim.store import open_results
from tests.scenes.design_results import PATHS, SLOPES, run_design

LINE = "velocity@BPFO"


def sheet(results, *features):
    answers = [(blocks, analyse(blocks)) for blocks in (collect_blocks(results, name) for name in features)]
    return draw_figure(results, answers), answers


def test_bars_are_indices_in_descending_order(tmp_path):
    results = open_results(run_design(tmp_path / "fake", n=64))
    canvas, [(_, indices), _] = sheet(results, LINE, "velocity.rms")
    first, total = (container for container in canvas.axes[0].containers if isinstance(container, BarContainer))
    for bars, expected in ((first, indices.first), (total, indices.total)):
        assert [bar.get_width() for bar in bars] == pytest.approx(expected.value)
        assert bars.errorbar is not None
        [whiskers] = bars.errorbar[2]
        for segment, low, high in zip(whiskers.get_segments(), expected.low, expected.high, strict=True):
            assert segment[:, 0] == pytest.approx([low, high])
    ax = canvas.axes[0]
    positions = dict(zip([text.get_text() for text in ax.get_yticklabels()], ax.get_yticks(), strict=True))
    assert positions == {"Defect width\n0 to 1 mm": 0, "Load\n100 to 200 N": 1}
    low, high = ax.get_ylim()
    assert low > high  # the first on top
    assert [container.get_title(loc="left") for container in canvas.axes] == [
        "Velocity amplitude at BPFO",
        "RMS velocity",
    ]


def test_points_are_effects_in_readable_unit(tmp_path):
    results = open_results(run_design(tmp_path / "fake", kind="morris", n=8))
    canvas, _ = sheet(results, LINE)
    [ax] = canvas.axes
    points = [container for container in ax.containers if isinstance(container, ErrorbarContainer)]
    assert [container[0].get_xdata()[0] for container in points] == pytest.approx(1e3 * np.array(SLOPES))
    assert [container[0].get_ydata()[0] for container in points] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert ax.get_xlabel() == "mu*, over the whole range (mm/s)"
    named = [text.get_text().split("\n")[0] for text in canvas.legends[0].get_texts()]
    assert named == ["Defect width", "Load"]
    assert len(points) == len(PATHS)


def test_caption_counts_blocks(tmp_path):
    results = open_results(run_design(tmp_path / "fake", actions={0: "raise"}))
    canvas, _ = sheet(results, LINE)
    caption = canvas.get_supxlabel().replace("\u00a0", " ")
    assert "15 of 16 blocks (saltelli)" in caption
    assert "whiskers: 95 % by bootstrap" in caption
