"""Features of extensions: missing values are reported, failing or undeclared functions are refused by name."""

from math import inf, nan

import numpy as np
import pandas as pd
import pytest

from bearingsim import catalogue
from bearingsim.assemble.registered import check_features
from bearingsim.catalogue import Feature
from bearingsim.config import FEATURES
from bearingsim.errors import UserError
from bearingsim.extensions import BrokenExtension
from bearingsim.runner.findings import missing_values
from bearingsim.runner.work import _failure
from bearingsim.simulation import record, simulate
from bearingsim.simulation.features import compute_extension_features, compute_features, refuse_undeclared
from bearingsim.study.used import extensions
from tests.scenes.short_cases import case

TIME, SERIES = np.zeros(2), {"ring.velocity.x": np.array([1.0, 3.0])}
NO_FUNCTION = 3


def mean(case, time, series):
    return series["ring.velocity.x"].mean()


def of_tilt(case, time, series):
    return series["roller.tilt"].max()


def infinite(case, time, series):
    return -inf


def undefined(case, time, series):
    return nan


def of_dictionary(case, time, series):
    return dict[str, float]()["roller.tilt"]


def array_result(case, time, series):
    return series["ring.velocity.x"]


def none_result(case, time, series):
    return None


def complex_result(case, time, series):
    return np.fft.rfft(series["ring.velocity.x"])[0] * 1j


def text_result(case, time, series):
    return "5"


def array_of_one_number(case, time, series):
    return np.asarray(series["ring.velocity.x"].max())


def changed_series(case, time, series):
    velocity = series["ring.velocity.x"]
    velocity -= velocity.mean()
    return velocity.max()


def changed_time(case, time, series):
    time += 1.0
    return time[0]


def exit_process(case, time, series):
    raise SystemExit(3)


def register_feature(monkeypatch: pytest.MonkeyPatch, function: str) -> None:
    """Register `mine` as the only feature of an extension."""
    feature = Feature("mine", "m/s", "mine", f"{__name__}:{function}")
    monkeypatch.setattr("bearingsim.catalogue.FEATURES", {"mine": feature})
    for module in ("simulation.features", "assemble.registered"):
        monkeypatch.setattr(f"bearingsim.{module}.FEATURES", {"mine": feature})


def declare_feature(monkeypatch: pytest.MonkeyPatch) -> None:
    """Add `mine` to the declared features."""
    for module in ("simulation.features", "assemble.registered"):
        monkeypatch.setattr(f"bearingsim.{module}.DECLARED", {**FEATURES, "mine": FEATURES["velocity.rms"]})


def compute_own_features() -> tuple[dict[str, float], dict[str, str]]:
    return compute_extension_features(case(), TIME, SERIES)


def test_finite_number_is_the_value(monkeypatch) -> None:
    register_feature(monkeypatch, "mean")
    assert compute_own_features() == ({"mine": 2.0}, {})


MISSING_VALUES = {
    "of_tilt": "`roller.tilt` is not recorded",
    "infinite": "computed as -inf",
    "undefined": "computed as nan",
}


@pytest.mark.parametrize("function", MISSING_VALUES)
def test_non_finite_value_becomes_nan_with_a_reason(function, monkeypatch) -> None:
    register_feature(monkeypatch, function)
    values, facts = compute_own_features()
    assert np.isnan(values["mine"])
    assert facts == {"no_value.mine": MISSING_VALUES[function]}


READ_ONLY = r"fails \(ValueError: output array is read-only\)$"
FAILING = {
    "of_dictionary": rf"of_dictionary` of the extension `{__name__}` fails \(KeyError: 'roller.tilt'\)$",
    "array_result": "array_result` returned a ndarray, not a real number$",
    "none_result": "none_result` returned a NoneType, not a real number$",
    "complex_result": "complex_result` returned a complex128, not a real number$",
    "text_result": "text_result` returned a str, not a real number$",
    "changed_series": rf"changed_series` of the extension `{__name__}` {READ_ONLY}",
    "changed_time": rf"changed_time` of the extension `{__name__}` {READ_ONLY}",
    "exit_process": rf"exit_process` of the extension `{__name__}` fails \(SystemExit: 3\)$",
}


