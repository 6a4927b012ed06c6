"""Implicit methods on the bearing: next to Verlet at a small step, and with dashpots no explicit method bears."""

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core.jit import jit
from bearingsim.core.laws.damping.general import General, Power
from bearingsim.core.layout import EVALUATED, FAILED, Q_O, VELOCITY, X, Y
from bearingsim.core.methods.backward_euler import BackwardEuler
from bearingsim.core.methods.interface import prepare, step
from bearingsim.core.methods.rodas import Rodas
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.outcomes import FINE
from tests.scenes.nf308 import SLOT, at_rest, case

INSTANT, PASS = 1e-5, 1.0 / 159.0  # s: between recorded instants; of a ball pass
LOAD = 150.0  # N


@jit
def pursue(method, model, times, y, path):
    """Recorded instants of ``times`` steps each: the ring's velocity, the first roller's outer force (n, 3)."""
    for n in range(len(path)):
        for k in range(times):
            step(method, model, (n * times + k) * method.h, y)
        path[n, 0], path[n, 1], path[n, 2] = y[VELOCITY + X], y[VELOCITY + Y], y[Q_O]


@jit
def set_out(method, model, y):
    """What the method needs at t = 0."""
    prepare(method, model, 0.0, y)


def follow(model, method, passes=2.0):
    """path (n, 3) and the buffer after so many ball passes from rest."""
    y = at_rest(model)
    path = np.empty((round(passes * PASS / INSTANT), 3))
    if not isinstance(method, Verlet):
        set_out(method, model, y)
    pursue(method, model, round(INSTANT / method.h), y, path)
    return path, y


def apart(one, other):
    """Relative L2 of the ring's velocity."""
    return np.linalg.norm(one[:, :2] - other[:, :2]) / np.linalg.norm(other[:, :2])


def tolerances(method, rtol, c=0.0):
    """As good as ``rtol``; with a dashpot c (N s/m) also in its force, which backward Euler has for nothing."""
    atol_v = rtol * (LOAD / c if c > 0.0 and method is Rodas else 1e-3)
    return method(INSTANT, rtol, rtol * 1e-8, min(atol_v, rtol * 1e-3), 1e-5)


@pytest.fixture(scope="module")
def slot():
    return assemble.model(case(defect=SLOT))


@pytest.fixture(scope="module")
def reference(slot):
    return follow(slot, Verlet(2e-8))[0]


@pytest.mark.parametrize(
    ("method", "rtol", "error", "evaluations"),
    [(Rodas, 1e-3, 2e-3, 25_000), (Rodas, 1e-5, 2e-5, 50_000), (BackwardEuler, 1e-3, 0.08, 40_000)],
)
def test_next_to_verlet_on_a_slot(slot, reference, method, rtol, error, evaluations):
    path, y = follow(slot, tolerances(method, rtol))
    assert y[FAILED] == FINE
    assert apart(path, reference) < error
    assert y[EVALUATED] < evaluations
    assert path[:, 2].max() == pytest.approx(reference[:, 2].max(), rel=0.01)


def dashpots(model, c, m3):
    law = General(model.outer.stiffness, c, Power(1.0), Power(m3))  # one type, compiled once
    return model._replace(outer=law, inner=law)


@pytest.mark.slow
@pytest.mark.parametrize("c", [1e6, 1e9])
def test_two_methods_agree_on_dashpots_that_jump(slot, c):
    """m3 = 0: the dashpot's force sets in at once, on the slot's edge with 1e7 N at 1e9 N s/m."""
    model = dashpots(slot, c, 0.0)
    stiff, y = follow(model, tolerances(Rodas, 1e-4, c))
    assert y[FAILED] == FINE
    for rtol, error in ((1e-2, 0.01), (1e-3, 0.004)):
        path, y = follow(model, tolerances(BackwardEuler, rtol, c))
        assert y[FAILED] == FINE
        assert apart(path, stiff) < error
        assert np.abs(path[:, :2]).max() < 0.1


@pytest.mark.slow
@pytest.mark.parametrize("c", [1e6, 1e9])
@pytest.mark.parametrize("m3", [1.0, 2.0])
@pytest.mark.parametrize("method", [Rodas, BackwardEuler])
def test_dashpots_that_grow_with_the_approach_stay_bounded(slot, method, c, m3):
    """With so little damping the rollers chatter: no two methods agree instant by instant."""
    path, y = follow(dashpots(slot, c, m3), tolerances(method, 1e-2))
    assert y[FAILED] == FINE
    assert np.abs(path[:, :2]).max() < 0.1
    assert path[:, 2].max() < 20.0 * LOAD
