"""Classification of a cell of the stability map by its ring's velocity, against a reference of two solutions."""

from itertools import combinations
from typing import NamedTuple

import numpy as np

from bearingsim.stability.scene import SAMPLE_INTERVAL
from bearingsim.stability.traces import BLOW_UP, STALL, TOO_SLOW, Trace

OK, INACCURATE, CHATTER, SKIPPED = "ok", "inaccurate", "chatter", "skipped"
REFUSED, CHAOS, NO_REFERENCE = "refused", "within chaos", "no reference"
CLASSES = (OK, INACCURATE, CHATTER, BLOW_UP, SKIPPED, STALL, REFUSED, TOO_SLOW, CHAOS, NO_REFERENCE)

ACCURACY = 0.01  # largest relative error of the class `ok`, or the reference's floor if that is larger
CHAOS_FLOOR = 0.05  # relative; runs within a larger floor are classified as within chaos
# relative L2 difference above which two solutions count as different paths of a chaotic motion
DIVERGENCE = 1e-3
RESPONSE_FRACTION = 0.5  # fraction of the reference's response to a crossing, below which the defect was skipped
RESPONSE_TIME = 60e-6  # s, duration of the ring's response after a crossing
OPENINGS_FACTOR, OPENINGS_OFFSET = 2.0, 10  # contacts chatter beyond this times the reference's openings plus this


class Reference(NamedTuple):
    """Reference of a scene: ring velocity (2, n) in m/s and contacts (Z, n) at each ``SAMPLE_INTERVAL``, and names
    of its solutions.

    floor: relative difference of the solutions, in L2 or, if chaotic, in RMS; smaller errors are not resolved.
    """

    velocity: np.ndarray
    contacts: np.ndarray
    names: str
    chaotic: bool
    floor: float


class Verdict(NamedTuple):
    """Class of a run, its relative error (L2, or RMS if chaotic), detected crossings, and openings of contacts
    of the run and of the reference.
    """

    outcome: str
    error: float
    detected: int
    openings: int
    reference_openings: int


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
    complete = {name: trace for name, trace in solutions.items() if not trace.failure}
    pairs = [(l2(complete[a].velocity, complete[b].velocity), a, b) for a, b in combinations(complete, 2)]
    if not pairs:
        return None
    difference, best, partner = min(pairs)
    chaotic = difference > DIVERGENCE
    worst = max(rms(complete[a].velocity, complete[b].velocity) for _, a, b in pairs)
    names = " + ".join(complete) if chaotic else f"{best} + {partner}"
    return Reference(
        complete[best].velocity, complete[best].contacts, names, chaotic, worst if chaotic else difference
    )


def openings(contacts: np.ndarray) -> int:
    """Count the openings of contacts."""
    return int((contacts[:, :-1] & ~contacts[:, 1:]).sum())


def detected_crossings(
    trace: Trace, reference: Reference, healthy: Reference, windows: list[tuple[float, float]]
) -> int:
    """Count the crossings with a ring response of at least ``RESPONSE_FRACTION`` of the reference's.

    The count uses the ring, not the positions of rollers, because the interpolated result of a solver that steps
    over a defect still has a roller in it.
    """
    count = 0
    for start, end in windows:
        begin = round(start / SAMPLE_INTERVAL) // trace.stride
        last = round((end + RESPONSE_TIME) / SAMPLE_INTERVAL) // trace.stride
        samples = trace.stride * np.arange(begin + 1, min(last, trace.velocity.shape[1])) - 1
        healthy_velocity = healthy.velocity[:, samples]
        response = trace.velocity[:, (samples + 1) // trace.stride - 1] - healthy_velocity
        count += bool(
            np.linalg.norm(response)
            >= RESPONSE_FRACTION * np.linalg.norm(reference.velocity[:, samples] - healthy_velocity)
            > 0.0
        )
    return count


def classify(
    trace: Trace,
    reference: Reference | None,
    healthy: Reference | None,
    windows: list[tuple[float, float]],
    long_steps: bool,
) -> Verdict:
    """Classify a run and return the supporting numbers. The class of a failed run is its failure.

    long_steps: whether steps may be longer than half a crossing; a crossing without response is then skipped.
    """
    no_verdict = Verdict(trace.failure or NO_REFERENCE, np.nan, 0, openings(trace.contacts), 0)
    if reference is None or trace.failure:
        return no_verdict
    stride = trace.stride
    exact, contacts = reference.velocity[:, stride - 1 :: stride], reference.contacts[:, stride - 1 :: stride]
    error = (rms if reference.chaotic else l2)(trace.velocity, exact)
    run_openings, reference_openings = openings(trace.contacts), openings(contacts)
    detected = detected_crossings(trace, reference, healthy, windows) if healthy is not None else len(windows)
    if error <= max(ACCURACY, reference.floor):
        outcome = OK if reference.floor <= CHAOS_FLOOR else CHAOS
    elif long_steps and detected < len(windows):
        outcome = SKIPPED
    elif run_openings > OPENINGS_FACTOR * reference_openings + OPENINGS_OFFSET:
        outcome = CHATTER
    else:
        outcome = INACCURATE
    return Verdict(outcome, error, detected, run_openings, reference_openings)
