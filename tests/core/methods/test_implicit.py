"""Implicit methods on one coordinate: order, damping of stiff motion, touch-down, failures."""

from itertools import pairwise
from math import exp, inf, pi

import numpy as np
import pytest

from bearingsim.core import layout as lay
from bearingsim.core.laws.stiffness.power_laws import PowerLaw
from bearingsim.core.methods import rodas
from bearingsim.core.methods.backward_euler import BackwardEuler
from bearingsim.core.methods.generalised_alpha import RHO, GeneralisedAlpha
from bearingsim.core.methods.rodas import Rodas
from bearingsim.core.methods.velocity_implicit import VelocityImplicitEuler
from bearingsim.core.outcomes import NEWTON_FAILED, STEP_TOO_SMALL, SUCCESS
from tests.scenes.stiff import Scene, dashpot, exact_state, run

SOFT = Scene(K=1.0, C=1.0, P=1.0)
STIFF = Scene(K=1e6, C=200.0, P=1.0)  # h omega from 50 to 200
DASHPOT = Scene(K=1e6, C=1e6, P=1.0)


def with_fixed_step(method, h):
    """Return the method with steps of ``h`` whatever their error."""
    return method(h, 0.0, inf, inf, h) if method in (Rodas, BackwardEuler) else method(h)


def errors(model, method, steps, span=1.0):
    """Return the errors (steps, 2) of position and velocity at the end of forced motion."""
    ends = [
        run(model, with_fixed_step(method, span / n), span, *exact_state(model, 0.0)).path[-1, :2] for n in steps
    ]
    return np.abs(np.array(ends) - exact_state(model, span))


def orders(results):
    return [np.log2(a / b) for a, b in pairwise(results)]


# the table


def standard_form():
    """Return alpha, Gamma and b of the textbook's form."""
    square = np.zeros((6, 6))
    square[:, :5] = rodas.E
    inverse = np.eye(6) / rodas.GAMMA - square
    gammas = np.linalg.inv(inverse)
    a = np.zeros((6, 6))
    a[:, :5] = rodas.A
    m = np.append(rodas.A[5], 1.0)
    return a @ gammas, gammas, m @ gammas


def test_table_satisfies_order_four_conditions():
    """Hairer and Wanner, Solving ODEs II, sec. IV.7, table 7.1; the times of the stages are row sums."""
    alpha, gammas, b = standard_form()
    beta, one = alpha + gammas, np.ones(6)
    c, d, e = alpha @ one, gammas @ one, (alpha + gammas) @ one
    assert c == pytest.approx(rodas.C, abs=1e-13)
    assert d == pytest.approx(rodas.D, abs=1e-13)
    assert b @ one == pytest.approx(1.0, abs=1e-13)
    assert b @ e == pytest.approx(1 / 2, abs=1e-13)
    assert b @ c**2 == pytest.approx(1 / 3, abs=1e-13)
    assert b @ beta @ e == pytest.approx(1 / 6, abs=1e-13)
    assert b @ c**3 == pytest.approx(1 / 4, abs=1e-13)
    assert b @ (c * (alpha @ e)) == pytest.approx(1 / 8, abs=1e-13)
    assert b @ beta @ c**2 == pytest.approx(1 / 12, abs=1e-13)
    assert b @ beta @ beta @ e == pytest.approx(1 / 24, abs=1e-13)


def test_rodas_is_l_stable():
    """R(inf) = 1 - b (alpha + Gamma)^-1 1 = 0, also for the embedded solution."""
    alpha, gammas, b = standard_form()
    embedded = np.append(rodas.A[5], 0.0) @ gammas
    assert 1.0 - b @ np.linalg.solve(alpha + gammas, np.ones(6)) == pytest.approx(0.0, abs=1e-12)
    assert 1.0 - embedded @ np.linalg.solve(alpha + gammas, np.ones(6)) == pytest.approx(0.0, abs=1e-11)


