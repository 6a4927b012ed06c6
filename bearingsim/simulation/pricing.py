"""CPU time and memory of a case: integration, step check, recording and features.

CPU time is the number of evaluations and operations times the measured prices in ``prices.csv``. These were
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
from bearingsim.core.sampling import DECIMATION_REACH, RESAMPLE_REACH
from bearingsim.simulation import channels, ending
from bearingsim.simulation.limits import LONGEST_STEP, Limits, step_limits
from bearingsim.simulation.pilot import check_cost
from bearingsim.simulation.repetition import LONGEST_PERIOD, MAX_STORED, may_repeat, searches_for_period
from bearingsim.simulation.settling import extrapolation_passes

TABLE = Path(__file__).with_name("prices.csv")
USUAL = ""
"""Name in the table for models and methods without a row of their own, such as a model of another package."""
OWN_PER_PERIOD = 10.0  # internal steps of an adaptive method in a period of the contacts' vibration
RINGING_RATIO = 0.1  # damping ratio below which the contacts' vibration determines the steps
# exponent of a damping ratio above 1, by which internal steps shorten (Rodas, m3 = 0; others roughly)
DAMPING_POWER = 0.37


@cache
def prices() -> dict[tuple[str, str], float]:
    """Return the table of prices by operation and name of model or method."""
    with TABLE.open(newline="") as file:
        return {(row["what"], row["name"]): float(row["value"]) for row in csv.DictReader(file)}


def price(what: str, name: str = USUAL) -> float:
    """Return an entry of the table, or the default entry (``USUAL``) if there is none for ``name``."""
    return prices().get((what, name), prices()[what, USUAL])


def compiling(case: Case) -> float:
    """Return the CPU time (s) to compile the code of a case with an empty cache."""
    return price("compile", case.model)


def evaluation(case: Case) -> float:
    """Return the CPU time (s) of one evaluation of the case's model."""
    of_rollers = (price("evaluation", case.model) + price("power") * count_powers(case)) * (slice_count(case) or 1)
    return of_rollers + bending(case)


def bending(case: Case) -> float:
    """Return the CPU time (s) of a flexible ring and its support springs in an evaluation."""
    if case.rig.ring is None:
        return 0.0
    springs = len(spring_properties(ring_parameters(case))[0]) if has_carrier(case.rig) else 0
    return (price("harmonic", case.model) + price("spring") * springs) * float(case.rig.ring.harmonics)


def per_step(method: str, model: str, evaluations: int) -> float:
    """Return the CPU time of a method's step in evaluations of the model, overhead included (docs/cost.md).

    evaluations: number of model evaluations in a step, used for a method without a row of its own.
    """
    usual = price("adaptive step") if METHODS[method].adaptive else 1.0
    of_any = prices().get(("step", method), usual * evaluations)
    return prices().get(("step", f"{method} {model}"), of_any)


def per_second(case: Case, step: float) -> float:
    """Return the CPU time (s) of the steps per second of simulated time."""
    kind = assemble.method_kind(case)
    if case.method is None:
        return evaluation(case) / step * kind.evaluations
    step_cost = per_step(case.method, case.model, kind.evaluations)
    if not METHODS[case.method].adaptive:
        return evaluation(case) / step * step_cost
    own = adaptive_step(case, step_limits(case.model_copy(update={"method": EXPLICIT})))
    return evaluation(case) * (price("record") / step + step_cost / own)


def adaptive_step(case: Case, limits: Limits) -> float:
    """Estimate the length (s) of an adaptive method's internal steps.

    Stability on the contacts at rest limits the steps of an explicit method. Crossing times, and the contacts'
    vibration and damping, limit those of an implicit one.
    """
    usual, name = price("own steps"), str(case.method)
    steps = price("own steps", name)
    smooth = min(limits.crossing, LONGEST_STEP * usual) / steps
    if not METHODS[name].implicit:
        return min(smooth, price("stable step", name) / limits.fastest_rate)
    rings = 1.0 / limits.contact_frequency / OWN_PER_PERIOD if limits.damping_ratio < RINGING_RATIO else inf
    return min(smooth, rings, LONGEST_STEP * usual / steps / max(1.0, limits.damping_ratio) ** DAMPING_POWER)


