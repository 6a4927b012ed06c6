"""Contact of a roller with the edge of a slot: elastic solution, compared with the reduced contact."""

from collections.abc import Iterable
from math import inf
from typing import NamedTuple

import numpy as np

from bearingsim.core.defects.closed_forms import make_groups
from bearingsim.core.defects.depth import Rectangular
from bearingsim.core.defects.edge_contact import EdgeContact
from bearingsim.core.defects.excitations import defect_response, response_groups
from bearingsim.core.laws.stiffness.power_laws import LINE_CONTACT_EXPONENT
from benchmarks.edges.contact import Body, Contact, press, press_to
from benchmarks.edges.race import Grading, Slot, depth_at, envelope
from benchmarks.edges.steel import Pair
from benchmarks.edges.surfaces import body_on_race, finite_elements, half_planes, race_below, slotted_surface

SINGLE_EDGE_WIDTH = 1.0  # m, width of a slot that represents one edge in the reduced contact


class Crossing(NamedTuple):
    """Contact at one position of the roller. s: m behind the rim; force: N/m; lengths in m, pressure in Pa.

    approach: of the elastic contact; h: of the envelope; smooth_approach: on the race without defect under this
    force; stiffness: dQ'/d(delta) relative to that on the race; pressure: the largest.
    """

    s: float
    force: float
    approach: float
    h: float
    smooth_approach: float
    stiffness: float
    pressure: float

    @property
    def ratio(self) -> float:
        """Approach beyond the envelope, elastic over reduced contact; 1 if the reduced contact is exact."""
        return (self.approach - self.h) / self.smooth_approach


def contact_under_force(pair: Pair, slot: Slot, body: Body, force: float, s: float) -> Crossing:
    """Solve the contact under ``force`` (N/m) with the roller centre ``s`` (m) behind the left rim of the slot."""
    return crossing_of(pair, slot, s, press(body, gap(pair, slot, body, s), force))


def contact_at_approach(pair: Pair, slot: Slot, body: Body, approach: float, s: float) -> Contact:
    """Solve the contact at ``approach`` (m)."""
    return press_to(body, gap(pair, slot, body, s), approach)


def gap(pair: Pair, slot: Slot, body: Body, s: float) -> np.ndarray:
    """Compute the gap (n,) (m) between the undeformed roller and race."""
    return depth_at(slot, body.t) + (body.t - s) ** 2 / (2.0 * pair.R)


def crossing_of(pair: Pair, slot: Slot, s: float, contact: Contact) -> Crossing:
    """Compare a solution with the reduced contact."""
    smooth_approach, force = pair.approach(contact.force), contact.force
    difference = pair.approach(1.001 * force) - pair.approach(0.999 * force)
    stiffness = contact.stiffness * difference / (0.002 * force)
    h = envelope(slot, pair.R, s)
    return Crossing(s, force, contact.approach, h, smooth_approach, stiffness, float(contact.pressure.max()))


def make_body(pair: Pair, slot: Slot, grading: Grading | None = None, cut_out: bool = True) -> Body:
    """Combine roller and race, with the defect cut out of finite elements or as a gap between half-planes."""
    surface = slotted_surface(slot, grading or Grading())
    return finite_elements(surface, pair) if cut_out else half_planes(surface, pair)


def contact_stresses(
    pair: Pair, slot: Slot, force: float, positions: Iterable[float]
) -> list[tuple[Crossing, float]]:
    """Return contact and largest von Mises stress (Pa) in the race at each position (m behind the rim)."""
    surface = slotted_surface(slot, Grading())
    race = race_below(surface, pair)
    body, results = body_on_race(surface, pair, race), []
    for s in positions:
        contact = press(body, gap(pair, slot, body, s), force)
        results.append((crossing_of(pair, slot, s, contact), race.largest_mises(contact.pressure)))
    return results


def edge_contact_response(pair: Pair, slot: Slot, reference: float, s: float) -> tuple[float, float]:
    """Return share and h (m) of ``EdgeContact`` for the reference load ``reference`` (N/m)."""
    excitation = EdgeContact(reference / (np.pi * pair.E_star), pair.D, slot.rho, LINE_CONTACT_EXPONENT)
    width = SINGLE_EDGE_WIDTH if slot.width == inf else slot.width
    defect = Rectangular(1.0, width, slot.depth)
    (row,) = response_groups(excitation, defect, make_groups(defect, 1.0, pair.R, 1), pair.R)
    share, h, _ = defect_response(excitation, np.array(row), s - width / 2.0, pair.R)
    return share, h


def corrected_ratio(pair: Pair, slot: Slot, reference: float, force: float, s: float) -> float:
    """Compute ``Crossing.ratio`` as predicted by ``EdgeContact``, for a power law of exponent 10/9."""
    share, h = edge_contact_response(pair, slot, reference, s)
    return share**-0.9 + (h - envelope(slot, pair.R, s)) / pair.approach(force)
