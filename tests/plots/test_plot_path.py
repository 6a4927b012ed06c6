"""The path that a roller took over a defect, from what was recorded of roller and ring."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from bearingsim.config import dataset_names
from bearingsim.core.geometry.kinematics import cage_speed
from bearingsim.plots.passage import cut, defects_of, first_passage, roller_path
from bearingsim.plots.plot import drawn
from bearingsim.plots.recorded import Job
from bearingsim.simulation.simulate import simulate
from bearingsim.store import Series, flat_parameters
from tests.plots.test_plots import STUDY, results
from tests.scenes.short_cases import SLOT, case

__all__ = ["results"]

OMEGA_C = cage_speed(60.0 * math.pi, 0.012, 0.065)
RECORD = ["roller.2.radial", "ring.displacement"]


def job_of(given, **channels):
    """A job of 30 ms whose cage starts at -0.6 rad; channels as numbers, or functions of the roller's angle."""
    time = np.arange(3000) / 1e5
    angle = -0.6 + 2.0 * math.pi / 13 + OMEGA_C * time
    made = {name: np.broadcast_to(value(angle) if callable(value) else value, time.shape) for name, value in
            channels.items()}  # fmt: skip
    return Job(
        flat_parameters(given), {"cage_angle_start_rad": -0.6, "settle_s": given.settle_s}, Series(time, made, {})
    )


def test_the_path_is_what_the_roller_moves_beyond_play_and_ring():
    """The ring 3 um down the load line and 4 um across; the roller 20 um outwards; clearance 8 um."""
    given = case(defect=SLOT | {"angle": "20 deg"}, clearance="8 um", model="rollers", record=RECORD)
    [defect] = defects_of(given)
    job = job_of(given, **{"roller.2.radial": 20e-6, "ring.displacement.x": 3e-6, "ring.displacement.y": 4e-6})
    found = roller_path(job, given, defect)
    angle = math.radians(20.0) + found.s / 0.0385
    expected = 20e-6 - 2e-6 - (3e-6 * np.cos(angle) + 4e-6 * np.sin(angle))
    assert found.number == 2
    assert found.depth == pytest.approx(expected, abs=1e-10)
    assert [found.s[0], found.s[-1]] == pytest.approx([-0.64e-3, 0.64e-3], abs=3e-5)
    assert np.all(np.diff(found.s) > 0.0)
    assert not found.tilt.any()


def test_a_leaning_roller_is_deeper_at_one_end():
    given = case(defect=SLOT | {"angle": "20 deg"}, model="spatial", record=[*RECORD, "roller.2.tilt"])
    [defect] = defects_of(given)
    still = dict.fromkeys(dataset_names("ring.displacement"), 0.0)
    found = roller_path(job_of(given, **{"roller.2.radial": 0.0, "roller.2.tilt": 1e-3, **still}), given, defect)
    assert set(found.tilt) == {1e-3}
    assert found.depth_at(3e-3) == pytest.approx(found.depth + 3e-6)


def test_on_the_inner_race_inwards_is_deep_and_rollers_come_from_ahead():
    """The race is faster than they are: what deepens as the roller goes on deepens towards -s."""
    record = [RECORD[0], "roller.2.tilt"]
    given = case(defect=SLOT | {"race": "inner", "angle": "-110 deg"}, model="spatial", record=record)
    [defect] = defects_of(given)
    ramps = {"roller.2.radial": lambda angle: -5e-6 - 2e-5 * angle, "roller.2.tilt": lambda angle: 1e-3 * angle}
    found = roller_path(job_of(given, **ramps), given, defect)
    start = -0.6 + 2.0 * math.pi / 13
    faster = given.speed - OMEGA_C
    met = math.radians(110.0) + start - given.speed * given.settle_s  # what the ring must still turn further
    time = (met % (2.0 * math.pi) - found.s / 0.0265) / faster
    angle = start + OMEGA_C * time
    assert np.all(np.diff(found.s) > 0.0)
    assert [found.s[0], found.s[-1]] == pytest.approx([-0.64e-3, 0.64e-3], abs=6e-5)
    assert found.depth == pytest.approx(5e-6 + 2e-5 * angle, abs=1e-9)
    assert found.tilt == pytest.approx(-1e-3 * angle, abs=1e-7)


