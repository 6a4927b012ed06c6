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
from bearingsim.simulation.comparison import steady_time
from bearingsim.simulation.integration import Run, integrate
from bearingsim.simulation.pilot import pilot
from bearingsim.simulation.pricing import price
from bearingsim.simulation.recording import RawRecord
from bearingsim.simulation.repetition import may_be_periodic, searches_for_period
from bearingsim.simulation.run_setup import NotPeriodic, Setup, StepRefused, set_up
from bearingsim.simulation.settling import decay_time, extrapolation_passes, slow_modes
from bearingsim.simulation.step_check import (
    COARSE_BOUNDS,
    FINER_BOUNDS,
    MAX_COST_RATIO,
    ORBIT_CLOSENESS,
    SECOND_PILOT,
    Beginning,
    FinerPilot,
    StepCheck,
    check_on_orbit,
    check_on_pilot,
    finer_orbit,
    refusal,
)
from bearingsim.simulation.sufficiency import Inspections
from bearingsim.simulation.time_grid import MAX_CPU, SAFETY, requested_step

INITIAL_FACTOR = 2.0
"""First step of a refinement, in automatic steps; the second is 0.89 automatic steps."""


class Refinement(NamedTuple):
    """Run with an accepted step: its setup, its record (None if not yet computed), and its check.

    begun: the run as far as its pilot; None if that was not its beginning.
    """

    setup: Setup
    raw: RawRecord | None
    check: StepCheck
    begun: Run | None = None


class PilotRuns:
    """Runs of a case that begin with its pilots, by fraction of the automatic step."""

    def __init__(self, case: Case) -> None:
        """Begin no run yet. case: with a named method and `settle` as a time."""
        self.case = case
        self.begun: dict[float, Run] = {}

    def run_of(self, pilot_setup: Setup) -> Run | None:
        """Return the run that begins with a pilot; None if it does not or may not be as long."""
        if not begins_with_pilot(self.case):
            return None
        fraction = pilot_setup.step_fraction
        if fraction not in self.begun:
            with suppress(Refused):
                self.begun[fraction] = Run.at_rest(set_up(self.case, fraction, MAX_COST_RATIO * MAX_CPU))
        run = self.begun.get(fraction)
        return None if run is None or run.setup.grid.passes < pilot_setup.grid.passes else run


class WholeRun(NamedTuple):
    """Run that is already computed, of which a pilot is a part."""

    raw: RawRecord

    def beginning(self, passes: int, max_cpu: float) -> RawRecord:
        """Return the record, of at least ``passes`` ball passes."""
        return self.raw


class ShortRuns:
    """Whole runs of a motion that may be periodic but is not within its few ball passes.

    Its pilots are parts of them. The search for a period is the run at the first step if it has computed all ball
    passes. A pilot as long as the run is not computed separately.
    """

    def __init__(self, coarse: Setup, searched: RawRecord | None) -> None:
        """Start with the search for a period, ``searched``, at the step of ``coarse``; None if there was none."""
        case = coarse.case
        self.coarse = coarse
        self.runs = {} if searched is None or not case.periodic else {coarse.step_fraction: searched}
        # Raw values are sampled at other instants, an extrapolated start differs, and strict pilots may be long.
        self.contain_pilots = (
            may_be_periodic(case)
            and not (channels.stores_raw_values(case) or slow_modes(case) > 0 or case.step_check == "strict")
            and case.until is None
        )

    def run_of(self, pilot_setup: Setup) -> WholeRun | None:
        """Return the run that contains a pilot, computed now if it is as long; None if there is no such run."""
        if not self.contain_pilots:
            return None
        step_fraction = pilot_setup.step_fraction
        if step_fraction not in self.runs and pilot_setup.grid.passes == self.coarse.grid.passes:
            self.runs[step_fraction] = integrate(replace(pilot_setup, case=self.coarse.case))
        raw = self.runs.get(step_fraction)
        if raw is None or raw.repetition.period > 0 or raw.repetition.computed < pilot_setup.grid.passes:
            return None
        rows = len(channels.recorded_cells(pilot_setup.case))  # the first ones
        return WholeRun(replace(raw, cells=raw.cells[:rows], fine=raw.fine[:rows]))

    def record(self, step_fraction: float) -> RawRecord | None:
        """Return the whole run at a step; None if it is not computed."""
        raw = self.runs.get(step_fraction) if self.contain_pilots else None
        if raw is None or (raw.repetition.period == 0 and raw.repetition.computed < self.coarse.grid.passes):
            return None
        return raw


