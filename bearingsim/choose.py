"""Which step a case needs, and what it will cost: computed before anything runs.

An explicit method is stable up to a step that stiffness and damping set. Damping often sets it, and grows with
the load, so the limit is taken twice: at rest, and at an estimate of the roller's impact on the far edge of the
steepest pit. All numbers are printed by ``bearingsim check``; a step near the limit at impact or over it is
refused.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from math import ceil, floor, inf, pi, sqrt
from typing import Any

from bearingsim import build
from bearingsim.config import CHANNELS, Case
from bearingsim.config.slicing import slice_count
from bearingsim.core.advance import start_at_rest
from bearingsim.core.contact import damping_slope, normal_force, stiffness_slope
from bearingsim.core.defects import DEPTH, REDUCED, SPAN, USED, X_E, B, sliding
from bearingsim.core.equilibrium import NoEquilibrium
from bearingsim.core.excitations import LEAPS
from bearingsim.core.methods.interface import load_number
from bearingsim.core.sampling import DECIMATION_REACH, RESAMPLE_REACH
from bearingsim.errors import Refused

SAFE = 0.9  # of the limit at impact, more is refused: it is a lone roller's, and the ring's motion lowers it
FEWEST_PER_CROSSING = 8  # fewer are refused
LONGEST = 20e-6  # s: a step nobody needs to exceed, for the models without a limit
SAMPLES_OF_A_PASS = 16  # cage angles at which the load at rest is looked at
FINE_PER_SAMPLE, FEWEST_FINE = 4, 64
MOST_STEPS = 10_000_000  # in a ball pass, whose recording is held in memory: 640 MB
OVERHEAD = 0.02  # CPU s per job: build, filters, features, writing


@dataclass(frozen=True)
class Limits:
    """What a case's step must respect. Times in s, forces in N, frequencies in Hz; inf where there is no limit.

    The limits are the method's own, on the linearised bearing; ``impact_force`` is an estimate of the peak.
    """

    rest_load: float
    contact_frequency: float
    damping_ratio: float
    at_rest: float
    closing_speed: float
    impact_force: float
    at_impact: float
    crossing: float


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
    """What a job will take: CPU seconds on one core, bytes on disk before compression, steps."""

    cpu_seconds: float
    bytes: int
    steps: int


def limits(case: Case) -> Limits:
    """Limits of the case's step (see ``Limits``). Raises ``Refused`` if nothing holds the ring."""
    try:
        return _limits(_at_full_speed(case))
    except NoEquilibrium as error:
        raise Refused(str(error), "give the bearing a load that its rollers can carry") from error


def _at_full_speed(case: Case) -> Case:
    """The case at the highest speed of its ramp, without the ramp."""
    if case.ramp is None:
        return case
    return case.model_copy(update={"speed": max(case.speed, case.ramp.to), "ramp": None})


def _limits(case: Case) -> Limits:
    rest_load, K, C = loads_at_rest(_healthy(case))
    omega = sqrt(K) if K > 0.0 else inf
    found = Limits(
        rest_load=rest_load,
        contact_frequency=omega / (2.0 * pi),
        damping_ratio=C / (2.0 * omega),
        at_rest=step_limit(case.method, K, C),
        closing_speed=0.0,
        impact_force=rest_load,
        at_impact=step_limit(case.method, K, C),
        crossing=inf,
    )
    return _with_pits(case, found, K, C) if build.kind(case).loaded else found


def _with_pits(case: Case, healthy: Limits, K: float, C: float) -> Limits:
    """The limits with what pits do to them."""
    model = build.model(case)
    speed = closing_speed(model)
    hits = [impact(model.bearing.m_r, law, speed) for law in (model.outer, model.inner)]
    hits += [leap(model, law, healthy.rest_load) for law in (model.outer, model.inner)]
    peak, K_more, C_more = (max(values) for values in zip(*hits, strict=True))
    return replace(
        healthy,
        closing_speed=speed,
        impact_force=peak + healthy.rest_load,
        at_impact=min(healthy.at_rest, step_limit(case.method, K + K_more, C + C_more)),
        crossing=crossing_time(model),
    )


def _healthy(case: Case) -> Case:
    """The case without what does not touch its load at rest; what is struck stands as a ring does."""
    same = build.healthy(case)
    return same if build.kind(case).loaded else same.model_copy(update={"model": "ring"})


