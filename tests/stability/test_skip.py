"""No method of the automatic set steps over a defect, wherever in a step it comes; tighter is no worse."""

from itertools import pairwise
from unittest import mock

import numpy as np
import pytest
from numba import typeof

from bearingsim import assemble
from bearingsim.catalogue import METHODS
from bearingsim.core.advance import advance_and_sample
from bearingsim.simulation import choice, limits
from bearingsim.stability import judge, matrix, references, traces
from bearingsim.stability.scene import CROSSING_TIMES, SAMPLE_INTERVAL, TIMES, crossing_case, crossing_windows
from bearingsim.stability.traces import trace

AUTOMATIC = [name for name, method in METHODS.items() if method.automatic]
ADAPTIVE = [name for name in AUTOMATIC if METHODS[name].adaptive]
POSITIONS = 50


def bench(defect, late=0.0):
    """The scene of the map with the default contact, the roller ``late`` s later."""
    case = crossing_case("rollers", defect, {}, late)
    model = assemble.model(case)
    return matrix.PreparedScene(
        case, model, assemble.start(case, model)[0], *limits.loads_at_rest(assemble.healthy_case(case))[1:]
    )


def reference(scene):
    """The scene by DOP853 at a tolerance that all others are compared with."""
    made = matrix.run(scene, "dop853", 1e-8, np.inf)
    assert not made.failure
    return judge.Reference(made.velocity, made.contacts, "", False, 0.0)


def setting(scene, name):
    """The step or tolerance of a run with `auto`; of steps, whole numbers make up a sample."""
    if METHODS[name].adaptive:
        return METHODS[name].tolerance
    named = choice.with_method(scene.case, name)
    return SAMPLE_INTERVAL / np.ceil(SAMPLE_INTERVAL / choice.automatic_step(named, limits.step_limits(named)))


def length(scene, name):
    """About how long (s) the method's steps are before the first defect: the longest it can be caught with."""
    if not METHODS[name].adaptive:
        return setting(scene, name)
    tolerance = METHODS[name].tolerance
    assert tolerance is not None
    return matrix.scene_tolerances(scene, tolerance).longest


@pytest.fixture(scope="module")
def sound():
    return reference(bench("healthy"))


def test_the_reference_is_what_others_find_too():
    scene = bench("0.2 mm slot")
    asked = matrix.scene_tolerances(scene, 1e-8)
    other = references.solve("scipy-lsoda", scene.model, scene.y, asked, np.inf)
    assert not other.failure
    assert judge.l2(other.velocity, reference(scene).velocity) < 1e-5


@pytest.mark.parametrize("name", AUTOMATIC)
def test_every_crossing_is_seen_wherever_in_a_step_it_comes(name, sound):
    """Seen by what it does to the ring: at least half of what it does to that of the reference."""
    step = length(bench("0.2 mm slot"), name)
    for n in range(POSITIONS):
        scene = bench("0.2 mm slot", late=n / POSITIONS * step)
        made = matrix.run(scene, name, setting(scene, name), np.inf)
        assert not made.failure
        assert judge.crossings_seen(made, reference(scene), sound, crossing_windows(scene.model)) == len(
            CROSSING_TIMES
        )


def test_a_solver_that_knows_of_no_defect_steps_over_it(sound):
    """What the test above can catch: SciPy's Radau at 1e-2 reports success."""
    scene = bench("0.2 mm slot")
    made = matrix.run(scene, "scipy-radau", 1e-2, np.inf)
    assert not made.failure
    assert len(made.velocity[0]) == len(TIMES)
    assert judge.crossings_seen(made, reference(scene), sound, crossing_windows(scene.model)) == 0


@pytest.mark.parametrize("name", ADAPTIVE)
def test_a_tighter_tolerance_never_doubles_the_error(name):
    """Above the floor, which is what two tight and independent solutions differ by."""
    scene = bench("0.2 mm slot")
    exact = reference(scene)
    asked = matrix.scene_tolerances(scene, 1e-8)
    floor = judge.l2(references.solve("scipy-lsoda", scene.model, scene.y, asked, np.inf).velocity, exact.velocity)
    made = [matrix.run(scene, name, 10.0**-n, np.inf) for n in range(2, 7)]
    errors = [judge.l2(one.velocity, exact.velocity) for one in made]
    for loose, tight in pairwise(errors):
        assert tight <= 2.0 * max(loose, floor)
    assert errors[-1] < 0.1 * errors[0]


def test_a_ring_that_does_not_answer_has_seen_no_crossing():
    """The count is not of angles: Verlet at its automatic step sees three, a ring that stands still none."""
    scene = bench("0.2 mm slot")
    exact, healthy = reference(scene), reference(bench("healthy"))
    still = exact.velocity * 0.0 + healthy.velocity
    verlet = assemble.kind_of_method("verlet").parameters(5e-7)
    blind = trace("verlet", verlet, scene.model, scene.y, np.inf)
    assert judge.crossings_seen(blind, exact, healthy, crossing_windows(scene.model)) == 3
    assert judge.crossings_seen(blind._replace(velocity=still), exact, healthy, crossing_windows(scene.model)) == 0


def test_its_clock_runs_for_code_that_is_compiled():
    """A step before the clock runs has the types of those after, and leaves the state as it is."""
    scene = bench("healthy")
    with mock.patch.object(traces, "advance_and_sample", wraps=advance_and_sample) as steps:
        trace("verlet", assemble.kind_of_method("verlet").parameters(5e-7), scene.model, scene.y, np.inf)
    of_first, *of_others = [tuple(map(typeof, call.args)) for call in steps.call_args_list]
    assert {*of_others} == {of_first}
    assert steps.call_args_list[0].args[4] is not steps.call_args_list[1].args[4]
