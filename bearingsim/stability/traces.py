"""Short runs with the methods of this package, and the failures in which they may end."""

import time
from math import ceil
from typing import Any, NamedTuple

import numpy as np

from bearingsim.assemble import kind_of_method
from bearingsim.catalogue import METHODS
from bearingsim.core import layout as lay
from bearingsim.core.advance import Monitor, NoSamples, advance_and_sample, prepare_first_step
from bearingsim.core.outcomes import NEWTON_FAILED, NOT_FINITE, STEP_TOO_SMALL, SUCCESS, TOO_MANY_STEPS
from bearingsim.stability.scene import DURATION, SAMPLE_INTERVAL

MAX_DISPLACEMENT, MAX_SPEED = 1e-3, 50.0  # m, m/s, limits of the ring beyond which a run has blown up
MAX_EVALUATIONS = 1e4  # evaluations by an adaptive method between two checks of the CPU time
MAX_CHUNK_STEPS = 20_000  # steps of an explicit fixed-step method between checks of the CPU time

BLOW_UP, STALL, TOO_SLOW = "blow-up", "stalled", "too slow"
FAILURES = {
    NOT_FINITE: (BLOW_UP, "not finite"),
    STEP_TOO_SMALL: (STALL, "the step became too short"),
    TOO_MANY_STEPS: (STALL, "too many steps for one sample"),
    NEWTON_FAILED: (STALL, "Newton's method found no solution"),
}


class Trace(NamedTuple):
    """Result of a run.

    stride: interval between columns, in units of ``SAMPLE_INTERVAL``; velocity: of the ring (2, n), m/s; contacts:
    whether each roller is loaded at the outer race (Z, n); failure: class in the stability map, empty on success;
    reason: of a failure; steps, rejected: numbers of accepted and rejected steps; evaluations: of the model;
    iterations: of Newton's method; cpu: s.
    """

    stride: int
    velocity: np.ndarray
    contacts: np.ndarray
    failure: str = ""
    reason: str = ""
    steps: int = 0
    rejected: int = 0
    evaluations: int = 0
    iterations: int = 0
    cpu: float = 0.0


def make_skipped_trace(failure: str, reason: str) -> Trace:
    """Return an empty trace for a run that was skipped, with the class and the reason."""
    return Trace(1, np.empty((2, 0)), np.empty((0, 0), dtype=bool), failure, reason)


def run_method(name: str, method: Any, model: Any, y: np.ndarray, cpu_limit: float) -> Trace:
    """Integrate a scene from a copy of the buffer ``y`` at t = 0.

    name: of the method; method: its parameters; cpu_limit: CPU time (s) after which the run is stopped.
    """
    y, Z = y.copy(), model.bearing.Z
    cells = np.array(
        [
            lay.VELOCITY + lay.X,
            lay.VELOCITY + lay.Y,
            lay.POSITION + lay.X,
            lay.POSITION + lay.Y,
            *range(lay.Q_O, lay.Q_O + Z),
        ]
    )
    steps = round(DURATION / method.h)
    steps_per_sample = max(1, round(SAMPLE_INTERVAL / method.h))
    stride = max(1, round(method.h / SAMPLE_INTERVAL))
    chunk_steps = steps_per_sample * (
        20 if METHODS[name].adaptive or METHODS[name].implicit else ceil(MAX_CHUNK_STEPS / steps_per_sample)
    )
    # no early stop, so that diverging runs are recorded
    monitor = Monitor(
        stride=16, overrun_limit=np.inf, max_evaluations=MAX_EVALUATIONS if METHODS[name].adaptive else np.inf
    )
    chunks: list[np.ndarray] = []
    failure, reason, step_count = "", "", 0
    prepare_first_step(method, model, 0.0, y)
    # compile or load before timing, by a discarded step (zero steps would have another array layout)
    advance_and_sample(method, model, monitor, 0, y.copy(), cells, _allocate(cells, 1), NoSamples())
    start = time.thread_time()
    while step_count < steps and not failure:
        out = _allocate(cells, min(chunk_steps, steps - step_count))
        advanced, outcome, _ = advance_and_sample(method, model, monitor, step_count, y, cells, out, NoSamples())
        step_count += advanced
        failure, reason = FAILURES[outcome] if outcome != SUCCESS else _check_limits(out[:, :advanced])
        if not failure and step_count < steps and time.thread_time() - start > cpu_limit:
            failure, reason = TOO_SLOW, f"{step_count / steps:.0%} done after {cpu_limit:g} s"
        chunks.append(out[:, steps_per_sample - 1 : advanced : steps_per_sample])
    cpu = time.thread_time() - start
    samples = np.concatenate(chunks, axis=1)
    counts = (
        y[lay.STEPS_TAKEN],
        y[lay.STEPS_REJECTED],
        y[lay.EVALUATIONS] or step_count * kind_of_method(name).evaluations,
        y[lay.NEWTON_ITERATIONS],
    )
    accepted, rejected, evaluations, iterations = (int(count) for count in counts)
    return Trace(
        stride,
        samples[:2],
        samples[4:] > 0.0,
        failure,
        reason,
        accepted or step_count,
        rejected,
        evaluations,
        iterations,
        cpu,
    )


def _allocate(cells: np.ndarray, steps: int) -> np.ndarray:
    """Allocate an array (cells, steps) with the memory layout of a simulation's, to use the same compiled code."""
    return np.empty((len(cells), steps + 1))[:, 1:]


def _check_limits(out: np.ndarray) -> tuple[str, str]:
    """Check if the ring exceeds its limits; return failure and reason, empty if it does not.

    out: (C, n) recorded cells, those of the ring first: velocity, then position.
    """
    if not np.isfinite(out[:4]).all():
        return BLOW_UP, "not finite"
    if np.abs(out[:2]).max() > MAX_SPEED or np.abs(out[2:4]).max() > MAX_DISPLACEMENT:
        return BLOW_UP, f"the ring moves {np.abs(out[2:4]).max():.2g} m at {np.abs(out[:2]).max():.2g} m/s"
    return "", ""
