"""Estimate of CPU time and memory of a case: integration, step check, recording and features.

CPU time is the number of evaluations and operations times the coefficients in ``prices.csv``. These were
measured on one core of a 2.6 GHz server (``benchmarks/step_cost.py``). They are used on every machine, so that the
same method is chosen everywhere. Memory is that of the arrays allocated at the same time; arrays of the step check
are freed before those of the run are allocated.
"""

import csv
from functools import cache
from math import ceil, inf, sqrt
from pathlib import Path
from typing import NamedTuple

from bearingsim import assemble
from bearingsim.assemble.bending import has_carrier, ring_parameters, spring_properties
from bearingsim.assemble.contacts import count_powers
from bearingsim.assemble.scales import full_speed_case
from bearingsim.catalogue import EXPLICIT, METHODS, MODELS
from bearingsim.config import CHANNELS, Case
from bearingsim.config.names import read_band
from bearingsim.config.rules.completion import slice_count
from bearingsim.core.sampling import DECIMATION_HALF_LENGTH, RESAMPLE_HALF_LENGTH
from bearingsim.simulation import channels, ending
from bearingsim.simulation.limits import LONGEST_STEP, Limits, step_limits
from bearingsim.simulation.pilot import make_pilot
from bearingsim.simulation.repetition import LONGEST_PERIOD, MAX_STORED_BYTES, may_repeat, searches_for_period
from bearingsim.simulation.settling import extrapolation_passes, has_free_cage, slow_mode_count

COEFFICIENT_FILE = Path(__file__).with_name("prices.csv")
DEFAULT_NAME = ""
"""Name of the table's rows for models and methods without their own, such as those of other packages."""
STEPS_PER_PERIOD = 10.0  # internal steps of an implicit adaptive method in a period of the contacts' vibration
RINGING_RATIO = 0.1  # damping ratio below which the contacts' vibration determines these steps
# these steps are divided by the damping ratio, if above 1, to this power (fitted to Rodas at m3 = 0)
DAMPING_POWER = 0.37


@cache
def coefficients() -> dict[tuple[str, str], float]:
    """Return the coefficients of the table, by operation and name of model or method."""
    with COEFFICIENT_FILE.open(newline="") as file:
        return {(row["what"], row["name"]): float(row["value"]) for row in csv.DictReader(file)}


def coefficient(operation: str, name: str = DEFAULT_NAME) -> float:
    """Return a coefficient of the table, that of ``DEFAULT_NAME`` if there is none for ``name``."""
    return coefficients().get((operation, name), coefficients()[operation, DEFAULT_NAME])


def compile_time(case: Case) -> float:
    """Return the CPU time (s) to compile the code of a case with an empty cache."""
    return coefficient("compile", case.model)


def evaluation_time(case: Case) -> float:
    """Return the CPU time (s) of one evaluation of the case's model."""
    roller_time = (coefficient("evaluation", case.model) + coefficient("power") * count_powers(case)) * (
        slice_count(case) or 1
    )
    return roller_time + bending_time(case) + form_time(case)


def form_time(case: Case) -> float:
    """Return the CPU time (s) of form deviations of surfaces in an evaluation."""
    surfaces = 0 if case.surfaces is None else len(case.surfaces.elements)
    return surfaces * coefficient("form", case.model) * (slice_count(case) or 1)


def bending_time(case: Case) -> float:
    """Return the CPU time (s) of a flexible ring and its support springs in an evaluation."""
    if case.rig.ring is None:
        return 0.0
    springs = len(spring_properties(ring_parameters(case))[0]) if has_carrier(case.rig) else 0
    return (coefficient("harmonic", case.model) + coefficient("spring") * springs) * float(case.rig.ring.harmonics)


def step_evaluations(method: str, model: str, evaluations: int) -> float:
    """Return the CPU time of a method's step in evaluations of the model, overhead included (docs/cost.md).

    evaluations: number of model evaluations in a step, used for a method without a row of its own.
    """
    default = coefficient("adaptive step") if METHODS[method].adaptive else 1.0
    method_default = coefficients().get(("step", method), default * evaluations)
    return coefficients().get(("step", f"{method} {model}"), method_default)


