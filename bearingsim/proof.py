"""Is a step short enough? Tried on the run's own beginning before the run is trusted.

A pilot of some ball passes is stepped twice from the same start: as the run will be, and with half the step (and
a tenth of the tolerance). What the line of the fault and the RMS change by is the error that the run is said to
have. Where the two part as they go on, a third pilot, whose ring starts 1e-10 of its displacement beside, tells
why: if it parts from the first as fast, the motion is chaotic, no step can hold a line, and the RMS alone counts.
"""

from dataclasses import dataclass, replace
from math import ceil, inf, nan, pi, sqrt

import numpy as np

from bearingsim import build, features
from bearingsim.config import Case
from bearingsim.config.names import LINES
from bearingsim.integration import Setup, integrate, set_up

HELD = 0.01
"""The most that half the step may change line and RMS; where the motion is chaotic, the RMS alone."""

FORGOTTEN = 1  # ball passes at the start of a pilot that do not count
FEWEST, SHORTEST = 4, 5e-3  # ball passes, and s, that count
SHARE = 1 / 16  # of a run that a pilot takes: with its half step three sixteenths of the run's CPU time
TURNING = 1 / 8  # where it must see a pit turn through the load zone
LOUD = 0.1  # a line under this part of the RMS is measured by it
APART = 0.01  # of the RMS: two pilots whose velocities differ by less in every ball pass are not chaotic
NUDGE = 1e-10  # of the ring's displacement at the start; a motion that repeats itself soon forgets it
SURE = 2.5  # standard deviations
GROWN, PARTED = 3.0, 1e-4  # from the first pass that counts to the last; of the RMS
NO_LESS = 0.3  # of what a tenth of the tolerance changes


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
        return bool(self.error <= max(HELD, SURE * self.noise))

    @property
    def long_enough(self) -> bool:
        """Whether the record holds so much of a chaotic motion that its RMS is worth 1 %."""
        return bool(SURE * self.scatter <= HELD)


UNPROVEN = Proof(nan, nan)


def wanted(case: Case) -> bool:
    """Whether a case's step is to be proven: it is automatic, there is one, and the case does not forbid it."""
    return case.prove and case.method is not None and case.step == "auto" and case.tolerance == "auto"


def prove(case: Case, part: float) -> Proof:
    """Try a case, its method named, at ``part`` of the automatic step. Raises like ``integrate``."""
    short, passes = pilot(case)
    coarse, fine = set_up(short, part), set_up(short, 0.5 * part)
    one, other = velocities(coarse, passes), velocities(fine, passes)
    scale = float(np.std(other)) or 1.0
    lines = [amplitude(coarse, name, passes, one, other) for name in fault_lines(case)]
    found = Proof(
        line=float(max(abs(a - b) / max(abs(b), LOUD * scale) for a, b in lines)),
        rms=float(abs(np.std(one) / scale - 1.0)),
    )
    apart = by_pass(one - other, passes) / scale
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


def pilot(case: Case) -> tuple[Case, int]:
    """The beginning of a case, and how many of its ball passes are compared."""
    rate = case.bearing.ball_pass_frequency(case.speed)
    whole = (case.settle + case.duration) * rate
    turn = turn_of_pits(case) * rate
    counted = ceil(max(FEWEST, SHORTEST * rate, SHARE * whole, min(turn, TURNING * whole)))
    counted = max(1, min(counted, int(whole) - FORGOTTEN))
    settle = min(FORGOTTEN / rate, max(0.0, whole - counted) / rate)
    short = {"settle": settle, "duration": (counted + 0.5) / rate, "record": (), "antialias": True}
    return case.model_copy(update=short), counted


def turn_of_pits(case: Case) -> float:
    """The time (s) in which the slowest pit turns through the load zone once; 0 if none turns."""
    return max((float(TURN_OF[defect.race](case)) for defect in case.defects), default=0.0)


TURN_OF = {
    "outer": lambda case: 0.0,
    "inner": lambda case: 2.0 * pi / case.speed,
    "roller": lambda case: case.bearing.rollers / case.bearing.ball_pass_frequency(case.speed),
}
"""The time (s) in which a pit of each race turns through the load zone once."""

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


def amplitude(setup: Setup, name: str, passes: int, *series: np.ndarray) -> tuple[complex, ...]:
    """The complex amplitudes of a line in several series (Hann), the cage turning at its kinematic speed."""
    start = features.first_sample(setup.case, setup.cut)
    turning = features.turns(setup.model, setup.cut, start, np.zeros(len(series[0])))
    angle = turning.along(LINES[name], setup.case.bearing.rollers)
    window = np.hanning(len(angle))
    turn = 2.0 * window * np.exp(-1j * angle) / window.sum()
    return tuple(complex(turn @ (one - window @ one / window.sum())) for one in series)


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
