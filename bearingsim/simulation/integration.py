"""Time integration of a case, from its setup to the raw record from which features and series are read.

Every run is monitored (``core/advance.py``); ``MethodFailure`` is raised if the monitor stops it.
"""

from collections.abc import Callable, Collection, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import islice
from math import exp, hypot, inf, nan
from typing import NamedTuple, Protocol

import numpy as np

from bearingsim import assemble, cpu_time
from bearingsim.catalogue import MODELS
from bearingsim.core import layout as lay
from bearingsim.core import outcomes
from bearingsim.core.advance import NoSamples, Samples, advance_and_sample, prepare_first_step, start_at_rest
from bearingsim.core.defects.crossings import count_missed_crossings, relative_passages
from bearingsim.core.methods.interface import prepare
from bearingsim.core.models.interface import update_extremes
from bearingsim.core.sampling import DECIMATION_HALF_LENGTH
from bearingsim.simulation import channels
from bearingsim.simulation.differentiation import MOTION_ROWS, STENCIL_HALF_LENGTH, derives_velocity, differentiate
from bearingsim.simulation.recording import RawRecord, Recording, extend_back, pop_peaks
from bearingsim.simulation.repetition import (
    RECORD_CRITERION,
    PeriodCriterion,
    Repetition,
    Search,
    may_repeat,
    rotate_state,
)
from bearingsim.simulation.run_setup import (
    MethodFailure,
    Setup,
    SimulationError,
    TooCostly,
    nested_types,
    run_failure,
)
from bearingsim.simulation.settling import SteadyExtrapolation, slowest_decay

SECONDS_PER_CALL = 0.1  # s, approximate CPU time between two readings of the clock
FIRST_STEPS, STEPS_PER_CALL = 8, 4000  # first and largest number of steps (or recorded instants) between readings
STEADY_TOLERANCE = 0.01  # change of a steady motion, as a fraction of ``PeriodCriterion.sum_limit``


@dataclass
class Pace:
    """CPU time (s) of the integrator so far, and number of steps until the clock is read again.

    max_cpu: CPU time (s) after which a run with an automatic step ends.
    """

    max_cpu: float
    cpu_s: float = 0.0
    steps: int = FIRST_STEPS

    def add(self, seconds: float, steps: int) -> None:
        """Add the CPU time of some steps, and choose the number of steps until the next reading."""
        self.cpu_s += seconds
        self.steps = int(min(STEPS_PER_CALL, max(1.0, steps * SECONDS_PER_CALL / max(seconds, 1e-9))))


@dataclass
class StepUsage:
    """Number of integrator steps, and their CPU time (s)."""

    steps: int = 0
    cpu_s: float = 0.0


_TOTAL_USAGE = StepUsage()


def step_usage() -> StepUsage:
    """Return the steps of this process so far, and their CPU time, including failed runs and pilots."""
    return replace(_TOTAL_USAGE)


class Inspector(Protocol):
    """Inspections of a run after each of ``passes`` ball passes."""

    @property
    def passes(self) -> Collection[int]:
        """Ball passes of the run, settling included."""

    def ends(self, raw: RawRecord) -> bool:
        """Check if the run may end after the ball passes so far."""


class Inspection(NamedTuple):
    """Inspection of a run after each of ``passes``; may_end: function of the record so far."""

    passes: Collection[int]
    may_end: Callable[[RawRecord], bool]

    def ends(self, raw: RawRecord) -> bool:
        """Check if the run may end after the ball passes so far."""
        return self.may_end(raw)


