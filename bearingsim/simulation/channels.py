"""From the names of channels to places in the simulation's buffer, and from what lies there to what is meant."""

from math import cos, sin
from typing import Any

import numpy as np

from bearingsim.config import Case, dataset_names
from bearingsim.config.channels import is_contact_force
from bearingsim.config.names import roller_of
from bearingsim.core import layout as lay
from bearingsim.core.advance import RING_MOTION
from bearingsim.core.geometry.motion import speed_factor
from bearingsim.core.geometry.slices import WEIGHT
from bearingsim.simulation.repetition import may_repeat

MOTION = ("displacement", "velocity", "acceleration")
CAGE_ANGLE, CAGE_SPEED = lay.POSITION + lay.PHI_C, lay.VELOCITY + lay.PHI_C
PLACES = {
    **dict(
        zip((name for quantity in MOTION for name in dataset_names(f"ring.{quantity}")), RING_MOTION, strict=True)
    ),
    "sensor.displacement": lay.SENSOR,
    "sensor.velocity": lay.SENSOR_V,
    "sensor.acceleration": lay.SENSOR_A,
    "ring.rotation": lay.POSITION + lay.PSI,
    "cage.speed": CAGE_SPEED,
    "cage.slip": CAGE_SPEED,
    "cage.position.x": lay.POSITION + lay.X_C,
    "cage.position.y": lay.POSITION + lay.Y_C,
    "inner.displacement.x": lay.POSITION + lay.X_I,
    "inner.displacement.y": lay.POSITION + lay.Y_I,
    "ring.axial": lay.POSITION + lay.Z,
    "ring.lean.x": lay.POSITION + lay.RING_TILT_X,
    "ring.lean.y": lay.POSITION + lay.RING_TILT_Y,
    "inner.axial": lay.POSITION + lay.Z_I,
    "inner.lean.x": lay.POSITION + lay.INNER_TILT_X,
    "inner.lean.y": lay.POSITION + lay.INNER_TILT_Y,
    "cage.axial": lay.POSITION + lay.Z_C,
    "cage.lean.x": lay.POSITION + lay.CAGE_TILT_X,
    "cage.lean.y": lay.POSITION + lay.CAGE_TILT_Y,
    "load_zone.rollers": lay.LOADED_ROLLERS,
}
OF_ROLLER = {
    "radial": lay.RADIAL,
    "outer_force": lay.Q_O,
    "inner_force": lay.Q_I,
    "outer_slip": lay.SLIP_O,
    "inner_slip": lay.SLIP_I,
    "cage_force": lay.Q_P,
    "spin": lay.SPIN_V,
    "tilt": lay.TILT,
    "skew": lay.SKEW,
    "axial": lay.AXIAL,
    "flange_force": lay.Q_F,
}
OF_SLICE = {"outer_line_load": lay.LOAD_O, "inner_line_load": lay.LOAD_I}
BASE = (*RING_MOTION, lay.LOADED_ROLLERS, CAGE_ANGLE, CAGE_SPEED)
"""What features are computed from, whether it is recorded or not: the first rows of every recording."""
AT_SENSOR = (lay.SENSOR, lay.SENSOR_V, lay.SENSOR_A)
"""Of a ring that bends the rows after them: its radial displacement, velocity, acceleration at the sensor."""


def base(case: Case) -> tuple[int, ...]:
    """Return places in the buffer of the first rows of the case's recording, which features are computed from."""
    return BASE if case.rig.ring is None else BASE + AT_SENSOR


def places_of(case: Case, name: str) -> tuple[int, ...]:
    """List places in the buffer of a dataset's values: of a rigid ring's sensor those of both coordinates."""
    of, _, quantity = name.partition(".")
    if of == "sensor" and case.rig.ring is None:
        return tuple(PLACES[component] for component in dataset_names(f"ring.{quantity}"))
    return (place(name),)


def place(name: str) -> int:
    """Return the place in the buffer that a dataset's values come from."""
    found = roller_of(name)
    if found is None:
        return PLACES[name]
    roller, quantity = found
    kind, _, number = quantity.partition(".")
    row = lay.slice_row(int(number) - 1, OF_SLICE[kind]) if number else OF_ROLLER[kind]
    return row + roller - 1


def recorded(case: Case) -> np.ndarray:
    """Return places (C,) in the buffer that a run of the case records: ``base``, then what else it asks for.

    Of a roller whose motion may repeat, those of all rollers: what it does later, others have done before it.
    """
    names = [name for channel in case.record for name in dataset_names(channel)]
    asked = np.array([one for name in names for one in places_of(case, name)], dtype=np.int64)
    if may_repeat(case):
        of_roller = asked[lay.lane_of(asked) >= 0]
        rows = np.unique(of_roller - lay.lane_of(of_roller))
        asked = np.concatenate([asked, np.add.outer(rows, np.arange(case.bearing.rollers)).ravel()])
    first = base(case)
    return np.array([*first, *dict.fromkeys(p for p in asked.tolist() if p not in first)], dtype=np.int64)


def asked(case: Case, places: np.ndarray) -> np.ndarray:
    """Return the rows of ``recorded`` that the case's own channels lie in."""
    row_of = {int(p): row for row, p in enumerate(places)}
    names = [name for channel in case.record for name in dataset_names(channel)]
    found = [row_of[one] for name in names for one in places_of(case, name)]
    return np.array([*dict.fromkeys(found)], dtype=np.int64)


def picks(case: Case) -> bool:
    """Tell whether raw values are kept at the record's instants: of all, or of contact forces."""
    return not case.antialias or any(map(is_contact_force, case.record))


def are_contact_forces(case: Case, places: np.ndarray) -> np.ndarray:
    """Return which of some places (R,) of the buffer hold contact forces that the case records: (R,) booleans."""
    names = [name for channel in case.record if is_contact_force(channel) for name in dataset_names(channel)]
    return np.isin(places, [one for name in names for one in places_of(case, name)])


def series(
    case: Case, model: Any, rows: np.ndarray, places: np.ndarray, time: np.ndarray
) -> dict[str, np.ndarray]:
    """Return the recorded channels by dataset name, from rows (C, n) sampled at ``time`` (n,), s into the run."""
    row_of = {int(p): row for p, row in zip(places, rows, strict=True)}
    return {
        name: _meant(name, along(case, [row_of[one] for one in places_of(case, name)]), model, time)
        for channel in case.record
        for name in dataset_names(channel)
    }


def along(case: Case, rows: list[np.ndarray]) -> np.ndarray:
    """Return values of one row; of both coordinates of a ring in the direction the sensor looks."""
    if len(rows) == 1:
        return rows[0]
    return cos(case.rig.sensor_angle) * rows[0] + sin(case.rig.sensor_angle) * rows[1]


def _meant(name: str, values: np.ndarray, model: Any, time: np.ndarray) -> np.ndarray:
    """Return a channel from what the buffer keeps: turns beyond the kinematic ones, forces of slices."""
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
