"""Check of a run's step by comparison with a step 2.24 times shorter, on a period, a pilot, or the whole run.

Of a periodic motion one period is compared. Otherwise a pilot of a few ball passes is integrated twice from the
same start, with the step of the run and with 1/sqrt(5) of it (and a tenth of the tolerance). The changes of the
defect's amplitude and of the RMS measure the error of the run. The factor is not 2 because the position of a
defect's cusp within a step determines size and sign of a first-order error: with half the step the cusp of a
second defect could fall on the same fraction of a step, and its error would not show.

If the two pilots diverge, a third pilot with its ring displaced by 1e-10 at the start distinguishes chaos from
step error. If it diverges as fast, the motion is chaotic: no step reproduces an amplitude, and only the RMS is
checked. If the displacement decays, the pilots differ only by their step error. Otherwise the result is doubtful,
and the check is repeated on a longer pilot if the run is long enough for one.

A step given by the case is used for the run. An automatic step is refined (``refinement.py``), and the result is
the finer of the two runs that agree.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf, isfinite, nan, sqrt
from typing import NamedTuple

import numpy as np

from bearingsim import assemble
from bearingsim.config import Case
from bearingsim.config.names import STEP_ACCURACY
from bearingsim.core import layout as lay
from bearingsim.simulation import channels, choice, time_grid
from bearingsim.simulation.chaos import (
    CONFIDENCE,
    MAX_DECAYED_SHARE,
    MIN_CHANGE_RATIO,
    MIN_DIVERGENCE,
    PERTURBATION,
    estimate_rms_scatter,
    is_chaotic_motion,
)
from bearingsim.simulation.comparison import (
    MIN_SAMPLES,
    RunSignals,
    compare,
    first_raw_value,
    lead_time,
    pass_changes,
    period_signals,
    periodic_start,
    pilot_signals,
    shift,
)
from bearingsim.simulation.integration import integrate
from bearingsim.simulation.pilot import advised_duration, covers_defect_revolutions, make_pilot
from bearingsim.simulation.recording import RawRecord
from bearingsim.simulation.repetition import PeriodCriterion, rotate_state
from bearingsim.simulation.rounding_bounds import velocity_of_perturbation
from bearingsim.simulation.run_setup import MethodFailure, Setup, TooChaotic, set_up
from bearingsim.text.numbers import percent


class Bounds(NamedTuple):
    """Coefficients of an error bound: ``factor`` times the change by a shorter step, plus ``offset``.

    min_share: least change of each quantity, as a share of the largest change, since one may be small by chance.

    If a step r = sqrt(5) times shorter changes a result by d, an error of order p is d r^p/(r^p - 1) in the coarse
    run and d/(r^p - 1) in the finer one (Richardson 1911; with a safety factor, the grid convergence index of
    Roache 1994). The order is at least one, as for a force that jumps within a step: 1.81 d and 0.81 d.
    """

    factor: float
    min_share: float
    offset: float


FIXED_STEP_BOUNDS = Bounds(2.5, 0.3, 1e-5)
COARSE_BOUNDS, FINER_BOUNDS = Bounds(2.5, 0.5, 5e-4), Bounds(2.0, 0.5, 5e-4)
"""Bounds for a step given by the case, and for the coarse and the finer run of a refinement (safety factors 1.4
and 2.5). Calibrated on random scenes and tested on others (docs/evidence/step_check.md)."""

SECOND_PILOT = 4.0  # length of the longer pilot over that of the first, used if the result of that is doubtful
ORBIT_CRITERION = PeriodCriterion(1e-5, 1e-5, pass_count=1)
"""Criterion of a periodic motion for a run that is compared on one period."""
MAX_FINER_PASSES = 4, 16  # limit of the finer run: factor on the passes of the run, and passes added
FEW_PASSES = 120
"""Number of passes up to which the finer run may cost more than the run.