class Run:
    """Run of a case, computed and recorded by ball passes, until it is periodic or complete.

    It may be interrupted after a pilot and continued later. setup: as given; y: the buffer; pace: CPU time of its
    steps; passes: number computed so far; period: of the motion in ball passes, 0 if it is not periodic so far.
    """

    def __init__(self, setup: Setup, y: np.ndarray, pace: Pace, search: Search | None = None) -> None:
        """Begin a run. y: the buffer at t = 0 (``_make_initial_buffer``); search: for a period, or None."""
        self.setup, self.y, self.pace, self.search = setup, y, pace, search
        self.passes, self.period, self.difference = 0, 0, nan
        self.recording = Recording(setup.case, setup.grid, setup.model.bearing.Z, y)
        self._initial_passages = _defect_passages(setup, 0.0, y)
        self._pass_iterator = _ball_passes(setup, self.recording.samples, y, self.recording.cells, pace)

    @classmethod
    def begin(
        cls,
        setup: Setup,
        perturbation: float = 0.0,
        start: np.ndarray | None = None,
        criterion: PeriodCriterion = RECORD_CRITERION,
        max_passes: int | None = None,
    ) -> "Run":
        """Return a run before its first step, at a steady state if one is extrapolated.

        Arguments as in ``integrate``.
        """
        pace = Pace(setup.max_cpu)
        steady_start = _find_steady_start(setup, pace, start, criterion, max_passes)
        return cls(
            setup, _make_initial_buffer(setup, perturbation, steady_start), pace, _make_search(setup, criterion)
        )

    @property
    def is_periodic(self) -> bool:
        """Periodicity of the motion after a whole number of periods, where the run ends."""
        return self.period > 0 and self.passes % self.period == 0

    def ball_passes(self) -> Iterator[int]:
        """Compute and record the remaining ball passes; yield the number computed so far after each."""
        while not self.is_periodic and (pass_values := next(self._pass_iterator, None)) is not None:
            self.recording.add_pass(self.passes, pass_values, self.y)
            self.passes += 1
            if self.search is not None and self.period == 0:
                peaks = self.recording.peaks[self.passes - 1]
                self.period, self.difference = self.search.add_pass(pass_values, self.y, peaks)
            yield self.passes

    def advance(self, passes: int) -> None:
        """Compute the run up to ball pass ``passes``, unless it is periodic before. Raises like ``integrate``."""
        for _ in islice(self.ball_passes(), max(0, passes - self.passes)):
            pass

    def record(self) -> RawRecord:
        """Return the record so far. Raises ``MethodFailure`` if its end is not finite or steps missed a defect."""
        _check_end(self.setup, self._initial_passages, self.y, self.passes)
        raw = self.inspected_record()
        if self.period > 0 and self.recording.stores_raw_values:
            self.recording.fill_repeated_passes(raw.repetition)
        if MODELS[self.setup.case.model].memoryless:  # the motion does not start from rest
            extend_back(self.setup.case, raw)
        return raw

    def inspected_record(self) -> RawRecord:
        """Return the record so far, without a check of its end."""
        contraction = inf if self.search is None else self.search.contraction
        repetition = Repetition(self.passes, self.period, self.difference, contraction)
        return self.recording.raw_record(repetition, self.y)


def integrate(
    setup: Setup,
    perturbation: float = 0.0,
    start: np.ndarray | None = None,
    criterion: PeriodCriterion = RECORD_CRITERION,
    max_search_passes: int = 0,
    max_passes: int | None = None,
    inspector: Inspector | None = None,
    partial_run: Run | None = None,
) -> RawRecord:
    """Integrate the ball passes and record fine samples (and raw values if the case needs them).

    Ends after all passes, at an inspection, or once the motion is periodic by ``criterion``, after a whole number
    of periods (so that a run started from its end is in phase). perturbation: initial perturbation of the ring,
    relative to its displacement; start: initial positions and velocities (2, 6, ROW) if not those of static
    equilibrium; max_search_passes: ball passes after which a non-periodic motion raises ``TooCostly``, 0 for
    never; max_passes: largest number of ball passes; inspector: inspections that may end the run; partial_run: the
    same run with some passes computed, continued unless it has already reached an inspection or ``max_passes``.

    Raises ``MethodFailure`` if the monitor stops the run, and SimulationError without a static equilibrium.
    """
    inspected: Collection[int] = () if inspector is None else inspector.passes
    run = partial_run
    if run is None or run.passes >= min((*inspected, max_passes or inf)):
        run = Run.begin(setup, perturbation, start, criterion, max_passes)
    run.pace.max_cpu = setup.max_cpu
    for passes in run.ball_passes():
        is_inspected = run.period == 0 and passes in inspected
        if inspector is not None and is_inspected and inspector.ends(run.inspected_record()):
            break
        if passes == max_passes:
            break
        if run.period == 0 and passes == max_search_passes:
            raise TooCostly(
                f"no ball pass of {passes} repeats another", setup.step_fraction, periodic=False, regular=False
            )
    return run.record()


