"""Trains of impulses against geometry and ``static``: when a roller crosses a defect, and how strongly."""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.defects.excitations import Envelope
from bearingsim.core.defects.impulse_train import (
    LoadZone,
    approach,
    crossing_speed,
    defect_passages,
    impulse_strengths,
    load,
    make_random_train,
    make_train,
)
from bearingsim.core.defects.pairs import nearest_roller, pack_defects
from bearingsim.core.models.equilibrium import ring_stiffness, solve_equilibrium, solve_initial_equilibrium
from tests.scenes.impulses import BEARING, DEEP, L_W, PASS, ZONE, defect, line
from tests.scenes.nf308 import case


@given(
    race=st.sampled_from(["outer", "inner", "roller", "roller, inside"]),
    angle=st.floats(-3.0, 3.0),
    start=st.floats(-0.1, 0.1),
    length=st.floats(0.0, 0.2),
)
def test_impulses_occur_when_a_roller_is_over_the_defect(race, angle, start, length):
    """Against the geometry that the other models use."""
    pair = defect(race, angle)
    times, phi = defect_passages(BEARING, pair, start, start + length)
    packed = pack_defects([pair], Envelope())
    for t, angle_k in zip(times, phi, strict=True):
        assert start - 1e-12 < t <= start + length + 1e-12
        theta_c = BEARING.theta_0 + BEARING.omega_c * t
        j, s = nearest_roller(packed, 0, theta_c, BEARING.omega_i * t, BEARING.omega_b * t, BEARING.Z)
        assert s == pytest.approx(0.0, abs=1e-12)
        assert cos(theta_c + 2 * pi * j / BEARING.Z - angle_k) == pytest.approx(1.0, abs=1e-12)
    rate = {"outer": BEARING.Z * BEARING.omega_c, "inner": BEARING.Z * (BEARING.omega_i - BEARING.omega_c)}.get(
        race, BEARING.omega_b
    )
    assert abs(len(times) - rate / (2 * pi) * length) <= 1.0


def test_several_defects_superpose():
    inner, outer = defect("inner"), defect("outer", 0.3)
    parts = [make_train(BEARING, ZONE, [pair], 0.0, 0.1) for pair in (inner, outer)]
    total = make_train(BEARING, ZONE, [inner, outer], 0.0, 0.1)
    assert np.all(np.diff(total.times) >= 0.0)
    np.testing.assert_array_equal(total.times, np.sort(np.concatenate([part.times for part in parts])))
    assert total.J_x.sum() == pytest.approx(sum(part.J_x.sum() for part in parts), rel=1e-12)
    assert len(make_train(BEARING, ZONE, [], 0.0, 1.0).times) == 0


def test_load_zone():
    """Half the circumference at epsilon 1/2, a fifth of the diameter projected at 0.2; turned by the axis."""
    assert load(ZONE, np.array([0.0, 1.0, pi / 2, 2.0])) == pytest.approx(
        [47.0, 47.0 * cos(1.0) ** (10 / 9), 0.0, 0.0]
    )
    narrow = ZONE._replace(epsilon=0.2, axis=0.4)
    edge = np.arccos(0.6)
    assert approach(narrow, 0.4 + np.array([-edge - 0.01, -edge + 0.01])) == pytest.approx(
        [0.0, 6.7e-9], abs=1e-10
    )
    assert load(narrow, np.array([0.4]))[0] == 47.0


def test_a_wide_deep_defect_removes_the_load_of_its_roller():
    """J = q w/v: 0.8 mm, 47 N, 2.96 m/s give 12.7 mN s, less 11 % for the ways in and out; at 4 mm 2 %."""
    v = BEARING.R_o * BEARING.omega_c
    assert 47.0 * 0.8e-3 / v == pytest.approx(12.7e-3, abs=0.05e-3)
    for width, ratio in ((0.8e-3, 0.888), (4e-3, 0.978)):
        J = impulse_strengths(BEARING, ZONE, defect(width=width), np.zeros(1))[0]
        assert J / (47.0 * width / v) == pytest.approx(ratio, rel=2e-3)
        half = impulse_strengths(BEARING, ZONE, defect(width=width, length=L_W / 2), np.zeros(1))[0]
        assert half == pytest.approx(J / 2, rel=1e-9)


