"""Refinement of an automatic step by factors of 2.24, until two runs agree; the finer run is the result.

The first step is twice the automatic one. For a periodic motion whole runs are refined, each started on the orbit
of the previous one. Otherwise pilots are refined, and the run gets the longest step whose error bound is small
enough: that of the coarser of two pilots if they hardly differ, else that of the finer one. Where a pilot is the
beginning of a run, the run continues it.
"""

from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

from bearingsim import assemble
from bearingsim.config import Case
from bearingsim.errors import Refused
from bearingsim.simulation import channels, choice
from bearingsim.simulation.comparison import periodic_start
from bearingsim.simulation.integration import Run
from bearingsim.simulation.limits import SAFETY
from bearingsim.simulation.pilot import pilot
from bearingsim.simulation.pricing import begins_with_pilot, price
from bearingsim.simulation.recording import RawRecord
from bearingsim.simulation.repetition import searches_for_period
from bearingsim.simulation.run_setup import Setup, StepRefused, TooCostly, set_up
from bearingsim.simulation.settling import decay_time, extrapolation_passes
from bearingsim.simulation.step_check import (
    COARSE_BOUNDS,
    FINER_BOUNDS,
    MAX_COST_RATIO,
    ORBIT_CLOSENESS,
    SECOND_PILOT,
    FinerPilot,
    StepCheck,
    check_on_orbit,
    check_on_pilot,
    finer_orbit,
    refusal,
)
from bearingsim.simulation.sufficiency import Inspections
from bearingsim.simulation.time_grid import MAX_CPU, requested_step

INITIAL_FACTOR = 2.0
"""First step of a refinement, in automatic steps; the second is 0.89 automatic steps."""


class Refinement(NamedTuple):
    """Run with an accepted step: its setup, its record (None if not yet computed), and its check.

    begun: the run as far as its pilot; None if it does not begin with that.
    """

    setup: Setup
    raw: RawRecord | None
    check: StepCheck
    begun: Run | None = None


class BegunRuns:
    """Runs of a case, by fraction of the automatic step, each computed as far as needed so far.

    A run begins with the search for a period or with a pilot, and the accepted one is continued.
    """

    def __init__(self, case: Case) -> None:
        """Begin no run yet. case: with a named method and `settle` as a time."""
        self.case = case
        self.runs: dict[float, Run] = {}

    def beginning(self, pilot_setup: Setup) -> RawRecord | None:
        """Return the record of a pilot from the run that begins with it.

        None if there is no such run, or it is periodic within the pilot.
        """
        run = self._run(pilot_setup.step_fraction)
        if run is None or run.setup.grid.passes < pilot_setup.grid.passes:
            return None
        run.pace.max_cpu = pilot_setup.max_cpu
        run.advance(pilot_setup.grid.passes)
        if run.period > 0:
            return None
        raw, rows = run.record(), len(channels.recorded_cells(pilot_setup.case))  # its first rows
        return replace(raw, cells=raw.cells[:rows], fine=raw.fine[:rows])

    def _run(self, step_fraction: float) -> Run | None:
        """Return the run at a step, begun now if it begins with its pilots; None if it does not."""
        if begins_with_pilot(self.case) and step_fraction not in self.runs:
            with suppress(Refused):
                self.runs[step_fraction] = Run.begin(set_up(self.case, step_fraction, MAX_COST_RATIO * MAX_CPU))
        return self.runs.get(step_fraction)


def refine_step(attempt: choice.Attempt) -> Refinement:
    """Refine the automatic step of an attempt until it is accepted.

    Raises ``TooCostly`` if the price of a shorter step, or of a response that is not periodic, is above the limit
    of the attempt; ``StepRefused`` if no step is accepted; and like ``integrate``.
    """
    coarse = set_up(attempt.case, _start(attempt))
    begun = BegunRuns(coarse.case)
    if searches_for_period(coarse.case):
        searched = _search(coarse)
        if (periodic := _refine_on_orbit(attempt, coarse, searched.record())) is not None:
            return periodic
        if attempt.patience > 0:
            raise TooCostly("no ball pass repeats another", attempt.step_fraction, periodic=False, regular=False)
        if begins_with_pilot(coarse.case) and coarse.case.periodic and searched.period == 0:
            begun.runs[coarse.step_fraction] = searched
    return _refine_on_pilots(attempt, coarse, begun)


def refine_periodic(attempt: choice.Attempt) -> Refinement | None:
    """Refine the step of an attempt like ``refine_step``; None if it is not periodic within a few passes."""
    coarse = set_up(attempt.case, _start(attempt))
    return _refine_on_orbit(attempt, coarse, _search(coarse).record())