def cpu_per_second(case: Case, step: float) -> float:
    """Return the CPU time (s) of the steps per second of simulated time."""
    kind = assemble.method_kind(case)
    if case.method is None:
        return evaluation_time(case) / step * kind.evaluations
    step_cost = step_evaluations(case.method, case.model, kind.evaluations)
    if not METHODS[case.method].adaptive:
        return evaluation_time(case) / step * step_cost
    internal_step = adaptive_step(case, step_limits(case.model_copy(update={"method": EXPLICIT})))
    return evaluation_time(case) * (coefficient("record") / step + step_cost / internal_step)


def adaptive_step(case: Case, limits: Limits) -> float:
    """Estimate the length (s) of an adaptive method's internal steps.

    Stability on the contacts at rest limits the steps of an explicit method. Crossing times, and the contacts'
    vibration and damping, limit those of an implicit one.
    """
    default_steps, name = coefficient("own steps"), str(case.method)
    steps = coefficient("own steps", name)
    crossing_step = min(limits.crossing, LONGEST_STEP * default_steps) / steps
    if not METHODS[name].implicit:
        return min(crossing_step, coefficient("stable step", name) / limits.fastest_rate)
    vibration_step = (
        1.0 / limits.contact_frequency / STEPS_PER_PERIOD if limits.damping_ratio < RINGING_RATIO else inf
    )
    return min(
        crossing_step,
        vibration_step,
        LONGEST_STEP * default_steps / steps / max(1.0, limits.damping_ratio) ** DAMPING_POWER,
    )


class Cost(NamedTuple):
    """CPU time (s) of a run.

    steps: of its steps; check: of the step check; non_periodic: of both if the response is not periodic; passes:
    number of computed ball passes; one_pass: CPU time (s) of a ball pass.
    """

    steps: float
    check: float
    non_periodic: float
    passes: int
    one_pass: float

    @property
    def total(self) -> float:
        """CPU time (s) of steps and step check."""
        return self.steps + self.check


def estimate_cost(case: Case, step: float, passes: int | None = None) -> Cost:
    """Estimate the cost of a case with a named method, at steps of ``step`` s.

    step: for an adaptive method the interval between recorded instants; passes: ball passes of the whole run, by
    default those of settling and duration.
    """
    rate = case.bearing.ball_pass_frequency(full_speed_case(case).speed)
    total_passes = passes or ceil((case.settle_s + case.duration) * rate)
    one_pass = cpu_per_second(case, step) / rate
    if solved_once(case):
        total_passes = 1
    check = check_cost_ratio(case) * total_passes if case.checks_step else 0.0
    extrapolation = min(extrapolation_passes(case), int(case.settle_s * rate))
    non_periodic = one_pass * (extrapolation + total_passes + check)
    computed = total_passes
    periodic_passes = min(total_passes, int(coefficient("passes")))
    if may_repeat(case):
        computed = periodic_passes
    elif (record_passes := next(ending.inspection_passes(case), None)) is not None:
        computed = min(total_passes, ceil(case.settle_s * rate) + record_passes)
        shortest_case = case.model_copy(update={"duration": record_passes / rate})
        check = check_cost_ratio(shortest_case) * computed if case.checks_step else 0.0
    if case.checks_step and searches_for_period(case):
        check = sqrt(5.0) * (coefficient("finer passes") + extrapolation)
        if not case.periodic:
            check += extrapolation + periodic_passes
    computed += extrapolation
    return Cost(one_pass * computed, one_pass * check, non_periodic, computed, one_pass)


def begins_with_pilot(case: Case) -> bool:
    """Check if the pilots of a case take the same steps as the beginning of its run.

    They do not on a ramp, where pilots run at the highest speed; with slow modes, where the run starts from an
    extrapolated state and its pilot at rest; and with raw values, which are sampled from the end of `settle` on.
    """
    return not (case.ramp is not None or slow_mode_count(case) > 0 or channels.stores_raw_values(case))