def begins_with_pilot(case: Case) -> bool:
    """Check if a run of a case begins with its pilots, step by step.

    A pilot of a ramp runs at the highest speed; one of a motion that may be periodic starts at rest; raw values
    are sampled from the end of `settle` on.
    """
    return not (case.ramp is not None or may_be_periodic(case) or channels.stores_raw_values(case))


def refine_step(case: Case, step_fraction: float, patience: int = 0) -> Refinement:
    """Refine the automatic step of a case with a named method until it is accepted.

    step_fraction: factor on the automatic step; patience: raises ``NotPeriodic`` if nonzero and no period is
    found. Raises ``StepRefused`` if no step is accepted, and like ``integrate``.
    """
    coarse = set_up(case, _start(case, step_fraction))
    is_stable, searched = coarse.step_fraction == INITIAL_FACTOR * step_fraction, None
    if searches_for_period(coarse.case):
        searched = _search(coarse)
        if (periodic := _refine_on_orbit(coarse, searched)) is not None:
            return periodic
        if patience > 0:
            raise NotPeriodic("no ball pass repeats another", "name a `method`")
    return _refine_on_pilots(coarse, ShortRuns(coarse, searched), is_stable)


def refine_periodic(case: Case, step_fraction: float) -> Refinement | None:
    """Refine the step of a case like ``refine_step``; None if the motion is not periodic within a few passes."""
    coarse = set_up(case, _start(case, step_fraction))
    return _refine_on_orbit(coarse, _search(coarse))


def _start(case: Case, step_fraction: float) -> float:
    """Return the multiple of the automatic step at which a refinement starts, limited to a stable step."""
    if assemble.is_adaptive(case):
        return INITIAL_FACTOR * step_fraction
    return step_fraction * min(INITIAL_FACTOR, SAFETY * choice.limits(case).at_impact / requested_step(case))


def _until_periodic(setup: Setup) -> Setup:
    """Return a setup that is computed until it is periodic."""
    return replace(setup, case=setup.case.model_copy(update={"periodic": True}))


def _search(coarse: Setup) -> RawRecord:
    """Return the first ball passes of a run, until it is periodic."""
    max_passes = max(int(price("patience")), extrapolation_passes(coarse.case))
    return integrate(_until_periodic(coarse), closeness=ORBIT_CLOSENESS, max_passes=max_passes)


def _refine_on_orbit(coarse: Setup, raw: RawRecord) -> Refinement | None:
    """Refine the step of a motion that is periodic within a search, ``raw``; None if it is not.

    The finer run is the result, unless the case is computed in full or the record contains a transient, because it
    starts before the run is steady and before its modes have decayed.
    """
    case, setup = coarse.case, _until_periodic(coarse)
    is_steady = steady_time(setup, raw) <= case.settle_s or decay_time(case) <= case.settle_s
    while raw.repetition.period > 0:
        finer, finer_raw = finer_orbit(setup, raw)
        check = check_on_orbit((setup, raw), (finer, finer_raw))
        if check is None:
            break
        check = replace(check, bounds=FINER_BOUNDS)
        if _is_last(finer, check):
            accepted = replace(finer, case=case)
            return Refinement(accepted, finer_raw if case.periodic and is_steady else None, check)
        setup, raw = finer, finer_raw
    return None


def _refine_on_pilots(coarse: Setup, short_runs: ShortRuns, is_stable: bool) -> Refinement:
    """Refine the step of a non-periodic motion on pilots.

    is_stable: whether the first step is not limited by stability. An adaptive method always uses the finer
    tolerance, because its error may not change with the tolerance: a force 1.4 % off changed by 0.06 %.
    """
    case, step_fraction, factor = Inspections(coarse).earliest.case, coarse.step_fraction, 1.0
    runs = PilotRuns(coarse.case)
    previous: FinerPilot | None = None

    def run_of(pilot_setup: Setup) -> Beginning | None:
        return runs.run_of(pilot_setup) or short_runs.run_of(pilot_setup)

    def refinement(fraction: float, check: StepCheck) -> Refinement:
        raw = short_runs.record(fraction)
        return Refinement(set_up(coarse.case, fraction), raw, check, runs.begun.get(fraction))

    while True:
        pilot_run = pilot(case, factor)
        check, is_doubtful, finer = check_on_pilot(case, step_fraction, *pilot_run, previous, run_of)
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
        step_fraction, previous = finer.setup.step_fraction, finer


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
