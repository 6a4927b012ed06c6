"""No automatic method steps over a defect, at any position in a step; tighter tolerances reduce the error."""

from itertools import pairwise
from unittest import mock

import numpy as np
import pytest
from numba import typeof

from bearingsim import assemble
from bearingsim.catalogue import METHODS
from bearingsim.core.advance import advance_and_sample
from bearingsim.simulation import choice, limits
from bearingsim.stability import classification, matrix, references, traces
from bearingsim.stability.scene import CROSSING_TIMES, SAMPLE_INTERVAL, TIMES, crossing_case, crossing_intervals
from bearingsim.stability.traces import run_method

AUTOMATIC = [name for name, method in METHODS.items() if method.automatic]
ADAPTIVE = [name for name in AUTOMATIC if METHODS[name].adaptive]
POSITIONS = 50


def prepare_scene(defect, delay=0.0):
    """Return a scene of the map with the default contact, ``delay`` s later."""
    case = crossing_case("rollers", defect, {}, delay)
    model = assemble.model(case)
    return matrix.PreparedScene(
        case,
        model,
        assemble.start(case, model)[0],
        *limits.load_and_rates_at_rest(assemble.healthy_case(case))[1:],
    )


def reference(scene):
    """Return the solution of a scene by DOP853, with which all others are compared."""
    result = matrix.run_cell(scene, "dop853", 1e-8, np.inf)
    assert not result.failure
    return classification.Reference(result.velocity, result.contacts, "", False, 0.0)


def setting(scene, name):
    """Return the step or tolerance that `auto` gives; a whole number of steps makes up a sample."""
    if METHODS[name].adaptive:
        return METHODS[name].tolerance
    case = choice.with_method(scene.case, name)
    return SAMPLE_INTERVAL / np.ceil(SAMPLE_INTERVAL / choice.automatic_step(case, limits.step_limits(case)))


def longest_step(scene, name):
    """Return the approximate length (s) of the method's steps before the first defect."""
    if not METHODS[name].adaptive:
        return setting(scene, name)
    tolerance = METHODS[name].tolerance
    assert tolerance is not None
    return matrix.scene_tolerances(scene, tolerance).longest


@pytest.fixture(scope="module")
def healthy():
    return reference(prepare_scene("healthy"))


def test_reference_agrees_with_independent_solver():
    scene = prepare_scene("0.2 mm slot")
    tolerances = matrix.scene_tolerances(scene, 1e-8)
    other = references.solve("scipy-lsoda", scene.model, scene.y, tolerances, np.inf)
    assert not other.failure
    assert classification.l2_error(other.velocity, reference(scene).velocity) < 1e-5


@pytest.mark.parametrize("name", AUTOMATIC)
def test_no_crossing_is_skipped_at_any_position_in_a_step(name, healthy):
    """A crossing counts if the ring responds with at least half of the reference's response."""
    step = longest_step(prepare_scene("0.2 mm slot"), name)
    for n in range(POSITIONS):
        scene = prepare_scene("0.2 mm slot", delay=n / POSITIONS * step)
        result = matrix.run_cell(scene, name, setting(scene, name), np.inf)
        assert not result.failure
        assert classification.count_detected_crossings(
            result, reference(scene), healthy, crossing_intervals(scene.model)
        ) == len(CROSSING_TIMES)


def test_solver_without_defect_information_skips_defects(healthy):
    """A counterexample to the test above: SciPy's Radau at 1e-2 reports success."""
    scene = prepare_scene("0.2 mm slot")
    result = matrix.run_cell(scene, "scipy-radau", 1e-2, np.inf)
    assert not result.failure
    assert len(result.velocity[0]) == len(TIMES)
    assert (
        classification.count_detected_crossings(result, reference(scene), healthy, crossing_intervals(scene.model))
        == 0
    )


@pytest.mark.parametrize("name", ADAPTIVE)
def test_a_tighter_tolerance_never_doubles_the_error(name):
    """Above the floor, the difference of two accurate, independent solutions."""
    scene = prepare_scene("0.2 mm slot")
    exact = reference(scene)
    tolerances = matrix.scene_tolerances(scene, 1e-8)
    floor = classification.l2_error(
        references.solve("scipy-lsoda", scene.model, scene.y, tolerances, np.inf).velocity, exact.velocity
    )
    results = [matrix.run_cell(scene, name, 10.0**-n, np.inf) for n in range(2, 7)]
    errors = [classification.l2_error(result.velocity, exact.velocity) for result in results]
    for loose, tight in pairwise(errors):
        assert tight <= 2.0 * max(loose, floor)
    assert errors[-1] < 0.1 * errors[0]


def test_ring_without_response_counts_no_crossing():
    """Crossings are counted by the response, not by angles: Verlet has three, a healthy motion none."""
    scene = prepare_scene("0.2 mm slot")
    exact, healthy = reference(scene), reference(prepare_scene("healthy"))
    healthy_velocity = exact.velocity * 0.0 + healthy.velocity
    verlet = assemble.kind_of_method("verlet").parameters(5e-7)
    run = run_method("verlet", verlet, scene.model, scene.y, np.inf)
    assert classification.count_detected_crossings(run, exact, healthy, crossing_intervals(scene.model)) == 3
    assert (
        classification.count_detected_crossings(
            run._replace(velocity=healthy_velocity), exact, healthy, crossing_intervals(scene.model)
        )
        == 0
    )


def test_compilation_is_not_timed():
    """An untimed first step has the same argument types as the timed ones, and does not change the state."""
    scene = prepare_scene("healthy")
    with mock.patch.object(traces, "advance_and_sample", wraps=advance_and_sample) as steps:
        run_method("verlet", assemble.kind_of_method("verlet").parameters(5e-7), scene.model, scene.y, np.inf)
    first_types, *other_types = [tuple(map(typeof, call.args)) for call in steps.call_args_list]
    assert {*other_types} == {first_types}
    assert steps.call_args_list[0].args[4] is not steps.call_args_list[1].args[4]
