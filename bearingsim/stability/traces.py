"""A short run by one of the own methods, whatever becomes of it."""

import time
from math import ceil
from typing import Any, NamedTuple

import numpy as np

from bearingsim.assemble import kind_of_method
from bearingsim.catalogue import METHODS
from bearingsim.core.advance import Watch, advance, ready
from bearingsim.core.layout import EVALUATED, ITERATED, POSITION, Q_O, REFUSED, TAKEN, VELOCITY, X, Y
from bearingsim.core.outcomes import FINE as WELL
from bearingsim.core.outcomes import NEWTON_STALLED, NOT_FINITE, STALLED, STEP_FLOOR
from bearingsim.stability.scene import FINE, SPAN

FARTHEST, FASTEST = 1e-3, 50.0  # m, m/s: a ring beyond has been blown away
MOST_WORK = 1e4  # evaluations by an adaptive method between two looks at the clock
MOST_AT_ONCE = 20_000  # steps between looks at the clock

BLOW_UP, STALL, TOO_SLOW = "blow-up", "stalled", "too slow"
WHY = {
    NOT_FINITE: (BLOW_UP, "not finite"),
    STEP_FLOOR: (STALL, "its step became too short"),
    STALLED: (STALL, "too many steps for one sample"),
    NEWTON_STALLED: (STALL, "Newton's method found no solution"),
}


class Trace(NamedTuple):
    """What a run has come to.

    every: ``FINE`` samples from one column to the next; velocity: of the ring (2, n), m/s; touching: whether each
    roller carries load at the outer race (Z, n); failure: a class of ``judge``, empty if it ended well; reason in
    words; steps taken and refused, evaluations of the model and Newton iterations; cpu: s.
    """

    every: int
    velocity: np.ndarray
    touching: np.ndarray
    failure: str = ""
    reason: str = ""
    steps: int = 0
    refused: int = 0
    evaluations: int = 0
    iterations: int = 0
    cpu: float = 0.0


def nothing(failure: str, reason: str) -> Trace:
    """The trace of a run that was not made."""
    return Trace(1, np.empty((2, 0)), np.empty((0, 0), dtype=bool), failure, reason)


def trace(name: str, method: Any, model: Any, y: np.ndarray, limit: float) -> Trace:
    """Step a copy of the buffer ``y`` (at rest, t = 0) through the scene, for ``limit`` CPU seconds at most."""
    y, Z = y.copy(), model.bearing.Z
    places = np.array([VELOCITY + X, VELOCITY + Y, POSITION + X, POSITION + Y, *range(Q_O, Q_O + Z)])
    steps, per, every = round(SPAN / method.h), max(1, round(FINE / method.h)), max(1, round(method.h / FINE))
    at_once = per * (20 if METHODS[name].adaptive or METHODS[name].implicit else ceil(MOST_AT_ONCE / per))
    # what outruns its limit is to be seen
    watch = Watch(stride=16, patience=np.inf, most_work=MOST_WORK if METHODS[name].adaptive else np.inf)
    kept: list[np.ndarray] = []
    failure, reason, taken = "", "", 0
    ready(method, model, 0.0, y)
    advance(method, model, watch, 0, y, places, np.empty((len(places), 0)))  # compiled, or loaded
    began = time.thread_time()
    while taken < steps and not failure:
        out = np.empty((len(places), min(at_once, steps - taken)))
        got, outcome, _ = advance(method, model, watch, taken, y, places, out)
        taken += got
        failure, reason = WHY[outcome] if outcome != WELL else _beyond(out[:, :got])
        if not failure and taken < steps and time.thread_time() - began > limit:
            failure, reason = TOO_SLOW, f"{taken / steps:.0%} done after {limit:g} s"
        kept.append(out[:, per - 1 : got : per])
    cpu = time.thread_time() - began
    rows = np.concatenate(kept, axis=1)
    counts = y[TAKEN], y[REFUSED], y[EVALUATED] or taken * kind_of_method(name).evaluations, y[ITERATED]
    own, refused, evaluations, iterations = (int(count) for count in counts)
    return Trace(
        every, rows[:2], rows[4:] > 0.0, failure, reason, own or taken, refused, evaluations, iterations, cpu
    )


def _beyond(out: np.ndarray) -> tuple[str, str]:
    """Whether the ring has left the machine."""
    if not np.isfinite(out[:4]).all():
        return BLOW_UP, "not finite"
    if np.abs(out[:2]).max() > FASTEST or np.abs(out[2:4]).max() > FARTHEST:
        return BLOW_UP, f"the ring moves {np.abs(out[2:4]).max():.2g} m at {np.abs(out[:2]).max():.2g} m/s"
    return "", ""
