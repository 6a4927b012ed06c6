"""A case cut in time, and what it will take: known before anything runs, and printed by ``bearingsim check``."""

from dataclasses import dataclass
from math import ceil, floor

from bearingsim import assemble
from bearingsim.assemble.scales import MIN_STEPS_PER_CROSSING, at_full_speed
from bearingsim.config import CHANNELS, Case
from bearingsim.core.sampling import DECIMATION_REACH, INTERPOLATION_REACH, RESAMPLE_REACH
from bearingsim.errors import Refused
from bearingsim.simulation.automatic_step import automatic_step
from bearingsim.simulation.choice import resolved
from bearingsim.simulation.cost import cost, solved_once
from bearingsim.simulation.limits import Limits, step_limits
from bearingsim.simulation.prices import per_second, price

SAFETY = 0.9  # of the limit at impact, more is refused: it is a lone roller's, and the ring's motion lowers it
FINE_PER_SAMPLE, MIN_FINE = 4, 64
MAX_STEPS = 10_000_000  # in a ball pass, whose recording is held in memory: 640 MB
MAX_CPU = 12 * 3600.0  # s: a job of more is refused, unless it gives its own step


@dataclass(frozen=True)
class Grid:
    """How a case is cut in time.

    rate: ball passes per second (Hz); ``fine_per_pass`` fine samples in each, ``decimation`` steps of ``step`` s
    to a fine sample. ``passes`` are computed: settling, the record, and what its last sample's filter reaches.
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
    """What a job will take: CPU seconds on one core, bytes on disk before compression, steps of the run itself.

    check_seconds: of ``cpu_seconds``, to prove its step; most_seconds: as ``cpu_seconds``, of a motion that might
    repeat itself and does not.
    """

    cpu_seconds: float
    bytes: int
    steps: int
    check_seconds: float = 0.0
    most_seconds: float = 0.0


def requested_step(case: Case) -> float:
    """The step (s) a case asks for, or is given by ``auto``. Raises ``Refused`` if it must not be taken."""
    case = resolved(case)
    found = step_limits(case)
    if case.step == "auto":
        return automatic_step(case, found)
    safe = min(SAFETY * found.at_impact, found.crossing / MIN_STEPS_PER_CROSSING)
    if case.step > safe:
        raise Refused(_refusal(case.step, found), _advice(case, found))
    return case.step


def _refusal(step: float, found: Limits) -> str:
    if step > SAFETY * found.at_impact:
        return (
            f"a step of {1e6 * step:.3g} us is over {1e6 * SAFETY * found.at_impact:.3g} us, {SAFETY:.0%} of the"
            f" method's limit at an impact ({1e6 * found.at_rest:.3g} us at rest)"
        )
    return f"a step of {1e6 * step:.3g} us passes a pit of {1e6 * found.crossing:.3g} us in too few steps"


def _advice(case: Case, found: Limits) -> str:
    return f"say `step: auto` ({1e6 * automatic_step(case, found):.2g} us)"


def samples(case: Case) -> int:
    """Samples of the record."""
    return floor(case.duration * case.sampling + 1e-6)


def grid(case: Case, part: float = 1.0, max_cpu: float = 0.0) -> Grid:
    """Cut the case in time: the wanted step, shortened until a ball pass holds a whole number of fine samples.

    part: of the wanted step, to take less; max_cpu: seconds that all steps may take, if more than ``MAX_CPU``.
    On a ramp the ball pass is that of the highest speed. Raises ``Refused`` like ``requested_step``, if no sample
    falls into the record, if a pass has too many steps, or if all take too long.
    """
    if samples(case) < 1:
        raise Refused("no sample falls into the record", "take a higher `sampling` or a longer `duration`")
    named, case = case.method != "auto", resolved(case)
    other = ", or say `method: auto`" if named else ""
    rate = case.bearing.ball_pass_frequency(at_full_speed(case).speed)
    fine = max(MIN_FINE, ceil(FINE_PER_SAMPLE * case.sampling / rate))
    decimation = max(1, ceil(1.0 / (rate * fine * part * requested_step(case)) * (1.0 - 1e-12)))
    if fine * decimation > MAX_STEPS:
        raise Refused(
            f"a ball pass would take {fine * decimation:.2g} steps (at most {MAX_STEPS:.0e} are held in memory)",
            f"lower `contact.damping`, which sets an explicit method's step{other or ', or take a higher speed'}"
            if case.step == "auto"
            else "take a longer `step`, or say `step: auto`",
        )
    computed = 1.0 / rate if solved_once(case) else case.settle + case.duration
    seconds = computed * per_second(case, 1.0 / (rate * fine * decimation))
    adaptive = assemble.adaptive(case)
    most = max(max_cpu, MAX_CPU)
    if seconds > most and (case.step == "auto" or adaptive):
        what, hours = case.method or f"`{case.model}`", seconds / 3600.0
        raise Refused(
            f"{what} would take about {hours:.2g} h of CPU time, over {most / 3600.0:.2g} h",
            "take a shorter `duration`, lower `contact.damping`"
            + (other if adaptive else ", or give a `step` of your own"),
        )
    beyond = RESAMPLE_REACH / case.sampling + (DECIMATION_REACH + INTERPOLATION_REACH + 2) / (rate * fine)
    passes = ceil((case.settle + case.duration + beyond) * rate)
    return Grid(rate, 1.0 / (rate * fine * decimation), fine, decimation, passes)


def estimate(case: Case) -> Estimate:
    """What the case will take. Raises ``Refused`` like ``requested_step``."""
    case = resolved(case)
    cut = grid(case)
    found = cost(case, cut.step, cut.passes)
    columns = sum(len(CHANNELS[name].components) for name in case.record)
    return Estimate(
        cpu_seconds=price("job") + found.whole,
        bytes=4 * columns * samples(case),
        steps=found.passes * cut.steps_per_pass,
        check_seconds=found.proof,
        most_seconds=price("job") + found.at_most,
    )
