"""The planar bearing carried by EXUDYN (Gerstmayr, PyPI `exudyn`), a general multibody code, by its own contacts.

The bodies are EXUDYN's rigid bodies, every contact is its ``ObjectContactSphereSphere`` (circles, in the plane):
rollers in the hollow outer ring and on the inner ring, Hunt-Crossley damping, Coulomb friction proportional to the
slip in a zone. A slot is two points on the ring, its edges: they bear a roller between them, the race does not. So
neither the envelope nor its slope is used here. The inner ring is so heavy that it turns as prescribed.

What differs from `planar`: forces are not clamped at zero (Hunt-Crossley pulls when a contact opens faster than
1/chi), circles meet edges exactly where the envelope is a parabola, and there is no cage.

``python -m tests.independent.exudyn_planar`` writes tests/data/exudyn_planar.npz with the SCENES.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tests.independent.planar import anchor_of, start
from tests.independent.planar_scene import OUTER, Coulomb, Defect, HuntCrossley, Scene

RESULTS = Path(__file__).parents[1] / "data" / "exudyn_planar.npz"
HEAVY = 1e12  # kg, kg m^2
POINT = 1e-12  # m, the radius of an edge
SLOWEST_IMPACT = 3.0  # m/s, faster than any here, so that EXUDYN always takes this one

HEALTHY = Scene(friction=Coulomb(0.3, 0.02), friction_tilts=True, clamp=False)
SPALL = replace(HEALTHY, damping=HuntCrossley(30.0), defects=(Defect(OUTER, 2e-3, 0.5e-3),))
SCENES = {"healthy": (HEALTHY, 1e-6), "spall": (SPALL, 0.25e-6)}  # scene, step (s)
DURATION = 0.02
SAMPLING = 2e-5


class Bearing(NamedTuple):
    """A system, and the item numbers by which it is steered and read."""

    system: Any
    container: Any
    ring: int  # node
    contacts: list  # objects, all
    races: list  # objects: a roller in the outer ring
    edges: list  # objects: a roller's two contacts with the edges of a slot, or ()


def add_body(system, mass, inertia, centre, velocity, angular_velocity):
    """Return (node, body) of a rigid body of the plane at its position at t = 0."""
    from exudyn import utilities as eu

    rates = [velocity.real, velocity.imag, angular_velocity]
    node = system.AddNode(
        eu.NodeRigidBody2D(referenceCoordinates=[centre.real, centre.imag, 0.0], initialVelocities=rates)
    )
    return node, system.AddObject(eu.RigidBody2D(nodeNumber=node, mass=mass, inertia=inertia))


def add_contact(system, scene, roller, other, radius, gap=1.0, hollow=False):
    """Contact of two markers with the scene's law.

    The sign of ``gap`` is the initial contact state of EXUDYN's first step. A gap of 1 m: not active yet.
    """
    from exudyn import utilities as eu

    memory = system.AddNode(eu.NodeGenericData(initialCoordinates=[gap, 0.0, 0.0, 0.0], numberOfDataCoordinates=4))
    return system.AddObject(
        eu.ObjectContactSphereSphere(
            markerNumbers=[roller, other],
            nodeNumber=memory,
            spheresRadii=[scene.R_w, radius],
            isHollowSphere1=hollow,
            contactStiffness=scene.elastic.k,
            contactStiffnessExponent=scene.elastic.m,
            impactModel=1,
            minimumImpactVelocity=SLOWEST_IMPACT,
            dynamicFriction=scene.friction.mu,
            frictionProportionalZone=scene.friction.zone,
            activeConnector=gap < 1.0,
        )
    )


def assemble(scene) -> Bearing:
    """Assemble the system in the reference's static start, with the same positions and rates."""
    import exudyn as exu
    from exudyn import utilities as eu

    container = exu.SystemContainer()
    system = container.AddSystem()
    anchor = anchor_of(scene)
    x, v = start(scene, anchor)
    fixed = lambda body, place=(0.0, 0.0, 0.0): system.AddMarker(  # noqa: E731
        eu.MarkerBodyRigid(bodyNumber=body, localPosition=list(place))
    )

    ring, ring_body = add_body(system, scene.m_o, HEAVY, x.ring, 0j, 0.0)  # heavy: it does not turn
    _, shaft = add_body(system, HEAVY, HEAVY, 0j, 0j, scene.speed)
    on_ring, on_shaft = fixed(ring_body), fixed(shaft)
    ground = system.AddMarker(
        eu.MarkerBodyPosition(
            bodyNumber=system.AddObject(eu.ObjectGround()), localPosition=[anchor.real, anchor.imag, 0.0]
        )
    )
    bracket: Any = {"stiffness": [scene.k_b, scene.k_b, 0.0], "damping": [scene.c_b, scene.c_b, 0.0]}
    system.AddObject(eu.CartesianSpringDamper(markerNumbers=[ground, on_ring], **bracket))
    load = complex(scene.load)
    system.AddLoad(eu.Force(markerNumber=on_ring, loadVector=[-load.real, -load.imag, 0.0]))

    rims = [
        fixed(ring_body, (scene.R_o * np.cos(a), scene.R_o * np.sin(a), 0.0))
        for defect in scene.defects
        for a in (defect.angle - defect.width / 2 / scene.R_o, defect.angle + defect.width / 2 / scene.R_o)
    ]
    inner, races, edges = [], [], []
    for c, velocity in zip(x.rollers, v.rollers, strict=True):
        _, body = add_body(system, scene.m_r, scene.roller_inertia, c, velocity, scene.spin)
        marker = fixed(body)
        races.append(
            add_contact(system, scene, marker, on_ring, scene.R_o, scene.R_o - scene.R_w - abs(c - x.ring), True)
        )
        inner.append(add_contact(system, scene, marker, on_shaft, scene.R_i, abs(c) - scene.R_i - scene.R_w))
        edges.append([add_contact(system, scene, marker, rim, POINT) for rim in rims])
    contacts = [*inner, *races, *(contact for pair in edges for contact in pair)]
    return Bearing(system, container, ring, contacts, races, edges)