class Cost(NamedTuple):
    """CPU time (s) of a run: of its steps, of the step check (proof), and of both if the response is not periodic.

    passes: computed ball passes; one_pass: CPU time (s) of a ball pass.
    """

    steps: float
    proof: float
    at_most: float
    passes: int
    one_pass: float

    @property
    def whole(self) -> float:
        """CPU time (s) of steps and step check."""
        return self.steps + self.proof


def cost(case: Case, step: float, passes: int | None = None) -> Cost:
    """Estimate the cost of a case with a named method, at steps of ``step`` s.

    step: for an adaptive method the interval between recorded instants; passes: ball passes of the whole run, by
    default those of settling and duration.
    """
    rate = case.bearing.ball_pass_frequency(full_speed_case(case).speed)
    whole = passes or ceil((case.settle_s + case.duration) * rate)
    one_pass = per_second(case, step) / rate
    if solved_once(case):
        whole = 1
    proof = check_cost(case) * whole if case.checks_step else 0.0
    before = extrapolation_passes(case)
    at_most = one_pass * (before + whole + proof)
    computed = whole
    in_a_period = min(whole, int(price("passes")))
    if may_repeat(case):
        computed = in_a_period
    elif (record := next(ending.inspection_passes(case), None)) is not None:
        computed = min(whole, ceil(case.settle_s * rate) + record)
        shortest = case.model_copy(update={"duration": record / rate})
        proof = check_cost(shortest) * computed if case.checks_step else 0.0
    if case.checks_step and searches_for_period(case):
        proof = sqrt(5.0) * (price("finer passes") + before)
        if not case.periodic:
            proof += before + in_a_period
    computed += before
    return Cost(one_pass * computed, one_pass * proof, at_most, computed, one_pass)


def solved_once(case: Case) -> bool:
    """Check if only one ball pass is computed, because the model has no memory and all passes are the same."""
    return MODELS[case.model].memoryless and may_repeat(case)


FLOAT = 8  # bytes
SENSED = 6  # rows of motion along the sensor that are filtered for statistics
FINER = sqrt(5.0)  # ratio of the number of steps in the finer run of a step check to that in the coarse one
PASSES_CHECKED = 2.0 / (1.0 + FINER)  # passes recorded by a step check per pass's worth of steps (coarse and fine)
BLOCK = 1 << 16  # fine samples read at a time, since a copy of all rows of a long record would dominate the memory
TURNED = 180.0  # values per fine sample of a block while lines of slipping bodies are read
STEADY, TURNING = 6.0, 16.0  # values per fine sample while lines are read, at constant and at varying speed
BANDED = 14.0  # values per fine sample of the record while band features are read
PILOT = 3.0  # copies of a pilot's rows: unfiltered, filtered, and extended by the reach of filters
COMPARED = 6.0  # values per fine sample stored of a pilot
WRITTEN = 3.0  # values per sample of a series: filtered, in double and in single precision
LOOKS = 5.0  # total length of all inspected records over that of the last, with `until`: 1 + 1/1.25 + ...
NOT_COMPARED = 5  # rows not compared between passes: accelerations, number of loaded rollers, cage
SMALL = 8e6  # bytes of all small arrays


class Counts(NamedTuple):
    """Numbers of operations on a run, with a price for each in ``prices.csv``.

    kept_value: recorded values, one per row and step; kept_pass: ball passes; tap: multiplications of the
    low-pass; line_sample: fine samples from which lines are read; turning_sample: those read with a slipping cage
    or on a ramp; ramp_sample: those on a ramp; band_sample: fine samples of the record, for each band feature;
    sample: samples of the record's series, and of rows picked at its instants; written: numbers written.
    """

    kept_value: float
    kept_pass: float
    tap: float
    line_sample: float
    turning_sample: float
    ramp_sample: float
    band_sample: float
    sample: float
    written: float

    @property
    def seconds(self) -> float:
        """CPU time (s) of all operations."""
        return sum(price(name.replace("_", " ")) * count for name, count in zip(self._fields, self, strict=True))


