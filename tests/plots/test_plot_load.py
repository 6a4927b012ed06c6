"""Figure of the load along a roller: its slices, time span and instants."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bearingsim.config.rules.completion import slice_ends
from bearingsim.core.geometry.kinematics import cage_speed
from bearingsim.plots import PlotError
from bearingsim.plots.line_load import LineLoad, instants
from bearingsim.plots.plot import draw_figures
from tests.scenes.figure_results import only, results
from tests.scenes.scan_files import bowl, write_grid

__all__ = ["results"]

STUDY = """\
study: loaded
bearing: nf308
speed: 1800 rpm
load: 150 N
model: spatial
defect: {shape: rectangular, length: 3 mm, width: 0.8 mm, depth: 0.05 mm, offset: 2 mm, angle: 20 deg}
contact: {slices: 12}
sweep:
  load: [150 N, 300 N]
duration: 30 ms
settle: 10 ms
sampling: 50 kHz
record: [roller.2.outer_line_load]
"""
OMEGA_C = cage_speed(60.0 * math.pi, 0.012, 0.065)
R_O = 0.0385
START = -0.6  # rad, cage angle at the start of the record


def loads(case, channel):
    """Return 4 N/mm on the undamaged race, 0 over the defect of 0.8 mm at 20 deg, and 9 N/mm just after it."""
    time = np.arange(round(case.duration * case.sampling)) / case.sampling
    ends = slice_ends(case)
    middles = (ends[1:] + ends[:-1]) / 2.0
    angle = START + 2.0 * math.pi / 13 + OMEGA_C * time - math.radians(20.0)
    s = R_O * (np.mod(angle + math.pi, 2.0 * math.pi) - math.pi)
    load = np.full((len(middles), len(time)), 4e3)
    load[np.ix_((middles > 0.5e-3) & (middles < 3.5e-3), abs(s) < 0.4e-3)] = 0.0
    load[:, (s > 0.45e-3) & (s < 0.6e-3)] = 9e3
    return time, {f"{channel}.{k}": row for k, row in enumerate(load, 1)}


def record(case):
    time, series = np.arange(round(case.duration * case.sampling)) / case.sampling, {}
    channels = dict.fromkeys(name.rpartition(".")[0] for name in case.record if "line_load" in name)
    for channel in channels:
        rows = loads(case, channel)[1]
        series |= {name: row for name, row in rows.items() if name in case.record}
    features = {"velocity@BPFO": 1e-6, "velocity@BPFO.phase": 0.0}
    info = {"cage_angle_start_rad": START, "cpu_s": 1.0}
    return SimpleNamespace(time=time, series=series, features=features, info=info)


@pytest.fixture
def loaded(results, monkeypatch):
    monkeypatch.setattr("tests.scenes.figure_results.record", record)
    return lambda **changed: results(changed.get("text", STUDY))


def middle():
    """Return the time (s) at which the second roller is over the defect."""
    return (math.radians(20.0) - START - 2.0 * math.pi / 13 + 2.0 * math.pi) % (2.0 * math.pi) / OMEGA_C


def test_load_map_shows_every_slice_during_passage(loaded):
    opened = loaded()
    name, canvas = only(draw_figures(opened, kind="load", jobs=opened.jobs[:2]))
    assert name == f"load-{opened.jobs[0][:8]}-{opened.jobs[1][:8]}"
    map_axes, profile_axes, *_ = canvas.axes
    speed = OMEGA_C * R_O
    low, high = map_axes.get_xlim()
    assert low == pytest.approx(1e3 * middle() - 1.5 * 0.8 / speed, abs=0.03)
    assert high == pytest.approx(1e3 * middle() + 3.0 * 0.8 / speed, abs=0.03)
    mesh = map_axes.collections[0]
    assert mesh.get_array().shape[0] == len(mesh.get_coordinates()) - 1 >= 12
    assert {0.5, 3.5} <= set(np.round(mesh.get_coordinates()[:, 0, 1], 9))
    assert mesh.get_array().max() == pytest.approx(9.0)
    assert profile_axes.get_xlabel() == "Line load (N/mm)"
    assert profile_axes.get_ylabel() == "z (mm)"
    assert profile_axes.get_ylim() == map_axes.get_ylim() == (-6.0, 6.0)
    assert map_axes.get_ylabel() == "Along the roller, z (mm)"
    bars = [ax.get_ylabel().replace("\n", " ") for ax in canvas.axes]
    assert bars.count("Line load of roller 2 on the outer race (N/mm)") == 2
    assert map_axes.get_title(loc="left") == "load 150 N"


def test_lifted_slices_are_white(loaded):
    opened = loaded()
    _, canvas = only(draw_figures(opened, kind="load", jobs=opened.jobs[:1]))
    seen = canvas.axes[0].collections[0].get_array()
    rows = np.ma.getmaskarray(seen).any(axis=1)
    edges = canvas.axes[0].collections[0].get_coordinates()[:, 0, 1]
    assert edges[:-1][rows].min() == pytest.approx(0.5)
    assert edges[1:][rows].max() == pytest.approx(3.5)


def test_profiles_are_before_over_and_after_the_defect(loaded):
    opened = loaded()
    _, canvas = only(draw_figures(opened, kind="load", jobs=opened.jobs[:1]))
    [entries] = [
        [text.get_text() for text in ax.get_legend().get_texts()] for ax in canvas.axes if ax.get_legend()
    ]
    assert [entry.split(",")[0] for entry in entries] == ["before", "over the defect", "largest after", "after"]
    over, largest = (float(entry.split(",\n")[1].split()[0]) for entry in entries[1:3])
    assert over == pytest.approx(1e3 * middle(), abs=0.03)
    assert 0.45 < (largest - 1e3 * middle()) * OMEGA_C * R_O < 0.62
    curves = {patch.get_label().split(",")[0]: patch.get_data() for patch in canvas.axes[1].patches}
    inside = curves["over the defect"].values == 0.0
    assert curves["over the defect"].edges[:-1][inside].min() == pytest.approx(0.5)
    assert set(curves["before"].values) == {4.0}
    assert set(curves["largest after"].values) == {9.0}


def test_tilt_and_skew_share_time_axis_of_load_map(loaded, monkeypatch):
    def tilted(case):
        result = record(case)
        result.series |= {"roller.2.tilt": 3e-6 * (1.0 + result.time), "roller.2.skew": 0.0 * result.time}
        return result

    monkeypatch.setattr("tests.scenes.figure_results.record", tilted)
    opened = loaded(
        text=STUDY.replace(
            "[roller.2.outer_line_load]", "[roller.2.outer_line_load, roller.2.tilt, roller.2.skew]"
        )
    )
    map_axes, _, below, beside, _ = only(draw_figures(opened, kind="load", jobs=opened.jobs[:1]))[1].axes
    assert below.get_xlim() == map_axes.get_xlim()
    assert below.get_ylabel() == "Tilt, skew (µrad)"
    assert below.lines[0].get_ydata()[0] == pytest.approx(3.0, rel=1e-2)
    assert below.lines[0].get_xdata()[0] == pytest.approx(map_axes.get_xlim()[0], abs=0.02)
    assert [text.get_text() for text in beside.get_legend().get_texts()] == ["tilt", "skew"]
    assert below.get_ylim()[1] > 3.0


def test_span_sets_drawn_time(loaded):
    opened = loaded()
    _, canvas = only(draw_figures(opened, kind="load", jobs=opened.jobs[:1], span=0.01))
    low, high = canvas.axes[0].get_xlim()
    assert high - low == pytest.approx(10.0, abs=0.05)
    assert low < 1e3 * middle() < high


def test_profiles_without_defect_are_at_largest_and_least_load(loaded):
    text = "".join(f"{line}\n" for line in STUDY.splitlines() if not line.startswith("defect:"))
    opened = loaded(text=text)
    _, canvas = only(draw_figures(opened, kind="load", jobs=opened.jobs[:1]))
    names = [
        text.get_text().split(",")[0]
        for ax in canvas.axes
        if ax.get_legend()
        for text in ax.get_legend().get_texts()
    ]
    assert names == ["largest load", "least load"]


def test_scan_whose_file_is_deleted_is_read_from_results(loaded, tmp_path):
    """The defect's ends along the roller are dotted, which needs the scan."""
    text = "".join(line + "\n" for line in STUDY.splitlines() if not line.startswith("defect"))
    scan = write_grid(tmp_path / "a.csv", 0.5 * bowl())
    opened = loaded(text=text + "defect: {shape: scan, file: a.csv, angle: 0 deg}\n")
    scan.unlink()
    _, canvas = only(draw_figures(opened, kind="load", jobs=opened.jobs[:1]))
    assert [line.get_ydata()[0] for line in canvas.axes[0].lines[:2]] == pytest.approx([-3.0, 3.0])


