"""Chaos of a motion: growth of a perturbation from pass to pass, and scatter of the RMS between diverged runs."""

from collections.abc import Sequence
from math import sqrt

import numpy as np

from bearingsim.simulation.comparison import pass_rms

MIN_DIVERGENCE = 0.01  # relative to the RMS; if velocities differ by less in every ball pass, chaos is not tested
PERTURBATION = 1e-10  # relative to the ring's initial displacement; decays if the motion is periodic
CONFIDENCE = 2.5  # standard deviations, for many passes
CONFIDENCE_PROBABILITY = 0.9938  # probability of a value below CONFIDENCE standard deviations
MIN_GROWTH = 3.0  # growth of a perturbation over the pilot
DECAY = 0.01  # of ``PERTURBATION``, left at the end of a pilot: below, neighbouring motions converge
MIN_CHANGE = 1e-4  # by a perturbation in any pass, relative to the RMS
MIN_CHANGE_RATIO = 0.3  # change by the perturbation, relative to that by the shorter step (or tighter tolerance)
MIN_BLOCKS = 16  # smallest number of blocks of passes for the scatter of the RMS


def is_chaotic_motion(perturbation_changes: np.ndarray, step_changes: np.ndarray, adaptive: bool) -> bool:
    """Check if a motion is chaotic, from the changes of each ball pass by a perturbation and by a shorter step.

    perturbation_changes, step_changes: (passes,) changes by the perturbation and by the shorter step, relative to
    the RMS. In a periodic motion the perturbation decays. With an adaptive method it also changes the steps, by an
    amount that shrinks with the tolerance. If the perturbed finer run diverges from the finer one about as much as
    the coarse run does, the motion itself is chaotic.
    """
    if adaptive:
        return bool(
            perturbation_changes.max() > MIN_CHANGE
            and perturbation_changes.max() > MIN_CHANGE_RATIO * step_changes.max()
        )
    return bool(
        perturbation_changes.max() > MIN_CHANGE
        or (
            perturbation_changes[-1] > 10.0 * PERTURBATION
            and perturbation_changes[-1] > MIN_GROWTH * perturbation_changes[0]
        )
    )


def scatter(series: Sequence[np.ndarray], passes: int) -> tuple[float, float]:
    """Return the scatter of a ball pass's RMS due to chaos, from three diverged recordings of the same passes.

    Returns the standard deviation of the relative change of the RMS and the factor to its confidence limit. The
    factor is Student's t with two degrees of freedom per effective pass, because a few strong passes may outweigh
    the rest. Of single passes and blocks of passes the largest standard deviation counts, because successive
    passes are correlated.
    """
    sizes = [2**k for k in range(passes.bit_length()) if k == 0 or passes >= MIN_BLOCKS * 2**k]
    return max(_scatter(series, passes // size, size) for size in sizes)


def _scatter(series: Sequence[np.ndarray], blocks: int, size: int) -> tuple[float, float]:
    """Return ``scatter`` from ``blocks`` of ``size`` passes each."""
    from scipy.special import stdtrit

    powers = np.array([pass_rms(recording, blocks) ** 2 for recording in series])
    powers /= np.mean(powers) or 1.0
    differences = np.sum((powers - np.roll(powers, 1, axis=0)) ** 2, axis=0)
    effective_passes = np.sum(differences) ** 2 / (np.sum(differences**2) or 1.0)
    noise = 0.5 * sqrt(size * np.mean(differences) / len(series))
    return noise, float(stdtrit(2.0 * max(1.0, effective_passes), CONFIDENCE_PROBABILITY))
