"""Uncertain parameters on the page: ranges of the features of the figures, and where they stand."""

import numpy as np
import pytest

from bearingsim.report.headline import feature_results
from tests.plots.test_plots import STUDY, results

__all__ = ["results"]

UNCERTAIN = STUDY.replace("model: [static, ring]", "model: [ring]") + (
    "uncertainty: {damping: [1 us, 5 us], clearance: [0 um, 5 um]}\n"
    "figures: [{y: [acceleration.rms, velocity@BPFO], x: defect.length}]\n"
)


@pytest.fixture
def uncertain(results):
    """Results of a study with variations; column ``features/acceleration.rms`` is the number of the job (m/s²)."""
    opened = results(UNCERTAIN)
    opened._frame["features/acceleration.rms"] = np.arange(1.0, len(opened._frame) + 1.0)
    opened._table["acceleration.rms"] = (
        opened._frame["features/acceleration.rms"].reindex(opened._table["job"]).values
    )
    return opened


def test_each_feature_has_the_ranges_of_its_extreme_cases(uncertain):
    [rms, line] = feature_results(uncertain)
    numbers = uncertain._frame["features/acceleration.rms"]
    largest = numbers[
        [entry["job"] for entry in uncertain.plan["jobs"] if not entry["twin"] | entry["variation"]]
    ].idxmax()
    for quantity in ("damping", "clearance"):
        jobs = [v["job"] for v in uncertain.variations if (v["of"], v["what"]) == (largest, quantity)]
        ends = numbers[[largest, *jobs]]
        assert f"; {quantity}: {ends.min():.3g} to {ends.max():.3g} m/s²" in rms.remarks[-2]
    assert "damping" in line.remarks[-2]


def test_unknown_range_is_named_in_the_card(uncertain):
    uncertain._frame["features/chaotic"] = 1.0
    uncertain._frame["features/rms_scatter"] = np.inf
    [rms, _] = feature_results(uncertain)
    assert "; damping: range unknown; clearance: range unknown" in rms.remarks[-2]
