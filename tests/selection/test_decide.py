"""Choice of models from trials with given numbers, and the study with the choice."""

import math
from dataclasses import replace
from typing import Any

import pytest

from bearingsim import selection
from bearingsim.selection import TrialRequest, candidates
from bearingsim.simulation.trial import Trial, with_trial_step
from bearingsim.study import Study
from tests.scenes.study_text import Write
from tests.scenes.trials import (
    FAR,
    RING,
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
        lines = {name: parts[: request.passes] for name, parts in full.lines.items()}
        return replace(
            full, passes=request.passes, turns=request.passes, lines=lines, forces=full.forces[: request.passes]
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
    assert selection.ModelSelector(study, range(3)).decide(result).repeating == 3


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
        return replace(result, powers={"velocity.rms": math.nan * result.powers["velocity.rms"]})

    study = accuracy_study(write, text)
    assert chosen_candidates(study, evaluate) == ["reference"] * 3
    assert "could not be distinguished" in choose(study, evaluate)[0].why


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
    reason = "the nearest cheaper model is 0 % off here, but not shown to be within 4 % elsewhere on a curve"
    assert result[0].why == reason


# Discretisation

BOWL = TEXT.replace("rectangular", "circular")
NODES = 24


def by_nodes(off: float, scatter: float = 0.0, **others: Any) -> TrialFunction:
    """Trials of rollers that hold, whose line doubled nodes change by a share."""

    def evaluate(request: TrialRequest) -> Trial:
        more = 1.0 + off * (request.case.contact.length_nodes > NODES)
        size = request.case.load * more * {"planar": 1.0, "rollers": 1.01}.get(request.case.model, 9.0)
        return trial(size, names=request.features, scatter=scatter * (more > 1.0), **others)

    return evaluate


@pytest.mark.parametrize("repeats", [False, True])
def test_discretisation_error_is_from_doubled_nodes(write: Write, costs: dict[str, float], repeats: bool) -> None:
    """Twice what they change, as of an error of first order, over the largest value of the curve.

    Both ends of the curve are tried: in between the error is the larger one of them.
    """
    evaluate, tried = by_nodes(0.004, repeats=repeats), set()

    def counted(request: TrialRequest) -> Trial | None:
        if request.case.contact.length_nodes > NODES:
            tried.add(request.case.load)
        return evaluate(request)

    result = choose(accuracy_study(write, BOWL), counted)
    assert tried == {150.0, 450.0}
    assert [choice.candidate for choice in result] == ["reference" if repeats else "rollers"] * 3
    size = 1.0 if repeats else 1.01
    errors = [choice.nodes["velocity@BPFO"] for choice in result]
    assert errors == pytest.approx([2.0 * 0.004 * size * load / 450.0 for load in (150.0, 450.0, 450.0)], rel=1e-6)


def test_each_shape_on_a_curve_has_its_discretisation_error(write: Write, costs: dict[str, float]) -> None:
    """Ends of each shape are tried; a case in between has the larger error of neighbours of its shape."""
    loads, shapes = "150 N, 200 N, 250 N, 300 N, 350 N, 400 N", ", ".join(3 * ["circular", "spall"])
    text = TEXT.replace("load: [150 N, 300 N, 450 N]", f"zip: {{load: [{loads}], defect.shape: [{shapes}]}}")
    tried: set[float] = set()

    def evaluate(request: TrialRequest) -> Trial | None:
        finer = request.case.contact.length_nodes > NODES
        tried.update([request.case.load] * finer)
        spall = bool(request.case.defects) and request.case.defects[0].shape == "spall"
        return by_nodes(0.01 if spall else 0.004, repeats=True)(request)

    errors = [choice.nodes["velocity@BPFO"] for choice in choose(accuracy_study(write, text), evaluate)]
    assert tried == {150.0, 200.0, 350.0, 400.0}
    of_loads = [0.004 * 150.0, 0.01 * 200.0, 0.004 * 350.0, 0.01 * 400.0, 0.004 * 350.0, 0.01 * 400.0]
    assert errors == pytest.approx([2.0 * of_load / 400.0 for of_load in of_loads], rel=1e-6)


def test_discretisation_error_includes_scatter(write: Write, costs: dict[str, float]) -> None:
    plain = choose(accuracy_study(write, BOWL), by_nodes(0.004))[2].nodes["velocity@BPFO"]
    noisy = choose(accuracy_study(write, BOWL), by_nodes(0.004, scatter=0.01))[2].nodes["velocity@BPFO"]
    assert plain is not None
    assert noisy is not None
    assert noisy > plain + 0.005


def test_scatter_counts_if_only_the_trial_with_other_nodes_is_not_periodic(
    write: Write, costs: dict[str, float]
) -> None:
    """Twice a change of 0.004, and the scatter of its parts."""

    def evaluate(request: TrialRequest) -> Trial:
        is_finer = request.case.contact.length_nodes > NODES
        size = request.case.load * (1.0 + 0.004 * is_finer)
        return trial(size, names=request.features, scatter=0.01 * is_finer, repeats=not is_finer)

    error = choose(accuracy_study(write, BOWL), evaluate)[2].nodes["velocity@BPFO"]
    assert error is not None
    assert error > 2.0 * 0.004 + 0.005


def test_nodes_along_defects_are_not_doubled_in_the_healthy_bearing(write: Write, costs: dict[str, float]) -> None:
    tried: list[bool] = []

    def evaluate(request: TrialRequest) -> Trial:
        tried.extend([bool(request.case.defects)] * (request.case.contact.length_nodes > NODES))
        return trial(1.0 + bool(request.case.defects), names=request.features, repeats=True)

    text = BOWL.replace("accuracy: 5 %", "accuracy: {within: 5 %, of: [velocity@BPFO-healthy]}")
    choose(accuracy_study(write, text), evaluate)
    assert tried == [True] * len(tried) != []


def test_discretisation_error_is_unknown_if_trial_fails(write: Write, costs: dict[str, float]) -> None:
    evaluate = by_nodes(0.0)
    result = choose(
        accuracy_study(write, BOWL),
        lambda request: None if request.case.contact.length_nodes > NODES else evaluate(request),
    )
    assert [choice.nodes for choice in result] == [{"velocity@BPFO": None}] * 3


def test_discretisation_error_is_unknown_if_the_case_fails(write: Write, costs: dict[str, float]) -> None:
    """The job may succeed later, because the trial failed for a reason of the machine."""
    evaluate = by_nodes(0.0)
    result = choose(
        accuracy_study(write, BOWL), lambda request: None if request.case.load == 300.0 else evaluate(request)
    )
    assert [choice.nodes["velocity@BPFO"] is None for choice in result] == [False, True, False]


@pytest.mark.parametrize(
    ("shape", "varies"),
    [("rectangular", False), ("triangular", False), ("circular", True), ("elliptical", True), ("spall", True)],
)
def test_nodes_are_doubled_if_defect_varies_along_roller(write: Write, shape: str, varies: bool) -> None:
    other = candidates.remeshed(accuracy_study(write, TEXT.replace("rectangular", shape)).cases()[0])
    assert (other is not None) == varies
    assert other is None or (other[0].contact.length_nodes, other[0].contact.slices, other[1]) == (48, 24, 2.0)


def test_reference_is_compared_with_half_the_slices_or_twice_the_harmonics(write: Write) -> None:
    """Twice the slices would exceed the limit. Other cases have this error within that of the model."""
    sliced = candidates.reference(accuracy_study(write, SPATIAL.replace("rectangular", "circular")).cases()[0])
    other = candidates.remeshed(sliced)
    assert other is not None
    assert (sliced.contact.slices, other[0].contact.slices, other[0].contact.length_nodes) == (48, 24, NODES)
    assert other[1] == 1.0
    assert candidates.remeshed(sliced, is_reference=False) is None
    bending = candidates.reference(accuracy_study(write, f"{TEXT}rig: {{ring: {RING}}}\n").cases()[0])
    other = candidates.remeshed(bending)
    assert other is not None
    rings = [case.rig.ring for case in (bending, other[0])]
    assert [int(ring.harmonics) for ring in rings if ring is not None] == [32, 64]
    assert other[1] == 2.0
    assert candidates.remeshed(bending, is_reference=False) is None


@pytest.mark.parametrize(("method", "step"), [("verlet", 1e-6), ("dop853", 1e-5), ("", 0.0)])
def test_nodes_are_doubled_at_the_step_of_the_trial(write: Write, method: str, step: float) -> None:
    """Another step would have an error of its own. It has been taken before, and is not checked again."""
    case = accuracy_study(write, BOWL).cases()[0]
    result = with_trial_step(case, replace(trial(1.0), method=method, step=step))
    assert result.step_check is False
    assert (result.method, result.step, result.tolerance) == {
        "verlet": ("verlet", 1e-6, "auto"),
        "dop853": ("dop853", "auto", 1e-5),
        "": (case.method, "auto", "auto"),
    }[method]


@pytest.mark.parametrize(
    ("harmonics", "others"), [(16, (32, 64)), (40, (80, 40)), (49, (98, 49)), (60, (100, 50))]
)
def test_error_of_harmonics_near_their_limit(write: Write, harmonics: int, others: tuple[int, int]) -> None:
    """An error of 1/harmonics is that of the reference, computed from another number, half as large or twice."""
    ring = f"rig: {{ring: {{bends: true, harmonics: {harmonics}}}}}\n"
    tried: set[int] = set()

    def evaluate(request: TrialRequest) -> Trial:
        assert request.case.rig.ring is not None
        tried.add(int(request.case.rig.ring.harmonics))
        return trial(1.0 + 1.0 / int(request.case.rig.ring.harmonics), names=request.features, repeats=True)

    (choice, *_) = choose(accuracy_study(write, TEXT + ring), evaluate)
    assert tried == set(others)
    error = choice.nodes["velocity@BPFO"]
    assert error == pytest.approx(1.0 / others[0], rel=0.05)


def test_error_of_harmonics_in_the_healthy_bearing_counts_for_the_change(write: Write) -> None:
    """Twice the harmonics change the healthy amplitude from 1.1 to 1.05; the faulty one is 2."""
    text = TEXT.replace("accuracy: 5 %", "accuracy: {within: 5 %, of: [velocity@BPFO-healthy]}")

    def evaluate(request: TrialRequest) -> Trial:
        assert request.case.rig.ring is not None
        healthy = 1.0 + 3.2 / int(request.case.rig.ring.harmonics)
        return trial(2.0 if request.case.defects else healthy, names=request.features, repeats=True)

    study = accuracy_study(write, f"{text}rig: {{ring: {RING}}}\n")
    errors = [choice.nodes["velocity@BPFO-healthy"] for choice in choose(study, evaluate)]
    assert errors == pytest.approx([2.0 * 0.05 / 0.9] * 3)


def test_discretisation_error_is_unknown_on_a_ramp(write: Write) -> None:
    """It has no trials."""
    ramp = "ramp: {to: 7000 rpm, time: 50 ms}\n"
    for text, nodes in ((BOWL, {"velocity@BPFO": None}), (TEXT, {})):
        result = choose(accuracy_study(write, text + ramp), by_nodes(0.0))
        assert [choice.nodes for choice in result] == [nodes] * 3


def test_error_is_unknown_where_the_reference_is_zero(write: Write, costs: dict[str, float]) -> None:
    """A candidate that gives 1 mm/s instead of 0 is not within 0.1 %."""

    def evaluate(request: TrialRequest) -> Trial:
        return trial(0.0 if request.case.model == "planar" else 1e-3, names=request.features)

    assert chosen_candidates(accuracy_study(write), evaluate) == ["reference"] * 3
