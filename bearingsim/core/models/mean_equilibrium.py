"""Static equilibria over a ball pass: mean position, stiffness and damping of the rollers."""

from math import pi
from typing import NamedTuple

import numpy as np

from bearingsim.core import layout as lay
from bearingsim.core.laws.damping.interface import damping_bound, in_series
from bearingsim.core.models.equilibrium import (
    NoEquilibrium,
    load_magnitude,
    ring_stiffness,
    solve_equilibrium,
    solve_in_cpu_time,
    solve_initial_equilibrium,
)
from bearingsim.core.parts.bending import Bending, NoSprings, supported_position

# a prime, so that no two triples of angles agree modulo a ball pass; of all generators, 109 lets the smallest of a
# smooth function's squared Fourier coefficients alias to its mean
LATTICE_POINTS, LATTICE_GENERATOR = 509, 109.0


def supported_body_position(model, y):
    """Return the position (m, m) of the body held by the bracket: the ring, or the carrier around it."""
    return supported_position(model.bending.springs if isinstance(model.bending, Bending) else NoSprings(), y)


class MeanEquilibrium(NamedTuple):
    """Static equilibrium of a bearing, averaged over a ball pass.

    x, y: mean position of the body held by the bracket, the ring or the carrier around it (m); load: largest force
    on a roller (N); approach: sum of the approaches of its two contacts under this force (m); K_x, K_y: mean
    stiffness (N/m) of the rollers for the ring.
    """

    x: float
    y: float
    load: float
    approach: float
    K_x: float
    K_y: float


def ring_damping(Z, outer, inner, y):
    """Return the damping (N s/m) of ``Z`` rollers for the ring along e_0 and e_90, with the two contacts of a
    roller in series."""
    c_xx, c_yy = 0.0, 0.0
    for j in range(Z):
        c_outer = damping_bound(outer, max(y[lay.DELTA_O + j], 0.0), 0.0)
        c_inner = damping_bound(inner, max(y[lay.DELTA_I + j], 0.0), 0.0)
        c = in_series(c_outer, c_inner)
        c_xx += c * y[lay.COS + j] * y[lay.COS + j]
        c_yy += c * y[lay.SIN + j] * y[lay.SIN + j]
    return c_xx, c_yy


def equilibria(model, times, y):
    """Yield the index of each of ``times`` (s) with ``y`` in static equilibrium, each found from the one before.

    Raises ``NoEquilibrium`` if an equilibrium is not found to 1e-8 of the load.
    """
    load = load_magnitude(model)
    for n, t in enumerate(times):
        solve = solve_initial_equilibrium if n == 0 else solve_equilibrium
        residual = solve_in_cpu_time(solve, model, float(t), y)
        if not residual <= 1e-8 * load:
            raise NoEquilibrium(f"no static equilibrium: {residual:g} N left of {load:g} N")
        yield n


def equilibria_over_pass(model, y, samples):
    """Run ``equilibria`` at ``samples`` times evenly spaced over a ball pass."""
    pass_time = 2.0 * pi / (model.bearing.Z * model.bearing.omega_c)
    return equilibria(model, [(n + 0.5) / samples * pass_time for n in range(samples)], y)


def mean_position(model, y):
    """Return the mean position (m, m) of the body held by the bracket, over all angles of cage, shaft and rollers.

    The three angles turn independently, because with slip no two of them stay in step. The mean is over a lattice
    of ``LATTICE_POINTS`` triples, 2 pi n (1, g, g^2)/N. Raises ``NoEquilibrium``.
    """
    b, g, N = model.bearing, LATTICE_GENERATOR, LATTICE_POINTS
    turning = model._replace(bearing=b._replace(omega_i=g * b.omega_c, omega_b=g * g % N * b.omega_c))
    times = 2.0 * pi / b.omega_c * np.arange(N) / N
    x, y_mean = np.mean([supported_body_position(model, y) for _ in equilibria(turning, times, y)], axis=0)
    return float(x), float(y_mean)


def mean_equilibrium(model, y, samples=32):
    """Return ``MeanEquilibrium`` of a bearing from ``samples`` equilibria over a ball pass. Raises
    ``NoEquilibrium``."""
    Z, rows, loads = model.bearing.Z, [], []
    for _ in equilibria_over_pass(model, y, samples):
        k_xx, _, k_yy = ring_stiffness(model, y)
        rows.append((*supported_body_position(model, y), k_xx, k_yy))
        heaviest = int(np.argmax(y[lay.Q_I : lay.Q_I + Z]))
        loads.append((y[lay.Q_O + heaviest], y[lay.DELTA_O + heaviest] + y[lay.DELTA_I + heaviest]))
    x_mean, y_mean, k_x, k_y = (float(value) for value in np.mean(rows, axis=0))
    load, approach = (float(value) for value in max(loads))
    return MeanEquilibrium(x_mean, y_mean, load, approach, k_x, k_y)


def mean_ring_damping(model, outer, inner, y, samples=32):
    """Return ``ring_damping`` of a bearing with the contact laws ``outer`` and ``inner``, averaged over a ball
    pass."""
    Z = model.bearing.Z
    dampings = [ring_damping(Z, outer, inner, y) for _ in equilibria_over_pass(model, y, samples)]
    c_x, c_y = np.mean(dampings, axis=0)
    return float(c_x), float(c_y)
