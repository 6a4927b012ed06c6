"""Diagnosis of measured signals. Run if BEARINGSIM_MEASURED names their folder.

Files: two of the CWRU Bearing Data Center (drive end, 6205-2RS, 1796 rpm; 130: 0.007 in. fault of the outer race,
97: healthy), as .npz with x, fs, rpm; three of the Harbin Institute of Technology (6205; two with an outer-race
arc of 8 deg, 3.28 mm, Wang 2022), as .mat, 51 200 Hz.
"""

import json
import os
from pathlib import Path

import pytest

from tests.scenes.commands import type_

FOLDER = os.environ.get("BEARINGSIM_MEASURED", "")
pytestmark = pytest.mark.skipif(not FOLDER, reason="BEARINGSIM_MEASURED names no folder of measured signals")

HIT = ["--rate", "51.2 kHz"]
DAMAGED = {
    "cwru_130_OR007_6_DE.npz": (1796, [], 107.61),
    "hit_spectraquest_OR8_900.mat": (900, HIT, 53.91),
    "hit_spectraquest_OR8_600.mat": (600, HIT, 35.94),
}
"""Speed (rpm), options, and the strongest line (Hz) of the squared-envelope spectrum, by file."""
HEALTHY = {"cwru_97_normal_DE.npz": (1796, []), "hit_spectraquest_Normal_900.mat": (900, HIT)}
WRONG = [("6205", 1.1), ("6205", 0.93), ("6205", 1.05), ("nf308", 1.0), ("nu206", 1.0)]


def analysis(name, rpm, options, bearing="6205"):
    words = ["analyze", Path(FOLDER, name), "--bearing", bearing, "--speed", f"{rpm} rpm", *options, "--json"]
    return json.loads(type_(*words)[0])


@pytest.mark.parametrize("name", DAMAGED)
def test_the_damaged_race_is_named_at_its_line(name):
    rpm, options, line = DAMAGED[name]
    values = analysis(name, rpm, options)
    assert values["verdict"] == "outer"
    assert values["races"]["outer"]["found_hz"] == pytest.approx(line, rel=2e-3)
    assert values["races"]["outer"]["score_db"] > values["threshold_db"] + 3.0


@pytest.mark.parametrize("name", HEALTHY)
def test_healthy_bearings_have_no_line(name):
    assert analysis(name, *HEALTHY[name])["verdict"] == "none"


@pytest.mark.parametrize("name", DAMAGED)
@pytest.mark.parametrize(("bearing", "factor"), WRONG)
def test_a_wrong_speed_or_bearing_names_no_race(name, bearing, factor):
    rpm, options, _ = DAMAGED[name]
    assert analysis(name, rpm * factor, options, bearing)["verdict"] in ("other rhythm", "none")


@pytest.mark.parametrize("name", DAMAGED)
@pytest.mark.parametrize("factor", [1.0, 2.0])
def test_twice_the_speed_is_suspected(name, factor):
    rpm, options, _ = DAMAGED[name]
    assert analysis(name, rpm * factor, options)["speed_may_be_doubled"] is (factor == 2.0)


@pytest.mark.parametrize("name", ["hit_spectraquest_OR8_900.mat", "hit_spectraquest_OR8_600.mat"])
def test_the_width_of_an_arc_is_covered(name):
    low, high = analysis(name, *DAMAGED[name][:2])["width_mm"]
    assert low < 3.28 < high
