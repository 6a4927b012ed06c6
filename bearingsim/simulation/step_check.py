"""Check of a run's step against a step 2.24 times shorter, on a period, a pilot, or the whole run.

Of a periodic motion one period is compared. Of any other, a pilot of some ball passes is stepped twice from the
same start: at the step of the run, and at 1/sqrt(5) of it (with a tenth of the tolerance). The changes of the
defect's line and the RMS measure the error of the run. The factor is not 2, because the place of a defect's cusp
within a step sets size and sign of an error of first order, and with exactly half the step the cusp of a second
defect would fall in the same place, its error unseen.

If the two pilots diverge, a third one, its ring displaced by 1e-10 at the start, shows the reason: if it diverges
from the first as fast, the motion is chaotic, no step can reproduce a line, and the RMS alone counts. Otherwise
the result is doubtful, and all is repeated on a longer pilot, if there is one.

A step of the case's own is that of the run. An automatic one is refined (``refinement.py``), and the finer of the
two runs that agree is the answer.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite, nan, sqrt
from typing import NamedTuple

import numpy as np

from bearingsim import assemble
from bearingsim.config import Case
from bearingsim.config.names import STEP_ACCURACY
from bearingsim.core import layout as lay
from bearingsim.simulation import channels, choice, time_grid
from bearingsim.simulation.comparison import Compared, compare, of_orbit, of_pilot, steady_from
from bearingsim.simulation.integration import integrate
from bearingsim.simulation.pilot import longer_duration, pilot, sees_defect_turns
from bearingsim.simulation.recording import RawRecord
from bearingsim.simulation.repetition import Closeness, turned_state
from bearingsim.simulation.run_setup import MethodFailure, Setup, TooChaotic, set_up


class Bounds(NamedTuple):
    """Bounds of errors from changes by a shorter step: ``times`` a change, and ``resolved`` more.

    least: smallest share of the largest change that every change counts as, since it may be small by chance.

    The change d of an error of order p by a step r = sqrt(5) times shorter extrapolates to errors d r^p/(r^p - 1)
    of the coarse run and d/(r^p - 1) of the finer (Richardson 1911; with a safety factor, the grid convergence
    index of Roache 1994). The order is at least one, that of a force that jumps within a step: 1.81 d and 0.81 d.
    """

    times: float
    least: float
    resolved: float


OF_OWN, OF_COARSE, OF_FINER = Bounds(2.5, 0.3, 1e-5), Bounds(2.5, 0.5, 1e-4), Bounds(2.0, 0.5, 1e-4)
"""Bounds of a step of the case's own, and of the coarse and the finer run of a refinement (safety factors 1.4 and
2.5), calibrated on random scenes, and tested on others (docs/step-check.md)."""

APART = 0.01  # of the RMS: two pilots whose velocities differ by less in every ball pass are not chaotic
PERTURBATION = 1e-10  # of the ring's displacement at the start; a periodic motion soon forgets it
CONFIDENCE = 2.5  # standard deviations, of many passes
CONFIDENCE_PROBABILITY = 0.9938  # the probability that lies below them
GROWN, PARTED = 3.0, 1e-4  # from the first pass that counts to the last; in any, of the RMS
NO_LESS = 0.3  # times the change by the shorter step, or a tenth of the tolerance
MIN_BLOCKS = 16  # of some passes each, for the scatter of their RMS
SECOND_PILOT = 4.0  # times as long is a second pilot, if the first two diverge without chaos
CLOSE_TO_ORBIT = Closeness(1e-5, 1e-5, times=1)
"""Closeness of the finer run to a periodic motion; smaller changes count as none."""
MOST_FINER_PASSES = 4, 16  # times those of the run, and some more: limit of the finer run
FEW_PASSES = 120
"""Passes of the finer run up to which it may cost more than the run.

