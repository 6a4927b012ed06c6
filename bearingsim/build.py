"""From a case to the core's parameters: the one place where configuration meets physics.

Imports numba (through the core), so import it only where something is computed.
"""

from functools import lru_cache
from math import ceil, pi
from typing import Any

import numpy as np

from bearingsim import config
from bearingsim.core import contact as laws
from bearingsim.core.defects import (
    ANGLE,
    INNER,
    ON,
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
from bearingsim.core.equilibrium import mean_rest
from bearingsim.core.excitations import Envelope
from bearingsim.core.kinematics import ball_spin_frequency, cage_speed
from bearingsim.core.layout import Q_O, buffer
from bearingsim.core.methods import equilibrium, rk4, verlet
from bearingsim.core.models import ring, rollers, static
from bearingsim.core.parameters import Bearing, Support

MODELS = {"static": static.KIND, "ring": ring.KIND, "rollers": rollers.KIND}
METHODS = {"verlet": verlet.KIND, "rk4": rk4.KIND, None: equilibrium.KIND}
STIFFNESS: dict[str, Any] = {"palmgren": laws.palmgren, "iso16281": laws.iso16281}


def roller_mass(bearing: config.Bearing) -> float:
    """Mass (kg) of one roller: a plain cylinder."""
    return bearing.material.density * pi / 4.0 * bearing.roller_diameter**2 * bearing.roller_length


def ring_mass(case: config.Case) -> float:
    """Mass (kg) of the outer ring: as given by the rig, else a plain tube from the race to the outside."""
    if case.rig.ring_mass is not None:
        return case.rig.ring_mass
    ring = case.bearing
    return ring.material.density * pi * ((ring.outside_diameter / 2.0) ** 2 - outer_radius(case) ** 2) * ring.width


def outer_radius(case: config.Case) -> float:
    """Radius (m) of the outer race, half of the clearance on its side."""
    return (case.bearing.pitch_diameter + case.bearing.roller_diameter) / 2.0 + case.clearance / 4.0


def inner_radius(case: config.Case) -> float:
    """Radius (m) of the inner race, half of the clearance on its side."""
    return (case.bearing.pitch_diameter - case.bearing.roller_diameter) / 2.0 - case.clearance / 4.0


def bearing(case: config.Case) -> Bearing:
    """Geometry, masses and motion of the case's bearing."""
    b, massless = case.bearing, MODELS[case.model].massless
    return Bearing(
        Z=b.rollers,
        R_w=b.roller_diameter / 2.0,
        R_o=outer_radius(case),
        R_i=inner_radius(case),
        gap=case.clearance / 4.0,
        m_r=0.0 if massless else roller_mass(b),
        m_o=float(ring_mass(case)),
        omega_i=case.speed,
        omega_c=cage_speed(case.speed, b.roller_diameter, b.pitch_diameter),
        omega_b=2.0 * pi * ball_spin_frequency(case.speed, b.roller_diameter, b.pitch_diameter),
        theta_0=case.start_angle,
    )


def contact(case: config.Case) -> Any:
    """The contact law: damping around stiffness."""
    stiffness = STIFFNESS[case.contact.stiffness](case.bearing.roller_length)
    match case.contact.damping:
        case config.HuntCrossley(chi=chi):
            return laws.HuntCrossley(stiffness, chi)
        case config.Kraemer(beta=beta):
            return laws.Kraemer(stiffness, beta)
        case config.General(coefficient=c, velocity_exponent=m2, indentation_exponent=m3):
            return laws.General(stiffness, c * 1e3 ** (m2 + m3), m2, m3)  # mm to m
    raise ValueError(f"no such damping: {case.contact.damping}")


def meetings(case: config.Case) -> Pits:
    """Where the rollers' contacts meet the case's pits."""
    R_w, R_o, R_i = case.bearing.roller_diameter / 2.0, outer_radius(case), inner_radius(case)
    reduced = {OUTER: outer_reduced_radius(R_w, R_o), INNER: inner_reduced_radius(R_w, R_i)}
    found = []
    for d in case.defects:
        on, radius, sides = {
            "outer": (ON_OUTER, R_o, (OUTER,)),
            "inner": (ON_INNER, R_i, (INNER,)),
            "roller": (d.roller - 1, R_w, (OUTER, INNER)),
        }[d.race]
        for side in sides:
            groups = groups_of(
                d.shape,
                d.length,
                d.width,
                d.depth,
                case.bearing.roller_length,
                reduced[side],
                case.contact.length_nodes,
            )
            found.append(Meeting(side, on, d.angle, radius, reduced[side], groups))
    return pits(found, Envelope())


def model(case: config.Case) -> Any:
    """The core's model of the case, its bracket anchored where the healthy bearing rests on average.

    So the load is what the bearing carries: a bracket anchored anywhere else would take a share of it.
    Raises ``NoEquilibrium`` if the healthy bearing finds no equilibrium.
    """
    of_case, law = bearing(case), contact(case)
    kind = MODELS[case.model].parameters
    x_0, y_0 = anchor(kind, of_case, law, case.load)
    support = Support(case.load, 0.0, case.rig.bracket_stiffness, case.rig.bracket_damping, x_0, y_0)
    return kind(of_case, support, law, law, meetings(case))


def anchor(kind: Any, of_case: Bearing, law: Any, load: float) -> tuple[float, float]:
    """Mean place (m, m) of the healthy, unsupported ring over a ball pass."""
    return _anchor(kind, of_case, law, repr(law), load)


@lru_cache(maxsize=256)
def _anchor(kind: Any, of_case: Bearing, law: Any, named: str, load: float) -> tuple[float, float]:
    """``anchor``, remembered; ``named`` tells laws apart that are equal as tuples."""
    free = kind(of_case, Support(load, 0.0, 0.0, 0.0, 0.0, 0.0), law, law, pits([], Envelope()))
    return mean_rest(free, empty_buffer(free))


def in_step(model: Any, steps_per_pass: int, cusp: float) -> Any:
    """The model with the cusp of its first pit ``cusp`` of a step after a step's start.

    At the cusp the damping force jumps; where in a step it does so decides whether the error is of first or of
    second order (docs/methods.md). The rollers start less than a step further on. Of several pits only the first
    is in step, and only on the outer race: what turns meets its steps anywhere, and the error averages out.
    """
    if len(model.pits.head) == 0 or model.pits.head[0, ON] != ON_OUTER:
        return model
    b, pass_angle = model.bearing, 2.0 * pi / model.bearing.Z
    steps = (b.theta_0 - model.pits.head[0, ANGLE]) / pass_angle * steps_per_pass  # whole when the cusp is met
    ahead = ceil(steps + cusp) - cusp - steps
    return model._replace(bearing=b._replace(theta_0=float(b.theta_0 + ahead * pass_angle / steps_per_pass)))


def empty_buffer(model: Any) -> np.ndarray:
    """A zeroed state buffer for the model."""
    return buffer(model.bearing.Z, model.bearing.m_r)


def outer_forces(model: Any, y: np.ndarray) -> np.ndarray:
    """Outer contact force (N) of each roller, (Z,), as the buffer has it."""
    return y[Q_O : Q_O + model.bearing.Z]


def method(case: config.Case, h: float) -> Any:
    """The core's method of the case with step ``h`` (s)."""
    return METHODS[case.method].parameters(h)