@lru_cache(maxsize=256)
def loads_at_rest(healthy: Case) -> tuple[float, float, float]:
    """Largest outer contact force (N), stiffness/mass (1/s^2) and damping/mass (1/s) of a body over a pass."""
    model = build.relaxed(build.model(healthy), LONGEST)
    y = build.empty_buffer(model)
    pass_time = 2.0 * pi / (model.bearing.Z * model.bearing.omega_c)
    load, K, C = 0.0, 0.0, 0.0
    for n in range(SAMPLES_OF_A_PASS):
        t = (n + 0.5) / SAMPLES_OF_A_PASS * pass_time
        build.settle(model, t, y, from_scratch=n == 0)
        load = max(load, float(build.outer_forces(model, y).max()))
        K_now, C_now = start_at_rest(model, t, y)
        K, C = max(K, K_now), max(C, C_now)
    return load, float(K), float(C)


def crossing_time(model: Any) -> float:
    """The shortest time (s) a contact takes to cross a pit, or one of several merged; inf without pits."""
    pits = model.pits
    times = [pits.head[d, SPAN] / abs(sliding(pits, d, model.bearing)) for d in range(len(pits.head))]
    return float(min(times, default=inf))


def closing_speed(model: Any) -> float:
    """Estimate of the speed (m/s) at which a roller meets the far edge of the steepest pit.

    The envelope's slope is at most x/R with x the distance from the rim where the roller reaches wall, floor or
    middle; the roller moves past it at the sliding speed.
    """
    pits = model.pits
    speeds = [
        min(group[B], group[X_E], sqrt(2.0 * pits.head[d, REDUCED] * group[DEPTH]))
        / pits.head[d, REDUCED]
        * abs(sliding(pits, d, model.bearing))
        for d in range(len(pits.head))
        for group in pits.groups[d, : int(pits.head[d, USED])]
    ]
    return float(max(speeds, default=0.0))


def leap(model: Any, law: Any, load: float) -> tuple[float, float, float]:
    """What ``impact`` gives, for a roller under ``load`` (N) whose race comes back at once as the pit ends.

    Only for excitations with such a step. The roller has fallen by then, in free flight from what its inner
    contact gave it (at most load times approach), but no deeper than the pit; so far it is pressed into the race.
    """
    b, pits = model.bearing, model.pits
    if b.m_r == 0.0 or len(pits.head) == 0 or not isinstance(pits.excitation, LEAPS):
        return 0.0, 0.0, 0.0
    flight = crossing_time(model)
    outwards = b.omega_c**2 * 0.5 * (b.R_o + b.R_i)
    fall = sqrt(load * approach(law, load) / b.m_r) * flight + 0.5 * outwards * flight * flight
    deep = min(fall, float(pits.groups[:, :, DEPTH].max()))
    K, C = stiffness_slope(law, deep, 0.0), damping_slope(law, deep, 0.0)
    return float(normal_force(law, deep, 0.0)), float(K) / b.m_r, float(C) / b.m_r


def approach(law: Any, load: float) -> float:
    """The approach (m) of a contact at rest under ``load`` (N), by bisection."""
    low, high = 0.0, 1e-3
    while high - low > 1e-9 * high:
        middle = 0.5 * (low + high)
        if normal_force(law, middle, 0.0) > load:
            high = middle
        else:
            low = middle
    return high


def impact(m: float, law: Any, speed: float) -> tuple[float, float, float]:
    """A free roller of mass ``m`` (kg) thrown at one race with ``speed`` (m/s): peak force, largest slopes over m.

    Returns (N, stiffness/mass in 1/s^2, damping/mass in 1/s). Models whose rollers have no mass have no such
    impact: zeros.
    """
    return _impact(m, law, repr(law), speed)


@lru_cache(maxsize=1024)
def _impact(m: float, law: Any, named: str, speed: float) -> tuple[float, float, float]:
    """``impact``, remembered; ``named`` tells laws apart that are equal as tuples."""
    if m == 0.0 or speed == 0.0:
        return 0.0, 0.0, 0.0
    h = min(1e-7, 1e-3 * pi * sqrt(m / stiffness_slope(law, 1e-7, 0.0)))
    delta, v, peak, K, C = 0.0, speed, 0.0, 0.0, 0.0
    while v > 0.0:
        force = normal_force(law, delta, v)
        peak = max(peak, force)
        K = max(K, stiffness_slope(law, max(delta, 0.0), v))
        C = max(C, damping_slope(law, max(delta, 0.0), v))
        delta += h * v
        v -= h * normal_force(law, delta, v) / m
    return float(peak), float(K) / m, float(C) / m