Measured: at most 14 in 285 random scenes of period one, 40 in 190 with rings of 5 to 100 kg. Of 14 of these with a
longer period, 11 took up to 110, three over 190.
"""
MAX_COST_RATIO = 4.0  # times the CPU time of a run that its finer run may take


@dataclass(frozen=True)
class StepCheck:
    """Changes by a shorter step (and a tenth of the tolerance), and their verdict.

    line, rms, force, record: as of ``Changes``; bounds: those of the run that is taken;
    chaotic: whether a perturbation of 1e-10 grows; noise: standard deviation of the RMS's relative change over the
    pilot due to chaos; scatter: confidence bound of it over the whole record, inf if the pilot was too short.
    """

    line: float
    rms: float
    force: float = 0.0
    record: float = 0.0
    bounds: Bounds = OF_OWN
    chaotic: bool = False
    noise: float = 0.0
    scatter: float = 0.0

    @property
    def changes(self) -> dict[str, float]:
        """Changes that count, by quantity."""
        every = {"line of the fault": self.line, "RMS": self.rms, "largest force": self.force}
        return {"RMS": self.rms} if self.chaotic else every

    @property
    def error(self) -> float:
        """Largest change that counts."""
        return max(self.changes.values())

    @property
    def holds(self) -> bool:
        """Acceptance of the step: its change is small, or within the scatter of chaos."""
        return bool(self.error <= max(STEP_ACCURACY / self.bounds.times, CONFIDENCE * self.noise))

    @property
    def holds_but_for_force(self) -> bool:
        """Acceptance of the step by line and RMS alone, since a force peak may need impractical steps."""
        return replace(self, force=0.0).holds

    @property
    def long_enough(self) -> bool:
        """Acceptance of a chaotic record's length: its RMS is within 1 %."""
        return bool(self.scatter <= STEP_ACCURACY)

    def bound(self, change: float) -> float:
        """Bound the step's error of a quantity, from the ``change`` of it (docs/step-check.md)."""
        least = self.bounds.least * max(self.line, self.rms, self.force)
        return self.bounds.times * max(change, least) + self.bounds.resolved


UNCHECKED = StepCheck(nan, nan, nan, nan)


def checked_step(setup: Setup, raw: RawRecord | None = None) -> StepCheck:
    """Check the step of a setup as it is, if the case checks steps. raw: its run, if that is periodic.

    Raises ``MethodFailure`` if its error is too large; that of the largest force may be if no step is shorter.
    """
    if not setup.case.checks_step:
        return UNCHECKED
    check = check_step(setup, raw if raw is not None and raw.repetition.period > 0 else None)
    may_be_shorter = choice.has_automatic_step(setup.case) and setup.part > choice.STEP_PARTS[-1]
    if not (check.holds or (not may_be_shorter and check.holds_but_for_force)):
        raise MethodFailure(*refused(setup, check))
    return check


def refused(setup: Setup, check: StepCheck) -> tuple[str, str]:
    """Return the reason for refusing a step that does not hold, and advice."""
    refinement = "a shorter step" + " and a tenth of the tolerance" * assemble.adaptive(setup.case)
    what = max(check.changes, key=check.changes.__getitem__)
    chaotic = ", and the motion is chaotic" if check.chaotic else ""
    changes = f"{refinement} changes the {what} by {100.0 * check.error:.2g} %{chaotic}"
    return (
        f"{setup.case.method} is not within {STEP_ACCURACY:.0%}: {changes}",
        "use a longer `duration`" if check.chaotic else f"{_tighter_advice(setup)}, or use `step_check: false`",
    )


def _tighter_advice(setup: Setup) -> str:
    """Return advice on a tighter tolerance or a shorter step."""
    if assemble.adaptive(setup.case):
        return f"use a tighter `tolerance` than {setup.method.rtol:.2g}"
    return "give a `step` of your own" if setup.case.step == "auto" else "use a shorter `step`"


def refuse_short_record(setup: Setup, checks_step: StepCheck) -> None:
    """Raise TooChaotic if a chaotic record is too short for an RMS within 1 %."""
    if checks_step.long_enough:
        return
    needed, worth = longer_duration(setup.case), "is of unknown accuracy"
    if isfinite(checks_step.scatter):
        needed = setup.case.duration * (checks_step.scatter / STEP_ACCURACY) ** 2
        worth = f"is uncertain by {checks_step.scatter:.1%}"
    raise TooChaotic(
        f"the motion is chaotic, and its RMS over {setup.case.duration:.2g} s {worth}",
        f"use a `duration` of {needed:.2g} s, or use `step_check: true`",
        needed,
    )


