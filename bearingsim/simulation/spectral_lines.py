"""Spectral lines of a run at characteristic frequencies, and the motion along the sensor axis."""

from collections.abc import Iterable, Iterator, Mapping
from math import ceil, floor, pi
from typing import Any, NamedTuple

import numpy as np

from bearingsim import cpu_time, signals
from bearingsim.config import Case
from bearingsim.config.names import HARMONICS, LINES, Line, line_name
from bearingsim.core.geometry.motion import kinematic_times
from bearingsim.simulation.channels import (
    CAGE_ANGLE,
    FEATURE_CELLS,
    MOTION,
    SENSOR_CELLS,
    cells_of,
    feature_cells,
    project_on_sensor,
)
from bearingsim.simulation.pilot import elements_with_deviations
from bearingsim.simulation.pricing import BLOCK
from bearingsim.simulation.recording import LowPassed, RawRecord, first_sample, whole_passes, windows
from bearingsim.simulation.settling import has_free_cage
from bearingsim.simulation.time_grid import Grid

MIN_PASSES = 3
"""Smallest number of ball passes for lines of unequal passes, because interpolation uses up the ends."""

ROW_OF = {cell: row for row, cell in enumerate(FEATURE_CELLS + SENSOR_CELLS)}
OTHER_LINES = {name: line for name, line in LINES.items() if not line.outer}


MULTIPLES = np.array(list(LINES.values())).T[:, :, np.newaxis]
"""Fields of ``Line`` (5, lines, 1) of all ``LINES``."""


class SampleAngles(NamedTuple):
    """Angles (n,) in rad at fine samples: of the cage (first roller), the inner ring, and a roller in the cage."""

    cage: np.ndarray
    inner: np.ndarray
    roll: np.ndarray

    def ends(self) -> "SampleAngles":
        """Return the first and the last angles."""
        return SampleAngles(self.cage[[0, -1]], self.inner[[0, -1]], self.roll[[0, -1]])

    def phase(self, line: Line, Z: int) -> np.ndarray:
        """Return the phase angle (n,) of a line."""
        return self._phase(line, Z)

    def phases(self, Z: int) -> np.ndarray:
        """Return the phase angles (lines, n) of all ``LINES``."""
        return self._phase(MULTIPLES, Z)

    def _phase(self, multiples: Iterable[Any], Z: int) -> np.ndarray:
        outer, inner, spin, cage, shaft = multiples
        races = outer * Z * self.cage + inner * Z * (self.inner - self.cage)
        return races + spin * self.roll + cage * self.cage + shaft * self.inner


def feature_rows(case: Case) -> np.ndarray:
    """Return the rows of a recording from which features are computed."""
    return np.arange(len(feature_cells(case)))


def sensor_series(case: Case, rows: np.ndarray, quantity: str) -> np.ndarray:
    """Project a quantity of the ring on the sensor axis; for a flexible ring, return its value at the sensor."""
    return project_on_sensor(case, [rows[ROW_OF[cell]] for cell in cells_of(case, f"sensor.{quantity}")])


def blocks(count: int) -> Iterator[tuple[int, int]]:
    """Yield start and end of blocks that cover ``count`` samples. Raises OutOfCpuTime if the job's time is up."""
    for begin in range(0, count, BLOCK):
        cpu_time.check()
        yield begin, min(begin + BLOCK, count)


def sensor_samples(case: Case, raw: RawRecord | LowPassed, quantity: str, start: int, count: int) -> np.ndarray:
    """Return ``sensor_series`` of fine samples (count,) from number ``start`` on."""
    rows, out = np.array([ROW_OF[cell] for cell in cells_of(case, f"sensor.{quantity}")]), np.empty(count)
    for begin, end in blocks(count):
        out[begin:end] = project_on_sensor(case, list(raw.read(start + begin, end - begin, rows)))
    return out


def sample_angles(model: Any, grid: Grid, start: int, slip: np.ndarray) -> SampleAngles:
    """Return the angles at fine samples from number ``start`` on; slip: (n,) cage angle (rad) minus kinematic."""
    b = model.bearing
    t = kinematic_times(model, (start + np.arange(len(slip))) / grid.fine_rate)
    return SampleAngles(
        b.theta_0 + b.omega_c * t + slip, b.omega_i * t, b.omega_b * t + b.omega_b / b.omega_c * slip
    )


def angles_of_record(case: Case, model: Any, grid: Grid, raw: RawRecord, start: int, count: int) -> SampleAngles:
    """Return the angles at ``count`` fine samples of a record from number ``start`` on, cage slip included."""
    slip = np.zeros(count)
    if has_free_cage(case):
        (slip,) = raw.read(start, count, np.array([ROW_OF[CAGE_ANGLE]]))
    return sample_angles(model, grid, start, slip)


def ball_pass_lines(case: Case, pass_lines: Mapping[str, np.ndarray]) -> dict[str, float]:
    """Return amplitude, phase and scatter of the lines at BPFO and its multiples, from ``lines_of_passes``."""
    columns = {}
    has_others = has_other_lines(case)
    for quantity, lines in pass_lines.items():
        for harmonic, values in zip(HARMONICS, lines, strict=True):
            name = f"{quantity}@{line_name(harmonic)}"
            columns[name], columns[f"{name}.phase"], columns[f"{name}-scatter"] = signals.mean_amplitude(
                values, has_others
            )
    return columns or dict.fromkeys(_ball_pass_names(), float("nan"))