def step_limit(method: str | None, K: float, C: float) -> float:
    """The step (s) at which a method turns unstable; K (1/s^2) and C (1/s) over a body's mass."""
    if method is None or (K == 0.0 and C == 0.0):
        return inf
    low, high = 0.0, 1.0
    while high - low > 1e-6 * high:
        h = 0.5 * (low + high)
        if load_number(build.METHODS[method].parameters(h), K, C) > 1.0:
            high = h
        else:
            low = h
    return low


def wanted_step(case: Case) -> float:
    """The step (s) a case asks for, or is given by ``auto``. Raises ``Refused`` if it must not be taken."""
    found = limits(case)
    if case.step == "auto":
        return automatic_step(case, found)
    safe = min(SAFE * found.at_impact, found.crossing / FEWEST_PER_CROSSING)
    if case.step > safe:
        raise Refused(_refusal(case.step, found), _advice(case, found))
    return case.step


def automatic_step(case: Case, found: Limits) -> float:
    """The step (s) that was measured to keep the line of the fault within about 1 % (see docs/methods.md)."""
    model, method = build.kind(case), build.method_kind(case)
    resolved = min(found.crossing / model.per_crossing, LONGEST)
    if model.memoryless:
        return resolved
    return min(resolved, method.fraction * found.at_impact, 1.0 / found.contact_frequency / method.per_period)


def _refusal(step: float, found: Limits) -> str:
    if step > SAFE * found.at_impact:
        return (
            f"a step of {1e6 * step:.3g} us is over {1e6 * SAFE * found.at_impact:.3g} us, {SAFE:.0%} of the"
            f" method's limit at an impact of about {found.impact_force:.0f} N"
            f" ({1e6 * found.at_rest:.3g} us at rest)"
        )
    return f"a step of {1e6 * step:.3g} us passes a pit of {1e6 * found.crossing:.3g} us in too few steps"


def _advice(case: Case, found: Limits) -> str:
    return f"say `step: auto` ({1e6 * automatic_step(case, found):.2g} us)"


def repeats(case: Case) -> bool:
    """Whether each ball pass equals the one before: nothing has memory, no pit turns, no roller is recorded."""
    return (
        build.kind(case).memoryless
        and all(defect.race == "outer" for defect in case.defects)
        and not any(name.startswith("roller") for name in case.record)
    )


def samples(case: Case) -> int:
    """Samples of the record."""
    return floor(case.duration * case.sampling + 1e-6)


def grid(case: Case, part: float = 1.0) -> Grid:
    """Cut the case in time: the wanted step, shortened until a ball pass holds a whole number of fine samples.

    part: of the wanted step, to take less. On a ramp the ball pass is that of the highest speed. Raises
    ``Refused`` like ``wanted_step``, if no sample falls into the record, or if a pass has too many steps.
    """
    if samples(case) < 1:
        raise Refused("no sample falls into the record", "take a higher `sampling` or a longer `duration`")
    rate = case.bearing.ball_pass_frequency(_at_full_speed(case).speed)
    fine = max(FEWEST_FINE, ceil(FINE_PER_SAMPLE * case.sampling / rate))
    decimation = max(1, ceil(1.0 / (rate * fine * part * wanted_step(case)) * (1.0 - 1e-12)))
    if fine * decimation > MOST_STEPS:
        raise Refused(
            f"a ball pass would take {fine * decimation:.2g} steps (at most {MOST_STEPS:.0e} are held in memory)",
            "lower `contact.damping`, which sets the step of an explicit method, or take a higher speed",
        )
    beyond = RESAMPLE_REACH / case.sampling + (DECIMATION_REACH + 2) / (rate * fine)
    passes = ceil((case.settle + case.duration + beyond) * rate)
    return Grid(rate, 1.0 / (rate * fine * decimation), fine, decimation, passes)


def estimate(case: Case) -> Estimate:
    """What the case will take. Raises ``Refused`` like ``wanted_step``."""
    cut = grid(case)
    computed = 1 if repeats(case) else cut.passes
    steps = computed * cut.steps_per_pass
    cost = build.method_kind(case).evaluations * build.kind(case).cost * (slice_count(case) or 1)
    columns = sum(len(CHANNELS[name].components) for name in case.record)
    return Estimate(
        cpu_seconds=OVERHEAD + steps * cost,
        bytes=4 * columns * samples(case),
        steps=steps,
    )