class Size(NamedTuple):
    """Sizes of a record.

    rows: recorded rows; requested: those that become series; computed: ball passes, each of ``fine`` fine samples
    and ``steps`` steps; read: distinct fine samples of the record; whole: all fine samples of the record;
    samples: length of each series; columns: number of series; checked: steps of the step check, in ball passes.
    """

    rows: int
    requested: int
    computed: int
    fine: int
    steps: int
    read: float
    whole: float
    samples: int
    columns: int
    checked: float

    def with_passes(self, computed: int, checked: float) -> "Size":
        """Return the size with other numbers of passes computed and checked."""
        read = min(self.whole, float(computed * self.fine))
        return self._replace(computed=computed, checked=checked, read=read)


def size(case: Case, fine: int, decimation: int, computed: int, checked: float) -> Size:
    """Return the size of a case with a named method and the ball passes ``computed`` and ``checked``."""
    whole = case.duration * case.bearing.ball_pass_frequency(full_speed_case(case).speed) * fine
    cells = channels.recorded_cells(case)
    requested = len(channels.requested_rows(case, cells))
    columns = sum(len(CHANNELS[name].components) for name in case.record)
    samples = int(case.duration * case.sampling + 1e-6)
    read = min(whole, float(computed * fine))
    return Size(len(cells), requested, computed, fine, fine * decimation, read, whole, samples, columns, checked)


def counts(case: Case, of: Size) -> Counts:
    """Count the operations on a run of that size."""
    passes = of.computed + PASSES_CHECKED * of.checked
    taps = 2.0 * ceil(RESAMPLE_REACH * of.whole / max(1, of.samples)) + 1.0
    of_series = of.whole if of.read == of.whole else of.computed * of.fine
    filtered = of.rows * PASSES_CHECKED * of.checked * of.fine
    filtered += SENSED * of.read + of.requested * of_series if case.antialias else 0.0
    turns = MODELS[case.model].slips and not (case.cage is not None and case.cage.motion == "kinematic")
    ramps = case.ramp is not None
    looks = LOOKS if case.until is not None else 0.0
    return Counts(
        kept_value=of.rows * of.steps * (of.computed + of.checked),
        kept_pass=passes,
        tap=taps * (filtered + looks * 2.0 * of.read),
        line_sample=of.read * (1.0 + looks),
        turning_sample=of.read if turns or ramps else 0.0,
        ramp_sample=of.read if ramps else 0.0,
        band_sample=of.whole * _bands(case),
        sample=float(of.samples * (of.requested + (of.rows if channels.stores_raw_values(case) else 0))),
        written=float(of.samples * of.columns),
    )


def memory(case: Case, of: Size) -> float:
    """Return the peak memory (bytes) of a run of that size, without the memory of the program."""
    turning = case.ramp is not None or MODELS[case.model].slips
    lines = TURNING * of.read + TURNED * min(of.read, BLOCK) if turning else STEADY * of.read
    lead = RESAMPLE_REACH * of.whole / max(1, of.samples)
    window = of.rows * (of.steps + 2 * DECIMATION_REACH * of.steps / of.fine)
    picked = float(of.rows * of.samples) if channels.stores_raw_values(case) else 0.0
    recording = of.rows * (of.computed * of.fine + lead) + picked
    banded = BANDED * of.whole if _bands(case) else 0.0
    series = (of.requested + WRITTEN * of.columns + 2.0) * of.samples
    pilot = PASSES_CHECKED * of.checked / 2.0 * of.fine
    check = (PILOT * of.rows + COMPARED) * pilot + 2.0 * window
    most = max(lines, banded, series, window)
    if not may_repeat(case):
        return FLOAT * max(recording + most, check) + SMALL
    stepped = window + _held(case, window, of.rows)
    if of.checked > 0.0:  # a period is computed again in finer steps, and recorded as well
        stepped = FINER * stepped + recording
    return FLOAT * (recording + max(most, stepped, check)) + SMALL


def _bands(case: Case) -> int:
    """Count the band features, which are read from all fine samples of the record."""
    return sum(read_band(name) is not None for name in case.features)


def _held(case: Case, window: float, rows: int) -> float:
    """Count the values of stored ball passes, for comparison with the next pass and for raw contact forces.

    One pass more is stored while the next replaces the oldest.
    """
    compared = min(MAX_STORED / FLOAT, (1 + LONGEST_PERIOD) * window * (1.0 - NOT_COMPARED / rows))
    return compared + window + (LONGEST_PERIOD * window if channels.stores_raw_values(case) else 0.0)
