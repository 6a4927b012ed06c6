"""Outer ring in static equilibrium over a ball pass: shape, rollers, springs, loads, defects, sensor."""

from collections.abc import Iterator
from math import pi
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bearingsim.plots.labels import PlotError

if TYPE_CHECKING:
    from bearingsim.config import Case

FRACTIONS = (0.0, 0.25, 0.5, 0.75)
"""Instants shown, as fractions of a ball pass after a roller passes the first defect of the outer race, or without
one the load line."""
MAX_RESIDUAL = 1e-6  # largest residual force of an equilibrium, relative to the load

Reals = NDArray[np.float64]


class AppliedForce(NamedTuple):
    """Applied force (N), inwards at an angle (rad)."""

    angle: float
    force: float


class DefectMark(NamedTuple):
    """Angular position and width of a defect at some instant.

    on: element that carries it, `outer`, `inner` or `roller`; angle: of its centre (rad) around the centre of that
    element; half: half its angular width (rad) around it; roller: index of the roller.
    """

    on: str
    angle: float
    half: float
    roller: int = 0


class Instant(NamedTuple):
    """Bearing in static equilibrium at a cage angle. Lengths in m, forces in N, angles in rad from the load line.

    fraction: part of the ball pass; x, y: position of the ring; n, a, b: (N,) numbers of its harmonics, amplitudes
    of cosine and sine, empty for a rigid ring; angles, outwards, forces: (Z,) of the rollers, their angle, their
    outward displacement from the pitch circle (without the drop into a defect of the outer race), and their force
    on the outer race; loaded: (Z,) True for a roller loaded by both races; springs: (P,) their forces; carrier:
    position of the body that supports the springs; marks: the defects.
    """

    fraction: float
    x: float
    y: float
    n: Reals
    a: Reals
    b: Reals
    angles: Reals
    outwards: Reals
    forces: Reals
    loaded: NDArray[np.bool_]
    springs: Reals
    carrier: tuple[float, float]
    marks: tuple[DefectMark, ...]

    def bending(self, angles: Reals) -> Reals:
        """Compute the outward bending displacement (m) of the ring at some angles."""
        phases = np.multiply.outer(np.asarray(angles), self.n)
        return np.asarray(np.cos(phases) @ self.a + np.sin(phases) @ self.b)

    def displacement(self, angles: Reals) -> Reals:
        """Compute the outward displacement (m) of the ring at some angles: bending plus rigid body."""
        return self.bending(angles) + self.x * np.cos(angles) + self.y * np.sin(angles)


class RingShape(NamedTuple):
    """Ring of a case in static equilibrium over a ball pass. Lengths in m, angles in rad from the load line.

    bends: True for a flexible ring; pitch, roller, outside: radii of the pitch circle, of a roller, and outer
    radius of the ring; gap: a quarter of the diametral clearance; by: `load.by` of the rig, or `rigid`;
    applied_forces: those on the ring, or on the carrier if there are springs; spring_angles: (P,); sensor: its
    angle; sensor_on: `ring` or `housing`.
    """

    bends: bool
    pitch: float
    roller: float
    outside: float
    gap: float
    by: str
    applied_forces: tuple[AppliedForce, ...]
    spring_angles: Reals
    sensor: float
    sensor_on: str
    instants: tuple[Instant, ...]

    def largest(self) -> float:
        """Compute the largest displacement (m) of ring, rollers and carrier over all instants."""
        around = np.linspace(-pi, pi, 721)
        displacements = [self.gap]
        for instant in self.instants:
            displacements += [
                np.abs(instant.displacement(around)).max(),
                np.abs(instant.outwards).max(),
                float(np.hypot(*instant.carrier)),
            ]
        return float(max(displacements))


def ring_shape(case: "Case", fractions: tuple[float, ...] = FRACTIONS) -> RingShape:
    """Compute the outer ring of a case in static equilibrium at some ``fractions`` of a ball pass.

    Raises PlotError for a model without load or a case without equilibrium.
    """
    from bearingsim import assemble
    from bearingsim.catalogue import MODELS
    from bearingsim.core.models.equilibrium import NoEquilibrium

    if not MODELS[case.model].loaded:
        raise PlotError(f"the model `{case.model}` has no loaded rollers, so there is no ring at rest to draw")
    try:
        model = assemble.model(case)
        instants = tuple(_instants(case, model, fractions))
    except NoEquilibrium as error:
        raise PlotError(str(error)) from None
    b, rig, bent = case.bearing, case.rig, _bending(model)
    springs = _spring_angles(bent)
    return RingShape(
        bends=bent is not None,
        pitch=b.pitch_diameter / 2.0,
        roller=b.roller_diameter / 2.0,
        outside=b.outside_diameter / 2.0,
        gap=case.clearance / 4.0,
        by=rig.load.by if bent is not None and rig.load is not None else "rigid",
        applied_forces=tuple(_applied_forces(case)),
        spring_angles=springs,
        sensor=rig.sensor_angle,
        sensor_on=rig.sensor.on,
        instants=instants,
    )


def _bending(model: Any) -> Any:
    """Return the bending part of a model; None for a rigid ring."""
    from bearingsim.core.parts.bending import Bending

    part = getattr(model, "bending", None)
    return part if isinstance(part, Bending) else None


