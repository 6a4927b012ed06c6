"""Time grid of a case, and estimates of its CPU time, memory and disk space (``bearingsim check``)."""

from dataclasses import dataclass
from math import ceil, floor

from bearingsim import assemble, memory
from bearingsim.assemble.scales import full_speed_case
from bearingsim.config import Case
from bearingsim.config.names import LINES, read_band
from bearingsim.core.sampling import DECIMATION_HALF_LENGTH, INTERPOLATION_HALF_LENGTH, RESAMPLE_HALF_LENGTH
from bearingsim.errors import Refused
from bearingsim.memory import PROGRAM_BYTES
from bearingsim.simulation import pricing
from bearingsim.simulation.choice import automatic_step, resolve
from bearingsim.simulation.limits import SAFETY, Limits, longest_step, step_limits
from bearingsim.simulation.pricing import Cost, RecordSize, coefficient, cpu_per_second, estimate_cost, solved_once
from bearingsim.simulation.repetition import searches_for_period
from bearingsim.simulation.settling import refuse_unsettled

FINE_PER_SAMPLE, MIN_FINE = 4, 64  # smallest numbers of fine samples per sample and per ball pass
PASSBAND = 0.15  # upper limit of the fine samples' pass band over the fine rate (core/sampling.py)
MAX_STEPS = 10_000_000  # largest number in a ball pass, which is recorded in memory (640 MB)
MAX_CPU = 12 * 3600.0  # s, CPU time above which a job is refused unless it gives its own step


@dataclass(frozen=True)
class Grid:
    """Time grid of a case.

    rate: ball passes per second (Hz); step: s; fine_per_pass: fine samples per ball pass; decimation: steps per
    fine sample; passes: ball passes of settling, the record, and half the filter's length beyond it.
    """

    rate: float
    step: float
    fine_per_pass: int
    decimation: int
    passes: int

    @property
    def fine_rate(self) -> float:
        """Fine samples per second (Hz)."""
        return self.rate * self.fine_per_pass

    @property
    def steps_per_pass(self) -> int:
        """Integrator steps in a ball pass."""
        return self.fine_per_pass * self.decimation


@dataclass(frozen=True)
class Estimate:
    """Estimate of a job: CPU seconds on one core, bytes on disk before compression, steps of the run itself.

    check_seconds: part of ``cpu_seconds`` for the step check; memory: peak bytes, without those of the program;
    max_seconds, max_memory: CPU seconds and peak bytes if the response is not periodic.
    """

    cpu_seconds: float
    bytes: int
    steps: int
    check_seconds: float = 0.0
    max_seconds: float = 0.0
    memory: float = 0.0
    max_memory: float = 0.0


def requested_step(case: Case) -> float:
    """Return the step (s) of a case, its own or the automatic one. Raises ``Refused`` if its own is too long."""
    case = resolve(case)
    limits = step_limits(case)
    if case.step == "auto":
        return automatic_step(case, limits)
    if case.step > longest_step(limits):
        advice = f"use `step: auto` ({1e6 * automatic_step(case, limits):.2g} us)"
        raise Refused(_refusal(case.step, limits), advice)
    return case.step


def _refusal(step: float, limits: Limits) -> str:
    """Return the reason why a step (s) is too long."""
    if step > SAFETY * limits.at_impact:
        return (
            f"a step of {1e6 * step:.3g} us is over {1e6 * SAFETY * limits.at_impact:.3g} us, {SAFETY:.0%} of the"
            f" method's limit at an impact ({1e6 * limits.at_rest:.3g} us at rest)"
        )
    if limits.wave < limits.crossing:
        obstacle = f"an undulation of {1e6 * limits.wave:.3g} us"
    else:
        obstacle = f"a defect of {1e6 * limits.crossing:.3g} us"
    return f"a step of {1e6 * step:.3g} us passes {obstacle} in too few steps"


def sample_count(case: Case) -> int:
    """Return the number of samples of the record."""
    return floor(case.duration * case.sampling + 1e-6)


def highest_band_limit(case: Case) -> float:
    """Return the highest upper limit (Hz) of the bands in a case's features; 0 if there are none."""
    features = (read_band(name) for name in case.features)
    return max((feature.band.high for feature in features if feature and feature.band), default=0.0)


def highest_line_frequency(case: Case) -> float:
    """Return the highest frequency (Hz) of all ``LINES`` at the highest speed of a case."""
    speed = full_speed_case(case).speed
    return max(case.bearing.line_frequency(line, speed) for line in LINES.values())


