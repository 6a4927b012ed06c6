"""Damping law `film`: oil film between rolling element and race, and hysteresis, as a table.

``core/laws/oil_film.py`` computes the damping of a film from the load. This module tabulates it over the approach,
with the load of the case's elastic law. The film is that of pure rolling at the speed of the case, so a case with
a ramp is rejected (``config/rules/conflicts.py``).
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
    entrainment_speed,
    equivalent_line_contact,
    film_damping,
    hysteresis_damping,
)
from bearingsim.core.laws.stiffness.interface import evaluate_law

MAX_APPROACH = 1e-4  # m, larger than in any bearing; the tabulated damping is constant above it
DIFFERENCE_STEP = 1e-5  # finite-difference step, relative to the approach
LINE_WIDTH_EXPONENT, POINT_WIDTH_EXPONENT = 0.5, 1.0 / 3.0  # of the load in the half width of a Hertzian contact


class LubricatedContact(NamedTuple):
    """Parameters of the damping of a rolling element's contact with one race.

    stiffness, other_stiffness: elastic laws of this race and of the other; point: contact of a ball, None for a
    roller; line: contact of a roller (length and radius are not used for a ball); mass: of the element (kg);
    loss_factor: of the hysteresis; at_natural_frequency: True if the film's damping is evaluated at the natural
    frequency of the element, False if at frequency 0.
    """

    stiffness: Any
    other_stiffness: Any
    point: PointContact | None
    line: LubricatedLine
    mass: float
    loss_factor: float
    at_natural_frequency: bool


def build_film_law(
    case: Case, stiffness: Any, other_stiffness: Any, point: PointContact | None, on_outer: bool
) -> Tabulated:
    """Build the contact law of one race: its stiffness law, and the tabulated damping of film and hysteresis.

    stiffness, other_stiffness: elastic laws of this race and of the other; point: contact of a ball, None for a
    roller.
    """
    b, section = case.bearing, cast(Film, case.contact.damping)
    R_w = b.roller_diameter / 2.0
    line = LubricatedLine(
        L=float(b.roller_length or 0.0),
        R=outer_reduced_radius(R_w, outer_radius(case))
        if on_outer
        else inner_reduced_radius(R_w, inner_radius(case)),
        E_star=effective_modulus(b.material.young_modulus, b.material.poisson_ratio),
        eta=section.inlet_viscosity,
        alpha=section.pressure_coefficient,
        u=entrainment_speed(case.speed, b.pitch_diameter, b.roller_diameter),
    )
    at_natural_frequency = section.at == "own"
    contact = LubricatedContact(
        stiffness, other_stiffness, point, line, b.element_mass, section.loss_factor, at_natural_frequency
    )
    return Tabulated(stiffness, tabulate_damping(contact, repr(contact)))


@lru_cache(maxsize=64)
def tabulate_damping(contact: LubricatedContact, laws: str) -> np.ndarray:
    """Return the coefficients of a table of the damping (N s/m) of a contact over its approach (m), cached.

    ``laws`` is part of the cache's key, because elastic laws of different types may be equal as tuples.
    """

    def damping_and_slope(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        delta = np.minimum(y, MAX_APPROACH)
        lower, upper = (damping(contact, delta * (1.0 + sign * DIFFERENCE_STEP)) for sign in (-1.0, 1.0))
        slope = (upper - lower) / (2.0 * DIFFERENCE_STEP * delta)
        return damping(contact, delta), np.where(y > MAX_APPROACH, 0.0, slope)

    coefficients = tabulate(damping_and_slope)
    coefficients.flags.writeable = False
    return coefficients


def damping(contact: LubricatedContact, delta: np.ndarray) -> np.ndarray:
    """Compute the damping (N s/m) of film and hysteresis at the approaches ``delta`` (m)."""
    Q, k = evaluate_law(contact.stiffness, delta)
    omega = natural_frequency(contact, Q, k)
    line, exponent = equivalent_line(contact, Q)
    c = film_damping(Q, k, line, omega if contact.at_natural_frequency else 0.0, exponent)
    return c + hysteresis_damping(k, omega, contact.loss_factor)


def natural_frequency(contact: LubricatedContact, Q: np.ndarray, k: np.ndarray) -> np.ndarray:
    """Compute the natural frequency (rad/s) of the element on the contact stiffnesses of its two races.

    Q: load (N) of both contacts; k: stiffness (N/m) of this race's contact under it.
    """
    loads, stiffnesses = evaluate_law(contact.other_stiffness, np.logspace(-12.0, -3.0, 400))
    k_other_race = np.exp(np.interp(np.log(Q), np.log(loads), np.log(stiffnesses)))
    return np.sqrt((k + k_other_race) / contact.mass)


def equivalent_line(contact: LubricatedContact, Q: np.ndarray) -> tuple[LubricatedLine, float]:
    """Return the equivalent line contact under the loads ``Q`` (N), and the exponent of Q in its half width."""
    if contact.point is None:
        return contact.line, LINE_WIDTH_EXPONENT
    a, b = contact.point.semi_axes(Q)
    L, R = equivalent_line_contact(a, b, 1.5 * Q / (pi * a * b), contact.line.E_star)
    return contact.line._replace(L=L, R=R), POINT_WIDTH_EXPONENT
