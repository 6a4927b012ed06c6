"""Refinement of an automatic step by factors of 2.24, until two runs agree; the finer run is the result.

The first step is twice the automatic one. For a periodic motion whole runs are refined, each started on the orbit
of the previous one. Otherwise pilots are refined, and the run gets the step of the finer pilot that agrees, or the
first step if the first two pilots hardly differ.
"""

from dataclasses import replace
from typing import NamedTuple

from bearingsim import assemble
from bearingsim.config import Case
from bearingsim.config.names import STEP_ACCURACY
from bearingsim.simulation import choice
from bearingsim.simulation.comparison import RunSignals, steady_time
from bearingsim.simulation.integration import integrate
from bearingsim.simulation.pilot import pilot
from bearingsim.simulation.pricing import price
from bearingsim.simulation.recording import RawRecord
from bearingsim.simulation.repetition import searches_for_period
from bearingsim.simulation.run_setup import NotPeriodic, Setup, StepRefused, set_up
from bearingsim.simulation.settling import decay_time, extrapolation_passes
from bearingsim.simulation.step_check import (
    OF_COARSE,
    OF_FINER,
    SECOND_PILOT,
    StepCheck,
    check_on_orbit,
    check_on_pilot,
    finer_orbit,
    refused,
)
from bearingsim.simulation.sufficiency import Inspections
from bearingsim.simulation.time_grid import SAFETY, requested_step

START = 2.0
"""First step of a refinement, in automatic steps; the second is 0.89 automatic steps."""
NO_CHANGE = 0.1 * STEP_ACCURACY
"""Largest change between the first two pilots at which the run uses the coarse step (docs/evidence/speed.md)."""


class Refined(NamedTuple):
    """Run with an accepted step: its setup, its record (None if not yet computed), and its check."""

    setup: Setup
    raw: RawRecord | None
    check: StepCheck


def refined(case: Case, part: float, patience: int = 0) -> Refined:
    """Refine the automatic step of a case with a named method until it is accepted.

    part: factor on the automatic step; patience: raises ``NotPeriodic`` if nonzero and no period is found. Raises
    ``StepRefused`` if no step is accepted, and like ``integrate``.
    """
    coarse = set_up(case, _start(case, part))
    if not searches_for_period(coarse.case):
        return _on_pilots(coarse, is_stable=coarse.part == START * part)
    if (periodic := _on_orbit(coarse)) is not None:
        return periodic
    if patience > 0:
        raise NotPeriodic("no ball pass repeats another", "name a `method`")
    return _on_pilots(coarse, is_stable=coarse.part == START * part)


def refined_orbit(case: Case, part: float) -> Refined | None:
    """Refine the step of a case like ``refined``; None if the motion is not periodic within a few passes."""
    return _on_orbit(set_up(case, _start(case, part)))


def _start(case: Case, part: float) -> float:
    """Return the multiple of the automatic step at which a refinement starts, limited to a stable step."""
    if assemble.is_adaptive(case):
        return START * part
    return part * min(START, SAFETY * choice.limits(case).at_impact / requested_step(case))


def _on_orbit(coarse: Setup) -> Refined | None:
    """Refine the step of a motion that is periodic within a few ball passes; None if it is not.

    The finer run is the result, unless the case is computed in full or the record contains a transient, because it
    starts before the run is steady and before its modes have decayed.
    """
    case = coarse.case
    setup = replace(coarse, case=case.model_copy(update={"periodic": True}))
    raw = integrate(setup, most=max(int(price("patience")), extrapolation_passes(case)))
    is_steady = steady_time(setup, raw) <= case.settle_s or decay_time(case) <= case.settle_s
    while raw.repetition.period > 0:
        finer, finer_raw = finer_orbit(setup, raw)
        check = check_on_orbit((setup, raw), (finer, finer_raw))
        if check is None:
            break
        check = replace(check, bounds=OF_FINER)
        if _is_last(finer, check):
            taken = replace(finer, case=case)
            return Refined(taken, finer_raw if case.periodic and is_steady else None, check)
        setup, raw = finer, finer_raw
    return None


def _on_pilots(coarse: Setup, is_stable: bool) -> Refined:
    """Refine the step of a non-periodic motion on pilots.

    is_stable: whether the first step is not limited by stability.
    """
    case, part, times = Inspections(coarse).earliest.case, coarse.part, 1.0
    last: tuple[Setup, RunSignals] | None = None
    while True:
        beginning = pilot(case, times)
        check, doubtful, finer = check_on_pilot(case, part, *beginning, last)
        if doubtful and times < SECOND_PILOT and pilot(case, SECOND_PILOT) != beginning:
            times, last = SECOND_PILOT, None
            continue
        if part == coarse.part and is_stable and check.error <= NO_CHANGE:
            return Refined(coarse, None, replace(check, bounds=OF_COARSE))
        check = replace(check, bounds=OF_FINER)
        if _is_last(finer[0], check):
            return Refined(set_up(coarse.case, finer[0].part), None, check)
        part, last = finer[0].part, finer


def _is_last(finer: Setup, check: StepCheck) -> bool:
    """Check if a finer run is accepted. Raises ``StepRefused`` if it is not and its step is the shortest.

    At the shortest step the error of the largest force is ignored.
    """
    shortest = finer.part <= choice.STEP_FRACTIONS[-1]
    if check.holds or (shortest and check.holds_but_for_force):
        return True
    if shortest:
        raise StepRefused(*refused(finer, check))
    return False
