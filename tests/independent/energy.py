"""Equilibrium of a bearing in space by its energy: rings are circles about tilted axes, rollers points with axes.

Only the data of the model are used. The state x has the ring's position (2,) and q (Z,) in um, then the tilts (Z,)
in 1e-3 rad, so ``gradient`` has forces in N and moments in N mm. The defect does not move relative to its roller,
because the model, too, omits the force along the race due to its slope.
"""

from math import pi

import numpy as np
from scipy.linalg import solve
from scipy.optimize import minimize

from bearingsim.core.defects.closed_forms import roller_drop
from bearingsim.core.defects.pairs import RADIUS

STEP = 1e-6  # of a state, for derivatives of forces
CONVERGED = 1e-8  # of the load; rounding of positions leaves 1e-10 of it


def unpack(model, x):
    """Return the ring's position (2,) and q (Z,) in m, and the tilts (Z,) in rad."""
    Z = model.bearing.Z
    return x[:2] * 1e-6, x[2 : 2 + Z] * 1e-6, x[2 + Z :] * 1e-3


def angles(model):
    """Return the angles of the rollers (Z,), rad."""
    return model.bearing.theta_0 + 2 * pi * np.arange(model.bearing.Z) / model.bearing.Z


def defect_drops(model):
    """Return the drop (Z, slices) of each slice into the outer race's defect, if any."""
    defects, h = model.defects, np.zeros((model.bearing.Z, len(model.slices.table)))
    if len(defects.head):
        distances = defects.head[0, RADIUS] * np.angle(np.exp(1j * (angles(model) - defects.head[0, 2])))
        for row, s in zip(h, distances, strict=True):
            row[:] = [roller_drop(group, s, defects.head[0, 4])[0] for group in defects.groups[0]]
    return h


def slice_positions(model, q, tilt):
    """Return the positions (Z, slices, 3) of the slices, and their derivatives by q and by the tilt."""
    theta, zeta = angles(model), model.slices.table[:, 0, None]
    e_r = np.stack([np.cos(theta), np.sin(theta), 0 * theta], axis=1)[:, None]
    e_z, tilt = np.array([0.0, 0.0, 1.0]), tilt[:, None, None]
    axis, axis_derivative = np.sin(tilt) * e_r + np.cos(tilt) * e_z, np.cos(tilt) * e_r - np.sin(tilt) * e_z
    middle = (model.bearing.R_o + model.bearing.R_i) / 2
    return (middle + q[:, None, None]) * e_r + zeta * axis, e_r + 0 * zeta, zeta * axis_derivative


def radial_distance(away, mount):
    """Return the distance (Z, slices) of points from a ring's axis, and its direction (Z, slices, 3)."""
    axis = np.array([mount.tilt_x, mount.tilt_y, 0.0])
    axis[2] = np.sqrt(1 - axis @ axis)
    across = away - (away @ axis)[..., None] * axis
    rho = np.linalg.norm(across, axis=-1)
    return rho, across / rho[..., None]


def contacts(model, x):
    """Return law, approach (Z, slices) and its derivatives (4, Z, slices) by ring position, q, tilt, by race."""
    b, drop = model.bearing, model.slices.table[:, 2]
    u, q, tilt = unpack(model, x)
    p, by_q, by_tilt = slice_positions(model, q, tilt)
    rho, n = radial_distance(p - np.append(u, 0.0), model.mount_o)
    derivatives = np.stack([-n[..., 0], -n[..., 1], (n * by_q).sum(axis=-1), (n * by_tilt).sum(axis=-1)])
    outer = model.outer.stiffness, rho - b.R_o + b.R_w - drop - defect_drops(model), derivatives
    rho, n = radial_distance(p, model.mount_i)
    derivatives = np.stack([0 * rho, 0 * rho, -(n * by_q).sum(axis=-1), -(n * by_tilt).sum(axis=-1)])
    return outer, (model.inner.stiffness, b.R_i - rho + b.R_w - drop, derivatives)


def gyration(model):
    """Return the gyroscopic moment over tilt (N m) of a roller that orbits with the cage and spins."""
    b = model.bearing
    return b.omega_c * (b.I_r * (b.omega_c - b.omega_b) - model.I_t * b.omega_c)


def energy(model, x):
    """Return the elastic energy (J) of the bearing minus the work of load and centrifugal force."""
    b, support, weight = model.bearing, model.support, model.slices.table[:, 1]
    u, q, tilt = unpack(model, x)
    r, displacement = (b.R_o + b.R_i) / 2 + q, u - np.array([support.x_0, support.y_0])
    contact_energies = [
        9 / 19 * (weight * law.k * np.maximum(delta, 0) ** (19 / 9)).sum() for law, delta, _ in contacts(model, x)
    ]
    bracket = support.k_b / 2 * (displacement @ displacement) + support.F * u[0] + support.F_across * u[1]
    centrifugal = (b.m_r * b.omega_c**2 * r**2).sum() / 2
    return sum(contact_energies) + bracket - centrifugal + gyration(model) * (tilt**2).sum() / 2


def gradient(model, x):
    """Compute the gradient of the energy along x, in N and N mm."""
    b, support, weight = model.bearing, model.support, model.slices.table[:, 1]
    u, q, tilt = unpack(model, x)
    r, displacement = (b.R_o + b.R_i) / 2 + q, u - np.array([support.x_0, support.y_0])
    contact_forces = sum(
        (weight * law.k * np.maximum(delta, 0) ** (10 / 9) * along).sum(axis=-1)
        for law, delta, along in contacts(model, x)
    )
    by_u = contact_forces[:2].sum(axis=1) + support.k_b * displacement + np.array([support.F, support.F_across])
    by_q, by_tilt = contact_forces[2] - b.m_r * b.omega_c**2 * r, contact_forces[3] + gyration(model) * tilt
    return np.concatenate([by_u, by_q, 1e3 * by_tilt])


def hessian(model, x):
    """Compute the Hessian (N, N) of the energy by differences of ``gradient``."""
    columns = [(gradient(model, x + e) - gradient(model, x - e)) / (2 * STEP) for e in STEP * np.eye(len(x))]
    return (np.array(columns) + np.array(columns).T) / 2


def minimum(model, start):
    """Return the state of minimum energy near ``start``, and the residual force there over the load.

    Rounding of the energy limits a minimiser, by an amount that depends on the processor. Newton steps on the
    forces then reduce the residual. They raise ``LinAlgError`` where there is no minimum.
    """

    def micro(x: np.ndarray) -> float:
        return float(1e6 * energy(model, x))

    def along(x: np.ndarray) -> np.ndarray:
        return gradient(model, x)

    x = minimize(micro, start, jac=along, method="BFGS").x
    for _ in range(4):
        x = x - solve(hessian(model, x), gradient(model, x), assume_a="pos")
    return x, np.abs(gradient(model, x)).max() / abs(model.support.F)
