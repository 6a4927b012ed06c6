"""Tilt and skew over time: their units, several rollers in one panel, tilt of rings."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from bearingsim.config import dataset_names
from bearingsim.plots import PlotError, labels, recorded
from bearingsim.plots.marks import MARK_COLOURS
from bearingsim.plots.plot import draw_figures
from tests.scenes.figure_results import only, results, text_of

__all__ = ["results"]

STUDY = """\
study: tilted
bearing: nf308
rig: {axial_stiffness: 1e7 N/m, tilting_stiffness: 1e4 N m/rad, sensor_angle: 90 deg}
speed: 1800 rpm
load: 150 N
model: spatial
defect: {shape: rectangular, length: 3 mm, width: 0.8 mm, depth: 0.05 mm, offset: 2 mm}
contact: {slices: 6}
sweep:
  load: [150 N, 300 N]
duration: 20 ms
record: [roller.2.outer_line_load, roller.2.tilt, roller.3.tilt, roller.2.skew, ring.lean, ring.axial]
"""
VALUES = {"roller.2.tilt": 2e-3, "roller.3.tilt": -3e-3, "roller.2.skew": 4e-6}
VALUES |= {"ring.lean.x": 5e-6, "ring.lean.y": 7e-6, "ring.axial": 8e-6}


def record(case):
    time = np.arange(round(case.duration * case.sampling)) / case.sampling
    names = [name for channel in case.record for name in dataset_names(channel)]
    series = {name: np.full(len(time), VALUES.get(name, 1e3)) for name in names}
    return SimpleNamespace(time=time, series=series, features={}, info={"cage_angle_start_rad": 0.0})


@pytest.fixture
def tilted(results, monkeypatch):
    monkeypatch.setattr("tests.scenes.figure_results.record", record)
    return results(STUDY)


def test_same_channel_of_rollers_shares_a_panel(tilted):
    channels = ["roller.2.tilt", "roller.3.tilt", "roller.2.skew"]
    for kind in ("series", "roller"):
        _, canvas = only(draw_figures(tilted, kind=kind, jobs=tilted.jobs[:1], y=channels))
        assert len(canvas.axes) == 2
        tilt, skew = canvas.axes
        assert tilt.get_ylabel().replace("\n", " ") == "Tilt of each roller, its +z end outwards (mrad)"
        assert skew.get_ylabel().replace("\n", " ") == "Skew of roller 2, its +z end forwards (µrad)"
        assert {line.get_label(): np.nanmax(line.get_ydata()) for line in tilt.lines[:2]} == pytest.approx(
            {"roller 2": 2.0, "roller 3": -3.0}, rel=1e-6
        )
        assert np.nanmax(skew.lines[0].get_ydata()) == pytest.approx(4.0, rel=1e-6)
        assert {"roller 2", "roller 3"} <= set(text_of(canvas))
        colours = [line.get_color() for line in tilt.lines[:2]]
        assert colours[0] != colours[1]


def test_each_roller_is_drawn_at_its_own_angle(tilted):
    channels = ["roller.2.tilt", "roller.3.tilt"]
    [ax] = only(draw_figures(tilted, kind="roller", jobs=tilted.jobs[:1], y=channels))[1].axes
    first = [line.get_xdata()[0] for line in ax.lines[:2]]
    assert first == pytest.approx([360.0 / 13, 720.0 / 13])


def test_defect_is_marked_within_any_range_of_angles(tilted):
    """The defect at 0 deg is at 360 deg of an axis from 180 to 540 deg."""
    for limits, position in (("180 deg..540 deg", 360.0), ("-180 deg..180 deg", 0.0)):
        sheets = draw_figures(tilted, kind="roller", jobs=tilted.jobs[:1], y=["roller.2.tilt"], range=limits)
        [ax] = only(sheets)[1].axes
        marks = [line.get_xdata()[0] for line in ax.lines if line.get_color() == MARK_COLOURS["outer"]]
        assert marks == pytest.approx([position])


def test_ring_tilt_has_two_components_at_any_sensor_angle(tilted):
    [ax] = only(draw_figures(tilted, kind="series", jobs=tilted.jobs[:1], y=["ring.lean"]))[1].axes
    assert ax.get_ylabel().replace("\n", " ") == "Tilt of the outer ring's axis (µrad)"
    assert {line.get_label(): line.get_ydata()[0] for line in ax.lines} == pytest.approx(
        {"x": 5.0, "y": 7.0}, rel=1e-6
    )


def test_slices_are_drawn_only_by_name(tilted):
    axes = only(draw_figures(tilted, kind="roller", jobs=tilted.jobs[:1]))[1].axes
    assert [ax.get_ylabel().split()[0] for ax in axes] == ["Tilt", "Skew"]
    [ax] = only(draw_figures(tilted, kind="series", jobs=tilted.jobs[:1]))[1].axes
    assert ax.get_ylabel().startswith("Tilt of roller 2")
    [ax] = only(draw_figures(tilted, kind="series", jobs=tilted.jobs[:1], y=["roller.2.outer_line_load.3"]))[
        1
    ].axes
    assert ax.get_ylabel().replace("\n", " ") == "Line load of roller 2 on the outer race, slice 3 (N/mm)"


@pytest.mark.parametrize("kind", ["series", "roller", "spectrum"])
def test_line_load_of_all_slices_is_referred_to_kind_load(tilted, kind):
    with pytest.raises(PlotError, match="use `--kind load`"):
        draw_figures(tilted, kind=kind, jobs=tilted.jobs[:1], y=["roller.2.outer_line_load"])


@pytest.mark.parametrize(
    ("name", "value", "label"),
    [
        ("roller.2.tilt", 2e-3, ("mrad", 1e3)),
        ("inner.lean", 2e-6, ("µrad", 1e6)),
        ("ring.lean.x", 0.0, ("nrad", 1e9)),
        ("tilt.max", 7e-6, ("µrad", 1e6)),
        ("load_zone.extent", 2.0, ("°", math.degrees(1.0))),
        ("velocity@BPFO.phase", 1e-3, ("°", math.degrees(1.0))),
    ],
)
def test_small_angles_are_in_radians_and_large_angles_in_degrees(name, value, label):
    assert labels.choose_unit("rad", name, value) == pytest.approx(label)


def test_label_of_several_rollers_says_each_roller():
    assert recorded.text_of("roller.2.axial", "roller.5.axial") == "Axial displacement of each roller"
    assert recorded.text_of("roller.2.axial") == "Axial displacement of roller 2"
