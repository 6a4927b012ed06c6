"""CPU time of a case's steps: laws with the measured numbers of ``prices.csv``.

The numbers hold for one core of a 2.6 GHz server, and are the same on every machine: the choice of a method rests
on them. ``benchmarks/step_cost.py`` measures them.
"""

import csv
from functools import cache
from math import inf
from pathlib import Path

from bearingsim import assemble
from bearingsim.assemble.bending import has_carrier, of_ring, places_of_springs
from bearingsim.assemble.contacts import powers
from bearingsim.catalogue import EXPLICIT, METHODS
from bearingsim.config import Case
from bearingsim.config.rules.completion import slice_count
from bearingsim.simulation.limits import LONGEST, Limits, step_limits

TABLE = Path(__file__).with_name("prices.csv")
USUAL = ""
"""Name in the table for models and methods without a row, such as another package's model."""
OWN_PER_PERIOD = 10.0  # steps of an adaptive method in a period of contacts that ring
RINGING_RATIO = 0.1  # damping ratio under which contacts ring
# power of the damping ratio, over 1, by which it shortens own steps (Rodas, m3 = 0; others roughly)
DAMPING_POWER = 0.37


@cache
def prices() -> dict[tuple[str, str], float]:
    """Return the table: (what, name of model or method) to its number."""
    with TABLE.open(newline="") as file:
        return {(row["what"], row["name"]): float(row["value"]) for row in csv.DictReader(file)}


def price(what: str, name: str = USUAL) -> float:
    """Return a number of the table, or the usual one."""
    return prices().get((what, name), prices()[what, USUAL])


def evaluation(case: Case) -> float:
    """Return the CPU time (s) of one evaluation of the case's model."""
    of_rollers = (price("evaluation", case.model) + price("power") * powers(case)) * (slice_count(case) or 1)
    return of_rollers + bending(case)


def bending(case: Case) -> float:
    """Return the CPU time (s) of a ring which bends, and of the springs around it, in an evaluation."""
    if case.rig.ring is None:
        return 0.0
    springs = len(places_of_springs(of_ring(case))[0]) if has_carrier(case.rig) else 0
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
