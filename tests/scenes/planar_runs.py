"""Runs of `planar` with all that moves recorded at every step, and the energy account along them."""

import numpy as np

from bearingsim import assemble
from bearingsim.core.advance import Monitor
from bearingsim.core.outcomes import SUCCESS
from tests.independent import planar_bodies as bodies
from tests.independent import planar_sums
from tests.scenes import nf308
from tests.scenes.nf308 import case


def record_run(model, method, span, y):
    """Return instants (n + 1,) and coordinates (cells, n + 1) over ``span`` (s) from the state in ``y``."""
    rows, n = bodies.state_rows(model.bearing.Z), round(span / method.h)
    y, out = y.copy(), np.empty((len(rows), n + 1))
    out[:, 0], columns = y[rows], np.empty((len(rows), n))
    steps_taken, outcome, _ = nf308.advance_recorded(method, model, Monitor(8, 1.0), 0, y, rows, columns)
    assert (steps_taken, outcome) == (n, SUCCESS)
    out[:, 1:] = columns
    return method.h * np.arange(n + 1), out


def balances(model, t, out):
    """Balances at all instants, some thousands at a time."""
    slices_ = [slice(k, k + 4000) for k in range(0, len(t), 4000)]
    parts = [planar_sums.balance(bodies.scene(model, t[slice_], out[:, slice_])) for slice_ in slices_]
    return planar_sums.Balance(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def energy_error(model, method, span, y):
    """Most energy (J) that came from nowhere at any (second) instant, and all that was lost; Simpson's rule."""
    totals, h = balances(model, *record_run(model, method, span, y)), method.h
    net = totals.power - totals.lost
    work = np.cumsum(net[:-2:2] + 4 * net[1:-1:2] + net[2::2]) * h / 3
    return np.abs(totals.energy[2::2] - totals.energy[0] - work).max(), h * totals.lost.sum()


def orders(errors):
    """Orders of convergence that errors at halved steps show."""
    return np.log2(np.array(errors[:-1]) / errors[1:])


def start_planar(**fields):
    """A model of the plain kind at static equilibrium."""
    planar_case = case(model="planar", **fields)
    model = assemble.model(planar_case)
    return model, assemble.start(planar_case, model)[0]
