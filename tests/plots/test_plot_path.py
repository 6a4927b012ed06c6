"""The path that a roller took over a defect, from what was recorded of roller and ring."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from bearingsim.config import dataset_names
from bearingsim.core.geometry.kinematics import cage_speed
from bearingsim.plots.passage import compute_section, defects_of, first_passage, roller_path
from bearingsim.plots.plot import draw_figures
from bearingsim.plots.recorded import Job
from bearingsim.simulation.simulate import simulate
from bearingsim.store import Series, flat_parameters
from tests.scenes.figure_results import STUDY, results
from tests.scenes.short_cases import SLOT, case

__all__ = ["results"]

OMEGA_C = cage_speed(60.0 * math.pi, 0.012, 0.065)
RECORD = ["roller.2.radial", "ring.displacement"]


def job_of(test_case, **channels):
    """A job of 30 ms whose cage starts at -0.6 rad; channels as numbers, or functions of the roller's angle."""
    time = np.arange(3000) / 1e5
    angle = -0.6 + 2.0 * math.pi / 13 + OMEGA_C * time
    series = {name: np.broadcast_to(value(angle) if callable(value) else value, time.shape) for name, value in
            channels.items()}  # fmt: skip
    return Job(
        flat_parameters(test_case),
        {"cage_angle_start_rad": -0.6, "settle_s": test_case.settle_s},
        Series(time, series, {}),
    )


def test_roller_path_is_radial_motion_less_clearance_and_ring():
    """The ring 3 um down the load line and 4 um across; the roller 20 um outwards; clearance 8 um."""
    test_case = case(defect=SLOT | {"angle": "20 deg"}, clearance="8 um", model="rollers", record=RECORD)
    [defect] = defects_of(test_case)
    job = job_of(test_case, **{"roller.2.radial": 20e-6, "ring.displacement.x": 3e-6, "ring.displacement.y": 4e-6})
    path = roller_path(job, test_case, defect)
    angle = math.radians(20.0) + path.s / 0.0385
    expected = 20e-6 - 2e-6 - (3e-6 * np.cos(angle) + 4e-6 * np.sin(angle))
    assert path.number == 2
    assert path.depth == pytest.approx(expected, abs=1e-10)
    assert [path.s[0], path.s[-1]] == pytest.approx([-0.64e-3, 0.64e-3], abs=3e-5)
    assert np.all(np.diff(path.s) > 0.0)
    assert not path.tilt.any()


def test_path_of_tilted_roller_is_deeper_at_one_end():
    test_case = case(defect=SLOT | {"angle": "20 deg"}, model="spatial", record=[*RECORD, "roller.2.tilt"])
    [defect] = defects_of(test_case)
    still = dict.fromkeys(dataset_names("ring.displacement"), 0.0)
    path = roller_path(
        job_of(test_case, **{"roller.2.radial": 0.0, "roller.2.tilt": 1e-3, **still}), test_case, defect
    )
    assert set(path.tilt) == {1e-3}
    assert path.depth_at(3e-3) == pytest.approx(path.depth + 3e-6)


def test_path_on_inner_race_is_inward_and_reversed():
    """The race is faster than they are: what deepens as the roller goes on deepens towards -s."""
    record = [RECORD[0], "roller.2.tilt"]
    test_case = case(defect=SLOT | {"race": "inner", "angle": "-110 deg"}, model="spatial", record=record)
    [defect] = defects_of(test_case)
    ramps = {"roller.2.radial": lambda angle: -5e-6 - 2e-5 * angle, "roller.2.tilt": lambda angle: 1e-3 * angle}
    path = roller_path(job_of(test_case, **ramps), test_case, defect)
    start = -0.6 + 2.0 * math.pi / 13
    faster = test_case.speed - OMEGA_C
    # remaining rotation of the ring until the roller meets the defect
    remaining = math.radians(110.0) + start - test_case.speed * test_case.settle_s
    time = (remaining % (2.0 * math.pi) - path.s / 0.0265) / faster
    angle = start + OMEGA_C * time
    assert np.all(np.diff(path.s) > 0.0)
    assert [path.s[0], path.s[-1]] == pytest.approx([-0.64e-3, 0.64e-3], abs=6e-5)
    assert path.depth == pytest.approx(5e-6 + 2e-5 * angle, abs=1e-9)
    assert path.tilt == pytest.approx(-1e-3 * angle, abs=1e-7)


