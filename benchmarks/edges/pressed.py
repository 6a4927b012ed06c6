"""Two elastic bodies pressed together: the unilateral contact problem on the nodes of one surface.

The pressure is linear between nodes. With p its values at the nodes, gap the distance of the undeformed
surfaces, C the sum of both bodies' compliances and delta the approach,

    p >= 0,     g = gap - delta + C p >= 0,     p g = 0,     spread . p = Q'

``spread`` holds the integrals of the nodes' hat functions. The nodes in contact are found by an active set: those
that pull are let go, those that overlap are taken in, until neither is left. (So does Kalker, Three-Dimensional
Elastic Bodies in Rolling Contact, 1990; Hintermueller, Ito and Kunisch 2002 show that it is a Newton method.)
"""

from collections.abc import Callable
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
    """A solution. force: N/m; approach: m, by the compliance's datum; stiffness: N/m^2; pressure: (n,) Pa."""

    force: float
    approach: float
    stiffness: float
    pressure: np.ndarray


def press(body: Body, gap: np.ndarray, force: float) -> Pressed:
    """The contact under ``force`` (N/m); ``gap`` (n,) in m. Raises ``NotPressed``."""

    def hold(active: np.ndarray) -> Pressed:
        per_approach, at_rest, stiffness = answers(body, gap, active)
        delta = (force + float(body.spread @ at_rest)) / stiffness
        return Pressed(force, delta, stiffness, delta * per_approach - at_rest)

    return settled(body, gap, hold)


def press_to(body: Body, gap: np.ndarray, approach: float) -> Pressed:
    """The contact at ``approach`` (m); no force where that is less than the gap. Raises ``NotPressed``."""

    def hold(active: np.ndarray) -> Pressed:
        per_approach, at_rest, stiffness = answers(body, gap, active)
        pressure = approach * per_approach - at_rest
        return Pressed(float(body.spread @ pressure), approach, stiffness, pressure)

    if approach <= gap.min():
        return Pressed(0.0, approach, 0.0, np.zeros(len(gap)))
    return settled(body, gap, hold)


def settled(body: Body, gap: np.ndarray, hold: Callable[[np.ndarray], Pressed]) -> Pressed:
    """The solution whose nodes in contact neither pull nor let others overlap; ``hold`` solves with given ones."""
    active = gap <= np.partition(gap, 3)[3]
    for _ in range(ROUNDS):
        found = hold(active)
        overlap = found.approach - gap - body.compliance @ found.pressure
        taken = ~active & (overlap > LOOSE * abs(found.approach))
        let_go = active & (found.pressure < 0.0)
        if not (taken.any() or let_go.any()):
            return found
        active = (active & ~let_go) | taken
    raise NotPressed(f"no set of nodes in contact found in {ROUNDS} rounds")


def answers(body: Body, gap: np.ndarray, active: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Pressure per approach (n,) (Pa/m) and against the gap (n,) (Pa), and stiffness (N/m^2), with given nodes."""
    inside = body.compliance[np.ix_(active, active)]
    found = np.zeros((2, len(gap)))
    found[:, active] = np.linalg.solve(inside, np.column_stack([np.ones(len(inside)), gap[active]])).T
    return found[0], found[1], float(body.spread @ found[0])
