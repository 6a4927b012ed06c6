"""Friction that a case leaves open: tried where it may change most, and computed where it changes much."""

from collections.abc import Mapping
from dataclasses import replace

import pytest

from bearingsim import selection
from bearingsim.config import Case
from bearingsim.selection import TrialRequest, candidates
from bearingsim.selection.candidates import WITH_FRICTION, with_friction
from bearingsim.selection.choices import choice_key
from bearingsim.simulation import run_trial
from bearingsim.simulation.trial import (
    CAGE_REVOLUTIONS,
    INSPECTION_REVOLUTIONS,
    ReferenceValues,
    Trial,
    lengthen_for_trial,
    trial_passes,
)
from bearingsim.study import case_id, load_study
from tests.scenes.study_text import Write
from tests.scenes.trials import OPEN, TrialFunction, accuracy_study, choose, is_free, run_trials, trial

LOADS = "150 N, 300 N, 450 N"
LINE = "velocity@BPFO"
OFF = {"planar": 1.0, "rollers": 1.01, "ring": 1.5, "static": 2.0}


def by_friction(change: float, off: Mapping[str, float] = OFF, repeats: bool = False) -> TrialFunction:
    """Trials whose features are the load, times what a model makes of it, and what friction changes."""

    def evaluate(request: TrialRequest) -> Trial:
        free = is_free(request.case)
        size = request.case.load * off[request.case.model] * (1.0 + change * free)
        return trial(size, names=request.features, repeats=repeats and not free)

    return evaluate


@pytest.mark.parametrize("repeats", [False, True])
def test_small_change_by_friction_is_an_error_part(write: Write, repeats: bool) -> None:
    result = choose(accuracy_study(write, OPEN), by_friction(0.002, repeats=repeats))
    assert [choice.candidate for choice in result] == ["reference" if repeats else "rollers"] * 3
    errors = [choice.friction[LINE] for choice in result]
    assert errors == pytest.approx([0.002 * load / 450.0 for load in (150.0, 450.0, 450.0)], rel=1e-6)
    assert [choice.inferred for choice in result] == [False, True, False]  # that between the ends of the curve


@pytest.mark.parametrize("repeats", [False, True])
def test_friction_with_large_change_is_computed(write: Write, repeats: bool) -> None:
    """On all of the curve: as `planar` has it by default."""
    study = accuracy_study(write, OPEN)
    evaluate = by_friction(0.045, repeats=repeats)
    result = choose(study, evaluate)
    assert [choice.candidate for choice in result] == [WITH_FRICTION] * 3
    assert result[0].why == "friction changes velocity@BPFO by up to 4.5 % on its curve, over 4 %"
    assert [choice.friction for choice in result] == [{}] * 3
    done = selection.apply_choices(
        study, selection.ModelSelector(study, range(3)).decide(run_trials(study, evaluate)).choices
    )
    named = OPEN.replace("accuracy: 5 %", "model: planar\nrecord: []\nuntil: 1.25 %")
    assert [case_id(case) for case in done.cases()] == [case_id(case) for case in load_study(write(named)).cases()]
    assert done.selection is not None
    assert done.selection.audits == ()


def test_errors_of_model_and_friction_share_the_accuracy(write: Write) -> None:
    """Each error is below 4 %, the limit of a trial at 5 % accuracy; their sum is not."""
    alone = choose(accuracy_study(write, OPEN), by_friction(0.001, OFF | {"rollers": 1.03}))
    combined = choose(accuracy_study(write, OPEN), by_friction(0.02, OFF | {"rollers": 1.03}))
    assert [choice.candidate for choice in alone] == ["rollers"] * 3
    assert [choice.candidate for choice in combined] == [WITH_FRICTION] * 3
    assert combined[2].why == "the nearest cheaper model is 3 % off, 5 % with the effect of friction: over 4 %"


@pytest.mark.parametrize("text", ["friction: none", "cage: {pocket_clearance: 0.1 mm}", "friction: traction"])
def test_stated_friction_or_cage_is_kept(write: Write, text: str) -> None:
    study = accuracy_study(write, f"{OPEN}{text}\n")
    assert candidates.with_friction(study.cases()[0]) is None
    result = choose(study, by_friction(9.0, OFF))
    assert WITH_FRICTION not in [choice.candidate for choice in result]
    assert [choice.friction for choice in result] == [{}] * 3


def test_choice_with_open_friction_has_another_key(write: Write) -> None:
    named, left = accuracy_study(write), accuracy_study(write, OPEN)
    assert case_id(named.cases()[0]) == case_id(left.cases()[0])
    assert choice_key(named, named.cases()[0]) != choice_key(left, left.cases()[0])