def set_damping(bearing, scene):
    """Gives all contacts the scene's Hunt-Crossley damping.

    EXUDYN's has chi = 1.5 (1 - restitution)/(speed of impact), the speed being that seen or a least one. Only the
    ratio enters the force, so the least speed is set above all that occur. The restitution coefficient is then
    a negative number without a meaning, which EXUDYN takes after assembly with its checks off.
    """
    import exudyn as exu

    exu.special.exceptions.parameterRangeChecks = False
    for contact in bearing.contacts:
        restitution = 1.0 - scene.damping.chi * SLOWEST_IMPACT / 1.5
        bearing.system.SetObjectParameter(contact, "restitutionCoefficient", restitution)
    exu.special.exceptions.parameterRangeChecks = True


def edge_switch(bearing, scene):
    """Return EXUDYN's callback before each step: over a slot the edges support the roller, elsewhere the race."""
    (defect,) = scene.defects
    was_inside = np.zeros(scene.Z, bool)

    def before_step(system, t):
        y = system.systemData.GetODE2CoordinatesTotal()
        centres = y[0::3] + 1j * y[1::3]  # ring, inner ring, rollers
        is_inside = (
            np.abs(np.angle((centres[2:] - centres[0]) * np.exp(-1j * defect.angle)))
            < defect.width / 2 / scene.R_o
        )
        for j in np.flatnonzero(is_inside != was_inside):
            system.SetObjectParameter(bearing.races[j], "activeConnector", not is_inside[j])
            for edge in bearing.edges[j]:
                system.SetObjectParameter(edge, "activeConnector", bool(is_inside[j]))
        was_inside[:] = is_inside
        return True

    return before_step


class Run(NamedTuple):
    """A bearing ready to be stepped, how, and its sensor of the ring's displacement."""

    bearing: Bearing
    settings: Any
    sensor: Any

    def solve(self, solver="RK44"):
        """Step through all of it with one of ``exudyn.DynamicSolverType``."""
        import exudyn as exu

        self.bearing.system.SolveDynamic(self.settings, solverType=getattr(exu.DynamicSolverType, solver))

    def displacement(self):
        """(time (n,), ring displacement (2, n), m), at the times at which EXUDYN gave its results."""
        data = self.bearing.system.GetSensorStoredData(self.sensor)
        return data[:, 0], data[:, 1:3].T


def prepare(scene, step, duration=DURATION, sampling=SAMPLING) -> Run:
    """A scene assembled, to be solved with a fixed step."""
    import exudyn as exu
    from exudyn import utilities as eu

    bearing = assemble(scene)
    system = bearing.system
    sensor = system.AddSensor(
        eu.SensorNode(
            nodeNumber=bearing.ring, storeInternal=True, outputVariableType=exu.OutputVariableType.Position
        )
    )
    if scene.defects:
        system.SetPreStepUserFunction(edge_switch(bearing, scene))
    system.Assemble()
    set_damping(bearing, scene)
    settings = exu.SimulationSettings()
    integration = settings.timeIntegration
    integration.endTime, integration.numberOfSteps = duration, round(duration / step)
    integration.adaptiveStep, integration.verboseMode = False, 0
    integration.discontinuous.iterationTolerance = 1e30  # a fixed step, never repeated
    settings.solution.sensors.writePeriod = sampling
    settings.solution.file.write = False
    return Run(bearing, settings, sensor)


def simulate(scene, step, duration=DURATION, sampling=SAMPLING):
    """(time (n,), ring displacement (2, n), m) by RK44, at the times at which EXUDYN gave its results."""
    run = prepare(scene, step, duration, sampling)
    run.solve()
    return run.displacement()


def load_results(name):
    """(time (n,), ring displacement (2, n)) of the scene as stored by ``store_results``."""
    with np.load(RESULTS) as data:
        return data["time"].astype(float), data[name].astype(float) + data[name + "_middle"][:, None]


def store_results():
    columns = {}
    for name, (scene, step) in SCENES.items():
        time, displacement = simulate(scene, step)
        mean = displacement.mean(axis=1)  # kept apart: the ring moves by a thousandth of where it stands
        columns |= {"time": time, name: (displacement - mean[:, None]).astype(np.float32), name + "_middle": mean}
    RESULTS.parent.mkdir(exist_ok=True)
    np.savez_compressed(RESULTS, **columns)


if __name__ == "__main__":
    store_results()
