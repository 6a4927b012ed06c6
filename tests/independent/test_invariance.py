"""Units of length, directions and numbers of rollers do not matter, nor, in `spatial`, left and right."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
import pytest

from bearingsim import assemble
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.core.advance import Monitor
from bearingsim.core.methods.verlet import Verlet
from bearingsim.core.outcomes import SUCCESS
from bearingsim.simulation.limits import step_limits
from bearingsim.simulation.settling import settling_time
from bearingsim.study.ranges import pressure
from tests.independent.invariant_cases import ROLLERS, View, case_of, flexible, planar, ring, rollers, spatial
from tests.scenes.nf308 import advance_recorded

STEP, STEPS = 0.4e-6, 6000
VECTORS = ("ring", "inner ring", "tilt of the ring", "tilt of the inner ring", "axes of the rollers")
ANGLE = 37.0


def cells(name: str) -> dict[str, list[int]]:
    """Cells of velocities and forces that the model has; complex: those of e_0, then those of e_90."""
    v, lanes = lay.VELOCITY, range(ROLLERS)
    result = {"ring": [v + lay.X, v + lay.Y], "outer forces": [lay.Q_O + j for j in lanes]}
    if name != "ring":
        result |= {"inner forces": [lay.Q_I + j for j in lanes], "radial": [lay.RADIAL_V + j for j in lanes]}
    if name in ("planar", "spatial"):
        result |= {
            "inner ring": [v + lay.X_I, v + lay.Y_I], "cage": [v + lay.PHI_C],
            "along the cage": [lay.EPS_V + j for j in lanes], "spin": [lay.SPIN_V + j for j in lanes],
        }  # fmt: skip
    if name == "spatial":
        result |= {
            "tilt of the ring": [v + lay.RING_TILT_X, v + lay.RING_TILT_Y],
            "tilt of the inner ring": [v + lay.INNER_TILT_X, v + lay.INNER_TILT_Y],
            "axes of the rollers": [row + j for row in (lay.AXIS_X_V, lay.AXIS_Y_V) for j in lanes],
            "axial": [v + lay.Z, v + lay.Z_I, v + lay.Z_C, *(lay.AXIAL_V + j for j in lanes)],
        }
    return result


def model_of(make: Callable, view: View, anchor: complex | None = None) -> tuple[Case, Any]:
    """Case and model; anchor: of the ring's support (m), instead of its own."""
    case = case_of(make, view)
    model = assemble.model(case)
    if anchor is not None:
        model = model._replace(support=model.support._replace(x_0=anchor.real, y_0=anchor.imag))
    return case, model


def anchor_of(make: Callable, view: View) -> complex:
    support = model_of(make, view)[1].support
    return complex(support.x_0, support.y_0)


