"""What the steps of a case cost in CPU time: laws with measured numbers, which stand in ``prices.csv``.

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
"""The name in the table of what has no row of its own, such as another package's model."""
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
    """CPU time (s) of one evaluation of the case's model."""
    of_rollers = (price("evaluation", case.model) + price("power") * powers(case)) * (slice_count(case) or 1)
    return of_rollers + bending(case)


def bending(case: Case) -> float:
    """CPU time (s) that a ring which bends, and the springs around it, add to an evaluation."""
    if case.rig.ring is None:
        return 0.0
    springs = len(places_of_springs(of_ring(case))[0]) if has_carrier(case.rig) else 0
    return (price("harmonic", case.model) + price("spring") * springs) * float(case.rig.ring.harmonics)


def per_step(method: str, model: str, evaluations: int) -> float:
    """CPU time of a method's step in evaluations of the model, all that goes with it included (docs/cost.md).

    ``evaluations``: of the model in a step, which is what a method without a row of its own is priced by.
    """
    usual = price("adaptive step") if METHODS[method].adaptive else 1.0
    of_any = prices().get(("step", method), usual * evaluations)
    return prices().get(("step", f"{method} {model}"), of_any)


def per_second(case: Case, step: float) -> float:
    """CPU time (s) of the steps of a simulated second."""
    kind = assemble.method_kind(case)
    if case.method is None:
        return evaluation(case) / step * kind.evaluations
    one = per_step(case.method, case.model, kind.evaluations)
    if not METHODS[case.method].adaptive:
        return evaluation(case) / step * one
    own = adaptive_step(case, step_limits(case.model_copy(update={"method": EXPLICIT})))
    return evaluation(case) * (price("record") / step + one / own)


def adaptive_step(case: Case, found: Limits) -> float:
    """About how long (s) the steps of an adaptive method are.

    An explicit one's are bounded by its stability on contacts at rest; an implicit one's by what is crossed,
    rings, or opens.
    """
    usual, name = price("own steps"), str(case.method)
    steps = price("own steps", name)
    smooth = min(found.crossing, LONGEST * usual) / steps
    if not METHODS[name].implicit:
        return min(smooth, price("stable step", name) / found.fastest_rate)
    rings = 1.0 / found.contact_frequency / OWN_PER_PERIOD if found.damping_ratio < RINGING_RATIO else inf
    return min(smooth, rings, LONGEST * usual / steps / max(1.0, found.damping_ratio) ** DAMPING_POWER)
