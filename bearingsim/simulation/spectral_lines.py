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
from bearingsim.simulation.recording import LowPassed, RawRecord, first_sample, pass_segments, whole_passes
from bearingsim.simulation.settling import has_free_cage
from bearingsim.simulation.time_grid import Grid

MIN_PASSES = 3
"""Smallest number of ball passes of unequal duration for lines, because interpolation shortens the record."""

ROW_OF = {cell: row for row, cell in enumerate(FEATURE_CELLS + SENSOR_CELLS)}
OTHER_LINES = {name: line for name, line in LINES.items() if not line.outer}


MULTIPLES = np.array(list(LINES.values())).T[:, :, np.newaxis]
"""Multiples (5, lines, 1) of the characteristic frequencies for all ``LINES``, in the order of ``Line``."""


class SampleAngles(NamedTuple):
    """Angles (n,) in rad at fine samples.

    cage: of the pocket of the first roller; inner: of the inner ring; roll: of a roller relative to the cage.
    """

    cage: np.ndarray
    inner: np.ndarray
    roll: np.ndarray

    def ends(self) -> "SampleAngles":
        """Return the angles at the first and the last sample."""
        return SampleAngles(self.cage[[0, -1]], self.inner[[0, -1]], self.roll[[0, -1]])

    def phase(self, line: Line, Z: int) -> np.ndarray:
        """Return the phase angle (n,) of a line."""
        return self._phase(line, Z)

    def phases(self, Z: int) -> np.ndarray:
        """Return the phase angles (lines, n) of all ``LINES``."""
        return self._phase(MULTIPLES, Z)

    def _phase(self, multiples: Iterable[Any], Z: int) -> np.ndarray:
        """Return phase angles from multiples of BPFO, BPFI, BSF, FTF and shaft rotation."""
        outer, inner, spin, cage, shaft = multiples
        races = outer * Z * self.cage + inner * Z * (self.inner - self.cage)
        return races + spin * self.roll + cage * self.cage + shaft * self.inner


def feature_rows(case: Case) -> np.ndarray:
    """Return the rows of a recording from which features are computed."""
    return np.arange(len(feature_cells(case)))


def sensor_series(case: Case, rows: np.ndarray, quantity: str) -> np.ndarray:
    """Project a quantity of the ring on the sensor axis; for a flexible ring, return its value at the sensor."""
    return project_on_sensor(case, [rows[ROW_OF[cell]] for cell in cells_of(case, f"sensor.{quantity}")])


def block_ranges(count: int) -> Iterator[tuple[int, int]]:
    """Yield start and end of blocks that cover ``count`` samples. Raises OutOfCpuTime at the job's time limit."""
    for begin in range(0, count, BLOCK):
        cpu_time.check()
        yield begin, min(begin + BLOCK, count)


def sensor_samples(case: Case, raw: RawRecord | LowPassed, quantity: str, start: int, count: int) -> np.ndarray:
    """Return ``sensor_series`` of fine samples (count,) from number ``start`` on."""
    rows, out = np.array([ROW_OF[cell] for cell in cells_of(case, f"sensor.{quantity}")]), np.empty(count)
    for begin, end in block_ranges(count):
        out[begin:end] = project_on_sensor(case, list(raw.read(start + begin, end - begin, rows)))
    return out


def sample_angles(model: Any, grid: Grid, start: int, slip: np.ndarray) -> SampleAngles:
    """Return the angles at fine samples from number ``start`` on.

    slip: (n,) cage angle minus the kinematic one (rad).
    """
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


def ball_pass_lines(case: Case, pass_amplitudes: Mapping[str, np.ndarray]) -> dict[str, float]:
    """Return amplitude, phase and scatter of the lines at BPFO and its multiples; NaN without ``pass_amplitudes``.

    pass_amplitudes: result of ``amplitudes_by_pass``.
    """
    columns = {}
    has_others = has_other_lines(case)
    for quantity, amplitudes_of_passes in pass_amplitudes.items():
        for harmonic, values in zip(HARMONICS, amplitudes_of_passes, strict=True):
            name = f"{quantity}@{line_name(harmonic)}"
            columns[name], columns[f"{name}.phase"], columns[f"{name}-scatter"] = signals.mean_amplitude(
                values, has_others
            )
    return columns or dict.fromkeys(_ball_pass_names(), float("nan"))


