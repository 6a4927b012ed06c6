"""Explicit methods: tables, order, and longest stable step on an oscillator and on a bearing."""

from math import inf, nan, sqrt

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.jit import jit
from bearingsim.core.methods import (
    dop853,
    dormand_prince,
    generalised_alpha,
    nystrom,
    rk4,
    stabilised,
    symplectic_euler,
    velocity_implicit,
    verlet,
)
from bearingsim.core.methods.dop853 import Dop853
from bearingsim.core.methods.dormand_prince import DormandPrince
from bearingsim.core.methods.interface import stability_ratio, step
from bearingsim.core.methods.limit import critical_step
from bearingsim.core.methods.nystrom import Nystrom
from bearingsim.core.methods.rk4 import RungeKutta4
from bearingsim.core.methods.stabilised import Stabilised
from bearingsim.core.methods.symplectic_euler import SymplecticEuler
from bearingsim.core.methods.tableau import make_runge_kutta
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.models.interface import accelerations, damping_per_mass, stiffness_per_mass
from tests.scenes.nf308 import at_rest, case
from tests.scenes.oscillators import Oscillator, at_even_steps, bouncing_roller, pendulum, run

EIGHTH = make_runge_kutta(dop853.a[:12, :12], dop853.a[12, :12])
RUNGE_KUTTA = {
    "rk4": (rk4.TABLE, 4),
    "dormand-prince": (dormand_prince.TABLE, 5),
    "dormand-prince, embedded": (make_runge_kutta(dormand_prince.a, dormand_prince.EMBEDDED), 4),
    "dop853": (EIGHTH, 8),
    "dop853, of fifth order": (make_runge_kutta(EIGHTH.a, EIGHTH.b - dop853.E_5_V[:12]), 5),
    "dop853, of third order": (make_runge_kutta(EIGHTH.a, EIGHTH.b - dop853.E_3_V[:12]), 3),
    "stabilised": (stabilised.TABLE, 2),
}
FIXED_STEP_METHODS = (Verlet, SymplecticEuler, RungeKutta4, Nystrom, Stabilised)


# Tables


@pytest.mark.parametrize("name", RUNGE_KUTTA)
def test_order_conditions(name):
    """Bushy trees b c^(k-1) = 1/k, tall trees b a^(k-2) c = 1/k!, and trees of two branches, up to the order."""
    (c, a, _, b, _), order = RUNGE_KUTTA[name]
    tall = np.ones(len(c))
    for k in range(1, order + 1):
        assert b @ c ** (k - 1) == pytest.approx(1.0 / k, abs=1e-13)
        assert b @ tall == pytest.approx(1.0 / np.prod(np.arange(1, k + 1)), abs=1e-13)
        tall = a @ tall
    for m in range(1, order - 1):  # c^m times (a c^n): 1/((n + 1)(m + n + 2))
        for n in range(1, order - 1 - m):
            assert b @ (c**m * (a @ c**n)) == pytest.approx(1.0 / ((n + 1) * (m + n + 2)), abs=1e-13)


def test_nodes_equal_published_values():
    """Row sums of the tables equal the published nodes."""
    assert dormand_prince.TABLE.c == pytest.approx([0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1, 1], abs=1e-14)
    root = sqrt(6.0)
    nodes = [0, 2 / 135 * (6 - root), (6 - root) / 45, (6 - root) / 30, (6 + root) / 30]
    more_nodes = [1 / 3, 1 / 4, 4 / 13, 127 / 195, 3 / 5, 6 / 7, 1, 1, 1 / 10, 1 / 5, 7 / 9]
    assert dop853.TABLE.c == pytest.approx([*nodes, *more_nodes], abs=1e-13)
    assert stabilised.TABLE.c[0] == 0.0
    assert (np.diff(stabilised.TABLE.c) > 0.0).all()


def test_continuous_extensions_join_start_and_end():
    """The extensions equal the step at its end, and integrate time exactly everywhere."""
    for extension, b in ((dop853.EXTENSION_V, dop853.a[12]), (dormand_prince.EXTENSION_V, dormand_prince.b)):
        assert extension[0] == pytest.approx(b)
        assert extension.sum(axis=1) == pytest.approx([1.0, *[0.0] * (len(extension) - 1)], abs=1e-11)


