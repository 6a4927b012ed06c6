"""`spatial` between tilted rings at rest, and its step limit, against equations of spatial.md solved by SciPy."""

from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import root

from bearingsim import assemble
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.simulation.limits import load_and_rates_at_rest, rest_case
from tests.independent.invariant_cases import View, case_of, spatial

Z, SLICES, L_W, D_W, D_M = 13, 24, 12e-3, 12e-3, 65e-3
R_W, M_R = D_W / 2, 7850 * np.pi * (D_W / 2) ** 2 * L_W
I_T = M_R * (3 * R_W**2 + L_W**2) / 12
AXIAL, TILTING = np.array([1e7, 2e7]), np.array([2e4, 4e4])
"""Stiffness of the mounts of the outer and the inner ring, N/m and N m/rad."""
ZETA = (np.arange(SLICES) + 0.5) / SLICES * L_W - L_W / 2
PROFILE = 3e-6 * (np.maximum(np.abs(ZETA) - 3e-3, 0.0) / 3e-3) ** 2
K = 8.06e4 * 12 ** (8 / 9) * 1e3 ** (10 / 9)


class Scene(NamedTuple):
    """Load along and across (N), clearance (m), misalignment of both rings (rad) and its direction (rad)."""

    load: complex
    clearance: float
    tilts: tuple
    direction: float
    speed: float = 1800.0


SCENES = {
    "preload": Scene(300 - 100j, -6e-6, (-2e-4, 4e-4), 0.5),
    "heavy load": Scene(2500 + 500j, -16e-6, (4e-4, 1e-4), -2.0),
    "one ring, fast": Scene(1000 + 0j, -12e-6, (0.0, 5e-4), 1.2, 6000.0),
}
"""Preloaded, because the tilt of a roller without load is arbitrary."""


def case_of_scene(s: Scene) -> Case:
    """Case without defects whose ring has practically no other support than the rollers."""
    fields = spatial(View())
    mounts = [
        {"axial_stiffness": f"{k} N/m", "tilting_stiffness": f"{k_t} N m/rad"}
        for k, k_t in zip(AXIAL, TILTING, strict=True)
    ]
    outer, inner = s.tilts
    return case_of(
        spatial, View(), defects=[], load=f"{s.load.real} N", load_across=f"{s.load.imag} N",
        clearance=f"{s.clearance} m", speed=f"{s.speed} rpm", shaft=fields["shaft"] | mounts[1],
        rig=fields["rig"] | {"bracket_stiffness": "0.01 N/m"} | mounts[0],
        misalignment={"outer": f"{outer} rad", "inner": f"{inner} rad", "direction": f"{s.direction} rad"},
    )  # fmt: skip


def axis(across: np.ndarray) -> np.ndarray:
    """Unit vector with these components along e_0 and e_90."""
    return np.append(across, np.sqrt(1 - across @ across))


def unpack(x: np.ndarray) -> tuple:
    """Ring (m), rollers' positions (m) and tilts, axial positions (m) and axes (2, 2) of both rings."""
    rings = x[2 + 2 * Z :].reshape(2, 3)
    return 1e-6 * x[:2], 1e-6 * x[2 : 2 + Z], 1e-4 * x[2 + Z : 2 + 2 * Z], 1e-6 * rings[:, 0], 1e-4 * rings[:, 1:]


def slice_contacts(s: Scene, x: np.ndarray, e_r: np.ndarray, z: np.ndarray) -> tuple:
    """Approaches (2, Z, SLICES), forces on the slices and their positions by (S2); centres and axes.

    z: axial positions of the rollers, m.
    """
    u, q, tilt, axial, axes = unpack(x)
    a = tilt[:, np.newaxis] * e_r
    a[:, 2] = np.sqrt(1 - tilt**2)
    c = (D_M / 2 + q)[:, np.newaxis] * e_r + z[:, np.newaxis] * [0.0, 0.0, 1.0]
    p = c[:, np.newaxis] + ZETA[:, np.newaxis] * a[:, np.newaxis]
    approaches, forces, centres = [], [], [np.append(u, axial[0]), np.array([0.0, 0.0, axial[1]])]
    for side, sigma in enumerate((1, -1)):
        b, d = axis(axes[side]), p - centres[side]
        X = d - (d @ b)[..., np.newaxis] * b
        rho = np.linalg.norm(X, axis=2)
        R = (D_M + sigma * D_W) / 2 + sigma * s.clearance / 4
        delta = sigma * (rho - R) + R_W - PROFILE
        load = K / SLICES * np.maximum(delta, 0.0) ** (10 / 9)
        approaches.append(delta)
        forces.append(-sigma * (load / rho)[..., np.newaxis] * X)
    return np.array(approaches), np.array(forces), p, centres, a