# order


@pytest.mark.parametrize(
    ("method", "model", "order"),
    [
        (Rodas, SOFT, 4.0),
        (Rodas, STIFF, 3.0),
        (Rodas, DASHPOT, 4.0),
        (BackwardEuler, SOFT, 1.0),
        (BackwardEuler, STIFF, 1.0),
        (BackwardEuler, DASHPOT, 1.0),
        (GeneralisedAlpha, SOFT, 2.0),
        (GeneralisedAlpha, DASHPOT, 2.0),
        (VelocityImplicitEuler, SOFT, 1.0),
        (VelocityImplicitEuler, DASHPOT, 1.0),
    ],
)
def test_order_on_soft_and_stiff_forced_motion(method, model, order):
    """Prothero and Robinson's test for a second-order equation; the velocity loses order first."""
    results = errors(model, method, (5, 10, 20) if method is Rodas else (20, 40, 80))
    assert orders(results[:, 1])[-1] == pytest.approx(order, abs=0.25)


@pytest.mark.parametrize(("method", "order"), [(Rodas, 4.0), (BackwardEuler, 1.0), (GeneralisedAlpha, 2.0)])
def test_order_on_van_der_pol(method, order):
    """Order from differences between halved steps, for mu = 1 over 3 s."""
    model = Scene(mu=1.0, K=1.0)
    ends = [run(model, with_fixed_step(method, 3.0 / n), 3.0, 2.0, 0.0).path[-1, :2] for n in (80, 160, 320, 640)]
    assert orders([np.linalg.norm(a - b) for a, b in pairwise(ends)])[-1] == pytest.approx(order, abs=0.25)


@pytest.mark.parametrize("fault", [1e-4, 1e-3])
def test_inexact_jacobian_costs_accuracy_not_stability(fault):
    """The error grows by about the relative error of the Jacobian, and the motion stays bounded."""
    exact = errors(STIFF, Rodas, (20, 40))[:, 1]
    inexact = errors(STIFF._replace(fault=fault), Rodas, (20, 40))[:, 1]
    assert (inexact < exact + 3.0 * fault).all()


# stiff motion


@pytest.mark.parametrize("method", [Rodas, BackwardEuler, VelocityImplicitEuler])
def test_stiff_motion_decays_in_one_step(method):
    """A dashpot of 1e9 N s/m per kg reduces a velocity of 1 m/s below 1e-6 m/s in one step of 1 s."""
    assert abs(run(Scene(C=1e9), with_fixed_step(method, 1.0), 1.0, 0.0, 1.0).path[-1, 1]) < 1e-6


def test_generalised_alpha_multiplies_stiff_motion_by_minus_rho():
    """The velocity of the same dashpot changes by the factor -rho per step."""
    v = run(Scene(C=1e9), GeneralisedAlpha(1.0), 30.0, 0.0, 1.0).path[:, 1]
    assert v[-1] / v[-2] == pytest.approx(-RHO, rel=1e-3)


def van_der_pol(mu):
    """Return the oscillator in the usual scaling, time over mu: 1/mu^2 q'' = (1 - q^2) q' - q."""
    return Scene(mu=mu * mu, K=mu * mu)


REFERENCE = 1.706167732170483, -0.8928097010247975
"""State at time 2 for mu = 1000: Mazzia and Magherini, Test Set for Initial Value Problem Solvers."""


@pytest.mark.parametrize(
    ("method", "rtol", "error"), [(Rodas, 1e-4, 1e-3), (Rodas, 1e-7, 1e-5), (BackwardEuler, 1e-4, 5e-2)]
)
def test_stiff_van_der_pol(method, rtol, error):
    w = run(van_der_pol(1e3), method(2.0 / 50, rtol, rtol, rtol, 0.1), 2.0, 2.0, 0.0)
    assert w.failed == SUCCESS
    assert w.path[-1, :2] == pytest.approx(REFERENCE, rel=error)


