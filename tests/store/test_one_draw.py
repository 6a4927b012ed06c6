"""Standard errors of chaotic motions."""

import math

import pandas as pd
import pytest

from bearingsim.store import has_error_estimate, is_uncertain, relative_error
from bearingsim.store.spread import FORCE_ERROR, has_unknown_scatter, standard_error

LINE, RMS = "velocity@BPFO", "velocity.rms"
WITHOUT_ESTIMATE = ("velocity.kurtosis", "inner_force.max", "cage_force.max", "cage.slip.mean")


def table(chaotic: float = 1.0, line: float = 0.0, rms: float = 0.0, force: float = 0.0) -> pd.DataFrame:
    """Make a result with relative standard errors of line, RMS (stored times 2.5) and largest force."""
    row = {LINE: 2.0, f"{LINE}-scatter": 2.0 * line, RMS: 3.0, "rms_scatter": 2.5 * rms, "chaotic": chaotic}
    row |= {"velocity@BPFI": 1.0, "outer_force.max": 5.0, "error.start.force": force}
    return pd.DataFrame([row | dict.fromkeys(WITHOUT_ESTIMATE, 1.0)])


@pytest.mark.parametrize(
    ("feature", "results", "is_flagged"),
    [
        (LINE, table(line=0.006), True),
        (LINE, table(line=0.004, rms=0.1), False),
        (f"{LINE}-healthy", table(line=0.006), True),
        (f"{LINE}.phase", table(line=0.006), True),
        (RMS, table(rms=0.006), True),
        (RMS, table(rms=0.004, line=0.1), False),
        (RMS, table(rms=math.inf), True),
        ("velocity.rms@10-1000Hz", table(rms=0.006), True),
        ("acceleration.rms", table(rms=0.006).assign(**{"acceleration.rms": 1.0}), True),
        ("outer_force.max", table(force=0.006), True),
        ("outer_force.max", table(line=0.1, rms=0.1), False),
        ("outer_force.max", table().drop(columns="error.start.force"), True),  # not estimated
        ("velocity@BPFI", table(), True),
        *((feature, table(), True) for feature in WITHOUT_ESTIMATE),
        (LINE, table(chaotic=0.0, line=0.1), False),
        (LINE, table(chaotic=math.nan, line=0.1), False),
    ],
)
def test_a_result_is_flagged_by_its_own_standard_error(
    feature: str, results: pd.DataFrame, is_flagged: bool
) -> None:
    assert bool(is_uncertain(results, feature).iloc[0]) == is_flagged


def test_smaller_limit_flags_smaller_errors() -> None:
    assert is_uncertain(table(line=0.004), LINE, notable=0.003).iloc[0]


def test_only_an_rms_has_the_standard_error_of_the_velocity_rms() -> None:
    """With drag the slip of the cage scatters by 3 %, and the RMS by 0.1 %: the error of a slip is unknown."""
    for feature in WITHOUT_ESTIMATE:
        assert not has_error_estimate(table(rms=0.001), feature)
        assert math.isnan(relative_error(table(rms=0.001), feature).iloc[0])
    assert relative_error(table(rms=0.001, force=0.02), "outer_force.max").iloc[0] == pytest.approx(0.02)


def test_error_of_a_change_is_relative_to_the_change() -> None:
    """2 % of 10 m/s^2 are 40 % of a change by 0.5 m/s^2, whatever the RMS of the velocity."""
    results = table(rms=0.02).assign(**{"acceleration.rms": 10.0, "acceleration.rms-healthy": 0.5})
    assert relative_error(results, "acceleration.rms-healthy").iloc[0] == pytest.approx(0.4)


def test_results_that_were_not_checked_are_not_flagged() -> None:
    assert not is_uncertain(pd.DataFrame([{LINE: 2.0}]), LINE).iloc[0]


