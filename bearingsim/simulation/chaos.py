"""Chaos of a motion: growth of a perturbation from pass to pass, and scatter of the RMS between diverging runs."""

from collections.abc import Sequence
from math import sqrt

import numpy as np

from bearingsim.simulation.comparison import pass_rms

MIN_DIVERGENCE = 0.01  # relative to the RMS; chaos is tested only if velocities differ by more in a ball pass
PERTURBATION = 1e-10  # of the ring's initial displacement, relative to it
CONFIDENCE = 2.5  # confidence limit of a change of the RMS, in standard deviations
CONFIDENCE_PROBABILITY = 0.9938  # one-sided probability of CONFIDENCE in the normal distribution
MIN_GROWTH = 3.0  # smallest growth of a perturbation over a pilot that is chaotic
MAX_DECAYED_SHARE = 0.01  # of ``PERTURBATION``, left at the end of a pilot if neighbouring motions converge
MIN_CHANGE = 1e-4  # smallest change by the perturbation that is chaotic, in any pass, relative to the RMS
MIN_CHANGE_RATIO = 0.3  # smallest ratio of the change by the perturbation to that by the shorter step
MIN_BLOCKS = 16  # smallest number of blocks of passes for the scatter of the RMS


def is_chaotic_motion(
    perturbation_changes: np.ndarray, step_changes: np.ndarray, adaptive: bool, initial_change: float = 0.0
) -> bool:
    """Check if a motion is chaotic, from its changes by a perturbation and by a shorter step.

    perturbation_changes, step_changes: (passes,) RMS of the change in each ball pass, relative to the RMS of the
    motion; initial_change: bound of that by a perturbation that does not grow, relative to the same RMS, which
    may be that of a small motion. In a periodic motion the perturbation decays. With an adaptive method it also
    changes the steps, by an amount that shrinks with the tolerance. If the perturbed finer run diverges from the
    finer one about as much as the coarse run does, the motion itself is chaotic.
    """
    min_change = max(MIN_CHANGE, MIN_GROWTH * initial_change)
    if adaptive:
        return bool(
            perturbation_changes.max() > min_change
            and perturbation_changes.max() > MIN_CHANGE_RATIO * step_changes.max()
        )
    return bool(
        perturbation_changes.max() > min_change
        or (
            perturbation_changes[-1] > 10.0 * PERTURBATION
            and perturbation_changes[-1] > MIN_GROWTH * perturbation_changes[0]
        )
    )


def estimate_rms_scatter(series: Sequence[np.ndarray], passes: int) -> tuple[float, float]:
    """Estimate the scatter of the RMS of a ball pass due to chaos, from three diverging recordings.

    Returns the standard deviation of the relative change of the RMS, and the factor from it to the confidence
    limit. The factor is Student's t with two degrees of freedom per effective pass, since a few strong passes may
    dominate. The standard deviation is the largest of those from single passes and from blocks of passes, because
    successive passes are correlated. series: three arrays (n,), fine samples of the same passes.
    """
    block_sizes = [2**k for k in range(passes.bit_length()) if k == 0 or passes >= MIN_BLOCKS * 2**k]
    return max(_block_scatter(series, passes // size, size) for size in block_sizes)


def _block_scatter(series: Sequence[np.ndarray], blocks: int, size: int) -> tuple[float, float]:
    """Estimate the scatter as ``estimate_rms_scatter``, from ``blocks`` of ``size`` passes each."""
    from scipy.special import stdtrit

    powers = np.array([pass_rms(recording, blocks) ** 2 for recording in series])
    powers /= np.mean(powers) or 1.0
    differences = np.sum((powers - np.roll(powers, 1, axis=0)) ** 2, axis=0)
    effective_passes = np.sum(differences) ** 2 / (np.sum(differences**2) or 1.0)
    deviation = 0.5 * sqrt(size * np.mean(differences) / len(series))
    return deviation, float(stdtrit(2.0 * max(1.0, effective_passes), CONFIDENCE_PROBABILITY))
