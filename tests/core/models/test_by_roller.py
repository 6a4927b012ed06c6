"""Models defined by functions of one roller: one loop for drift, loads and sums, with any model and method."""

from typing import Any, NamedTuple

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.jit import jit
from bearingsim.core.methods.interface import step
from bearingsim.core.methods.symplectic_euler import SymplecticEuler
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.models import by_roller
from bearingsim.core.models.by_roller import (
    NoUpdate,
    accelerate_roller,
    accelerate_shared,
    load_roller,
    shared_quantities,
)
from bearingsim.core.models.interface import accelerations, begin, degrees_of_freedom, state_width
from bearingsim.core.parameters import Bearing, lanes
from bearingsim.core.sums import sum_loads
from tests.scenes.lanes import compiled, keeps_lanes, needs_vectors
from tests.scenes.nf308 import SLOT, case

STIFFNESS = 1e6  # N/m, of the springs of ``Beads``


class Beads(NamedTuple):
    """A model of another package: every roller on a spring to the ring, which has no other support."""

    bearing: Bearing


by_roller.register_roller_model(Beads)
state_width.register(Beads)(lambda model: lay.FIRST_LANE + lanes(model.bearing))
degrees_of_freedom.register(Beads)(lambda model: (1, 2))


@shared_quantities.register(Beads)
def _shared(model, t, y):
    return y[lay.POSITION + lay.X], y[lay.POSITION + lay.Y]


@load_roller.register(Beads)
def _load_roller(model, common, y, j):
    u_x, u_y = common
    c, s = y[lay.COS_0 + j], y[lay.SIN_0 + j]
    y[lay.Q_O + j] = STIFFNESS * (y[lay.RADIAL + j] - u_x * c - u_y * s)
    y[lay.roller_load(lay.F_X) + j] = y[lay.Q_O + j] * c
    y[lay.roller_load(lay.F_Y) + j] = y[lay.Q_O + j] * s


@accelerate_shared.register(Beads)
def _accelerate_shared(model, common, t, y):
    sum_loads(lay.F_X, lay.F_Y, y, lanes(model.bearing))
    y[lay.ACCELERATION + lay.X] = y[lay.F_X] / model.bearing.m_o
    y[lay.ACCELERATION + lay.Y] = y[lay.F_Y] / model.bearing.m_o


@accelerate_roller.register(Beads)
def _accelerate_roller(model, common, body_acceleration, y, j):
    y[lay.RADIAL_A + j] = -y[lay.INVERSE_MASS + j] * y[lay.Q_O + j]


@begin.register(Beads)
def _begin(model, t, y):
    accelerations(model, t, y)


@jit
def run(method, model, count, y):
    begin(model, 0.0, y)
    for n in range(count):
        step(method, model, n * method.h, y)


evaluate_at_once = jit(by_roller.evaluate_at_once)


@jit
def run_at_once(method, model, count, y):
    begin(model, 0.0, y)
    for n in range(count):
        evaluate_at_once(model, method, (n + 1) * method.h, y)


def beads() -> tuple[Beads, np.ndarray]:
    model = Beads(assemble.model(case(model="rollers")).bearing)
    y = lay.make_buffer(model.bearing.Z, model.bearing.m_r)
    y[lay.RADIAL : lay.RADIAL + 13] = 1e-6 * np.arange(13)
    return model, y


def test_an_external_model_follows_its_equations() -> None:
    """A linear system, by its eigenvectors: sqrt of the masses on both sides makes it symmetric."""
    (model, y), h, count = beads(), 1e-6, 500
    b, angle = model.bearing, 2.0 * np.pi * np.arange(13) / 13
    arms = np.vstack([-np.cos(angle), -np.sin(angle), np.eye(13)])  # elongation of each spring per coordinate
    per_root = 1.0 / np.sqrt([b.m_o, b.m_o, *[b.m_r] * 13])
    K, modes = np.linalg.eigh(STIFFNESS * per_root[:, None] * (arms @ arms.T) * per_root)
    start = np.array([0.0, 0.0, *y[lay.RADIAL : lay.RADIAL + 13]]) / per_root
    expected = per_root * (modes @ (np.cos(np.sqrt(np.maximum(K, 0.0)) * h * count) * (modes.T @ start)))
    run(Verlet(h), model, count, y)
    result = [y[lay.POSITION], y[lay.POSITION + 1], *y[lay.RADIAL : lay.RADIAL + 13]]
    assert result == pytest.approx(expected, rel=1e-3, abs=1e-10)
    assert np.abs(expected - start * per_root).max() > 1e-7


def model_and_state(name: str) -> tuple[Any, np.ndarray]:
    bearing_case = case(model=name, method="verlet", defect=SLOT)
    model = assemble.model(bearing_case)
    return model, assemble.start(bearing_case, model)[0]


@pytest.mark.parametrize("method", [Verlet(4e-7), SymplecticEuler(4e-7)])
@pytest.mark.parametrize("name", ["ring", "rollers", "planar", "beads"])
def test_one_pass_over_the_rollers_equals_separate_loops(name: str, method: Any) -> None:
    """To rounding, which the sums of friction amplify."""
    model, y = beads() if name == "beads" else model_and_state(name)
    combined = y.copy()
    run(method, model, 300, y)
    run_at_once(method, model, 300, combined)
    state = slice(lay.POSITION, lay.POSITION + 3 * lay.STATE)
    assert y[state] == pytest.approx(combined[state], rel=1e-9, abs=1e-18)
    assert np.abs(y[lay.VELOCITY : lay.VELOCITY + 2]).max() > 0.0


@needs_vectors
@pytest.mark.parametrize("method", [Verlet(4e-7), NoUpdate()])
@pytest.mark.parametrize("name", ["ring", "rollers", "planar", "beads"])
def test_both_loops_over_rollers_keep_their_lanes(name: str, method: Any) -> None:
    model, y = beads() if name == "beads" else model_and_state(name)
    common, body_acceleration, n = shared_quantities(model, 0.0, y), 0.0, lanes(model.bearing)
    assert keeps_lanes(compiled(by_roller.load_rollers.py_func), model, method, common, y, n)
    if name != "ring":  # whose rollers have no mass
        assert keeps_lanes(
            compiled(by_roller.accelerate_rollers.py_func), model, method, common, body_acceleration, y, n
        )
