"""Implicit methods on the bearing: next to Verlet at a small step, and with dashpots no explicit method bears."""

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import Monitor, prepare_first_step
from bearingsim.core.laws.damping.general import General, Power
from bearingsim.core.methods.backward_euler import BackwardEuler
from bearingsim.core.methods.rodas import Rodas
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.outcomes import SUCCESS
from tests.scenes.nf308 import PLACES, SLOT, at_rest, case, recorded

INSTANT, PASS = 1e-5, 1.0 / 159.0  # s: between recorded instants; of a ball pass
LOAD = 150.0  # N


def follow(model, method, passes=2.0, seed=0):
    """path (n, 3): the ring's velocity, the first roller's outer force; and the buffer. Ball passes from rest.

    ``seed``: of rollers that are moved by some 1e-14 of their place, none if 0.
    """
    y, times = at_rest(model), round(INSTANT / method.h)
    if seed:
        y[lay.RADIAL : lay.RADIAL + 13] *= 1.0 + 1e-14 * np.random.default_rng(seed).normal(size=13)
    out = np.empty((len(PLACES), times * round(passes * PASS / INSTANT)))
    if not isinstance(method, Verlet):
        prepare_first_step(method, model, 0.0, y)
    recorded(method, model, Monitor(8, 1.0), 0, y, PLACES, out)
    return out[[2, 3, 6], times - 1 :: times].T, y


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
    [(Rodas, 1e-3, 2e-3, 25_000), (Rodas, 1e-5, 2e-5, 50_000), (BackwardEuler, 1e-3, 0.08, 45_000)],
)
def test_next_to_verlet_on_a_slot(slot, reference, method, rtol, error, evaluations):
    """Backward Euler's law is the same, told in powers: so the method is compiled for one type of law.

    The median of five starts that differ by rounding: an adaptive method then takes other steps, and the error of
    one run is its own (Rodas at 1e-5: 6e-6 to 2.2e-5).
    """
    model, apart_by = slot if method is Rodas else in_powers(slot), []
    for seed in range(5):
        path, y = follow(model, tolerances(method, rtol), seed=seed)
        assert y[lay.FAILED] == SUCCESS
        assert y[lay.EVALUATIONS] < evaluations
        assert path[:, 2].max() == pytest.approx(reference[:, 2].max(), rel=0.01)
        apart_by.append(apart(path, reference))
    assert np.median(apart_by) < error


def in_powers(model):
    """The model with its law, k delta^(10/9) (1 + chi v), as an elastic force and a dashpot."""
    both = model.outer, model.inner
    laws = [General(law.stiffness, law.chi * law.stiffness.k, Power(1.0), Power(10 / 9)) for law in both]
    return model._replace(outer=laws[0], inner=laws[1])


def dashpots(model, c, m3):
    law = General(model.outer.stiffness, c, Power(1.0), Power(m3))  # one type, compiled once
    return model._replace(outer=law, inner=law)


@pytest.mark.slow
@pytest.mark.parametrize("c", [1e6, 1e9])
def test_two_methods_agree_on_dashpots_that_jump(slot, c):
    """m3 = 0: the dashpot's force sets in at once, on the slot's edge with 1e7 N at 1e9 N s/m."""
    model = dashpots(slot, c, 0.0)
    stiff, y = follow(model, tolerances(Rodas, 1e-4, c))
    assert y[lay.FAILED] == SUCCESS
    for rtol, error in ((1e-2, 0.01), (1e-3, 0.004)):
        path, y = follow(model, tolerances(BackwardEuler, rtol, c))
        assert y[lay.FAILED] == SUCCESS
        assert apart(path, stiff) < error
        assert np.abs(path[:, :2]).max() < 0.1


@pytest.mark.slow
@pytest.mark.parametrize("c", [1e6, 1e9])
@pytest.mark.parametrize("m3", [1.0, 2.0])
@pytest.mark.parametrize("method", [Rodas, BackwardEuler])
def test_dashpots_that_grow_with_the_approach_stay_bounded(slot, method, c, m3):
    """With so little damping the rollers chatter: no two methods agree instant by instant."""
    path, y = follow(dashpots(slot, c, m3), tolerances(method, 1e-2))
    assert y[lay.FAILED] == SUCCESS
    assert np.abs(path[:, :2]).max() < 0.1
    assert path[:, 2].max() < 20.0 * LOAD
