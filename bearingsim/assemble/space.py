"""Parameters of ``spatial`` that ``planar`` does not have: slices, profile, mounts, flanges, cage in space."""

from math import cos, sin
from typing import Any

from bearingsim import config
from bearingsim.assemble import free, geometry
from bearingsim.assemble.contacts import roller_length
from bearingsim.catalogue import MODELS
from bearingsim.config import Case
from bearingsim.config.rules.completion import slice_ends
from bearingsim.core.geometry import slices as cut
from bearingsim.core.laws.damping.hunt_crossley import HuntCrossley
from bearingsim.core.laws.stiffness.power_laws import Linear
from bearingsim.core.parts import flanges as shoulders
from bearingsim.core.parts.cage import KinematicCage
from bearingsim.core.parts.cage_in_space import CageInPlane, CageInSpace
from bearingsim.core.parts.mounts import ElasticMount, RigidMount

FLANGE_HEIGHT = 0.2  # default height of a flange, relative to the roller's diameter (assumed)


def build_slices(case: Case) -> cut.Slices:
    """Divide a roller into slices, each with the drop of the roller's profile."""
    return cut.make_slices(slice_ends(case), lambda z: profile_drop(case, z))


def profile_drop(case: Case, z: float) -> float:
    """Compute the reduction (m) of the roller's radius by its profile at ``z`` (m) from its centre."""
    b = case.bearing
    L_w, profile = roller_length(case), b.roller_profile
    match profile.shape:
        case "crowned":
            return cut.crowned_drop(z, L_w, profile.straight_length or 0.0, profile.drop or 0.0)
        case "logarithmic":
            return cut.logarithmic_drop(z, L_w, b.roller_diameter)
    return 0.0


def unevenly_loaded(case: Case) -> bool:
    """Check if the rollers of the healthy bearing are loaded unevenly along their length.

    They are in a model with sliced rollers if the case has a misalignment or a roller profile.
    """
    return MODELS[case.model].sliced and (
        case.misalignment is not None or case.bearing.roller_profile.shape != "straight"
    )


def transverse_roller_inertia(case: Case) -> float:
    """Compute the transverse moment of inertia (kg m^2) of a roller, a cylinder, about a diameter."""
    b = case.bearing
    return b.element_mass * (3.0 * (b.roller_diameter / 2.0) ** 2 + roller_length(case) ** 2) / 12.0


def transverse_inertia(case: Case, m: float, about_axis: float) -> float:
    """Compute the transverse moment of inertia (kg m^2) of a ring about a diameter.

    m: mass of the ring (kg), which has the bearing's width; about_axis: moment of inertia about its axis (kg m^2).
    """
    return about_axis / 2.0 + m * case.bearing.width**2 / 12.0


def build_outer_mount(case: Case) -> Any:
    """Build the axial and tilting support of the outer ring by the bracket."""
    return build_mount(case, case.rig, "outer", geometry.ring_mass(case), geometry.ring_inertia(case))


def build_inner_mount(case: Case) -> Any:
    """Build the axial and tilting support of the inner ring by the shaft, with the mass of both."""
    m = case.shaft.mass if case.shaft else 0.0
    about_axis = m * ((case.bearing.bore / 2.0) ** 2 + geometry.inner_radius(case) ** 2) / 2.0
    return build_mount(case, case.shaft, "inner", m, about_axis)


def build_mount(
    case: Case, support: config.Rig | config.Shaft | None, ring: str, m: float, about_axis: float
) -> Any:
    """Build the axial and tilting support of a ring, rigid unless both stiffnesses are given, with misalignment.

    ring: `outer` or `inner`; m: mass (kg); about_axis: moment of inertia about the ring's axis (kg m^2).
    """
    misalignment = case.misalignment
    tilt = sin(getattr(misalignment, ring)) if misalignment else 0.0
    direction = misalignment.direction if misalignment else 0.0
    tilt_x, tilt_y = float(tilt * cos(direction)), float(tilt * sin(direction))
    if support is None or support.axial_stiffness is None or support.tilting_stiffness is None:
        return RigidMount(tilt_x, tilt_y)
    return ElasticMount(
        m=float(m),
        I_a=float(about_axis),
        I_t=float(transverse_inertia(case, m, about_axis)),
        k_z=support.axial_stiffness,
        c_z=support.axial_damping or 0.0,
        k_tilt=support.tilting_stiffness,
        c_tilt=support.tilting_damping or 0.0,
        tilt_x=tilt_x,
        tilt_y=tilt_y,
    )


def build_flanges(case: Case) -> Any:
    """Build the flanges of both rings; a single flange of a ring is on its +z side.

    There are none with a kinematic cage, because it prescribes the axial position of a roller. A flange of a
    tilted ring could not displace the roller and would clamp it.
    """
    f, b = case.bearing.flanges, case.bearing
    if f is None or f.inner + f.outer == 0 or isinstance(free.build_cage(case), KinematicCage):
        return shoulders.NoFlanges()
    return shoulders.Flanges(
        inner_minus=1.0 if f.inner > 1 else 0.0,
        inner_plus=1.0 if f.inner > 0 else 0.0,
        outer_minus=1.0 if f.outer > 1 else 0.0,
        outer_plus=1.0 if f.outer > 0 else 0.0,
        play=f.clearance / 2.0,
        height=f.height or FLANGE_HEIGHT * b.roller_diameter,
        law=HuntCrossley(Linear(f.stiffness), f.damping),
        friction=free.build_friction(case),
    )


def build_cage_in_space(case: Case) -> Any:
    """Build the axial and tilting motion of the cage, with contacts of rollers and ends of pockets."""
    cage, c = free.build_cage(case), case.cage or config.Cage()
    if isinstance(cage, KinematicCage):
        return CageInPlane()
    width = free.CAGE_WIDTH * case.bearing.width
    about_diameter = cage.inertia / 2.0 + cage.m * width**2 / 12.0
    return CageInSpace(float(about_diameter), c.axial_clearance / 2.0, cage.pocket)
