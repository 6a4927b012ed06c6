"""Arrays of ``solver.py`` and ``solver_planar.py``, made of a scene.

The pages of docs/ name each quantity: bearings.md, contact.md (C2), defects.md (M4), excitations.md, form.md (F3).
"""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.optimize import brentq, root
from scipy.special import ellipe, ellipk, j0

from tests.independent import solver
from tests.independent.solver import INNER, OUTER
from tests.independent.solver_planar import Friction, Planar
from tests.independent.solver_scenes import Defect, Scene

DENSITY, E_STAR = 7850.0, 207e9 / (2 * (1 - 0.3**2))
CELLS, NODES, PHASES, TRIPLES = 500, 24, 32, 509
GUIDES = ("centred", "rollers", "outer-ring", "inner-ring")
ELEMENTS = {"outer": solver.OUTER, "inner": solver.INNER, "roller": solver.ROLLER}


def laws(s: Scene) -> tuple:
    """Stiffness laws of both contacts (contact.md)."""
    length, name = 1e3 * s.size.L, s.stiffness or ("point" if s.size.grooves else "palmgren")
    if name == "johnson":
        return tuple(
            solver.Law(np.pi * E_STAR * s.size.L, 0.0, abs(R - sign * s.R_w))
            for sign, R in zip((1, -1), s.races, strict=True)
        )
    if name == "point":
        return tuple(solver.Law(point(s, side)[0], 1.5, 0.0) for side in (OUTER, INNER))
    named: dict[str, tuple[float, float]] = {
        "palmgren": (8.06e4 * length ** (8 / 9), 10 / 9),
        "iso16281": (2 ** (10 / 9) * 35948 * length ** (8 / 9), 10 / 9),
    }
    coefficient, exponent = named[name] if isinstance(name, str) else name
    return (solver.Law(coefficient * 1e3**exponent, exponent, 0.0),) * 2


def point(s: Scene, side: int) -> tuple:
    """Coefficient k, and the half axes across and along rolling under 1 N, of a ball (C2)."""
    R, groove = (-s.races[OUTER], s.races[INNER])[side], s.size.grooves[side]
    across, along = (2 / s.size.D_w - 1 / groove) / 2, (2 / s.size.D_w + 1 / R) / 2
    total = across + along

    def excess(kappa):
        first_kind, second_kind = ellipk(1 - kappa**-2), ellipe(1 - kappa**-2)
        ratio = ((kappa**2 + 1) * second_kind - 2 * first_kind) / ((kappa**2 - 1) * second_kind)
        return ratio - (along - across) / total

    kappa = brentq(excess, 1.001, 100.0, xtol=1e-14)
    first_kind, second_kind = ellipk(1 - kappa**-2), ellipe(1 - kappa**-2)
    k = 2 * np.pi * E_STAR / 3 * kappa * np.sqrt(second_kind / (first_kind**3 * total))
    a = (3 * kappa**2 * second_kind / (2 * np.pi * E_STAR * total)) ** (1 / 3)
    return k, a, a / kappa


def opening(d: Defect) -> float:
    """Width (m) of a rounding: its radius, or less if the defect is shallower."""
    return np.sqrt(2 * d.edge * d.depth - d.depth**2) if d.depth < d.edge else d.edge


def depth(d: Defect, zeta: float, t: np.ndarray) -> np.ndarray:
    """Depth map of a defect at t >= 0 from its middle and z = zeta l/2 (defects.md, Shapes)."""
    x, half = 2 * t / d.width, d.width / 2
    if d.shape == "triangular":
        return d.depth * np.maximum(1 - x, 0.0)
    if d.shape == "circular":
        return d.depth * np.maximum(1 - x**2 - zeta**2, 0.0)
    if d.shape == "elliptical":
        return d.depth * np.sqrt(np.maximum(1 - x**2 - zeta**2, 0.0))
    left = np.clip(half + opening(d) - t, 0.0, opening(d))  # of the rounding, whose arc is tangent to the race
    return np.where(t < half, d.depth, np.minimum(d.depth, d.edge - np.sqrt(d.edge**2 - left**2)))


