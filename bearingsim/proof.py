"""Is a step short enough? Tried on the run's own beginning before the run is trusted.

A pilot of some ball passes is stepped twice from the same start: as the run will be, and with half the step (and
a tenth of the tolerance). What the line of the fault and the RMS change by is the error that the run is said to
have. Half the step is 1/sqrt(5) of it: where in a step a pit's cusp falls sets size and sign of an error of first
order, and with half of it exactly a second pit's would fall in the same place again, and its error be unseen.

Where the two part as they go on, a third pilot, whose ring starts 1e-10 of its displacement beside, tells why: if
it parts from the first as fast, the motion is chaotic, no step can hold a line, and the RMS alone counts.
"""

from dataclasses import dataclass, replace
from math import inf, nan, sqrt

import numpy as np

from bearingsim import build, choose, features
from bearingsim.config import Case
from bearingsim.config.names import LINES
from bearingsim.integration import Setup, integrate, set_up
from bearingsim.pilot import pilot, turn_of_pits

HELD = 0.01
"""What a run holds of its line and its RMS; where the motion is chaotic, of the RMS alone."""
CHANGED = 0.5 * HELD
"""The most that half the step may change them: an error of first order is twice that."""

LOUD = 1e-3  # a line under this part of the RMS (60 dB below it) is none, and is measured by it
APART = 0.01  # of the RMS: two pilots whose velocities differ by less in every ball pass are not chaotic
NUDGE = 1e-10  # of the ring's displacement at the start; a motion that repeats itself soon forgets it
SURE = 2.5  # standard deviations
GROWN, PARTED = 3.0, 1e-4  # from the first pass that counts to the last; of the RMS
NO_LESS = 0.3  # of what a tenth of the tolerance changes
MORE = 4.0  # times the CPU time that half the step and a tenth of the tolerance may take


@dataclass(frozen=True)
class Proof:
    """What half the step (and a tenth of the tolerance) changes.

    line, rms: relative change of the fault's line (of the worst, if there are several) and of the RMS; chaotic:
    whether a start 1e-10 beside leads elsewhere; noise: standard deviation of the RMS's relative change over the
    pilot that chaos alone brings about; scatter: the same over the whole record, inf if the pilot was too short to
    see the pit turn once.
    """

    line: float
    rms: float
    chaotic: bool = False
    noise: float = 0.0
    scatter: float = 0.0

    @property
    def error(self) -> float:
        """The change that counts."""
        return self.rms if self.chaotic else max(self.line, self.rms)

    @property
    def holds(self) -> bool:
        """Whether the step can be trusted: what it changes is small, or no more than chaos does anyway."""
        return bool(self.error <= max(CHANGED, SURE * self.noise))

    @property
    def long_enough(self) -> bool:
        """Whether the record holds so much of a chaotic motion that its RMS is worth 1 %."""
        return bool(SURE * self.scatter <= HELD)


UNPROVEN = Proof(nan, nan)


def prove(case: Case, part: float) -> Proof:
    """Try a case, its method named, at ``part`` of the automatic step. Raises like ``integrate``."""
    short, passes = pilot(case)
    allowed = choose.MOST_CPU * length(short) / length(case)
    coarse = set_up(short, part, allowed)
    fine = set_up(finer(short), part * shorter(coarse.cut.decimation), MORE * allowed)
    one, other = velocities(coarse, passes), velocities(fine, passes)
    scale = float(np.std(other)) or 1.0
    lines = [
        (amplitude(coarse, name, passes, one), amplitude(fine, name, passes, other)) for name in fault_lines(case)
    ]
    found = Proof(
        line=float(max(abs(a - b) / max(abs(b), LOUD * scale) for a, b in lines)),
        rms=float(abs(np.std(one) / scale - 1.0)),
    )
    apart = by_pass(one - later(other, ahead(coarse, fine) * fine.cut.fine_rate), passes) / scale
    if not apart.max() > APART:
        return found
    twin, nudged = (fine, other) if build.method_kind(case).adaptive else (coarse, one)
    beside = velocities(twin, passes, NUDGE)
    if not leads_elsewhere(by_pass(nudged - beside, passes) / scale, apart, build.method_kind(case).adaptive):
        return found
    powers = [by_pass(series, passes) ** 2 / scale**2 for series in (one, other, beside)]
    between = np.concatenate([powers[0] - powers[1], powers[1] - powers[2], powers[2] - powers[0]])
    noise = 0.5 * float(np.sqrt(np.mean(between**2)))
    seen = passes >= turn_of_pits(case) * coarse.cut.rate
    whole = max(1.0, case.duration * coarse.cut.rate)
    return replace(found, chaotic=True, noise=noise / sqrt(passes), scatter=noise / sqrt(whole) if seen else inf)


