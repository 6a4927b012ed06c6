"""The scenes of tests/independent/planar.py carried by the package's `planar`, with laws that only tests need."""

from typing import Any, NamedTuple

import numpy as np

from bearingsim.assemble.rest import build_static, static_model
from bearingsim.core import layout as lay
from bearingsim.core.advance import Monitor, start_at_rest
from bearingsim.core.defects.closed_forms import make_groups
from bearingsim.core.defects.depth import Rectangular
from bearingsim.core.defects.excitations import Envelope
from bearingsim.core.defects.pairs import INNER, ON_INNER, ON_OUTER, OUTER, RollerDefectPair, pack_defects
from bearingsim.core.geometry.motion import Steady
from bearingsim.core.laws.damping.hunt_crossley import HuntCrossley
from bearingsim.core.laws.damping.interface import damping_bound, normal_force, stiffness_bound
from bearingsim.core.laws.friction.curves import Frictionless, StaticDynamic
from bearingsim.core.laws.friction.interface import mu, mu_derivative_bound
from bearingsim.core.laws.stiffness.interface import elastic, tangent
from bearingsim.core.laws.stiffness.power_laws import Linear, TenNinths
from bearingsim.core.methods.rk4 import RungeKutta4
from bearingsim.core.models.equilibrium import solve_initial_equilibrium
from bearingsim.core.models.mean_equilibrium import mean_equilibrium
from bearingsim.core.models.planar import Planar
from bearingsim.core.outcomes import SUCCESS
from bearingsim.core.parameters import Bearing, Support
from bearingsim.core.parts.cage import Centred, FreeCage, OilDrag, RollerGuided
from bearingsim.core.parts.shaft import FixedRing, RigidShaft, TorsionSpring
from tests.independent import planar_scene
from tests.scenes.nf308 import advance_recorded

NO_CONTACT_PLAY = 0.01  # m: a pocket that no roller touches
ROWS = np.array(
    [
        lay.POSITION + lay.X,
        lay.POSITION + lay.Y,
        lay.VELOCITY + lay.X,
        lay.VELOCITY + lay.Y,
        lay.VELOCITY + lay.PHI_C,
        lay.Q_O,
        lay.Q_I,
    ]
)


class Unclamped(NamedTuple):
    """Hunt and Crossley's law without the clamp: it pulls when the contact opens faster than 1/chi."""

    stiffness: Any
    chi: float


@normal_force.register(Unclamped)
def _force_unclamped(contact, delta, v):
    return elastic(contact.stiffness, max(delta, 0.0)) * (1.0 + contact.chi * v)


@damping_bound.register(Unclamped)
def _damping_unclamped(contact, delta, v):
    return contact.chi * elastic(contact.stiffness, delta)


@stiffness_bound.register(Unclamped)
def _stiffness_unclamped(contact, delta, v):
    return tangent(contact.stiffness, delta) * max(1.0 + contact.chi * v, 0.0)


class RegularisedCoulomb(NamedTuple):
    """Coulomb friction, proportional to the slip below ``v`` (m/s)."""

    mu: float
    v: float


@mu.register(RegularisedCoulomb)
def _mu_zone(law, v, u):
    return law.mu * min(max(v / law.v, -1.0), 1.0)


@mu_derivative_bound.register(RegularisedCoulomb)
def _mu_derivative_bound_zone(law, u):
    return law.mu / law.v


def friction(law: Any) -> Any:
    """The package's law for a friction of the reference."""
    if law is planar_scene.frictionless:
        return Frictionless()
    if isinstance(law, planar_scene.Coulomb):
        return RegularisedCoulomb(law.mu, law.zone)
    mu_s, mu_d = float(law(0.02)), float(law(1.0))
    return StaticDynamic(mu_s, mu_d, 0.02, 0.1)


