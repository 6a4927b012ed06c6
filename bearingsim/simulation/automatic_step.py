"""The step of ``step: auto``: measured to keep the defect's line within 1 % (docs/steps.md)."""

from math import inf

from bearingsim import assemble
from bearingsim.catalogue import MODELS
from bearingsim.config import Case
from bearingsim.simulation.limits import LONGEST, Limits

RECORDED_PER_CROSSING, RECORDED_PER_PERIOD = 25, 4
"""Recorded instants of an adaptive method over a pit, and in a period of contacts that ring."""


def automatic_step(case: Case, limits: Limits) -> float:
    """Return the step (s) measured to keep the defect's line within about 1 % (docs/steps.md).

    For an adaptive method, which controls its own error, the time between recorded instants.
    """
    model, method = assemble.kind(case), assemble.method_kind(case)
    if assemble.adaptive(case):
        rings = 1.0 / limits.contact_frequency / RECORDED_PER_PERIOD if limits.damping_ratio < 1.0 else inf
        return min(limits.crossing / RECORDED_PER_CROSSING, rings, LONGEST)
    seen = min(limits.crossing / model.per_crossing, LONGEST)
    if MODELS[case.model].memoryless:
        return seen
    return min(seen, method.fraction * limits.at_impact, 1.0 / limits.contact_frequency / method.per_period)
