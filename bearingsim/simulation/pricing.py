"""CPU time and memory of a case: of its steps, of the passes that check them, of recording and reading features.

CPU time is a count of evaluations and operations times the measured prices of ``prices.csv``. These hold for one
core of a 2.6 GHz server, and are the same on every machine, because the choice of a method rests on them;
``benchmarks/step_cost.py`` measures them. Memory is that of the arrays alive at once: those of the step check are
freed before those of the run.
"""

import csv
from functools import cache
from math import ceil, inf, sqrt
from pathlib import Path
from typing import NamedTuple

from bearingsim import assemble
from bearingsim.assemble.bending import has_carrier, ring_parameters, spring_properties
from bearingsim.assemble.contacts import powers
from bearingsim.assemble.scales import full_speed_case
from bearingsim.catalogue import EXPLICIT, METHODS, MODELS
from bearingsim.config import CHANNELS, Case
from bearingsim.config.names import read_band
from bearingsim.config.rules.completion import slice_count
from bearingsim.core.sampling import DECIMATION_REACH, RESAMPLE_REACH
from bearingsim.simulation import channels, ending
from bearingsim.simulation.limits import LONGEST, Limits, step_limits
from bearingsim.simulation.pilot import check_cost
from bearingsim.simulation.repetition import LONGEST_PERIOD, MOST_HELD, may_repeat, period_is_sought
from bearingsim.simulation.settling import extrapolation_passes

TABLE = Path(__file__).with_name("prices.csv")
USUAL = ""
"""Name in the table for models and methods without a row, such as another package's model."""
OWN_PER_PERIOD = 10.0  # steps of an adaptive method in a period of contacts that ring
RINGING_RATIO = 0.1  # damping ratio under which contacts ring
# power of the damping ratio, over 1, by which it shortens own steps (Rodas, m3 = 0; others roughly)
DAMPING_POWER = 0.37


@cache
def prices() -> dict[tuple[str, str], float]:
    """Return the table of prices by operation and name of model or method."""
    with TABLE.open(newline="") as file:
        return {(row["what"], row["name"]): float(row["value"]) for row in csv.DictReader(file)}


def price(what: str, name: str = USUAL) -> float:
    """Return a number of the table, or the usual one."""
    return prices().get((what, name), prices()[what, USUAL])


def compiling(case: Case) -> float:
    """Return the CPU time (s) of compiling the code of a case, where nothing of it is in the cache."""
    return price("compile", case.model)


def evaluation(case: Case) -> float:
    """Return the CPU time (s) of one evaluation of the case's model."""
    of_rollers = (price("evaluation", case.model) + price("power") * powers(case)) * (slice_count(case) or 1)
    return of_rollers + bending(case)


def bending(case: Case) -> float:
    """Return the CPU time (s) of a ring which bends, and of the springs around it, in an evaluation."""
    if case.rig.ring is None:
        return 0.0
    springs = len(spring_properties(ring_parameters(case))[0]) if has_carrier(case.rig) else 0
    return (price("harmonic", case.model) + price("spring") * springs) * float(case.rig.ring.harmonics)


def per_step(method: str, model: str, evaluations: int) -> float:
    """Return the CPU time of a method's step in evaluations of the model, overhead included (docs/cost.md).

    evaluations: of the model in a step, the price of a method without a row of its own.
    """
    usual = price("adaptive step") if METHODS[method].adaptive else 1.0
    of_any = prices().get(("step", method), usual * evaluations)
    return prices().get(("step", f"{method} {model}"), of_any)


def per_second(case: Case, step: float) -> float:
    """Return the CPU time (s) of the steps of a simulated second."""
    kind = assemble.method_kind(case)
    if case.method is None:
        return evaluation(case) / step * kind.evaluations
    step_cost = per_step(case.method, case.model, kind.evaluations)
    if not METHODS[case.method].adaptive:
        return evaluation(case) / step * step_cost
    own = adaptive_step(case, step_limits(case.model_copy(update={"method": EXPLICIT})))
    return evaluation(case) * (price("record") / step + step_cost / own)


def adaptive_step(case: Case, limits: Limits) -> float:
    """Estimate the length (s) of an adaptive method's own steps.

    Those of an explicit one are bounded by its stability on contacts at rest; those of an implicit one by crossing
    times, and by contacts that ring or open.
    """
    usual, name = price("own steps"), str(case.method)
    steps = price("own steps", name)
    smooth = min(limits.crossing, LONGEST * usual) / steps
    if not METHODS[name].implicit:
        return min(smooth, price("stable step", name) / limits.fastest_rate)
    rings = 1.0 / limits.contact_frequency / OWN_PER_PERIOD if limits.damping_ratio < RINGING_RATIO else inf
    return min(smooth, rings, LONGEST * usual / steps / max(1.0, limits.damping_ratio) ** DAMPING_POWER)


class Cost(NamedTuple):
    """CPU time (s) of a run: of its steps, of their check (proof), and of both if the response is not periodic.

    passes: computed ball passes; one_pass: CPU time (s) of one.
    """

    steps: float
    proof: float
    at_most: float
    passes: int
    one_pass: float

    @property
    def whole(self) -> float:
        """Steps and proof."""
        return self.steps + self.proof