def test_load_map_of_inner_race_defect_allows_for_rotation(loaded):
    text = STUDY.replace("angle: 20 deg", "angle: -150 deg, race: inner").replace("outer_line", "inner_line")
    opened = loaded(text=text)
    _, canvas = only(draw_figures(opened, kind="load", jobs=opened.jobs[:1]))
    start = math.radians(-150.0) + 60.0 * math.pi * 0.01 - START - 2.0 * math.pi / 13  # defect ahead of roller
    ahead = -start % (2.0 * math.pi)
    when, speed = ahead / (60.0 * math.pi - OMEGA_C), (60.0 * math.pi - OMEGA_C) * 0.0265
    assert canvas.axes[0].get_xlim()[0] == pytest.approx(1e3 * when - 1.5 * 0.8 / speed, abs=0.03)


def test_defect_on_race_of_the_channel_is_preferred(loaded):
    """Both could be passed within the record: the inner race's at 5.5 ms, the outer race's at 6.1 ms."""
    inner = "{race: inner, shape: rectangular, length: 3 mm, width: 0.8 mm, depth: 0.05 mm, angle: -150 deg}"
    text = STUDY.replace("defect: {", f"defects: [{inner}, {{").replace("20 deg}", "20 deg}]")
    opened = loaded(text=text)
    low, _ = only(draw_figures(opened, kind="load", jobs=opened.jobs[:1]))[1].axes[0].get_xlim()
    assert low == pytest.approx(1e3 * middle() - 1.5 * 0.8 / (OMEGA_C * R_O), abs=0.03)


