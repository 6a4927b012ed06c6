"""Recording of methods with steps of their own, and of positions without velocity."""

import numpy as np
import pytest

from bearingsim.config import Case
from bearingsim.core import outcomes
from bearingsim.core.advance import NoSamples
from bearingsim.core.sampling import DECIMATION_HALF_LENGTH, sampling_kernel
from bearingsim.simulation import channels, choice, integration, limits
from bearingsim.simulation.channels import FEATURE_CELLS
from bearingsim.simulation.differentiation import (
    MOTION_ROWS,
    STENCIL_HALF_LENGTH,
    difference_weights,
    differentiate,
)
from bearingsim.simulation.features import compute_statistics
from bearingsim.simulation.integration import integrate
from bearingsim.simulation.recording import _sample_pass
from bearingsim.simulation.run_setup import set_up
from bearingsim.simulation.simulate import simulate
from bearingsim.simulation.time_grid import sample_count
from tests.scenes.short_cases import SLOT, case

RING = MOTION_ROWS[0]
POSITION, VELOCITY, ACCELERATION = RING
H, TAIL, STEPS = 1e-3, 16, 50


def record_passes(position, passes=3):
    """Return times, velocity and acceleration of ``position(t)``, differentiated pass by pass as in a run."""
    window, result = np.zeros((6, TAIL + STEPS)), []
    window[POSITION] = position(H * np.arange(-TAIL - STEPS, 0))
    for p in range(passes):
        window[:, :TAIL] = window[:, STEPS:].copy()
        t = H * np.arange(p * STEPS - TAIL, (p + 1) * STEPS)
        window[POSITION, TAIL:] = position(t[TAIL:])
        differentiate(window, RING, TAIL, H)
        full = slice(TAIL - STENCIL_HALF_LENGTH, TAIL + STEPS - STENCIL_HALF_LENGTH)
        result.append((t[full], window[VELOCITY, full].copy(), window[ACCELERATION, full].copy()))
    return (np.concatenate(parts, axis=-1) for parts in zip(*result, strict=True))


@pytest.mark.parametrize("omega", [400.0, 800.0])
def test_differences_are_of_eighth_order_across_passes(omega):
    """At the highest frequency of the record, 0.15 of the rate, omega H = 0.94."""
    t, velocity, acceleration = record_passes(lambda t: np.array([np.sin(omega * t), np.cos(omega * t)]))
    is_started = t > 0.0
    bound = (omega * H) ** 8
    assert 0.8 * bound < 630 * np.abs(velocity[0] / omega - np.cos(omega * t))[is_started].max() < 1.1 * bound
    assert (
        0.8 * bound < 3150 * np.abs(acceleration[1] / omega**2 + np.cos(omega * t))[is_started].max() < 1.1 * bound
    )


def test_motion_at_the_sensor_is_differentiated_like_that_of_the_ring():
    """A flexible ring's sensor has rows of its own, after those of the features."""
    window = np.zeros((len(FEATURE_CELLS) + 3, TAIL + STEPS))
    for motion in MOTION_ROWS:
        window[motion[0]] = np.sin(400.0 * H * np.arange(TAIL + STEPS))
        differentiate(window, motion, TAIL, H)
    ring, sensor = (np.array([window[rows][0] for rows in motion]) for motion in MOTION_ROWS)
    np.testing.assert_array_equal(sensor, ring)
    assert np.all(np.ptp(sensor, axis=1) > 0.0)


@pytest.mark.parametrize(("ring", "sensor_rows"), [({}, set()), ({"ring": {"harmonics": 5}}, {1, 2})])
def test_only_velocities_and_accelerations_are_differentiated(ring, sensor_rows, monkeypatch):
    """In a run with a rigid ring the rows after those of the features are other channels.

    All rows sample the square of the step number, which no difference of it equals.
    """

    def sample_squares(method, model, monitor, start, y, cells, columns, samples):
        columns[:] = np.arange(start, start + columns.shape[1]) ** 2.0
        return columns.shape[1], outcomes.SUCCESS, 0

    monkeypatch.setattr(integration, "advance_and_sample", sample_squares)
    monkeypatch.setattr(integration, "_COMPILED", set())
    forces = [f"roller.{number}.outer_force" for number in (1, 2, 3)]
    setup = set_up(case(model="rollers", method="dop853", rig=ring, record=forces))
    cells, y = channels.recorded_cells(setup.case), integration._make_initial_buffer(setup, 0.0)
    window = next(integration._ball_passes(setup, NoSamples(), y, cells, integration.Pace(1.0)))
    squares = np.arange(100) ** 2.0
    tail = window.shape[1] - setup.grid.steps_per_pass
    changed = {row for row, values in enumerate(window) if not np.array_equal(values[tail : tail + 100], squares)}
    assert changed == {2, 3, 4, 5} | {len(FEATURE_CELLS) + row for row in sensor_rows}