def test_stabilised_table_equals_the_recurrence():
    """R(z) of the table is that of the paper, 1 + b_s (T_s(w_0 + w_1 z) - T_s(w_0)) scaled to 1 at z = 0."""
    s = stabilised.STAGES
    T = np.polynomial.Chebyshev.basis(s)
    w_0 = 1.0 + stabilised.EPS / s**2
    w_1, b = T.deriv(1)(w_0) / T.deriv(2)(w_0), T.deriv(2)(w_0) / T.deriv(1)(w_0) ** 2
    for z in (-40.0, -11.0, -1.0, -0.1):
        R = 1.0 + z * stabilised.TABLE.b @ np.linalg.solve(np.eye(s) - z * stabilised.TABLE.a, np.ones(s))
        assert pytest.approx(1.0 + b * (T(w_0 + w_1 * z) - T(w_0)), abs=1e-10) == R


# Order


@pytest.mark.parametrize(
    ("method", "order", "steps"),
    [
        (SymplecticEuler, 1, (400, 800, 1600)),
        (Verlet, 2, (100, 200, 400)),
        (Stabilised, 2, (40, 80, 160)),
        (RungeKutta4, 4, (40, 80, 160)),
        (Nystrom, 4, (40, 80, 160)),
        (DormandPrince, 5, (40, 80, 160)),
        (Dop853, 8, (10, 14, 20, 28)),
    ],
)
def test_order_on_a_smooth_problem(method, order, steps):
    """A nonlinear oscillator with a force of position, speed and time, against DOP853 with a short step."""
    model, span = pendulum(4.0, 0.3, 0.7), 4.0
    exact = at_even_steps(Dop853, model, span / 400, 400, 0.5, 0.2)
    errors = [np.abs(at_even_steps(method, model, span / n, n, 0.5, 0.2) - exact).max() for n in steps]
    assert -np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(order, abs=0.3)


# Jumps


@pytest.mark.parametrize(
    "module", [generalised_alpha, nystrom, rk4, stabilised, symplectic_euler, velocity_implicit, verlet]
)
def test_jump_at_the_cusp_fraction_causes_no_first_order_error(module):
    """The force turns from 1 to -1 N on 1 kg within step 11 of 40; the speed then is the time before less that
    after it, except for 2 % of a step."""
    method, h, steps = module.KIND.parameters, 0.01, 40
    jump = (10 + module.KIND.cusp) * h
    out, _ = run(method(h), Oscillator(0.0, 0.0, g=-1.0, until=jump, after=-1.0), steps, 0.0, 0.0)
    assert out[-1, 1] == pytest.approx(jump - (steps * h - jump), abs=0.021 * h)


# Limits


def is_unstable(method, K, C):
    """Check if the oscillator's motion grows by a factor of 1000 in 6000 steps."""
    out, _ = run(method, Oscillator(K, C), 6000, q=1.0 / sqrt(K), v=0.7)
    return not np.abs(out[-50:, 1] + sqrt(K) * out[-50:, 0]).max() < 1e3


UNCERTAIN_ZETA = (
    0.9,
    1.5,
)  # between these damping ratios, and below 0.04, Chebyshev's stability interval has gaps


@pytest.mark.parametrize(
    ("method", "zeta"),
    [
        (method, zeta)
        for method in FIXED_STEP_METHODS
        for zeta in (0.0, 0.01, 0.05, 0.2, 0.4, 0.54, 0.8, 0.97, 1.05, 1.8, 5.0, 16.0, 40.0)
        if method is not Stabilised or (0.04 < zeta < UNCERTAIN_ZETA[0] or zeta > UNCERTAIN_ZETA[1])
    ],
)
def test_measured_limit_equals_linear_theory(method, zeta):
    """Limits agree within 2 % for each explicit method and damping ratio; that of symplectic Euler is h_c."""
    if method is Stabilised and (zeta < 0.04 or (zeta > 0.9 and zeta < 1.5)):
        pytest.skip("its stability interval has gaps here")
    omega = 2e5
    K, C = omega * omega, 2.0 * zeta * omega
    low, high = 0.0, 60.0 / (C + omega)
    while high - low > 2e-3 * high:
        h = 0.5 * (low + high)
        low, high = (low, h) if is_unstable(method(h), K, C) else (h, high)
    assert stability_ratio(method(low), K, C) == pytest.approx(1.0, abs=0.02)
    if method is SymplecticEuler:
        assert low == pytest.approx(2.0 / omega * (sqrt(1.0 + zeta * zeta) - zeta), rel=0.02)


