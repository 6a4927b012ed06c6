"""Runs of `planar` with all that moves recorded at every step, and the energy account along them."""

import numpy as np

from bearingsim import assemble
from bearingsim.core.advance import Monitor
from bearingsim.core.outcomes import SUCCESS
from tests.independent import planar_bodies as bodies
from tests.scenes import nf308
from tests.scenes.nf308 import case


def record_run(model, method, span, y):
    """Instants (n + 1,) and all that moves (places, n + 1) over ``span`` (s) from the state in ``y``."""
    at, n = bodies.places(model.bearing.Z), round(span / method.h)
    y, out = y.copy(), np.empty((len(at), n + 1))
    out[:, 0], later = y[at], np.empty((len(at), n))
    taken, outcome, _ = nf308.advance_recorded(method, model, Monitor(8, 1.0), 0, y, at, later)
    assert (taken, outcome) == (n, SUCCESS)
    out[:, 1:] = later
    return method.h * np.arange(n + 1), out


def balances(model, t, out):
    """Balances at all instants, some thousands at a time."""
    pieces = [slice(k, k + 4000) for k in range(0, len(t), 4000)]
    found = [bodies.balance(bodies.scene(model, t[piece], out[:, piece])) for piece in pieces]
    return bodies.Balance(*(np.concatenate(column) for column in zip(*found, strict=True)))


def energy_error(model, method, span, y):
    """Most energy (J) that came from nowhere at any (second) instant, and all that was lost; Simpson's rule."""
    found, h = balances(model, *record_run(model, method, span, y)), method.h
    net = found.power - found.lost
    gone = np.cumsum(net[:-2:2] + 4 * net[1:-1:2] + net[2::2]) * h / 3
    return np.abs(found.energy[2::2] - found.energy[0] - gone).max(), h * found.lost.sum()


def orders(errors):
    """Orders of convergence that errors at halved steps show."""
    return np.log2(np.array(errors[:-1]) / errors[1:])


def start_planar(**given):
    """A model of the plain kind at static equilibrium."""
    at_hand = case(model="planar", **given)
    model = assemble.model(at_hand)
    return model, assemble.start(at_hand, model)[0]
