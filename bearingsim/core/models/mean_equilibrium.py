"""Static equilibria over a ball pass: mean position, stiffness and damping of the rollers."""

from math import inf, pi
from typing import NamedTuple

import numpy as np

from bearingsim import cpu_time
from bearingsim.core import layout as lay
from bearingsim.core.jit import jit
from bearingsim.core.laws.damping.interface import damping_bound, in_series
from bearingsim.core.models.equilibrium import (
    NoEquilibrium,
    load_magnitude,
    ring_stiffness,
    solve_equilibrium,
    solve_initial_equilibrium,
)
from bearingsim.core.parts.bending import Bending, NoSprings, supported_position

# of a rank-1 lattice: a prime number of points, so that no two have equal angles modulo a ball pass; of all
# generators, 109 gives the smallest sum of squared Fourier coefficients of a smooth function that alias to its
# mean
LATTICE_POINTS, LATTICE_GENERATOR = 509, 109.0
MAX_RESIDUAL = 1e-8  # largest residual force of an accepted equilibrium, relative to the load


class MeanEquilibrium(NamedTuple):
    """Static equilibrium of a bearing, averaged over a ball pass.

    x, y: mean position (m) of the body supported by the bracket, which is the ring or the carrier around it; load,
    inner_load: largest force of the outer race on a roller, and that of the inner race on the same roller (N);
    approach: sum of the approaches of its two contacts under these forces (m); K_x, K_y: mean stiffness (N/m) of
    the rollers for the ring.
    """

    x: float
    y: float
    load: float
    inner_load: float
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


@jit
def fill_equilibria(model, springs, times, from_scratch, tolerance, y, rows):
    """Find the static equilibrium at each of ``times`` (n,) s, each with the previous one as initial guess.

    The initial guess of the first is the equilibrium in ``y`` unless ``from_scratch`` is true. Fills a row of
    ``rows`` (n, 7) for each: the position of the body supported by the bracket (m, m), the stiffness of the
    rollers for the ring along x and y (N/m), the forces of outer and inner race on the most loaded roller (N),
    and the sum of the approaches of its contacts (m). Ends at the first residual above ``tolerance`` (N). Returns
    the last residual (N).
    """
    residual = 0.0
    for n in range(len(times)):
        if n == 0 and from_scratch:
            residual = solve_initial_equilibrium(model, times[n], y)
        else:
            residual = solve_equilibrium(model, times[n], y)
        if not residual <= tolerance:
            break
        most_loaded = 0
        for j in range(model.bearing.Z):
            if y[lay.Q_I + j] > y[lay.Q_I + most_loaded]:
                most_loaded = j
        rows[n, 0], rows[n, 1] = supported_position(springs, y)
        rows[n, 2], _, rows[n, 3] = ring_stiffness(model, y)
        rows[n, 4] = y[lay.Q_O + most_loaded]
        rows[n, 5] = y[lay.Q_I + most_loaded]
        rows[n, 6] = y[lay.DELTA_O + most_loaded] + y[lay.DELTA_I + most_loaded]
    return residual


def solve_in_turn(model, times, y, from_scratch=True, tolerance=inf):
    """Run ``fill_equilibria`` within the job's CPU time; return the last residual (N) and the rows (n, 7).

    All equilibria in the plane are computed by this function, so that only one is compiled for a static model.
    Raises ``OutOfCpuTime`` when the time is used up.
    """
    rows = np.empty((len(times), 7))
    springs = model.bending.springs if isinstance(model.bending, Bending) else NoSprings()

    def fill_until(end):
        y[lay.CPU_END] = end
        return fill_equilibria(model, springs, times, from_scratch, tolerance, y, rows)

    return float(cpu_time.bounded(fill_until)), rows


def solve_at(model, t, y, from_scratch):
    """Find the static equilibrium at ``t`` (s) into ``y``; return the residual (N).

    The initial guess is the equilibrium in ``y`` unless ``from_scratch`` is true. Raises ``OutOfCpuTime``.
    """
    residual, _ = solve_in_turn(model, np.array([t], dtype=float), y, from_scratch)
    return residual


def equilibria(model, times, y):
    """Return the rows (n, 7) of ``fill_equilibria`` at ``times`` (n,) s.

    Raises ``NoEquilibrium`` if a residual is over ``MAX_RESIDUAL``.
    """
    load = load_magnitude(model)
    residual, rows = solve_in_turn(model, times, y, tolerance=MAX_RESIDUAL * load)
    refuse_unbalanced(residual, load)
    return rows


def refuse_unbalanced(residual, load):
    """Raise ``NoEquilibrium`` if the residual force is over ``MAX_RESIDUAL`` of the load (N)."""
    if not residual <= MAX_RESIDUAL * load:
        raise NoEquilibrium(f"no static equilibrium: residual force {residual:g} N at a load of {load:g} N")


def times_of_pass(model, samples):
    """Return ``samples`` times (s) evenly spaced over a ball pass."""
    pass_time = 2.0 * pi / (model.bearing.Z * model.bearing.omega_c)
    return (np.arange(samples) + 0.5) / samples * pass_time


def mean_position(model, y):
    """Return the mean position (m, m) of the body supported by the bracket, over all angles of cage, shaft and
    rollers.

    The three angles are independent, because with slip no two of them have a fixed ratio. The mean is over a
    lattice of ``LATTICE_POINTS`` triples, 2 pi n (1, g, g^2)/N. Raises ``NoEquilibrium``.
    """
    b, g, N = model.bearing, LATTICE_GENERATOR, LATTICE_POINTS
    lattice_model = model._replace(bearing=b._replace(omega_i=g * b.omega_c, omega_b=g * g % N * b.omega_c))
    times = 2.0 * pi / b.omega_c * np.arange(N) / N
    x, y_mean = np.mean(equilibria(lattice_model, times, y)[:, :2], axis=0)
    return float(x), float(y_mean)


def mean_equilibrium(model, y, samples=32):
    """Return ``MeanEquilibrium`` of a bearing from ``samples`` equilibria over a ball pass. Raises
    ``NoEquilibrium``."""
    rows = equilibria(model, times_of_pass(model, samples), y)
    x_mean, y_mean, k_x, k_y = np.mean(rows[:, :4], axis=0).tolist()
    load, inner_load, approach = max(rows[:, 4:].tolist())
    return MeanEquilibrium(x_mean, y_mean, load, inner_load, approach, k_x, k_y)


def mean_ring_damping(model, outer, inner, y, samples=32):
    """Return ``ring_damping`` of a bearing with the contact laws ``outer`` and ``inner``, averaged over a ball
    pass."""
    Z = model.bearing.Z
    dampings = []
    for n, t in enumerate(times_of_pass(model, samples).tolist()):
        refuse_unbalanced(solve_at(model, t, y, from_scratch=n == 0), load_magnitude(model))
        dampings.append(ring_damping(Z, outer, inner, y))
    c_x, c_y = np.mean(dampings, axis=0)
    return float(c_x), float(c_y)