def test_friction_is_tried_at_ends_of_curve_and_largest_value(write: Write) -> None:
    """The change of the others is assumed to be no larger; their audits have friction."""
    study = accuracy_study(write, OPEN.replace(LOADS, "450 N, 150 N, 300 N, 200 N, 400 N"))
    tried: set[float] = set()

    def evaluate(request: TrialRequest) -> Trial | None:
        if is_free(request.case):
            tried.add(request.case.load)
        peak = request.case.model_copy(update={"load": 1000.0 - abs(request.case.load - 300.0)})
        return by_friction(0.01 * peak.load / 1000.0, repeats=True)(replace(request, case=peak))

    result = choose(study, evaluate)
    assert tried == {150.0, 300.0, 450.0}
    assert [choice.inferred for choice in result] == [False, False, False, True, True]
    largest = result[2].friction[LINE]
    assert [choice.friction[LINE] for choice in result[3:]] == [largest, largest]
    choices = selection.ModelSelector(study, range(5)).decide(run_trials(study, evaluate)).choices
    done = selection.apply_choices(study, choices)
    assert done.selection is not None
    ids = [case_id(case) for case in done.cases()]
    assert {audit.of for audit in done.selection.audits} == {ids[3], ids[4]}
    assert all(is_free(audit.job.case) for audit in done.selection.audits)


@pytest.mark.parametrize("duration", ["0.15 s", "0.5 s"])
def test_case_tried_with_friction_is_that_of_the_job(write: Write, duration: str) -> None:
    """Its record may end early, and the trial may go on as the job."""
    study = accuracy_study(write, OPEN.replace("duration: 0.2 s", f"duration: {duration}"))
    tried: list[Case] = []

    def evaluate(request: TrialRequest) -> Trial | None:
        tried.extend([request.case] * is_free(request.case))
        return by_friction(0.1)(request)

    choose(study, evaluate)
    friction_trial = {case_id(case) for own in study.cases() if (case := with_friction(own)) is not None}
    assert {case_id(case) for case in tried if case.defects} <= friction_trial
    assert tried


def test_large_change_by_friction_is_known_beside_a_difference_from_the_healthy_bearing(write: Write) -> None:
    """Neither trial ends early, because both must cover the same turns of the cage."""
    accuracy = "accuracy: {within: 5 %, of: [velocity@BPFO, velocity@BPFO-healthy]}"
    study = accuracy_study(write, OPEN.replace("accuracy: 5 %", accuracy))

    def evaluate(request: TrialRequest) -> Trial:
        free = is_free(request.case)
        size = 100.0 * (1.5 if free else 1.0) if request.case.defects else 1.0
        is_far = any(values.limits for values in request.reference_values)
        turns = INSPECTION_REVOLUTIONS if is_far else CAGE_REVOLUTIONS
        return trial(size, turns, names=request.features, repeats=not free)

    assert [choice.candidate for choice in choose(study, evaluate)] == [WITH_FRICTION] * 3


def test_each_curve_is_decided_separately(write: Write) -> None:
    text = OPEN.replace("sweep: {", "sweep: {defect.width: [0.4 mm, 0.8 mm], ").replace(
        "x: load", "x: load, by: defect.width"
    )
    study = accuracy_study(write, text)

    def evaluate(request: TrialRequest) -> Trial | None:
        wide = bool(request.case.defects) and request.case.defects[0].width > 5e-4
        return by_friction(0.1 if wide else 0.0)(request)

    assert [choice.candidate for choice in choose(study, evaluate)] == ["rollers"] * 3 + [WITH_FRICTION] * 3


def test_change_by_friction_is_unknown_if_trial_fails(write: Write) -> None:
    evaluate = by_friction(0.0, repeats=True)
    result = choose(
        accuracy_study(write, OPEN), lambda request: None if is_free(request.case) else evaluate(request)
    )
    assert [choice.candidate for choice in result] == ["reference"] * 3
    assert [choice.friction for choice in result] == [{LINE: None}] * 3


def test_record_of_few_cage_turns_is_computed_with_friction(write: Write) -> None:
    """Trials are omitted because they would cost more. 65 ball passes are 0.122 s."""
    short = accuracy_study(write, OPEN.replace("0.2 s", "0.12 s"))
    assert run_trials(short, by_friction(0.0)) == {}
    assert [choice.candidate for choice in choose(short, by_friction(0.0))] == [WITH_FRICTION] * 3
    long = accuracy_study(write, OPEN.replace("0.2 s", "0.13 s"))
    assert [choice.candidate for choice in choose(long, by_friction(0.0, repeats=True))] == ["reference"] * 3


def test_few_turns_of_non_periodic_response_are_not_compared(write: Write) -> None:
    def evaluate(request: TrialRequest) -> Trial:
        assert not is_free(request.case)
        return trial(request.case.load, CAGE_REVOLUTIONS - 1, names=request.features)

    result = choose(accuracy_study(write, OPEN), evaluate)
    assert [choice.candidate for choice in result] == [WITH_FRICTION] * 3
    assert result[0].why.startswith("the response without friction is not periodic")