def check_step(setup: Setup, raw: RawRecord | None = None) -> StepCheck:
    """Check a case's step. raw: its run, if periodic. Raises like ``integrate``."""
    if raw is not None and (on_orbit := check_on_orbit((setup, raw), finer_orbit(setup, raw))) is not None:
        return on_orbit
    case, part = setup.case, setup.part
    beginning = pilot(case)
    check, doubtful, _ = check_on_pilot(case, part, *beginning)
    more = pilot(case, SECOND_PILOT)
    if doubtful and more != beginning:
        check, *_ = check_on_pilot(case, part, *more)
    return check


def finer_orbit(coarse: Setup, raw: RawRecord) -> tuple[Setup, RawRecord]:
    """Return a finer run of a periodic motion, which starts where the other ended and so soon is periodic too."""
    fine = set_up(coarse.case, coarse.part * shorter(coarse.cut.decimation), MAX_COST_RATIO * time_grid.MAX_CPU)
    start = rewound_state(coarse, raw)
    return fine, integrate(fine, start=start, close=CLOSE_TO_ORBIT, most=most_finer_passes(raw))


def check_on_orbit(coarse: tuple[Setup, RawRecord], fine: tuple[Setup, RawRecord]) -> StepCheck | None:
    """Return the step check of a periodic motion: one period of it against one at a shorter step.

    None if the finer run is not periodic, or if raw values are recorded and the record ends before both are
    steady.
    """
    if fine[1].repetition.period == 0:
        return None
    steady = max(steady_from(*coarse), steady_from(*fine))
    if channels.picks(coarse[0].case) and steady >= length(coarse[0].case):
        return None
    return StepCheck(*compare(*(of_orbit(setup, run, steady) for setup, run in (coarse, fine))))


def most_finer_passes(raw: RawRecord) -> int:
    """Return the largest number of ball passes of a finer run: beyond a few it costs no more than the run."""
    computed = raw.repetition.computed
    as_much = max(FEW_PASSES, round(computed / sqrt(5.0)))
    return min(MOST_FINER_PASSES[0] * computed + MOST_FINER_PASSES[1], as_much)


def rewound_state(coarse: Setup, raw: RawRecord) -> np.ndarray:
    """Return the state (2, 6, ROW) at the end of a periodic run, rotated back to t = 0."""
    state = raw.y[lay.POSITION : lay.POSITION + 2 * lay.STATE].reshape(2, 6, lay.ROW).copy()
    return turned_state(state, coarse.model, raw.repetition.computed)


class OnPilot(NamedTuple):
    """Step check by a pilot; doubtful: the pilots diverge without sign of chaos; finer: the finer pilot."""

    check: StepCheck
    doubtful: bool
    finer: tuple[Setup, Compared]


def check_on_pilot(
    case: Case, part: float, short: Case, passes: int, before: tuple[Setup, Compared] | None = None
) -> OnPilot:
    """Check the step of a case by a pilot ``short`` of ``passes``; before: the coarse one, if it has been run."""
    allowed = time_grid.MAX_CPU * length(short) / length(case)
    short = short.model_copy(update={"periodic": False})
    coarse = before[0] if before is not None else set_up(short, part, allowed)
    fine = set_up(with_finer_tolerance(short), part * shorter(coarse.cut.decimation), MAX_COST_RATIO * allowed)
    coarse_run = before[1] if before is not None else run_pilot(coarse, passes)
    fine_run = run_pilot(fine, passes)
    finer = fine, fine_run
    check = StepCheck(*compare(coarse_run, fine_run))
    scale = float(np.std(fine_run.fine)) or 1.0
    apart = (
        by_pass(coarse_run.fine - shifted(fine_run.fine, ahead(coarse, fine) * fine.cut.fine_rate), passes) / scale
    )
    if not apart.max() > APART:
        return OnPilot(check, False, finer)
    adaptive = assemble.adaptive(case)
    twin, nudged = (fine, fine_run) if adaptive else (coarse, coarse_run)
    third = run_pilot(twin, passes, nudge=PERTURBATION)
    beside = by_pass(nudged.fine - third.fine, passes) / scale
    if not is_chaotic_motion(beside, apart, adaptive):
        return OnPilot(check, True, finer)
    # pilots have not diverged at their start; the wider band, where they diverge first, is more informative
    noise, sure = max(
        (scatter(series, passes) for series in zip(coarse_run[:2], fine_run[:2], third[:2], strict=True)),
        key=np.prod,
    )
    is_measurable = sees_defect_turns(case, passes) and np.linalg.norm(beside) > NO_LESS * np.linalg.norm(apart)
    whole = max(1.0, case.duration * coarse.cut.rate)
    worth = sure * noise / sqrt(whole) if is_measurable else inf
    return OnPilot(replace(check, chaotic=True, noise=noise / sqrt(passes), scatter=worth), False, finer)


