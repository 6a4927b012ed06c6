"""Choice of models from trials with given numbers, and the study with the choice."""

import math
from dataclasses import replace

import pytest

from bearingsim import selection
from bearingsim.selection import TrialRequest
from bearingsim.simulation.trial import Trial
from bearingsim.study import Study
from tests.scenes.study_text import Write
from tests.scenes.trials import (
    FAR,
    SIXTH,
    SPATIAL,
    TEXT,
    TrialFunction,
    accuracy_study,
    choose,
    run_trials,
    trial,
    trials_by_model,
)


def chosen_candidates(study: Study, evaluate: TrialFunction) -> list[str]:
    return [choice.candidate for choice in choose(study, evaluate)]


def models_tried(study: Study, factors: dict[str, float]) -> set[str]:
    """Return the models of all trials; their values differ by ``factors``."""
    models = set()

    def evaluate(request: TrialRequest) -> Trial | None:
        models.add(request.case.model)
        return trials_by_model(FAR | factors)(request)

    run_trials(study, evaluate)
    return models


@pytest.mark.parametrize(
    ("off", "model"),
    [
        ({}, "rollers"),  # the ring and static are too far off
        ({"ring": 1.03}, "ring"),
        ({"ring": 1.03, "static": 0.97}, "static"),
        ({"rollers": 1.039}, "rollers"),
        ({"rollers": 1.041}, "reference"),  # a fifth of the 5 % is left to step and scatter
        ({"rollers": 1.2, "static": 0.99}, "static"),
    ],
)
def test_cheapest_sufficient_model_is_chosen(
    write: Write, costs: dict[str, float], off: dict[str, float], model: str
) -> None:
    assert chosen_candidates(accuracy_study(write), trials_by_model(FAR | {"rollers": 1.01} | off)) == [model] * 3


def test_scatter_counts_as_difference(write: Write, costs: dict[str, float]) -> None:
    """Two draws of 30 % scatter each agree by no luck within 5 %."""
    offsets = {model: number for number, model in enumerate(FAR)}

    def evaluate(request: TrialRequest) -> Trial:
        full = trial(request.case.load, request.passes + offsets[request.case.model], 0.3, names=request.features)
        lines = {name: parts[: request.passes] for name, parts in full.amplitudes.items()}
        return replace(
            full,
            passes=request.passes,
            revolutions=request.passes,
            amplitudes=lines,
            forces=full.forces[: request.passes],
        )

    assert chosen_candidates(accuracy_study(write), evaluate) == ["reference"] * 3


def test_errors_are_relative_to_largest_value_of_curve(write: Write, costs: dict[str, float]) -> None:
    """Rollers are 10 N off at each load: 6.7 % of 150 N, but 2.2 % of the 450 N at the curve's end."""

    def evaluate(request: TrialRequest) -> Trial:
        return trial(
            request.case.load + {"planar": 0.0, "rollers": 10.0}.get(request.case.model, 1e3),
            names=request.features,
        )

    study = accuracy_study(write)
    result = choose(study, evaluate)
    assert [choice.candidate for choice in result] == ["rollers"] * 3
    assert [choice.error["velocity@BPFO"] for choice in result] == pytest.approx([10.0 / 450.0] * 3, rel=1e-6)
    separate = accuracy_study(
        write, TEXT.replace("x: load", "x: seed, by: load").replace("sweep: {", "sweep: {seed: [0], ")
    )
    assert chosen_candidates(separate, evaluate) == ["reference", "rollers", "rollers"]


