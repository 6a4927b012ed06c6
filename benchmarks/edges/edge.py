"""A roller that crosses the edge of a slot: the elastic contact beside the product's reduced one."""

from collections.abc import Iterable
from math import inf
from typing import NamedTuple

import numpy as np

from bearingsim.core.defects.closed_forms import groups_of
from bearingsim.core.defects.depth import Rectangular
from bearingsim.core.defects.edge_contact import EdgeContact
from bearingsim.core.defects.excitations import defect_response, response_groups
from benchmarks.edges.damaged import damaged, finite_elements, half_planes, on_race, race_of
from benchmarks.edges.pressed import Body, Pressed, press, press_to
from benchmarks.edges.race import Grading, Slot, depth_at, envelope
from benchmarks.edges.steel import Pair

WIDE = 1.0  # m: width that stands for one edge alone in the reduced contact


class Crossing(NamedTuple):
    """One place of the roller. s: m behind the rim; force: N/m; lengths in m, pressure in Pa.

    approach: of the elastic contact; h: the envelope; smooth: approach on the race under this force; stiffness:
    dQ'/d(delta) over that on the race; pressure: the largest.
    """

    s: float
    force: float
    approach: float
    h: float
    smooth: float
    stiffness: float
    pressure: float

    @property
    def ratio(self) -> float:
        """Approach beyond the envelope, elastic over reduced: 1 where the reduced contact is right."""
        return (self.approach - self.h) / self.smooth


def crossed(pair: Pair, slot: Slot, body: Body, force: float, s: float) -> Crossing:
    """The contact under ``force`` (N/m), the roller's middle ``s`` (m) behind the slot's left rim."""
    return described(pair, slot, s, press(body, gap(pair, slot, body, s), force))


def crossed_at(pair: Pair, slot: Slot, body: Body, approach: float, s: float) -> Pressed:
    """The contact at ``approach`` (m)."""
    return press_to(body, gap(pair, slot, body, s), approach)


def gap(pair: Pair, slot: Slot, body: Body, s: float) -> np.ndarray:
    """(n,) m between roller and race before they are pressed."""
    return depth_at(slot, body.t) + (body.t - s) ** 2 / (2.0 * pair.R)


def described(pair: Pair, slot: Slot, s: float, found: Pressed) -> Crossing:
    """A solution with what it is compared with."""
    smooth, force = pair.approach(found.force), found.force
    ahead = pair.approach(1.001 * force) - pair.approach(0.999 * force)
    stiffness = found.stiffness * ahead / (0.002 * force)
    h = envelope(slot, pair.R, s)
    return Crossing(s, force, found.approach, h, smooth, stiffness, float(found.pressure.max()))


def bodies(pair: Pair, slot: Slot, grading: Grading | None = None, cut_out: bool = True) -> Body:
    """Roller and damaged race: the defect cut out of finite elements, or only a gap between half-planes."""
    made = damaged(slot, grading or Grading())
    return finite_elements(made, pair) if cut_out else half_planes(made, pair)


def stressed(pair: Pair, slot: Slot, force: float, places: Iterable[float]) -> list[tuple[Crossing, float]]:
    """Each contact at ``places`` (m behind the rim) with the largest von Mises stress (Pa) in the race."""
    made = damaged(slot, Grading())
    below = race_of(made, pair)
    body, found = on_race(made, pair, below), []
    for s in places:
        solved = press(body, gap(pair, slot, body, s), force)
        found.append((described(pair, slot, s, solved), below.largest_mises(solved.pressure)))
    return found


def corrected(pair: Pair, slot: Slot, reference: float, s: float) -> tuple[float, float]:
    """Share and h (m) of ``EdgeContact`` with the reference load ``reference`` (N/m)."""
    excitation = EdgeContact(reference / (np.pi * pair.E_star), pair.D, slot.rho)
    width = WIDE if slot.width == inf else slot.width
    defect = Rectangular(1.0, width, slot.depth)
    (row,) = response_groups(excitation, defect, groups_of(defect, 1.0, pair.R, 1), pair.R)
    share, h, _ = defect_response(excitation, np.array(row), s - width / 2.0, pair.R)
    return share, h


def corrected_ratio(pair: Pair, slot: Slot, reference: float, force: float, s: float) -> float:
    """What ``Crossing.ratio`` would be if ``EdgeContact`` were true, for a power law of exponent 10/9."""
    share, h = corrected(pair, slot, reference, s)
    return share**-0.9 + (h - envelope(slot, pair.R, s)) / pair.approach(force)