def has_other_lines(case: Case) -> bool:
    """Check if a record has lines or vibration that are not periodic over a ball pass.

    On a ramp this is true of the natural vibration, because its frequency does not follow the speed.
    """
    rotates = case.unbalance is not None or any(element != "outer" for element in elements_with_deviations(case))
    return rotates or has_unequal_passes(case)


def has_unequal_passes(case: Case) -> bool:
    """Check if ball passes differ in duration, because the cage is free or the speed changes."""
    return has_free_cage(case) or case.ramp is not None


def amplitudes_by_pass(case: Case, model: Any, grid: Grid, raw: RawRecord) -> dict[str, np.ndarray]:
    """Return the complex amplitudes (harmonics, passes) of the harmonics of BPFO in each ball pass, by quantity.

    In a record that also has other lines, each is computed over two passes (``lines.amplitudes_by_pass_pair``).
    Empty if the record is too short for that, or for passes of unequal duration.
    """
    return (_amplitudes_at_equal_angles if has_unequal_passes(case) else _amplitudes_at_equal_times)(
        case, model, grid, raw
    )


def _amplitudes_at_equal_times(case: Case, model: Any, grid: Grid, raw: RawRecord) -> dict[str, np.ndarray]:
    """Return the amplitudes of ``amplitudes_by_pass`` for passes of equal duration."""
    segments = pass_segments(case, grid, raw, margin=1)
    M, start = segments.M, segments.start
    position, speed = (
        sensor_samples(case, raw, quantity, start, segments.distinct * M + 1) for quantity in MOTION[:2]
    )
    arguments = position, speed, M, start, grid.rate, case.bearing.rollers * model.bearing.theta_0
    if has_other_lines(case):
        return _amplitudes_by_pass_pair(*arguments)
    amplitudes_of_quantity = _amplitudes_of_passes(*arguments)
    return {quantity: amplitudes[:, segments.index] for quantity, amplitudes in amplitudes_of_quantity.items()}


