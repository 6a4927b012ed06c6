"""The contact law at each race: damping around stiffness."""

from math import isclose
from typing import Any

from bearingsim.assemble import film as oil
from bearingsim.assemble.geometry import inner_radius, outer_radius
from bearingsim.catalogue import LAWS, call
from bearingsim.config import Case
from bearingsim.core.laws.damping import general as multibody
from bearingsim.core.laws.damping.hunt_crossley import HuntCrossley
from bearingsim.core.laws.damping.kraemer import Kraemer
from bearingsim.core.laws.damping.tabulated import Tabulated
from bearingsim.core.laws.hertz import PointContact, ball_on_race
from bearingsim.core.laws.stiffness import johnson as line_contact
from bearingsim.core.laws.stiffness import ten_ninths
from bearingsim.core.laws.stiffness.linear import Linear
from bearingsim.core.laws.stiffness.power_law import PowerLaw
from bearingsim.core.laws.stiffness.three_halves import ThreeHalves


def outer(case: Case) -> Any:
    """The law at the outer race."""
    return damped(case, on_outer=True)


def inner(case: Case) -> Any:
    """The law at the inner race."""
    return damped(case, on_outer=False)


def powers(case: Case) -> int:
    """How many powers of the law are the library's, which leaves the vector lanes."""
    return sum(isinstance(part, PowerLaw | multibody.Power) for part in outer(case))


def damped(case: Case, on_outer: bool) -> Any:
    """The case's law at one race: ``build(case, section, stiffness, on_outer)`` of the catalogue's damping law."""
    section: Any = case.contact.damping
    return call(LAWS["damping"][section.law].build, case, section, stiffness(case, on_outer), on_outer)


def hunt_crossley(case: Case, section: Any, stiffness: Any, on_outer: bool) -> HuntCrossley:
    """Damping proportional to the elastic force."""
    return HuntCrossley(stiffness, section.chi)


def kraemer(case: Case, section: Any, stiffness: Any, on_outer: bool) -> Kraemer:
    """Damping proportional to the tangent stiffness."""
    return Kraemer(stiffness, section.damping_time)


def general(case: Case, section: Any, stiffness: Any, on_outer: bool) -> multibody.General:
    """Damping of the multibody codes, its coefficient in N, mm and s."""
    m2, m3 = section.velocity_exponent, section.indentation_exponent
    return multibody.general(stiffness, section.coefficient * 1e3 ** (m2 + m3), m2, m3)


def film(case: Case, section: Any, elastic: Any, on_outer: bool) -> Tabulated:
    """An oil film, and hysteresis."""
    point = point_contact(case, on_outer) if case.bearing.element == "ball" else None
    return oil.film(case, elastic, stiffness(case, not on_outer), point, on_outer)


def stiffness(case: Case, on_outer: bool) -> Any:
    """The case's stiffness law at one race: ``build(case, section, on_outer)`` of the catalogue's law."""
    law = LAWS["stiffness"][case.contact.elastic_law]
    return call(law.build, case, case.contact.stiffness, on_outer)


def constant(case: Case, section: Any, on_outer: bool) -> Any:
    """k delta^m, the coefficient in N and mm."""
    return power(section.coefficient * 1e3**section.exponent, section.exponent)


FASTER = ((1.0, Linear), (ten_ninths.EXPONENT, ten_ninths.TenNinths), (1.5, ThreeHalves))
"""The exponents that have a law of their own, without ``pow``."""


def power(k: float, m: float) -> Any:
    """The law k delta^m, k in N/m^m: the fastest that has this exponent."""
    for exponent, law in FASTER:
        if isclose(m, exponent, rel_tol=1e-12):
            return law(k)
    if m < 1.0:
        raise ValueError(f"exponent {m}: below 1 a contact is infinitely stiff at touch-down")
    return PowerLaw(k, m)


def palmgren(case: Case, section: Any, on_outer: bool) -> ten_ninths.TenNinths:
    """Palmgren's line contact."""
    return ten_ninths.palmgren(roller_length(case))


def iso16281(case: Case, section: Any, on_outer: bool) -> ten_ninths.TenNinths:
    """ISO/TS 16281's line contact."""
    return ten_ninths.iso16281(roller_length(case))


def johnson(case: Case, section: Any, on_outer: bool) -> line_contact.Johnson:
    """Johnson's line contact of a roller inside, or outside, a race."""
    b, R_w = case.bearing, case.bearing.roller_diameter / 2.0
    dR = outer_radius(case) - R_w if on_outer else inner_radius(case) + R_w
    return line_contact.johnson(b.material.young_modulus, b.material.poisson_ratio, roller_length(case), dR)


def point(case: Case, section: Any, on_outer: bool) -> ThreeHalves:
    """Hertz's point contact of a ball."""
    return ThreeHalves(point_contact(case, on_outer).k)


def roller_length(case: Case) -> float:
    """Length (m) of a roller; 0 of a ball, which no law of lines is given."""
    return float(case.bearing.roller_length or 0.0)


def point_contact(case: Case, on_outer: bool) -> PointContact:
    """The contact of a ball with the groove of one race."""
    b = case.bearing
    r_g = b.outer_groove_radius if on_outer else b.inner_groove_radius
    R = -outer_radius(case) if on_outer else inner_radius(case)
    return ball_on_race(
        b.material.young_modulus, b.material.poisson_ratio, b.roller_diameter, float(r_g or 0.0), R
    )
