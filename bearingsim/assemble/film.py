"""Damping law `film`: oil film between rolling element and race, plus hysteresis, as a table.

``core/laws/oil_film.py`` gives the damping of a film under a load; this module tabulates it over the approach with
the elastic law in use. Rollers roll without slip at the speed of the case, which has no ramp.
"""

from functools import lru_cache
from math import pi
from typing import Any, NamedTuple, cast

import numpy as np

from bearingsim.assemble.geometry import inner_radius, outer_radius
from bearingsim.config import Case, Film
from bearingsim.core.defects.pairs import inner_reduced_radius, outer_reduced_radius
from bearingsim.core.laws.damping.tabulated import Tabulated
from bearingsim.core.laws.hertz import PointContact, effective_modulus
from bearingsim.core.laws.octaves import tabulate
from bearingsim.core.laws.oil_film import (
    LubricatedLine,
    ball_as_strip,
    entrainment_speed,
    film_damping,
    hysteresis,
)
from bearingsim.core.laws.stiffness.interface import curve

MAX_APPROACH = 1e-4  # m, largest approach of the table, larger than in any bearing; damping is constant above it
DIFFERENCE = 1e-5  # finite-difference step, relative to the approach
LINE, STRIP = 0.5, 1.0 / 3.0  # exponents of the load in the half widths of rollers and of balls


class LubricatedContact(NamedTuple):
    """Parameters of the damping of one contact.

    stiffness, other: elastic laws of this race and of the other; point: contact of a ball, None for a roller;
    line: contact of a roller (for a ball its length and radius are not used); mass: mass of the element (kg);
    at_natural_frequency: whether the film is evaluated at the element's natural frequency, not at frequency 0.
    """

    stiffness: Any
    other: Any
    point: PointContact | None
    line: LubricatedLine
    mass: float
    loss_factor: float
    at_natural_frequency: bool


def film(case: Case, stiffness: Any, other: Any, point: PointContact | None, on_outer: bool) -> Tabulated:
    """Build the contact law of one race; point: contact of a ball, None for a roller."""
    b, section = case.bearing, cast(Film, case.contact.damping)
    reduced, race = (outer_reduced_radius, outer_radius) if on_outer else (inner_reduced_radius, inner_radius)
    line = LubricatedLine(
        L=float(b.roller_length or 0.0),
        R=reduced(b.roller_diameter / 2.0, race(case)),
        E_star=effective_modulus(b.material.young_modulus, b.material.poisson_ratio),
        eta=section.inlet_viscosity,
        alpha=section.pressure_coefficient,
        u=entrainment_speed(case.speed, b.pitch_diameter, b.roller_diameter),
    )
    at_natural_frequency = section.at == "own"
    contact = LubricatedContact(
        stiffness, other, point, line, b.element_mass, section.loss_factor, at_natural_frequency
    )
    return Tabulated(stiffness, table(contact, repr(contact)))


@lru_cache(maxsize=64)
def table(contact: LubricatedContact, laws: str) -> np.ndarray:
    """Tabulate c (N s/m) over the approach (m), cached; ``laws`` distinguishes laws that are equal as tuples."""

    def with_derivative(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        delta = np.minimum(y, MAX_APPROACH)
        lower, upper = (damping(contact, delta * (1.0 + sign * DIFFERENCE)) for sign in (-1.0, 1.0))
        constant = y > MAX_APPROACH
        return damping(contact, delta), np.where(constant, 0.0, (upper - lower) / (2.0 * DIFFERENCE * delta))

    rows = tabulate(with_derivative)
    rows.flags.writeable = False
    return rows


def damping(contact: LubricatedContact, delta: np.ndarray) -> np.ndarray:
    """Compute c (N s/m) of film and hysteresis at approaches ``delta`` (m)."""
    Q, k = curve(contact.stiffness, delta)
    omega = natural_frequency(contact, Q, k)
    line, exponent = lubricated_line(contact, Q)
    c = film_damping(Q, k, line, omega if contact.at_natural_frequency else 0.0, exponent)
    return c + hysteresis(k, omega, contact.loss_factor)


def natural_frequency(contact: LubricatedContact, Q: np.ndarray, k: np.ndarray) -> np.ndarray:
    """Compute the natural frequency (rad/s) of the element between its races, both under the loads ``Q`` (N)."""
    loads, stiffnesses = curve(contact.other, np.logspace(-12.0, -3.0, 400))
    k_other = np.exp(np.interp(np.log(Q), np.log(loads), np.log(stiffnesses)))
    return np.sqrt((k + k_other) / contact.mass)


def lubricated_line(contact: LubricatedContact, Q: np.ndarray) -> tuple[LubricatedLine, float]:
    """Return the equivalent line contact under the loads ``Q`` (N), and the exponent of the load in the formula
    of its half width.
    """
    if contact.point is None:
        return contact.line, LINE
    a, b = contact.point.semi_axes(Q)
    L, R = ball_as_strip(a, b, 1.5 * Q / (pi * a * b), contact.line.E_star)
    return contact.line._replace(L=L, R=R), STRIP
