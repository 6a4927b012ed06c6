"""Rest of a bearing in space by its energy alone: rings are circles about leaning axes, rollers points with axes.

Of the model only its data are used. The state x holds the ring's place (2,) and q (Z,) in um, then the tilts (Z,)
in 1e-3 rad; so ``gradient`` has forces in N and moments in N mm. The defect stays where it is under its
roller: the model too leaves out the force along the race that its slope would give.
"""

from math import pi

import numpy as np
from scipy.linalg import solve
from scipy.optimize import minimize

from bearingsim.core.defects.closed_forms import roller_drop
from bearingsim.core.defects.pairs import RADIUS

STEP = 1e-6  # of a state, for the slopes of forces
CONVERGED = 1e-8  # of the load; rounding of places leaves 1e-10 of it


def unpack(model, x):
    """The ring's place (2,) and q (Z,) in m, tilts (Z,) in rad."""
    Z = model.bearing.Z
    return x[:2] * 1e-6, x[2 : 2 + Z] * 1e-6, x[2 + Z :] * 1e-3


def angles(model):
    """Where the rollers stand (Z,), rad."""
    return model.bearing.theta_0 + 2 * pi * np.arange(model.bearing.Z) / model.bearing.Z


def defect_drops(model):
    """Sinking (Z, slices) of each slice at the outer race's defect, if there is one."""
    defects, h = model.defects, np.zeros((model.bearing.Z, len(model.slices.table)))
    if len(defects.head):
        distances = defects.head[0, RADIUS] * np.angle(np.exp(1j * (angles(model) - defects.head[0, 2])))
        for row, s in zip(h, distances, strict=True):
            row[:] = [roller_drop(group, s, defects.head[0, 4])[0] for group in defects.groups[0]]
    return h


def slice_positions(model, q, tilt):
    """Places (Z, slices, 3) of the slices, and how they move along with q and with the tilt."""
    theta, zeta = angles(model), model.slices.table[:, 0, None]
    e_r = np.stack([np.cos(theta), np.sin(theta), 0 * theta], axis=1)[:, None]
    e_z, tilt = np.array([0.0, 0.0, 1.0]), tilt[:, None, None]
    axis, axis_derivative = np.sin(tilt) * e_r + np.cos(tilt) * e_z, np.cos(tilt) * e_r - np.sin(tilt) * e_z
    middle = (model.bearing.R_o + model.bearing.R_i) / 2
    return (middle + q[:, None, None]) * e_r + zeta * axis, e_r + 0 * zeta, zeta * axis_derivative


def radial_distance(away, mount):
    """Distance (Z, slices) of places from a ring's axis, and the direction (Z, slices, 3) away from it."""
    axis = np.array([mount.tilt_x, mount.tilt_y, 0.0])
    axis[2] = np.sqrt(1 - axis @ axis)
    across = away - (away @ axis)[..., None] * axis
    rho = np.linalg.norm(across, axis=-1)
    return rho, across / rho[..., None]


def contacts(model, x):
    """Law, approach (Z, slices) and its slopes (4, Z, slices), along the ring's place, q, tilt, of either race."""
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
    """What tilts an axis that goes round with the cage and turns about itself, per tilt (N m)."""
    b = model.bearing
    return b.omega_c * (b.I_r * (b.omega_c - b.omega_b) - model.I_t * b.omega_c)


def energy(model, x):
    """Elastic energy (J) of the bearing less what load and centrifugal force give."""
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
    """The least energy that lies near ``start``, and what is left of the load (1) there.

    A minimiser stops where rounding hides the energy's fall: where, differs from one processor to the next.
    Newton's steps on the forces go on to where these vanish. They raise ``LinAlgError`` where there is no minimum.
    """

    def micro(x: np.ndarray) -> float:
        return float(1e6 * energy(model, x))

    def along(x: np.ndarray) -> np.ndarray:
        return gradient(model, x)

    x = minimize(micro, start, jac=along, method="BFGS").x
    for _ in range(4):
        x = x - solve(hessian(model, x), gradient(model, x), assume_a="pos")
    return x, np.abs(gradient(model, x)).max() / abs(model.support.F)
