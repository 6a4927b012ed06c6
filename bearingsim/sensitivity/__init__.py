"""Sensitivity analysis of a design: influential parameters of a feature, with confidence intervals.

``blocks`` reads a feature from a results folder in the order of its design, ``estimates`` computes indices and
effects with their intervals, and ``verdict`` describes them in sentences.
"""

import numpy as np

from bearingsim.sensitivity.blocks import ROUNDING, Blocks, SensitivityError, collect_blocks, design_of
from bearingsim.sensitivity.estimates import LEVEL, Effects, Estimate, Indices, estimate_effects, estimate_indices
from bearingsim.sensitivity.verdict import describe_effects, describe_indices

__all__ = [
    "LEVEL",
    "ROUNDING",
    "Blocks",
    "Effects",
    "Estimate",
    "Indices",
    "SensitivityError",
    "analyse",
    "collect_blocks",
    "describe_effects",
    "describe_indices",
    "design_of",
]


def analyse(blocks: Blocks) -> Indices | Effects:
    """Compute Sobol' indices (design `saltelli`) or Morris effects (design `morris`), with intervals.

    Raises SensitivityError if too few blocks vary for the bootstrap.
    """
    result: Indices | Effects
    if blocks.kind == "saltelli":
        result = estimate_indices(blocks.values)
    else:
        result = estimate_effects(blocks.points, blocks.values)
    if not all(np.isfinite(values).all() for estimate in result for values in estimate):
        raise SensitivityError(f"`{blocks.feature}` varies in too few blocks for an interval: raise `n`")
    return result