def _start(attempt: choice.Attempt) -> float:
    """Return the multiple of the automatic step at which a refinement starts, limited to a stable step."""
    case, step_fraction = attempt.case, attempt.step_fraction
    if assemble.is_adaptive(case):
        return INITIAL_FACTOR * step_fraction
    return step_fraction * min(INITIAL_FACTOR, SAFETY * choice.limits(case).at_impact / requested_step(case))


def _until_periodic(setup: Setup) -> Setup:
    """Return a setup that is computed until it is periodic."""
    return replace(setup, case=setup.case.model_copy(update={"periodic": True}))


def _search(coarse: Setup) -> Run:
    """Return a run, computed until it is periodic or a search for a period has taken long enough."""
    max_passes = max(int(price("patience")), extrapolation_passes(coarse.case))
    run = Run.begin(_until_periodic(coarse), closeness=ORBIT_CLOSENESS, max_passes=max_passes)
    run.advance(max_passes)
    return run


def _refine_on_orbit(attempt: choice.Attempt, coarse: Setup, raw: RawRecord) -> Refinement | None:
    """Refine the step of a motion that is periodic within a search, ``raw``; None if it is not.

    The finer run is the result, unless the case is computed in full or the record contains a transient, because it
    starts before the run is steady and before its modes have decayed.
    """
    case, setup = coarse.case, _until_periodic(coarse)
    is_steady = periodic_start(setup, raw) <= case.settle_s or decay_time(case) <= case.settle_s
    while raw.repetition.period > 0:
        finer, finer_raw = finer_orbit(setup, raw)
        check = check_on_orbit((setup, raw), (finer, finer_raw))
        if check is None:
            break
        check = replace(check, bounds=FINER_BOUNDS)
        if _is_last(finer, check):
            accepted = replace(finer, case=case)
            return Refinement(accepted, finer_raw if case.periodic and is_steady else None, check)
        _refuse_costly(attempt, coarse, finer, periodic=True, regular=True)
        setup, raw = finer, finer_raw
    return None


def _refine_on_pilots(attempt: choice.Attempt, coarse: Setup, begun: BegunRuns) -> Refinement:
    """Refine the step of a non-periodic motion on pilots. begun: runs computed so far.

    An adaptive method always uses the finer tolerance, because its error may not change with the tolerance: a
    force 1.4 % off changed by 0.06 %. The first step is not used if it is limited by stability.
    """
    is_stable = attempt.step_fraction < 1.0 or coarse.step_fraction == INITIAL_FACTOR
    case, step_fraction, factor = Inspections(coarse).shortest_setup.case, coarse.step_fraction, 1.0
    previous: FinerPilot | None = None

    def refinement(fraction: float, check: StepCheck) -> Refinement:
        return Refinement(set_up(coarse.case, fraction), None, check, begun.runs.get(fraction))

    while True:
        pilot_run = pilot(case, factor)
        check, is_doubtful, finer = check_on_pilot(
            case, step_fraction, *pilot_run, previous, begun.beginning, attempt.regular
        )
        if is_doubtful and factor < SECOND_PILOT and pilot(case, SECOND_PILOT) != pilot_run:
            factor, previous = SECOND_PILOT, None
            continue
        coarse_check = replace(check, bounds=COARSE_BOUNDS)
        may_be_coarse = not assemble.is_adaptive(case) and (is_stable or step_fraction < coarse.step_fraction)
        if may_be_coarse and coarse_check.holds:
            return refinement(step_fraction, coarse_check)
        check = replace(check, bounds=FINER_BOUNDS)
        if _is_last(finer.setup, check):
            return refinement(finer.setup.step_fraction, check)
        is_regular = not (check.chaotic or is_doubtful)
        _refuse_costly(attempt, coarse, finer.setup, periodic=False, regular=is_regular)
        step_fraction, previous = finer.setup.step_fraction, finer


def _refuse_costly(attempt: choice.Attempt, coarse: Setup, refused: Setup, periodic: bool, regular: bool) -> None:
    """Raise ``TooCostly`` if an attempt that goes on from a refused step costs more than its limit."""
    step_fraction = attempt.step_fraction * refused.step_fraction / coarse.step_fraction
    if attempt.repriced(step_fraction, periodic).price > attempt.limit:
        raise TooCostly(f"{refused.case.method} needs a shorter step", step_fraction, periodic, regular)


def _is_last(finer: Setup, check: StepCheck) -> bool:
    """Check if a finer run is accepted. Raises ``StepRefused`` if it is not and its step is the shortest.

    At the shortest step the error of the largest force is ignored.
    """
    shortest = finer.step_fraction <= choice.STEP_FRACTIONS[-1]
    if check.holds or (shortest and check.holds_without_force):
        return True
    if shortest:
        raise StepRefused(*refusal(finer, check))
    return False
