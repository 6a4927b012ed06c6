"""``impulse``: the motion against exact solutions, the trains against geometry, both against ``static``."""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.defects.closed_forms import groups_of
from bearingsim.core.defects.excitations import Envelope
from bearingsim.core.defects.impulse_train import (
    LoadZone,
    approach,
    crossing_speed,
    defect_passages,
    impulse_strengths,
    load,
    random_train,
    train,
)
from bearingsim.core.defects.pairs import (
    INNER,
    ON_INNER,
    ON_OUTER,
    OUTER,
    RollerDefectPair,
    inner_reduced_radius,
    nearest_roller,
    outer_reduced_radius,
    pack_defects,
)
from bearingsim.core.jit import jit
from bearingsim.core.methods.impulses import Impulses
from bearingsim.core.methods.interface import step
from bearingsim.core.models.equilibrium import ring_stiffness, solve_equilibrium, solve_initial_equilibrium
from bearingsim.core.models.impulse import Impulse, free_motion
from tests.scenes.defect_maps import SHAPES
from tests.scenes.nf308 import case

BEARING = assemble.geometry.bearing(case())
L_W, DEEP = 0.012, 5e-5
PASS = 2 * pi / (BEARING.Z * BEARING.omega_c)
K, M = 1e7, 0.3
CRITICAL = 2 * sqrt(K * M)
ZONE = LoadZone(q_0=47.0, delta_0=3.37e-7, epsilon=0.5, n=10 / 9)
TIMES = np.array([0.0101e-3, 0.33e-3, 0.3305e-3, 1.2e-3])
STRENGTHS = np.array([-1e-3, 2e-3, 0.5e-3, -3e-3])


def defect(race="outer", angle=0.0, width=0.8e-3, depth=DEEP, length=L_W, shape="rectangular"):
    """Return the pair of a defect and a contact; for a roller, of its contact with the outer race."""
    on, side, radius = {
        "outer": (ON_OUTER, OUTER, BEARING.R_o),
        "inner": (ON_INNER, INNER, BEARING.R_i),
        "roller": (0, OUTER, BEARING.R_w),
        "roller, inside": (4, INNER, BEARING.R_w),
    }[race]
    reduced = (outer_reduced_radius(BEARING.R_w, BEARING.R_o), inner_reduced_radius(BEARING.R_w, BEARING.R_i))[
        side
    ]
    return RollerDefectPair(
        side, on, angle, radius, reduced, groups_of(SHAPES[shape](length, width, depth), L_W, reduced, 6)
    )


def ring(times=TIMES, J_x=STRENGTHS, J_y=None, C=0.1 * CRITICAL, stiffness=K):
    J_y = np.zeros(len(times)) if J_y is None else J_y
    return Impulse(
        BEARING, M, stiffness, 2.0 * stiffness, C, C, np.asarray(times, float), np.asarray(J_x, float), J_y
    )


@jit
def run(method, model, start, y, out):
    """Record positions, velocities and accelerations after each step: (6, n)."""
    for n in range(out.shape[1]):
        step(method, model, (start + n) * method.h, y)
        for axis in range(2):
            out[axis, n] = y[lay.POSITION + axis]
            out[2 + axis, n] = y[lay.VELOCITY + axis]
            out[4 + axis, n] = y[lay.ACCELERATION + axis]


def drive(model, h, steps, start=0, y=None):
    y = lay.buffer(BEARING.Z, 0.0) if y is None else y
    out = np.empty((6, steps))
    run(Impulses(h), model, start, y, out)
    return out


def response(t, J, C, stiffness=K):
    """Return the displacement after one impulse, J/(m omega) e^(-beta t) sin(omega t), sinh if overdamped."""
    beta, D = C / (2 * M), stiffness / M - (C / (2 * M)) ** 2
    i_omega, since = 1j * np.sqrt(complex(D)), np.maximum(t, 0.0)
    ringing = (np.exp((i_omega - beta) * since) - np.exp((-i_omega - beta) * since)) / (2 * i_omega)
    return np.where(t > 0, J / M * ringing.real, 0.0)


def line(x, frequency, h):
    """Return the complex amplitude of x at ``frequency``; its first sample is at h."""
    t = h * np.arange(1, x.shape[-1] + 1)
    return 2.0 * np.mean(x * np.exp(-2j * pi * frequency * t), axis=-1)


def mobility(frequency, stiffness, C):
    """Return velocity over force at ``frequency`` (Hz)."""
    omega = 2 * pi * frequency
    return 1j * omega / (stiffness - M * omega**2 + 1j * omega * C)