def test_caption_notes_roller_that_passes_no_defect(loaded):
    opened = loaded(text=STUDY.replace("angle: 20 deg", "angle: -90 deg"))
    _, canvas = only(draw_figures(opened, kind="load", jobs=opened.jobs[:1]))
    assert "passes a race defect within the record" in canvas.get_supxlabel().replace("\u00a0", " ")
    assert canvas.axes[0].get_xlim()[1] == pytest.approx(30.0, abs=0.05)


def test_a_roller_without_a_number_is_the_first_one(loaded):
    text = STUDY.replace("roller.2.outer_line_load", "roller.outer_line_load")
    opened = loaded(text=text)
    for y in ([], ["roller.outer_line_load"], ["roller.1.outer_line_load"]):
        assert len(only(draw_figures(opened, kind="load", jobs=opened.jobs[:1], y=y))[1].axes) == 3


def test_caption_notes_few_samples_over_the_defect(loaded):
    opened = loaded(text=STUDY.replace("50 kHz", "20 kHz"))
    _, canvas = only(draw_figures(opened, kind="load", jobs=opened.jobs[:1]))
    assert "only 5.4 samples over the defect" in canvas.get_supxlabel().replace("\u00a0", " ")


@pytest.mark.parametrize(
    ("recorded", "options", "message"),
    [
        ("roller.2.outer_line_load", {"y": ["roller.2.inner_line_load"]},
         "did not record `roller.2.inner_line_load`: add `roller.2.inner_line_load` to `record`"),
        ("cage.speed", {},
         "did not record a load along a roller: add `roller.outer_line_load` to `record`, with `model: spatial`"),
        ("roller.2.outer_line_load.3", {}, "recorded 1 of 1[23] slices; add `roller.2.outer_line_load`"),
        ("roller.2.outer_line_load", {"span": 2e-5}, "samples in that time; raise `sampling`"),
    ],
)  # fmt: skip
def test_unrecorded_channel_is_refused(results, monkeypatch, recorded, options, message):
    def made(case):
        time, rows = loads(case, "roller.2.outer_line_load")
        series = {name: rows.get(name, 0.0 * time) for name in case.record}
        return SimpleNamespace(time=time, series=series, features={}, info={"cage_angle_start_rad": START})

    monkeypatch.setattr("tests.scenes.figure_results.record", made)
    with pytest.raises(PlotError, match=message):
        draw_figures(results(STUDY.replace("roller.2.outer_line_load", recorded)), kind="load", **options)


def test_instant_over_defect_has_least_load_even_if_no_slice_lifts():
    """Over the defect half of the load remains, in the middle of the interval."""
    load = np.full((2, 9), 4.0)
    load[1, 3:6] = 2.0
    passage: Any = SimpleNamespace(defect=SimpleNamespace(z=(0.0, 1.0)))
    load_along = LineLoad("c", np.arange(9.0), load, np.array([-1.0, 0.0, 1.0]), passage, {})
    assert instants(load_along) == {"before": 0, "over the defect": 4, "largest after": 6, "after": 8}


def test_instant_over_a_defect_without_the_middle_of_a_slice_is_found():
    """The middles of the slices are at -0.5 and 0.5, the defect is from -0.2 to 0.2."""
    load = np.full((2, 9), 4.0)
    load[:, 1:4] = 2.0
    passage: Any = SimpleNamespace(defect=SimpleNamespace(z=(-0.2, 0.2)))
    load_along = LineLoad("c", np.arange(9.0), load, np.array([-1.0, 0.0, 1.0]), passage, {})
    assert instants(load_along)["over the defect"] == 2


def test_slice_that_is_partly_over_the_defect_counts_by_that_part():
    """From -0.1 to 1 a tenth of the first slice: 0.4 + 2 = 2.4 at instants 2 and 3, and 0 + 4 = 4 at 4 and 5."""
    load = np.full((2, 9), 6.0)
    load[:, 2:4] = [[4.0], [2.0]]
    load[:, 4:6] = [[0.0], [4.0]]
    passage: Any = SimpleNamespace(defect=SimpleNamespace(z=(-0.1, 1.0)))
    load_along = LineLoad("c", np.arange(9.0), load, np.array([-1.0, 0.0, 1.0]), passage, {})
    assert instants(load_along)["over the defect"] == 3


def test_largest_load_is_integral_of_line_load():
    """A slice of a tenth of the length counts a tenth."""
    load = np.array([[1.0, 1.0, 2.0], [1.0, 9.0, 2.0]])
    load_along = LineLoad("c", np.arange(3.0), load, np.array([0.0, 10.0, 11.0]), None, {})
    assert instants(load_along) == {"largest load": 2, "least load": 0}