@pytest.mark.parametrize(("compiling_s", "tried"), [(0.0, True), (20.0, True), (22.0, False)])
def test_model_that_saves_less_than_its_compile_time_is_not_tried(
    write: Write, costs: dict[str, float], compiling_s: float, tried: bool
) -> None:
    """`rollers` saves 7 s in each of three cases."""
    study, evaluate = accuracy_study(write), trials_by_model(FAR | {"rollers": 1.01})
    costs |= {"ring": 10.0, "static": 10.0}  # save nothing
    choosing = selection.ModelSelector(study, range(3), lambda case: compiling_s)
    result = {request.id: evaluate(request) for request in choosing.next_trials({})}
    pending = choosing.next_trials(result)
    assert {request.case.model for request in pending} == ({"rollers"} if tried else set())
    chosen = choosing.decide(result | {request.id: evaluate(request) for request in pending}).choices.values()
    assert {choice.candidate for choice in chosen} == {"rollers" if tried else "reference"}
    if not tried:
        why = "cheaper models would save less CPU time than compiling them takes"
        assert {choice.why for choice in chosen} == {why}


def test_candidate_of_the_same_model_is_tried_for_any_saving(write: Write, costs: dict[str, float]) -> None:
    """Fewer slices need no other code."""
    costs.update(dict.fromkeys(costs, 1.0), spatial=1e-3)
    study, evaluate = accuracy_study(write, SPATIAL), trials_by_model(dict.fromkeys(costs, 1.0))
    choosing = selection.ModelSelector(study, range(3), lambda case: 100.0)
    result = {request.id: evaluate(request) for request in choosing.next_trials({})}
    result |= {request.id: evaluate(request) for request in choosing.next_trials(result)}
    assert {choice.candidate for choice in choosing.decide(result).choices.values()} == {SIXTH}


def test_failing_candidate_is_not_chosen(write: Write, costs: dict[str, float]) -> None:
    evaluate = trials_by_model(FAR | {"rollers": 1.01, "ring": 1.01})
    study = accuracy_study(write)
    assert (
        chosen_candidates(study, lambda request: None if request.case.model == "ring" else evaluate(request))
        == ["rollers"] * 3
    )
    failing = (300.0, "ring")
    assert (
        chosen_candidates(
            study,
            lambda request: None if (request.case.load, request.case.model) == failing else evaluate(request),
        )
        == ["rollers"] * 3
    )


@pytest.mark.parametrize("which", ["own", "healthy"])
def test_case_with_failing_reference_is_computed_by_reference(
    write: Write, costs: dict[str, float], which: str
) -> None:
    text = TEXT.replace("accuracy: 5 %", "accuracy: {within: 5 %, of: [velocity@BPFO-healthy]}")
    evaluate = trials_by_model(FAR | {"rollers": 1.0})

    def failing(request: TrialRequest) -> Trial | None:
        fails = (
            request.case.model == "planar"
            and request.case.load == 300.0
            and bool(request.case.defects) == (which == "own")
        )
        lower = replace(
            request,
            case=request.case.model_copy(
                update={"load": request.case.load * (2.0 if request.case.defects else 1.0)}
            ),
        )
        return None if fails else evaluate(lower)

    result = choose(accuracy_study(write, text), failing)
    assert [choice.candidate for choice in result] == ["rollers", "reference", "rollers"]
    assert result[1].why == "the reference fails"


@pytest.mark.parametrize(("saving", "model"), [(0.09, "rollers"), (0.11, "ring")])
def test_a_lower_model_must_save_a_tenth(write: Write, costs: dict[str, float], saving: float, model: str) -> None:
    costs["ring"] = (1.0 - saving) * costs["rollers"]
    assert (
        chosen_candidates(accuracy_study(write), trials_by_model(FAR | {"rollers": 1.01, "ring": 1.01}))
        == [model] * 3
    )


@pytest.mark.parametrize(("share", "mixed"), [(0.32, True), (0.34, False)])
def test_models_are_mixed_on_a_curve_only_for_a_large_saving(
    write: Write, costs: dict[str, float], share: float, mixed: bool
) -> None:
    """Static does at two of three loads; rollers, at the third alone, save so much."""
    costs |= {"planar": 1.0, "rollers": 0.5, "static": (3.0 * share - 0.5) / 2.0, "ring": 1.0}

    def evaluate(request: TrialRequest) -> Trial:
        low = request.case.load < 400.0
        off = {"planar": 1.0, "rollers": 1.5 if low else 1.0, "static": 1.0 if low else 1.5}
        return trial(request.case.load * off.get(request.case.model, 9.0), names=request.features)

    # one model for all is the reference
    assert chosen_candidates(accuracy_study(write), evaluate) == (
        ["static", "static", "rollers"] if mixed else ["reference"] * 3
    )


