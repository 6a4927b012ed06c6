"""What a contact that closes within a step does to a method's order (docs/touch_down.md has the measurements).

A force that starts as tau^m leaves, of a step across, an error of h^(1 + m) in the speed, whatever the method.
"""

import numpy as np
import pytest

from bearingsim.core import layout as lay
from bearingsim.core.methods.dop853 import Dop853
from bearingsim.core.methods.dormand_prince import DormandPrince
from bearingsim.core.methods.nystrom import Nystrom
from bearingsim.core.methods.rk4 import RungeKutta4
from tests.scenes.oscillators import at_even_steps, bounce, run

METHODS = (RungeKutta4, Nystrom, DormandPrince, Dop853)
G, V, FLIGHT, PRESSED, PHASES = 10.0, 1.0, 0.02, 0.012, 64
STEPS = (32, 48, 72, 108, 162, 243)
SCALE = np.array([100.0, 1.0])


def floor(m):
    """As stiff as a spring of 1e4 1/s^2 at 5 mm."""
    return bounce(G, 1e4 * 5e-3 ** (1.0 - m), m)


def exactly(model, t):
    """Place, times 100 1/s, and speed at ``t`` (s) after the touch-down at V, to rounding."""
    out, y = run(Dop853(t, 1e-14, 1e-17, 1e-16, t), model, 1, q=0.0, v=-V)
    assert y[lay.FAILED] == 0.0
    return out[0] * SCALE


def fitted(method, model, located, some=STEPS):
    """Order of the error's root mean square: touch-downs at 64 places in a step, or at a step's end."""
    measured = []
    for steps in some:
        if located:
            found = [at_even_steps(method, model, PRESSED / steps, steps, 0.0, -V)]
            exact = [exactly(model, PRESSED)]
        else:
            span = FLIGHT + PRESSED
            h = span / steps
            flights = FLIGHT + h * (np.arange(PHASES) + 0.5) / PHASES
            found = [at_even_steps(method, model, h, steps, V * t - G * t * t / 2, G * t - V) for t in flights]
            exact = [exactly(model, span - t) for t in flights]
        measured.append(np.sqrt(np.mean(np.square(np.array(found) * SCALE - exact))))
    errors = np.array(measured)
    kept = errors > 3e-14
    assert kept.sum() > 2
    return -np.polyfit(np.log(np.array(some)[kept]), np.log(errors[kept]), 1)[0]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("m", [1.0, 10.0 / 9.0, 1.5])
def test_order_across_a_touch_down(method, m):
    """1 + m for every method: 2.11 for rollers, 2.5 for balls, 2 for a linear contact."""
    assert fitted(method, floor(m), located=False) == pytest.approx(1.0 + m, abs=0.2)


@pytest.mark.parametrize(("method", "order"), [(RungeKutta4, 4), (Nystrom, 4), (DormandPrince, 5)])
def test_a_step_from_the_touch_down_gives_back_the_order_to_a_linear_contact(method, order):
    """DOP853's error is rounding at the longest of these steps."""
    assert fitted(method, floor(1.0), True, (8, 12, 18, 27, 40)) == pytest.approx(order, abs=0.3)
    found = at_even_steps(Dop853, floor(1.0), PRESSED / 8, 8, 0.0, -V) * SCALE
    assert found == pytest.approx(exactly(floor(1.0), PRESSED), abs=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_but_not_to_a_rollers(method):
    """From the touch-down on the force still starts as tau^(10/9): the order stays, only the factor falls."""
    model = floor(10.0 / 9.0)
    assert fitted(method, model, located=True) == pytest.approx(19.0 / 9.0, abs=0.2)