@pytest.mark.parametrize("mu", [1e4, 1e5, 1e6])
def test_very_stiff_van_der_pol(mu):
    """Two tolerances agree up to 1/mu^2 = 1e-12."""
    ends = [run(van_der_pol(mu), Rodas(0.04, r, r, r, 0.1), 2.0, 2.0, 0.0) for r in (1e-5, 1e-7)]
    assert [w.failed for w in ends] == [SUCCESS, SUCCESS]
    assert ends[0].path[-1, 0] == pytest.approx(ends[1].path[-1, 0], rel=1e-3)


# contact

K_FLOOR, SPEED, DROP = 1e9, 1e-2, 1e-6  # N/m on 1 kg; m/s; m above the floor


def bounce_error(method, rtol):
    """Return the relative error of position and speed after a bounce off a spring, back at the initial height."""
    span = pi / K_FLOOR**0.5 + 2.0 * DROP / SPEED
    tolerances = method(span, rtol, rtol * SPEED / K_FLOOR**0.5, rtol * SPEED, span)
    w = run(Scene(floor=dashpot(PowerLaw(K_FLOOR, 1.0), 0.0, 0.0)), tolerances, span, DROP, -SPEED)
    assert w.failed == SUCCESS
    return abs(w.path[-1, 0] / DROP - 1.0) + abs(w.path[-1, 1] / SPEED - 1.0)


def test_error_of_a_bounce_follows_the_tolerance():
    results = [bounce_error(Rodas, rtol) for rtol in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)]
    assert all(error < 3.0 * rtol for error, rtol in zip(results, (1e-2, 1e-3, 1e-4, 1e-5, 1e-6), strict=True))


def test_backward_euler_error_of_a_bounce_is_root_of_the_tolerance():
    results = [bounce_error(BackwardEuler, rtol) for rtol in (1e-3, 1e-5, 1e-7)]
    assert results[-1] < 1e-2
    for coarse, fine in pairwise(results):
        assert coarse / fine == pytest.approx(10.0, rel=0.25)


@pytest.mark.parametrize("c", [1e4, 1e6, 1e9])
@pytest.mark.parametrize("method", [Rodas, BackwardEuler])
def test_dashpot_force_that_jumps_at_contact(method, c):
    """A mass of 1 kg falls on a spring and a parallel dashpot whose force jumps at contact.

    The motion is overdamped: after the jump delta = (g/k)(1 - exp(-k t/c)), plus v m/c from the jump itself.
    """
    k, g, span, t_contact = 1e9, 300.0, 1e-3, 1e-4
    floor = dashpot(PowerLaw(k, 1.0), c, 0.0)
    tolerances = method(span / 5, 1e-3, 1e-12, min(1e-5, 1e-3 * g / c), span)
    w = run(Scene(floor=floor, g=g), tolerances, span, SPEED * t_contact + 0.5 * g * t_contact**2, -SPEED)
    assert w.failed == SUCCESS
    if c >= 1e6:
        rate = k / c
        jump = (SPEED + g * t_contact) / c
        depth = g / k * (1.0 - exp(-rate * (span - t_contact))) + jump * exp(-rate * (span - t_contact))
        assert -w.path[-1, 0] == pytest.approx(depth, rel=5e-3)


@pytest.mark.parametrize(("c", "m3"), [(1e4, 0.0), (1e9, 0.0), (1e4, 1.0 / 9.0), (1e4, 1.0)])
@pytest.mark.parametrize("method", [GeneralisedAlpha, VelocityImplicitEuler])
def test_fixed_steps_cross_a_jump(method, c, m3):
    """Newton's method converges, or the linear solution continues, where the dashpot's force begins."""
    floor = dashpot(PowerLaw(1e9, 10.0 / 9.0), c, m3)
    w = run(Scene(floor=floor, g=300.0), method(1e-7), 2e-4, DROP, -SPEED)
    assert w.failed == SUCCESS
    assert np.isfinite(w.path).all()