@pytest.mark.parametrize(
    "missing", [{"record": RECORD[:1]}, {"record": RECORD[1:]}, {"defect": SLOT | {"angle": "-90 deg"}}]
)
def test_no_path_without_recorded_channels_or_passage(missing):
    test_case = case(**{"defect": SLOT | {"angle": "20 deg"}, "model": "rollers", "record": RECORD} | missing)
    [defect] = defects_of(test_case)
    names = {name: 0.0 for channel in test_case.record for name in dataset_names(channel)}
    assert roller_path(job_of(test_case, **names), test_case, defect) is None


def test_contact_is_where_path_is_below_geometric_path():
    """A computed one falls 4.9 um into the slot of 0.8 mm, and strikes the far edge 0.14 mm behind the middle."""
    channels = ["roller.1.radial", "roller.1.outer_force", "ring.displacement"]
    times = {"sampling": "100 kHz", "duration": "20 ms", "settle": "0 ms", "antialias": False}
    test_case = case(defect=SLOT, model="rollers", start_angle="-60 deg", record=channels, **times)
    result = simulate(test_case)
    job = Job(flat_parameters(test_case), result.info, Series(result.time, result.series, {}))
    [defect] = defects_of(test_case)
    path, passage = roller_path(job, test_case, defect), first_passage(job, test_case, 1, "outer")
    over = compute_section(defect, 0.0)
    sinks = np.interp(path.s, over.s, over.h)
    force = np.interp(passage.time + path.s / passage.speed, result.time, result.series["roller.1.outer_force"])
    pressed, lifted = path.depth > sinks + 5e-8, path.depth < sinks - 5e-8
    assert pressed.sum() > 20
    assert lifted.sum() > 10
    assert np.mean(force[pressed] > 1.0) > 0.9  # damping lets go of what springs back fast
    assert abs(force[lifted]).max() == 0.0
    assert path.depth.max() == pytest.approx(4.9e-6, rel=0.05)
    assert path.s[np.argmax(path.depth)] == pytest.approx(0.13e-3, abs=2e-5)


def test_recorded_path_is_drawn_over_sections(results, monkeypatch):
    def made(test_case):
        time = np.arange(round(test_case.duration * test_case.sampling)) / test_case.sampling
        values = {"roller.2.radial": 3e-6, "ring.displacement.x": 0.0, "ring.displacement.y": 0.0}
        series = {name: np.full(len(time), values[name]) for c in test_case.record for name in dataset_names(c)}
        return SimpleNamespace(time=time, series=series, features={}, info={"cage_angle_start_rad": -0.6})

    monkeypatch.setattr("tests.scenes.figure_results.record", made)
    text = STUDY.replace("[static, ring]", "[rollers]") + f"record: [{', '.join(RECORD)}]\n"
    opened = results(text)
    _, canvas = draw_figures(opened, kind="pit", jobs=opened.jobs[:2])[0]
    path_lines = [line for ax in canvas.axes for line in ax.lines if line.get_label() == "recorded path"]
    depths = [np.asarray(line.get_ydata()) for line in path_lines]
    assert [depth.min() for depth in depths] == pytest.approx([1.75] * 3, rel=1e-5)  # clearance 5 um
    titles = [ax.get_title(loc="left") for ax in canvas.axes[1:4]]
    assert titles == [
        "(b) section A, heights ×5",
        "(c) section A, enlarged, heights ×20",
        "(d) section A, enlarged, heights ×100",
    ]
    caption = canvas.get_supxlabel().replace("\u00a0", " ").replace("\n", " ")
    assert "path of roller 2 at length 3 mm, load 150 N, model rollers" in caption
