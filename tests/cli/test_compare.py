"""`bearingsim compare`: a job and a measured signal side by side."""

import json

import numpy as np
import pytest

from bearingsim import open_results
from tests.scenes.commands import type_

STUDY = """\
study: arc
bearing: 6205
speed: 900 rpm
load: 150 N
defect: {shape: rectangular, length: 7.94 mm, width: 3.28 mm, depth: 25 um}
model: rollers
duration: 1 s
sampling: 25.6 kHz
record: [ring.acceleration]
"""
G = 9.80665


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("arc")
    (folder / "arc.yaml").write_text(STUDY)
    type_("run", folder / "arc.yaml", "--jobs", 1, "--out", folder / "results")
    return folder / "results"


@pytest.fixture
def series(results):
    stored = open_results(results)
    damaged = [job for job in stored.jobs if "@" not in job][0]  # noqa: RUF015
    return stored.series(damaged)


def compared(*words):
    return json.loads(type_("compare", *words, "--json")[0])


def test_a_signal_equals_itself_in_another_unit(results, series, tmp_path):
    np.savez(tmp_path / "a.npz", x=series["ring.acceleration.x"].astype(float) / G, fs=25600.0, x_unit="g")
    values = compared(results, tmp_path / "a.npz")
    assert values["scale"] == 1.0
    assert values["band_hz"] == [0.0, 0.4 * 25600.0]
    for feature in values["features"].values():
        assert feature["simulated"] == pytest.approx(feature["measured"], rel=1e-6)
    features = values["features"]
    assert features["line"]["simulated"] == pytest.approx(3.5848, rel=1e-3)
    assert 0.1 < features["entry to exit, of a pass"]["simulated"] < 0.25
    assert features["RMS"]["unit"] == "m/s^2"


def test_nothing_is_scaled_without_the_option_which_prints_its_factor(results, series, tmp_path):
    np.savez(tmp_path / "a.npz", x=3.0 * series["ring.acceleration.x"].astype(float), fs=25600.0)
    words = [results, tmp_path / "a.npz", "--unit", "m/s^2"]
    values = compared(*words)["features"]["RMS"]
    assert values["measured"] == pytest.approx(3.0 * values["simulated"])
    scaled = compared(*words, "--scale")
    assert scaled["scale"] == pytest.approx(3.0)
    assert scaled["features"]["RMS"]["simulated"] == pytest.approx(scaled["features"]["RMS"]["measured"])
    assert "simulated signal times 3, to the measured RMS" in type_("compare", *words, "--scale")[0]


def test_lines_are_compared_in_orders_where_the_speeds_differ(results, series, tmp_path):
    fs = 25600.0 / 0.9  # the same passes in nine tenths of the time
    np.savez(tmp_path / "a.npz", x=series["ring.acceleration.x"].astype(float), fs=fs)
    features = compared(results, tmp_path / "a.npz", "--unit", "m/s^2", "--speed", "1000 rpm")["features"]
    for name in ("line", "entry to exit, of a pass"):
        assert features[name]["simulated"] == pytest.approx(features[name]["measured"], rel=5e-3), name


def test_text_and_figure(results, series, tmp_path):
    np.savez(tmp_path / "a.npz", x=series["ring.acceleration.x"].astype(float), fs=25600.0, x_unit="m/s^2")
    out = type_("compare", results, tmp_path / "a.npz", "--figure", tmp_path / "a.png")[0]
    assert "speed of the measurement: 900 rpm (the job; `--speed` gives another)" in out
    assert "both in the band 0 to 10.24 kHz" in out
    assert "entry to exit, of a pass" in out
    assert (tmp_path / "a.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("arrays", "words", "message"),
    [
        ({"x": 1}, [], "states no unit of `x`; ring.acceleration.x is in m/s^2: give `--unit`, one of m/s^2"),
        ({"x": 1, "x_unit": "V"}, [], "has `x` in `V`"),
        ({"x": 1, "y": 1, "unit": "g"}, [], "has 2 channels: name one by `--channel`, such as `x`"),
        ({"x": 1, "unit": "g"}, ["--y", "ring.velocity.x"], "not `ring.velocity.x`"),
        ({"x": 1, "unit": "g"}, ["--job", "zzz"], "no job begins with `zzz`"),
        ({"x": 0, "unit": "g"}, [], "is constant"),
    ],
)
def test_what_cannot_be_compared_is_refused(results, series, tmp_path, arrays, words, message):
    signal = series["ring.acceleration.x"].astype(float)
    content = {name: value * signal if isinstance(value, int) else value for name, value in arrays.items()}
    np.savez(tmp_path / "a.npz", **content, fs=25600.0)
    _, err = type_("compare", results, tmp_path / "a.npz", *words, code=2)
    assert message in " ".join(err.replace("│", " ").split())
