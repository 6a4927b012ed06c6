"""Buffer cells of the channels, and channel values read from the recorded rows."""

from functools import lru_cache
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

MOTION = ("displacement", "velocity", "acceleration")  # quantities of the ring's motion
CAGE_ANGLE, CAGE_SPEED = lay.POSITION + lay.PHI_C, lay.VELOCITY + lay.PHI_C
CELLS = {
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
ROLLER_ROWS = {
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
SLICE_ROWS = {"outer_line_load": lay.LOAD_O, "inner_line_load": lay.LOAD_I}
FEATURE_CELLS = (*RING_MOTION, lay.LOADED_ROLLERS, CAGE_ANGLE, CAGE_SPEED)
"""Cells from which features are computed; the first rows of every recording, even if not requested."""
SENSOR_CELLS = (lay.SENSOR, lay.SENSOR_V, lay.SENSOR_A)
"""Rows after ``FEATURE_CELLS`` for a flexible ring: radial displacement, velocity, acceleration at the sensor."""


def feature_cells(case: Case) -> tuple[int, ...]:
    """Return the buffer cells from which features are computed, the first rows of a case's recording."""
    return FEATURE_CELLS if case.rig.ring is None else FEATURE_CELLS + SENSOR_CELLS


def cells_of(case: Case, name: str) -> tuple[int, ...]:
    """Return the buffer cells of a dataset; for the sensor on a rigid ring, those of both coordinates."""
    body, _, quantity = name.partition(".")
    if body == "sensor" and case.rig.ring is None:
        return tuple(CELLS[component] for component in dataset_names(f"ring.{quantity}"))
    return (cell_of(name),)


def cell_of(name: str) -> int:
    """Return the buffer cell of a dataset."""
    match = roller_of(name)
    if match is None:
        return CELLS[name]
    roller, quantity = match
    kind, _, number = quantity.partition(".")
    row = lay.slice_row(int(number) - 1, SLICE_ROWS[kind]) if number else ROLLER_ROWS[kind]
    return row + roller - 1


@lru_cache(maxsize=256)
def recorded_cells(case: Case) -> np.ndarray:
    """Return the buffer cells (C,) recorded for a case, read-only: ``feature_cells``, then its channels.

    If the motion may be periodic, a channel of one roller is recorded for all rollers, because passes that are not
    computed are filled in from other rollers.
    """
    names = [name for channel in case.record for name in dataset_names(channel)]
    requested_cells = np.array([p for name in names for p in cells_of(case, name)], dtype=np.int64)
    if may_repeat(case):
        roller_cells = requested_cells[lay.lane_of(requested_cells) >= 0]
        rows = np.unique(roller_cells - lay.lane_of(roller_cells))
        requested_cells = np.concatenate(
            [requested_cells, np.add.outer(rows, np.arange(case.bearing.rollers)).ravel()]
        )
    first_cells = feature_cells(case)
    cells = np.array(
        [*first_cells, *dict.fromkeys(p for p in requested_cells.tolist() if p not in first_cells)], dtype=np.int64
    )
    cells.flags.writeable = False
    return cells


def requested_rows(case: Case, cells: np.ndarray) -> np.ndarray:
    """Return the numbers (R,) of the rows of ``recorded_cells`` that the channels in `record` need."""
    row_of = {int(p): row for row, p in enumerate(cells)}
    names = [name for channel in case.record for name in dataset_names(channel)]
    rows = [row_of[p] for name in names for p in cells_of(case, name)]
    return np.array([*dict.fromkeys(rows)], dtype=np.int64)


def stores_raw_values(case: Case) -> bool:
    """Check if unfiltered values are stored at the sampling instants (of all channels, or of contact forces)."""
    return not case.antialias or any(map(is_contact_force, case.record))


def contact_force_mask(case: Case, cells: np.ndarray) -> np.ndarray:
    """Return a mask (R,) of the cells (R,) of contact forces that the case records."""
    names = [name for channel in case.record if is_contact_force(channel) for name in dataset_names(channel)]
    if not names:
        return np.zeros(len(cells), dtype=bool)
    return np.isin(cells, [p for name in names for p in cells_of(case, name)])


def read_channels(
    case: Case, model: Any, rows: np.ndarray, cells: np.ndarray, time: np.ndarray
) -> dict[str, np.ndarray]:
    """Return the recorded channels by dataset name.

    rows: (C, n) recorded values of ``cells`` (C,); time: (n,) of the samples, s into the run.
    """
    row_of = {int(p): row for p, row in zip(cells, rows, strict=True)}
    return {
        name: _channel_values(
            name, project_on_sensor(case, [row_of[p] for p in cells_of(case, name)]), model, time
        )
        for channel in case.record
        for name in dataset_names(channel)
    }


def project_on_sensor(case: Case, rows: list[np.ndarray]) -> np.ndarray:
    """Return the values of a single row, or the projection of two coordinates on the sensor axis."""
    if len(rows) == 1:
        return rows[0]
    return cos(case.rig.sensor_angle) * rows[0] + sin(case.rig.sensor_angle) * rows[1]


def _channel_values(name: str, values: np.ndarray, model: Any, time: np.ndarray) -> np.ndarray:
    """Convert buffer values to a channel: relative speeds to absolute ones, slice forces to line loads."""
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
