"""The contact law at each race: damping around stiffness."""

from typing import Any

from bearingsim import config
from bearingsim.assemble.geometry import inner_radius, outer_radius
from bearingsim.config import Case
from bearingsim.core.laws.damping import general, hunt_crossley, kraemer
from bearingsim.core.laws.hertz import PointContact, ball_on_race
from bearingsim.core.laws.stiffness import constant, johnson, power_law, ten_ninths, three_halves


def outer(case: Case) -> Any:
    """The law at the outer race."""
    return damped(case, stiffness(case, on_outer=True))


def inner(case: Case) -> Any:
    """The law at the inner race."""
    return damped(case, stiffness(case, on_outer=False))


def powers(case: Case) -> int:
    """How many powers of the law are the library's, which leaves the vector lanes."""
    return sum(isinstance(part, power_law.PowerLaw | general.Power) for part in outer(case))


def damped(case: Case, stiffness: Any) -> Any:
    """The case's damping around a stiffness."""
    match case.contact.damping:
        case config.HuntCrossley(chi=chi):
            return hunt_crossley.HuntCrossley(stiffness, chi)
        case config.Kraemer(beta=beta):
            return kraemer.Kraemer(stiffness, beta)
        case config.General(coefficient=c, velocity_exponent=m2, indentation_exponent=m3):
            return general.general(stiffness, c * 1e3 ** (m2 + m3), m2, m3)  # mm to m
    raise ValueError(f"no such damping: {case.contact.damping}")


def stiffness(case: Case, on_outer: bool) -> Any:
    """The case's stiffness law at one race."""
    b, law = case.bearing, case.contact.stiffness
    L_w = float(b.roller_length or 0.0)  # a ball has none, and no law that asks for it
    match law:
        case config.Constant(coefficient=k, exponent=m):
            return constant.constant(k * 1e3**m, m)  # mm to m
        case "palmgren":
            return ten_ninths.palmgren(L_w)
        case "iso16281":
            return ten_ninths.iso16281(L_w)
        case "johnson":
            R_w = b.roller_diameter / 2.0
            dR = outer_radius(case) - R_w if on_outer else inner_radius(case) + R_w
            return johnson.johnson(b.material.young_modulus, b.material.poisson_ratio, L_w, dR)
        case "point":
            return three_halves.ThreeHalves(point_contact(case, on_outer).k)
    raise ValueError(f"no such stiffness: {law}")


def point_contact(case: Case, on_outer: bool) -> PointContact:
    """The contact of a ball with the groove of one race."""
    b = case.bearing
    r_g = b.outer_groove_radius if on_outer else b.inner_groove_radius
    R = -outer_radius(case) if on_outer else inner_radius(case)
    return ball_on_race(
        b.material.young_modulus, b.material.poisson_ratio, b.roller_diameter, float(r_g or 0.0), R
    )
