"""Which method and step a case needs, and what it will cost: computed before anything runs.

The method is the cheapest that holds 1 %, by the limits of its step and what a step costs; the step is what was
measured to keep that (docs/methods.md). All numbers are printed by ``bearingsim check``; a step near the method's
limit at impact or over it is refused.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from math import ceil, floor, inf
from typing import NamedTuple

from bearingsim import assemble
from bearingsim.assemble.contacts import powers
from bearingsim.assemble.scales import FEWEST_PER_CROSSING, at_full_speed
from bearingsim.config import CHANNELS, Case
from bearingsim.config.rules.slicing import slice_count
from bearingsim.core.models.interface import linearise
from bearingsim.core.sampling import DECIMATION_REACH, RESAMPLE_REACH
from bearingsim.errors import Refused
from bearingsim.simulation.limits import LONGEST, Limits, step_limits
from bearingsim.simulation.pilot import share

SAFE = 0.9  # of the limit at impact, more is refused: it is a lone roller's, and the ring's motion lowers it
FINE_PER_SAMPLE, FEWEST_FINE = 4, 64
MOST_STEPS = 10_000_000  # in a ball pass, whose recording is held in memory: 640 MB
OVERHEAD = 0.02  # CPU s per job: build, filters, features, writing
MOST_CPU = 12 * 3600.0  # s: a job of more is refused, unless it gives its own step
SHORTENED = (1.0, 0.5, 0.25, 0.125)
"""Parts of an automatic step that are tried in turn; with half of it goes a tenth of the tolerance."""

PER_STEP = {"verlet": 1.2, "dop853": 21.0, "rodas": 16.0, "backward-euler": 12.0}
"""CPU time of a step of its own in evaluations of the model, all that goes with it included: docs/methods.md."""
USUAL_PER_STEP = 1.7  # of an adaptive method that is not listed, to each of its evaluations
PER_RECORD = 2.5  # and of an instant that an adaptive method records
PER_POWER = 0.22e-6  # CPU s, in each evaluation of a model, of a law's power that is the library's
USUAL_OWN_STEPS = 25.0
OWN_STEPS = {"backward-euler": 600.0}
"""Steps of its own over a pit of an adaptive method that needs other than the usual, at its usual tolerance."""
OWN_PER_PERIOD = 25.0  # and in a period of contacts that ring
REACH = 3.0  # step of an explicit adaptive method over Verlet's limit
RINGS = 0.3  # damping ratio under which they do
HEAVY = 0.37  # power of the damping ratio, over 1, by which it shortens them (Rodas, m3 = 0; others roughly)
FAVOUR = 3.0  # what an implicit method must save: Verlet's price is certain, its own an estimate
SHOWN_PER_CROSSING, SHOWN_PER_PERIOD = 40, 10
"""Recorded instants of an adaptive method over a pit, and in a period of contacts that ring."""


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

    proof_seconds: of ``cpu_seconds``, to prove its step.
    """

    cpu_seconds: float
    bytes: int
    steps: int
    proof_seconds: float = 0.0


class Choice(NamedTuple):
    """A method for a case, why in words, and what each able one would cost (CPU s), the cheapest first."""

    method: str | None
    why: str
    prices: dict[str, float]


class Attempt(NamedTuple):
    """One way to compute a case: its method named, and the part of the automatic step (or tolerance) to take."""

    case: Case
    part: float


def resolved(case: Case) -> Case:
    """The case with a method instead of `auto`."""
    return using(case, choice(case).method) if case.method == "auto" else case


def limits(case: Case) -> Limits:
    """What the case's step must respect, by the method that it is given or chosen."""
    return step_limits(resolved(case))


def using(case: Case, method: str | None) -> Case:
    """The case with a method of that name."""
    return case.model_copy(update={"method": method})


def attempts(case: Case) -> Iterator[Attempt]:
    """What to try in turn until a run proves right: shorter automatic steps, then (with `auto`) other methods."""
    first = resolved(case)
    parts = SHORTENED if case.automatic and case.tolerance == "auto" else (1.0,)
    for part in parts:
        yield Attempt(first, part)
    if case.method == "auto" and case.automatic:
        for name in alternatives(first):
            yield from (Attempt(using(case, name), part) for part in parts)