def test_periodic_reference_is_chosen_without_trials(write: Write) -> None:
    study = accuracy_study(write)
    evaluate = trials_by_model(FAR, repeats=True)
    result = run_trials(study, evaluate)
    assert len(result) == 3  # nothing else is tried
    assert selection.ModelSelector(study, range(3)).next_trials(result) == []
    assert chosen_candidates(study, evaluate) == ["reference"] * 3
    assert selection.ModelSelector(study, range(3)).decide(result).periodic_count == 3


@pytest.mark.parametrize(
    ("off", "tried"),
    [
        ({}, {"planar", "rollers", "ring", "static"}),
        ({"ring": 1.03}, {"planar", "ring", "static"}),
        ({"static": 1.03}, {"planar", "static"}),
    ],
)
def test_models_dearer_than_a_sufficient_one_are_not_tried(
    write: Write, costs: dict[str, float], off: dict[str, float], tried: set[str]
) -> None:
    assert models_tried(accuracy_study(write), {"rollers": 1.01} | off) == tried


def test_a_model_is_not_tried_that_costs_over_a_ninth_more_than_the_cheapest_sufficient_one(
    write: Write, costs: dict[str, float]
) -> None:
    """Each costs about 10 % more than the one before."""
    costs |= {"static": 1.0, "ring": 1.1, "rollers": 1.2}
    tried = models_tried(accuracy_study(write), {"static": 1.0, "ring": 1.0, "rollers": 1.0})
    assert tried == {"planar", "static", "ring"}


def test_nan_feature_makes_model_insufficient(write: Write, costs: dict[str, float]) -> None:
    """A number that is none in one feature is not hidden by another that is near."""
    text = TEXT.replace("accuracy: 5 %", "accuracy: {within: 5 %, of: [velocity@BPFO, velocity.rms]}")

    def evaluate(request: TrialRequest) -> Trial:
        result = trial(request.case.load, names=request.features)
        return replace(result, mean_squares={"velocity.rms": math.nan * result.mean_squares["velocity.rms"]})

    study = accuracy_study(write, text)
    assert chosen_candidates(study, evaluate) == ["reference"] * 3
    assert "too few ball passes to compare" in choose(study, evaluate)[0].why


@pytest.mark.parametrize(
    ("off", "reason"),
    [
        ({"rollers": 1.1}, "the nearest cheaper model is 10 % off: over 4 %"),
        ({"planar": 1.0}, "the nearest cheaper model is 50 % off: over 4 %"),
    ],
)
def test_reason_against_cheaper_models_is_given(
    write: Write, costs: dict[str, float], off: dict[str, float], reason: str
) -> None:
    text = TEXT.replace("150 N, 300 N, 450 N", "450 N")
    assert choose(accuracy_study(write, text), trials_by_model(FAR | off))[0].why == reason


def test_reason_names_other_case_of_the_curve(write: Write, costs: dict[str, float]) -> None:
    def evaluate(request: TrialRequest) -> Trial:
        high = request.case.load > 400.0 and request.case.model != "planar"
        return trial(request.case.load * (2.0 if high else 1.0), names=request.features)

    result = choose(accuracy_study(write), evaluate)
    reason = (
        "the nearest cheaper model is 0 % off for this case, but not shown to be within 4 % elsewhere on a curve"
    )
    assert result[0].why == reason


def test_error_is_unknown_where_the_reference_is_zero(write: Write, costs: dict[str, float]) -> None:
    """A candidate that gives 1 mm/s instead of 0 is not within 0.1 %."""

    def evaluate(request: TrialRequest) -> Trial:
        return trial(0.0 if request.case.model == "planar" else 1e-3, names=request.features)

    assert chosen_candidates(accuracy_study(write), evaluate) == ["reference"] * 3
