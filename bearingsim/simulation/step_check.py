"""Is a step short enough? Tried on the run's own beginning, or on all of it, before the run is trusted.

A motion that repeats itself is compared with its like at half the step, a period with a period. Of any other, a
pilot of some ball passes is stepped twice from the same start: as the run will be, and with half the step (and
a tenth of the tolerance). What the line of the fault and the RMS change by is the error that the run is said to
have. Half the step is 1/sqrt(5) of it: where in a step a pit's cusp falls sets size and sign of an error of first
order, and with half of it exactly a second pit's would fall in the same place again, and its error be unseen.

Where the two part as they go on, a third pilot, whose ring starts 1e-10 of its displacement beside, tells why: if
it parts from the first as fast, the motion is chaotic, no step can hold a line, and the RMS alone counts. If it
does not, that is doubtful: all is tried again on a longer beginning, if there is one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, nan, sqrt

import numpy as np
from scipy.special import stdtrit

from bearingsim import assemble
from bearingsim.config import Case
from bearingsim.core import layout as lay
from bearingsim.simulation import time_grid
from bearingsim.simulation.comparison import Compared, compare, of_orbit, of_pilot
from bearingsim.simulation.integration import Setup, integrate, set_up
from bearingsim.simulation.pilot import pilot, sees_pit_turns
from bearingsim.simulation.raw_record import RawRecord
from bearingsim.simulation.repetition import Closeness, turned_state

ACCURACY = 0.01
"""What a run holds of its line, RMS and largest force; where the motion is chaotic, of the RMS alone."""
TIMES_CHANGE, LEAST_SHARE, RESOLVED = 2.5, 0.3, 1e-5
"""An error stays under so many times the change by half the step. (Of first order it is 1.8 times it, of second
1.25.) What changes little by luck counts for a share of what changes most. Calibrated on random scenes, and tested
on others (docs/step-check.md)."""
MAX_CHANGE = ACCURACY / TIMES_CHANGE
"""The most that half the step may change them."""

APART = 0.01  # of the RMS: two pilots whose velocities differ by less in every ball pass are not chaotic
PERTURBATION = 1e-10  # of the ring's displacement at the start; a motion that repeats itself soon forgets it
CONFIDENCE = 2.5  # standard deviations, where many passes tell them
CONFIDENCE_PROBABILITY = 0.9938  # the probability that lies below them
GROWN, PARTED = 3.0, 1e-4  # from the first pass that counts to the last; in any, of the RMS
NO_LESS = 0.3  # of what half the step, or a tenth of the tolerance, changes
MIN_BLOCKS = 16  # of some passes each, to tell how their RMS scatters
SECOND_PILOT = 4.0  # times as long is a second pilot, if the first one's twins part without chaos
CLOSE_TO_ORBIT = Closeness(1e-5, 1e-5, times=1)
"""How close the finer run must come to repeating itself: changes by less count as none."""
MOST_FINER_PASSES = 4, 16  # times those of the run, and some more: then it is not waited for any longer
FEW_PASSES = 120  # passes of the finer run up to which it may cost more than the run
MAX_COST_RATIO = 4.0  # times the CPU time that half the step and a tenth of the tolerance may take


@dataclass(frozen=True)
class StepCheck:
    """What half the step (and a tenth of the tolerance) changes, and what follows from it.

    line, rms, force, record: as of ``Changes``; chaotic: whether a start 1e-10 beside leads elsewhere; noise:
    standard deviation of the RMS's relative change over the pilot that chaos alone brings about; scatter: what
    that surely stays under over the whole record, inf if the pilot was too short to tell.
    """

    line: float
    rms: float
    force: float = 0.0
    record: float = 0.0
    chaotic: bool = False
    noise: float = 0.0
    scatter: float = 0.0

    @property
    def changes(self) -> dict[str, float]:
        """The changes that count, by what changes."""
        every = {"line of the fault": self.line, "RMS": self.rms, "largest force": self.force}
        return {"RMS": self.rms} if self.chaotic else every

    @property
    def error(self) -> float:
        """The largest change that counts."""
        return max(self.changes.values())

    @property
    def holds(self) -> bool:
        """Whether the step can be trusted: what it changes is small, or no more than chaos does anyway."""
        return bool(self.error <= max(MAX_CHANGE, CONFIDENCE * self.noise))

    @property
    def holds_but_for_force(self) -> bool:
        """Whether line and RMS can be trusted: a peak of a force may need steps that nobody takes."""
        return replace(self, force=0.0).holds

    @property
    def shorter(self) -> float:
        """The part of the step that may hold, if its error is between first and second order."""
        return (MAX_CHANGE / self.error) ** (2.0 / 3.0)

    @property
    def long_enough(self) -> bool:
        """Whether the record holds so much of a chaotic motion that its RMS is worth 1 %."""
        return bool(self.scatter <= ACCURACY)

    def bound(self, change: float) -> float:
        """Bound the step's error of a quantity, from the ``change`` of it (docs/step-check.md)."""
        least = LEAST_SHARE * max(self.line, self.rms, self.force)
        return TIMES_CHANGE * max(change, least) + RESOLVED


