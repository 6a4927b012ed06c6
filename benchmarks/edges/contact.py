"""Unilateral contact of two elastic bodies on the nodes of one surface.

The pressure is linear between nodes. With the nodal pressures p, the gap between the undeformed surfaces, the sum
C of both compliances and the approach delta,

    p >= 0,     g = gap - delta + C p >= 0,     p g = 0,     spread . p = Q'

``spread`` contains the integrals of the hat functions. The nodes in contact are determined by an active-set
method: nodes in tension are removed and overlapping nodes are added until there are none. (Kalker, Three-
Dimensional Elastic Bodies in Rolling Contact, 1990; Hintermueller, Ito and Kunisch 2002 show that it is a Newton
method.)
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

MAX_ROUNDS = 200
ROUNDING = 1e-12  # largest overlap due to rounding, relative to the approach


class ContactError(ArithmeticError):
    """The active set did not converge."""


class Body(NamedTuple):
    """Pair of bodies.

    t: (n,) m, positions of the nodes along rolling; compliance: (n, n) m/Pa, normal displacement of both bodies at
    node i under the hat pressure of node j; spread: (n,) m.
    """

    t: np.ndarray
    compliance: np.ndarray
    spread: np.ndarray


class Contact(NamedTuple):
    """Solution. force: N/m; approach: m, relative to the datum; stiffness: N/m^2; pressure: (n,) Pa."""

    force: float
    approach: float
    stiffness: float
    pressure: np.ndarray


def press(body: Body, gap: np.ndarray, force: float) -> Contact:
    """Solve the contact under ``force`` (N/m); ``gap`` (n,) in m. Raises ``ContactError``."""

    def solve(active: np.ndarray) -> Contact:
        per_approach, for_gap, stiffness = unit_solutions(body, gap, active)
        delta = (force + float(body.spread @ for_gap)) / stiffness
        return Contact(force, delta, stiffness, delta * per_approach - for_gap)

    return find_contact(body, gap, solve)


def press_to(body: Body, gap: np.ndarray, approach: float) -> Contact:
    """Solve the contact at ``approach`` (m); the force is 0 below the smallest gap. Raises ``ContactError``."""

    def solve(active: np.ndarray) -> Contact:
        per_approach, for_gap, stiffness = unit_solutions(body, gap, active)
        pressure = approach * per_approach - for_gap
        return Contact(float(body.spread @ pressure), approach, stiffness, pressure)

    if approach <= gap.min():
        return Contact(0.0, approach, 0.0, np.zeros(len(gap)))
    return find_contact(body, gap, solve)


def find_contact(body: Body, gap: np.ndarray, solve: Callable[[np.ndarray], Contact]) -> Contact:
    """Determine the nodes in contact by an active-set method; ``solve`` gives the solution for given nodes."""
    active = gap <= np.partition(gap, 3)[3]
    for _ in range(MAX_ROUNDS):
        contact = solve(active)
        overlap = contact.approach - gap - body.compliance @ contact.pressure
        added = ~active & (overlap > ROUNDING * abs(contact.approach))
        removed = active & (contact.pressure < 0.0)
        if not (added.any() or removed.any()):
            return contact
        active = (active & ~removed) | added
    raise ContactError(f"no set of nodes in contact found in {MAX_ROUNDS} rounds")


def unit_solutions(body: Body, gap: np.ndarray, active: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Return pressure per approach (n,) (Pa/m), pressure due to the gap (n,) (Pa), and stiffness (N/m^2)."""
    compliance = body.compliance[np.ix_(active, active)]
    pressures = np.zeros((2, len(gap)))
    pressures[:, active] = np.linalg.solve(compliance, np.column_stack([np.ones(len(compliance)), gap[active]])).T
    return pressures[0], pressures[1], float(body.spread @ pressures[0])