def test_adaptive_methods_have_no_stability_limit():
    """Error control limits their steps."""
    for method in (Dop853, DormandPrince):
        assert stability_ratio(method(1.0, 1e-6, 1e-9, 1e-9, 1.0), 1e12, 1e9) == 0.0


@jit
def take_steps(method, model, steps, y):
    """Take steps of a bearing after an evaluation of its accelerations."""
    accelerations(model, 0.0, y)
    for n in range(steps):
        step(method, model, n * method.h, y)


@jit
def stiffness_and_damping(model, y, j):
    """Return K (1/s^2) and C (1/s) of a monitored body."""
    accelerations(model, 0.0, y)
    return stiffness_per_mass(model, y, j), damping_per_mass(model, y, j)


@pytest.fixture(scope="module", params=["0.5 s/m", "50 s/m"])
def preloaded_bearing(request):
    """Return the preloaded NF308 under 300 N with a fixed cage, its equilibrium and the linearised equations."""
    model = assemble.model(case(clearance="-4 um", load="300 N", contact={"damping": {"chi": request.param}}))
    model = model._replace(bearing=model.bearing._replace(omega_c=0.0))
    y = at_rest(model)
    cells = np.array([lay.POSITION, lay.POSITION + 1, *range(lay.RADIAL, lay.RADIAL + 13)])
    shift, A_q, A_v = lay.VELOCITY - lay.POSITION, np.empty((15, 15)), np.empty((15, 15))
    for k, cell in enumerate(cells):
        for matrix, varied, increment in ((A_q, cell, 1e-11), (A_v, cell + shift, 1e-6)):
            results = []
            for sign in (-1.0, 1.0):
                z = y.copy()
                z[varied] += sign * increment
                accelerations(model, 0.0, z)
                results.append(z[cells + lay.ACCELERATION - lay.POSITION])
            matrix[:, k] = (results[1] - results[0]) / (2.0 * increment)
    return model, y, cells, A_q, A_v


def step_matrix(method, A_q, A_v, h):
    """Return the amplification matrix of one step for q'' = A_q q + A_v v, from the method's formula."""
    n = len(A_q)
    I, O = np.eye(n), np.zeros((n, n))  # noqa: E741
    if method is SymplecticEuler:
        return np.block([[I, h * I], [O, I]]) @ np.block([[I, O], [h * A_q, I + h * A_v]])
    if method is Verlet:  # the state includes the last accelerations: (q, v, a)
        q_1, v_predicted = np.block([I, h * I, h * h / 2 * I]), np.block([O, I, h * I])
        a_1 = A_q @ q_1 + A_v @ v_predicted
        return np.block([[q_1], [np.block([O, I, h / 2 * I]) + h / 2 * a_1], [a_1]])
    table = {RungeKutta4: rk4.TABLE, Nystrom: nystrom.TABLE, Stabilised: stabilised.TABLE}[method]
    q, v, f = np.block([I, O]), np.block([O, I]), []
    for i, c in enumerate(table.c):
        q_i = q + c * h * v + h * h * sum((table.A[i, j] * f[j] for j in range(i)), np.zeros((n, 2 * n)))
        v_i = v + h * sum((table.a[i, j] * f[j] for j in range(i)), np.zeros((n, 2 * n)))
        f.append(A_q @ q_i + A_v @ v_i)
    new_q = q + h * v + h * h * sum(B * f_j for B, f_j in zip(table.B, f, strict=True))
    return np.block([[new_q], [v + h * sum(b * f_j for b, f_j in zip(table.b, f, strict=True))]])


