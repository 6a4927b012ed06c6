"""From the names of channels to places in the simulation's buffer, and from what lies there to what is meant."""

from typing import Any

import numpy as np

from bearingsim.config import Case, dataset_names
from bearingsim.config.names import roller_of
from bearingsim.core.advance import RING
from bearingsim.core.geometry.motion import speed_factor
from bearingsim.core.geometry.slices import WEIGHT
from bearingsim.core.layout import (
    AXIAL,
    LEAN_X,
    LEAN_X_C,
    LEAN_X_I,
    LEAN_Y,
    LEAN_Y_C,
    LEAN_Y_I,
    LOAD_I,
    LOAD_O,
    LOADED,
    PHI_C,
    POSITION,
    PSI,
    Q_F,
    Q_I,
    Q_O,
    Q_P,
    SKEW,
    SLIP_I,
    SLIP_O,
    SPIN_V,
    TILT,
    VELOCITY,
    X_C,
    X_I,
    Y_C,
    Y_I,
    Z_C,
    Z_I,
    Q,
    Z,
    slice_row,
)

MOTION = ("displacement", "velocity", "acceleration")
TURN_OF_CAGE, SPEED_OF_CAGE = POSITION + PHI_C, VELOCITY + PHI_C
PLACES = {
    **dict(zip((name for quantity in MOTION for name in dataset_names(f"ring.{quantity}")), RING, strict=True)),
    "ring.rotation": POSITION + PSI,
    "cage.speed": SPEED_OF_CAGE,
    "cage.slip": SPEED_OF_CAGE,
    "cage.position.x": POSITION + X_C,
    "cage.position.y": POSITION + Y_C,
    "inner.displacement.x": POSITION + X_I,
    "inner.displacement.y": POSITION + Y_I,
    "ring.axial": POSITION + Z,
    "ring.lean.x": POSITION + LEAN_X,
    "ring.lean.y": POSITION + LEAN_Y,
    "inner.axial": POSITION + Z_I,
    "inner.lean.x": POSITION + LEAN_X_I,
    "inner.lean.y": POSITION + LEAN_Y_I,
    "cage.axial": POSITION + Z_C,
    "cage.lean.x": POSITION + LEAN_X_C,
    "cage.lean.y": POSITION + LEAN_Y_C,
    "load_zone.rollers": LOADED,
}
OF_ROLLER = {
    "radial": Q,
    "outer_force": Q_O,
    "inner_force": Q_I,
    "outer_slip": SLIP_O,
    "inner_slip": SLIP_I,
    "cage_force": Q_P,
    "spin": SPIN_V,
    "tilt": TILT,
    "skew": SKEW,
    "axial": AXIAL,
    "flange_force": Q_F,
}
OF_SLICE = {"outer_line_load": LOAD_O, "inner_line_load": LOAD_I}
BASE = (*RING, LOADED, TURN_OF_CAGE, SPEED_OF_CAGE)
"""What features are computed from, whether it is recorded or not: the first rows of every recording."""


def place(name: str) -> int:
    """Where in the buffer a dataset's values come from."""
    found = roller_of(name)
    if found is None:
        return PLACES[name]
    roller, quantity = found
    kind, _, number = quantity.partition(".")
    row = slice_row(int(number) - 1, OF_SLICE[kind]) if number else OF_ROLLER[kind]
    return row + roller - 1


def recorded(case: Case) -> np.ndarray:
    """Places (C,) in the buffer that a run of the case records: ``BASE``, then what else it asks for."""
    asked = [place(name) for channel in case.record for name in dataset_names(channel)]
    return np.array([*BASE, *dict.fromkeys(p for p in asked if p not in BASE)], dtype=np.int64)


def series(
    case: Case, model: Any, rows: np.ndarray, places: np.ndarray, time: np.ndarray
) -> dict[str, np.ndarray]:
    """The recorded channels by dataset name, from rows (C, n) sampled at ``time`` (n,), s into the run."""
    row_of = {int(p): row for p, row in zip(places, rows, strict=True)}
    return {
        name: _meant(name, row_of[place(name)], model, time)
        for channel in case.record
        for name in dataset_names(channel)
    }


def _meant(name: str, values: np.ndarray, model: Any, time: np.ndarray) -> np.ndarray:
    """A channel from what the buffer keeps: turns beyond the kinematic ones, forces of slices."""
    b = model.bearing
    if name == "cage.speed":
        return values + b.omega_c * speed_factor(model, time)
    if name == "cage.slip":
        return -values / (b.omega_c * speed_factor(model, time))
    if name.endswith(".spin"):
        return (b.omega_b - b.omega_c) * speed_factor(model, time) - values
    if "_line_load." in name:
        return values / (model.slices.table[int(name.rpartition(".")[2]) - 1, WEIGHT] * model.L_w)
    return values