@pytest.mark.parametrize("reach", [1, 2, 3, 4])
def test_weights_of_differences_are_exact_for_polynomials(reach):
    """Up to degree 2 reach for the slope and 2 reach + 1 for the second derivative."""
    slopes, curvatures = difference_weights(reach)
    k = np.arange(1, reach + 1)
    for degree in range(1, 2 * reach + 1):
        even, odd = k**degree + (-k) ** degree, k**degree - (-k) ** degree
        assert np.dot(slopes, odd) == pytest.approx(float(degree == 1), abs=1e-12)
        assert np.dot(curvatures, even) == pytest.approx(2.0 * (degree == 2), abs=1e-12)


@pytest.mark.parametrize("fraction", [0.1, 0.5, 0.9])
def test_displacement_is_conserved_if_the_velocity_jumps(fraction):
    """Samples of the jump would have an error of up to half a step."""
    jump = (70.0 + fraction) * H
    t, velocity, _ = record_passes(lambda t: np.tile(np.maximum(0.0, t - jump), (2, 1)))
    assert H * velocity[0].sum() == pytest.approx(t[-1] + 0.5 * H - jump, abs=1e-12)
    sampled = H * np.heaviside(t - jump, 0.5).sum()
    assert fraction == 0.5 or abs(sampled - (t[-1] + 0.5 * H - jump)) > 0.3 * H


@pytest.mark.parametrize("method", ["dop853", "rodas"])
def test_line_does_not_depend_on_the_recording_step(method):
    test_case = case(model="rollers", defect=SLOT, method=method, step_check=False)
    often = choice.automatic_step(test_case, limits.step_limits(test_case))
    fine, coarse = (simulate(test_case.model_copy(update={"step": k * often})).features for k in (0.25, 1))
    assert coarse["velocity@BPFO"] == pytest.approx(fine["velocity@BPFO"], rel=5e-4)
    assert coarse["velocity.rms"] == pytest.approx(fine["velocity.rms"], rel=2e-4)


WIDE = {"load": "240 N", "defect": SLOT | {"width": "1.3 mm"}, "duration": "20 ms", "settle": "10 ms"}


@pytest.mark.parametrize("method", ["dop853", "rodas"])
def test_raw_values_are_interpolated_by_the_method(method):
    """Linear interpolation between recorded instants gave accelerations with an error of 20 %."""
    test_case = case(model="rollers", method=method, antialias=False, tolerance=1e-5, **WIDE)
    result, fine = (
        simulate(test_case.model_copy(update=update)) for update in ({}, {"step_check": False, "tolerance": 1e-7})
    )
    for name, bound in (("velocity.rms", 1e-3), ("acceleration.rms", 3e-3), ("acceleration.peak", 3e-3)):
        assert result.features[name] == pytest.approx(fine.features[name], rel=bound)
    assert 0.0 < result.features["step_error.record"] < 3e-3
    smooth = simulate(test_case.model_copy(update={"step_check": False, "antialias": True})).features
    # the steps do not depend on the sampling instants
    assert smooth["velocity@BPFO"] == pytest.approx(result.features["velocity@BPFO"], rel=1e-12)


