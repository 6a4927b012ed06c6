"""Free rotation of a body in space, against the closed form of a symmetric top."""

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.advance import Monitor, start_at_rest
from bearingsim.core.methods.rk4 import RungeKutta4
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.outcomes import SUCCESS
from tests.core.models.test_planar_balance import orders
from tests.independent.spatial_bodies import tilt_vectors
from tests.scenes.nf308 import advance_recorded, case
from tests.scenes.spatial_bearing import NO_FRICTION, empty, even_slices, spatial_model

GAP = 1e-3  # m: distance from the races
SPEED = 3000.0  # rad/s
TILT, TILT_RATE = np.array([0.02, -0.05]), np.array([150.0, 90.0])
ROWS = np.array([lay.AXIS_X, lay.AXIS_Y, lay.AXIS_X_V, lay.AXIS_Y_V, lay.SPIN, lay.SPIN_V])


def free_rollers():
    """Return a bearing at rest whose rollers touch no race and spin at SPEED."""
    model = spatial_model(assemble.model(case(model="planar")), even_slices(2))
    bearing = model.bearing._replace(gap=GAP, omega_c=0.0, omega_i=0.0, omega_b=-SPEED)
    return model._replace(bearing=bearing, cage=model.cage._replace(play=GAP), friction=NO_FRICTION)


def simulate(model, h, span, make=RungeKutta4):
    """Return the motion (6, n + 1) of the first roller at every step.

    Rows: two components of the axis, their rates, angle and rate of the spin, relative to the kinematic ``SPEED``.
    """
    y = empty(model)
    for row, value in zip(ROWS[:4], (*TILT, *TILT_RATE), strict=True):
        y[row] = value
    y[lay.AXIAL_V] = 0.3
    start_at_rest(model, 0.0, y)
    n = round(span / h)
    out = np.empty((6, n + 1))
    out[:, 0] = y[ROWS]
    assert advance_recorded(make(h), model, Monitor(1000, 1.0), 0, y, ROWS, out[:, 1:])[1] == SUCCESS
    return out


def rotation(axis, angle):
    """Return the matrix of a rotation about ``axis`` by ``angle`` (rad)."""
    x, y, z = axis / np.linalg.norm(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def axis_of(tilt):
    """Return the axis with these two components."""
    return np.array([*tilt, np.sqrt(1 - tilt @ tilt)])


def orientation(tilt, angle):
    """Return the orientation of a body with this axis and angle."""
    frame = tilt_vectors(axis_of(tilt), np.eye(3)).T
    return frame @ rotation(np.array([0.0, 0.0, 1.0]), angle)


def free_top(model, t):
    """Return the orientation at ``t`` (s): spin about the axis, which precesses about the angular momentum."""
    a = axis_of(TILT)
    rate = np.array([*TILT_RATE, -(TILT @ TILT_RATE) / a[2]])
    precession = (rate[0] * a[1] - a[0] * rate[1]) / (1 + a[2])
    omega, I_a, I_t = SPEED + precession, model.bearing.I_r, model.I_t
    L = I_t * np.cross(a, rate) + I_a * omega * a
    spin = omega * (1 - I_a / I_t)
    return (
        rotation(L, np.linalg.norm(L) / I_t * t)
        @ orientation(TILT, 0.0)
        @ rotation(np.array([0.0, 0.0, 1.0]), spin * t)
    )


def test_a_free_roller_precesses_as_a_symmetric_top():
    """The error of the direction cosines after 24 turns of the roller is of fourth order in the step."""
    model, span = free_rollers(), 0.05
    errors = []
    for h in (2e-5, 1e-5, 5e-6):
        out = simulate(model, h, span)
        result = orientation(out[:2, -1], SPEED * span + out[4, -1])
        errors.append(np.abs(result - free_top(model, span)).max())
    assert orders(errors) == pytest.approx(4.0, abs=0.2)
    assert errors[-1] < 1e-6
    assert np.abs(orientation(TILT, SPEED * span) - free_top(model, span)).max() > 0.05


@pytest.mark.parametrize(("method", "order"), [(RungeKutta4, 4.0), (Verlet, 2.0)])
def test_free_roller_conserves_energy_and_angular_momentum(method, order):
    """The errors converge at least with the method's order (less 0.3)."""
    model = free_rollers()
    errors = []
    for h in (2e-5, 1e-5):
        out = simulate(model, h, 0.02, method)
        a = np.array([*out[:2], np.sqrt(1 - out[0] ** 2 - out[1] ** 2)])
        rate = np.array([*out[2:4], -(out[0] * out[2] + out[1] * out[3]) / a[2]])
        omega = SPEED + out[5] + (rate[0] * a[1] - a[0] * rate[1]) / (1 + a[2])
        L = model.I_t * np.cross(a.T, rate.T) + (model.bearing.I_r * omega * a).T
        energy = model.I_t * (rate**2).sum(axis=0) + model.bearing.I_r * omega**2
        errors.append([np.abs(L - L[0]).max() / np.linalg.norm(L[0]), np.ptp(energy) / energy[0]])
    assert (np.log2(np.divide(errors[0], errors[1])) > order - 0.3).all()
    assert (np.array(errors[1]) < (1e-6 if order > 3 else 1e-3)).all()