def make_grid(case: Case, step_fraction: float = 1.0, max_cpu: float = 0.0) -> Grid:
    """Compute the time grid of a case, with the step shortened to fit a whole number of steps into a ball pass.

    step_fraction: fraction of the requested step; max_cpu: CPU time (s) allowed for all steps, if more than
    ``MAX_CPU``. On a ramp the ball pass is that of the highest speed. Raises ``Refused`` like ``requested_step``,
    and if the record has no sample, if a pass has too many steps, or if the steps take too long.
    """
    if sample_count(case) < 1:
        raise Refused("no sample falls into the record", "use a higher `sampling` or a longer `duration`")
    has_named_method, case = case.method != "auto", resolve(case)
    other = ", or use `method: auto`" if has_named_method else ""
    rate = case.bearing.ball_pass_frequency(full_speed_case(case).speed)
    highest = max(highest_band_limit(case), highest_line_frequency(case))
    fine = max(MIN_FINE, ceil(max(FINE_PER_SAMPLE * case.sampling, highest / PASSBAND) / rate))
    decimation = max(1, ceil(1.0 / (rate * fine * step_fraction * requested_step(case)) * (1.0 - 1e-12)))
    if fine * decimation > MAX_STEPS:
        raise Refused(
            f"a ball pass would take {fine * decimation:.2g} steps (at most {MAX_STEPS:.0e} are stored in memory)",
            f"lower `contact.damping`, which sets an explicit method's step{other or ', or use a higher speed'}"
            if case.step == "auto"
            else "use a longer `step`, or use `step: auto`",
        )
    computed = 1.0 / rate if solved_once(case) else case.settle_s + case.duration
    seconds = computed * cpu_per_second(case, 1.0 / (rate * fine * decimation))
    adaptive = assemble.is_adaptive(case)
    limit = max(max_cpu, MAX_CPU)
    if seconds > limit and (case.step == "auto" or adaptive):
        name, hours = case.method or f"`{case.model}`", seconds / 3600.0
        raise Refused(
            f"{name} would take about {hours:.2g} h of CPU time, over {limit / 3600.0:.2g} h",
            "use a shorter `duration`, lower `contact.damping`" + (other if adaptive else ", or set `step`"),
        )
    fine_samples = DECIMATION_HALF_LENGTH + INTERPOLATION_HALF_LENGTH + 2
    filter_time = RESAMPLE_HALF_LENGTH / case.sampling + fine_samples / (rate * fine)
    passes = ceil((case.settle_s + case.duration + filter_time) * rate)
    return Grid(rate, 1.0 / (rate * fine * decimation), fine, decimation, passes)


def estimate(case: Case) -> Estimate:
    """Estimate CPU time, memory and disk space of a case.

    Raises ``Refused`` like ``requested_step`` and ``refuse_unsettled``, and if the memory is insufficient.
    """
    case = resolve(case)
    refuse_unsettled(case)
    grid = make_grid(case)
    costs = estimate_cost(case, grid.step, grid.passes)
    expected, non_periodic_size = _sizes(case, grid, costs)
    memory_expected, max_memory = _memory(case, grid, costs)
    _refuse_too_large(max_memory)
    unchecked_size = expected._replace(checked=0.0)
    seconds, unchecked, longest = (
        pricing.count_operations(case, size).seconds for size in (expected, unchecked_size, non_periodic_size)
    )
    return Estimate(
        cpu_seconds=coefficient("job") + costs.total + seconds,
        bytes=4 * expected.columns * expected.samples,
        steps=costs.passes * grid.steps_per_pass,
        check_seconds=costs.check + seconds - unchecked,
        max_seconds=coefficient("job") + costs.non_periodic + longest,
        memory=memory_expected,
        max_memory=max_memory,
    )


def _memory(case: Case, grid: Grid, costs: Cost) -> tuple[float, float]:
    """Return the peak memory (bytes) of a case: expected, and if its response is not periodic.

    With `periodic: false` and a step check on a period, the search for the period may need more than the run.
    """
    peaks = [pricing.peak_memory(case, size) for size in _sizes(case, grid, costs)]
    if not case.periodic and searches_for_period(case):
        periodic = case.model_copy(update={"periodic": True})
        search_sizes = _sizes(periodic, grid, estimate_cost(periodic, grid.step, grid.passes))
        peaks = [
            max(run, pricing.peak_memory(periodic, size)) for run, size in zip(peaks, search_sizes, strict=True)
        ]
    return peaks[0], peaks[1]


def _sizes(case: Case, grid: Grid, costs: Cost) -> tuple[RecordSize, RecordSize]:
    """Return the size of a case with a named method: expected, and if its response is not periodic."""
    expected = pricing.make_record_size(
        case, grid.fine_per_pass, grid.decimation, costs.passes, costs.check / costs.one_pass
    )
    if costs.non_periodic == costs.total:
        return expected, expected
    return expected, expected.with_passes(grid.passes, costs.non_periodic / costs.one_pass - grid.passes)


def refuse_too_large(case: Case, grid: Grid) -> None:
    """Raise ``Refused`` if a case with a named method may need more memory than is available."""
    _refuse_too_large(_memory(case, grid, estimate_cost(case, grid.step, grid.passes))[1])


def _refuse_too_large(max_memory: float) -> None:
    """Raise ``Refused`` if ``max_memory`` (bytes) and the program need more memory than is available."""
    needed, available = PROGRAM_BYTES + max_memory, memory.limit()
    if needed > available:
        raise Refused(
            f"a job may need {needed / 1e9:.2g} GB of memory, and {available / 1e9:.2g} GB are available",
            "use a shorter `duration`, a lower `sampling`, or a shorter `record`",
        )
