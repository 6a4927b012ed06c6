"""``linearise`` of the models whose cage is kinematic against differences of their accelerations."""

from typing import Any

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.core import layout as lay
from bearingsim.core.defects.on_roller import roller_at_defect
from bearingsim.core.defects.pairs import ANGLE, HALF_WIDTH, RADIUS
from bearingsim.core.laws.damping.general import make_general
from bearingsim.core.laws.damping.hunt_crossley import HuntCrossley
from bearingsim.core.laws.damping.kraemer import Kraemer
from bearingsim.core.laws.stiffness.power_laws import TenNinths, ThreeHalves
from bearingsim.core.models.interface import degrees_of_freedom
from bearingsim.core.parameters import kinematic_angles
from tests.scenes.differences import cells, derivatives, differences
from tests.scenes.laws import with_laws
from tests.scenes.nf308 import case

DEFECT = {"shape": "rectangular", "length": "6 mm", "width": "0.8 mm", "depth": "0.05 mm", "angle": "20 deg"}
BOWL = DEFECT | {"shape": "circular", "width": "3 mm", "depth": "0.02 mm"}
LAWS = {
    "hunt-crossley": lambda k: HuntCrossley(TenNinths(k), 20.0),
    "kraemer": lambda k: Kraemer(ThreeHalves(20.0 * k), 2e-6),
    "general": lambda k: make_general(TenNinths(k), 1e9, 1.0, 1.0),
}


def model_of(name: str, law: str, *defects: dict[str, Any]) -> Any:
    """Return the NF308 with two different contacts."""
    model = assemble.model(case(model=name, defects=list(defects)))
    return with_laws(model, LAWS[law](1.6e9), LAWS[law](1.1e9))


def random_state(model: Any, rng: np.random.Generator) -> np.ndarray:
    """Return a buffer with ring and rollers at random positions near contact, with velocities of an impact."""
    y = assemble.empty_buffer(model)
    gap, roller_dof = model.bearing.gap, degrees_of_freedom(model)[0]
    y[lay.POSITION : lay.POSITION + 2] = rng.normal(0.0, 3.0 * gap + 2e-6, 2)
    y[lay.VELOCITY : lay.VELOCITY + 2] = rng.normal(0.0, 0.02, 2)
    if roller_dof:
        rollers = cells(model)[2:]
        y[lay.POSITION + rollers] = rng.normal(0.0, gap + 1e-6, len(rollers))
        y[lay.VELOCITY + rollers] = rng.normal(0.0, 0.02, len(rollers))
    return y


def random_time_over_defect(model: Any, rng: np.random.Generator) -> float:
    """Return a random time (s) at which a roller is over the first defect."""
    y = assemble.empty_buffer(model)
    while True:
        t = float(rng.uniform(0.0, 0.1))
        if abs(roller_at_defect(model, 0, t, y)[1]) < 0.9 * model.defects.head[0, HALF_WIDTH]:
            return t


def largest_error(model: Any, t: float, y: np.ndarray) -> float:
    """Return the largest error of an entry, over the largest entry of its row."""
    N = len(cells(model))
    result = derivatives(model, t, y)
    expected = differences(model, t, y, (np.full(N, 2e-11), np.full(N, 1e-6)))
    errors = [
        np.abs(value - reference) / np.maximum(np.abs(reference).max(axis=1, keepdims=True), 1e-300)
        for value, reference in zip(result, expected, strict=True)
    ]
    return float(np.max(errors))


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", ["ring", "rollers"])
@pytest.mark.parametrize(
    "defects",
    [(), (DEFECT,), (BOWL | {"race": "inner"},), (DEFECT, BOWL | {"race": "inner"}, DEFECT | {"race": "roller"})],
    ids=["healthy", "outer", "inner", "all"],
)
def test_derivatives_are_those_of_the_accelerations(name, law, defects):
    """In 90 % of the states; in the others a contact is within a step of its kink."""
    model = model_of(name, law, *defects)
    rng = np.random.default_rng(11)
    errors = []
    for _ in range(40):
        t = random_time_over_defect(model, rng) if defects else float(rng.uniform(0.0, 0.1))
        errors.append(largest_error(model, t, random_state(model, rng)))
    assert np.quantile(errors, 0.9) < 1e-6


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", ["ring", "rollers"])
def test_over_two_defects_at_once(name, law):
    """Roller 1 is over a defect of each race: in series, each changes the closing rate of the other contact."""
    model, t = model_of(name, law, BOWL, BOWL | {"race": "inner"}), 0.01
    rng, head = np.random.default_rng(3), model.defects.head
    theta_c, theta_i, _ = kinematic_angles(model.bearing, t)
    errors = []
    for _ in range(20):
        head[:, ANGLE] = theta_c + rng.uniform(-1.0, 1.0, 2) * 8e-4 / head[:, RADIUS] - [0.0, theta_i]
        y = random_state(model, rng)
        y[lay.POSITION + lay.X] = -2.0 * model.bearing.gap - 2e-5
        errors.append(largest_error(model, t, y))
    assert np.quantile(errors, 0.9) < 1e-6