def series(make: Callable, view: View, anchor: complex | None = None) -> dict[str, np.ndarray]:
    """Recorded quantities (of vectors, complex), at every tenth step of a run from rest."""
    rows, (case, model) = cells(make.__name__), model_of(make, view, anchor)
    y, _ = assemble.start(case, model)
    all_cells = np.concatenate([*rows.values()]).astype(int)
    out = np.empty((len(all_cells), STEPS // 3 if make is spatial else STEPS))
    steps, outcome, _ = advance_recorded(Verlet(STEP * view.size), model, Monitor(8, 1.0), 0, y, all_cells, out)
    assert (steps, outcome) == (out.shape[1], SUCCESS)
    ends = np.cumsum([len(row) for row in rows.values()])[:-1]
    result = dict(zip(rows, np.split(out[:, 9::10], ends), strict=True))
    for name in set(VECTORS) & set(result):
        along, across = np.split(result[name], 2)
        result[name] = along + 1j * across
    return result


def difference(seen: dict[str, np.ndarray], expected: dict[str, np.ndarray]) -> float:
    """Largest difference of any quantity over its range."""
    return max(
        float(np.abs(seen[name] - row).max() / (np.ptp(np.abs(row)) or 1.0)) for name, row in expected.items()
    )


def resized(expected: dict[str, np.ndarray], size: float) -> dict[str, np.ndarray]:
    """Velocities stay, forces grow by the square of the size, rates of angles fall by it."""
    powers = {"outer forces": 2, "inner forces": 2, "cage": -1, "along the cage": -1, "spin": -1}
    return {name: row * size ** powers.get(name, 0) for name, row in expected.items()}


@pytest.fixture(scope="module")
def reference() -> Callable[[Callable], dict[str, np.ndarray]]:
    """Series of each model in the usual view, computed once."""
    return lru_cache(lambda make: series(make, View()))


@pytest.mark.parametrize("make", [ring, rollers, planar])
def test_series_do_not_depend_on_the_unit_of_length(make, reference):
    """Within 1e-9: rounding, of which 1e-11 was measured."""
    assert difference(series(make, View(size=4.0)), resized(reference(make), 4.0)) < 1e-9


@pytest.mark.parametrize("make", [ring, rollers, planar, flexible, spatial])
def test_series_turn_with_the_bearing(make, reference):
    """Within 1e-8, rounding (1e-10 was measured).

    The anchor is a mean over some angles of the cage, counted from the load line, so it is compared by itself:
    within 1e-4 (7e-6 was measured in `spatial`, less elsewhere).
    """
    turn = np.exp(1j * np.radians(ANGLE))
    anchor = anchor_of(make, View()) * turn
    assert abs(anchor_of(make, View(angle=ANGLE)) - anchor) <= 1e-4 * abs(anchor)
    turned = {name: row * turn if name in VECTORS else row for name, row in reference(make).items()}
    assert difference(series(make, View(angle=ANGLE), anchor), turned) < 1e-8


@pytest.mark.parametrize("make", [ring, rollers, planar])
def test_series_do_not_depend_on_the_numbers_of_the_rollers(make, reference):
    """Within 1e-9 (4e-13 was measured)."""
    renumbered = {
        name: np.roll(row, -1, axis=0) if len(row) == ROLLERS else row for name, row in reference(make).items()
    }
    assert difference(series(make, View(renumbered=1)), renumbered) < 1e-9


def test_series_of_a_mirrored_bearing(reference):
    """Tilt and axial motion change their sign, within 1e-9 (1e-13 was measured)."""
    odd = ("axial", "tilt of the ring", "tilt of the inner ring", "axes of the rollers")
    mirrored = {name: -row if name in odd else row for name, row in reference(spatial).items()}
    assert difference(series(spatial, View(mirror=-1.0)), mirrored) < 1e-9


@pytest.mark.parametrize("make", [ring, planar])
def test_limits_do_not_depend_on_the_unit_of_length(make):
    """Times grow with the size, forces by its square, rates fall, energy by its cube; ratios and pressure stay.

    Within 1e-5: limits are found by bisection to 1e-6.
    """
    powers = dict.fromkeys(("damping_time", "at_rest", "at_impact", "crossing", "wave", "approach_bound"), 1)
    powers |= dict.fromkeys(("contact_frequency", "fastest_rate"), -1) | dict.fromkeys(
        ("rest_load", "impact_force"), 2
    )
    powers |= {"damping_ratio": 0, "closing_speed": 0, "energy_bound": 3}
    plain, large = (case_of(make, View(size=size)) for size in (1.0, 4.0))
    limits, limits_of_large = step_limits(plain), step_limits(large)
    for name, power in powers.items():
        assert getattr(limits_of_large, name) == pytest.approx(getattr(limits, name) * 4.0**power, rel=1e-5), name
    assert pressure(large) == pytest.approx(pressure(plain), rel=1e-6)


def test_settling_does_not_depend_on_the_unit_of_length():
    """A ring of 20 kg, which settles for longer than the least time and than five turns of the cage."""

    def heavy(size: float) -> Case:
        view = View(size=size)
        rig = planar(view)["rig"] | {"ring_mass": view.quantity(20.0, "kg", 3)}
        return case_of(planar, view, rig=rig)

    assert settling_time(heavy(4.0)) == pytest.approx(4.0 * settling_time(heavy(1.0)), rel=1e-6)