def _amplitudes_at_equal_angles(case: Case, model: Any, grid: Grid, raw: RawRecord) -> dict[str, np.ndarray]:
    """Return the amplitudes of ``amplitudes_by_pass`` for passes of unequal duration, resampled at equal angles.

    Empty if the record is too short, or if the cage does not always rotate forwards.
    """
    M, start, Z = grid.fine_per_pass, first_sample(case, grid), case.bearing.rollers
    length = whole_passes(case, grid) * M + 1
    (slip,) = raw.read(start, length, np.array([ROW_OF[CAGE_ANGLE]]))
    angle = Z * model.bearing.theta_0
    pass_angle = Z * sample_angles(model, grid, start, slip).cage - angle
    min_angle = 2.0 * pi * MIN_PASSES * (1.0 - 1e-9)  # tolerates rounding
    if pass_angle[-1] - pass_angle[0] < min_angle or np.any(np.diff(pass_angle) <= 0.0):
        return {}
    M *= ceil(2.0 * pi / (M * np.diff(pass_angle).min()))  # no pass loses samples
    motion = np.stack([sensor_samples(case, raw, quantity, start, length) for quantity in MOTION[:2]])
    (position, speed), first_pass = signals.resample_by_angle(motion, pass_angle, M)
    passes = first_pass + np.arange((len(position) - 1) // M + 1)
    rate = 1.0 / np.diff(np.interp(2.0 * pi * passes, pass_angle, np.arange(length) / grid.fine_rate))
    return _amplitudes_by_pass_pair(position, speed, M, 0, rate, angle)


def _amplitudes_by_pass_pair(
    position: np.ndarray, speed: np.ndarray, M: int, start: int, rate: Any, Z_theta_0: float
) -> dict[str, np.ndarray]:
    """Return amplitudes (harmonics, passes - 1), each over two successive passes; empty for fewer than two passes.

    Arguments as for ``_amplitudes_of_passes``; rate: one value, or one for each pass.
    """
    if len(position) <= 2 * M:
        return {}
    displacement, _ = signals.amplitudes_by_pass_pair(position[:-1], M, rate, HARMONICS, start, Z_theta_0)
    velocity, acceleration = signals.amplitudes_by_pass_pair(speed[:-1], M, rate, HARMONICS, start, Z_theta_0)
    return dict(zip(MOTION, (displacement, velocity, acceleration), strict=True))


def _amplitudes_of_passes(
    position: np.ndarray, speed: np.ndarray, M: int, start: int, rate: float, Z_theta_0: float
) -> dict[str, np.ndarray]:
    """Return amplitudes (harmonics, passes) over each pass.

    position, speed: (passes * M + 1,) along the sensor, from fine sample ``start`` on; rate: ball passes per
    second (Hz); Z_theta_0: Z times the initial angle of the first roller (rad).
    """
    displacement, velocity = (
        signals.amplitudes_by_pass(series[:-1], M, HARMONICS, start, Z_theta_0) for series in (position, speed)
    )
    acceleration = signals.derivative_amplitudes(
        velocity, speed[::M], rate, HARMONICS, Z_theta_0 + 2.0 * pi * (start % M) / M
    )
    return dict(zip(MOTION, (displacement, velocity, acceleration), strict=True))


def _ball_pass_names() -> list[str]:
    """List the names of the features of ``ball_pass_lines``."""
    lines = [f"{quantity}@{line_name(harmonic)}" for quantity in MOTION for harmonic in HARMONICS]
    return [f"{line}{ending}" for line in lines for ending in ("", ".phase", "-scatter")]


def other_lines(case: Case, model: Any, grid: Grid, raw: RawRecord) -> dict[str, float]:
    """Return amplitude and phase of the lines other than BPFO and its multiples; NaN if not resolved."""
    length = max(2, floor(case.duration * grid.fine_rate + 1e-6))
    length = length if raw.end is None else min(length, raw.end - first_sample(case, grid))
    compute_amplitudes = (
        _amplitudes_at_varying_speed if has_unequal_passes(case) else _amplitudes_at_constant_speed
    )
    amplitudes, frequencies = compute_amplitudes(case, model, grid, raw, length)
    resolved = dict(
        zip(LINES, signals.are_resolved(frequencies, min(case.duration, length / grid.fine_rate)), strict=True)
    )
    columns: dict[str, float] = {}
    for quantity, values in amplitudes.items():
        for name, value in zip(LINES, values, strict=True):
            if name in OTHER_LINES:
                amplitude = value if resolved[name] else complex("nan")
                columns[f"{quantity}@{name}"] = float(abs(amplitude))
                columns[f"{quantity}@{name}.phase"] = float(np.angle(amplitude))
    return columns


def reason_unresolved(case: Case, name: str) -> str:
    """Return the reason why a record has no value of a line, with a duration that separates it if there is one."""
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


def _amplitudes_at_constant_speed(
    case: Case, model: Any, grid: Grid, raw: RawRecord, length: int
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Return complex amplitudes (lines,) of each quantity, and the lines' frequencies (Hz)."""
    segments = pass_segments(case, grid, raw, margin=0)
    M, start = segments.M, segments.start
    count = min(len(segments.index), length // M)
    segment_count = min(segments.distinct, count)
    series = np.stack([sensor_samples(case, raw, q, start, segment_count * M) for q in MOTION[:2]])
    tail = np.stack([sensor_samples(case, raw, q, start + count * M, length - count * M) for q in MOTION[:2]])
    angles = sample_angles(model, grid, start, np.zeros(1))
    phases = angles.phases(case.bearing.rollers)
    initial_angles = sample_angles(model, grid, 0, np.zeros(2))  # small angles, for full precision
    phase_step = np.diff(initial_angles.phases(case.bearing.rollers))[:, 0]
    displacement, velocity = signals.amplitudes_of_segments(
        series.reshape(2, segment_count, M), count, segments.period, tail, phases[:, 0], phase_step
    )
    # by parts from the velocity: impacts alias into the line less than in the sampled acceleration
    acceleration = 1j * phase_step * grid.fine_rate * velocity
    amplitudes = dict(zip(MOTION, (displacement, velocity, acceleration), strict=True))
    return amplitudes, phase_step / (2.0 * pi) * grid.fine_rate


def _amplitudes_at_varying_speed(
    case: Case, model: Any, grid: Grid, raw: RawRecord, length: int
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Return complex amplitudes and mean frequencies (Hz) of the lines at varying speed."""
    start, Z = first_sample(case, grid), case.bearing.rollers

    def angles(begin: int, end: int) -> np.ndarray:
        (slip,) = raw.read(start + begin, end - begin, np.array([ROW_OF[CAGE_ANGLE]]))
        sample = sample_angles(model, grid, start + begin, slip)
        return np.array([sample.phase(line, Z) for line in LINES.values()])

    def parts() -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        for begin, end in block_ranges(length):
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
    amplitudes = dict(zip(MOTION, (displacement, velocity, 1j * weighted_velocity), strict=True))
    return amplitudes, (last_angles - first_angles) / (2.0 * pi * (length - 1)) * grid.fine_rate
