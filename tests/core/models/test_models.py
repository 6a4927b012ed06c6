"""Models against an independent solution, each other, and balances of mechanics."""

from math import pi

import numpy as np
import pytest
from scipy.optimize import brentq

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import Monitor, start_at_rest
from bearingsim.core.defects.closed_forms import roller_drop
from bearingsim.core.defects.pairs import GROUP_COUNT, GROUP_WEIGHT, REDUCED_RADIUS
from bearingsim.core.laws.damping.interface import normal_force
from bearingsim.core.methods.rk4 import RungeKutta4
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.outcomes import NOT_FINITE
from bearingsim.simulation.simulate import simulate
from tests.independent import rollers
from tests.scenes.nf308 import ROWS, SLOT, advance_recorded, at_rest, case, drive, light_rollers


@pytest.fixture(scope="module")
def independent():
    """Return the ring velocity every 10 us over 20 ms (three crossings of a 0.8 mm slot) of the reference.

    Steps of 1 us at most and a tolerance of 1e-9 change it by 2e-5 of its range.
    """
    times = 1e-5 * np.arange(1, 2001)
    return rollers.simulate(0.8e-3, 0.05e-3, times, max_step=1e-5, rtol=1e-6)


def every_10_us(method):
    """Return the ring velocity of ``rollers`` at the same instants."""
    stride = round(1e-5 / method.h)
    return drive(assemble.model(case(defect=SLOT)), method, 2000 * stride)[2:4, stride - 1 :: stride]


def test_rk4_agrees_with_an_independent_solution(independent):
    """At 0.5 us within 0.1 % of the velocity's range at every instant."""
    error = np.abs(every_10_us(RungeKutta4(5e-7)) - independent).max(axis=1)
    assert (error < 1e-3 * np.ptp(independent[0])).all()


def test_verlet_agrees_with_an_independent_solution_and_converges(independent):
    """At 0.5 us within 0.2 % RMS of the range; at 0.25 us at least twice as accurate."""
    errors = [np.sqrt(np.mean((every_10_us(Verlet(h))[0] - independent[0]) ** 2)) for h in (5e-7, 2.5e-7)]
    assert errors[0] < 2e-3 * np.ptp(independent[0])
    assert errors[1] < errors[0] / 2


def test_a_rejected_step_gives_a_wrong_result(independent):
    """Verlet at 2 us on the 0.8 mm slot without monitor: not finite, or an error above a tenth of the range."""
    out, model = np.empty((len(ROWS), 10_000)), assemble.model(case(defect=SLOT))
    steps, outcome, _ = advance_recorded(Verlet(2e-6), model, Monitor(1, 1.0), 0, at_rest(model), ROWS, out)
    velocity = out[2, 4:steps:5]
    assert outcome == NOT_FINITE or np.abs(velocity - independent[0]).max() > 0.1 * np.ptp(independent[0])


@pytest.mark.parametrize("shape", ["rectangular", "circular"])
def test_rollers_without_mass_are_a_ring(shape):
    """Rollers of 3 % of their mass move the line by less than 2 %; a bowl has its groups solved in series."""
    defect = SLOT | {"shape": shape, "length": "6 mm"}
    fields = {"duration": "0.1 s", "settle": "20 ms", "defect": defect} | light_rollers(0.03)
    rollers = simulate(case(model="rollers", **fields)).features
    ring = simulate(case(model="ring", **fields)).features
    assert rollers["velocity@BPFO"] == pytest.approx(ring["velocity@BPFO"], rel=0.02)
    assert rollers["velocity@BPFO.phase"] == pytest.approx(ring["velocity@BPFO.phase"], abs=0.02)


@pytest.mark.parametrize("defect", [None, SLOT, SLOT | {"shape": "circular", "length": "6 mm", "angle": "20 deg"}])
def test_slow_rotation_is_static(defect):
    """At 6 rpm inertia and damping are negligible: displacement amplitudes within 1 %."""
    fields = {"speed": "6 rpm", "duration": "2 s", "settle": "0.2 s", "sampling": "1000 Hz", "step": "100 us"}
    fields |= {"defect": defect} if defect else {}
    ring = simulate(case(model="ring", **fields | {"step": "10 us"})).features
    static = simulate(case(model="static", **fields)).features
    for line in ("displacement@BPFO", "displacement@2BPFO"):
        assert ring[line] == pytest.approx(static[line], rel=0.01)


def random_state(model, seed):
    """Return a buffer away from equilibrium by micrometres and centimetres per second."""
    random = np.random.default_rng(seed)
    y = at_rest(model)
    y[lay.POSITION : lay.POSITION + 2] += random.normal(0, 1e-6, 2)
    y[lay.VELOCITY : lay.VELOCITY + 2] += random.normal(0, 1e-2, 2)
    y[lay.RADIAL : lay.RADIAL + 13] += random.normal(0, 1e-6, 13)
    y[lay.RADIAL_V : lay.RADIAL_V + 13] += random.normal(0, 1e-2, 13)
    return y