@given(
    ratio=st.one_of(st.floats(0.0, 30.0), st.floats(0.999999, 1.000001), st.just(1.0)),
    periods=st.floats(1e-4, 3.0),
    x=st.floats(-1e-6, 1e-6),
    v=st.floats(1e-6, 1e-2),
)
def test_free_motion_is_the_matrix_exponential(ratio, periods, x, v):
    """For any damping, including critical; positions scaled to speeds by omega_0."""
    omega_0, t = sqrt(K / M), periods * 2 * pi * sqrt(M / K)
    result = free_motion(M, K, ratio * CRITICAL, t, x, v)
    propagator = expm(t * omega_0 * np.array([[0.0, 1.0], [-1.0, -2.0 * ratio]]))
    expected = propagator @ np.array([x * omega_0, v])
    assert (result[0] * omega_0, result[1]) == pytest.approx(
        tuple(expected), abs=1e-10 * (abs(x) * omega_0 + abs(v))
    )


@pytest.mark.parametrize("ratio", [0.0, 0.05, 0.999999, 1.0, 1.000001, 3.0, 50.0])
def test_the_response_to_one_impulse_is_the_closed_form(ratio):
    h, t_0 = 7e-6, 0.1e-3 + 1.234e-6
    out = drive(ring([t_0], [2e-3], C=ratio * CRITICAL), h, 500)
    t = h * np.arange(1, 501) - t_0
    if abs(ratio - 1.0) < 1e-3:  # the formula itself loses digits there
        solution = solve_ivp(
            lambda _, y: [y[1], -K / M * y[0] - ratio * CRITICAL / M * y[1]], (0.0, t[-1]), [0.0, 2e-3 / M],
            "DOP853", t[t > 0], rtol=1e-12, atol=1e-18,
        )  # fmt: skip
        expected = np.concatenate([np.zeros(np.count_nonzero(t <= 0)), solution.y[0]])
    else:
        expected = response(t, 2e-3, ratio * CRITICAL)
    np.testing.assert_allclose(out[0], expected, atol=1e-10 * np.abs(expected).max())


@pytest.mark.parametrize("h", [1e-6, 5e-6, 100e-6])
def test_positions_do_not_depend_on_the_step(h):
    steps = round(2e-3 / h)
    out = drive(ring(J_y=2 * STRENGTHS), h, steps)
    t = h * np.arange(1, steps + 1)
    for row, J, stiffness in ((0, STRENGTHS, K), (1, 2 * STRENGTHS, 2 * K)):
        expected = sum(
            response(t - t_k, J_k, 0.1 * CRITICAL, stiffness) for t_k, J_k in zip(TIMES, J, strict=True)
        )
        np.testing.assert_allclose(out[row], expected, atol=1e-11 * np.abs(expected).max())


def test_trains_superpose():
    total = drive(ring(), 5e-6, 400)
    first, second = (drive(ring(TIMES[rows], STRENGTHS[rows]), 5e-6, 400) for rows in (slice(0, 2), slice(2, 4)))
    np.testing.assert_allclose(total, first + second, atol=1e-12 * np.abs(total).max(axis=1).max())


@given(positions=st.lists(st.floats(0.1, 39.9), min_size=1, max_size=5), h=st.floats(1e-7, 1e-3))
def test_each_impulse_counts_once(positions, h):
    """An undamped mass on a very soft spring keeps its momentum; some impulses are at the end of a step."""
    times = np.sort(
        np.concatenate([h * np.array(positions), h * np.arange(1.0, 30.0, 7.0), 0.1 * h * np.array([30, 70])])
    )
    out = drive(ring(times, np.ones(len(times)), C=0.0, stiffness=1e-9), h, 60)
    assert M * out[2, -1] == pytest.approx(len(times), rel=1e-9)


def test_velocity_and_acceleration_are_differences_of_positions():
    h, out = 5e-6, drive(ring(), 5e-6, 300)
    x = np.concatenate([[0.0], out[0]])
    np.testing.assert_allclose(out[2, :-1], (x[2:] - x[:-2]) / (2 * h), atol=1e-12 * np.abs(out[2]).max())
    np.testing.assert_allclose(
        out[4, :-1], (x[2:] - 2 * x[1:-1] + x[:-2]) / h**2, atol=1e-9 * np.abs(out[4]).max()
    )


def test_a_run_in_chunks_is_the_run_in_one():
    expected = drive(ring(J_y=-STRENGTHS), 5e-6, 300)
    y = lay.buffer(BEARING.Z, 0.0)
    parts = [
        drive(ring(J_y=-STRENGTHS), 5e-6, n, start, y) for start, n in ((0, 1), (1, 66), (67, 33), (100, 200))
    ]
    np.testing.assert_array_equal(np.concatenate(parts, axis=1), expected)


