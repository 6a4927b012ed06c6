"""Classification of a cell of the stability map by its ring's velocity, against a reference of two solutions."""

from itertools import combinations
from typing import NamedTuple

import numpy as np

from bearingsim.stability.scene import SAMPLE_INTERVAL
from bearingsim.stability.traces import BLOW_UP, STALL, TOO_SLOW, Trace

OK, INACCURATE, CHATTER, SKIPPED = "ok", "inaccurate", "chatter", "skipped"
REFUSED, CHAOS, UNJUDGED = "refused", "within chaos", "no reference"
CLASSES = (OK, INACCURATE, CHATTER, BLOW_UP, SKIPPED, STALL, REFUSED, TOO_SLOW, CHAOS, UNJUDGED)

ACCURACY = 0.01  # largest relative error of the class `ok`, or the reference's floor if that is larger
CHAOS_FLOOR = 0.05  # relative; runs within a larger floor are classified as within chaos
# relative L2 difference above which two solutions count as different paths of a chaotic motion
SAME_PATH = 1e-3
SEEN_PART = 0.5  # fraction of the reference's response to a crossing, below which the defect was skipped
ANSWER_TIME = 60e-6  # s, duration of the ring's response after a crossing
MORE_OFTEN, OFTEN = 2.0, 10  # contacts chatter beyond this times the reference's openings plus this


class Reference(NamedTuple):
    """Reference of a scene: ring velocity (2, n) in m/s and contacts (Z, n) at each ``SAMPLE_INTERVAL``, and names
    of its solutions.

    floor: relative difference of the solutions, in L2 or, if chaotic, in RMS; smaller errors are not resolved.
    """

    velocity: np.ndarray
    touching: np.ndarray
    names: str
    chaotic: bool
    floor: float


class Verdict(NamedTuple):
    """Class of a run, its relative error (L2, or RMS if chaotic), crossings seen, and openings of contacts of the
    run and of the reference.
    """

    outcome: str
    error: float
    seen: int
    openings: int
    openings_of_reference: int


def l2(a: np.ndarray, b: np.ndarray) -> float:
    """Compute the relative difference of two series, sample by sample."""
    return float(np.linalg.norm(a - b) / np.linalg.norm(b))


def rms(a: np.ndarray, b: np.ndarray) -> float:
    """Compute the relative difference of the two series' RMS."""
    return abs(float(np.linalg.norm(a) / np.linalg.norm(b)) - 1.0)


def agreeing_solutions(solutions: dict[str, Trace]) -> Reference | None:
    """Build the reference of a scene from the two solutions that agree best; None for fewer than two.

    If all solutions diverge in spite of tight tolerances, the motion is chaotic: RMS values are compared, and the
    floor is the largest difference between any two.
    """
    whole = {name: trace for name, trace in solutions.items() if not trace.failure}
    pairs = [(l2(whole[a].velocity, whole[b].velocity), a, b) for a, b in combinations(whole, 2)]
    if not pairs:
        return None
    least, best, second = min(pairs)
    chaotic = least > SAME_PATH
    worst = max(rms(whole[a].velocity, whole[b].velocity) for _, a, b in pairs)
    names = " + ".join(whole) if chaotic else f"{best} + {second}"
    return Reference(whole[best].velocity, whole[best].touching, names, chaotic, worst if chaotic else least)


def openings(touching: np.ndarray) -> int:
    """Count the openings of contacts."""
    return int((touching[:, :-1] & ~touching[:, 1:]).sum())


def crossings_seen(
    trace: Trace, reference: Reference, healthy: Reference, windows: list[tuple[float, float]]
) -> int:
    """Count the crossings with a ring response of at least ``SEEN_PART`` of the reference's.

    The count uses the ring, not the positions of rollers, because the interpolated result of a solver that steps
    over a defect still has a roller in it.
    """
    count = 0
    for start, end in windows:
        begin = round(start / SAMPLE_INTERVAL) // trace.every
        last = round((end + ANSWER_TIME) / SAMPLE_INTERVAL) // trace.every
        samples = trace.every * np.arange(begin + 1, min(last, trace.velocity.shape[1])) - 1
        sound = healthy.velocity[:, samples]
        answer = trace.velocity[:, (samples + 1) // trace.every - 1] - sound
        count += bool(
            np.linalg.norm(answer) >= SEEN_PART * np.linalg.norm(reference.velocity[:, samples] - sound) > 0.0
        )
    return count


def judge(
    trace: Trace,
    reference: Reference | None,
    healthy: Reference | None,
    windows: list[tuple[float, float]],
    strides: bool,
) -> Verdict:
    """Classify a run and return the supporting numbers. The class of a failed run is its failure.

    strides: whether steps may be longer than half a crossing; a crossing without response is then skipped.
    """
    missing = Verdict(trace.failure or UNJUDGED, np.nan, 0, openings(trace.touching), 0)
    if reference is None or trace.failure:
        return missing
    every = trace.every
    exact, touching = reference.velocity[:, every - 1 :: every], reference.touching[:, every - 1 :: every]
    error = (rms if reference.chaotic else l2)(trace.velocity, exact)
    opened, of_reference = openings(trace.touching), openings(touching)
    seen = crossings_seen(trace, reference, healthy, windows) if healthy is not None else len(windows)
    if error <= max(ACCURACY, reference.floor):
        outcome = OK if reference.floor <= CHAOS_FLOOR else CHAOS
    elif strides and seen < len(windows):
        outcome = SKIPPED
    elif opened > MORE_OFTEN * of_reference + OFTEN:
        outcome = CHATTER
    else:
        outcome = INACCURATE
    return Verdict(outcome, error, seen, opened, of_reference)