@pytest.mark.parametrize("seed", range(5))
def test_momentum_balances_at_any_state(seed):
    """On ring and rollers act only the load, the bracket, the inner race and the centrifugal load."""
    model = assemble.model(case(defect=SLOT, clearance="1 um"))
    b, s = model.bearing, model.support
    y = random_state(model, seed)
    start_at_rest(model, 0.3e-3, y)
    e = np.array([y[lay.COS : lay.COS + 13], y[lay.SIN : lay.SIN + 13]])
    r = (b.R_o + b.R_i) / 2 + y[lay.RADIAL : lay.RADIAL + 13]
    rate = b.m_r * (e @ (y[lay.RADIAL_A : lay.RADIAL_A + 13] - b.omega_c**2 * r))
    rate += b.m_o * y[lay.ACCELERATION : lay.ACCELERATION + 2]
    u, w = y[lay.POSITION : lay.POSITION + 2], y[lay.VELOCITY : lay.VELOCITY + 2]
    external = np.array([-s.F, 0.0]) - s.k_b * (u - [s.x_0, s.y_0]) - s.c_b * w + e @ y[lay.Q_I : lay.Q_I + 13]
    assert rate == pytest.approx(external, abs=1e-9 * np.abs(y[lay.Q_O : lay.Q_O + 13]).sum())


def test_a_free_roller_flies_straight():
    """Without contact a roller in the turning frame obeys r'' = omega_c^2 r: cosh."""
    model = assemble.model(case(clearance="200 um", load="1 N"))
    model = model._replace(support=model.support._replace(F=0.0, k_b=0.0))
    b = model.bearing
    y = assemble.empty_buffer(model)
    start_at_rest(model, 0.0, y)
    drive(model, RungeKutta4(1e-6), 200, y)
    r0, t = (b.R_o + b.R_i) / 2, 200e-6
    assert y[lay.RADIAL : lay.RADIAL + 13] == pytest.approx(r0 * (np.cosh(b.omega_c * t) - 1), rel=1e-6)


def test_the_approach_rate_is_the_derivative_of_the_approach():
    """v_o of the model equals the change of delta_o in time, the defect's slope under the roller included."""
    model = assemble.model(case(defect=SLOT | {"width": "2 mm"}, start_angle=0.015))
    y = random_state(model, 1)
    approaches, h = [], 1e-9
    for t in (-h, h):
        state = y.copy()
        state[lay.POSITION : lay.POSITION + 2] += t * y[lay.VELOCITY : lay.VELOCITY + 2]
        state[lay.RADIAL : lay.RADIAL + 13] += t * y[lay.RADIAL_V : lay.RADIAL_V + 13]
        theta = model.bearing.theta_0 + model.bearing.omega_c * t
        u_r = state[lay.POSITION + lay.X] * np.cos(theta) + state[lay.POSITION + lay.Y] * np.sin(theta)
        rim = 1e-3 - abs(model.bearing.R_o * theta)
        approaches.append(
            state[lay.RADIAL] - u_r - min(rim**2 / (2 * model.defects.head[0, REDUCED_RADIUS]), 0.05e-3)
        )
    start_at_rest(model, 0.0, y)
    rate, delta = (approaches[1] - approaches[0]) / (2 * h), (approaches[0] + approaches[1]) / 2
    assert y[lay.Q_O] == pytest.approx(normal_force(model.outer, delta, rate), rel=1e-5, abs=1e-3)


def ring_over_defect(defect):
    """Return a state with the first roller over a defect, and that roller's Delta, its rate, h and h'."""
    model = assemble.model(case(model="ring", defect=defect, start_angle=0.003))
    y = at_rest(model)
    y[lay.VELOCITY : lay.VELOCITY + 2] = 0.02, -0.01
    start_at_rest(model, 0.0, y)
    b, u, w, theta = model.bearing, y[lay.POSITION : lay.POSITION + 2], y[lay.VELOCITY : lay.VELOCITY + 2], 0.003
    e_r, e_theta = np.array([np.cos(theta), np.sin(theta)]), np.array([-np.sin(theta), np.cos(theta)])
    Delta, rate = -u @ e_r, -w @ e_r - b.omega_c * (u @ e_theta)
    groups = model.defects.groups[0, : int(model.defects.head[0, GROUP_COUNT])]
    drops = np.array(
        [roller_drop(group, b.R_o * theta, model.defects.head[0, REDUCED_RADIUS]) for group in groups]
    )
    return model, y, Delta, rate, groups[:, GROUP_WEIGHT], drops[:, 0], drops[:, 1] * b.R_o * b.omega_c


