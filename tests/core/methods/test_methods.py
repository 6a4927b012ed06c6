"""Integrators: order, linear stability limit, energy, and runs in chunks."""

from itertools import pairwise

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import Monitor
from bearingsim.core.methods.rk4 import RungeKutta4
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.models.interface import accelerations
from bearingsim.core.outcomes import NOT_FINITE, STEP_LIMIT_EXCEEDED, SUCCESS
from tests.scenes.nf308 import ROWS, SLOT, advance_recorded, at_rest, case, drive

SMOOTH = {"clearance": "-4 um", "contact": {"damping": {"chi": "5 s/m"}}}  # preloaded: no contact opens


def displaced_state(model):
    """Return the state of the smooth case at rest, with an initial velocity of the ring."""
    y = at_rest(model)
    y[lay.VELOCITY] += 2e-3
    y[lay.VELOCITY + 1] -= 1e-3
    accelerations(model, 0.0, y)
    return y


@pytest.mark.parametrize(("method", "order", "tolerance"), [(RungeKutta4, 4.0, 0.3), (Verlet, 2.0, 0.2)])
@pytest.mark.parametrize("model", ["ring", "rollers"])
def test_order_on_smooth_motion(method, order, tolerance, model):
    """Differences between successive halvings of the step fall by 2^order."""
    scene = assemble.model(case(model=model, **SMOOTH))
    span, longest = (256e-6, 1e-6) if method is RungeKutta4 else (256e-6, 0.25e-6)
    ends = []
    for n in range(4):
        h = longest / 2**n
        y = displaced_state(scene)
        drive(scene, method(h), round(span / h), y)
        ends.append(
            np.concatenate(
                [
                    y[lay.POSITION : lay.POSITION + 2],
                    y[lay.RADIAL : lay.RADIAL + 13],
                    1e-6 * y[lay.VELOCITY : lay.VELOCITY + 2],
                ]
            )
        )
    differences = [np.linalg.norm(a - b) for a, b in pairwise(ends)]
    orders = [np.log2(a / b) for a, b in pairwise(differences)]
    assert orders[-1] == pytest.approx(order, abs=tolerance)


def test_verlet_conserves_the_energy_of_undamped_contacts():
    """With preload and a fixed cage the energy changes by less than 1e-4 of the kinetic energy in 40 ms."""
    model = assemble.model(case(clearance="-4 um", contact={"damping": {"chi": "0 s/m"}}))
    bearing = model.bearing._replace(omega_c=0.0)
    model = model._replace(bearing=bearing, support=model.support._replace(c_b=0.0))
    y = at_rest(model)
    y[lay.VELOCITY] = 1e-3
    accelerations(model, 0.0, y)
    energies = []
    for _ in range(20):
        energies.append(energy(model, y))
        drive(model, Verlet(2e-7), 10_000, y)
    kinetic = 0.5 * model.bearing.m_o * 1e-6
    assert np.ptp(energies) < 1e-4 * kinetic


def energy(model, y):
    """Return the total energy (J): kinetic, elastic, of the bracket's spring and of the load."""
    b, s, k = model.bearing, model.support, model.outer.stiffness.k
    angle = b.theta_0 + 2 * np.pi * np.arange(13) / 13
    u = y[lay.POSITION : lay.POSITION + 2]
    w = y[lay.VELOCITY : lay.VELOCITY + 2]
    q = y[lay.RADIAL : lay.RADIAL + 13]
    v = y[lay.RADIAL_V : lay.RADIAL_V + 13]
    outer = np.maximum(q - u[0] * np.cos(angle) - u[1] * np.sin(angle) - b.gap, 0.0)
    inner = np.maximum(-b.gap - q, 0.0)
    elastic = k * 9 / 19 * (outer ** (19 / 9) + inner ** (19 / 9)).sum()
    spring = 0.5 * s.k_b * ((u[0] - s.x_0) ** 2 + (u[1] - s.y_0) ** 2)
    return 0.5 * b.m_o * w @ w + 0.5 * b.m_r * v @ v + elastic + spring + s.F * u[0]


@pytest.mark.parametrize("method", [Verlet(4e-7), RungeKutta4(1e-6)])
def test_run_in_chunks_is_identical(method):
    model = assemble.model(case(defect=SLOT))
    expected = drive(model, method, 9000)
    y, monitor, chunks = at_rest(model), Monitor(8, 1.0), []
    for start, count in ((0, 1000), (1000, 3001), (4001, 4999)):
        out = np.empty((len(ROWS), count))
        advance_recorded(method, model, monitor, start, y, ROWS, out)
        chunks.append(out)
    assert np.array_equal(np.hstack(chunks), expected)


def outcome(method, overrun_limit=13e-6, steps=60_000, **options):
    model = assemble.model(case(**options))
    out = np.empty((len(ROWS), steps))
    return advance_recorded(method, model, Monitor(2, overrun_limit), 0, at_rest(model), ROWS, out)


def test_monitor_passes_a_stable_run():
    assert outcome(Verlet(4e-7), defect=SLOT)[1] == SUCCESS


@pytest.mark.parametrize("method", [Verlet(2e-6), RungeKutta4(6e-6)])
def test_monitor_stops_a_run_over_the_step_limit(method):
    taken, result, body = outcome(method, defect=SLOT)
    assert result == STEP_LIMIT_EXCEEDED
    assert taken * method.h < 10e-3
    assert 0 <= body < 13


def test_monitor_stops_a_diverging_run():
    assert outcome(Verlet(2e-5), overrun_limit=1.0, defect=SLOT)[1] == NOT_FINITE