def residuals(s: Scene, x: np.ndarray, e_r: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Forces (N) and moments over half the length (N) on rings and rollers (spatial.md, Start, Mounts)."""
    _, forces, p, centres, a = slice_contacts(s, x, e_r, z)
    _, q, _, axial, axes = unpack(x)
    omega_c = s.speed * np.pi / 30 * (1 - D_W / D_M) / 2
    e_t = np.cross([0.0, 0.0, 1.0], e_r)
    on_roller = forces.sum(axis=(0, 2))
    radial = np.sum(on_roller * e_r, axis=1) + M_R * omega_c**2 * (D_M / 2 + q)
    moments = np.cross(ZETA[:, np.newaxis] * a[:, np.newaxis], forces.sum(axis=0)).sum(axis=1)
    rows = [-forces[0].sum(axis=(0, 1))[:2] - [s.load.real, s.load.imag], radial]
    rows.append(2 / L_W * np.sum(moments * e_t, axis=1))
    mounted = [np.sin(tilt) * np.array([np.cos(s.direction), np.sin(s.direction)]) for tilt in s.tilts]
    for side in range(2):
        force, moment = -forces[side].sum(axis=(0, 1)), -np.cross(p - centres[side], forces[side]).sum(axis=(0, 1))
        tip = np.cross(moment, axis(axes[side]))[:2]
        rows.append(np.array([force[2] - AXIAL[side] * axial[side]]))
        rows.append(2 / L_W * (tip - TILTING[side] * (axes[side] - mounted[side])))
    return np.concatenate(rows)


def at_rest(s: Scene, theta_0: float, z: np.ndarray) -> tuple:
    """Solution of ``residuals`` and directions of the rollers, with the first one at ``theta_0`` (rad)."""
    theta = theta_0 + 2 * np.pi * np.arange(Z) / Z
    e_r = np.array([np.cos(theta), np.sin(theta), 0 * theta]).T
    guess = np.zeros(2 + 2 * Z + 6)
    guess[2 + Z : 2 + 2 * Z] = 0.5e4 * sum(s.tilts) * np.cos(theta - s.direction)
    for side, tilt in enumerate(s.tilts):
        guess[3 + 2 * Z + 3 * side : 5 + 2 * Z + 3 * side] = (
            1e4 * tilt * np.array([np.cos(s.direction), np.sin(s.direction)])
        )

    def residuals_at(x: np.ndarray) -> np.ndarray:
        return residuals(s, x, e_r, z)

    solution = root(residuals_at, guess, tol=1e-13)
    assert np.abs(solution.fun).max() < 1e-7 * abs(s.load), solution.message
    return solution.x, e_r


def product_at_rest(case: Case) -> tuple[tuple, np.ndarray, float]:
    """The same unknowns as ``unpack``; axial positions of the rollers, in the middle of their flanges; theta_0."""
    model = assemble.model(case)
    y, _ = assemble.start(case, model)
    p = lay.POSITION
    tilt_x, tilt_y = (y[row : row + Z] for row in (lay.AXIS_X, lay.AXIS_Y))
    theta = model.bearing.theta_0 + 2 * np.pi * np.arange(Z) / Z
    return (
        y[[p + lay.X, p + lay.Y]], y[lay.RADIAL : lay.RADIAL + Z], tilt_x * np.cos(theta) + tilt_y * np.sin(theta),
        y[[p + lay.Z, p + lay.Z_I]],
        y[[[p + lay.RING_TILT_X, p + lay.RING_TILT_Y], [p + lay.INNER_TILT_X, p + lay.INNER_TILT_Y]]],
    ), y[lay.AXIAL : lay.AXIAL + Z], model.bearing.theta_0  # fmt: skip


TOLERANCES = (3e-7, 8e-6, 6e-5, 5e-5, 3e-5)
"""Of each kind of unknown, relative to its largest value; 6.5e-8, 2.2e-6, 1.9e-5, 1.6e-5, 8e-6 were measured."""


@pytest.mark.parametrize("name", SCENES)
def test_equilibrium(name):
    """Forces balance to 1e-10."""
    computed, z, theta_0 = product_at_rest(case_of_scene(SCENES[name]))
    expected = unpack(at_rest(SCENES[name], theta_0, z)[0])
    for values, solution, tolerance in zip(computed, expected, TOLERANCES, strict=True):
        assert values == pytest.approx(solution, rel=0.0, abs=tolerance * np.abs(solution).max())


def largest_rate(s: Scene, theta_0: float, z: np.ndarray) -> float:
    """Largest eigenvalue (1/s^2) of radial motion and tilt of a roller on the tangents of its contacts."""
    x, e_r = at_rest(s, theta_0, z)
    approaches = slice_contacts(s, x, e_r, z)[0]
    k = (10 / 9 * K / SLICES * np.maximum(approaches, 0.0) ** (1 / 9)).sum(axis=0)
    k_0, k_1, k_2 = ((k * ZETA**n).sum(axis=1) for n in range(3))
    coupling = k_1 / np.sqrt(M_R * I_T)
    matrices = np.array([[k_0 / M_R, coupling], [coupling, k_2 / I_T]])
    return float(np.linalg.eigvalsh(np.moveaxis(matrices, -1, 0)).max())


@pytest.mark.parametrize("name", SCENES)
def test_stiffness_that_limits_the_step(name):
    """The largest over a ball pass, of which both sample some angles: within 2e-5 (6.5e-6 was measured)."""
    s, case = SCENES[name], case_of_scene(SCENES[name])
    _, z, theta_0 = product_at_rest(case)
    expected = max(largest_rate(s, theta_0 + 2 * np.pi / Z * k / 6, z) for k in range(6))
    assert load_and_rates_at_rest(rest_case(case))[1] == pytest.approx(expected, rel=2e-5)
