"""Bearings of the independent solution of `planar`: dimensions, loads, laws, defects and the path over one."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

OUTER, INNER = 1, -1
STEEL = 7850.0


class Defect(NamedTuple):
    """A box over the full length. ``on``: OUTER, INNER or the roller's number from 0 as ``("roller", j)``.

    The angle is measured from the load line at t = 0, for a roller from its outward radial direction at t = 0.
    """

    on: Any
    width: float
    depth: float
    angle: float = 0.0


@dataclass(frozen=True)
class Power:
    """Elastic force k delta^m, energy k delta^(m+1)/(m+1)."""

    k: float
    m: float

    def force(self, delta):
        return self.k * np.maximum(delta, 0.0) ** self.m

    def energy(self, delta):
        return self.k / (self.m + 1.0) * np.maximum(delta, 0.0) ** (self.m + 1.0)


def palmgren(length: float) -> Power:
    """8.06e4 L^(8/9) N/mm^(10/9), L in mm."""
    return Power(8.06e4 * (1e3 * length) ** (8 / 9) * 1000 ** (10 / 9), 10 / 9)


@dataclass(frozen=True)
class HuntCrossley:
    """Damping force chi v E."""

    chi: float

    def __call__(self, elastic, rate):
        return self.chi * rate * elastic


@dataclass(frozen=True)
class Linear:
    """Damping force c v while in contact."""

    c: float

    def __call__(self, elastic, rate):
        return np.where(elastic > 0.0, self.c * rate, 0.0)


def step(x):
    """0 to 1 as x goes from 0 to 1, flat at both ends."""
    x = np.minimum(np.maximum(x, 0.0), 1.0)  # np.clip is slow
    return x * x * (3.0 - 2.0 * x)


def static_dynamic(static=0.3, dynamic=0.15, static_speed=0.02, dynamic_speed=0.1) -> Callable:
    """Odd: -static at -static_speed, static at static_speed, dynamic from dynamic_speed on; cubic steps."""

    def mu(v):
        rise = 2.0 * static * step((v + static_speed) / (2.0 * static_speed)) - static
        fall = np.sign(v) * (static - dynamic) * step((np.abs(v) - static_speed) / (dynamic_speed - static_speed))
        return rise - fall

    return mu


@dataclass(frozen=True)
class Coulomb:
    """Constant beyond ``zone`` (m/s), proportional to the slip within it."""

    mu: float
    zone: float

    def __call__(self, v):
        return self.mu * np.clip(v / self.zone, -1.0, 1.0)


def frictionless(v):
    return 0.0 * v


ROLLER_ON_RACE = palmgren(0.012)
LUBRICATED = HuntCrossley(50.0)


@dataclass(frozen=True)
class Scene:
    """NF308 at 1800 rpm, 150 N, without friction, cage contact or drag unless named."""

    Z: int = 13
    D_w: float = 0.012
    d_m: float = 0.065
    L_w: float = 0.012
    outside: float = 0.090
    breadth: float = 0.023
    clearance: float = 0.0
    speed: float = 2 * np.pi * 30
    theta_0: float = np.pi / 13
    load: complex = 150.0  # pushes the ring with -load
    k_b: float = 1e7
    c_b: float = 200.0
    torsion: tuple | None = None  # N m/rad, N m s/rad; None: the ring does not turn
    elastic: Power = ROLLER_ON_RACE
    damping: Any = LUBRICATED
    clamp: bool = True
    friction: Callable = frictionless
    friction_tilts: bool = (
        False  # it acts where the edge of a defect touches, and across that; else under the centre
    )
    defects: tuple = ()
    cage_mass: float = 0.05
    cage_moves: bool = False  # its centre
    pocket_clearance: float = 0.2e-3
    pocket_stiffness: float = 0.0
    pocket_chi: float = 50.0
    pocket_friction: Callable = frictionless
    eps: tuple = field(default=())  # angles of the rollers from their pockets' centres at t = 0
    roller_drag: float = 0.0  # kg/m: 1/2 rho_eff C_d L D
    cage_drag: float = 0.0  # N m s

    R_w = property(lambda s: s.D_w / 2)
    R_o = property(lambda s: (s.d_m + s.D_w) / 2 + s.clearance / 4)
    R_i = property(lambda s: (s.d_m - s.D_w) / 2 - s.clearance / 4)
    m_r = property(lambda s: STEEL * np.pi * s.R_w**2 * s.L_w)
    m_o = property(lambda s: STEEL * np.pi * ((s.outside / 2) ** 2 - s.R_o**2) * s.breadth)
    roller_inertia = property(lambda s: s.m_r * s.R_w**2 / 2)
    ring_inertia = property(lambda s: s.m_o * ((s.outside / 2) ** 2 + s.R_o**2) / 2)
    cage_inertia = property(lambda s: s.cage_mass * (s.d_m / 2) ** 2)
    orbit = property(lambda s: s.speed * (1 - s.D_w / s.d_m) / 2)
    spin = property(lambda s: -s.orbit * s.d_m / s.D_w)  # rolling on the standing outer ring
    pockets = property(lambda s: 2 * np.pi * np.arange(s.Z) / s.Z)
    angles = property(lambda s: s.theta_0 + s.pockets + (np.array(s.eps) if len(s.eps) else 0.0))

    def radius(self, side):
        return self.R_o if side == OUTER else self.R_i

    def reduced(self, side):
        """1/R = 1/R_w - side/R_race: the relative curvature of roller and race."""
        return 1.0 / (1.0 / self.R_w - side / self.radius(side))


def path_depth_and_slope(s, width, depth, reduced):
    """h(s) = min over t of p(t) + (t - s)^2/(2 R), and dh/ds = (s - t*)/R at the minimiser (envelope theorem)."""
    defect = np.linspace(-width / 2, width / 2, 2001)
    t = np.concatenate([defect, defect[[0, -1]], [s]])
    profile = np.concatenate([np.full(defect.size, depth), [0.0, 0.0], [0.0 if abs(s) >= width / 2 else depth]])
    gap = profile + (t - s) ** 2 / (2 * reduced)
    best = np.argmin(gap)
    return gap[best], (s - t[best]) / reduced