# tolerances, counts


@pytest.mark.parametrize(("method", "first"), [(Rodas, 1e-3), (BackwardEuler, 1e-2)])
def test_error_falls_with_the_tolerance_on_a_dashpot(method, first):
    model = DASHPOT._replace(w=3.0)
    results = []
    for rtol in first * 10.0 ** -np.arange(4):
        w = run(model, method(0.01, rtol, rtol, rtol, 1.0), 1.0, *exact_state(model, 0.0))
        path = np.array([exact_state(model, 0.01 * (n + 1)) for n in range(100)])
        results.append(np.abs(w.path[:, :2] - path).max())
    assert all(fine < 0.5 * coarse for coarse, fine in pairwise(results))
    assert results[-1] < 1e-2 * results[0] or method is BackwardEuler


def test_linear_problem_takes_at_most_two_newton_iterations():
    """The second iteration confirms the first."""
    w = run(DASHPOT, BackwardEuler(0.01, 1e-3, 1e-3, 1e-3, 0.01), 0.5, *exact_state(DASHPOT, 0.0))
    assert w.iterated <= 2 * (w.taken + w.refused)
    assert w.evaluated == w.iterated + len(w.path) + 2  # without contacts, so none in the middle of a step


def test_evaluations_of_rodas_are_counted():
    w = run(SOFT, with_fixed_step(Rodas, 0.1), 1.0, *exact_state(SOFT, 0.0))
    assert w.evaluated == 7 * (w.taken + w.refused) + len(w.path) + 2


@pytest.mark.parametrize("method", [Rodas, BackwardEuler])
def test_recorded_instants_lie_within_steps(method):
    """Errors at ten instants within each step are of third order, or of first for backward Euler."""
    h = 0.1 if method is Rodas else 0.02
    model = SOFT
    full_steps = run(model, method(h / 10, 0.0, inf, inf, h), 1.0, *exact_state(model, 0.0))
    half_steps = run(model, method(h / 20, 0.0, inf, inf, h / 2), 1.0, *exact_state(model, 0.0))
    worst = []
    for w in (full_steps, half_steps):
        instants = np.arange(1, len(w.path) + 1) / len(w.path)
        worst.append(np.abs(w.path[:, :2] - [exact_state(model, t) for t in instants]).max())
    assert np.log2(worst[0] / worst[1]) > (2.7 if method is Rodas else 0.8)


# failure


def test_diverging_newton_iteration_fails():
    """With derivatives of the wrong sign the iteration diverges."""
    w = run(Scene(K=1e8, fault=-3.0), GeneralisedAlpha(0.1), 1.0, 1.0, 0.0)
    assert w.failed == NEWTON_FAILED
    assert w.y[lay.FAILED_BODY] == 0


@pytest.mark.parametrize(("method", "outcome"), [(Rodas, STEP_TOO_SMALL), (BackwardEuler, NEWTON_FAILED)])
def test_non_finite_force_ends_the_run(method, outcome):
    w = run(Scene(K=np.nan), method(0.1, 1e-3, 1e-3, 1e-3, 0.1), 0.3, 1.0, 0.0)
    assert w.failed == outcome


def test_backward_euler_shortens_steps_if_newton_fails():
    """Derivatives of the wrong sign do not matter in steps much shorter than the period."""
    floor = dashpot(PowerLaw(K_FLOOR, 1.0), 0.0, 0.0)
    w = run(Scene(floor=floor, fault=-3.0), BackwardEuler(1e-4, 1e-2, 1e-9, 1e-4, 1e-4), 4e-4, DROP, -SPEED)
    assert w.failed == SUCCESS
    assert w.refused > 0
    assert w.path[-1, 1] == pytest.approx(SPEED, rel=0.2)