def alternatives(case: Case) -> list[str]:
    """Other methods of the automatic set that can step the case, the cheapest first; none if it has no method."""
    if case.method is None:
        return []
    return [name for name in choice(using(case, "auto")).prices if name != case.method]


@lru_cache(maxsize=1024)
def choice(case: Case) -> Choice:
    """The cheapest method that holds 1 % of the fault's line. Raises ``Refused`` like ``limits``.

    DOP853 costs what Verlet does where contacts are soft and little damped, and is kept for what Verlet fails at.
    """
    if case.method != "auto":
        return Choice(case.method, "the case says so" if case.method else f"{case.model} has no method", {})
    able = [name for name in assemble.METHODS if assemble.METHODS[name].automatic and can(case, name)]
    if case.tolerance != "auto":  # only those that keep one
        able = [name for name in able if assemble.METHODS[name].adaptive]
    prices = dict(sorted(((name, _integration(using(case, name))) for name in able), key=lambda pair: pair[1]))
    found = step_limits(using(case, "verlet"))
    if "verlet" not in prices:
        return Choice(next(iter(prices)), "the cheapest of those that keep a tolerance", prices)
    implicit = [name for name in prices if assemble.METHODS[name].implicit]
    chosen = implicit[0] if implicit and FAVOUR * prices[implicit[0]] < prices["verlet"] else "verlet"
    return Choice(chosen, _reason(chosen, prices, found), prices)


def can(case: Case, name: str) -> bool:
    """Whether a method can step the case's model: an implicit one needs its derivatives."""
    return not assemble.METHODS[name].implicit or assemble.kind(case).parameters in linearise.types


def _reason(chosen: str, prices: dict[str, float], found: Limits) -> str:
    if chosen == "verlet":
        return "no implicit method would take less than a third of its CPU time"
    saved = prices["verlet"] / prices[chosen]
    return f"explicit steps are limited to {1e6 * found.at_impact:.2g} us: about {saved:.0f} times the CPU time"


def _integration(case: Case) -> float:
    """CPU time (s) of all steps of a case whose method is named, at the automatic step."""
    return (case.settle + case.duration) * per_second(case, automatic_step(case, step_limits(case)))


def per_second(case: Case, step: float) -> float:
    """CPU time (s) of the steps of a simulated second."""
    kind = assemble.method_kind(case)
    cost = (assemble.kind(case).cost + PER_POWER * powers(case)) * (slice_count(case) or 1)
    if not kind.adaptive:
        return cost / step * PER_STEP.get(str(case.method), kind.evaluations)
    own = own_step(case, step_limits(using(case, "verlet")))
    return cost * (PER_RECORD / step + PER_STEP.get(str(case.method), USUAL_PER_STEP * kind.evaluations) / own)


def own_step(case: Case, found: Limits) -> float:
    """About how long (s) the steps of an adaptive method are: what rings, is crossed, or opens sets them."""
    steps = OWN_STEPS.get(str(case.method), USUAL_OWN_STEPS)
    smooth = min(found.crossing, LONGEST * USUAL_OWN_STEPS) / steps
    rings = 1.0 / found.contact_frequency / OWN_PER_PERIOD if found.damping_ratio < RINGS else inf
    limit = inf if assemble.method_kind(case).implicit else REACH * found.at_impact
    opens = LONGEST * USUAL_OWN_STEPS / steps / max(1.0, found.damping_ratio) ** HEAVY
    return min(smooth, rings, limit, opens)


def wanted_step(case: Case) -> float:
    """The step (s) a case asks for, or is given by ``auto``. Raises ``Refused`` if it must not be taken."""
    case = resolved(case)
    found = step_limits(case)
    if case.step == "auto":
        return automatic_step(case, found)
    safe = min(SAFE * found.at_impact, found.crossing / FEWEST_PER_CROSSING)
    if case.step > safe:
        raise Refused(_refusal(case.step, found), _advice(case, found))
    return case.step