def roller_drop(d: Defect, zeta: float, R: float, s: np.ndarray) -> tuple:
    """(M4) and its slope (s - t)/R, at the point t of contact, by search over finer and finer grids."""
    rim = d.width / 2 * np.sqrt(1 - zeta**2)
    t = np.unique(np.concatenate([s, np.linspace(0.0, rim, CELLS), [rim]]))
    k = np.argmin(depth(d, zeta, t) + (t - s[:, np.newaxis]) ** 2 / (2 * R), axis=1)
    best, spacing = t[k], np.diff(t).max()
    for _ in range(4):
        near = np.maximum(best[:, np.newaxis] + spacing * np.linspace(-1.0, 1.0, 41), 0.0)
        value = depth(d, zeta, near) + (near - s[:, np.newaxis]) ** 2 / (2 * R)
        best, spacing = np.take_along_axis(near, np.argmin(value, axis=1)[:, np.newaxis], 1)[:, 0], spacing / 20
    h = depth(d, zeta, best) + (best - s) ** 2 / (2 * R)
    return h, (s - best) / R, np.abs(best - rim) < 1e-9


def responses(s: Scene, d: Defect, zeta: float, side: int, b: float) -> tuple:
    """Reach of a group and its tables of share, h and dh/ds (excitations.md); b: half width of the contact."""
    reach, R, half = d.width / 2 + opening(d), s.reduced[side], d.width / 2
    x = np.linspace(0.0, reach + (b if s.excitation == "pressure-share" else 0.0), CELLS + 1)
    nothing, whole = np.zeros(CELLS + 1), np.ones(CELLS + 1)
    h, slope, on_rim = roller_drop(d, zeta, R, x)
    top, local = h[0], half * np.sqrt(1 - zeta**2)
    full = d.depth * (1 - zeta**2 if d.shape == "circular" else 1.0)
    if s.excitation == "pressure-share":
        front, back = (np.clip((sign * local - x) / b, -1.0, 1.0) for sign in (1, -1))
        rho = sum(sign * (np.arcsin(p) + p * np.sqrt(1 - p * p)) / np.pi for sign, p in ((1, front), (-1, back)))
        return x[-1], [(1 - rho, nothing, nothing), (rho, full * whole, nothing)]
    if s.excitation == "soft-edge":
        whole = np.where(on_rim & (h < full * (1 - 1e-12)) & (x < local), 0.65, 1.0)
    elif s.excitation != "envelope":
        within = x <= local
        x_r = min(local, np.sqrt(2 * R * d.depth)) if d.shape == "rectangular" else local
        x_r = local if s.excitation == "half-sine-pulse" else x_r
        phase = np.pi * np.minimum(local - x, x_r) / (2 * x_r)
        h = np.where(within, top * np.sin(phase), 0.0)
        slope = np.where(within & (local - x < x_r), -np.pi * top / (2 * x_r) * np.cos(phase), 0.0)
        if s.excitation in ("rectangular-pulse", "clearance-increase"):
            h, slope = (top if s.excitation == "rectangular-pulse" else full) * within, nothing
    return reach, [(whole, h, slope)]


def tables(s: Scene, half_axes: tuple, b: tuple) -> tuple:
    """Arrays of all defects for ``solver.Contacts``; half_axes: of balls, across rolling."""
    head, span, table, rest = [], [], [], []
    for d in s.defects:
        start, outside = len(table), [0.0, 0.0]
        for side in (OUTER, INNER):
            length = 2 * half_axes[side] if s.size.grooves else s.size.L
            low, high = max(-length / 2, d.offset - d.length / 2), min(length / 2, d.offset + d.length / 2)
            zetas, weights = np.zeros(1), np.ones(1)
            if d.shape in ("circular", "elliptical"):
                nodes, weights = np.polynomial.legendre.leggauss(NODES)
                zetas, weights = (
                    2 * ((low + high) / 2 + (high - low) / 2 * nodes - d.offset) / d.length,
                    weights / 2,
                )
            of_side = [
                (weight * (high - low) / length * share, h, slope)
                for zeta, weight in zip(zetas, weights, strict=True)
                for share, h, slope in responses(s, d, zeta, side, b[side])[1]
            ]
            outside[side] = 1 - (high - low) / length
            if side == OUTER:
                table += [np.zeros((2, 3, CELLS + 1)) for _ in of_side]
            for k, rows in enumerate(of_side):
                table[start + k][side] = rows
        reach = responses(s, d, 0.0, OUTER, b[OUTER])[0]
        head.append((ELEMENTS[d.race], d.roller - 1, np.radians(d.angle), reach, reach / CELLS))
        span.append((start, len(table)))
        rest.append(outside)
    shape = np.array(table).reshape(-1, 2, 3, CELLS + 1)
    return np.array(head).reshape(-1, 5), np.array(span, int).reshape(-1, 2), shape, np.array(rest).reshape(-1, 2)


