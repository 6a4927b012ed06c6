"""Order of a method if a contact closes within a step (measurements: docs/touch_down.md).

A force that starts as tau^m within a step causes an error of h^(1 + m) in the speed, whatever the method.
"""

from math import inf
from typing import NamedTuple

import numpy as np
import pytest

from bearingsim.core import layout as lay
from bearingsim.core.defects.jumps import next_jump
from bearingsim.core.methods.dop853 import Dop853
from bearingsim.core.methods.dormand_prince import DormandPrince
from bearingsim.core.methods.nystrom import Nystrom
from bearingsim.core.methods.rk4 import RungeKutta4
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.models.interface import accelerations, degrees_of_freedom, state_width, update_extremes
from bearingsim.core.parameters import Bearing
from tests.scenes.oscillators import UNIT, at_even_steps, bouncing_roller, run

METHODS = (RungeKutta4, Nystrom, DormandPrince, Dop853)
G, V, FLIGHT, CONTACT_TIME, PHASES = 10.0, 1.0, 0.02, 0.012, 64
STEPS = (32, 48, 72, 108, 162, 243)
SCALE = np.array([100.0, 1.0])


def floor(m):
    """Return a floor of exponent ``m`` with the force of a spring of 1e4 1/s^2 at 5 mm."""
    return bouncing_roller(G, 1e4 * 5e-3 ** (1.0 - m), m)


def exact_state(model, t):
    """Return position times 100 1/s, and speed, at ``t`` (s) after a touch-down at speed V, exact to rounding."""
    out, y = run(Dop853(t, 1e-14, 1e-17, 1e-16, t), model, 1, q=0.0, v=-V)
    assert y[lay.FAILED] == 0.0
    return out[0] * SCALE


def error_order(method, model, located, step_counts=STEPS):
    """Return the order of the RMS error, for touch-downs at 64 fractions of a step or at its end."""
    rms_errors = []
    for steps in step_counts:
        if located:
            results = [at_even_steps(method, model, CONTACT_TIME / steps, steps, 0.0, -V)]
            exact = [exact_state(model, CONTACT_TIME)]
        else:
            span = FLIGHT + CONTACT_TIME
            h = span / steps
            flights = FLIGHT + h * (np.arange(PHASES) + 0.5) / PHASES
            results = [at_even_steps(method, model, h, steps, V * t - G * t * t / 2, G * t - V) for t in flights]
            exact = [exact_state(model, span - t) for t in flights]
        rms_errors.append(np.sqrt(np.mean(np.square(np.array(results) * SCALE - exact))))
    errors = np.array(rms_errors)
    resolved = errors > 3e-14
    assert resolved.sum() > 2
    return -np.polyfit(np.log(np.array(step_counts)[resolved]), np.log(errors[resolved]), 1)[0]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("m", [1.0, 10.0 / 9.0, 1.5])
def test_order_across_a_touch_down(method, m):
    """The order is 1 + m for every method: 2.11 for rollers, 2.5 for balls, 2 for a linear contact."""
    assert error_order(method, floor(m), located=False) == pytest.approx(1.0 + m, abs=0.2)


@pytest.mark.parametrize(("method", "order"), [(RungeKutta4, 4), (Nystrom, 4), (DormandPrince, 5)])
def test_step_from_touch_down_restores_the_order_for_a_linear_contact(method, order):
    """The error of DOP853 is rounding even at the longest of these steps."""
    assert error_order(method, floor(1.0), True, (8, 12, 18, 27, 40)) == pytest.approx(order, abs=0.3)
    result = at_even_steps(Dop853, floor(1.0), CONTACT_TIME / 8, 8, 0.0, -V) * SCALE
    assert result == pytest.approx(exact_state(floor(1.0), CONTACT_TIME), abs=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_step_from_touch_down_does_not_restore_the_order_for_a_roller(method):
    """The force still starts as tau^(10/9), so the order stays the same and only the factor falls."""
    model = floor(10.0 / 9.0)
    assert error_order(method, model, located=True) == pytest.approx(19.0 / 9.0, abs=0.2)


class DampedFloor(NamedTuple):
    """A roller over a floor whose dashpot acts as delta^(1/9), as Kraemer's law on Palmgren's stiffness does.

    reported: 1 if the model fills the rows of the contact, 0 if it leaves them empty.
    """

    reported: float
    K: float = 1e6
    beta: float = 4e-4
    bearing: Bearing = UNIT


state_width.register(DampedFloor)(lambda model: lay.FIRST_LANE + 8)
degrees_of_freedom.register(DampedFloor)(lambda model: (1, 0))
update_extremes.register(DampedFloor)(lambda model, y: None)
next_jump.register(DampedFloor)(lambda model, t, y: inf)


@accelerations.register(DampedFloor)
def _accelerations(model, t, y):
    delta, v = -y[lay.RADIAL], -y[lay.RADIAL_V]
    y[lay.DELTA_O], y[lay.V_O] = model.reported * delta, model.reported * v
    d = max(delta, 0.0)
    y[lay.RADIAL_A] = max(model.K * (d ** (10 / 9) + model.beta * 10 / 9 * d ** (1 / 9) * v), 0.0)


def test_verlet_divides_the_step_of_a_touch_down():
    """RMS error of the speed after touch-downs at 64 fractions of a step, with and without the division."""
    contact_time, gap = 1e-3, 1e-3
    h = contact_time / 40
    gaps = gap - h * V * (np.arange(PHASES) + 0.5) / PHASES
    steps = round((contact_time + gap / V) / h)
    exact = [
        run(Dop853(steps * h - g / V, 1e-12, 1e-16, 1e-13, 1e-6), DampedFloor(1.0), 1, q=0.0, v=-V)[0][-1, 1]
        for g in gaps
    ]
    divided, undivided = (
        np.sqrt(
            np.mean(
                [
                    (run(Verlet(h), model, steps, q=g, v=-V)[0][-1, 1] - v) ** 2
                    for g, v in zip(gaps, exact, strict=True)
                ]
            )
        )
        for model in (DampedFloor(1.0), DampedFloor(0.0))
    )
    assert 1e-5 < divided < undivided / 6.0