def test_a_ring_shares_approach_and_rate_between_both_contacts_over_a_slot():
    model, y, Delta, rate, _, h, drop_rate = ring_over_defect(SLOT | {"width": "0.3 mm"})
    expected = normal_force(model.outer, (Delta - h[0]) / 2, (rate - drop_rate[0]) / 2)
    assert y[lay.Q_O] == pytest.approx(expected, rel=1e-9)
    assert expected > 1.0


FILM = {"law": "film", "oil": "VG 68", "temperature": "55 C"}


@pytest.mark.parametrize("race", ["", "outer", "inner"])
@pytest.mark.parametrize(("bearing", "damping"), [("nf308", FILM), ("6205", {"law": "kraemer"})])
def test_unlike_contacts_in_series_have_equal_forces(bearing, damping, race):
    """A film damps the outer contact more than the inner one; a ball's two contacts differ in stiffness."""
    defects = [SLOT | {"race": race, "depth": "0.5 um"}] if race else []
    fields = {"bearing": bearing, "contact": {"damping": damping}, "load": "2 kN", "start_angle": "1.5e-3 rad"}
    model = assemble.model(case(model="ring", defects=defects, **fields))
    y = at_rest(model)
    y[lay.VELOCITY : lay.VELOCITY + 2] = -0.02, 0.01
    start_at_rest(model, 0.0, y)
    b, u, w, theta = model.bearing, y[lay.POSITION : lay.POSITION + 2], y[lay.VELOCITY : lay.VELOCITY + 2], 1.5e-3
    e_r, e_theta = np.array([np.cos(theta), np.sin(theta)]), np.array([-np.sin(theta), np.cos(theta)])
    Delta, rate = -u @ e_r - 2.0 * b.gap, -w @ e_r - b.omega_c * (u @ e_theta)
    if race:
        speed, radius = (b.omega_c, b.R_o) if race == "outer" else (b.omega_c - b.omega_i, b.R_i)
        h, slope = roller_drop(model.defects.groups[0, 0], radius * theta, model.defects.head[0, REDUCED_RADIUS])
        Delta, rate = Delta - h, rate - slope * radius * speed
    static = [lambda d, law=law: normal_force(law, d, 0.0) for law in (model.outer, model.inner)]
    d_i = brentq(lambda d: static[0](Delta - d) - static[1](d), 0.0, Delta, xtol=1e-22)
    forces = lambda v: (normal_force(model.outer, Delta - d_i, rate - v), normal_force(model.inner, d_i, v))  # noqa: E731
    v_i = brentq(lambda v: np.subtract(*forces(v)), -1.0, 1.0, xtol=1e-18)
    assert y[lay.Q_O] == pytest.approx(forces(v_i)[0], rel=1e-8)
    assert y[lay.Q_I] == y[lay.Q_O]


def test_a_ring_balances_a_roller_over_a_bowl():
    """Elastic: the sum of the outer groups equals the inner contact; damping: half of each group's rate."""
    bowl = SLOT | {"shape": "circular", "length": "8 mm", "depth": "0.2 um"}
    model, y, Delta, rate, w, h, drop_rate = ring_over_defect(bowl)
    k = model.outer.stiffness.k
    outer = lambda d_i: w * k * np.maximum(Delta - d_i - h, 0.0) ** (10 / 9)  # noqa: E731
    d_i = brentq(lambda d: outer(d).sum() - k * d ** (10 / 9), 0.0, Delta, xtol=1e-20)
    expected = (outer(d_i) * (1 + model.outer.chi * (rate - drop_rate) / 2)).sum()
    assert y[lay.Q_O] == pytest.approx(expected, rel=1e-8)
    assert (outer(d_i) > 0).sum() >= 2


@pytest.mark.parametrize(("model", "width"), [("rollers", "0.8 mm"), ("rollers", "3 mm"), ("ring", "2 mm")])
def test_a_bowl_has_enough_groups(model, width):
    """Each group hits the far wall at once: 6 on the half length gave 58 % too much RMS at 3 mm."""
    bowl = SLOT | {"shape": "circular", "width": width}
    fields = {"model": model, "defect": bowl, "duration": "40 ms", "settle": "30 ms"}
    automatic, fine = (
        simulate(case(contact=contact, **fields)).features for contact in ({}, {"length_nodes": "64"})
    )
    for name in ("velocity@BPFO", "velocity.rms", "outer_force.max"):
        assert automatic[name] == pytest.approx(fine[name], rel=0.01)


def test_two_defects_act_on_two_rollers():
    """A second defect one pitch further is crossed at the same time: at least 1.2 times the amplitude."""
    single = simulate(case(model="static", defect=SLOT | {"width": "0.3 mm"}, duration="20 ms", settle="0 ms"))
    pitch = 2 * pi / 13
    double = simulate(
        case(
            model="static",
            duration="20 ms",
            settle="0 ms",
            defects=[SLOT | {"width": "0.3 mm"}, SLOT | {"width": "0.3 mm", "angle": pitch}],
        )
    )
    assert double.features["velocity@BPFO"] > 1.2 * single.features["velocity@BPFO"]