def test_raw_values_start_with_the_record():
    """At t = 0 the bearing is at rest; later values are those of the run."""
    times = {"settle": "0 ms", "duration": "20 ms", "sampling": "50 kHz"}
    test_case = case(model="rollers", method="rodas", antialias=False, record=["ring.velocity"], **times)
    result, later = simulate(test_case), simulate(test_case.model_copy(update={"settle": 4e-3, "duration": 10e-3}))
    assert result.velocity[0].tolist() == [0.0, 0.0]
    assert np.allclose(result.velocity[200:700], later.velocity, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("ring", [{}, {"ring": {"harmonics": 5}}])
@pytest.mark.parametrize("overrides", [{}, {"antialias": False}])
def test_sensor_series_agrees_with_features(ring, overrides):
    """At 30 deg: projection of the ring coordinates, plus bending if the ring is flexible."""
    rig = {"sensor": {"angle": "30 deg"}} | ring
    channels = ["sensor.velocity", "ring.velocity", "sensor.displacement"]
    result = simulate(case(model="rollers", rig=rig, record=channels, defects=[], **overrides))
    series, angle = result.series, np.pi / 6.0
    projected = np.cos(angle) * series["ring.velocity.x"] + np.sin(angle) * series["ring.velocity.y"]
    if ring:
        assert np.std(series["sensor.velocity"] - projected) > 0.1 * np.std(projected)
    else:
        assert series["sensor.velocity"] == pytest.approx(projected, abs=1e-15)
    assert np.std(series["sensor.velocity"]) == pytest.approx(result.features["velocity.rms"], rel=0.1)


@pytest.mark.parametrize("method", ["verlet", "dop853"])
def test_contact_forces_are_recorded_without_low_pass(method: str) -> None:
    """Never negative, and unchanged by `antialias`; other channels are low-passed."""
    fields = {"record": ["roller.1.outer_force", "ring.velocity"], "step_check": False}  # the same steps
    filtered, raw = (
        simulate(case(defect=SLOT, method=method, duration="60 ms", antialias=antialias, **fields))
        for antialias in (True, False)
    )
    force = filtered.series["roller.1.outer_force"]
    assert force.min() >= 0.0
    assert force.max() > 0.0
    assert force.tolist() == raw.series["roller.1.outer_force"].tolist()
    assert not np.array_equal(filtered.series["ring.velocity.x"], raw.series["ring.velocity.x"])


def rms_of_impulses(test_case: Case) -> float:
    """Return the RMS (m/s) of the motion along the load of a ring under equal impulses once per ball pass.

    Each line is 2 J BPFO |mobility|, times the gain of the record's filter.
    """
    setup = set_up(test_case)
    model, rate = setup.model, setup.grid.rate
    taps = sampling_kernel(setup.grid.fine_rate / test_case.sampling)
    f = rate * np.arange(1, round(0.7 * test_case.sampling / rate))
    omega = 2.0 * np.pi * f
    offsets = np.arange(len(taps)) - len(taps) // 2
    gain = np.array([taps @ np.cos(w / setup.grid.fine_rate * offsets) for w in omega])
    mobility = omega / np.abs(model.K_x - model.m * omega**2 + 1j * omega * model.C_x)
    lines = 2.0 * abs(model.J_x[0]) * rate * mobility * gain
    return float(np.sqrt(np.sum(lines**2) / 2.0))


def test_rms_of_an_impulse_train_at_a_high_sampling_rate_is_that_of_its_lines() -> None:
    high = {"sampling": "102.4 kHz", "duration": "50 ms", "settle": "50 ms"}
    test_case = case(model="impulse", defects=[SLOT], record=[], **high)
    assert simulate(test_case).features["velocity.rms"] == pytest.approx(rms_of_impulses(test_case), rel=1.5e-3)


def test_rms_of_static_motion_at_a_high_sampling_rate_is_that_of_short_steps() -> None:
    test_case = case(model="static", defects=[SLOT], sampling="102.4 kHz", record=[])
    setups = [set_up(test_case, fraction) for fraction in (1.0, 1.0 / 16.0)]
    rms, fine = (compute_statistics(s.case, s.grid, integrate(s))["velocity.rms"] for s in setups)
    assert rms == pytest.approx(fine, rel=1e-3)


def test_raw_values_of_a_model_without_method_are_accurate_at_ends_of_passes_too() -> None:
    """A sine instead of the motion: accelerations are those of the sine, to 3e-4 and the interpolation."""
    test_case = case(model="static", sampling="102.4 kHz", antialias=False, duration="20 ms")
    grid = set_up(test_case).grid
    omega, tail = 0.1 / grid.step, 2 * DECIMATION_HALF_LENGTH * grid.decimation
    steps, raw_values = grid.steps_per_pass, np.empty((6, sample_count(test_case)))
    for p in range(grid.passes):
        window = np.empty((6, tail + steps))
        window[POSITION] = np.sin(omega * grid.step * np.arange(p * steps - tail + 1, (p + 1) * steps + 1))
        differentiate(window, RING, tail, grid.step)
        _sample_pass(test_case, grid, p, window, raw_values)
    expected = -(omega**2) * np.sin(omega * (0.03 + np.arange(raw_values.shape[1]) / 102.4e3))
    assert np.abs(raw_values[ACCELERATION] - expected).max() < 2e-3 * omega**2
