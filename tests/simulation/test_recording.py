"""What is recorded of an adaptive method, whose own steps lie between the recorded instants."""

import numpy as np
import pytest

from bearingsim.simulation import choice, limits
from bearingsim.simulation.integration import MOTIONS, STENCIL_REACH, difference_weights, differentiate
from bearingsim.simulation.simulate import simulate
from tests.scenes.short_cases import SLOT, case

RING = MOTIONS[0]
PLACE, VELOCITY, ACCELERATION = RING
H, TAIL, STEPS = 1e-3, 16, 50


def recorded(place, passes=3):
    """Velocity and acceleration of ``place``(t), pass by pass as a run writes them."""
    window, result = np.zeros((6, TAIL + STEPS)), []
    window[PLACE] = place(H * np.arange(-TAIL - STEPS, 0))
    for p in range(passes):
        window[:, :TAIL] = window[:, STEPS:].copy()
        t = H * np.arange(p * STEPS - TAIL, (p + 1) * STEPS)
        window[PLACE, TAIL:] = place(t[TAIL:])
        differentiate(window, RING, TAIL, H)
        full = slice(TAIL - STENCIL_REACH, TAIL + STEPS - STENCIL_REACH)
        result.append((t[full], window[VELOCITY, full].copy(), window[ACCELERATION, full].copy()))
    return (np.concatenate(one, axis=-1) for one in zip(*result, strict=True))


@pytest.mark.parametrize("omega", [400.0, 800.0])
def test_differences_are_of_eighth_order_and_know_no_seams(omega):
    """The highest frequency that is kept, 0.15 of the rate, is omega H = 0.94."""
    t, velocity, push = recorded(lambda t: np.array([np.sin(omega * t), np.cos(omega * t)]))
    after = t > 0.0
    bound = (omega * H) ** 8
    assert 0.8 * bound < 630 * np.abs(velocity[0] / omega - np.cos(omega * t))[after].max() < 1.1 * bound
    assert 0.8 * bound < 3150 * np.abs(push[1] / omega**2 + np.cos(omega * t))[after].max() < 1.1 * bound


@pytest.mark.parametrize("reach", [1, 2, 3, 4])
def test_weights_of_differences_are_exact_for_polynomials(reach):
    """To degree 2 reach for the slope, 2 reach + 1 for the second derivative, which odd powers do not have."""
    slopes, bends = difference_weights(reach)
    k = np.arange(1, reach + 1)
    for degree in range(1, 2 * reach + 1):
        even, odd = k**degree + (-k) ** degree, k**degree - (-k) ** degree
        assert np.dot(slopes, odd) == pytest.approx(float(degree == 1), abs=1e-12)
        assert np.dot(bends, even) == pytest.approx(2.0 * (degree == 2), abs=1e-12)


@pytest.mark.parametrize("late", [0.1, 0.5, 0.9])
def test_of_a_velocity_that_jumps_the_way_gone_is_kept(late):
    """Samples of the jump would be off by up to half a step of it."""
    jump = (70.0 + late) * H
    t, velocity, _ = recorded(lambda t: np.tile(np.maximum(0.0, t - jump), (2, 1)))
    assert H * velocity[0].sum() == pytest.approx(t[-1] + 0.5 * H - jump, abs=1e-12)
    sampled = H * np.heaviside(t - jump, 0.5).sum()
    assert late == 0.5 or abs(sampled - (t[-1] + 0.5 * H - jump)) > 0.3 * H


@pytest.mark.parametrize("method", ["dop853", "rodas"])
def test_the_line_does_not_depend_on_how_often_is_recorded(method):
    test_case = case(model="rollers", defect=SLOT, method=method, step_check=False)
    often = choice.automatic_step(test_case, limits.step_limits(test_case))
    fine, coarse = (simulate(test_case.model_copy(update={"step": k * often})).features for k in (0.25, 1))
    assert coarse["velocity@BPFO"] == pytest.approx(fine["velocity@BPFO"], rel=5e-4)
    assert coarse["velocity.rms"] == pytest.approx(fine["velocity.rms"], rel=2e-4)


WIDE = {"load": "240 N", "defect": SLOT | {"width": "1.3 mm"}, "duration": "20 ms", "settle": "10 ms"}


@pytest.mark.parametrize("method", ["dop853", "rodas"])
def test_raw_values_are_the_methods_own(method):
    """On lines between recorded instants accelerations were 20 % off, and the step check did not see it."""
    test_case = case(model="rollers", method=method, antialias=False, tolerance=1e-5, **WIDE)
    result, fine = (
        simulate(test_case.model_copy(update=one)) for one in ({}, {"step_check": False, "tolerance": 1e-7})
    )
    for name, bound in (("velocity.rms", 1e-3), ("acceleration.rms", 3e-3), ("acceleration.peak", 3e-3)):
        assert result.features[name] == pytest.approx(fine.features[name], rel=bound)
    assert 0.0 < result.features["step_error.record"] < 3e-3
    smooth = simulate(test_case.model_copy(update={"step_check": False, "antialias": True})).features
    # no step depends on where it is looked at
    assert smooth["velocity@BPFO"] == pytest.approx(result.features["velocity@BPFO"], rel=1e-12)


def test_raw_values_begin_where_the_record_does():
    """At t = 0 the bearing stands at rest; the next value is that of the run as well."""
    times = {"settle": "0 ms", "duration": "20 ms", "sampling": "50 kHz"}
    test_case = case(model="rollers", method="rodas", antialias=False, record=["ring.velocity"], **times)
    result, later = simulate(test_case), simulate(test_case.model_copy(update={"settle": 4e-3, "duration": 10e-3}))
    assert result.velocity[0].tolist() == [0.0, 0.0]
    assert np.allclose(result.velocity[200:700], later.velocity, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("ring", [{}, {"ring": {"harmonics": 5}}])
@pytest.mark.parametrize("more", [{}, {"antialias": False}])
def test_the_sensor_s_series_is_what_its_features_are_read_from(ring, more):
    """At 30 deg, of a rigid ring its two coordinates, turned; of a bent one its bending too."""
    rig = {"sensor": {"angle": "30 deg"}} | ring
    channels = ["sensor.velocity", "ring.velocity", "sensor.displacement"]
    result = simulate(case(model="rollers", rig=rig, record=channels, defects=[], **more))
    series, angle = result.series, np.pi / 6.0
    turned = np.cos(angle) * series["ring.velocity.x"] + np.sin(angle) * series["ring.velocity.y"]
    if ring:
        assert np.std(series["sensor.velocity"] - turned) > 0.1 * np.std(turned)
    else:
        assert series["sensor.velocity"] == pytest.approx(turned, abs=1e-15)
    assert np.std(series["sensor.velocity"]) == pytest.approx(result.features["velocity.rms"], rel=0.1)


@pytest.mark.parametrize("method", ["verlet", "dop853"])
def test_contact_forces_are_recorded_as_they_are(method: str) -> None:
    """Never as tension, and the same as without a low-pass; what is no force is low-passed."""
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
