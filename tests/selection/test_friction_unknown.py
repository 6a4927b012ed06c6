"""Friction whose effect is unknown, or largest where a curve does not show it."""

import numpy as np
import pytest

from bearingsim.selection import TrialRequest
from bearingsim.selection.candidates import WITH_FRICTION
from bearingsim.simulation.trial import Trial
from tests.scenes.study_text import Write
from tests.scenes.trials import OPEN, accuracy_study, choose, is_free, steady_trial, trial, trial_of_record


@pytest.mark.parametrize("change", [0.5, 0.01])
def test_case_whose_reference_fails_is_computed_with_friction(write: Write, change: float) -> None:
    def evaluate(request: TrialRequest) -> Trial | None:
        free = is_free(request.case)
        size = request.case.load * (1.0 + change * free)
        fails = request.case.load == 300.0 and not free
        return None if fails else trial(size, names=request.features, repeats=not free)

    result = choose(accuracy_study(write, OPEN), evaluate)
    assert result[1].candidate == WITH_FRICTION
    assert "the trial without friction fails" in result[1].why or change == 0.5


def test_ramp_is_computed_with_friction(write: Write) -> None:
    """It has no trials, because its first passes are not representative."""
    ramp = "ramp: {to: 7000 rpm, time: 50 ms}\n"

    def evaluate(request: TrialRequest) -> Trial:
        raise AssertionError(request)

    result = choose(accuracy_study(write, OPEN + ramp), evaluate)
    assert [choice.candidate for choice in result] == [WITH_FRICTION] * 3
    assert "ramp" in result[0].why
    result = choose(accuracy_study(write, OPEN + ramp + "friction: none\n"), evaluate)
    assert [choice.candidate for choice in result] == ["reference"] * 3


@pytest.mark.parametrize("order", ["outer, inner, roller", "inner, outer, roller", "outer, roller, inner"])
def test_every_case_is_tried_if_x_is_a_word(write: Write, order: str) -> None:
    """Only a defect of the inner race is sensitive to friction; it may be first, last or between others."""
    sweep = f"load: 300 N\nsweep: {{defect.race: [{order}]}}"
    text = OPEN.replace("sweep: {load: [150 N, 300 N, 450 N]}", sweep)
    sizes = {"outer": 3.0, "inner": 2.0, "roller": 1.0}

    def evaluate(request: TrialRequest) -> Trial:
        race, free = request.case.defects[0].race, is_free(request.case)
        change = 0.5 if race == "inner" and free else 0.0
        return steady_trial(request, sizes[race] * (1.0 + change), repeats=not free)

    study = accuracy_study(write, text.replace("velocity@BPFO, x: load", "velocity.rms, x: defect.race"))
    assert [choice.candidate for choice in choose(study, evaluate)] == [WITH_FRICTION] * 3


def test_unknown_friction_makes_a_model_inaccurate(write: Write, costs: dict[str, float]) -> None:
    """The trial at 150 N fails; elsewhere friction (3.5 %) and model (3 %) together are too much."""
    costs |= {"planar": 10.0, "rollers": 0.1, "ring": 10.0, "static": 10.0}

    def evaluate(request: TrialRequest) -> Trial | None:
        free = is_free(request.case)
        if free and request.case.load == 150.0:
            return None
        size = 100.0 * (1.035 if free else 1.0) * (1.03 if request.case.model == "rollers" else 1.0)
        return trial(size * (1.2 if request.case.load == 450.0 else 1.0), names=request.features)

    study = accuracy_study(write, OPEN.replace("150 N, 300 N", "150 N, 200 N, 300 N"))
    result = choose(study, evaluate)
    assert "rollers" not in [choice.candidate for choice in result]
    assert result[0].why == "the nearest cheaper model is 2.5 % off, and the effect of friction is unknown"


def test_friction_is_tried_at_the_largest_value_of_a_feature_without_figure(write: Write) -> None:
    """The RMS is largest at 300 N, and only there friction changes it."""
    text = OPEN.replace("accuracy: 5 %", "accuracy: {within: 5 %, of: [velocity@BPFO, velocity.rms]}")

    def evaluate(request: TrialRequest) -> Trial:
        free, is_middle = is_free(request.case), request.case.load == 300.0
        result = trial(request.case.load, names=request.features, repeats=not free)
        rms = (10.0 if is_middle else 1.0) * (1.5 if is_middle and free else 1.0)
        result.mean_squares["velocity.rms"] = np.full_like(result.mean_squares["velocity.rms"], rms**2)
        return result

    assert choose(accuracy_study(write, text), evaluate)[1].candidate == WITH_FRICTION


@pytest.mark.parametrize("name", ["velocity@BPFI", "velocity.rms", "outer_force.max"])
def test_record_shorter_than_two_turns_of_the_defect(write: Write, costs: dict[str, float], name: str) -> None:
    """A trial without a whole turn shows no difference between models."""
    text = OPEN.replace("defect: {", "friction: none\ndefect: {race: inner, ").replace("0.2 s", "15 ms")
    study = accuracy_study(write, text.replace("accuracy: 5 %", f"accuracy: {{within: 5 %, of: {name}}}"))
    result = choose(study, lambda request: trial_of_record(request, request.case.load, repeats=False))
    assert [choice.candidate for choice in result] == ["reference"] * 3


def test_record_shorter_than_two_turns_of_the_cage(write: Write) -> None:
    """The mesh of a circular defect is varied nevertheless."""
    text = OPEN.replace("rectangular", "circular").replace("0.2 s", "0.03 s")
    evaluate = lambda request: trial_of_record(request, request.case.load, repeats=False)  # noqa: E731
    result = choose(accuracy_study(write, text), evaluate)
    assert [choice.candidate for choice in result] == [WITH_FRICTION] * 3