def test_every_contact_runs_over_its_defect_at_the_same_speed():
    """Rolling without slip (and no clearance): 2.959 m/s at 1800 rpm."""
    for race in ("outer", "inner", "roller", "roller, inside"):
        assert crossing_speed(BEARING, defect(race)) == pytest.approx(2.9587, abs=1e-4)


@pytest.mark.parametrize("stiffness", [np.inf, 5e8])
@pytest.mark.parametrize("race", ["outer", "inner"])
@pytest.mark.parametrize("phi", [0.0, 0.7])
@pytest.mark.parametrize(
    "fields",
    [{}, {"depth": 2e-7}, {"width": 0.2e-3}, {"length": 5e-3}, {"shape": "triangular", "depth": 1e-6}],
    ids=str,
)
def test_the_lost_load_equals_a_pointwise_solution(fields, phi, race, stiffness):
    """The force P q that balances the ring with the roller's actual force, by bisection and quadrature."""
    zone = ZONE._replace(K_x=stiffness, K_y=stiffness)
    pair = defect(race, **fields)
    delta, q = zone.delta_0 * cos(phi), zone.q_0 * cos(phi) ** (10 / 9)
    k = 10 / 9 * q / delta

    def force(s):
        def residual(P):  # displacement z of the ring under P q, on its spring K with the roller loaded
            z = P * q / stiffness
            load = sum(
                row[0] * q * max(1 - (drop(row, s, pair.R) - z) / delta, 0.0) ** (10 / 9) for row in pair.groups
            )
            return P * q - (q - load) - k * z

        return brentq(residual, -0.1, 10.0, xtol=1e-13)

    width = fields.get("width", 0.8e-3)
    total = 2 * quad(force, 0.0, width / 2, limit=200, epsabs=1e-9)[0]
    speed = pair.radius * (BEARING.omega_c if race == "outer" else BEARING.omega_i - BEARING.omega_c)
    J = impulse_strengths(BEARING, zone, pair, np.array([phi]))[0]
    assert pytest.approx(q * total / speed, rel=2e-3) == J


def drop(row, s, R):
    """Return the drop of a roller into a rectangular or V-shaped defect."""
    _, b, x_e, _, depth = row
    x = max(b - abs(s), 0.0)
    return min(depth, x**2 / (2 * R) if x < x_e else x_e * (x - x_e / 2) / R)


def test_the_impulse_acts_towards_the_unloaded_roller():
    """The load acts on the ring along -e_0; the impulse is that of the missing roller force."""
    for angle in (0.0, 0.6, -0.6):
        impulses = make_train(BEARING, ZONE, [defect(angle=angle)], 0.0, 0.02)
        J = impulse_strengths(BEARING, ZONE, defect(angle=angle), np.array([angle]))[0]
        assert impulses.J_x == pytest.approx(np.full(len(impulses.times), -J * cos(angle)), rel=1e-12)
        assert impulses.J_y == pytest.approx(np.full(len(impulses.times), -J * sin(angle)), rel=1e-12)
    impulses = make_train(BEARING, ZONE, [defect(angle=pi)], 0.0, 0.02)
    assert not impulses.J_x.any()
    assert len(impulses.times) > 0


def defect_lines(pair):
    """Return the change (2,) of the BPFO velocity amplitudes of ``static``, and the mean stiffness."""
    healthy = assemble.model(case(model="static"))
    lines, stiffness, count = [], np.zeros(3), 1000
    for model in (healthy, healthy._replace(defects=pack_defects([pair], Envelope()))):
        y, positions = assemble.empty_buffer(model), np.empty((2, count))
        for n in range(count):
            (solve_equilibrium if n else solve_initial_equilibrium)(model, (n + 1) / count * PASS, y)
            positions[:, n] = y[lay.POSITION + lay.X], y[lay.POSITION + lay.Y]
            if model is healthy:
                stiffness += np.array(ring_stiffness(model, y)) / count
        lines.append(2j * pi / PASS * line(positions, 1 / PASS, PASS / count))
    return lines[1] - lines[0], stiffness


