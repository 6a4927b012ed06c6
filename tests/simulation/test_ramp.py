"""Speed ramps: motion of the inner ring, and response of cage and rollers."""

import numpy as np
import pytest

from bearingsim.core.geometry.motion import Ramp, Steady, kinematic_time, kinematic_times, speed_factor
from bearingsim.core.methods.verlet import Verlet
from bearingsim.simulation.simulate import simulate
from tests.scenes.nf308 import SLOT, case
from tests.scenes.planar_runs import energy_error, orders, start_planar

T = 0.05  # s: length of the ramps
RECORD = ["ring.velocity", "cage.speed", "cage.slip", "roller.spin", "roller.cage_force"]


def simulate_ramp(to, **overrides):
    """Simulate 0.2 s in `planar`, with a ramp from 1800 rpm to ``to`` within 0.05 s."""
    overrides = {"model": "planar", "duration": "0.2 s", "settle": "0 s", "record": RECORD} | overrides
    return simulate(case(ramp={"to": to, "time": f"{T} s"}, **overrides))


@pytest.mark.parametrize("ratio", [0.2, 1.0, 1.5, 4.0])
def test_angle_speed_and_acceleration_are_consistent(ratio):
    """The angle is the integral of the speed (by trapezoids, exactly), the speed that of the acceleration."""
    motion, t = Ramp(ratio, T), np.linspace(0.0, 3 * T, 3001)
    angle, speed, acceleration = np.array([kinematic_time(motion, x) for x in t]).T
    assert (angle[0], speed[0]) == (0.0, 1.0)
    assert speed[1000:] == pytest.approx(ratio, rel=1e-14)
    steps = np.diff(t)
    assert np.diff(angle) == pytest.approx(steps * (speed[1:] + speed[:-1]) / 2, rel=1e-10)
    assert np.diff(speed) == pytest.approx(steps * acceleration[:-1], abs=1e-13 * ratio)
    assert set(acceleration[1000:]) == {0.0}


class MovingModel:
    """Object with a motion."""

    motion = Ramp(2.0, T)


def test_motion_of_a_series():
    t = np.array([0.0, 0.02, 0.05, 0.3])
    assert kinematic_times(MovingModel, t).tolist() == [kinematic_time(MovingModel.motion, x)[0] for x in t]
    assert speed_factor(MovingModel, t).tolist() == [kinematic_time(MovingModel.motion, x)[1] for x in t]
    assert kinematic_times(None, t) is t
    assert speed_factor(None, t) == 1.0
    assert kinematic_time(Steady(), 0.3) == (0.3, 1.0, 0.0)


def test_ramp_to_the_same_speed_changes_nothing():
    """To rounding, over a slot."""
    settings = {"defect": SLOT, "duration": "80 ms", "seed": 3}
    ramp = simulate_ramp("1800 rpm", **settings)
    steady = simulate(case(model="planar", settle="0 s", record=RECORD, **settings))
    for name, values in steady.series.items():
        assert ramp.series[name] == pytest.approx(values, abs=1e-6 * np.abs(values).max() + 1e-12)


@pytest.mark.parametrize(("to", "sense"), [("2400 rpm", 1.0), ("1200 rpm", -1.0)])
def test_a_cage_without_drag_follows_a_ramp(to, sense):
    """Slower than kinematic while the rollers push it, faster while they brake it, and kinematic afterwards.

    Rollers push in the load zone only, so the cage lags by a pocket clearance (0.2 mm) each time a roller crosses
    it (some 90 mm): 0.22 %. The channel contains the total speed.
    """
    run = simulate_ramp(to, seed=1)
    slip, t = run.series["cage.slip"], run.time
    assert 3e-4 < sense * slip[t < T].mean() < 5e-3
    assert abs(slip[t > 0.1].mean()) < 3e-4
    ratio = float(to.split()[0]) / 1800
    kinematic = case().speed * (1 - 12 / 65) / 2 * np.where(t < T, 1 + (ratio - 1) * t / T, ratio)
    assert run.series["cage.speed"] == pytest.approx(kinematic * (1 - slip), rel=1e-12)


def test_accelerated_cage_is_pushed_by_rollers():
    """Pocket forces are zero at constant speed and above 1 N on a ramp."""
    assert np.abs(simulate_ramp("1800 rpm").series["roller.cage_force"]).max() == 0.0
    assert np.abs(simulate_ramp("2400 rpm").series["roller.cage_force"]).max() > 1.0


def test_energy_closes_on_a_ramp():
    """Drive, friction, damping and pockets while the speed grows by an eighth: Verlet to second order."""
    model, y = start_planar(ramp={"to": "2160 rpm", "time": "10 ms"})
    slow, lost = zip(*(energy_error(model, Verlet(h), 6.4e-3, y) for h in (8e-7, 4e-7, 2e-7)), strict=True)
    assert orders(slow) == pytest.approx(2.0, abs=0.05)
    assert slow[-1] < 2e-3 * lost[-1]
