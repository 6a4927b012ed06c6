"""The static equilibrium of a bearing in space: sliced rollers that tilt, rings that may lean and move axially.

Unknown are q_j and tilt_j of every roller, the outer ring's x and y, and of a ring on springs its place along the
axis and its lean. There is no friction, and nothing is damped; geometry and contacts are those of the motion
(``models/spatial.py``), evaluated at rest, so that what a leaning ring or a profile does is in it as it is there.
Rollers do not skew, stay in the middle of their pockets and between the flanges, and a pit's edge pushes nothing
sideways (as in ``models/equilibrium.py``).

The residuals are minus the gradient of an energy that is convex but for the tilt of normals (1e-6 of it). For
rings that stand still each roller's pair of equations is solved by itself, all rollers at once; the rings follow
by Newton's method on what the rollers then push, with the stiffness that is left when the rollers give way:

    K = K_rr - sum_j K_rj K_jj^-1 K_jr

Both with steps cut so that they do not pass the point where the force along them vanishes.
"""

from math import hypot
from typing import Any, NamedTuple

import numpy as np

from bearingsim import cpu_time
from bearingsim.core import layout as lay
from bearingsim.core.geometry.motion import kinematic_time
from bearingsim.core.geometry.orientation import body_at
from bearingsim.core.geometry.plane import roller_directions
from bearingsim.core.geometry.sides import InnerSide, OuterSide
from bearingsim.core.geometry.slices import WEIGHT, ZETA
from bearingsim.core.jit import jit
from bearingsim.core.laws.damping.interface import stiffness_bound
from bearingsim.core.laws.stiffness.interface import tangent
from bearingsim.core.models.bodies_in_space import hold_mounted_rings
from bearingsim.core.models.equilibrium import NoEquilibrium
from bearingsim.core.models.spatial import race_contacts, roller_axes
from bearingsim.core.parameters import lanes
from bearingsim.core.parts.flanges import axial_position
from bearingsim.core.parts.mounts import mount_rates
from bearingsim.core.parts.races_in_space import side_loads
from bearingsim.core.sums import sum_loads

RESIDUAL = 1e-10  # of the load: well under the 1e-8 promised
MAX_STEPS = 100
ADDED_STIFFNESS = 1e-3  # of a contact's stiffness, added to a roller's: one that touches nothing finds back
LONGEST_STEP = 2e-5  # m, and of an angle times half a roller's length
OUTER, INNER = slice(0, 5), slice(5, 8)  # coordinates of the rings: x, y, z, lean; z, lean of the inner


@jit
def contacts_at_rest(model, t, y, n):
    """All contacts with everything standing still at time ``t`` (s): what presses on rollers and rings."""
    b, middle = model.bearing, 0.5 * (model.bearing.R_o + model.bearing.R_i)
    time, _, _ = kinematic_time(model.motion, t)
    outer = body_at(y, lay.X, lay.Z, lay.RING_TILT_X, lay.RING_TILT_Y, 0.0)
    inner = body_at(y, lay.X_I, lay.Z_I, lay.INNER_TILT_X, lay.INNER_TILT_Y, 0.0)
    roller_directions(b.theta_0 + b.omega_c * time, y, n)
    for j in range(n):
        c, s = y[lay.COS + j], y[lay.SIN + j]
        tilt = y[lay.TILT + j]
        y[lay.AXIS_X + j], y[lay.AXIS_Y + j] = tilt * c, tilt * s
        y[lay.AXIAL + j] = axial_position(model.flanges, outer, inner, c, s, middle + y[lay.RADIAL + j])
        y[lay.FORCE_R + j], y[lay.MOMENT_T + j] = 0.0, 0.0
    roller_axes(0.0, 0.0, b.R_w, y, n)
    race_contacts(model, t, 0.0, outer, inner, 0.0, y, n)
    side_loads(OuterSide(), b, outer, y, n)
    side_loads(InnerSide(), b, inner, y, n)
    sum_loads(lay.F_X, lay.M_INNER, y, n)