def largest_stable_step(unstable, high, count):
    """Return the largest stable step (s): bisection below the first unstable of ``count`` steps up to ``high``."""
    trial_steps = high * np.arange(1, count + 1) / count
    high_stable = next(h for h in trial_steps if unstable(h))
    low = high_stable - trial_steps[0]
    while high_stable - low > 1e-3 * high_stable:
        h = 0.5 * (low + high_stable)
        low, high_stable = (low, h) if unstable(h) else (h, high_stable)
    return low


@pytest.mark.parametrize("method", FIXED_STEP_METHODS)
def test_measured_limit_on_the_loaded_bearing(method, preloaded_bearing):
    """The limit agrees within 2 % with linear theory of the whole bearing, within 10 % with the monitor's limit.

    Growth is measured in the accelerations: beyond its limit Verlet reaches a false equilibrium under heavy
    damping, with forces that alternate from step to step and no motion (docs/touch_down.md).
    """
    model, y, cells, A_q, A_v = preloaded_bearing
    K, C = np.max([stiffness_and_damping(model, y, j) for j in range(13)], axis=0)
    longest = 25.0 * critical_step(K, C)

    def is_unstable_in_theory(h):
        return np.abs(np.linalg.eigvals(step_matrix(method, A_q, A_v, h))).max() > 1.0 + 1e-6

    def is_unstable_in_simulation(h):
        z, rng = y.copy(), np.random.default_rng(1)
        z[cells + lay.VELOCITY - lay.POSITION] += 1e-9 * rng.normal(size=15)
        take_steps(method(h), model, 20_000, z)
        return not np.abs(z[cells + lay.ACCELERATION - lay.POSITION]).max() < 10.0

    limit = largest_stable_step(is_unstable_in_simulation, longest, 20)
    assert limit == pytest.approx(largest_stable_step(is_unstable_in_theory, longest, 200), rel=0.02)
    assert stability_ratio(method(limit), K, C) == pytest.approx(1.0, abs=0.1)


# Energy


def test_verlet_conserves_the_energy_of_a_contact():
    """The energy of a closed contact of power 10/9 changes by less than 1e-4 (measured: 4e-8) in 38 000 periods.

    A bouncing body touches the floor at another fraction of a step each time; its energy varies by a per cent.
    """
    for v, max_change in ((0.3, 1e-4), (3.0, 0.03)):  # relative to the speed of lift-off
        K, n, g = 1e4, 10.0 / 9.0, 100.0
        model = bouncing_roller(g, K, n)
        rest_depth = (g / K) ** (1.0 / n)
        h = 2.0 * np.pi / sqrt(n * K * rest_depth ** (n - 1.0)) / 52.0
        out, _ = run(Verlet(h), model, 38_000 * 52, q=-rest_depth, v=v * sqrt(g * rest_depth))
        depth = np.maximum(-out[:, 0], 0.0)
        energy = 0.5 * out[:, 1] ** 2 + K * depth ** (n + 1.0) / (n + 1.0) + g * out[:, 0]
        rest_energy = K * rest_depth ** (n + 1.0) / (n + 1.0) - g * rest_depth
        means = (energy.reshape(-1, 52 * 380).mean(axis=1) - rest_energy) / (energy[0] - rest_energy)
        assert (out[:, 0].max() > 0.0) == (v > 1.0)
        assert np.ptp(means) < max_change


@pytest.mark.parametrize("method", FIXED_STEP_METHODS)
@pytest.mark.parametrize(("K", "C"), [(inf, inf), (nan, nan), (nan, 1.0), (1.0, nan), (inf, 1.0), (1.0, inf)])
def test_non_finite_stiffness_exceeds_every_limit(method, K, C):
    """A non-finite value is never used as an index of a table."""
    ratio = stability_ratio(method(1e-6), K, C)
    assert ratio == inf if method in (RungeKutta4, Nystrom, Stabilised) else not ratio <= 1.0