@pytest.mark.parametrize(("width", "depth"), [(0.2e-3, DEEP), (0.8e-3, DEEP), (0.8e-3, 3e-7), (2e-3, DEEP)])
@pytest.mark.parametrize("angle", [0.0, 0.35, 0.7])
def test_the_line_equals_static(width, depth, angle):
    """Zero clearance, 150 N: 4.08 F/Z on the most loaded roller. Within 5 % along the load, 10 % of it across."""
    pair = defect(angle=angle, width=width, depth=depth)
    expected, (K_x, K_xy, K_y) = defect_lines(pair)
    assert abs(K_xy) < 1e-3 * K_x
    q_0 = 4.08 * 150.0 / BEARING.Z
    delta_0 = 2 * (q_0 / assemble.model(case(model="static")).outer.stiffness.k) ** 0.9
    zone = LoadZone(q_0, delta_0, 0.5, 10 / 9, 0.0, K_x, K_y)
    J = impulse_strengths(BEARING, zone, pair, np.array([angle]))[0]
    omega = 2 * pi / PASS
    assert 2 * J / PASS * cos(angle) * omega / K_x == pytest.approx(abs(expected[0]), rel=0.05)
    assert 2 * J / PASS * sin(angle) * omega / K_y == pytest.approx(abs(expected[1]), abs=0.1 * abs(expected[0]))


def test_random_impulses_depend_only_on_the_seed():
    def impulses(seed, end=0.5):
        return make_random_train(
            BEARING, ZONE, [defect(), defect("inner", 1.0)], 0.0, end, np.random.default_rng(seed)
        )

    for row, other in zip(impulses(7), impulses(7), strict=True):
        np.testing.assert_array_equal(row, other)
    assert not np.array_equal(impulses(7).times, impulses(8).times)
    assert np.all(np.diff(impulses(7).times) >= 0.0)
    long, short = impulses(7, 1.0), impulses(7, 0.5)
    n = int(np.sum(short.times < 0.499))
    np.testing.assert_array_equal(long.J_x[:n], short.J_x[:n])


def test_random_impulses_divide_each_crossing():
    """16 asperities of 0.05 mm in 0.8 mm: mean J, standard deviation J/4, all within the crossing."""
    end = 4000.5 * PASS
    pair = defect()
    impulses = make_random_train(BEARING, ZONE, [pair], 0.0, end, np.random.default_rng(1))
    J = impulse_strengths(BEARING, ZONE, pair, np.zeros(1))[0]
    times, _ = defect_passages(BEARING, pair, 0.0, end)
    nearest = np.rint((impulses.times - times[0]) / PASS).astype(int)
    delay = impulses.times - times[nearest]
    half = 0.4e-3 / (BEARING.R_o * BEARING.omega_c)
    assert np.abs(delay).max() <= half
    assert np.std(delay) == pytest.approx(half / sqrt(3), rel=0.02)
    assert np.all(np.bincount(nearest) == 16)
    totals = np.bincount(nearest, weights=-impulses.J_x)
    assert totals.mean() == pytest.approx(J, abs=4 * J / 4 / sqrt(len(times)))
    assert totals.std() == pytest.approx(J / 4, rel=0.06)  # 5 of its standard errors


def test_random_impulses_preserve_the_mean_amplitude():
    """E[line] is that of the regular train; the scatter of one crossing is averaged over the passes."""
    end, count = 1000 * PASS, 1000
    pair, f = defect(), 1 / PASS
    regular = make_train(BEARING, ZONE, [pair], 0.0, end)
    random = make_random_train(BEARING, ZONE, [pair], 0.0, end, np.random.default_rng(2))
    lines = [np.sum(part.J_x * np.exp(-2j * pi * f * part.times)) for part in (regular, random)]
    assert len(regular.times) == count
    assert lines[1] == pytest.approx(lines[0], rel=5 / 4 / sqrt(count))
