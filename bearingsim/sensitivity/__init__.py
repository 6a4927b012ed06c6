"""What the results of a design say: which parameters decide a feature, and how surely.

``blocks`` reads a feature from a results folder, in the rows of its design. ``sobol`` and ``morris`` make indices
and effects of them, ``intervals`` says how well they are known, ``verdict`` puts them into words.
"""

from bearingsim.sensitivity.blocks import Blocks, SensitivityError, design_of, of_results
from bearingsim.sensitivity.intervals import LEVEL, Estimate
from bearingsim.sensitivity.morris import Effects, of_trajectories
from bearingsim.sensitivity.sobol import Indices, of_blocks
from bearingsim.sensitivity.verdict import of_effects, of_indices

__all__ = [
    "LEVEL",
    "Blocks",
    "Effects",
    "Estimate",
    "Indices",
    "SensitivityError",
    "analysed",
    "design_of",
    "of_effects",
    "of_indices",
    "of_results",
]


def analysed(blocks: Blocks) -> Indices | Effects:
    """Sobol' indices of a design `saltelli`, Morris' effects of a design `morris`, with intervals."""
    if blocks.kind == "saltelli":
        return of_blocks(blocks.values)
    return of_trajectories(blocks.points, blocks.values)