def bearing(s: Scene) -> solver.Bearing:
    """Bearing of a scene, without the anchor of its support."""
    size, ball = s.size, bool(s.size.grooves)
    m_r = DENSITY * np.pi * s.R_w**2 * (4 / 3 * s.R_w if ball else size.L)
    m_o = DENSITY * np.pi * ((size.outside / 2) ** 2 - s.races[OUTER] ** 2) * size.breadth
    return solver.Bearing(
        Z=size.Z, r_m=size.d_m / 2, R_w=s.R_w, radius=s.races, gap=s.clearance / 4, m_r=m_r,
        I_r=(0.4 if ball else 0.5) * m_r * s.R_w**2, m_o=s.ring_mass or m_o, theta_0=np.radians(s.start_angle),
        omega_i=s.speed * np.pi / 30, gamma=size.D_w / size.d_m, load=complex(s.load, s.load_across),
        k_b=s.bracket[0], c_b=s.bracket[1], anchor=0j,
    )  # fmt: skip


def at_rest(b: solver.Bearing, c: solver.Contacts, turns: np.ndarray, guess: complex, k_b: float) -> tuple:
    """Ring (m, complex), rollers and their forces in equilibrium (M12), with the support's stiffness k_b."""
    q, forces, out = np.zeros(b.Z), np.zeros((2, b.Z)), np.zeros((solver.MAX_GROUPS, 5))
    centrifugal = b.m_r * (b.omega_i * (1 - b.gamma) / 2) ** 2

    def net(microns):
        u = 1e-6 * complex(*microns)
        force = solver.rest_forces(b, c, u, turns, centrifugal, out, q, forces)
        force -= b.load + k_b * (u - b.anchor)
        return np.array([force.real, force.imag]) / abs(b.load)

    solution = root(net, [1e6 * guess.real, 1e6 * guess.imag], tol=1e-13)
    assert np.abs(net(solution.x)).max() < 1e-6, solution.message
    return 1e-6 * complex(*solution.x), q, forces