def run_pilot(setup: Setup, passes: int, nudge: float = 0.0) -> Compared:
    """Run a pilot; return its compared signals."""
    return of_pilot(setup, integrate(setup, nudge), passes)


def scatter(series: Sequence[np.ndarray], passes: int) -> tuple[float, float]:
    """Return the scatter of a ball pass's RMS due to chaos, from three diverged recordings of the same passes.

    First the standard deviation of its relative change, then the factor to its confidence limit: Student's t, with
    two degrees of freedom for each effective pass, because a few strong ones may outweigh the rest. The larger of
    those from single passes and from blocks, because successive passes are correlated.
    """
    sizes = [2**k for k in range(passes.bit_length()) if k == 0 or passes >= MIN_BLOCKS * 2**k]
    return max(_scatter(series, passes // size, size) for size in sizes)


def _scatter(series: Sequence[np.ndarray], blocks: int, size: int) -> tuple[float, float]:
    """Return ``scatter`` from ``blocks`` of ``size`` passes each."""
    from scipy.special import stdtrit

    powers = np.array([by_pass(recording, blocks) ** 2 for recording in series])
    powers /= np.mean(powers) or 1.0
    between = np.sum((powers - np.roll(powers, 1, axis=0)) ** 2, axis=0)
    telling = np.sum(between) ** 2 / (np.sum(between**2) or 1.0)
    noise = 0.5 * sqrt(size * np.mean(between) / len(series))
    return noise, float(stdtrit(2.0 * max(1.0, telling), CONFIDENCE_PROBABILITY))


def length(case: Case) -> float:
    """Return the computed time (s) of a case."""
    return case.settle_s + case.duration


def shorter(decimation: int) -> float:
    """Return about 1/sqrt(5), the fraction of a step where a fine sample holds ``decimation`` steps."""
    return decimation / max(2 * decimation + 1, round(sqrt(5.0) * decimation))


def with_finer_tolerance(case: Case) -> Case:
    """Return the case with a tenth of its tolerance, if it gives one (an automatic one goes with the step)."""
    return case if case.tolerance == "auto" else case.model_copy(update={"tolerance": 0.1 * case.tolerance})


def ahead(setup: Setup, other: Setup) -> float:
    """Return the lead (s) of a setup's rollers over another's, both aligned with their first defect."""
    return float((setup.model.bearing.theta_0 - other.model.bearing.theta_0) / other.model.bearing.omega_c)


def shifted(series: np.ndarray, part: float) -> np.ndarray:
    """Shift a series by a small ``part`` of a sample, to first order."""
    return series + part * np.gradient(series)


def by_pass(difference: np.ndarray, passes: int) -> np.ndarray:
    """Return the RMS (passes,) of a difference in each ball pass."""
    whole = difference[: (len(difference) - 1) // passes * passes].reshape(passes, -1)
    return np.sqrt(np.mean(whole**2, axis=1))


def is_chaotic_motion(beside: np.ndarray, apart: np.ndarray, adaptive: bool) -> bool:
    """Check if a motion is chaotic, by the changes of each ball pass due to a nudge and to a shorter step.

    beside, apart: (passes,) these changes over the RMS. A periodic motion forgets a nudge. An adaptive method
    takes other steps after it, with changes that shrink with the tolerance. If the finer run diverges from its
    nudged twin as much as from the coarse run, the motion itself is the cause.
    """
    if adaptive:
        return bool(beside.max() > PARTED and beside.max() > NO_LESS * apart.max())
    return bool(beside.max() > PARTED or (beside[-1] > 10.0 * PERTURBATION and beside[-1] > GROWN * beside[0]))
