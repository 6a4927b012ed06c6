"""Records that end as soon as their features are accurate enough."""

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from bearingsim import simulate
from bearingsim.config import Case
from bearingsim.simulation import ending, try_out
from bearingsim.simulation.choice import resolve
from bearingsim.simulation.run_setup import set_up
from bearingsim.simulation.sufficiency import Inspections, batch_error
from bearingsim.simulation.time_grid import estimate
from bearingsim.simulation.trial import ReferenceValues
from tests.scenes.short_cases import SLOT, case

CHATTERS: dict[str, Any] = {"model": "rollers", "defect": SLOT | {"depth": "5 um", "angle": "20 deg"}}
CHATTERS |= {"speed": "1200 rpm", "clearance": "10 um", "record": [], "duration": "1 s", "step_check": False}
CHATTERS |= {"contact": {"damping": {"law": "kraemer", "beta": "1 us"}}}


def test_a_record_ends_when_it_is_accurate_enough() -> None:
    full, short = (
        simulate(case(**CHATTERS)),
        simulate(case(**CHATTERS, until="2 %")),
    )
    assert full.info["passes_computed"] == full.info["passes"]
    assert ending.MIN_PASSES < float(short.info["passes_computed"]) < 0.7 * float(full.info["passes_computed"])
    for name, error in (("velocity@BPFO", "standard_error_line"), ("velocity.rms", "standard_error_rms")):
        stated = float(short.info[error])
        assert 0.0 < stated <= 0.02
        assert abs(short.features[name] / full.features[name] - 1.0) < 3.0 * stated
    assert short.features["load_zone.extent"] == pytest.approx(full.features["load_zone.extent"], rel=0.01)
    assert np.isfinite(short.features["outer_force.max"])


def test_what_is_not_accurate_enough_takes_its_whole_duration() -> None:
    result = simulate(case(**CHATTERS | {"duration": "0.2 s"}, until="0.01 %"))
    assert result.info["passes_computed"] == result.info["passes"]
    assert float(result.info["standard_error_rms"]) > 1e-4


def test_what_repeats_is_known_exactly() -> None:
    result = simulate(case(defect=SLOT, record=[], until="0.5 %"))
    assert (result.info["standard_error_line"], result.info["standard_error_rms"]) == (0.0, 0.0)
    assert float(result.info["passes_computed"]) < ending.MIN_PASSES


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"record": ["ring.velocity"]}, "no series can be stored"),
        ({"record": [], "ramp": {"to": "1900 rpm", "time": "1 s"}}, "the speed changes"),
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


FREE: dict[str, Any] = {"model": "planar", "speed": "6000 rpm", "load": "100 N", "defect": SLOT, "record": []}


def test_a_record_with_a_free_cage_ends_early() -> None:
    """Its passes are correlated over tens of passes, so it holds five turns of the cage."""
    fields = FREE | {"duration": "0.4 s", "step_check": False}
    full, short = simulate(case(**fields)), simulate(case(**fields, until="1 %"))
    settling, passes = (float(short.info["settle_s"]) * 530.0, float(short.info["passes_computed"]))
    assert settling + 65 <= passes < 0.8 * float(full.info["passes_computed"])
    for name, error in (("velocity@BPFO", "standard_error_line"), ("velocity.rms", "standard_error_rms")):
        stated = float(short.info[error])
        assert 0.0 < stated <= 0.01
        assert abs(short.features[name] / full.features[name] - 1.0) < 3.0 * stated
    assert np.isnan(full.info["standard_error_rms"])


def turning(race: str) -> Case:
    defect = SLOT | {"race": race, "length": "5 mm"}
    return case(model="rollers", defect=defect, record=[], until="0.5 %", duration="4 s")


@pytest.mark.parametrize("race", ["inner", "roller"])
def test_a_record_over_a_defect_that_turns_holds_nearly_whole_turns(race: str) -> None:
    test_case = turning(race)
    [turn] = ending.turn_lengths(test_case)
    inspections = [*ending.inspection_passes(test_case)]
    assert len(inspections) > 4
    for passes in inspections:
        assert passes >= max(ending.MIN_PASSES, 5 * test_case.bearing.rollers)
        assert abs(passes / turn - round(passes / turn)) * turn <= 0.001 * passes + 1e-9


def test_a_unit_of_passes_holds_nearly_whole_turns() -> None:
    assert [ending.unit(turning(race)) for race in ("outer", "inner", "roller")] == [2, 16, 13]


def test_a_record_without_until_is_not_inspected() -> None:
    assert [*ending.inspection_passes(case(**FREE))] == []


@pytest.mark.parametrize("correlation", [0.0, 0.9])
def test_batches_see_the_correlation_of_successive_values(correlation: float) -> None:
    """Two standard errors cover the mean of a first-order autoregression in 95 % at least."""
    generator = np.random.default_rng(5)
    covered = 0
    for _ in range(400):
        values = generator.standard_normal(400)
        for n in range(1, 400):
            values[n] += correlation * values[n - 1]
        covered += abs(values[100:].mean()) <= 2.0 * batch_error(values[100:])
    assert 0.95 * 400 <= covered < 400


def test_a_record_that_ends_early_is_priced_as_such() -> None:
    early, full = (estimate(case(**FREE, duration="1 s", **more)) for more in ({"until": "1 %"}, {}))
    assert early.cpu_seconds < 0.5 * full.cpu_seconds
    assert early.check_seconds < 0.6 * full.check_seconds
    assert early.most_seconds > early.cpu_seconds  # if it is never accurate enough


def test_a_trial_that_is_accurate_enough_is_the_record() -> None:
    test_case = case(**FREE, duration="0.4 s", until="1 %")
    record = simulate(test_case)
    result, of_trial = try_out(test_case, ["velocity@BPFO", "velocity.rms"], 65, 0.0, ReferenceValues({}, {}))
    assert of_trial is not None
    assert result.passes == 65
    assert of_trial.features == pytest.approx(record.features, rel=0.0, abs=0.0, nan_ok=True)
    computed, full, of_record = (
        float(of.info[name])
        for of, name in ((of_trial, "passes_computed"), (record, "passes"), (record, "passes_computed"))
    )
    assert computed == of_record < full


def test_a_trial_that_is_not_accurate_enough_is_no_record() -> None:
    test_case = case(**FREE, duration="0.4 s", until="0.0001 %", step_check=False)
    result, record = try_out(test_case, ["velocity@BPFO"], 65, 0.0, ReferenceValues({}, {}))
    assert record is None
    assert result.passes == 65


def test_the_step_is_checked_on_a_part_of_the_shortest_record() -> None:
    early, full = (
        Inspections(set_up(resolve(case(**FREE, duration="1 s", **more)), 1.0)) for more in ({"until": "1 %"}, {})
    )
    assert early.earliest.case.duration * 530.0 == pytest.approx(65.0)
    assert full.earliest is full.setup