def test_block_errors_take_precedence_over_pass_errors() -> None:
    results = table(line=0.1, rms=0.1).assign(**{"standard_error.line": [0.004], "standard_error.rms": [0.006]})
    assert not is_uncertain(results, LINE).iloc[0]
    assert is_uncertain(results, RMS).iloc[0]
    assert is_uncertain(results.assign(**{"standard_error.line": [math.nan]}), LINE).iloc[0]
    assert is_uncertain(results.assign(**{"standard_error.line": [math.inf]}), LINE).iloc[0]


def test_early_record_has_the_standard_error_at_its_end() -> None:
    """This holds for lines and RMS values; for a full record the error counts only if it is chaotic."""
    features = table(chaotic=0.0, line=0.1).add_prefix("features/")
    columns = {"info/standard_error_line": 0.004, "info/standard_error_rms": 0.002, "info/passes": 200}
    early_end, full_record = (features.assign(**columns, **{"info/passes_computed": n}) for n in (130, 200))
    assert standard_error(early_end, LINE).iloc[0] == pytest.approx(0.004 * 2.0)
    assert standard_error(early_end, RMS).iloc[0] == pytest.approx(0.002 * 3.0)
    assert standard_error(early_end, "outer_force.max").iloc[0] == 0.0
    assert standard_error(full_record, LINE).iloc[0] == 0.0
    chaotic = early_end.assign(**{"features/chaotic": 1.0})
    assert not has_unknown_scatter(chaotic, "velocity@BPFI").iloc[0]
    assert has_unknown_scatter(full_record.assign(**{"features/chaotic": 1.0}), "velocity@BPFI").iloc[0]


def test_early_error_of_a_quiet_line_is_relative_to_the_rms() -> None:
    """A line below 1e-3 of the RMS has the error 0.4 % of 3e-3, a thousandth of the RMS, not of itself."""
    columns = {"info/standard_error_line": 0.004, "info/passes": 200, "info/passes_computed": 130}
    quiet = table(chaotic=0.0).assign(**{LINE: 6e-4}).add_prefix("features/").assign(**columns)
    assert standard_error(quiet, LINE).iloc[0] == pytest.approx(0.004 * 3e-3)


def test_a_chaotic_result_without_an_estimate_has_no_standard_error() -> None:
    """A standard error of 0 would give the result a range without width, and an error without scatter."""
    for feature in ("velocity@BPFI", "velocity.peak", "velocity.kurtosis", "inner_force.max"):
        columns = {f"features/{feature}": 1.0}
        for chaotic, is_unknown in ((1.0, True), (0.0, False)):
            results = table(chaotic=chaotic).add_prefix("features/").assign(**columns)
            assert math.isnan(standard_error(results, feature).iloc[0]) == is_unknown


def test_extreme_value_of_a_record_that_ended_early_has_unknown_scatter() -> None:
    """A periodic motion repeats its extremes."""
    features = table(chaotic=0.0).assign(**{"outer_force.max": 9.0}).add_prefix("features/")
    columns = {"info/standard_error_line": 0.0, "info/passes": 200, "info/passes_computed": 130}
    early_end, periodic = (features.assign(**columns, **{"info/standard_error_rms": e}) for e in (0.002, 0.0))
    assert has_unknown_scatter(early_end, "outer_force.max").iloc[0]
    assert not has_unknown_scatter(early_end, RMS).iloc[0]
    assert not has_unknown_scatter(periodic, "outer_force.max").iloc[0]
    full_record = early_end.assign(**{"info/passes_computed": 200})
    assert not has_unknown_scatter(full_record, "outer_force.max").iloc[0]


def test_largest_force_of_a_chaotic_motion_scatters_by_its_own_error() -> None:
    """It includes the standard error of the maxima; a periodic motion repeats its largest force."""
    features = table(rms=0.001).assign(**{"error.start.force": 0.03}).add_prefix("features/")
    assert standard_error(features, "outer_force.max").iloc[0] == pytest.approx(0.03 * 5.0)
    assert math.isnan(standard_error(features.assign(**{FORCE_ERROR: math.nan}), "outer_force.max").iloc[0])
    assert standard_error(features.assign(**{"features/chaotic": 0.0}), "outer_force.max").iloc[0] == 0.0