def has_other_lines(case: Case) -> bool:
    """Check if a record has content other than the lines of BPFO, whose periods do not fit into a ball pass.

    On a ramp the natural vibration is such content, because its frequency does not follow the speed.
    """
    turns = case.unbalance is not None or any(element != "outer" for element in elements_with_deviations(case))
    return turns or has_unequal_passes(case)


def has_unequal_passes(case: Case) -> bool:
    """Check if ball passes differ in duration, because the cage is free or the speed changes."""
    return has_free_cage(case) or case.ramp is not None


def lines_of_passes(case: Case, model: Any, grid: Grid, raw: RawRecord) -> dict[str, np.ndarray]:
    """Return the lines (harmonics, passes) of each quantity; besides other lines, in windows of two passes.

    Empty if the record is too short for passes of unequal duration, or for these windows.
    """
    return (_lines_at_equal_angles if has_unequal_passes(case) else _lines_at_equal_times)(case, model, grid, raw)


def _lines_at_equal_times(case: Case, model: Any, grid: Grid, raw: RawRecord) -> dict[str, np.ndarray]:
    """Return the lines (harmonics, passes) of each quantity for passes of equal duration."""
    record_windows = windows(case, grid, raw, reach=1)
    M, start = record_windows.M, record_windows.start
    position, speed = (
        sensor_samples(case, raw, quantity, start, record_windows.distinct * M + 1) for quantity in MOTION[:2]
    )
    samples = position, speed, M, start, grid.rate, case.bearing.rollers * model.bearing.theta_0
    if has_other_lines(case):
        return _lines_across_borders(*samples)
    lines = _lines_by_pass(*samples)
    return {quantity: amplitudes[:, record_windows.index] for quantity, amplitudes in lines.items()}