def test_array_of_no_dimension_is_a_number(monkeypatch) -> None:
    register_feature(monkeypatch, "array_of_one_number")
    assert compute_own_features() == ({"mine": 3.0}, {})


def test_features_cannot_change_the_record(monkeypatch) -> None:
    """The record is stored after the features of extensions are computed."""
    before = {name: values.copy() for name, values in SERIES.items()}
    for function in ("changed_series", "changed_time"):
        register_feature(monkeypatch, function)
        with pytest.raises(BrokenExtension):
            compute_own_features()
    assert all(np.array_equal(SERIES[name], values) for name, values in before.items())
    assert not TIME.any()


@pytest.mark.parametrize("function", FAILING)
def test_failing_function_is_named(function, monkeypatch) -> None:
    """A KeyError within the function does not mean that a series is missing."""
    register_feature(monkeypatch, function)
    with pytest.raises(BrokenExtension, match=f"^feature `mine`: `{__name__}:{FAILING[function]}"):
        compute_own_features()


def test_missing_values_are_reported_once_per_reason() -> None:
    facts = pd.DataFrame(
        {"method": ["verlet"] * 4, "no_value.mine": ["", "computed as inf", "computed as inf", "computed as nan"]},
        index=["a", "b", "c", "d"],
    )
    assert list(missing_values(facts)) == [
        "feature `mine` has no value in 2 of 4 jobs: computed as inf (for example b)",
        "feature `mine` has no value in 1 of 4 jobs: computed as nan (d)",
    ]
    assert list(missing_values(facts[["method"]])) == []


def test_jobs_that_need_different_durations_have_one_reason() -> None:
    """In a design each job has a frequency, and thus a duration, of its own; the longest suffices for all."""
    reason = "a `duration` of {} s separates it from {}"
    reasons = [reason.format(0.21, "fr"), reason.format(1.02, "fr"), reason.format(0.3, "FTF"), "too short"]
    facts = pd.DataFrame({"no_value.velocity@2BSF": reasons}, index=list("abcd"))
    assert list(missing_values(facts)) == [
        f"feature `velocity@2BSF` has no value in 1 of 4 jobs: {reasons[2]} (c)",
        f"feature `velocity@2BSF` has no value in 2 of 4 jobs: {reasons[1]} (for example b)",
        "feature `velocity@2BSF` has no value in 1 of 4 jobs: too short (d)",
    ]


@pytest.mark.parametrize("function", ["NO_FUNCTION", "not_there", "mean"])
def test_unusable_feature_is_refused_before_the_run(function, monkeypatch) -> None:
    """Before the run: no function, not loadable, or registered too late."""
    register_feature(monkeypatch, function)
    messages = {
        "NO_FUNCTION": "^feature `mine`: `.*` is not a function$",
        "not_there": f"^`.*:not_there` of the extension `{__name__}` does not load",
        "mean": "^feature `mine` is not declared; register it in the module of its entry point$",
    }
    with pytest.raises(UserError, match=messages[function]):
        check_features()


def test_a_declared_feature_is_accepted(monkeypatch) -> None:
    register_feature(monkeypatch, "mean")
    with pytest.raises(UserError, match="feature `mine` is not declared"):
        check_features()
    declare_feature(monkeypatch)
    check_features()
    refuse_undeclared(["mine", "velocity.rms"])


def test_undeclared_computed_feature_is_refused(monkeypatch) -> None:
    """The failed job has the same message, without the name of the exception class."""
    monkeypatch.setattr(
        record, "compute_features", lambda *run: compute_features(*run) | {"velocity.skewness": 0.0}
    )
    message = "feature `velocity.skewness` is computed but not declared: add it to config/names.py"
    with pytest.raises(UserError, match=f"^{message}$") as caught:
        simulate(case(model="static", duration=0.02))
    assert _failure("abc", caught.value).reason == message


def test_feature_of_an_extension_is_part_of_every_id(monkeypatch) -> None:
    """Ids contain the digest of the package; without features of extensions they contain none."""
    assert extensions(case()) == {}
    register_feature(monkeypatch, "mean")
    assert extensions(case()) == {"extensions": catalogue.extension_digest()}
