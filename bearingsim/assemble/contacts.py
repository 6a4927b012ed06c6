"""Contact law of each race: a damping law that contains a stiffness law."""

from math import isclose
from typing import Any

import numpy as np

from bearingsim.assemble import film as oil
from bearingsim.assemble.geometry import inner_radius, outer_radius
from bearingsim.catalogue import LAWS, call
from bearingsim.config import Case
from bearingsim.core.laws.damping import general as multibody
from bearingsim.core.laws.damping.hunt_crossley import HuntCrossley
from bearingsim.core.laws.damping.kraemer import Kraemer
from bearingsim.core.laws.damping.tabulated import Tabulated
from bearingsim.core.laws.hertz import PointContact, make_ball_contact
from bearingsim.core.laws.stiffness import johnson as line_contact
from bearingsim.core.laws.stiffness import power_laws
from bearingsim.core.laws.stiffness.power_laws import Linear, PowerLaw, ThreeHalves
from bearingsim.core.models.ring import DampedRates, HalfRates


def build_outer_law(case: Case) -> Any:
    """Build the contact law of the outer race."""
    return build_contact_law(case, on_outer=True)


def build_inner_law(case: Case) -> Any:
    """Build the contact law of the inner race."""
    return build_contact_law(case, on_outer=False)


def build_rate_division(case: Case) -> HalfRates | DampedRates:
    """Build the division of a massless roller's closing rate between its contacts: halves for equal laws."""
    return HalfRates() if _are_equal(build_outer_law(case), build_inner_law(case)) else DampedRates()


def _are_equal(law: Any, other: Any) -> bool:
    """Check if two laws have the same types and parameters, which ``==`` of tuples does not compare by type."""
    if type(law) is not type(other):
        return False
    if isinstance(law, tuple):
        return all(map(_are_equal, law, other))
    return bool(np.array_equal(law, other))


def count_powers(case: Case) -> int:
    """Count the terms of the contact law that call ``pow`` of the C library, which is not vectorised."""
    return sum(isinstance(part, PowerLaw | multibody.Power) for part in build_outer_law(case))


def build_contact_law(case: Case, on_outer: bool) -> Any:
    """Build the contact law of one race by ``build(case, section, stiffness, on_outer)`` of its damping law in the
    catalogue.
    """
    section: Any = case.contact.damping
    return call(LAWS["damping"][section.law].build, case, section, build_stiffness_law(case, on_outer), on_outer)


def build_hunt_crossley(case: Case, section: Any, stiffness: Any, on_outer: bool) -> HuntCrossley:
    """Build the damping law proportional to the elastic force."""
    return HuntCrossley(stiffness, section.chi)


def build_kraemer(case: Case, section: Any, stiffness: Any, on_outer: bool) -> Kraemer:
    """Build the damping law proportional to the tangent stiffness."""
    return Kraemer(stiffness, section.damping_time)


def build_general(case: Case, section: Any, stiffness: Any, on_outer: bool) -> multibody.General:
    """Build the damping law c |v|^m2 delta^m3 of multibody programs; the coefficient c is in N, mm and s."""
    m2, m3 = section.velocity_exponent, section.indentation_exponent
    return multibody.make_general(stiffness, section.coefficient * 1e3 ** (m2 + m3), m2, m3)


def build_film(case: Case, section: Any, elastic: Any, on_outer: bool) -> Tabulated:
    """Build the damping law of an oil film and hysteresis."""
    point = point_contact(case, on_outer) if case.bearing.element == "ball" else None
    return oil.build_film_law(case, elastic, build_stiffness_law(case, not on_outer), point, on_outer)


def build_stiffness_law(case: Case, on_outer: bool) -> Any:
    """Build the stiffness law of one race by its ``build(case, section, on_outer)`` in the catalogue."""
    law = LAWS["stiffness"][case.contact.elastic_law]
    return call(law.build, case, case.contact.stiffness, on_outer)


def build_constant(case: Case, section: Any, on_outer: bool) -> Any:
    """Build the stiffness law k delta^m; the coefficient k is in N and mm."""
    return build_power_law(section.coefficient * 1e3**section.exponent, section.exponent)


SPECIAL_EXPONENTS = ((1.0, Linear), (power_laws.LINE_CONTACT_EXPONENT, power_laws.TenNinths), (1.5, ThreeHalves))
"""Exponents, and the implementation of each that does not call ``pow``."""


def build_power_law(k: float, m: float) -> Any:
    """Build the stiffness law k delta^m, k in N/m^m, by the fastest implementation of its exponent.

    Raises ValueError for an exponent below 1.
    """
    for exponent, law in SPECIAL_EXPONENTS:
        if isclose(m, exponent, rel_tol=1e-12):
            return law(k)
    if m < 1.0:
        raise ValueError(f"exponent {m} is below 1: the contact would be infinitely stiff at touch-down")
    return PowerLaw(k, m)


def build_palmgren(case: Case, section: Any, on_outer: bool) -> power_laws.TenNinths:
    """Build Palmgren's line contact."""
    return power_laws.make_palmgren(roller_length(case))


def build_iso16281(case: Case, section: Any, on_outer: bool) -> power_laws.TenNinths:
    """Build the line contact of ISO/TS 16281."""
    return power_laws.make_iso16281(roller_length(case))


def build_johnson(case: Case, section: Any, on_outer: bool) -> line_contact.Johnson:
    """Build Johnson's line contact of a roller in the outer race or on the inner race."""
    b, R_w = case.bearing, case.bearing.roller_diameter / 2.0
    dR = outer_radius(case) - R_w if on_outer else inner_radius(case) + R_w
    return line_contact.make_johnson(b.material.young_modulus, b.material.poisson_ratio, roller_length(case), dR)


def build_point(case: Case, section: Any, on_outer: bool) -> ThreeHalves:
    """Build the stiffness law of a ball's Hertzian point contact."""
    return ThreeHalves(point_contact(case, on_outer).k)


def roller_length(case: Case) -> float:
    """Return the length (m) of a roller; 0 for a ball, which has no line contact."""
    return float(case.bearing.roller_length or 0.0)


def point_contact(case: Case, on_outer: bool) -> PointContact:
    """Compute the Hertzian contact of a ball and the groove of one race."""
    b = case.bearing
    groove_radius = b.outer_groove_radius if on_outer else b.inner_groove_radius
    R = -outer_radius(case) if on_outer else inner_radius(case)
    return make_ball_contact(
        b.material.young_modulus, b.material.poisson_ratio, b.roller_diameter, float(groove_radius or 0.0), R
    )