@jit
def stiffnesses(model, y, k_o, k_i):
    """Fill ``k_o`` and ``k_i`` (slices, Z) with the stiffness (N/m) of every slice's contact."""
    for k in range(len(model.slices.table)):
        weight = model.slices.table[k, WEIGHT]
        for j in range(model.bearing.Z):
            o, i = y[lay.slice_row(k, lay.APPROACH_O) + j], y[lay.slice_row(k, lay.APPROACH_I) + j]
            k_o[k, j] = weight * stiffness_bound(model.outer, o, 0.0) if o > 0.0 else 0.0
            k_i[k, j] = weight * stiffness_bound(model.inner, i, 0.0) if i > 0.0 else 0.0


class Statics:
    """A bearing whose rest is looked for: residuals and stiffness at what the buffer ``y`` holds."""

    def __init__(self, model: Any, t: float, y: np.ndarray) -> None:
        """Scales and which of the rings' coordinates are free."""
        self.model, self.t, self.y, self.n = model, t, y, lanes(model.bearing)
        hold_mounted_rings(model, y)
        b, self.half = model.bearing, model.L_w / 2.0
        self.load = hypot(model.support.F, model.support.F_across) + 1e-3
        rate = kinematic_time(model.motion, t)[1]
        orbit, spin = b.omega_c * rate, (b.omega_c - b.omega_b) * rate
        self.flung = b.m_r * orbit**2
        self.gyro = orbit * (b.I_r * spin - model.I_t * orbit)
        self.soft = ADDED_STIFFNESS * tangent(model.outer.stiffness, 1e-7)
        sprung = [mount_rates(mount) is not None for mount in (model.mount_o, model.mount_i) for _ in range(3)]
        self.free = np.array([True, True, *sprung])
        self.cells = lay.POSITION + np.array(
            [lay.X, lay.Y, lay.Z, lay.RING_TILT_X, lay.RING_TILT_Y, lay.Z_I, lay.INNER_TILT_X, lay.INNER_TILT_Y]
        )
        self.unit = np.array([1.0, 1.0, 1.0, self.half, self.half, 1.0, self.half, self.half])  # N per residual

    def row(self, place: int) -> np.ndarray:
        """What the rollers have in a row (Z,), as a view."""
        return self.y[place : place + self.model.bearing.Z]

    def press(self) -> tuple[np.ndarray, np.ndarray]:
        """Residuals of the rollers (Z, 2), N and N m, and of the rings (8,): forces, and N m against lean."""
        contacts_at_rest(self.model, self.t, self.y, self.n)
        cpu_time.check()
        b, y = self.model.bearing, self.y
        out = self.row(lay.FORCE_R) + self.flung * ((b.R_o + b.R_i) / 2.0 + self.row(lay.RADIAL))
        tilting = self.row(lay.MOMENT_T) - self.gyro * self.row(lay.TILT)
        support = self.model.support
        ring = np.array(
            [
                y[lay.F_X] - support.F - support.k_b * (y[lay.POSITION + lay.X] - support.x_0),
                y[lay.F_Y] - support.F_across - support.k_b * (y[lay.POSITION + lay.Y] - support.y_0),
                *self.mounted(self.model.mount_o, y[lay.F_Z], y[[lay.M_X, lay.M_Y, lay.M_RING]], self.cells[2:5]),
                *self.mounted(
                    self.model.mount_i, y[lay.F_Z_I], y[[lay.M_X_I, lay.M_Y_I, lay.M_INNER]], self.cells[5:8]
                ),
            ]
        )
        return np.stack([out, tilting], axis=1), np.where(self.free, ring, 0.0)

    def mounted(self, held: Any, f_z: float, moment: np.ndarray, cells: np.ndarray) -> tuple[float, float, float]:
        """Residuals along the axis (N) and of the two leans (N m) of a ring in its mount."""
        rates = mount_rates(held)
        if rates is None:
            return 0.0, 0.0, 0.0
        k_z, k_tilt = rates
        z, b_x, b_y = self.y[cells]
        b_z = np.sqrt(1.0 - b_x**2 - b_y**2)
        turns = np.cross(moment, [b_x, b_y, b_z])
        return (
            f_z - k_z * z,
            turns[0] - k_tilt * (b_x - held.tilt_x),
            turns[1] - k_tilt * (b_y - held.tilt_y),
        )

    def stiffness(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Stiffness of the rollers (Z, 2, 2), between rollers and rings (Z, 2, 8), and of the rings (8, 8)."""
        model, b = self.model, self.model.bearing
        zeta = model.slices.table[:, ZETA, np.newaxis]
        k_o, k_i = np.zeros((2, len(zeta), b.Z))
        stiffnesses(model, self.y, k_o, k_i)
        both = k_o + k_i + self.soft / len(zeta)
        rollers = np.moveaxis(np.array([[both, zeta * both], [zeta * both, zeta**2 * both]]).sum(axis=2), -1, 0)
        rollers[:, 0, 0] -= self.flung
        rollers[:, 1, 1] += self.gyro
        c, s, nothing = self.row(lay.COS), self.row(lay.SIN), np.zeros((len(zeta), b.Z))
        crossed, rings = np.zeros((b.Z, 2, 8)), np.zeros((8, 8))
        for k, part, on in ((k_o, OUTER, (c, s)), (k_i, INNER, ())):
            ways = np.array([*(way + nothing for way in on), nothing, zeta * c, zeta * s])
            crossed[:, :, part] = -np.einsum("kj,akj,wkj->jaw", k, np.array([1.0 + nothing, zeta + nothing]), ways)
            rings[part, part] = np.einsum("kj,vkj,wkj->vw", k, ways, ways)
        rings[np.diag_indices(8)] += self.springs()
        return rollers, crossed, rings

    def springs(self) -> np.ndarray:
        """What holds the rings besides the rollers (8,): N/m, N m/rad."""
        k_b = self.model.support.k_b + 1e-8 * tangent(self.model.outer.stiffness, 1e-7)
        rates = [mount_rates(mount) or (1.0, 1.0) for mount in (self.model.mount_o, self.model.mount_i)]
        return np.array([k_b, k_b, *(k for k_z, k_tilt in rates for k in (k_z, k_tilt, k_tilt))])

    def move_rollers(self, steps: np.ndarray) -> None:
        """Move every roller by its row of ``steps`` (Z, 2), m and rad."""
        self.row(lay.RADIAL)[:] += steps[:, 0]
        self.row(lay.TILT)[:] += steps[:, 1]

    def settle(self) -> np.ndarray:
        """Balance every roller where the rings stand; returns the residuals of the rings (8,)."""
        left, rings = self.press()
        for _ in range(MAX_STEPS):
            if self.size(left) <= 0.1 * RESIDUAL * self.load:
                break
            steps = np.linalg.solve(self.stiffness()[0], left[:, :, np.newaxis])[:, :, 0]
            longest = np.abs(steps * [1.0, self.half]).max(axis=1)
            steps *= np.minimum(1.0, LONGEST_STEP / np.maximum(longest, 1e-300))[:, np.newaxis]
            push, before = (left * steps).sum(axis=1), left
            self.move_rollers(steps)
            left, rings = self.press()
            for _ in range(40):
                past = (left * steps).sum(axis=1) < -0.5 * push
                if not past.any() or self.size(left) <= 0.1 * RESIDUAL * self.load:
                    break
                steps = np.where(past[:, np.newaxis], 0.5 * steps, steps)
                push = np.where(past, 0.5 * push, push)
                self.move_rollers(np.where(past[:, np.newaxis], -steps, 0.0))
                left, rings = self.press()
            if self.size(left) >= self.size(before) and self.size(left) <= RESIDUAL * self.load:
                break  # rounding
        return rings

    def size(self, left: np.ndarray) -> float:
        """Largest residual (N) of the rollers."""
        return float(np.abs(left / [1.0, self.half]).max())

    def balance(self) -> float:
        """Find the rest; returns the largest residual (N), moments counted by half of a roller's length."""
        rings = self.settle()
        for _ in range(MAX_STEPS):
            if np.abs(rings / self.unit).max() <= RESIDUAL * self.load:
                break
            step = self.towards(rings)
            push, start = rings @ step, self.y[self.cells].copy()
            state, part = (self.row(lay.RADIAL).copy(), self.row(lay.TILT).copy()), 1.0
            for _ in range(40):
                self.y[self.cells] = start + part * step
                rings = self.settle()
                if rings @ step >= -0.5 * push:
                    break
                part *= 0.5
                self.row(lay.RADIAL)[:], self.row(lay.TILT)[:] = state
        left, rings = self.press()
        return max(self.size(left), float(np.abs(rings / self.unit).max()))

    def towards(self, rings: np.ndarray) -> np.ndarray:
        """Newton's step (8,) of the rings, the rollers giving way."""
        rollers, crossed, stiff = self.stiffness()
        stiff = stiff - np.einsum("jaw,jav->wv", crossed, np.linalg.solve(rollers, crossed))
        step, free = np.zeros(8), self.free
        step[free] = np.linalg.solve(stiff[np.ix_(free, free)], rings[free])
        return step * min(1.0, LONGEST_STEP / max(np.abs(step * self.unit).max(), 1e-300))


def rest_in_space(model: Any, t: float, y: np.ndarray) -> float:
    """Put rings and rollers at rest at time ``t`` (s), from where a rest in the plane left them.

    Returns the largest residual (N). Velocities are zero but for the rollers' axes, which go round with them.
    """
    b = model.bearing
    for row in (lay.EPS, lay.SPIN):
        y[row : row + b.Z] = 0.0
    y[lay.VELOCITY : lay.VELOCITY + lay.STATE] = 0.0
    y[lay.TILT : lay.TILT + b.Z] = 0.0
    left = Statics(model, t, y).balance()
    orbit = b.omega_c * kinematic_time(model.motion, t)[1]
    y[lay.AXIS_X_V : lay.AXIS_X_V + b.Z] = -orbit * y[lay.AXIS_Y : lay.AXIS_Y + b.Z]
    y[lay.AXIS_Y_V : lay.AXIS_Y_V + b.Z] = orbit * y[lay.AXIS_X : lay.AXIS_X + b.Z]
    return left


class MeanRest(NamedTuple):
    """A bearing at rest over a ball pass: mean place of the ring (m), and the largest force on a roller (N)."""

    x: float
    y: float
    load: float


def mean_rest_in_space(model: Any, y: np.ndarray, samples: int = 32) -> MeanRest:
    """``MeanRest``, from ``samples`` of a ball pass; ``y``: a buffer at a rest in the plane.

    Raises ``NoEquilibrium`` if one is not found to 1e-8 of the load.
    """
    b = model.bearing
    pass_time = 2.0 * np.pi / (b.Z * b.omega_c)
    load, found = hypot(model.support.F, model.support.F_across), []
    for n in range(samples):
        residual = rest_in_space(model, (n + 0.5) / samples * pass_time, y)
        if not residual <= 1e-8 * load:
            raise NoEquilibrium(f"no static equilibrium in space: {residual:g} N left of {load:g} N")
        found.append((y[lay.POSITION + lay.X], y[lay.POSITION + lay.Y], y[lay.Q_O : lay.Q_O + b.Z].max()))
    x, across, _ = (float(value) for value in np.mean(found, axis=0))
    return MeanRest(x, across, float(max(most for _, _, most in found)))