def test_trials_with_free_cage_have_whole_cage_turns(write: Write) -> None:
    case = accuracy_study(write, OPEN).cases()[0]
    Z, rate = case.bearing.rollers, case.bearing.ball_pass_frequency(case.speed)
    first = selection.ModelSelector(accuracy_study(write, OPEN), [0]).next_trials({})[0]
    assert first.passes == trial_passes(case, has_free_cage=True) == CAGE_REVOLUTIONS * Z
    assert first.revolution_time == pytest.approx(Z / rate)
    assert trial_passes(case) < CAGE_REVOLUTIONS * Z
    assert lengthen_for_trial(case).duration * rate / 2.0 >= CAGE_REVOLUTIONS * Z
    assert lengthen_for_trial(lengthen_for_trial(case)).duration == lengthen_for_trial(case).duration


# Computed

SCENE = {
    "bearing": "nf308",
    "speed": "6000 rpm",
    "load": "100 N",
    "defect": {"shape": "rectangular", "length": "12 mm", "width": "0.8 mm", "depth": "50 um"},
    "model": "reference",
    "record": [],
}


def test_trial_far_from_reference_ends_early() -> None:
    """A periodic motion is continued beyond its record."""
    case = Case.model_validate(SCENE | {"duration": "0.1 s"})
    free = candidates.with_friction(case)
    assert free is not None
    Z = case.bearing.rollers
    passes, turn = CAGE_REVOLUTIONS * Z, Z / case.bearing.ball_pass_frequency(case.speed)
    plain, record = run_trial(case, [LINE], passes, turn)
    assert record is not None
    assert (plain.passes, plain.revolutions, plain.is_periodic) == (passes, CAGE_REVOLUTIONS, True)
    size = float(abs(plain.amplitudes[LINE][0]))
    for most, turns in ((1e-6, INSPECTION_REVOLUTIONS), (10.0, CAGE_REVOLUTIONS)):
        friction_trial, _ = run_trial(
            lengthen_for_trial(free), [LINE], passes, turn, ReferenceValues({LINE: size}, {LINE: most * size})
        )
        assert (friction_trial.revolutions, friction_trial.passes, friction_trial.is_periodic) == (
            turns,
            turns * Z,
            False,
        )
        assert friction_trial.is_consistent


def test_reason_names_the_feature_for_which_a_trial_ended_early(write: Write) -> None:
    """Friction changes the RMS by 20 %, the line by 0.1 %; the scatter of neither is known after two turns."""
    text = OPEN.replace("y: velocity@BPFO", "y: [velocity@BPFO, velocity.rms]") + "record: [ring.velocity]\n"

    def evaluate(request: TrialRequest) -> Trial:
        free = is_free(request.case)
        turns = INSPECTION_REVOLUTIONS if free else CAGE_REVOLUTIONS
        result = trial(request.case.load, turns, names=request.features, repeats=not free)
        lines = {name: values * (1.001 if free else 1.0) for name, values in result.amplitudes.items()}
        powers = {name: values * (1.44 if free else 1.0) for name, values in result.mean_squares.items()}
        return replace(result, amplitudes=lines, mean_squares=powers)

    result = choose(accuracy_study(write, text), evaluate)
    assert [choice.candidate for choice in result] == [WITH_FRICTION] * 3
    assert result[0].why == "friction changes velocity.rms by about 20 %, over 4 %"


def test_trial_that_ended_early_for_a_smaller_accuracy_is_not_used(write: Write) -> None:
    """A change of 5 % by friction is far beyond 2 %, so the trial ends early; it is within 0.8 times 10 %."""
    text = OPEN.replace("accuracy: 5 %", "accuracy: 2 %") + "record: [ring.velocity]\n"

    def evaluate(request: TrialRequest) -> Trial:
        free = is_free(request.case)
        complete = trial(request.case.load * (1.05 if free else 1.0), CAGE_REVOLUTIONS, names=request.features)
        is_early = any(values.is_far(complete) for values in request.reference_values)
        turns = INSPECTION_REVOLUTIONS if is_early else CAGE_REVOLUTIONS
        return trial(abs(complete.forces[0]), turns, names=request.features, repeats=not free)

    stored = run_trials(accuracy_study(write, text), evaluate)
    study = accuracy_study(write, text.replace("2 %", "10 %"))
    choices = selection.ModelSelector(study, range(3)).decide(run_trials(study, evaluate, stored)).choices
    assert [choice.candidate for choice in choices.values()] == ["reference"] * 3
    assert [choice.friction[LINE] for choice in choices.values()] == pytest.approx(
        [0.05 * load / 450.0 for load in (150.0, 450.0, 450.0)]
    )