def automatic_step(case: Case, found: Limits) -> float:
    """The step (s) that was measured to keep the line of the fault within about 1 % (see docs/methods.md).

    Of an adaptive method, which sees to that itself, the time between recorded instants.
    """
    model, method = assemble.kind(case), assemble.method_kind(case)
    if method.adaptive:
        rings = 1.0 / found.contact_frequency / SHOWN_PER_PERIOD if found.damping_ratio < 1.0 else inf
        return min(found.crossing / SHOWN_PER_CROSSING, rings, LONGEST)
    seen = min(found.crossing / model.per_crossing, LONGEST)
    if model.memoryless:
        return seen
    return min(seen, method.fraction * found.at_impact, 1.0 / found.contact_frequency / method.per_period)


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
        assemble.kind(case).memoryless
        and all(defect.race == "outer" for defect in case.defects)
        and not any(name.startswith("roller") for name in case.record)
    )


def samples(case: Case) -> int:
    """Samples of the record."""
    return floor(case.duration * case.sampling + 1e-6)


def grid(case: Case, part: float = 1.0, most_cpu: float = 0.0) -> Grid:
    """Cut the case in time: the wanted step, shortened until a ball pass holds a whole number of fine samples.

    part: of the wanted step, to take less; most_cpu: seconds that all steps may take, if more than ``MOST_CPU``.
    On a ramp the ball pass is that of the highest speed. Raises ``Refused`` like ``wanted_step``, if no sample
    falls into the record, if a pass has too many steps, or if all take too long.
    """
    if samples(case) < 1:
        raise Refused("no sample falls into the record", "take a higher `sampling` or a longer `duration`")
    named, case = case.method != "auto", resolved(case)
    other = ", or say `method: auto`" if named else ""
    rate = case.bearing.ball_pass_frequency(at_full_speed(case).speed)
    fine = max(FEWEST_FINE, ceil(FINE_PER_SAMPLE * case.sampling / rate))
    decimation = max(1, ceil(1.0 / (rate * fine * part * wanted_step(case)) * (1.0 - 1e-12)))
    if fine * decimation > MOST_STEPS:
        raise Refused(
            f"a ball pass would take {fine * decimation:.2g} steps (at most {MOST_STEPS:.0e} are held in memory)",
            f"lower `contact.damping`, which sets an explicit method's step{other or ', or take a higher speed'}"
            if case.step == "auto"
            else "take a longer `step`, or say `step: auto`",
        )
    computed = 1.0 / rate if repeats(case) else case.settle + case.duration
    price = computed * per_second(case, 1.0 / (rate * fine * decimation))
    adaptive = assemble.method_kind(case).adaptive
    most = max(most_cpu, MOST_CPU)
    if price > most and (case.step == "auto" or adaptive):
        what, hours = case.method or f"`{case.model}`", price / 3600.0
        raise Refused(
            f"{what} would take about {hours:.2g} h of CPU time, over {most / 3600.0:.2g} h",
            "take a shorter `duration`, lower `contact.damping`"
            + (other if adaptive else ", or give a `step` of your own"),
        )
    beyond = RESAMPLE_REACH / case.sampling + (DECIMATION_REACH + 2) / (rate * fine)
    passes = ceil((case.settle + case.duration + beyond) * rate)
    return Grid(rate, 1.0 / (rate * fine * decimation), fine, decimation, passes)


def estimate(case: Case) -> Estimate:
    """What the case will take. Raises ``Refused`` like ``wanted_step``."""
    case = resolved(case)
    cut = grid(case)
    computed = 1 if repeats(case) else cut.passes
    steps = computed * cut.steps_per_pass
    seconds = computed / cut.rate * per_second(case, cut.step)
    proof = share(case) * seconds if case.proven else 0.0
    columns = sum(len(CHANNELS[name].components) for name in case.record)
    return Estimate(
        cpu_seconds=OVERHEAD + seconds + proof,
        bytes=4 * columns * samples(case),
        steps=steps,
        proof_seconds=proof,
    )
