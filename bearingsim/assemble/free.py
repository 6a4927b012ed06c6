"""Parameters of ``planar``: inner ring, friction, cage, drag, shaft; assumed values for unspecified dimensions."""

from math import pi
from typing import Any

import numpy as np

from bearingsim import config
from bearingsim.assemble import geometry
from bearingsim.catalogue import LAWS, call
from bearingsim.config import Case
from bearingsim.core.geometry.motion import Ramp, Steady
from bearingsim.core.laws.damping.hunt_crossley import HuntCrossley
from bearingsim.core.laws.friction.curves import Frictionless, StaticDynamic, Traction
from bearingsim.core.laws.stiffness.power_laws import Linear
from bearingsim.core.parts import cage as cages
from bearingsim.core.parts import shaft as shafts

STANDARD_GRAVITY = 9.80665  # m/s^2
CAGE_THICKNESS = 0.35  # radial thickness over the roller's diameter (assumed)
CAGE_WIDTH = 0.7  # width over that of the bearing (assumed)
CAGE_SOLIDITY = 0.5  # share of solid material in the cage's ring, the rest being pockets (assumed)
LAND_DISTANCE = 0.35  # distance from pitch circle to guiding land over the roller's diameter (assumed)


def motion(case: Case) -> Any:
    """Build the motion of the inner ring; a ramp to the initial speed is steady."""
    if case.ramp is None or case.ramp.to == case.speed:
        return Steady()
    return Ramp(float(case.ramp.to / case.speed), float(case.ramp.time))


def friction(case: Case) -> Any:
    """Build the friction law of the contacts between rollers and races, as registered in the catalogue."""
    section: Any = case.friction
    return call(LAWS["friction"][section.law].build, section) if section else Frictionless()


def static_dynamic(section: Any) -> StaticDynamic:
    """Build the static-dynamic friction curve."""
    return StaticDynamic(section.static, section.dynamic, section.static_speed, section.dynamic_speed)


def traction(section: Any) -> Traction:
    """Build the traction curve."""
    return Traction(section.a, section.b, section.c, section.d)


def frictionless(section: Any) -> Frictionless:
    """Build the law without friction."""
    return Frictionless()


def cage_mass(case: Case) -> float:
    """Return the mass (kg) of the cage: that of the case, or else of a perforated ring of the bearing's material
    at the pitch circle.
    """
    b, mass = case.bearing, case.cage.mass if case.cage else None
    if mass is not None:
        return mass
    section = CAGE_THICKNESS * b.roller_diameter * CAGE_WIDTH * b.width
    return b.material.density * CAGE_SOLIDITY * section * pi * b.pitch_diameter


def land_radius(case: Case, on_outer: bool) -> float:
    """Return the radius (m) of the land that guides the cage, on the outer or the inner ring."""
    b = case.bearing
    return b.pitch_diameter / 2.0 + (LAND_DISTANCE if on_outer else -LAND_DISTANCE) * b.roller_diameter


def cage(case: Case) -> Any:
    """Build the cage, with its pockets and its guide."""
    c = case.cage or config.Cage()
    if c.motion == "kinematic":
        return cages.KinematicCage()
    m, law = cage_mass(case), HuntCrossley(Linear(c.pocket_stiffness), c.pocket_damping)
    friction = static_dynamic(c.friction)
    return cages.FreeCage(
        m=float(m),
        inertia=float(m * (case.bearing.pitch_diameter / 2.0) ** 2),
        play=c.pocket_clearance / 2.0,
        pocket=law,
        friction=friction,
        guide=guide(case, c, law, friction),
    )


def guide(case: Case, c: config.Cage, law: Any, friction: Any) -> Any:
    """Build the guide of the cage."""
    if c.guide == "centred":
        return cages.Centred()
    if c.guide == "rollers":
        return cages.RollerGuided(float(c.radial_pocket_clearance or c.pocket_clearance) / 2.0, law)
    on_outer = c.guide == "outer-ring"
    return cages.RingGuided(
        c.guide_clearance / 2.0, land_radius(case, on_outer), 1.0 if on_outer else 0.0, law, friction
    )


def drag(case: Case) -> Any:
    """Build the oil drag on rollers and cage."""
    d, b = case.drag, case.bearing
    if d is None:
        return cages.NoDrag()
    frontal_area = b.roller_diameter * (b.roller_length or pi / 4.0 * b.roller_diameter)
    land_width = d.land_width if d.land_width is not None else b.land_width
    R, on_outer = land_radius(case, d.land == "outer"), d.land == "outer"
    return cages.OilDrag(
        roller=0.5 * d.oil_fraction * d.oil_density * d.drag_coefficient * frontal_area,
        land=2.0 * pi * d.oil_viscosity * R**3 * land_width / d.land_gap,
        outer=1.0 if on_outer else 0.0,
    )


def shaft(case: Case) -> Any:
    """Build the support of the inner ring."""
    s, u = case.shaft, case.unbalance
    if s is None:
        return shafts.RigidShaft()
    return shafts.ElasticShaft(s.mass, s.stiffness, s.damping, u.mass_radius if u else 0.0, u.angle if u else 0.0)


def bracket(case: Case) -> Any:
    """Build the torsional support of the outer ring."""
    rig = case.rig
    if rig.torsion_stiffness is None:
        return shafts.FixedRing()
    return shafts.TorsionSpring(geometry.ring_inertia(case), rig.torsion_stiffness, rig.torsion_damping or 0.0)


def gravity(case: Case) -> float:
    """Return the gravitational acceleration (m/s^2), towards the most loaded position; 0 without gravity."""
    return STANDARD_GRAVITY if case.gravity else 0.0


def initial_pocket_angles(case: Case) -> Any:
    """Draw initial angles (Z,) of the rollers, in rad from the pocket centres; 0 without a seed or a free cage."""
    retainer = cage(case)
    if case.seed == 0 or not isinstance(retainer, cages.FreeCage):
        return 0.0
    max_angle = retainer.play / (case.bearing.pitch_diameter / 2.0)
    return np.random.default_rng(case.seed).uniform(-max_angle, max_angle, case.bearing.rollers)
