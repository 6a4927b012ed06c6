"""Integrators: order, linear stability limit, energy, and runs in pieces."""

from itertools import pairwise

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import Monitor, advance
from bearingsim.core.methods.rk4 import RungeKutta4
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.models.interface import accelerations
from bearingsim.core.outcomes import NOT_FINITE, STEP_LIMIT_EXCEEDED, SUCCESS
from tests.scenes.nf308 import PLACES, SLOT, at_rest, case, drive

SMOOTH = {"clearance": "-4 um", "contact": {"damping": {"chi": "5 s/m"}}}  # preloaded: no contact opens


def shaken(model):
    """The smooth scene in motion: the ring pushed aside, everything else at rest."""
    y = at_rest(model)
    y[lay.VELOCITY] += 2e-3
    y[lay.VELOCITY + 1] -= 1e-3
    accelerations(model, 0.0, y)
    return y


@pytest.mark.parametrize(("method", "order", "tolerance"), [(RungeKutta4, 4.0, 0.3), (Verlet, 2.0, 0.2)])
@pytest.mark.parametrize("model", ["ring", "rollers"])
def test_order_on_a_smooth_scene(method, order, tolerance, model):
    """Richardson's order from three halvings of the step: the differences fall by 2^order."""
    scene = assemble.model(case(model=model, **SMOOTH))
    span, longest = (256e-6, 1e-6) if method is RungeKutta4 else (256e-6, 0.25e-6)
    ends = []
    for n in range(4):
        h = longest / 2**n
        y = shaken(scene)
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
    gaps = [np.linalg.norm(a - b) for a, b in pairwise(ends)]
    orders = [np.log2(a / b) for a, b in pairwise(gaps)]
    assert orders[-1] == pytest.approx(order, abs=tolerance)


def test_verlet_keeps_the_energy_of_undamped_contacts():
    """Preloaded, undamped, standing cage: the energy drifts under 1e-4 of what moves in 40 ms."""
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
    """Kinetic + elastic + spring + potential of the load (J)."""
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
def test_a_run_in_pieces_is_the_same_run(method):
    model = assemble.model(case(defect=SLOT))
    whole = drive(model, method, 9000)
    y, monitor, pieces = at_rest(model), Monitor(8, 1.0), []
    for start, count in ((0, 1000), (1000, 3001), (4001, 4999)):
        out = np.empty((len(PLACES), count))
        advance(method, model, monitor, start, y, PLACES, out)
        pieces.append(out)
    assert np.array_equal(np.hstack(pieces), whole)


def outcome(method, patience=13e-6, steps=60_000, **given):
    model = assemble.model(case(**given))
    out = np.empty((len(PLACES), steps))
    return advance(method, model, Monitor(2, patience), 0, at_rest(model), PLACES, out)


def test_the_watch_lets_a_good_run_pass():
    assert outcome(Verlet(4e-7), defect=SLOT)[1] == SUCCESS


@pytest.mark.parametrize("method", [Verlet(2e-6), RungeKutta4(6e-6)])
def test_the_watch_stops_a_run_that_outruns_its_limit(method):
    taken, result, body = outcome(method, defect=SLOT)
    assert result == STEP_LIMIT_EXCEEDED
    assert taken * method.h < 10e-3
    assert 0 <= body < 13


def test_the_watch_stops_a_run_that_blows_up():
    assert outcome(Verlet(2e-5), patience=1.0, defect=SLOT)[1] == NOT_FINITE
