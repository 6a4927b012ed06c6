"""Parameters of ``planar`` that simpler models do not have: inner ring, friction, cage, drag and shaft.

Dimensions that the case does not specify have assumed values.
"""

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
CAGE_THICKNESS = 0.35  # radial thickness of the cage, relative to the roller's diameter (assumed)
CAGE_WIDTH = 0.7  # width of the cage, relative to that of the bearing (assumed)
CAGE_SOLIDITY = 0.5  # fraction of the cage's ring that is material; the rest is pockets (assumed)
LAND_DISTANCE = 0.35  # distance of the land from the pitch circle, relative to the roller's diameter (assumed)


def build_motion(case: Case) -> Any:
    """Build the motion of the inner ring: steady, or a ramp to another speed."""
    if case.ramp is None or case.ramp.to == case.speed:
        return Steady()
    return Ramp(float(case.ramp.to / case.speed), float(case.ramp.time))


def build_friction(case: Case) -> Any:
    """Build the friction law of rollers on races by its ``build(section)`` in the catalogue."""
    section: Any = case.friction
    return call(LAWS["friction"][section.law].build, section) if section else Frictionless()


def build_static_dynamic(section: Any) -> StaticDynamic:
    """Build the static-dynamic friction curve."""
    return StaticDynamic(section.static, section.dynamic, section.static_speed, section.dynamic_speed)


def build_traction(section: Any) -> Traction:
    """Build the traction curve."""
    return Traction(section.a, section.b, section.c, section.d)


def build_frictionless(section: Any) -> Frictionless:
    """Build the law without friction."""
    return Frictionless()


def cage_mass(case: Case) -> float:
    """Return the mass (kg) of the cage.

    Unless the case specifies it, it is that of a perforated ring of the bearing's material on the pitch circle.
    """
    b, mass = case.bearing, case.cage.mass if case.cage else None
    if mass is not None:
        return mass
    cross_section = CAGE_THICKNESS * b.roller_diameter * CAGE_WIDTH * b.width
    return b.material.density * CAGE_SOLIDITY * cross_section * pi * b.pitch_diameter


def land_radius(case: Case, on_outer: bool) -> float:
    """Return the radius (m) of the land that guides the cage, on the outer or the inner ring."""
    b = case.bearing
    return b.pitch_diameter / 2.0 + (LAND_DISTANCE if on_outer else -LAND_DISTANCE) * b.roller_diameter


def build_cage(case: Case) -> Any:
    """Build the cage with its pockets and its guidance."""
    c = case.cage or config.Cage()
    if c.motion == "kinematic":
        return cages.KinematicCage()
    m, law = cage_mass(case), HuntCrossley(Linear(c.pocket_stiffness), c.pocket_damping)
    friction = build_static_dynamic(c.friction)
    return cages.FreeCage(
        m=float(m),
        inertia=float(m * (case.bearing.pitch_diameter / 2.0) ** 2),
        play=c.pocket_clearance / 2.0,
        pocket=law,
        friction=friction,
        guide=build_guide(case, c, law, friction),
    )


def build_guide(case: Case, c: config.Cage, law: Any, friction: Any) -> Any:
    """Build the guidance of the cage, with the contact law and friction of its contacts."""
    if c.guide == "centred":
        return cages.Centred()
    if c.guide == "rollers":
        return cages.RollerGuided(float(c.radial_pocket_clearance or c.pocket_clearance) / 2.0, law)
    on_outer = c.guide == "outer-ring"
    return cages.RingGuided(
        c.guide_clearance / 2.0, land_radius(case, on_outer), 1.0 if on_outer else 0.0, law, friction
    )


def build_drag(case: Case) -> Any:
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


def build_shaft(case: Case) -> Any:
    """Build the radial support of the inner ring by the shaft."""
    s, u = case.shaft, case.unbalance
    if s is None:
        return shafts.RigidShaft()
    return shafts.ElasticShaft(s.mass, s.stiffness, s.damping, u.mass_radius if u else 0.0, u.angle if u else 0.0)


def build_bracket(case: Case) -> Any:
    """Build the torsional support of the outer ring."""
    rig = case.rig
    if rig.torsion_stiffness is None:
        return shafts.FixedRing()
    return shafts.TorsionSpring(geometry.ring_inertia(case), rig.torsion_stiffness, rig.torsion_damping or 0.0)


def gravity(case: Case) -> float:
    """Return the gravitational acceleration (m/s^2), which acts along the load line; 0 if the case excludes it."""
    return STANDARD_GRAVITY if case.gravity else 0.0


def initial_pocket_angles(case: Case) -> Any:
    """Draw the initial angles (Z,) of the rollers from their pockets' centres (rad).

    They are zero if the seed is 0 or the cage is kinematic.
    """
    cage = build_cage(case)
    if case.seed == 0 or not isinstance(cage, cages.FreeCage):
        return 0.0
    max_angle = cage.play / (case.bearing.pitch_diameter / 2.0)
    return np.random.default_rng(case.seed).uniform(-max_angle, max_angle, case.bearing.rollers)