def defect_pairs(scene: planar_scene.Scene, defect: planar_scene.Defect) -> list[RollerDefectPair]:
    """A box over the full length, as each contact meets it."""
    rings: dict[Any, tuple[int, float, tuple[int, ...]]] = {
        planar_scene.OUTER: (ON_OUTER, scene.R_o, (OUTER,)),
        planar_scene.INNER: (ON_INNER, scene.R_i, (INNER,)),
    }
    carrier, radius, sides = rings.get(defect.on) or (defect.on[1], scene.R_w, (OUTER, INNER))
    reduced = {OUTER: scene.reduced(planar_scene.OUTER), INNER: scene.reduced(planar_scene.INNER)}
    return [
        RollerDefectPair(
            side,
            carrier,
            defect.angle,
            radius,
            reduced[side],
            make_groups(Rectangular(scene.L_w, defect.width, defect.depth), scene.L_w, reduced[side], 1),
        )
        for side in sides
    ]


def planar_model(scene: planar_scene.Scene) -> Planar:
    """The scene as the package's model."""
    bearing = Bearing(
        Z=scene.Z,
        R_w=scene.R_w,
        R_o=scene.R_o,
        R_i=scene.R_i,
        gap=scene.clearance / 4.0,
        m_r=scene.m_r,
        I_r=scene.roller_inertia,
        m_o=scene.m_o,
        omega_i=scene.speed,
        omega_c=scene.orbit,
        omega_b=scene.orbit - scene.spin,
        theta_0=scene.theta_0,
    )
    law = (HuntCrossley if scene.clamp else Unclamped)(TenNinths(scene.elastic.k), scene.damping.chi)
    load = complex(scene.load)
    healthy = build_static(
        bearing, Support(load.real, load.imag, 0.0, 0.0, 0.0, 0.0), law, law, pack_defects([], Envelope())
    )
    buffer = lay.make_buffer(scene.Z, scene.m_r)
    equilibrium = mean_equilibrium(healthy, buffer, samples=16)  # as many as the reference
    wall_law = HuntCrossley(Linear(max(scene.pocket_stiffness, 1.0)), scene.pocket_chi)
    cage = FreeCage(
        m=scene.cage_mass,
        inertia=scene.cage_inertia,
        play=scene.pocket_clearance / 2.0 if scene.pocket_stiffness else NO_CONTACT_PLAY,
        pocket=wall_law,
        friction=friction(scene.pocket_friction),
        guide=RollerGuided(NO_CONTACT_PLAY, wall_law) if scene.cage_moves else Centred(),
    )
    return Planar(
        bearing=bearing,
        support=Support(load.real, load.imag, scene.k_b, scene.c_b, equilibrium.x, equilibrium.y),
        outer=law,
        inner=law,
        defects=pack_defects(
            [pair for defect in scene.defects for pair in defect_pairs(scene, defect)], Envelope()
        ),
        motion=Steady(),
        friction=friction(scene.friction),
        cage=cage,
        drag=OilDrag(scene.roller_drag, scene.cage_drag, 1.0),  # zero or not: compiled once
        shaft=RigidShaft(),
        bracket=TorsionSpring(scene.ring_inertia, *scene.torsion) if scene.torsion else FixedRing(),
        gravity=0.0,
    )


def at_rest(scene: planar_scene.Scene) -> tuple[Planar, np.ndarray]:
    """The scene as the package's model, and a buffer in its static start."""
    model = planar_model(scene)
    y = lay.make_buffer(scene.Z, scene.m_r)
    assert solve_initial_equilibrium(static_model(model), 0.0, y) <= 1e-8 * abs(scene.load)
    if len(scene.eps):
        y[lay.EPS : lay.EPS + scene.Z] = scene.eps
    start_at_rest(model, 0.0, y)
    return model, y


def simulate(scene: planar_scene.Scene, duration: float, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Times (n + 1,) s and the rows PLACES (7, n + 1), from the static start by RK4, friction without lag."""
    model, y = at_rest(scene)
    steps = round(duration / step)
    out = np.empty((len(ROWS), steps + 1))
    out[:, 0] = y[ROWS]
    steps_taken, outcome, _ = advance_recorded(
        RungeKutta4(step), model, Monitor(1000, 1.0), 0, y, ROWS, out[:, 1:]
    )
    assert (steps_taken, outcome) == (steps, SUCCESS)
    return step * np.arange(steps + 1), out
