"""Where rollers meet the case's pits, and what they feel of them."""

from typing import Any

from bearingsim import config
from bearingsim.build.contacts import point_contact
from bearingsim.build.geometry import inner_radius, outer_radius
from bearingsim.build.rest import largest_load
from bearingsim.config import Case
from bearingsim.core import excitations as felt
from bearingsim.core.defects import (
    INNER,
    ON_INNER,
    ON_OUTER,
    OUTER,
    Meeting,
    Pits,
    groups_of,
    inner_reduced_radius,
    outer_reduced_radius,
    pits,
)

EXCITATIONS: dict[str, Any] = {
    "envelope": felt.Envelope(),
    "rectangular-pulse": felt.RectangularPulse(),
    "half-sine-pulse": felt.HalfSinePulse(),
    "piecewise-pulse": felt.PiecewisePulse(),
    "clearance-increase": felt.ClearanceIncrease(),
    "soft-edge": felt.SoftEdge(),
    "impulse-train": felt.Envelope(),
    "random-impulses": felt.Envelope(),
}


def meetings(case: Case) -> Pits:
    """Where the rollers' contacts meet the case's pits."""
    chosen = excitation(case)
    return pits([one for defect in case.defects for one in of_defect(case, defect, chosen)], chosen)


def excitation(case: Case) -> Any:
    """What a roller of the case feels of a pit."""
    if case.excitation == "pressure-share":
        return felt.PressureShare(half_width(case))
    return EXCITATIONS[case.excitation]


def reduced_radius(case: Case, side: int) -> float:
    """Radius (m) of a roller relative to the race on one side of it."""
    R_w = case.bearing.roller_diameter / 2.0
    if side == OUTER:
        return outer_reduced_radius(R_w, outer_radius(case))
    return inner_reduced_radius(R_w, inner_radius(case))


def half_width(case: Case) -> float:
    """Half width (m) of the outer contact along rolling, under the largest load of the healthy bearing."""
    load = largest_load(case)
    if case.bearing.element == "ball":
        return point_contact(case, on_outer=True).semi_axes(load)[1]
    steel = case.bearing.material
    length, R = float(case.bearing.roller_length or 0.0), reduced_radius(case, OUTER)
    return felt.hertz_half_width(load, length, R, steel.young_modulus, steel.poisson_ratio)


def contact_length(case: Case, side: int) -> float:
    """Length (m) of the contact along the axis: the roller's; of a ball its ellipse's at the largest load."""
    if case.bearing.roller_length is not None:
        return case.bearing.roller_length
    return 2.0 * point_contact(case, side == OUTER).semi_axes(largest_load(case))[0]


def of_defect(case: Case, d: config.Defect, chosen: Any) -> list[Meeting]:
    """A pit as each contact meets it."""
    on, radius, sides = {
        "outer": (ON_OUTER, outer_radius(case), (OUTER,)),
        "inner": (ON_INNER, inner_radius(case), (INNER,)),
        "roller": ((d.roller or 1) - 1, case.bearing.roller_diameter / 2.0, (OUTER, INNER)),
    }[d.race]
    return [
        Meeting(side, on, d.angle, radius, reduced_radius(case, side), cut(case, d, chosen, side))
        for side in sides
    ]


def cut(case: Case, d: config.Defect, chosen: Any, side: int) -> list:
    """The groups along the contact that a pit is cut into."""
    L_w, R, nodes = contact_length(case, side), reduced_radius(case, side), case.contact.length_nodes
    return felt.groups(chosen, d.shape, groups_of(d.shape, d.length, d.width, d.depth, L_w, R, nodes), R)
