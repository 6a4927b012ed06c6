"""Features of other packages: what has no number is said, what fails or is not declared is refused by name."""

from importlib import import_module
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
from bearingsim.simulation.features import extension_features, refuse_undeclared
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


def whole(case, time, series):
    return series["ring.velocity.x"]


def nothing(case, time, series):
    return None


def leaves(case, time, series):
    raise SystemExit(3)


def register_feature(monkeypatch: pytest.MonkeyPatch, function: str) -> None:
    """Let one feature, `mine`, be that of another package."""
    feature = Feature("mine", "m/s", "mine", f"{__name__}:{function}")
    monkeypatch.setattr("bearingsim.catalogue.FEATURES", {"mine": feature})
    for module in ("simulation.features", "assemble.registered"):
        monkeypatch.setattr(f"bearingsim.{module}.FEATURES", {"mine": feature})


def declare_feature(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let `mine` be among the declared features."""
    for module in ("simulation.features", "assemble.registered"):
        monkeypatch.setattr(f"bearingsim.{module}.DECLARED", {**FEATURES, "mine": FEATURES["velocity.rms"]})


def compute_features() -> tuple[dict[str, float], dict[str, str]]:
    return extension_features(case(), TIME, SERIES)


def test_finite_number_is_the_value(monkeypatch) -> None:
    register_feature(monkeypatch, "mean")
    assert compute_features() == ({"mine": 2.0}, {})


VALUELESS = {
    "of_tilt": "`roller.tilt` is not recorded",
    "infinite": "computed as -inf",
    "undefined": "computed as nan",
}


@pytest.mark.parametrize("function", VALUELESS)
def test_non_finite_value_becomes_nan_with_a_reason(function, monkeypatch) -> None:
    register_feature(monkeypatch, function)
    values, facts = compute_features()
    assert np.isnan(values["mine"])
    assert facts == {"no_value.mine": VALUELESS[function]}


FAILING = {
    "of_dictionary": rf"of_dictionary` of the extension `{__name__}` fails \(KeyError: 'roller.tilt'\)$",
    "whole": "whole` gives a ndarray, not a number$",
    "nothing": "nothing` gives a NoneType, not a number$",
    "leaves": rf"leaves` of the extension `{__name__}` fails \(SystemExit: 3\)$",
}


@pytest.mark.parametrize("function", FAILING)
def test_failing_function_is_named(function, monkeypatch) -> None:
    """A KeyError of its own is no series that is missing."""
    register_feature(monkeypatch, function)
    with pytest.raises(BrokenExtension, match=f"^feature `mine`: `{__name__}:{FAILING[function]}"):
        compute_features()


def test_missing_values_are_reported_once_per_reason() -> None:
    facts = pd.DataFrame(
        {"method": ["verlet"] * 4, "no_value.mine": ["", "computed as inf", "computed as inf", "computed as nan"]},
        index=["a", "b", "c", "d"],
    )
    assert list(missing_values(facts)) == [
        "feature `mine` has no value in 2 of 4 jobs: computed as inf (for example b)",
        "feature `mine` has no value in 1 of 4 jobs: computed as nan (for example d)",
    ]
    assert list(missing_values(facts[["method"]])) == []


@pytest.mark.parametrize("function", ["NO_FUNCTION", "not_there", "mean"])
def test_unusable_feature_is_refused_before_the_run(function, monkeypatch) -> None:
    """Before anything runs: what is no function, what does not load, and what was registered too late."""
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
    declare_feature(monkeypatch)
    check_features()
    refuse_undeclared(["mine", "velocity.rms"])


def test_undeclared_computed_feature_is_refused(monkeypatch) -> None:
    """The failure of its job says so, without the name of a class before it."""
    simulating = import_module("bearingsim.simulation.simulate")  # its name is also a function's
    original = simulating.features
    monkeypatch.setattr(simulating, "features", lambda *run: original(*run) | {"velocity.skewness": 0.0})
    message = "feature `velocity.skewness` is computed but not declared: add it to config/names.py"
    with pytest.raises(UserError, match=f"^{message}$") as caught:
        simulating.simulate(case(model="static", duration=0.02))
    assert _failure("abc", caught.value).reason == message


def test_feature_of_an_extension_is_part_of_every_id(monkeypatch) -> None:
    """The sources of its package are; without one a case of the program's own has none."""
    assert extensions(case()) == {}
    register_feature(monkeypatch, "mean")
    assert extensions(case()) == {"extensions": catalogue.extension_digest()}
