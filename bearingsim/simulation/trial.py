"""A trial: the first ball passes of a run, by which models are compared. What each pass adds to what is asked.

A line's amplitude is the size of a sum over ball passes (Hann), an RMS the root of a mean, a largest force the
largest of them: so what two models differ by is known pass by pass, and how surely it is known, too.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, floor, pi

import numpy as np

from bearingsim import signals
from bearingsim.config import Case
from bearingsim.config.names import LINES
from bearingsim.simulation import features, record_windows
from bearingsim.simulation.comparison import FORCE, amplitudes, low_passed
from bearingsim.simulation.integration import Setup
from bearingsim.simulation.pilot import PILOT_PART, PIT_TURN
from bearingsim.simulation.raw_record import RawRecord

MIN_PASSES, TURNS = 16, 3
"""Ball passes, and turns of every pit through the load zone, that are compared at least."""
MOST_PART = 0.5
"""Of a record, the most that is compared: more would cost as much as the run that it may save."""


@dataclass(frozen=True)
class Trial:
    """The first passes of a run after it has settled.

    passes: how many count; repeats: whether the motion has been found to repeat itself; lines: of each asked line
    what the passes add to its complex amplitude (SI), by name, NaN of one that they cannot tell from others;
    powers: (passes,) mean squares of an asked RMS (SI), by name; forces: (passes,) the largest of an outer contact
    (N).
    """

    passes: int
    repeats: bool
    lines: dict[str, np.ndarray]
    powers: dict[str, np.ndarray]
    forces: np.ndarray


def passes_to_try(case: Case) -> int:
    """Ball passes of a case by which its model is judged; 0 if its record holds none."""
    rate = case.bearing.ball_pass_frequency(case.speed)
    wanted = max(MIN_PASSES, ceil(TURNS * pit_turn(case) * rate), ceil(PILOT_PART * case.duration * rate))
    return min(wanted, max(int(MOST_PART * case.duration * rate), 1))


def pit_turn(case: Case) -> float:
    """The time (s) in which the slowest pit turns through the load zone once; 0 if none turns."""
    return max((float(PIT_TURN[defect.race](case)) for defect in case.defects), default=0.0)


def last_pass(setup: Setup, passes: int) -> int:
    """Ball passes to compute so that so many after settling can be read."""
    case, cut = setup.case, setup.cut
    beyond = cut.passes - floor((case.settle + case.duration) * cut.rate)  # what filters reach
    return min(cut.passes, ceil(case.settle * cut.rate) + passes + beyond)


def of_passes(setup: Setup, raw: RawRecord, asked: Sequence[str], passes: int) -> Trial:
    """What is asked of the first ``passes`` of a run after settling."""
    case, cut = setup.case, setup.cut
    start, length = record_windows.first_sample(case, cut), passes * cut.fine_per_pass + 1
    fine = raw.read(start, length, features.of_base(case))
    rows = low_passed(setup, raw, start, length) if case.antialias else fine
    lines, powers, told = {}, {}, told_apart(setup, passes / cut.rate)
    for name in asked:
        quantity, _, line = name.partition("@")
        if line:
            parts = amplitudes(setup, line, passes, features.along_sensor(case, fine, quantity))
            lines[name] = parts if line in told else np.full_like(parts, np.nan)
        elif name.endswith(".rms"):
            along = features.along_sensor(case, rows, name.removesuffix(".rms"))
            powers[name] = by_pass_mean_square(along, passes)
    before = ceil(start / cut.fine_per_pass)
    known = raw.peaks[:, FORCE]
    places = [int(p) if p < len(known) else int(raw.repetition.source(p)) for p in range(before, before + passes)]
    return Trial(passes, raw.repetition.period > 0, lines, powers, known[places])


def told_apart(setup: Setup, duration: float) -> set[str]:
    """The lines that a trial of so many seconds tells from all others; multiples of BPFO, whose passes are whole.

    2BSF is close to BPFO: a beginning that holds both as one would judge a model by the wrong one.
    """
    b = setup.model.bearing
    turning = features.SampleAngles(*(np.array(speed) for speed in (b.omega_c, b.omega_i, b.omega_b)))
    frequencies = [abs(float(turning.along(line, b.Z))) / (2.0 * pi) for line in LINES.values()]
    told = signals.resolvable(frequencies, duration)
    return {name for name, alone in zip(LINES, told, strict=True) if alone or name not in features.OTHER_LINES}


def by_pass_mean_square(series: np.ndarray, passes: int) -> np.ndarray:
    """(passes,) mean squares about the mean of all."""
    whole = (series - series.mean())[: (len(series) - 1) // passes * passes]
    return np.mean(whole.reshape(passes, -1) ** 2, axis=1)