def check_cost_ratio(case: Case) -> float:
    """Return the ratio of the CPU time of a step check to that of its run.

    A check runs a pilot at 1/sqrt(5) of the step, and one at the step unless the run begins with that. The third
    pilot of a possibly chaotic motion and the longer ones of a doubtful result are not included.
    """
    pilot_case, _ = make_pilot(case)
    pilots = sqrt(5.0) if begins_with_pilot(case) else 1.0 + sqrt(5.0)
    return pilots * (pilot_case.settle_s + pilot_case.duration) / (case.settle_s + case.duration)


def solved_once(case: Case) -> bool:
    """Check if only one ball pass is computed, because the model has no memory and all passes are the same."""
    return MODELS[case.model].memoryless and may_repeat(case)


FLOAT_BYTES = 8  # bytes
SENSOR_ROWS = 6  # rows of motion along the sensor that are filtered for statistics
REFINEMENT_RATIO = sqrt(5.0)  # steps of the finer run of a step check over those of the coarse run
CHECKED_PASS_RATIO = 2.0 / (1.0 + REFINEMENT_RATIO)
"""Ball passes recorded by a step check (coarse and finer run) over its steps, in ball passes of the coarse run."""
BLOCK = 1 << 16  # fine samples read at a time, since a copy of a long record would dominate the memory
VARYING_BLOCK_VALUES = 180.0  # values per fine sample of a block while lines are read at varying speed
STEADY_LINE_VALUES, VARYING_LINE_VALUES = 6.0, 16.0
"""Values per fine sample of the record while lines are read, at constant and at varying speed."""
BAND_VALUES = 14.0  # values per fine sample of the record while band features are read
PILOT_COPIES = 3.0  # copies of a pilot's rows: unfiltered, filtered, and extended by the half length of filters
COMPARED_VALUES = 6.0  # values per fine sample stored of a pilot
SERIES_VALUES = 3.0  # values per sample of a series: filtered, in double and in single precision
INSPECTED_LENGTH = 5.0
"""Total length of all inspected records over that of the last one, with `until`: 1 + 1/1.25 + 1/1.25^2 + ..."""
UNCOMPARED_ROWS = (
    5  # rows not compared between passes: two accelerations, number of loaded rollers, cage angle and speed
)
SMALL_ARRAYS = 8e6  # bytes of all small arrays


class OperationCounts(NamedTuple):
    """Numbers of operations on a run, with a coefficient for each in ``prices.csv``.

    recorded_value: recorded values, one per row and step; recorded_pass: ball passes; tap: multiplications of the
    low-pass; line_sample: fine samples from which lines are read; varying_sample: those read with a slipping cage
    or on a ramp; ramp_sample: those on a ramp; band_sample: fine samples of the record, for each band feature;
    sample: samples of the record's series, and of rows picked at its instants; written: numbers written.
    """

    recorded_value: float
    recorded_pass: float
    tap: float
    line_sample: float
    varying_sample: float
    ramp_sample: float
    band_sample: float
    sample: float
    written: float

    @property
    def seconds(self) -> float:
        """CPU time (s) of all operations."""
        return sum(
            coefficient(name.replace("_", " ")) * count for name, count in zip(self._fields, self, strict=True)
        )


class RecordSize(NamedTuple):
    """Sizes of a record.

    rows: recorded rows; requested: those that become series; computed: ball passes, each of ``fine`` fine samples
    and ``steps`` steps; read: distinct fine samples of the record; total: all fine samples of the record;
    samples: length of each series; columns: number of series; checked: steps of the step check, in ball passes.
    """

    rows: int
    requested: int
    computed: int
    fine: int
    steps: int
    read: float
    total: float
    samples: int
    columns: int
    checked: float

    def with_passes(self, computed: int, checked: float) -> "RecordSize":
        """Return the size with other numbers of passes computed and checked."""
        read = min(self.total, float(computed * self.fine))
        return self._replace(computed=computed, checked=checked, read=read)


