"""The step that ``step: auto`` takes: what was measured to hold 1 % of the fault's line (docs/steps.md)."""

from math import inf

from bearingsim import assemble
from bearingsim.catalogue import MODELS
from bearingsim.config import Case
from bearingsim.simulation.limits import LONGEST, Limits

RECORDED_PER_CROSSING, RECORDED_PER_PERIOD = 25, 4
"""Recorded instants of an adaptive method over a pit, and in a period of contacts that ring."""


def automatic_step(case: Case, found: Limits) -> float:
    """Return the step (s) that was measured to keep the line of the fault within about 1 % (see docs/steps.md).

    Of an adaptive method, which sees to that itself, the time between recorded instants.
    """
    model, method = assemble.kind(case), assemble.method_kind(case)
    if assemble.adaptive(case):
        rings = 1.0 / found.contact_frequency / RECORDED_PER_PERIOD if found.damping_ratio < 1.0 else inf
        return min(found.crossing / RECORDED_PER_CROSSING, rings, LONGEST)
    seen = min(found.crossing / model.per_crossing, LONGEST)
    if MODELS[case.model].memoryless:
        return seen
    return min(seen, method.fraction * found.at_impact, 1.0 / found.contact_frequency / method.per_period)