def _lines_at_equal_angles(case: Case, model: Any, grid: Grid, raw: RawRecord) -> dict[str, np.ndarray]:
    """Return the lines by pass of unequal passes, resampled at equal angles; empty for too short a record."""
    M, start, Z = grid.fine_per_pass, first_sample(case, grid), case.bearing.rollers
    length = whole_passes(case, grid) * M + 1
    (slip,) = raw.read(start, length, np.array([ROW_OF[CAGE_ANGLE]]))
    angle = Z * model.bearing.theta_0
    pass_angle = Z * sample_angles(model, grid, start, slip).cage - angle
    min_angle = 2.0 * pi * MIN_PASSES * (1.0 - 1e-9)  # tolerates rounding
    if pass_angle[-1] - pass_angle[0] < min_angle or np.any(np.diff(pass_angle) <= 0.0):
        return {}
    M *= ceil(2.0 * pi / (M * np.diff(pass_angle).min()))  # the longest pass keeps all its samples
    motion = np.stack([sensor_samples(case, raw, quantity, start, length) for quantity in MOTION[:2]])
    (position, speed), first_pass = signals.resample_by_angle(motion, pass_angle, M)
    passes = first_pass + np.arange((len(position) - 1) // M + 1)
    rate = 1.0 / np.diff(np.interp(2.0 * pi * passes, pass_angle, np.arange(length) / grid.fine_rate))
    return _lines_across_borders(position, speed, M, 0, rate, angle)


def _lines_across_borders(
    position: np.ndarray, speed: np.ndarray, M: int, start: int, rate: Any, Z_theta_0: float
) -> dict[str, np.ndarray]:
    """Return the lines (harmonics, passes - 1) of each quantity, as ``signals.amplitudes_by_pass_pair``; arguments
    as for ``_lines_by_pass``. Empty for fewer than two passes."""
    if len(position) <= 2 * M:
        return {}
    displacement, _ = signals.amplitudes_by_pass_pair(position[:-1], M, rate, HARMONICS, start, Z_theta_0)
    velocity, acceleration = signals.amplitudes_by_pass_pair(speed[:-1], M, rate, HARMONICS, start, Z_theta_0)
    return dict(zip(MOTION, (displacement, velocity, acceleration), strict=True))


def _lines_by_pass(
    position: np.ndarray, speed: np.ndarray, M: int, start: int, rate: float, Z_theta_0: float
) -> dict[str, np.ndarray]:
    """Return the lines (harmonics, passes) of each quantity; position, speed: whole passes plus one sample."""
    displacement, velocity = (
        signals.amplitudes_by_pass(series[:-1], M, HARMONICS, start, Z_theta_0) for series in (position, speed)
    )
    acceleration = signals.derivative_amplitudes(
        velocity, speed[::M], rate, HARMONICS, Z_theta_0 + 2.0 * pi * (start % M) / M
    )
    return dict(zip(MOTION, (displacement, velocity, acceleration), strict=True))


def _ball_pass_names() -> list[str]:
    lines = [f"{quantity}@{line_name(harmonic)}" for quantity in MOTION for harmonic in HARMONICS]
    return [f"{line}{ending}" for line in lines for ending in ("", ".phase", "-scatter")]


def other_lines(case: Case, model: Any, grid: Grid, raw: RawRecord) -> dict[str, float]:
    """Return amplitude and phase of the lines other than BPFO and its multiples; NaN if not resolved."""
    length = max(2, floor(case.duration * grid.fine_rate + 1e-6))
    length = length if raw.end is None else min(length, raw.end - first_sample(case, grid))
    compute_lines = _lines_at_varying_speed if has_unequal_passes(case) else _lines_at_constant_speed
    lines, frequencies = compute_lines(case, model, grid, raw, length)
    resolved = dict(
        zip(LINES, signals.are_resolved(frequencies, min(case.duration, length / grid.fine_rate)), strict=True)
    )
    columns: dict[str, float] = {}
    for quantity, values in lines.items():
        for name, value in zip(LINES, values, strict=True):
            if name in OTHER_LINES:
                A = value if resolved[name] else complex("nan")
                columns[f"{quantity}@{name}"] = float(abs(A))
                columns[f"{quantity}@{name}.phase"] = float(np.angle(A))
    return columns


def reason_unresolved(case: Case, name: str) -> str:
    """Return the reason why a record has no value of a line, with the duration (s) that separates the line."""
    frequencies = {line: case.bearing.line_frequency(LINES[line], case.speed) for line in LINES}
    own = frequencies.pop(name)
    nearest = min(frequencies, key=lambda line: abs(frequencies[line] - own))
    distance = min(abs(frequencies[nearest] - own), abs(own))
    is_far = distance * case.duration >= signals.RESOLVED_DISTANCE
    if case.ramp is not None or LINES[name].outer or is_far:
        return "the record is too short"
    if distance == 0.0:
        return f"its frequency is that of {nearest}"
    duration = 1.005 * signals.RESOLVED_DISTANCE / distance  # rounded up
    return f"a `duration` of {duration:.3g} s separates it from {nearest} (docs/lines.md)"


def _lines_at_constant_speed(
    case: Case, model: Any, grid: Grid, raw: RawRecord, length: int
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Return complex amplitudes (lines,) of each quantity, and the lines' frequencies (Hz)."""
    record_windows = windows(case, grid, raw, reach=0)
    M, start = record_windows.M, record_windows.start
    count = min(len(record_windows.index), length // M)
    window_count = min(record_windows.distinct, count)
    series = np.stack([sensor_samples(case, raw, q, start, window_count * M) for q in MOTION[:2]])
    tail = np.stack([sensor_samples(case, raw, q, start + count * M, length - count * M) for q in MOTION[:2]])
    angles = sample_angles(model, grid, start, np.zeros(1))
    phases = angles.phases(case.bearing.rollers)
    initial_angles = sample_angles(model, grid, 0, np.zeros(2))  # small angles, for full precision
    phase_step = np.diff(initial_angles.phases(case.bearing.rollers))[:, 0]
    displacement, velocity = signals.amplitudes_of_segments(
        series.reshape(2, window_count, M), count, record_windows.period, tail, phases[:, 0], phase_step
    )
    # from the velocity, integrated by parts, because impacts alias into the line less than from the acceleration
    acceleration = 1j * phase_step * grid.fine_rate * velocity
    lines = dict(zip(MOTION, (displacement, velocity, acceleration), strict=True))
    return lines, phase_step / (2.0 * pi) * grid.fine_rate


def _lines_at_varying_speed(
    case: Case, model: Any, grid: Grid, raw: RawRecord, length: int
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Return complex amplitudes and mean frequencies (Hz) of the lines at varying speed."""
    start, Z = first_sample(case, grid), case.bearing.rollers

    def angles(begin: int, end: int) -> np.ndarray:
        (slip,) = raw.read(start + begin, end - begin, np.array([ROW_OF[CAGE_ANGLE]]))
        sample = sample_angles(model, grid, start + begin, slip)
        return np.array([sample.phase(line, Z) for line in LINES.values()])

    def parts() -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        for begin, end in blocks(length):
            before, after = max(0, begin - 1), min(length, end + 1)  # neighbours for gradients
            inside = slice(begin - before, end - before)
            extended = angles(before, after)
            gradient = np.gradient(extended, axis=1)[:, inside]
            position, speed = (
                sensor_samples(case, raw, quantity, start + begin, end - begin) for quantity in MOTION[:2]
            )
            motion = (np.broadcast_to(position, gradient.shape), np.broadcast_to(speed, gradient.shape))
            yield np.stack([*motion, gradient * grid.fine_rate * speed], axis=1), extended[:, inside], gradient

    first_angles, last_angles = angles(0, 1)[:, 0], angles(length - 1, length)[:, 0]
    displacement, velocity, weighted_velocity = signals.amplitudes_of_blocks(parts(), first_angles, last_angles).T
    lines = dict(zip(MOTION, (displacement, velocity, 1j * weighted_velocity), strict=True))
    return lines, (last_angles - first_angles) / (2.0 * pi * (length - 1)) * grid.fine_rate