def test_no_impulses_no_motion():
    assert not drive(ring([], []), 5e-6, 20).any()


@pytest.mark.parametrize("angle", [0.0, 0.5, -1.0])
def test_line_of_a_defect_on_the_outer_race(angle):
    """2 J BPFO |mobility| along the load and across it: an impulse train has all its lines equal."""
    steps = 1258
    h, C = PASS / steps, 0.3 * CRITICAL
    impulses = train(BEARING, ZONE, [defect(angle=angle)], 0.0, 45 * PASS)
    model = ring(impulses.times, impulses.J_x, impulses.J_y, C)
    v = drive(model, h, 40 * steps)[2:4, 20 * steps :]
    J = impulse_strengths(BEARING, ZONE, defect(angle=angle), np.array([angle]))[0]
    for harmonic in (1, 2, 5):
        f = harmonic / PASS
        lines = np.abs(line(v, f, h))
        expected = [
            2 * J / PASS * abs(cos(angle) * mobility(f, K, C)),
            2 * J / PASS * abs(sin(angle) * mobility(f, 2 * K, C)),
        ]
        assert lines == pytest.approx(expected, rel=1e-3, abs=1e-6 * max(expected))


@pytest.mark.parametrize("epsilon", [0.5, 2.0])
def test_sidebands_of_a_defect_on_the_inner_race(epsilon):
    """BPFI + k f_i as the Fourier coefficients of -J(phi) cos phi and -J(phi) sin phi say (McFadden and Smith)."""
    zone = ZONE._replace(epsilon=epsilon)
    shaft = BEARING.omega_i / (2 * pi)
    rate = BEARING.Z * (shaft - BEARING.omega_c / (2 * pi))
    assert 10 * rate / shaft == pytest.approx(77.0, abs=1e-9)  # ten turns of the shaft close the pattern
    steps, C = 66000, 0.3 * CRITICAL
    h = 10 / shaft / steps
    impulses = train(BEARING, zone, [defect("inner")], -0.02, 2 * 10 / shaft + 10 * h)
    v = drive(ring(impulses.times, impulses.J_x, impulses.J_y, C), h, 2 * steps)[2:4, steps:]
    phi = 2 * pi * np.arange(4096) / 4096
    J = impulse_strengths(BEARING, zone, defect("inner"), phi)
    strongest = 2 * rate * J.max() * abs(mobility(rate, K, C))
    for k in range(-3, 4):
        f = rate + k * shaft
        lines = np.abs(line(v, f, h))
        for axis, (wave, stiffness) in enumerate(((np.cos(phi), K), (np.sin(phi), 2 * K))):
            coefficient = np.mean(-J * wave * np.exp(-1j * k * phi))
            expected = 2 * rate * abs(coefficient) * abs(mobility(f, stiffness, C))
            assert lines[axis] == pytest.approx(expected, abs=1e-3 * strongest)


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
    parts = [train(BEARING, ZONE, [pair], 0.0, 0.1) for pair in (inner, outer)]
    total = train(BEARING, ZONE, [inner, outer], 0.0, 0.1)
    assert np.all(np.diff(total.times) >= 0.0)
    np.testing.assert_array_equal(total.times, np.sort(np.concatenate([part.times for part in parts])))
    assert total.J_x.sum() == pytest.approx(sum(part.J_x.sum() for part in parts), rel=1e-12)
    assert len(train(BEARING, ZONE, [], 0.0, 1.0).times) == 0


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
        impulses = train(BEARING, ZONE, [defect(angle=angle)], 0.0, 0.02)
        J = impulse_strengths(BEARING, ZONE, defect(angle=angle), np.array([angle]))[0]
        assert impulses.J_x == pytest.approx(np.full(len(impulses.times), -J * cos(angle)), rel=1e-12)
        assert impulses.J_y == pytest.approx(np.full(len(impulses.times), -J * sin(angle)), rel=1e-12)
    impulses = train(BEARING, ZONE, [defect(angle=pi)], 0.0, 0.02)
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
        return random_train(BEARING, ZONE, [defect(), defect("inner", 1.0)], 0.0, end, np.random.default_rng(seed))

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
    impulses = random_train(BEARING, ZONE, [pair], 0.0, end, np.random.default_rng(1))
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
    regular = train(BEARING, ZONE, [pair], 0.0, end)
    random = random_train(BEARING, ZONE, [pair], 0.0, end, np.random.default_rng(2))
    lines = [np.sum(part.J_x * np.exp(-2j * pi * f * part.times)) for part in (regular, random)]
    assert len(regular.times) == count
    assert lines[1] == pytest.approx(lines[0], rel=5 / 4 / sqrt(count))
