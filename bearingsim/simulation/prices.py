"""What the steps of a case cost in CPU time: laws with measured numbers, which stand in ``prices.csv``.

The numbers hold for one core of a 2.6 GHz server, and are the same on every machine: the choice of a method rests
on them. ``benchmarks/step_cost.py`` measures them.
"""

import csv
from functools import cache
from math import inf
from pathlib import Path

from bearingsim import assemble
from bearingsim.assemble.contacts import powers
from bearingsim.catalogue import EXPLICIT, METHODS
from bearingsim.config import Case
from bearingsim.config.rules.slicing import slice_count
from bearingsim.simulation.limits import LONGEST, Limits, step_limits

TABLE = Path(__file__).with_name("prices.csv")
USUAL = ""
"""The name in the table of what has no row of its own, such as another package's model."""
OWN_PER_PERIOD = 25.0  # steps of an adaptive method in a period of contacts that ring
REACH = 3.0  # step of an explicit adaptive method over the explicit one's limit
RINGS = 0.3  # damping ratio under which contacts ring
HEAVY = 0.37  # power of the damping ratio, over 1, by which it shortens own steps (Rodas, m3 = 0; others roughly)


@cache
def prices() -> dict[tuple[str, str], float]:
    """The table: (what, name of model or method) to its number."""
    with TABLE.open(newline="") as file:
        return {(row["what"], row["name"]): float(row["value"]) for row in csv.DictReader(file)}


def price(what: str, name: str = USUAL) -> float:
    """A number of the table, or the usual one."""
    return prices().get((what, name), prices()[what, USUAL])


def evaluation(case: Case) -> float:
    """CPU time (s) of one evaluation of the case's model."""
    return (price("evaluation", case.model) + price("power") * powers(case)) * (slice_count(case) or 1)


def per_step(method: str, evaluations: int) -> float:
    """CPU time of a method's step in evaluations of the model, all that goes with it included (docs/methods.md).

    ``evaluations``: of the model in a step, which is what a method without a row of its own is priced by.
    """
    usual = price("adaptive step") if METHODS[method].adaptive else 1.0
    return prices().get(("step", method), usual * evaluations)


def per_second(case: Case, step: float) -> float:
    """CPU time (s) of the steps of a simulated second."""
    kind = assemble.method_kind(case)
    if case.method is None:
        return evaluation(case) / step * kind.evaluations
    one = per_step(case.method, kind.evaluations)
    if not METHODS[case.method].adaptive:
        return evaluation(case) / step * one
    own = own_step(case, step_limits(case.model_copy(update={"method": EXPLICIT})))
    return evaluation(case) * (price("record") / step + one / own)


def own_step(case: Case, found: Limits) -> float:
    """About how long (s) the steps of an adaptive method are: what rings, is crossed, or opens sets them."""
    usual, name = price("own steps"), str(case.method)
    steps = price("own steps", name)
    smooth = min(found.crossing, LONGEST * usual) / steps
    rings = 1.0 / found.contact_frequency / OWN_PER_PERIOD if found.damping_ratio < RINGS else inf
    limit = inf if METHODS[name].implicit else REACH * found.at_impact
    opens = LONGEST * usual / steps / max(1.0, found.damping_ratio) ** HEAVY
    return min(smooth, rings, limit, opens)