Measured: at most 14 passes in 285 random scenes of period one, and 40 in 190 with rings of 5 to 100 kg. Of 14 of
the latter with a longer period, 11 needed up to 110 passes and three over 190.
"""
MAX_COST_RATIO = 4.0  # largest ratio of the CPU time of a finer run to that of the run


@dataclass(frozen=True)
class StepCheck:
    """Changes by a shorter step (and a tenth of the tolerance), and their assessment.

    line, rms, force, record: as in ``Changes``; bounds: error bounds of the run that is used; chaotic: whether a
    perturbation of 1e-10 grows; noise: standard deviation of the relative change of the RMS over the pilot due to
    chaos; scatter: its confidence limit over the whole record, inf if the pilot was too short; checks_force:
    whether the largest force is checked. It is not checked on pilots of a case with `until`, because the largest
    force depends on the length of the record; on a period it always is.
    """

    line: float
    rms: float
    force: float = 0.0
    record: float = 0.0
    bounds: Bounds = FIXED_STEP_BOUNDS
    chaotic: bool = False
    noise: float = 0.0
    scatter: float = 0.0
    checks_force: bool = True

    @property
    def changes(self) -> dict[str, float]:
        """Changes that are checked, by quantity."""
        line = {} if self.chaotic else {"amplitude at the defect frequency": self.line}
        force = {"largest force": self.force} if self.checks_force and not self.chaotic else {}
        return line | {"RMS": self.rms} | force

    @property
    def error(self) -> float:
        """Largest change that is checked."""
        return max(self.changes.values())

    @property
    def is_accepted(self) -> bool:
        """True if the step is accepted: the error is small, or within the scatter due to chaos."""
        return bool(self.error <= max(STEP_ACCURACY / self.bounds.factor, CONFIDENCE * self.noise))

    @property
    def is_accepted_without_force(self) -> bool:
        """True if the step is accepted by amplitude and RMS; a force peak may need very short steps."""
        return replace(self, checks_force=False).is_accepted

    @property
    def is_long_enough(self) -> bool:
        """True if a chaotic record is long enough for an RMS within ``STEP_ACCURACY``."""
        return bool(self.scatter <= STEP_ACCURACY)

    @property
    def step_errors(self) -> dict[str, float]:
        """Bounds of the step errors by quantity, as far as the check resolves them (docs/step-check.md).

        Two chaotic motions differ in line and largest force however short the step is, so their bounds are NaN.
        Their RMS values differ at random by ``noise``, and a smaller effect of the step does not show.
        """
        if not self.chaotic:
            return {name: self.bound(getattr(self, name)) for name in ("line", "rms", "force", "record")}
        errors = {
            name: max(self.bounds.factor * change + self.bounds.offset, CONFIDENCE * self.noise)
            for name, change in (("rms", self.rms), ("record", self.record))
        }
        return {"line": nan, "rms": errors["rms"], "force": nan, "record": errors["record"]}

    def bound(self, change: float) -> float:
        """Bound the step error of a quantity of a motion that is not chaotic from its ``change``.

        The change of a force that is not checked is limited to the largest one that a check would accept.
        """
        force = self.force if self.checks_force else min(self.force, STEP_ACCURACY / self.bounds.factor)
        min_change = self.bounds.min_share * max(self.line, self.rms, force)
        return self.bounds.factor * max(change, min_change) + self.bounds.offset


UNCHECKED = StepCheck(nan, nan, nan, nan)
"""Step check of a case that requests none."""


def verify_step(setup: Setup, raw: RawRecord | None = None) -> StepCheck:
    """Check the step of a setup, if the case requests step checks. raw: its run, used if periodic.

    Raises ``MethodFailure`` if the error is too large. An error of the largest force is accepted if the step
    cannot be shortened.
    """
    if not setup.case.checks_step:
        return UNCHECKED
    check = check_step(setup, raw if raw is not None and raw.repetition.period > 0 else None)
    may_be_shorter = choice.has_automatic_step(setup.case) and setup.step_fraction > choice.STEP_FRACTIONS[-1]
    if not (check.is_accepted or (not may_be_shorter and check.is_accepted_without_force)):
        raise MethodFailure(*describe_refusal(setup, check))
    return check


def describe_refusal(setup: Setup, check: StepCheck) -> tuple[str, str]:
    """Return the reason for refusing a step, and advice."""
    refinement = "a shorter step" + " and a tenth of the tolerance" * assemble.is_adaptive(setup.case)
    quantity = max(check.changes, key=check.changes.__getitem__)
    chaotic = ", and the motion is chaotic" if check.chaotic else ""
    changes = f"{refinement} changes the {quantity} by {percent(check.error)}{chaotic}"
    return (
        f"{setup.case.method} is not within {STEP_ACCURACY:.0%}: {changes}",
        "use a longer `duration`" if check.chaotic else f"{_tighter_advice(setup)}, or use `step_check: false`",
    )


def _tighter_advice(setup: Setup) -> str:
    """Return advice on a tighter tolerance or a shorter step."""
    if assemble.is_adaptive(setup.case):
        return f"use a tighter `tolerance` than {setup.method.rtol:.2g}"
    return "set `step`" if setup.case.step == "auto" else "use a shorter `step`"


def refuse_short_record(setup: Setup, check: StepCheck) -> None:
    """Raise TooChaotic if a chaotic record is too short for its RMS to be accurate."""
    if check.is_long_enough:
        return
    duration, accuracy_text = advised_duration(setup.case), "is of unknown accuracy"
    if isfinite(check.scatter):
        duration = setup.case.duration * (check.scatter / STEP_ACCURACY) ** 2
        accuracy_text = f"is uncertain by {check.scatter:.1%}"
    raise TooChaotic(
        f"the motion is chaotic, and its RMS over {setup.case.duration:.2g} s {accuracy_text}",
        f"use a `duration` of {duration:.2g} s, or use `step_check: true`",
        duration,
    )


def check_step(setup: Setup, raw: RawRecord | None = None) -> StepCheck:
    """Check the step of a setup. raw: its run, if periodic. Raises like ``integrate``."""
    if raw is not None and (orbit_check := check_on_orbit((setup, raw), run_finer_orbit(setup, raw))) is not None:
        return orbit_check
    case, step_fraction = setup.case, setup.step_fraction
    pilot_run = make_pilot(case)
    check, is_doubtful, _ = check_on_pilot(case, step_fraction, *pilot_run)
    longer_pilot_run = make_pilot(case, SECOND_PILOT)
    if is_doubtful and longer_pilot_run != pilot_run:
        check, *_ = check_on_pilot(case, step_fraction, *longer_pilot_run)
    return check


def run_finer_orbit(coarse: Setup, raw: RawRecord) -> tuple[Setup, RawRecord]:
    """Compute a finer run of a periodic motion, from the end of the coarse run, so that it is soon periodic."""
    fine = set_up(coarse.case, finer_fraction(coarse), MAX_COST_RATIO * time_grid.MAX_CPU)
    start, criterion = rewound_state(coarse, raw), ORBIT_CRITERION._replace(contraction=raw.repetition.contraction)
    return fine, integrate(fine, start=start, criterion=criterion, max_passes=max_finer_passes(raw))


def check_on_orbit(coarse: tuple[Setup, RawRecord], fine: tuple[Setup, RawRecord]) -> StepCheck | None:
    """Return the step check of a periodic motion, from one period at each step.

    None if the finer run is not periodic, or if raw values are recorded and fewer than ``MIN_SAMPLES`` of them lie
    in the periodic part of both runs.
    """
    if fine[1].repetition.period == 0:
        return None
    case, start_time = coarse[0].case, max(periodic_start(*coarse), periodic_start(*fine))
    samples = time_grid.sample_count(case) - first_raw_value(case, start_time)
    if channels.stores_raw_values(case) and samples < MIN_SAMPLES:
        return None
    return StepCheck(*compare(*(period_signals(setup, run, start_time) for setup, run in (coarse, fine))))


def max_finer_passes(raw: RawRecord) -> int:
    """Return the largest number of ball passes of a finer run.

    Above ``FEW_PASSES`` the finer run costs no more than the run itself.
    """
    computed = raw.repetition.computed
    max_passes = max(FEW_PASSES, round(computed / sqrt(5.0)))
    return min(MAX_FINER_PASSES[0] * computed + MAX_FINER_PASSES[1], max_passes)


def rewound_state(coarse: Setup, raw: RawRecord) -> np.ndarray:
    """Return the state (2, 6, ROW) at the end of a periodic run, with the rollers rotated back to t = 0."""
    state = raw.y[lay.POSITION : lay.POSITION + 2 * lay.STATE].reshape(2, 6, lay.ROW).copy()
    return rotate_state(state, coarse.model, raw.repetition.computed)


class FinerPilot(NamedTuple):
    """Finer pilot of a step check.

    converges: whether a perturbation of a coarser pilot has decayed (``MAX_DECAYED_SHARE``), or the motion is
    known not to be chaotic.
    """

    setup: Setup
    signals: RunSignals
    converges: bool = False


class PilotCheck(NamedTuple):
    """Step check by a pilot; finer: the finer pilot.

    is_doubtful: whether the pilots diverge without chaos, and the perturbation has not decayed
    (``MAX_DECAYED_SHARE``).
    """

    check: StepCheck
    is_doubtful: bool
    finer: FinerPilot


def check_on_pilot(
    case: Case,
    step_fraction: float,
    pilot_case: Case,
    passes: int,
    previous: FinerPilot | None = None,
    beginning: Callable[[Setup], RawRecord | None] = lambda pilot_setup: None,
    regular: bool = False,
) -> PilotCheck:
    """Check the step of a case by a pilot of ``passes``.

    previous: its coarse pilot, if already computed; beginning: function that returns the record of a pilot from
    the run that begins with it, None if there is no such run; regular: whether the motion is known not to be
    chaotic.
    """
    cpu_limit = time_grid.MAX_CPU * run_time(pilot_case) / run_time(case)
    pilot_case = pilot_case.model_copy(update={"periodic": False, "step_check": False})
    coarse = previous.setup if previous is not None else set_up(pilot_case, step_fraction, cpu_limit)
    fine = set_up(with_finer_tolerance(pilot_case), finer_fraction(coarse), MAX_COST_RATIO * cpu_limit)
    coarse_run = previous.signals if previous is not None else run_pilot(coarse, passes, raw=beginning(coarse))
    fine_run = run_pilot(fine, passes, raw=beginning(fine))
    finer = FinerPilot(fine, fine_run, regular or (previous is not None and previous.converges))
    check = StepCheck(*compare(coarse_run, fine_run), checks_force=case.until is None)
    rms, rounding = float(np.std(fine_run.fine_velocity)), coarse.rounding.plus(fine.rounding).velocity
    step_difference = coarse_run.fine_velocity - shift(
        fine_run.fine_velocity, lead_time(coarse, fine) * fine.grid.fine_rate
    )
    step_changes = pass_changes(step_difference, passes, rms, rounding)
    if finer.converges or not step_changes.max() > MIN_DIVERGENCE:
        return PilotCheck(check, False, finer)
    adaptive = assemble.is_adaptive(case)
    base, base_run = (fine, fine_run) if adaptive else (coarse, coarse_run)
    perturbed_run = run_pilot(base, passes, perturbation=PERTURBATION)
    perturbation_changes = pass_changes(
        base_run.fine_velocity - perturbed_run.fine_velocity, passes, rms, rounding
    )
    initial_change = velocity_of_perturbation(case, PERTURBATION) / (rms or 1.0)
    if not is_chaotic_motion(perturbation_changes, step_changes, adaptive, initial_change):
        converges = bool(perturbation_changes[-1] <= MAX_DECAYED_SHARE * PERTURBATION)
        return PilotCheck(check, not converges, finer._replace(converges=converges))
    # pilots agree at first, so the signal that diverges sooner, usually of the wider band, is more informative
    noise, confidence_factor = max(
        (
            estimate_rms_scatter(series, passes)
            for series in zip(coarse_run[:2], fine_run[:2], perturbed_run[:2], strict=True)
        ),
        key=np.prod,
    )
    is_measurable = covers_defect_revolutions(case, passes) and np.linalg.norm(
        perturbation_changes
    ) > MIN_CHANGE_RATIO * np.linalg.norm(step_changes)
    record_passes = max(1.0, case.duration * coarse.grid.rate)
    rms_uncertainty = confidence_factor * noise / sqrt(record_passes) if is_measurable else inf
    return PilotCheck(
        replace(check, chaotic=True, noise=noise / sqrt(passes), scatter=rms_uncertainty), False, finer
    )


def run_pilot(setup: Setup, passes: int, perturbation: float = 0.0, raw: RawRecord | None = None) -> RunSignals:
    """Run a pilot; return its compared signals. raw: its record, if already computed."""
    return pilot_signals(setup, integrate(setup, perturbation) if raw is None else raw, passes)


def run_time(case: Case) -> float:
    """Return the time (s) that the run of a case covers, settling included."""
    return case.settle_s + case.duration


def finer_fraction(coarse: Setup) -> float:
    """Return the fraction of the requested step for a run with ``step_ratio`` of the step of ``coarse``.

    The step divides the interval of fine samples, so it may be much shorter than requested. For an adaptive method
    the fraction scales the tolerance, which does not depend on the grid.
    """
    fraction = coarse.step_fraction
    if not assemble.is_adaptive(coarse.case):
        fraction = coarse.grid.step / time_grid.requested_step(coarse.case)
    return fraction * step_ratio(coarse.grid.decimation)


def step_ratio(decimation: int) -> float:
    """Return the ratio of a shorter step to a step, about 1/sqrt(5), for ``decimation`` steps per fine sample."""
    return decimation / max(2 * decimation + 1, round(sqrt(5.0) * decimation))


def with_finer_tolerance(case: Case) -> Case:
    """Return the case with a tenth of its own tolerance; an automatic tolerance follows the step."""
    return case if case.tolerance == "auto" else case.model_copy(update={"tolerance": 0.1 * case.tolerance})
