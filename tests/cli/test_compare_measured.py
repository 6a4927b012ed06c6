"""A simulation beside a recording. Run if BEARINGSIM_MEASURED names its folder.

Harbin Institute of Technology, 6205, arc of 8 deg in the outer race, 900 rpm, 51 200 Hz (Wang 2022). Depth of the
arc and load are unknown, so levels are not compared.
"""

import json
import os
from pathlib import Path

import pytest

from tests.conftest import ROOT
from tests.scenes.commands import type_

FOLDER = os.environ.get("BEARINGSIM_MEASURED", "")
pytestmark = pytest.mark.skipif(not FOLDER, reason="BEARINGSIM_MEASURED names no folder of measured signals")


def test_rhythm_and_double_impulse_agree(tmp_path):
    results = tmp_path / "results"
    type_("run", ROOT / "studies/measured/hit_6205_arc.yaml", "--jobs", 1, "--out", results)
    file = Path(FOLDER, "hit_spectraquest_OR8_900.mat")
    values = json.loads(type_("compare", results, file, "--rate", "51.2 kHz", "--unit", "g", "--json")[0])
    features = values["features"]
    for name, tolerance in (("line", 0.005), ("entry_to_exit_of_a_pass", 0.05)):
        assert features[name]["simulated"] == pytest.approx(features[name]["measured"], rel=tolerance), name
    for source in ("simulated", "measured"):
        assert 0.0 > features["envelope_harmonic_2"][source] > features["envelope_harmonic_3"][source]