def make_record_size(case: Case, fine_per_pass: int, decimation: int, computed: int, checked: float) -> RecordSize:
    """Make the size of a case with a named method.

    fine_per_pass, decimation: as in ``Grid``; computed, checked: numbers of ball passes.
    """
    total = case.duration * case.bearing.ball_pass_frequency(full_speed_case(case).speed) * fine_per_pass
    cells = channels.recorded_cells(case)
    requested = len(channels.requested_rows(case, cells))
    columns = sum(len(CHANNELS[name].components) for name in case.record)
    samples = int(case.duration * case.sampling + 1e-6)
    read = min(total, float(computed * fine_per_pass))
    return RecordSize(
        len(cells),
        requested,
        computed,
        fine_per_pass,
        fine_per_pass * decimation,
        read,
        total,
        samples,
        columns,
        checked,
    )


def count_operations(case: Case, size: RecordSize) -> OperationCounts:
    """Count the operations on a run of a given size."""
    recorded_passes = size.computed + CHECKED_PASS_RATIO * size.checked
    taps = 2.0 * ceil(RESAMPLE_HALF_LENGTH * size.total / max(1, size.samples)) + 1.0
    series_samples = size.total if size.read == size.total else size.computed * size.fine
    filtered = size.rows * CHECKED_PASS_RATIO * size.checked * size.fine
    filtered += SENSOR_ROWS * size.read + size.requested * series_samples if case.antialias else 0.0
    has_ramp = case.ramp is not None
    inspections = INSPECTED_LENGTH if case.until is not None else 0.0
    return OperationCounts(
        recorded_value=size.rows * size.steps * (size.computed + size.checked),
        recorded_pass=recorded_passes,
        tap=taps * (filtered + inspections * 2.0 * size.read),
        line_sample=size.read * (1.0 + inspections),
        varying_sample=size.read if has_free_cage(case) or has_ramp else 0.0,
        ramp_sample=size.read if has_ramp else 0.0,
        band_sample=size.total * _band_count(case),
        sample=float(size.samples * (size.requested + (size.rows if channels.stores_raw_values(case) else 0))),
        written=float(size.samples * size.columns),
    )


def peak_memory(case: Case, size: RecordSize) -> float:
    """Return the peak memory (bytes) of a run of a given size, without the memory of the program."""
    is_varying = case.ramp is not None or MODELS[case.model].slips
    lines = (
        VARYING_LINE_VALUES * size.read + VARYING_BLOCK_VALUES * min(size.read, BLOCK)
        if is_varying
        else STEADY_LINE_VALUES * size.read
    )
    lead = RESAMPLE_HALF_LENGTH * size.total / max(1, size.samples)
    pass_values = size.rows * (size.steps + 2 * DECIMATION_HALF_LENGTH * size.steps / size.fine)
    raw_values = float(size.rows * size.samples) if channels.stores_raw_values(case) else 0.0
    recording = size.rows * (size.computed * size.fine + lead) + raw_values
    bands = BAND_VALUES * size.total if _band_count(case) else 0.0
    series = (size.requested + SERIES_VALUES * size.columns + 2.0) * size.samples
    pilot = CHECKED_PASS_RATIO * size.checked / 2.0 * size.fine
    check = (PILOT_COPIES * size.rows + COMPARED_VALUES) * pilot + 2.0 * pass_values
    largest = max(lines, bands, series, pass_values)
    if not may_repeat(case):
        return FLOAT_BYTES * max(recording + largest, check) + SMALL_ARRAYS
    stepping = pass_values + _stored_values(case, pass_values, size.rows)
    if size.checked > 0.0:  # a period is also computed and recorded with finer steps
        stepping = REFINEMENT_RATIO * stepping + recording
    return FLOAT_BYTES * (recording + max(largest, stepping, check)) + SMALL_ARRAYS


def _band_count(case: Case) -> int:
    """Count the band features, which are read from all fine samples of the record."""
    return sum(read_band(name) is not None for name in case.features)


def _stored_values(case: Case, pass_values: float, rows: int) -> float:
    """Count the values of stored ball passes, for comparison with the next pass and for raw contact forces.

    One more pass than the longest period is stored while the next one replaces the oldest.
    """
    compared = min(
        MAX_STORED_BYTES / FLOAT_BYTES, (1 + LONGEST_PERIOD) * pass_values * (1.0 - UNCOMPARED_ROWS / rows)
    )
    return compared + pass_values + (LONGEST_PERIOD * pass_values if channels.stores_raw_values(case) else 0.0)