def length(case: Case) -> float:
    """What is computed of a case, s."""
    return case.settle + case.duration


def shorter(decimation: int) -> float:
    """About 1/sqrt(5), the part of a step to take where a fine sample holds ``decimation`` steps."""
    return decimation / max(2 * decimation + 1, round(sqrt(5.0) * decimation))


def finer(case: Case) -> Case:
    """The case with a tenth of its tolerance, if it gives one (one that is automatic goes with the step)."""
    return case if case.tolerance == "auto" else case.model_copy(update={"tolerance": 0.1 * case.tolerance})


FAULT_LINES = {"outer": "BPFO", "inner": "BPFI", "roller": "2BSF"}


def fault_lines(case: Case) -> list[str]:
    """The lines of the case's pits; BPFO, at which a healthy bearing vibrates too, without any."""
    return list(dict.fromkeys(FAULT_LINES[defect.race] for defect in case.defects)) or ["BPFO"]


def velocities(setup: Setup, passes: int, nudge: float = 0.0) -> np.ndarray:
    """Velocity (m/s) along the sensor at the fine samples of a pilot's ball passes that count."""
    tape = integrate(setup, nudge)
    start = tape.zero + features.first_sample(setup.case, setup.cut)
    rows = tape.fine[:, start : start + passes * setup.cut.fine_per_pass + 1]
    return features.along_sensor(setup.case, rows, "velocity")


def ahead(setup: Setup, other: Setup) -> float:
    """By how long (s) the rollers of one setup are ahead of another's: each begins in step with its first pit."""
    return float((setup.model.bearing.theta_0 - other.model.bearing.theta_0) / other.model.bearing.omega_c)


def later(series: np.ndarray, part: float) -> np.ndarray:
    """A series by a ``part`` of a sample later on, which is much less than one: to first order."""
    return series + part * np.gradient(series)


def amplitude(setup: Setup, name: str, passes: int, series: np.ndarray) -> complex:
    """The complex amplitude of a line in a series (Hann), the cage turning at its kinematic speed."""
    start = features.first_sample(setup.case, setup.cut)
    turning = features.turns(setup.model, setup.cut, start, np.zeros(len(series)))
    angle = turning.along(LINES[name], setup.case.bearing.rollers)
    window = np.hanning(len(angle))
    turn = 2.0 * window * np.exp(-1j * angle) / window.sum()
    return complex(turn @ (series - window @ series / window.sum()))


def by_pass(difference: np.ndarray, passes: int) -> np.ndarray:
    """RMS of a difference in each ball pass."""
    whole = difference[: (len(difference) - 1) // passes * passes].reshape(passes, -1)
    return np.sqrt(np.mean(whole**2, axis=1))


def leads_elsewhere(beside: np.ndarray, apart: np.ndarray, adaptive: bool) -> bool:
    """Whether a motion is chaotic, by what a nudge (``beside``) and half the step (``apart``) change by ball pass.

    Both over the RMS. A motion that repeats itself forgets a nudge. An adaptive method answers it by other steps,
    which changes what it finds by its tolerance. That shrinks with the tolerance: where the finer run parts
    from its nudged twin as it does from the coarse run, the motion itself does it.
    """
    if adaptive:
        return bool(beside[-1] > PARTED and beside[-1] > NO_LESS * apart[-1])
    return bool(beside[-1] > PARTED or (beside[-1] > 10.0 * NUDGE and beside[-1] > GROWN * beside[0]))