@pytest.mark.parametrize(
    "missing", [{"record": RECORD[:1]}, {"record": RECORD[1:]}, {"defect": SLOT | {"angle": "-90 deg"}}]
)
def test_without_a_record_or_a_passage_there_is_no_path(missing):
    given = case(**{"defect": SLOT | {"angle": "20 deg"}, "model": "rollers", "record": RECORD} | missing)
    [defect] = defects_of(given)
    names = {name: 0.0 for channel in given.record for name in dataset_names(channel)}
    assert roller_path(job_of(given, **names), given, defect) is None


def test_a_roller_presses_where_its_path_is_below_the_round_roller_s():
    """A computed one falls 4.9 um into the slot of 0.8 mm, and strikes the far edge 0.14 mm behind the middle."""
    kept = ["roller.1.radial", "roller.1.outer_force", "ring.displacement"]
    times = {"sampling": "100 kHz", "duration": "20 ms", "settle": "0 ms", "antialias": False}
    given = case(defect=SLOT, model="rollers", start_angle="-60 deg", record=kept, **times)
    made = simulate(given)
    job = Job(flat_parameters(given), made.info, Series(made.time, made.series, {}))
    [defect] = defects_of(given)
    found, passage = roller_path(job, given, defect), first_passage(job, given, 1, "outer")
    over = cut(defect, 0.0)
    sinks = np.interp(found.s, over.s, over.h)
    force = np.interp(passage.time + found.s / passage.speed, made.time, made.series["roller.1.outer_force"])
    pressed, lifted = found.depth > sinks + 5e-8, found.depth < sinks - 5e-8
    assert pressed.sum() > 20
    assert lifted.sum() > 10
    assert np.mean(force[pressed] > 1.0) > 0.9  # damping lets go of what springs back fast
    assert abs(force[lifted]).max() == 0.0
    assert found.depth.max() == pytest.approx(4.9e-6, rel=0.05)
    assert found.s[np.argmax(found.depth)] == pytest.approx(0.13e-3, abs=2e-5)


def test_the_path_taken_lies_over_the_sections(results, monkeypatch):
    def made(given):
        time = np.arange(round(given.duration * given.sampling)) / given.sampling
        worth = {"roller.2.radial": 3e-6, "ring.displacement.x": 0.0, "ring.displacement.y": 0.0}
        series = {name: np.full(len(time), worth[name]) for c in given.record for name in dataset_names(c)}
        return SimpleNamespace(time=time, series=series, features={}, info={"cage_angle_start_rad": -0.6})

    monkeypatch.setattr("tests.plots.test_plots.record", made)
    text = STUDY.replace("[static, ring]", "[rollers]") + f"record: [{', '.join(RECORD)}]\n"
    opened = results(text)
    _, canvas = drawn(opened, kind="pit", jobs=opened.jobs[:2])[0]
    taken = [line for ax in canvas.axes for line in ax.lines if line.get_label() == "path it took"]
    depths = [np.asarray(line.get_ydata()) for line in taken]
    assert [depth.min() for depth in depths] == pytest.approx([1.75] * 3, rel=1e-5)  # clearance 5 um
    titles = [ax.get_title(loc="left") for ax in canvas.axes[1:4]]
    assert titles == [
        "(b) section A, heights ×5",
        "(c) section A, closer, heights ×20",
        "(d) section A, closer, heights ×100",
    ]
    caption = canvas.get_supxlabel().replace("\u00a0", " ").replace("\n", " ")
    assert "path of roller 2 at length 3 mm, load 150 N, model rollers" in caption