UNCHECKED = StepCheck(nan, nan, nan, nan)


def check_step(setup: Setup, raw: RawRecord | None = None) -> StepCheck:
    """Try a case's step. ``raw``: its run, if that is known to repeat itself. Raises like ``integrate``."""
    if raw is not None:
        found = check_on_orbit(setup, raw)
        if found is not None:
            return found
    case, part = setup.case, setup.part
    beginning = pilot(case)
    told, doubtful = check_on_pilot(case, part, *beginning)
    more = pilot(case, SECOND_PILOT)
    if doubtful and more != beginning:
        told, _ = check_on_pilot(case, part, *more)
    return told


def check_on_orbit(coarse: Setup, raw: RawRecord) -> StepCheck | None:
    """Return the step check of a motion that repeats itself: one period of it against one with half the step.

    The finer run starts where the other ended, so it soon repeats itself too; None if it does not. Where it stops,
    what it may still change rests on how fast the coarse run has settled.
    """
    cut = coarse.cut
    whole = coarse.case.model_copy(update={"until": None})
    fine = set_up(whole, coarse.part * shorter(cut.decimation), MAX_COST_RATIO * time_grid.MAX_CPU)
    other = integrate(fine, start=by_place(coarse, raw), close=CLOSE_TO_ORBIT, most=most_finer_passes(raw))
    if other.repetition.period == 0:
        return None
    return StepCheck(*compare(*(of_orbit(setup, one) for setup, one in ((coarse, raw), (fine, other)))))


def most_finer_passes(raw: RawRecord) -> int:
    """Return the ball passes after which a finer run is given up: beyond a few it costs no more than the run."""
    computed = raw.repetition.computed
    as_much = max(FEW_PASSES, round(computed / sqrt(5.0)))
    return min(MOST_FINER_PASSES[0] * computed + MOST_FINER_PASSES[1], as_much)


def by_place(coarse: Setup, raw: RawRecord) -> np.ndarray:
    """Return the state at the end of a run whose motion repeats itself, as if it were t = 0: (2, 6, ROW)."""
    state = raw.y[lay.POSITION : lay.POSITION + 2 * lay.STATE].reshape(2, 6, lay.ROW).copy()
    return turned_state(state, coarse.model, raw.repetition.computed)


def check_on_pilot(case: Case, part: float, short: Case, passes: int) -> tuple[StepCheck, bool]:
    """The step check by one pilot, and whether it is doubtful: its twins part, and nothing says that this is
    chaos.
    """
    allowed = time_grid.MAX_CPU * length(short) / length(case)
    short = short.model_copy(update={"periodic": False, "until": None})
    coarse = set_up(short, part, allowed)
    fine = set_up(with_finer_tolerance(short), part * shorter(coarse.cut.decimation), MAX_COST_RATIO * allowed)
    one, other = (run_pilot(setup, passes) for setup in (coarse, fine))
    found = StepCheck(*compare(one, other))
    scale = float(np.std(other.fine)) or 1.0
    apart = by_pass(one.fine - shifted(other.fine, ahead(coarse, fine) * fine.cut.fine_rate), passes) / scale
    if not apart.max() > APART:
        return found, False
    adaptive = assemble.adaptive(case)
    twin, nudged = (fine, other) if adaptive else (coarse, one)
    third = run_pilot(twin, passes, nudge=PERTURBATION)
    beside = by_pass(nudged.fine - third.fine, passes) / scale
    if not is_chaotic_motion(beside, apart, adaptive):
        return found, True
    # the twins of a pilot have not parted at its start: the wider band, where they part first, tells more
    noise, sure = max(
        (scatter(series, passes) for series in zip(one[:2], other[:2], third[:2], strict=True)), key=np.prod
    )
    told = sees_pit_turns(case, passes) and np.linalg.norm(beside) > NO_LESS * np.linalg.norm(apart)
    whole = max(1.0, case.duration * coarse.cut.rate)
    worth = sure * noise / sqrt(whole) if told else inf
    return replace(found, chaotic=True, noise=noise / sqrt(passes), scatter=worth), False


