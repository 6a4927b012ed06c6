"""Records that end as soon as line and RMS are known well enough."""

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from bearingsim import simulate
from bearingsim.simulation.accuracy import MIN_PASSES
from tests.scenes.short_cases import SLOT, case

CHATTERS: dict[str, Any] = {"model": "rollers", "defect": SLOT | {"depth": "5 um", "angle": "20 deg"}}
CHATTERS |= {"speed": "1200 rpm", "clearance": "10 um", "record": [], "duration": "1 s", "step_check": False}
CHATTERS |= {"contact": {"damping": {"law": "kraemer", "beta": "1 us"}}}


def test_a_record_ends_when_it_is_accurate_enough() -> None:
    whole, short = (
        simulate(case(**CHATTERS)),
        simulate(case(**CHATTERS, until="2 %")),
    )
    assert whole.info["passes_computed"] == whole.info["passes"]
    assert MIN_PASSES < float(short.info["passes_computed"]) < 0.5 * float(whole.info["passes_computed"])
    for name, error in (("velocity@BPFO", "standard_error_line"), ("velocity.rms", "standard_error_rms")):
        stated = float(short.info[error])
        assert 0.0 < stated <= 0.02
        assert abs(short.features[name] / whole.features[name] - 1.0) < 3.0 * stated
    assert short.features["load_zone.extent"] == pytest.approx(whole.features["load_zone.extent"], rel=0.01)
    assert np.isfinite(short.features["outer_force.max"])


def test_what_is_not_accurate_enough_takes_its_whole_duration() -> None:
    found = simulate(case(**CHATTERS | {"duration": "0.2 s"}, until="0.01 %"))
    assert found.info["passes_computed"] == found.info["passes"]
    assert float(found.info["standard_error_rms"]) > 1e-4


def test_what_repeats_is_known_exactly() -> None:
    found = simulate(case(defect=SLOT, record=[], until="0.5 %"))
    assert (found.info["standard_error_line"], found.info["standard_error_rms"]) == (0.0, 0.0)
    assert float(found.info["passes_computed"]) < MIN_PASSES


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"record": ["ring.velocity"]}, "has no series"),
        ({"record": [], "model": "rollers", "defect": SLOT | {"race": "inner"}}, "a pit turns"),
        ({"record": [], "model": "planar"}, "the cage is free"),
        ({"record": [], "model": "impulse", "defect": SLOT}, "the model does not say"),
        ({"record": [], "antialias": False}, "low-passed"),
        ({"record": [], "step_check": "strict"}, "the whole record"),
    ],
)
def test_it_is_refused_where_passes_are_not_alike_or_series_are_wanted(
    fields: dict[str, Any], reason: str
) -> None:
    with pytest.raises(ValidationError, match=reason):
        case(**fields, until="1 %")
