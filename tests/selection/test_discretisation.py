"""Discretisation error of the chosen models, from trials with other nodes, slices or harmonics."""

from dataclasses import replace
from typing import Any

import pytest

from bearingsim.selection import TrialRequest, candidates
from bearingsim.simulation.trial import Trial, with_trial_step
from tests.scenes.study_text import Write
from tests.scenes.trials import RING, SPATIAL, TEXT, TrialFunction, accuracy_study, choose, trial

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
    other = candidates.change_mesh(accuracy_study(write, TEXT.replace("rectangular", shape)).cases()[0])
    assert (other is not None) == varies
    assert other is None or (other[0].contact.length_nodes, other[0].contact.slices, other[1]) == (48, 24, 2.0)


def test_reference_is_compared_with_half_the_slices_or_twice_the_harmonics(write: Write) -> None:
    """Twice the slices would exceed the limit. Other cases have this error within that of the model."""
    sliced = candidates.make_reference(
        accuracy_study(write, SPATIAL.replace("rectangular", "circular")).cases()[0]
    )
    other = candidates.change_mesh(sliced)
    assert other is not None
    assert (sliced.contact.slices, other[0].contact.slices, other[0].contact.length_nodes) == (48, 24, NODES)
    assert other[1] == 1.0
    assert candidates.change_mesh(sliced, is_reference=False) is None
    bending = candidates.make_reference(accuracy_study(write, f"{TEXT}rig: {{ring: {RING}}}\n").cases()[0])
    other = candidates.change_mesh(bending)
    assert other is not None
    rings = [case.rig.ring for case in (bending, other[0])]
    assert [int(ring.harmonics) for ring in rings if ring is not None] == [32, 64]
    assert other[1] == 2.0
    assert candidates.change_mesh(bending, is_reference=False) is None


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
