"""``static``: at each cage angle the ring stands where the forces balance; nothing has inertia or damping.

Its velocity is the rate at which that place moves, by differentiating the balance f(u, t) = 0:
(-df/du) u' = df/dt at fixed u. Left out: everything that takes time.
"""

from typing import Any, NamedTuple

from bearingsim.core.contact import tangent
from bearingsim.core.defects import Pits, W, depression
from bearingsim.core.equilibrium import ALONG, K_SERIES, PIT, find_rest, ring_stiffness, solve_2x2
from bearingsim.core.jit import jit
from bearingsim.core.layout import COS, DELTA_I, LANES, POSITION, Q_O, SIN, VELOCITY, X, Y
from bearingsim.core.models.interface import damping_per_mass, rest, stiffness_per_mass, watched, width
from bearingsim.core.parameters import Bearing, Support


class Static(NamedTuple):
    """Parameters of the model; ``bearing.m_r`` must be 0, the ring's mass and the damping are not used."""

    bearing: Bearing
    support: Support
    contact: Any
    pits: Pits


@width.register(Static)
def _width(model):
    return LANES


@jit
def pit_rate(model, d, s, inner, u_r):
    """Mean rate dh/dt (m/s) at which the pit sinks away, weighted by the stiffness of the groups in contact."""
    pits, bearing = model.pits, model.bearing
    weighted, total = 0.0, 0.0
    for k in range(pits.used[d]):
        h, slope = depression(pits.groups[d, k], s, pits.R)
        delta = -u_r - 2.0 * bearing.gap - inner - h
        if delta > 0.0:
            stiffness = pits.groups[d, k, W] * tangent(model.contact.stiffness, delta)
            weighted += stiffness * slope * pits.R_o * bearing.omega_c
            total += stiffness
    return weighted / total if total > 0.0 else 0.0


@jit
def moving_force(model, y):
    """df/dt (N/s) of the net force with the ring held: rollers change angle, pits sink under them."""
    bearing = model.bearing
    g_x, g_y = 0.0, 0.0
    for j in range(bearing.Z):
        c, s = y[COS + j], y[SIN + j]
        rate = -bearing.omega_c * (-y[POSITION + X] * s + y[POSITION + Y] * c)
        if y[PIT + j] >= 0.0:
            u_r = y[POSITION + X] * c + y[POSITION + Y] * s
            rate -= pit_rate(model, int(y[PIT + j]), y[ALONG + j], y[DELTA_I + j], u_r)
        force_rate, turning = y[K_SERIES + j] * rate, y[Q_O + j] * bearing.omega_c
        g_x += force_rate * c - turning * s
        g_y += force_rate * s + turning * c
    return g_x, g_y


@rest.register(Static)
def _rest(model, t, y):
    residual = find_rest(model, t, y)
    g_x, g_y = moving_force(model, y)
    k_xx, k_xy, k_yy = ring_stiffness(model, y)
    y[VELOCITY + X], y[VELOCITY + Y] = solve_2x2(k_xx, k_xy, k_yy, g_x, g_y)
    return residual


@watched.register(Static)
def _watched(model):
    return 0


@stiffness_per_mass.register(Static)
def _stiffness_per_mass(model, y, j):
    return 0.0


@damping_per_mass.register(Static)
def _damping_per_mass(model, y, j):
    return 0.0
