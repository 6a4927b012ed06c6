"""Classification of cells of a stability map, by comparison of the ring's velocity with a reference solution."""

from itertools import combinations
from typing import NamedTuple

import numpy as np

from bearingsim.stability.scene import SAMPLE_INTERVAL
from bearingsim.stability.traces import BLOW_UP, STALL, TOO_SLOW, Trace

OK, INACCURATE, CHATTER, SKIPPED = "ok", "inaccurate", "chatter", "skipped"
REFUSED, CHAOS, NO_REFERENCE = "refused", "within chaos", "no reference"
CLASSES = (OK, INACCURATE, CHATTER, BLOW_UP, SKIPPED, STALL, REFUSED, TOO_SLOW, CHAOS, NO_REFERENCE)

ACCURACY = 0.01  # largest relative error of the class `ok`, or the reference's floor if that is larger
CHAOS_FLOOR = 0.05  # relative; runs that agree with a reference of larger floor are classified as within chaos
# relative L2 difference above which two solutions count as different trajectories of a chaotic motion
DIVERGENCE = 1e-3
RESPONSE_FRACTION = 0.5  # of the reference's response to a crossing; with a smaller one the defect was skipped
RESPONSE_TIME = 60e-6  # s, duration of the ring's response after a crossing
OPENINGS_FACTOR, OPENINGS_OFFSET = 2.0, 10  # contacts chatter above factor * (openings of reference) + offset


class Reference(NamedTuple):
    """Reference solution of a scene.

    velocity: (2, n) of the ring, m/s, at each ``SAMPLE_INTERVAL``; contacts: (Z, n) whether each roller is loaded;
    names: of the solutions compared; chaotic: whether they diverge; floor: relative difference of the solutions,
    in L2 or, if chaotic, in RMS; smaller errors are not resolved.
    """

    velocity: np.ndarray
    contacts: np.ndarray
    names: str
    chaotic: bool
    floor: float


class Verdict(NamedTuple):
    """Class of a run, with the supporting numbers.

    outcome: one of ``CLASSES``; error: relative (L2, or RMS if chaotic); detected: number of detected crossings;
    openings, reference_openings: numbers of contact openings in the run and in the reference.
    """

    outcome: str
    error: float
    detected: int
    openings: int
    reference_openings: int


def l2_error(values: np.ndarray, reference: np.ndarray) -> float:
    """Compute the relative L2 norm of the difference of two series."""
    return float(np.linalg.norm(values - reference) / np.linalg.norm(reference))


def rms_error(values: np.ndarray, reference: np.ndarray) -> float:
    """Compute the relative difference of the RMS of two series."""
    return abs(float(np.linalg.norm(values) / np.linalg.norm(reference)) - 1.0)


def make_reference(solutions: dict[str, Trace]) -> Reference | None:
    """Build the reference of a scene from the two solutions that agree best; None for fewer than two solutions.

    Failed solutions are left out. If all pairs diverge in spite of tight tolerances, the motion is chaotic: RMS
    values are compared, and the floor is the largest difference of RMS between any two solutions.
    """
    complete = {name: trace for name, trace in solutions.items() if not trace.failure}
    pairs = [(l2_error(complete[a].velocity, complete[b].velocity), a, b) for a, b in combinations(complete, 2)]
    if not pairs:
        return None
    difference, best, partner = min(pairs)
    chaotic = difference > DIVERGENCE
    largest_rms_error = max(rms_error(complete[a].velocity, complete[b].velocity) for _, a, b in pairs)
    names = " + ".join(complete) if chaotic else f"{best} + {partner}"
    return Reference(
        complete[best].velocity,
        complete[best].contacts,
        names,
        chaotic,
        largest_rms_error if chaotic else difference,
    )


def count_openings(contacts: np.ndarray) -> int:
    """Count the openings of contacts; contacts: (Z, n) whether each roller is loaded."""
    return int((contacts[:, :-1] & ~contacts[:, 1:]).sum())


def count_detected_crossings(
    trace: Trace, reference: Reference, healthy: Reference, crossings: list[tuple[float, float]]
) -> int:
    """Count the crossings with a ring response of at least ``RESPONSE_FRACTION`` of the reference's.

    The response is that of the ring. Roller positions would not do, because the interpolated result of a solver
    that steps over a defect still shows a roller in it. crossings: start and end (s) of each.
    """
    count = 0
    for start, end in crossings:
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
    crossings: list[tuple[float, float]],
    may_skip: bool,
) -> Verdict:
    """Classify a run. The class of a failed run is its failure.

    crossings: start and end (s) of each; may_skip: whether steps may be longer than half a crossing, so that a
    crossing without a response counts as skipped.
    """
    no_verdict = Verdict(trace.failure or NO_REFERENCE, np.nan, 0, count_openings(trace.contacts), 0)
    if reference is None or trace.failure:
        return no_verdict
    stride = trace.stride
    reference_velocity, reference_contacts = (
        reference.velocity[:, stride - 1 :: stride],
        reference.contacts[:, stride - 1 :: stride],
    )
    error = (rms_error if reference.chaotic else l2_error)(trace.velocity, reference_velocity)
    run_openings, reference_openings = count_openings(trace.contacts), count_openings(reference_contacts)
    detected = (
        count_detected_crossings(trace, reference, healthy, crossings) if healthy is not None else len(crossings)
    )
    if error <= max(ACCURACY, reference.floor):
        outcome = OK if reference.floor <= CHAOS_FLOOR else CHAOS
    elif may_skip and detected < len(crossings):
        outcome = SKIPPED
    elif run_openings > OPENINGS_FACTOR * reference_openings + OPENINGS_OFFSET:
        outcome = CHATTER
    else:
        outcome = INACCURATE
    return Verdict(outcome, error, detected, run_openings, reference_openings)
