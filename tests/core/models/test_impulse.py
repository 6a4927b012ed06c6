"""``impulse``: the motion against exact solutions, the trains against geometry, both against ``static``."""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from bearingsim.core import layout as lay
from bearingsim.core.defects.impulse_train import impulse_strengths, make_train
from bearingsim.core.jit import jit
from bearingsim.core.methods.impulses import Impulses
from bearingsim.core.methods.interface import step
from bearingsim.core.models.impulse import Impulse, free_motion
from tests.scenes.impulses import BEARING, PASS, ZONE, defect, line

K, M = 1e7, 0.3
CRITICAL = 2 * sqrt(K * M)
TIMES = np.array([0.0101e-3, 0.33e-3, 0.3305e-3, 1.2e-3])
STRENGTHS = np.array([-1e-3, 2e-3, 0.5e-3, -3e-3])


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
    y = lay.make_buffer(BEARING.Z, 0.0) if y is None else y
    out = np.empty((6, steps))
    run(Impulses(h), model, start, y, out)
    return out


def response(t, J, C, stiffness=K):
    """Return the displacement after one impulse, J/(m omega) e^(-beta t) sin(omega t), sinh if overdamped."""
    beta, D = C / (2 * M), stiffness / M - (C / (2 * M)) ** 2
    i_omega, since = 1j * np.sqrt(complex(D)), np.maximum(t, 0.0)
    ringing = (np.exp((i_omega - beta) * since) - np.exp((-i_omega - beta) * since)) / (2 * i_omega)
    return np.where(t > 0, J / M * ringing.real, 0.0)


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


def test_velocity_and_acceleration_are_those_of_the_free_motion_between_impulses():
    """Both equal differences of the positions of a shorter step, away from impulses."""
    out, fine = drive(ring(), 5e-6, 300), drive(ring(), 0.5e-6, 3010)[0]
    n = np.arange(10, 3010, 10) - 1
    is_free = np.array([np.min(np.abs(t - TIMES)) > 1e-6 for t in 0.5e-6 * (n + 1)])
    velocity = (fine[n + 1] - fine[n - 1]) / 1e-6
    acceleration = (fine[n + 1] - 2 * fine[n] + fine[n - 1]) / 0.5e-6**2
    for row, expected in ((2, velocity), (4, acceleration)):
        np.testing.assert_allclose(
            out[row][is_free], expected[is_free], atol=1e-5 * np.abs(expected[is_free]).max()
        )


def test_a_run_in_chunks_is_the_run_in_one():
    expected = drive(ring(J_y=-STRENGTHS), 5e-6, 300)
    y = lay.make_buffer(BEARING.Z, 0.0)
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
    impulses = make_train(BEARING, ZONE, [defect(angle=angle)], 0.0, 45 * PASS)
    model = ring(impulses.times, impulses.J_x, impulses.J_y, C)
    x = drive(model, h, 40 * steps)[:2, 20 * steps :]  # samples of the velocity, which jumps, have a wrong mean
    J = impulse_strengths(BEARING, ZONE, defect(angle=angle), np.array([angle]))[0]
    for harmonic in (1, 2, 5):
        f = harmonic / PASS
        lines = 2 * pi * f * np.abs(line(x, f, h))
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
    impulses = make_train(BEARING, zone, [defect("inner")], -0.02, 2 * 10 / shaft + 10 * h)
    x = drive(ring(impulses.times, impulses.J_x, impulses.J_y, C), h, 2 * steps)[:2, steps:]
    phi = 2 * pi * np.arange(4096) / 4096
    J = impulse_strengths(BEARING, zone, defect("inner"), phi)
    strongest = 2 * rate * J.max() * abs(mobility(rate, K, C))
    for k in range(-3, 4):
        f = rate + k * shaft
        lines = 2 * pi * f * np.abs(line(x, f, h))
        for axis, (wave, stiffness) in enumerate(((np.cos(phi), K), (np.sin(phi), 2 * K))):
            coefficient = np.mean(-J * wave * np.exp(-1j * k * phi))
            expected = 2 * rate * abs(coefficient) * abs(mobility(f, stiffness, C))
            assert lines[axis] == pytest.approx(expected, abs=1e-3 * strongest)
