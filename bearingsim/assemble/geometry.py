"""Geometry, masses, moments of inertia and kinematic speeds of a case's bearing."""

from math import pi

from bearingsim.catalogue import MODELS
from bearingsim.config import Case
from bearingsim.core.geometry.kinematics import ball_spin_frequency, cage_speed
from bearingsim.core.parameters import Bearing


def outer_radius(case: Case) -> float:
    """Compute the radius (m) of the outer race: half of the diametral clearance is added to its nominal diameter.

    Equation (M1) of docs/model.md.
    """
    return (case.bearing.pitch_diameter + case.bearing.roller_diameter) / 2.0 + case.clearance / 4.0


def inner_radius(case: Case) -> float:
    """Compute the radius (m) of the inner race: half of the diametral clearance reduces its nominal diameter.

    Equation (M1) of docs/model.md.
    """
    return (case.bearing.pitch_diameter - case.bearing.roller_diameter) / 2.0 - case.clearance / 4.0


def ring_mass(case: Case) -> float:
    """Return the mass (kg) of the outer ring.

    Default: that of a hollow cylinder from the race to the outside diameter.
    """
    if case.rig.ring_mass is not None:
        return case.rig.ring_mass
    b = case.bearing
    return b.material.density * pi * ((b.outside_diameter / 2.0) ** 2 - outer_radius(case) ** 2) * b.width


def roller_inertia(case: Case) -> float:
    """Compute the moment of inertia (kg m^2) of a rolling element, a solid cylinder or sphere, about its axis."""
    factor = 1.0 / 2.0 if case.bearing.element == "roller" else 2.0 / 5.0
    return factor * case.bearing.element_mass * (case.bearing.roller_diameter / 2.0) ** 2


def ring_inertia(case: Case) -> float:
    """Compute the moment of inertia (kg m^2) of the outer ring, a hollow cylinder, about its axis."""
    return ring_mass(case) * ((case.bearing.outside_diameter / 2.0) ** 2 + outer_radius(case) ** 2) / 2.0


def build_bearing(case: Case) -> Bearing:
    """Build the parameters of the case's bearing; m_r and I_r are 0 if the model does not use them."""
    b = case.bearing
    return Bearing(
        Z=b.rollers,
        R_w=b.roller_diameter / 2.0,
        R_o=outer_radius(case),
        R_i=inner_radius(case),
        gap=case.clearance / 4.0,
        m_r=b.element_mass if MODELS[case.model].has_centrifugal_load else 0.0,
        I_r=roller_inertia(case) if MODELS[case.model].has_inertia else 0.0,
        m_o=float(ring_mass(case)),
        omega_i=case.speed,
        omega_c=cage_speed(case.speed, b.roller_diameter, b.pitch_diameter),
        omega_b=2.0 * pi * ball_spin_frequency(case.speed, b.roller_diameter, b.pitch_diameter),
        theta_0=case.start_angle,
    )
