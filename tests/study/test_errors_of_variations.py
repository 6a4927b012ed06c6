"""Errors of uncertain parameters from the features of variations, which may be chaotic."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from bearingsim.runner.variations import CHANGE_MEANING, variation_effects
from bearingsim.store.spread import spread, standard_error, variation_errors
from bearingsim.study import StudyError, load_study
from tests.scenes.study_text import BASE, Write

# Chaos


def synthetic_plan(**columns: Any) -> tuple[dict[str, Any], pd.DataFrame]:
    """Plan of job `a` with the variations `b` and `c` of damping, and a frame of their features."""
    plan = {
        "variations": [{"of": "a", "what": "damping", "value": v, "job": j} for v, j in ((1e-6, "b"), (1e-5, "c"))]
    }
    return plan, pd.DataFrame({f"features/{name}": values for name, values in columns.items()}, index=list("abc"))


CHAOTIC = {
    "velocity@BPFO": [10.0, 12.0, 9.0],
    "velocity@BPFO-scatter": [0.5, 0.7, 0.1],
    "velocity.rms": [100.0, 90.0, 105.0],
    "outer_force.max": [200.0, 220.0, 210.0],
    "chaotic": [0.0, 1.0, 0.0],
    "rms_scatter": [0.0, 0.25, 0.0],
    "error.start.force": [0.0, 0.0, 0.0],
}


def test_a_chaotic_value_counts_with_its_standard_error() -> None:
    """Of `b` alone: 12 +- 0.7, and 90 +- 9, since the scatter is 2.5 standard deviations."""
    plan, frame = synthetic_plan(**CHAOTIC)
    assert list(standard_error(frame, "velocity@BPFO")) == [0.0, 0.7, 0.0]
    assert list(standard_error(frame, "velocity.rms")) == pytest.approx([0.0, 9.0, 0.0])
    assert spread(plan, frame, "velocity@BPFO").loc["a"].to_dict() == {
        "least": 9.0,
        "largest": 12.7,
        "chaotic": True,
    }
    row = variation_errors(plan, frame).loc["a"]
    assert row["error.damping"] == pytest.approx((12.7 - 9.0) / 10.0)
    assert row["error.damping.rms"] == pytest.approx((105.0 - 81.0) / 100.0)
    assert row["error.damping.force"] == pytest.approx(20.0 / 200.0)


def test_unknown_standard_error_gives_no_rms_error() -> None:
    """An RMS of unknown standard error has no range; the line has one."""
    plan, frame = synthetic_plan(**CHAOTIC | {"rms_scatter": [0.0, math.inf, 0.0]})
    result = variation_errors(plan, frame)
    assert "error.damping.rms" not in result
    assert result["error.damping"].loc["a"] > 0.0


def test_standard_error_from_blocks_of_the_record_comes_before_that_of_the_pilots() -> None:
    scatter = {"rms_scatter": [0.0, math.inf, 0.0], "standard_error.rms": [math.nan, 0.05, math.nan]}
    plan, frame = synthetic_plan(**CHAOTIC | scatter)
    assert spread(plan, frame, "velocity.rms").loc["a", "least"] == pytest.approx(0.95 * 90.0)


def test_range_of_a_non_negative_feature_ends_at_zero() -> None:
    plan, frame = synthetic_plan(**CHAOTIC | {"velocity@BPFO-scatter": [0.0, 20.0, 0.0]})
    assert spread(plan, frame, "velocity@BPFO").loc["a", "least"] == 0.0


def test_a_job_with_a_variation_that_failed_has_no_range() -> None:
    """The range of the other variations would look complete."""
    plan, frame = synthetic_plan(**CHAOTIC)
    frame.loc["b"] = np.nan
    assert spread(plan, frame, "velocity@BPFO").empty
    assert "error.damping" not in variation_errors(plan, frame)


def test_a_phase_has_no_range() -> None:
    plan, frame = synthetic_plan(**{"velocity@BPFO.phase": [3.1, -3.1, 3.0]})
    assert spread(plan, frame, "velocity@BPFO.phase").empty


def test_a_job_that_failed_itself_has_neither_range_nor_error() -> None:
    plan, frame = synthetic_plan(**CHAOTIC)
    frame.loc["a"] = np.nan
    assert spread(plan, frame, "velocity@BPFO").empty
    assert "error.damping" not in variation_errors(plan, frame)


def test_line_is_that_of_the_defective_element() -> None:
    columns = CHAOTIC | {"velocity@BPFI": [1.0, 2.0, 3.0], "chaotic": [0.0] * 3}
    plan, frame = synthetic_plan(**columns)
    frame["parameters/defects.1.race"] = "inner"
    assert variation_errors(plan, frame).loc["a", "error.damping"] == pytest.approx(2.0)


def test_effect_on_a_single_job_is_no_maximum() -> None:
    plan, frame = synthetic_plan(**CHAOTIC)
    plan |= {"jobs": [SimpleNamespace(job=name) for name in "abc"], "units": {}}
    changes = "velocity@BPFO by 37 %, velocity.rms by 24 %, outer_force.max by 10 %"
    text = f"damping 1 to 10 us changes {changes} {CHANGE_MEANING}"
    chaotic = "1 of 2 damping variations are chaotic; the change includes their standard errors"
    assert list(variation_effects(plan, frame)) == [text, chaotic]
    frame["features/chaotic"] = 0.0
    assert list(variation_effects(plan, frame)) == [text.replace("37", "30").replace("24", "15")]


def test_value_without_a_valid_case_is_refused(write: Write) -> None:
    with pytest.raises(StudyError) as error:
        load_study(write(BASE + "uncertainty: {clearance: [0 um, 5 mm]}\n"))
    assert "uncertainty.clearance: a clearance of 2500 um is beyond" in str(error.value)


DRAWN = CHAOTIC | {"acceleration.rms": [100.0, 90.0, 105.0]}


def test_effect_is_that_on_the_features_of_the_figures() -> None:
    plan, frame = synthetic_plan(**DRAWN)
    text, _ = variation_effects(plan, frame, ["acceleration.rms", "velocity@BPFO", "velocity@FTF"])
    assert text == f"damping 1 to 10 us changes acceleration.rms by 24 %, velocity@BPFO by 37 % {CHANGE_MEANING}"


def test_effect_counts_the_cases_of_unknown_range() -> None:
    """The RMS of `b` has an unknown standard error; case `d`, with one variation, has a range of 50 %."""
    plan, frame = synthetic_plan(**DRAWN | {"rms_scatter": [0.0, math.inf, 0.0]})
    text, _ = variation_effects(plan, frame, ["acceleration.rms", "velocity@BPFO"])
    changes = "acceleration.rms by an unknown amount, velocity@BPFO by 37 %"
    assert text == f"damping 1 to 10 us changes {changes} {CHANGE_MEANING}"
    frame.loc["d"], frame.loc["e"] = frame.loc["a"], frame.loc["a"] * 1.5
    plan["variations"].append({"of": "d", "what": "damping", "value": 1e-5, "job": "e"})
    text, _ = variation_effects(plan, frame, ["acceleration.rms"])
    changes = "acceleration.rms by up to 50 % (range unknown in 1 of 2 cases)"
    assert text == f"damping 1 to 10 us changes {changes} {CHANGE_MEANING}"