def cost(case: Case, step: float, passes: int | None = None) -> Cost:
    """Estimate the cost of a case, its method named, at steps of ``step`` s (adaptive: between recorded instants).

    passes: ball passes of the whole run, if not those of settling and duration.
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
    elif (record := next(ending.looks(case), None)) is not None:
        computed = min(whole, ceil(case.settle_s * rate) + record)
        shortest = case.model_copy(update={"duration": record / rate})
        proof = check_cost(shortest) * computed if case.checks_step else 0.0
    if case.checks_step and period_is_sought(case):
        proof = sqrt(5.0) * (price("finer passes") + before)
        if not case.periodic:
            proof += before + in_a_period
    computed += before
    return Cost(one_pass * computed, one_pass * proof, at_most, computed, one_pass)


def solved_once(case: Case) -> bool:
    """Check if one ball pass is all that is computed: the model has no memory and every pass is the same."""
    return MODELS[case.model].memoryless and may_repeat(case)


FLOAT = 8  # bytes
SENSED = 6  # rows along the sensor that are filtered for statistics
FINER = sqrt(5.0)  # times as many steps are taken to check them
PASSES_CHECKED = 2.0 / (1.0 + FINER)  # in a step check that takes the steps of one pass: coarse ones and fine
BLOCK = 1 << 16  # fine samples read at a time: of a long record a copy of all rows is larger than all else
TURNED = 180.0  # values for each fine sample of a block while lines of bodies that slip are read
STEADY, TURNING = 6.0, 16.0  # values for each fine sample while lines are read, at constant speeds and at others
BANDED = 14.0  # values for each fine sample of the record while features of bands are read
PILOT = 3.0  # rows of a pilot's, as they are, filtered, and with filters' reach
COMPARED = 6.0  # values for each fine sample that are kept of a pilot
WRITTEN = 3.0  # values for each sample of a series: filtered, of one precision and of the other
LOOKS = 5.0  # lengths of all that a record is looked at over that ends as it is accurate enough: 1 + 1/1.25 + ...
NOT_COMPARED = 5  # rows of a pass left out of its comparison: accelerations, counts of rollers, the cage
SMALL = 8e6  # bytes of all that is small


class Counts(NamedTuple):
    """Operations on a run, by the rows of ``prices.csv`` with the price of each.

    kept_value: values recorded, one for each row and step; kept_pass: ball passes; tap: of the low-pass, over all
    that is filtered; line_sample, turning_sample: fine samples that lines are read from, at constant speeds and at
    others; ramp_sample: of these, at a speed that changes; band_sample: of the record, for each feature of a band;
    sample: of the record's series, and of rows picked at their instants; written: numbers.
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

    rows: recorded, of which ``requested`` make series; computed: ball passes of ``fine`` fine samples and
    ``steps`` steps each; read: fine samples that differ within the record; whole: fine samples of the record;
    samples: of each of ``columns`` series; checked: passes' worth of steps in the step check.
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
    """Return the size of a case, its method named, with the ball passes ``computed`` and ``checked``."""
    whole = case.duration * case.bearing.ball_pass_frequency(full_speed_case(case).speed) * fine
    cells = channels.recorded(case)
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
        sample=float(of.samples * (of.requested + (of.rows if channels.picks(case) else 0))),
        written=float(of.samples * of.columns),
    )


def memory(case: Case, of: Size) -> float:
    """Return the largest memory (bytes) of a run of that size, without the program's own."""
    turning = case.ramp is not None or MODELS[case.model].slips
    lines = TURNING * of.read + TURNED * min(of.read, BLOCK) if turning else STEADY * of.read
    lead = RESAMPLE_REACH * of.whole / max(1, of.samples)
    window = of.rows * (of.steps + 2 * DECIMATION_REACH * of.steps / of.fine)
    picked = float(of.rows * of.samples) if channels.picks(case) else 0.0
    recording = of.rows * (of.computed * of.fine + lead) + picked
    banded = BANDED * of.whole if _bands(case) else 0.0
    series = (of.requested + WRITTEN * of.columns + 2.0) * of.samples
    pilot = PASSES_CHECKED * of.checked / 2.0 * of.fine
    check = (PILOT * of.rows + COMPARED) * pilot + 2.0 * window
    most = max(lines, banded, series, window)
    if not may_repeat(case):
        return FLOAT * max(recording + most, check) + SMALL
    stepped = window + _held(case, window, of.rows)
    if of.checked > 0.0:  # a period is computed again, in finer steps, and recorded too
        stepped = FINER * stepped + recording
    return FLOAT * (recording + max(most, stepped, check)) + SMALL


def _bands(case: Case) -> int:
    """Count the features of bands, which are read from all fine samples of the record."""
    return sum(read_band(name) is not None for name in case.features)


def _held(case: Case, window: float, rows: int) -> float:
    """Count values of the ball passes that are held to compare the next with, and to pick contact forces from.

    One more is held while the next replaces the oldest.
    """
    compared = min(MOST_HELD / FLOAT, (1 + LONGEST_PERIOD) * window * (1.0 - NOT_COMPARED / rows))
    return compared + window + (LONGEST_PERIOD * window if channels.picks(case) else 0.0)
