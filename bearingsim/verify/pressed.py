"""Two elastic bodies pressed together: the unilateral contact problem on the nodes of one surface.

The pressure is linear between nodes. With p its values at the nodes, gap the distance of the undeformed
surfaces, C the sum of both bodies' compliances and delta the approach,

    p >= 0,     g = gap - delta + C p >= 0,     p g = 0,     spread . p = Q'

``spread`` holds the integrals of the nodes' hat functions. The nodes in contact are found by an active set: those
that pull are let go, those that overlap are taken in, until neither is left (Kalker 1990 solves contact so; Hintermueller,
Ito and Kunisch 2002 show that it is a Newton method).
"""

from typing import NamedTuple

import numpy as np

ROUNDS = 200
LOOSE = 1e-12  # of the approach: an overlap that is rounding


class NotPressed(ArithmeticError):
    """The set of nodes in contact kept changing."""


class Body(NamedTuple):
    """What a pair of bodies is to the solver.

    t: (n,) m, places of the nodes along rolling; compliance: (n, n) m/Pa, normal displacement of both bodies at
    node i under the hat pressure of node j; spread: (n,) m.
    """

    t: np.ndarray
    compliance: np.ndarray
    spread: np.ndarray


class Pressed(NamedTuple):
    """A solution. force: N/m; approach: m, with the compliance's datum; stiffness: dQ'/d(delta), N/m^2; pressure: (n,) Pa."""

    force: float
    approach: float
    stiffness: float
    pressure: np.ndarray


def press(body: Body, gap: np.ndarray, force: float) -> Pressed:
    """The contact under ``force`` (N/m); ``gap`` (n,) in m. Raises ``NotPressed``."""
    active = gap <= np.partition(gap, 3)[3]
    for _ in range(ROUNDS):
        p, delta, stiffness = hold(body, gap, active, force)
        overlap = delta - gap - body.compliance @ p
        taken = ~active & (overlap > LOOSE * abs(delta))
        let_go = active & (p < 0.0)
        if not (taken.any() or let_go.any()):
            return Pressed(force, delta, stiffness, p)
        active = (active & ~let_go) | taken
    raise NotPressed(f"no set of nodes in contact found in {ROUNDS} rounds")


def hold(body: Body, gap: np.ndarray, active: np.ndarray, force: float) -> tuple[np.ndarray, float, float]:
    """Pressure (Pa), approach (m) and stiffness (N/m^2) with just the ``active`` nodes in contact, even pulling."""
    inside = body.compliance[np.ix_(active, active)]
    per_approach, at_rest = np.linalg.solve(inside, np.array([np.ones(len(inside)), gap[active]]).T).T
    spread = body.spread[active]
    stiffness = float(spread @ per_approach)
    delta = (force + float(spread @ at_rest)) / stiffness
    pressure = np.zeros(len(gap))
    pressure[active] = delta * per_approach - at_rest
    return pressure, delta, stiffness
