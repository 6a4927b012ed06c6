"""Is a step short enough? Tried on the run's own beginning before the run is trusted.

A pilot of some ball passes is stepped twice from the same start: as the run will be, and with half the step (and
a tenth of the tolerance). What the line of the fault and the RMS change by is the error that the run is said to
have. Where the two part as they go on, a third pilot, whose ring starts 1e-10 of its displacement beside, tells
why: if it parts from the first as fast, the motion is chaotic, no step can hold a line, and the RMS alone counts.
"""

from dataclasses import dataclass
from math import ceil, inf, nan, pi, sqrt

import numpy as np

from bearingsim import build, features
from bearingsim.choose import Grid
from bearingsim.config import Case
from bearingsim.config.names import LINES
from bearingsim.features import Tape
from bearingsim.integration import Setup, integrate, set_up

HELD = 0.01
"""The most that half the step may change the line, or the RMS where the motion is chaotic."""

FORGOTTEN = 1  # ball passes at the start of a pilot that do not count
FEWEST, SHORTEST = 4, 5e-3  # ball passes, and s, that count
SHARE = 1 / 16  # of a run that a pilot takes: with its half step three sixteenths of the run's CPU time
TURNING = 1 / 8  # where it must see a pit turn through the load zone
LOUD = 0.1  # a line under this part of the RMS is measured by it
APART = 0.01  # of the RMS: two pilots whose velocities differ by less in every ball pass are not chaotic
NUDGE = 1e-10  # of the ring's displacement at the start; a motion that repeats itself soon forgets it
CERTAIN = 0.003  # standard error of a chaotic record's RMS: two such records then agree to 1 % (2.4 deviations)
FEWEST_STRETCHES, MOST_STRETCHES = 5, 20
GROWN, PARTED = 3.0, 1e-4  # from the first pass that counts to the last; of the RMS
NO_LESS = 0.3  # of what a tenth of the tolerance changes


@dataclass(frozen=True)
class Proof:
    """What half the step (or a tenth of the tolerance) changes.

    line, rms: relative change of the fault's line (of the worst, if there are several) and of the RMS; chaotic:
    whether a start 1e-10 beside leads elsewhere; passes: ball passes that were compared.
    """

    line: float
    rms: float
    chaotic: bool
    passes: int

    @property
    def error(self) -> float:
        """The change that counts."""
        return self.rms if self.chaotic else max(self.line, self.rms)

    @property
    def holds(self) -> bool:
        """Whether the step can be trusted."""
        return bool(self.error <= HELD)


UNPROVEN = Proof(nan, nan, False, 0)


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
    apart = by_pass(one - other, passes) / scale
    chaotic = bool(apart.max() > APART) and leads_elsewhere(coarse, fine, passes, one, other)
    return Proof(
        line=float(max(abs(a - b) / max(abs(b), LOUD * scale) for a, b in lines)),
        rms=float(abs(np.std(one) / scale - 1.0)),
        chaotic=chaotic,
        passes=passes,
    )


def pilot(case: Case) -> tuple[Case, int]:
    """The beginning of a case, and how many of its ball passes are compared."""
    rate = case.bearing.ball_pass_frequency(case.speed)
    whole = (case.settle + case.duration) * rate
    turn = max((TURN_OF[defect.race](case) * rate for defect in case.defects), default=0.0)
    counted = ceil(max(FEWEST, SHORTEST * rate, SHARE * whole, min(turn, TURNING * whole)))
    counted = max(1, min(counted, int(whole) - FORGOTTEN))
    settle = min(FORGOTTEN / rate, max(0.0, whole - counted) / rate)
    short = {"settle": settle, "duration": (counted + 0.5) / rate, "record": (), "antialias": True}
    return case.model_copy(update=short), counted


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


def uncertain(case: Case, cut: Grid, tape: Tape) -> float:
    """The relative standard error of a record's RMS where the motion is chaotic; inf if it is too short to tell.

    From the scatter of the power between stretches of the record, each of whole turns of the pit.
    """
    start, length = tape.zero + features.first_sample(case, cut), int(case.duration * cut.fine_rate)
    velocity = features.along_sensor(case, tape.fine[:, start : start + length], "velocity")
    turn = max([TURN_OF[defect.race](case) for defect in case.defects] + [1.0 / cut.rate])
    stretches = min(MOST_STRETCHES, int(case.duration / turn))
    if stretches < FEWEST_STRETCHES:
        return inf
    size = int(int(case.duration / turn) // stretches * turn * cut.fine_rate)
    power = np.mean((velocity[: stretches * size] - velocity.mean()).reshape(stretches, size) ** 2, axis=1)
    return float(0.5 * power.std(ddof=1) / power.mean() / sqrt(stretches))


def leads_elsewhere(coarse: Setup, fine: Setup, passes: int, one: np.ndarray, other: np.ndarray) -> bool:
    """Whether a motion is chaotic: its pilots ``one`` and ``other`` are at hand.

    An adaptive method answers a nudge with other steps, which changes what it finds by its tolerance. That shrinks
    with the tolerance; where the finer run still parts from its nudged twin as it does from the coarse run, the
    motion itself does it.
    """
    scale = float(np.std(other))
    if build.method_kind(coarse.case).adaptive:
        beside = by_pass(other - velocities(fine, passes, NUDGE), passes)
        return bool(beside[-1] > PARTED * scale and beside[-1] > NO_LESS * by_pass(one - other, passes)[-1])
    return parts(by_pass(one - velocities(coarse, passes, NUDGE), passes) / scale)


def parts(beside: np.ndarray) -> bool:
    """Whether what a nudge changes, by ball pass and over the RMS, grows instead of being forgotten."""
    return bool(beside[-1] > PARTED or (beside[-1] > 1e3 * NUDGE and beside[-1] > GROWN * beside[0]))
