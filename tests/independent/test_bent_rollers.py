"""The bearing in motion with a ring that bends: against differences, energy and its own rest."""

import numpy as np
import pytest

from tests.independent import bent_static, rollers
from tests.independent.beam_ring import frequencies
from tests.independent.bent_rollers import (
    R_MEAN,
    Motion,
    approaches,
    at_rest,
    contact,
    defect_contribution,
    equations,
    run,
)
from tests.independent.bent_static import POINT, Scene, harmonics, points, shape_functions, soft_pads

COARSE = 3146  # steps to a ball pass: 2 us
UNDAMPED = Motion(beta=0.0, ratio=0.0, damper=0.0)


def any_state(scene, size, seed=0):
    """Return positions and rates of ring and rollers, near equilibrium."""
    rng = np.random.default_rng(seed)
    place, speed = 1e-7 * rng.normal(size=size + rollers.Z), 1e-3 * rng.normal(size=size + rollers.Z)
    place[0] -= 1e-6
    return place[:size], place[size:], speed[:size], speed[size:]


@pytest.mark.parametrize("first", [5e-5, -1e-4, 0.0031])
def test_the_rate_is_that_of_the_approach(first):
    """Also as a roller runs along the bent race and into the slot; rollers move on in 1 ns."""
    scene, step = Scene(last=8), 1e-9
    start = first - np.pi / rollers.Z / rollers.OMEGA_C
    x, q, w, v = any_state(scene, 17)
    _, _, rate = approaches(scene, start, x, q, w, v)
    sides = [approaches(scene, start + d, x + d * w, q + d * v, w, v)[1] for d in (-step, step)]
    assert rate == pytest.approx((sides[1] - sides[0]) / (2 * step), abs=1e-5)


def test_kraemer_damps_by_the_slope_of_the_force():
    delta = np.array([-1e-7, 1e-9, 1e-7])
    force = contact(delta, np.zeros(3), 2.5e-6)
    assert force == pytest.approx(rollers.elastic(delta))
    ahead = (rollers.elastic(delta + 1e-13) - rollers.elastic(delta - 1e-13)) / 2e-13
    assert contact(delta, np.full(3, 1e-3), 2.5e-6) - force == pytest.approx(2.5e-9 * ahead, rel=1e-6)
    assert not contact(delta, np.full(3, -10.0), 2.5e-6).any()


@pytest.mark.parametrize("outside", [POINT, soft_pads(-45, 45), points(-60, 0, 60)])
def test_undamped_the_start_is_at_rest(outside):
    """Accelerations of ring and rollers vanish where the energy of everything is least."""
    motion = equations(Scene(last=8, outside=outside), UNDAMPED)
    assert np.abs(motion.slope(0.0, motion.start)).max() < 1e-4  # m/s2


def test_undamped_forces_do_the_work_of_the_energy():
    """Power of the accelerations, with fixed rollers, is minus the change of the energy."""
    scene = Scene(last=8, width=0.0, bracket=0.0)
    motion = equations(scene, UNDAMPED)
    x, q, w, v = any_state(scene, 17, seed=3)
    rates = motion.slope(0.0, np.concatenate([x, q, w, v]))[17 + rollers.Z :]
    orders = harmonics(8)
    stiffness, mass = bent_static.beam_ring.modes(orders, mass=rollers.M_O)
    m = np.concatenate([[rollers.M_O] * 2, bent_static.per_unknown(orders, mass)])
    k = np.concatenate([[0.0] * 2, bent_static.per_unknown(orders, stiffness)])
    s = shape_functions(orders, rollers.THETA)

    def energy(x, q):
        pressed = np.maximum(np.concatenate([q - s @ x, -q]), 0.0)
        thrown = rollers.M_R * rollers.OMEGA_C**2 * np.sum(R_MEAN * q + q**2 / 2)
        stored = rollers.K * 9 / 19 * np.sum(pressed ** (19 / 9)) + k @ x**2 / 2
        return stored - thrown + rollers.LOAD * (shape_functions(orders, 0.0)[0] @ x)

    power = (m * w) @ rates[:17] + rollers.M_R * v @ rates[17:]
    step = 1e-8
    change = (energy(x + step * w, q + step * v) - energy(x - step * w, q - step * v)) / (2 * step)
    assert power == pytest.approx(-change, rel=1e-5)


@pytest.mark.parametrize(("cap", "expected"), [(np.inf, frequencies(8)[0]), (25e3, 25e3)])
def test_a_lone_harmonic_swings_as_the_free_ring(cap, expected):
    """With all rollers on the inner race alone b_8 swings by itself, damped by 1 %."""
    scene = Scene(last=8, width=0.0)
    motion = equations(scene, Motion(cap=cap))
    y = np.zeros(motion.start.size)
    y[17:30] = -1e-3
    still = motion.slope(0.0, y)
    place, rate = y.copy(), y.copy()
    place[16], rate[46] = 1e-9, 1e-6
    omega = 2 * np.pi * expected
    assert (motion.slope(0.0, place) - still)[46] == pytest.approx(-(omega**2) * 1e-9, rel=1e-6)
    assert (motion.slope(0.0, rate) - still)[46] == pytest.approx(-2 * 0.01 * omega * 1e-6, rel=1e-6)


def test_rollers_at_rest_carry_load_and_their_own_centrifugal_force():
    """Outer less inner force is the centrifugal one of each roller; the outer ones carry the load."""
    scene = Scene(last=8, bracket=0.0)
    y = at_rest(scene, 0.1, None)
    angles = 0.1 + bent_static.PASS * np.arange(rollers.Z)
    outer = rollers.elastic(
        y[17:30] - shape_functions(harmonics(8), angles) @ y[:17] - bent_static.drops(scene, angles)
    )
    inner = rollers.elastic(-y[17:30])
    assert outer - inner == pytest.approx(np.full(13, rollers.M_R * rollers.OMEGA_C**2 * R_MEAN), rel=1e-4)
    assert outer @ shape_functions((), angles) == pytest.approx([rollers.LOAD, 0.0], abs=1e-6)


@pytest.mark.slow
def test_lines_under_a_point_load():
    """Harmonics to 8: the kept numbers of this solution.

    Half the step, or two more passes, change them by less than 0.1 %.
    """
    damaged, healthy = (run(equations(Scene(last=8, width=width)), 3, COARSE) for width in (0.8e-3, 0.0))
    assert 1e6 * defect_contribution(damaged, healthy) == pytest.approx(94.05, rel=5e-3)
    assert 1e6 * abs(healthy.lines()[-1]) == pytest.approx(11.70, rel=5e-3)
