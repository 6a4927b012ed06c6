"""Implicit methods on the bearing: against Verlet with a short step, and with very stiff dashpots."""

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
from tests.scenes.nf308 import ROWS, SLOT, advance_recorded, at_rest, case

INSTANT, PASS = 1e-5, 1.0 / 159.0  # s: between recorded instants; of a ball pass
LOAD = 150.0  # N


def simulate(model, method, passes=2.0, seed=0):
    """Return the path (n, 3), the ring's velocity and the first roller's outer force, and the buffer, from rest.

    seed: of relative changes of 1e-14 in the rollers' initial positions; 0 for none.
    """
    y, steps_per_instant = at_rest(model), round(INSTANT / method.h)
    if seed:
        y[lay.RADIAL : lay.RADIAL + 13] *= 1.0 + 1e-14 * np.random.default_rng(seed).normal(size=13)
    out = np.empty((len(ROWS), steps_per_instant * round(passes * PASS / INSTANT)))
    if not isinstance(method, Verlet):
        prepare_first_step(method, model, 0.0, y)
    advance_recorded(method, model, Monitor(8, 1.0), 0, y, ROWS, out)
    return out[[2, 3, 6], steps_per_instant - 1 :: steps_per_instant].T, y


def relative_difference(path, reference):
    """Return the relative L2 difference of the ring's velocity."""
    return np.linalg.norm(path[:, :2] - reference[:, :2]) / np.linalg.norm(reference[:, :2])


def tolerances(method, rtol, c=0.0):
    """Return the method with tolerance ``rtol``, for Rodas also in the force of a dashpot c (N s/m)."""
    atol_v = rtol * (LOAD / c if c > 0.0 and method is Rodas else 1e-3)
    return method(INSTANT, rtol, rtol * 1e-8, min(atol_v, rtol * 1e-3), 1e-5)


@pytest.fixture(scope="module")
def slot():
    return assemble.model(case(defect=SLOT))


@pytest.fixture(scope="module")
def reference(slot):
    return simulate(slot, Verlet(2e-8))[0]


@pytest.mark.parametrize(
    ("method", "rtol", "error", "evaluations"),
    [(Rodas, 1e-3, 2e-3, 25_000), (Rodas, 1e-5, 2e-5, 50_000), (BackwardEuler, 1e-3, 0.08, 45_000)],
)
def test_agreement_with_verlet_on_a_slot(slot, reference, method, rtol, error, evaluations):
    """Backward Euler has the same law in another form, so that it is compiled for one type of law.

    The error is the median of five starts that differ by rounding, because an adaptive method then takes other
    steps (Rodas at 1e-5: errors from 6e-6 to 2.2e-5).
    """
    model, differences = slot if method is Rodas else with_general_law(slot), []
    for seed in range(5):
        path, y = simulate(model, tolerances(method, rtol), seed=seed)
        assert y[lay.FAILED] == SUCCESS
        assert y[lay.EVALUATIONS] < evaluations
        assert path[:, 2].max() == pytest.approx(reference[:, 2].max(), rel=0.01)
        differences.append(relative_difference(path, reference))
    assert np.median(differences) < error


def with_general_law(model):
    """Return the model with its law, k delta^(10/9) (1 + chi v), as an elastic force and a dashpot."""
    races = model.outer, model.inner
    laws = [General(law.stiffness, law.chi * law.stiffness.k, Power(1.0), Power(10 / 9)) for law in races]
    return model._replace(outer=laws[0], inner=laws[1])


def with_dashpots(model, c, m3):
    law = General(model.outer.stiffness, c, Power(1.0), Power(m3))  # one type, compiled once
    return model._replace(outer=law, inner=law)


@pytest.mark.slow
@pytest.mark.parametrize("c", [1e6, 1e9])
def test_methods_agree_on_dashpots_that_jump(slot, c):
    """With m3 = 0 the dashpot's force jumps at contact, to 1e7 N on the slot's edge at 1e9 N s/m."""
    model = with_dashpots(slot, c, 0.0)
    rodas_path, y = simulate(model, tolerances(Rodas, 1e-4, c))
    assert y[lay.FAILED] == SUCCESS
    for rtol, error in ((1e-2, 0.01), (1e-3, 0.004)):
        path, y = simulate(model, tolerances(BackwardEuler, rtol, c))
        assert y[lay.FAILED] == SUCCESS
        assert relative_difference(path, rodas_path) < error
        assert np.abs(path[:, :2]).max() < 0.1


@pytest.mark.slow
@pytest.mark.parametrize("c", [1e6, 1e9])
@pytest.mark.parametrize("m3", [1.0, 2.0])
@pytest.mark.parametrize("method", [Rodas, BackwardEuler])
def test_motion_with_indentation_dependent_dashpots_is_bounded(slot, method, c, m3):
    """With so little damping the rollers bounce irregularly, so only bounds are compared."""
    path, y = simulate(with_dashpots(slot, c, m3), tolerances(method, 1e-2))
    assert y[lay.FAILED] == SUCCESS
    assert np.abs(path[:, :2]).max() < 0.1
    assert path[:, 2].max() < 20.0 * LOAD