@lru_cache
def prepare(s: Scene) -> tuple:
    """Bearing with its anchor, contacts, and the position of ring and rollers at rest at t = 0."""
    b, mean = bearing(s), np.mean(s.diameters or (0.0,)) / 2
    of_scene = laws(s)
    form: dict[str, Any] = {"waves": np.zeros((0, 6)), "radii": np.full(b.Z, mean)}
    damping = solver.Damping(0, 0.0, 0.0, 0.0)
    smooth = solver.Contacts(of_scene, damping, *tables(replace(s, defects=()), (0, 0), (0, 0)), **form)
    guess = -b.load / abs(b.load) * (1e-6 + max(s.clearance, 0.0) / 2)
    turns = [2 * np.pi / b.Z * np.array([(k + 0.5) / PHASES, 0.0, 0.0]) for k in range(PHASES)]
    states = [at_rest(b, smooth, turn, guess, 0.0) for turn in turns]
    loads = np.max([forces for _, _, forces in states], axis=(0, 2))
    anchor = np.mean([u for u, _, _ in states])
    half_axes = (0.0, 0.0)
    if s.size.grooves:
        axes = [np.array(point(s, side)[1:]) * loads[side] ** (1 / 3) for side in (OUTER, INNER)]
        half_axes, half_widths = zip(*axes, strict=True)
    else:
        pairs = zip(s.reduced, loads, strict=True)
        half_widths = tuple(np.sqrt(4 * R * load / (s.size.L * np.pi * E_STAR)) for R, load in pairs)
    if s.waves or s.diameters:
        form = {"waves": waves(s, half_widths), "radii": np.array(s.diameters or (0.0,) * b.Z) / 2}
        uneven, steps = smooth._replace(**form), np.array([1 / TRIPLES, 0.6180339887498949, 0.7548776662466927])
        turns = [2 * np.pi * np.mod(k * steps, 1.0) for k in range(TRIPLES)]
        anchor = np.mean([at_rest(b, uneven, turn, anchor, 0.0)[0] for turn in turns])
    law, *parameters = s.damping
    dampings: dict[str, Callable[..., solver.Damping]] = {
        "kraemer": lambda beta: solver.Damping(solver.KRAEMER, beta, 0.0, 0.0),
        "loss-factor": lambda psi, f: solver.Damping(solver.KRAEMER, psi / (2 * np.pi * f), 0.0, 0.0),
        "hunt-crossley": lambda chi: solver.Damping(solver.HUNT_CROSSLEY, chi, 0.0, 0.0),
        "general": lambda c, m2, m3: solver.Damping(solver.GENERAL, c * 1e3 ** (m2 + m3), m2, m3),
    }
    damping = dampings[law](*parameters)
    contacts = solver.Contacts(of_scene, damping, *tables(s, half_axes, half_widths), **form)
    b = b._replace(anchor=complex(anchor))
    return b, contacts, *at_rest(b, contacts, np.zeros(3), b.anchor, b.k_b)[:2]


def waves(s: Scene, b: tuple) -> np.ndarray:
    """Waves with the amplitudes that act at the outer and the inner contact (F3)."""
    rows = []
    for wave in s.waves:
        R = (*s.races, s.R_w)[ELEMENTS[wave.element]]
        x = wave.order / R * np.array(b)
        acting = wave.amplitude * (np.sinc(x / np.pi) if s.size.grooves else j0(x))
        rows.append((ELEMENTS[wave.element], wave.roller - 1, wave.order, *acting, np.radians(wave.phase)))
    return np.array(rows).reshape(-1, 6)


def planar_bodies(s: Scene, b: solver.Bearing) -> Planar:
    """Bodies and laws of `planar` (planar.md, Cage, Drag, Shaft)."""
    size, drag, ramp = s.size, dict(s.drag or ()), s.ramp or (s.speed, 0.0)
    m_c = DENSITY * np.pi * size.d_m * 0.35 * size.D_w * 0.7 * size.breadth / 2
    area = np.pi * size.D_w**2 / 4 if size.grooves else size.L * size.D_w
    film_inner = drag.get("land") == "inner"
    land = size.d_m / 2 + (-0.35 if film_inner else 0.35) * size.D_w
    film = 2 * np.pi * drag.get("oil_viscosity", 0.05) * land**3 * (size.breadth - (size.L or size.D_w)) / 0.2e-3
    outside = size.outside / 2
    return Planar(
        omega_end=ramp[0] * np.pi / 30, ramp=ramp[1], friction=s.friction,
        cage_friction=Friction(False, 0.002, 0.001, 0.02, 0.1), m_c=m_c, I_c=m_c * b.r_m**2,
        pocket=(0.1e-3, 1e7, 10.0, 0.1e-3), guide=GUIDES.index(s.guide), play=0.2e-3,
        land=b.r_m + (-0.35 if s.guide == "inner-ring" else 0.35) * size.D_w,
        drag=0.5 * drag.get("oil_fraction", 0.1) * 860 * area if s.drag is not None else 0.0,
        film=film if s.drag is not None else 0.0, film_inner=film_inner, gravity=9.80665 if s.gravity else 0.0,
        shaft=tuple(map(float, s.shaft or (0, 0, 0))),
        unbalance=s.unbalance[0] * np.exp(1j * np.radians(s.unbalance[1])) if s.unbalance else 0j,
        torsion=(*s.torsion, b.m_o * (outside**2 + s.races[OUTER] ** 2) / 2) if s.torsion else (0.0, 0.0, 0.0),
    )  # fmt: skip