def run_pilot(setup: Setup, passes: int, nudge: float = 0.0) -> Compared:
    """Return a pilot, and of it what is compared."""
    return of_pilot(setup, integrate(setup, nudge), passes)


def scatter(series: Sequence[np.ndarray], passes: int) -> tuple[float, float]:
    """What chaos does to the RMS of one ball pass: from three recordings of the same passes that have parted.

    Standard deviation of its relative change, and how many of them it surely stays under: by Student's t, with two
    degrees of freedom for each pass that tells, since a few strong ones may make up all the rest. Of single passes
    or blocks of them, whichever says more: what is loud may stay loud for a while.
    """
    sizes = [2**k for k in range(passes.bit_length()) if k == 0 or passes >= MIN_BLOCKS * 2**k]
    return max(_scatter(series, passes // size, size) for size in sizes)


def _scatter(series: Sequence[np.ndarray], blocks: int, size: int) -> tuple[float, float]:
    """Return ``scatter`` from ``blocks`` of ``size`` passes each."""
    powers = np.array([by_pass(one, blocks) ** 2 for one in series])
    powers /= np.mean(powers) or 1.0
    between = np.sum((powers - np.roll(powers, 1, axis=0)) ** 2, axis=0)
    telling = np.sum(between) ** 2 / (np.sum(between**2) or 1.0)
    noise = 0.5 * sqrt(size * np.mean(between) / len(series))
    return noise, float(stdtrit(2.0 * max(1.0, telling), CONFIDENCE_PROBABILITY))


def length(case: Case) -> float:
    """Return what is computed of a case, s."""
    return case.settle_s + case.duration


def shorter(decimation: int) -> float:
    """About 1/sqrt(5), the part of a step to take where a fine sample holds ``decimation`` steps."""
    return decimation / max(2 * decimation + 1, round(sqrt(5.0) * decimation))


def with_finer_tolerance(case: Case) -> Case:
    """Take a tenth of the tolerance of a case, if it gives one (an automatic one goes with the step)."""
    return case if case.tolerance == "auto" else case.model_copy(update={"tolerance": 0.1 * case.tolerance})


def ahead(setup: Setup, other: Setup) -> float:
    """Return the time (s) by which one setup's rollers are ahead: each begins in step with its first pit."""
    return float((setup.model.bearing.theta_0 - other.model.bearing.theta_0) / other.model.bearing.omega_c)


def shifted(series: np.ndarray, part: float) -> np.ndarray:
    """Return a series by a ``part`` of a sample later on, which is much less than one: to first order."""
    return series + part * np.gradient(series)


def by_pass(difference: np.ndarray, passes: int) -> np.ndarray:
    """Return RMS of a difference in each ball pass."""
    whole = difference[: (len(difference) - 1) // passes * passes].reshape(passes, -1)
    return np.sqrt(np.mean(whole**2, axis=1))


def is_chaotic_motion(beside: np.ndarray, apart: np.ndarray, adaptive: bool) -> bool:
    """Whether a motion is chaotic, by what a nudge (``beside``) and half the step (``apart``) change by ball pass.

    Both over the RMS. A motion that repeats itself forgets a nudge. An adaptive method answers it by other steps,
    which changes what it finds by its tolerance. That shrinks with the tolerance: where the finer run parts
    from its nudged twin as it does from the coarse run, the motion itself does it.
    """
    if adaptive:
        return bool(beside.max() > PARTED and beside.max() > NO_LESS * apart.max())
    return bool(beside.max() > PARTED or (beside[-1] > 10.0 * PERTURBATION and beside[-1] > GROWN * beside[0]))