def _make_search(setup: Setup, criterion: PeriodCriterion) -> Search | None:
    """Make a search for a period; None if the motion cannot be periodic or is computed in full."""
    if not may_repeat(setup.case):
        return None
    cells, memoryless = channels.recorded_cells(setup.case), MODELS[setup.case.model].memoryless
    slowest_ratio = exp(-slowest_decay(setup.case) / setup.grid.rate)
    steps = setup.grid.steps_per_pass
    return Search(cells, steps, setup.model, memoryless, criterion, slowest_ratio, setup.rounding)


def _make_initial_buffer(setup: Setup, perturbation: float, state: np.ndarray | None = None) -> np.ndarray:
    """Make a buffer at t = 0, at static equilibrium or ``state``, with accelerations and a prepared method."""
    case, model = setup.case, setup.model
    y, residual = assemble.start(case, model)
    if not residual <= 1e-8 * hypot(case.load, case.load_across):
        raise SimulationError(
            f"no static equilibrium at the start: {residual:.3g} N left", "check load and clearance"
        )
    if state is not None:
        y[lay.POSITION : lay.POSITION + 2 * lay.STATE] = state.ravel()
    y[lay.POSITION + lay.X] *= 1.0 + perturbation
    if perturbation != 0.0 or state is not None:
        start_at_rest(model, 0.0, y)
    update_extremes(model, y)
    if type(setup.method) in prepare.types:
        prepare_first_step(setup.method, model, 0.0, y)
    return y


def _restart_at(setup: Setup, t: float, y: np.ndarray) -> None:
    """Update accelerations and method state in a buffer with new positions and velocities at time ``t`` (s)."""
    start_at_rest(setup.model, t, y)
    if type(setup.method) in prepare.types:
        prepare_first_step(setup.method, setup.model, t, y)


def _find_steady_start(
    setup: Setup, pace: Pace, start: np.ndarray | None, criterion: PeriodCriterion, max_passes: int | None
) -> np.ndarray | None:
    """Return the steady state at t = 0 (2, 6, ROW), extrapolated from slow modes; ``start`` if it is not reached.

    The state is that at the end of a ball pass, where each roller is at the initial position of another, rotated
    back to t = 0. max_passes: largest number of ball passes.
    """
    extrapolation = SteadyExtrapolation.from_case(
        setup.case, setup.model, setup.grid.rate, STEADY_TOLERANCE * criterion.sum_limit
    )
    if extrapolation is None:
        return start
    y, passes = _make_initial_buffer(setup, 0.0, start), 0
    if start is not None:
        motion = slice(lay.POSITION, lay.POSITION + 2 * lay.STATE)
        extrapolation.set_initial_change(y[motion], _make_initial_buffer(setup, 0.0)[motion])
    cells = channels.recorded_cells(setup.case)
    short_setup = replace(
        setup, grid=replace(setup.grid, passes=min(extrapolation.passes, max_passes or extrapolation.passes))
    )
    with suppress(MethodFailure):  # unless the extrapolation caused it, the run itself fails in the same way
        for _ in _ball_passes(short_setup, NoSamples(), y, cells, pace):
            passes += 1
            if extrapolation.extrapolate(y):
                _restart_at(setup, passes * setup.grid.steps_per_pass * setup.grid.step, y)
            if extrapolation.converged:
                break
    state = y[lay.POSITION : lay.POSITION + 2 * lay.STATE].reshape(2, 6, lay.ROW)
    return rotate_state(state, setup.model, passes) if extrapolation.steady and np.isfinite(state).all() else start


