"""Refinement of an automatic step by factors of 2.24, until two runs agree.

The first step is twice the automatic one. For a periodic motion whole runs are refined, each started on the
periodic orbit of the previous one, and the finer run is the result. Otherwise pilots are refined, and the run gets
the longest step whose error bound is small enough: that of the coarser of two pilots if they hardly differ, else
that of the finer one. Where a pilot is the beginning of a run, the run continues it.
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
from bearingsim.simulation.pilot import make_pilot
from bearingsim.simulation.pricing import begins_with_pilot, coefficient
from bearingsim.simulation.recording import RawRecord
from bearingsim.simulation.repetition import searches_for_period
from bearingsim.simulation.run_setup import Setup, StepRefused, TooCostly, set_up
from bearingsim.simulation.settling import decay_time, extrapolation_passes
from bearingsim.simulation.step_check import (
    COARSE_BOUNDS,
    FINER_BOUNDS,
    MAX_COST_RATIO,
    ORBIT_CRITERION,
    SECOND_PILOT,
    FinerPilot,
    StepCheck,
    check_on_orbit,
    check_on_pilot,
    describe_refusal,
    run_finer_orbit,
)
from bearingsim.simulation.sufficiency import Inspections
from bearingsim.simulation.time_grid import MAX_CPU, requested_step

INITIAL_FACTOR = 2.0
"""First step of a refinement, in automatic steps; the second is 0.89 automatic steps."""


class Refinement(NamedTuple):
    """Setup with an accepted step, its record, and its step check.

    raw: None if the run is not yet computed; partial_run: the run, computed as far as its pilot, None if it does
    not begin with the pilot.
    """

    setup: Setup
    raw: RawRecord | None
    check: StepCheck
    partial_run: Run | None = None


class PartialRuns:
    """Partial runs of a case, by fraction of the automatic step, each computed as far as needed so far.

    A run begins with the search for a period or with a pilot, and the run with the accepted step is continued.
    """

    def __init__(self, case: Case) -> None:
        """Start without runs. case: with a named method and `settle` as a time."""
        self.case = case
        self.runs: dict[float, Run] = {}

    def beginning(self, pilot_setup: Setup) -> RawRecord | None:
        """Return the record of a pilot from the run that begins with it.

        None if there is no such run, or if it is periodic within the pilot.
        """
        run = self._run(pilot_setup.step_fraction)
        if run is None or run.setup.grid.passes < pilot_setup.grid.passes:
            return None
        run.pace.max_cpu = pilot_setup.max_cpu
        run.advance(pilot_setup.grid.passes)
        if run.period > 0:
            return None
        # the rows of the pilot are the first ones of the run
        raw, rows = run.record(), len(channels.recorded_cells(pilot_setup.case))
        return replace(raw, cells=raw.cells[:rows], fine=raw.fine[:rows])

    def _run(self, step_fraction: float) -> Run | None:
        """Return the run at a step, new if necessary; None if it does not begin with its pilots."""
        if begins_with_pilot(self.case) and step_fraction not in self.runs:
            with suppress(Refused):
                self.runs[step_fraction] = Run.begin(set_up(self.case, step_fraction, MAX_COST_RATIO * MAX_CPU))
        return self.runs.get(step_fraction)


def refine_step(attempt: choice.Attempt) -> Refinement:
    """Refine the automatic step of an attempt until it is accepted.

    Raises ``TooCostly`` if the cost of a shorter step, or of a response that is not periodic, is above the limit
    of the attempt; ``StepRefused`` if no step is accepted; and like ``integrate``.
    """
    coarse = set_up(attempt.case, _start(attempt))
    partial_runs = PartialRuns(coarse.case)
    if searches_for_period(coarse.case):
        search_run = _search(coarse)
        if (periodic := _refine_on_orbit(attempt, coarse, search_run.record())) is not None:
            return periodic
        if attempt.max_search_passes > 0:
            raise TooCostly("no ball pass repeats another", attempt.step_fraction, periodic=False, regular=False)
        if begins_with_pilot(coarse.case) and coarse.case.periodic and search_run.period == 0:
            partial_runs.runs[coarse.step_fraction] = search_run
    return _refine_on_pilots(attempt, coarse, partial_runs)


def refine_periodic(attempt: choice.Attempt) -> Refinement | None:
    """Refine the step of an attempt like ``refine_step``; None if a few passes show no period."""
    coarse = set_up(attempt.case, _start(attempt))
    return _refine_on_orbit(attempt, coarse, _search(coarse).record())


def _start(attempt: choice.Attempt) -> float:
    """Return the fraction of the automatic step at which a refinement starts, limited to a stable step."""
    case, step_fraction = attempt.case, attempt.step_fraction
    if assemble.is_adaptive(case):
        return INITIAL_FACTOR * step_fraction
    return step_fraction * min(INITIAL_FACTOR, SAFETY * choice.limits(case).at_impact / requested_step(case))


def _until_periodic(setup: Setup) -> Setup:
    """Return a setup whose run ends when it is periodic."""
    return replace(setup, case=setup.case.model_copy(update={"periodic": True}))


def _search(coarse: Setup) -> Run:
    """Return a run, computed until it is periodic or for the number of passes of a search for a period."""
    max_passes = max(int(coefficient("patience")), extrapolation_passes(coarse.case))
    run = Run.begin(_until_periodic(coarse), criterion=ORBIT_CRITERION, max_passes=max_passes)
    run.advance(max_passes)
    return run


def _refine_on_orbit(attempt: choice.Attempt, coarse: Setup, raw: RawRecord) -> Refinement | None:
    """Refine the step of a motion that is periodic within a search; None if it is not. raw: record of the search.

    The finer run is the result, unless the case is computed in full, or the record contains a transient because it
    starts before the run is steady and before its modes have decayed.
    """
    case, setup = coarse.case, _until_periodic(coarse)
    is_steady = periodic_start(setup, raw) <= case.settle_s or decay_time(case) <= case.settle_s
    while raw.repetition.period > 0:
        finer, finer_raw = run_finer_orbit(setup, raw)
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


def _refine_on_pilots(attempt: choice.Attempt, coarse: Setup, partial_runs: PartialRuns) -> Refinement:
    """Refine the step of a non-periodic motion on pilots. partial_runs: those computed so far.

    An adaptive method always uses the finer tolerance, because its error may not change with the tolerance: a
    force with an error of 1.4 % changed by 0.06 %. The first step is not used if it was limited by stability.
    """
    initial_step_is_unlimited = attempt.step_fraction < 1.0 or coarse.step_fraction == INITIAL_FACTOR
    case, step_fraction, factor = Inspections(coarse).shortest_setup.case, coarse.step_fraction, 1.0
    previous: FinerPilot | None = None

    def refinement(fraction: float, check: StepCheck) -> Refinement:
        return Refinement(set_up(coarse.case, fraction), None, check, partial_runs.runs.get(fraction))

    while True:
        pilot_run = make_pilot(case, factor)
        check, is_doubtful, finer = check_on_pilot(
            case, step_fraction, *pilot_run, previous, partial_runs.beginning, attempt.regular
        )
        if is_doubtful and factor < SECOND_PILOT and make_pilot(case, SECOND_PILOT) != pilot_run:
            factor, previous = SECOND_PILOT, None
            continue
        coarse_check = replace(check, bounds=COARSE_BOUNDS)
        may_be_coarse = not assemble.is_adaptive(case) and (
            initial_step_is_unlimited or step_fraction < coarse.step_fraction
        )
        if may_be_coarse and coarse_check.is_accepted:
            return refinement(step_fraction, coarse_check)
        check = replace(check, bounds=FINER_BOUNDS)
        if _is_last(finer.setup, check):
            return refinement(finer.setup.step_fraction, check)
        is_regular = not (check.chaotic or is_doubtful)
        _refuse_costly(attempt, coarse, finer.setup, periodic=False, regular=is_regular)
        step_fraction, previous = finer.setup.step_fraction, finer


def _refuse_costly(
    attempt: choice.Attempt, coarse: Setup, refused_setup: Setup, periodic: bool, regular: bool
) -> None:
    """Raise ``TooCostly`` if an attempt that continues after a refused step would cost more than its limit.

    refused_setup: setup with this step.
    """
    step_fraction = attempt.step_fraction * refused_setup.step_fraction / coarse.step_fraction
    if attempt.at_step(step_fraction, periodic).cost > attempt.limit:
        raise TooCostly(f"{refused_setup.case.method} needs a shorter step", step_fraction, periodic, regular)


def _is_last(finer: Setup, check: StepCheck) -> bool:
    """Check if a finer run is accepted. Raises ``StepRefused`` if it is not, and its step is the shortest.

    At the shortest step the error of the largest force is ignored.
    """
    shortest = finer.step_fraction <= choice.STEP_FRACTIONS[-1]
    if check.is_accepted or (shortest and check.is_accepted_without_force):
        return True
    if shortest:
        raise StepRefused(*describe_refusal(finer, check))
    return False