def _spring_angles(bent: Any) -> Reals:
    """Compute the angles (P,) in rad of the springs around a ring."""
    from bearingsim.core.parts.bending import SPRING_COS, SPRING_SIN, Springs

    if bent is None or not isinstance(bent.springs, Springs):
        return np.zeros(0)
    real = bent.springs.transposed_shapes.shape[1]
    return np.asarray(
        np.arctan2(bent.springs.spring_table[SPRING_SIN, :real], bent.springs.spring_table[SPRING_COS, :real])
    )


def _applied_forces(case: "Case") -> Iterator[AppliedForce]:
    """Yield the applied loads: at the load line, or distributed over the pads, and the transverse load."""
    pads = case.rig.load.angles if case.rig.ring is not None and case.rig.load is not None else None
    angles = np.asarray(pads or (0.0,))
    for angle in angles:
        yield AppliedForce(float(angle), float(case.load / np.cos(angles).sum()))
    if case.load_across:
        side = pi / 2.0 if case.load_across > 0.0 else -pi / 2.0
        yield AppliedForce(side, abs(case.load_across))


def _instants(case: "Case", model: Any, fractions: tuple[float, ...]) -> Iterator[Instant]:
    """Yield the bearing in equilibrium at each fraction of a ball pass."""
    from bearingsim import assemble

    y, bearing = assemble.empty_buffer(model), model.bearing
    ball_pass = 2.0 * pi / (bearing.Z * bearing.omega_c)
    load = float(np.hypot(case.load, case.load_across))
    for fraction in fractions:
        t = _begin(model) + fraction * ball_pass
        residual = assemble.find_equilibrium(model, t, y, from_scratch=True)
        if not residual <= MAX_RESIDUAL * load:
            raise PlotError(f"no static equilibrium: residual force {residual:g} N at a load of {load:g} N")
        yield _read(model, t, y, fraction)


def _begin(model: Any) -> float:
    """Compute the first time (s) of a roller over the first defect of the outer race, or at the load line."""
    from bearingsim.core.defects.pairs import ANGLE, CARRIER, ON_OUTER

    defect_angles = [float(row[ANGLE]) for row in model.defects.head if row[CARRIER] == ON_OUTER]
    ahead = ((defect_angles or [0.0])[0] - model.bearing.theta_0) % (2.0 * pi / model.bearing.Z)
    return float(ahead / model.bearing.omega_c)


def _read(model: Any, t: float, y: np.ndarray, fraction: float) -> Instant:
    """Extract an instant from the buffer of a bearing in equilibrium at ``t`` (s)."""
    from bearingsim.core import layout as lay

    Z, bent = model.bearing.Z, _bending(model)
    rows = (lay.COS, lay.SIN, lay.RADIAL, lay.DELTA_O, lay.Q_O, lay.Q_I)
    cosines, sines, outwards, approach, outer, inner = (y[row : row + Z].copy() for row in rows)
    n, a, b = _amplitudes(bent, y)
    angles = np.arctan2(sines, cosines)
    springs, carrier = _springs(bent, y)
    instant = Instant(
        fraction=fraction,
        x=float(y[lay.POSITION + lay.X]),
        y=float(y[lay.POSITION + lay.Y]),
        n=n,
        a=a,
        b=b,
        angles=angles,
        outwards=outwards,
        forces=outer,
        loaded=(outer > 0.0) & (inner > 0.0),
        springs=springs,
        carrier=carrier,
        marks=tuple(_marks(model, t, angles)),
    )
    touching = instant.displacement(angles) + model.bearing.gap + np.maximum(approach, 0.0)
    return instant._replace(outwards=np.minimum(outwards, touching))


def _amplitudes(bent: Any, y: np.ndarray) -> tuple[Reals, Reals, Reals]:
    """Return harmonic numbers and cosine and sine amplitudes (m) of the ring, without those of the carrier."""
    from bearingsim.core import layout as lay
    from bearingsim.core.parts.bending import ORDER

    if bent is None:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    real = bent.breathing_index + 1
    first_c, first_s = lay.POSITION + lay.MODES_C, lay.POSITION + lay.MODES_S
    return (
        bent.harmonic_table[ORDER, :real].copy(),
        y[first_c : first_c + real].copy(),
        y[first_s : first_s + real].copy(),
    )


def _springs(bent: Any, y: np.ndarray) -> tuple[Reals, tuple[float, float]]:
    """Return the spring forces (P,) in N and the position (m, m) of the carrier around them."""
    from bearingsim.core import layout as lay
    from bearingsim.core.parts.bending import supported_position

    count = len(_spring_angles(bent))
    if not count:
        return np.zeros(0), (0.0, 0.0)
    x, z = supported_position(bent.springs, y)
    return y[lay.SPRING_FORCE : lay.SPRING_FORCE + count].copy(), (float(x), float(z))


def _marks(model: Any, t: float, angles: Reals) -> Iterator[DefectMark]:
    """Yield the positions of the defects at ``t`` (s)."""
    from bearingsim.core.defects.pairs import ANGLE, CARRIER, HALF_WIDTH, ON_INNER, ON_OUTER, OUTER, RADIUS, SIDE

    bearing = model.bearing
    for row in model.defects.head:
        on, angle, half = row[CARRIER], float(row[ANGLE]), float(row[HALF_WIDTH] / row[RADIUS])
        if on == ON_OUTER:
            yield DefectMark("outer", angle, half)
        elif on == ON_INNER:
            yield DefectMark("inner", angle + bearing.omega_i * t, half)
        elif row[SIDE] == OUTER:  # a roller's defect has a second row, for the inner race
            yield DefectMark("roller", float(angles[int(on)]) + angle - bearing.omega_b * t, half, int(on))