def _ball_passes(
    setup: Setup, samples: NoSamples | Samples, y: np.ndarray, cells: np.ndarray, pace: Pace
) -> Iterator[np.ndarray]:
    """Yield the recorded values of each ball pass, preceded by the end of the pass before, (C, tail + steps).

    The same array is yielded every time. The CPU time of the integrator is added to ``pace``.
    """
    case, grid = setup.case, setup.grid
    steps, tail = grid.steps_per_pass, 2 * DECIMATION_HALF_LENGTH * grid.decimation
    pass_values = np.empty((len(cells), tail + steps))
    pass_values[:] = y[cells][:, np.newaxis]
    motions = (MOTION_ROWS if case.rig.ring is not None else MOTION_ROWS[:1]) if derives_velocity(case) else ()
    _warm_up(setup, samples, y, cells)
    if MODELS[case.model].memoryless:
        # the motion does not start from rest, so samples before t = 0 are computed as well
        lead_in = pass_values[:, steps - 2 * STENCIL_HALF_LENGTH :]
        _record_steps(setup, NoSamples(), -lead_in.shape[1], y, cells, lead_in, pace)
        for motion in motions:
            differentiate(lead_in, motion, 2 * STENCIL_HALF_LENGTH, grid.step)
        pop_peaks(y)
    for p in range(grid.passes):
        pass_values[:, :tail] = pass_values[:, steps:].copy()
        _record_steps(setup, samples, p * steps, y, cells, pass_values[:, tail:], pace)
        for motion in motions:
            differentiate(pass_values, motion, tail, grid.step)
        yield pass_values


def _check_end(setup: Setup, initial_passages: list[float], y: np.ndarray, passes: int) -> None:
    """Raise ``MethodFailure`` if the motion is not finite at the end of a run, or steps missed a defect."""
    end = passes * setup.grid.steps_per_pass * setup.grid.step
    if not np.isfinite(_defect_passages(setup, end, y)).all():
        raise run_failure(setup, outcomes.NOT_FINITE, outcomes.NO_BODY, end)
    missed = count_missed_crossings(setup.model, end, initial_passages, y) if initial_passages else 0
    if missed > 0:
        raise run_failure(setup, outcomes.CROSSINGS_MISSED, missed, end)


_COMPILED: set[tuple] = set()
"""Types of method, model, monitor and samples for which the integrator is compiled or loaded in this process."""


def _warm_up(setup: Setup, samples: NoSamples | Samples, y: np.ndarray, cells: np.ndarray) -> None:
    """Compile or load an integrator by a discarded step, to keep compilation out of the measured CPU time."""
    types = nested_types((setup.method, setup.model, setup.monitor, samples))
    if types in _COMPILED:
        return
    y = y.copy()
    y[lay.CPU_END] = cpu_time.end()
    # strided like a recording, because Numba compiles for each array layout
    columns = np.empty((len(cells), 2))[:, :1]
    advance_and_sample(setup.method, setup.model, setup.monitor, 0, y, cells, columns, samples)
    _COMPILED.add(types)


def _record_steps(
    setup: Setup,
    samples: NoSamples | Samples,
    start: int,
    y: np.ndarray,
    cells: np.ndarray,
    out: np.ndarray,
    pace: Pace,
) -> None:
    """Take the steps from number ``start`` on, and record one in each column of ``out``.

    Raises MethodFailure if the run is stopped.
    """
    n = 0
    while n < out.shape[1]:
        y[lay.CPU_END], start_time = cpu_time.end(), cpu_time.now()
        columns = out[:, n : n + pace.steps]
        count, outcome, body = advance_and_sample(
            setup.method, setup.model, setup.monitor, start + n, y, cells, columns, samples
        )
        n += count
        seconds = cpu_time.now() - start_time
        pace.add(seconds, count)
        _TOTAL_USAGE.steps += count
        _TOTAL_USAGE.cpu_s += seconds
        cpu_time.check()
        if outcome == outcomes.SUCCESS and pace.cpu_s > pace.max_cpu and setup.case.step == "auto":
            outcome = outcomes.TOO_SLOW
        if outcome != outcomes.SUCCESS:
            raise run_failure(setup, outcome, body, (start + n) * setup.grid.step)


def _defect_passages(setup: Setup, t: float, y: np.ndarray) -> list[float]:
    """Return the passages of rollers over each defect until ``t`` (s); empty without contact forces or memory."""
    if not MODELS[setup.case.model].loaded or MODELS[setup.case.model].memoryless:
        return []
    return [relative_passages(setup.model, d, t, y) for d in range(len(setup.model.defects.head))]
