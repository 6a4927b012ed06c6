"""Trial: the first ball passes of a run, on which models are compared in the requested features.

The amplitude of a line is a windowed mean, as is the square of an RMS. Both are computed over the whole trial and
over every pair of successive turns of the slowest defect (Hann's window over two turns removes the period of a
turn). Between pairs the difference of two models scatters if the motion is chaotic, and hardly at all otherwise.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import ceil, floor, pi
from typing import Any

import numpy as np

from bearingsim import assemble, signals
from bearingsim.catalogue import METHODS
from bearingsim.config import Case
from bearingsim.config.names import LINES, Line, read_band
from bearingsim.simulation import recording, spectral_lines
from bearingsim.simulation.comparison import FORCE, low_pass_rows
from bearingsim.simulation.features import band_of
from bearingsim.simulation.pilot import DEFECT_TURN, PILOT_FRACTION, ROUNDING
from bearingsim.simulation.recording import RawRecord
from bearingsim.simulation.run_setup import Setup
from bearingsim.simulation.settling import cage_turn
from bearingsim.simulation.spectral_lines import SampleAngles

MIN_PASSES, TURNS = 16, 4
"""Smallest numbers of ball passes, and of turns of every defect through the load zone, that are compared."""
MOST_PART = 0.5
"""Largest part of a record that is compared. A longer trial would cost as much as the run that it may save."""
CAGE_TURNS = 5
"""Smallest number of turns of a free cage that are compared. Tens of successive passes are correlated: the
standard error of a line is 0.9 % over 16 passes and 0.3 % over 64 (100 N, 3000 rpm)."""
INSPECTION_TURNS = 2
"""Turns of the cage after which a trial may end because it is far from the reference."""
SPARE = 1e-9  # s, margin for rounding in a duration that must contain a number of passes
MAIN_LOBE, NEAR = 2.0, 4.0
"""Half width of the main lobe of Hann's window, and distance beyond which its response is under 0.6 %, in turns.
The amplitudes of lines closer than the latter are solved for jointly."""
LARGEST_FORCE = "outer_force.max"
LEAST_OVERLAP_EIGENVALUE = 0.1
"""Smallest eigenvalue of the overlap matrix of jointly solved lines; there, noise is amplified threefold."""


@dataclass(frozen=True)
class Trial:
    """Features over the first passes of a run after settling.

    passes: number of ball passes; turns: whole turns of the slowest defect in them (ball passes if none turns);
    repeats: whether the motion is periodic; lines: by name, (1 + W,) complex amplitudes (SI) of each requested
    line over the whole trial and over W pairs of turns, NaN if the whole trial does not resolve the line; powers:
    likewise, mean squares (SI) of each requested RMS; forces: (passes,) largest outer contact forces (N); method:
    name of the method, empty if the model has none; step: its step (s), or its tolerance if adaptive.
    """

    passes: int
    turns: int
    repeats: bool
    lines: dict[str, np.ndarray]
    powers: dict[str, np.ndarray]
    forces: np.ndarray
    method: str = ""
    step: float = 0.0

    @property
    def is_whole(self) -> bool:
        """Consistency of the lengths of all arrays with the numbers of passes and turns."""
        parts = {len(values) for values in (*self.lines.values(), *self.powers.values())}
        return parts <= {parts_of(self.turns)} and len(self.forces) == self.passes >= self.turns

    def tells(self, requested: Iterable[str]) -> bool:
        """Check if the trial has all requested lines and RMS values; it always has the largest force."""
        return all(name in self.lines or name in self.powers for name in requested if name != LARGEST_FORCE)


@dataclass(frozen=True)
class Against:
    """Reference values with which a trial is compared, and may end early.

    values: lines and RMS values (SI) by feature; most: differences (SI) beyond which the trial ends.
    """

    values: Mapping[str, float]
    most: Mapping[str, float]

    def is_far(self, trial: "Trial") -> bool:
        """Check if a trial differs by more than ``most`` in any feature."""
        own = {name: float(abs(parts[0])) for name, parts in trial.lines.items()}
        own |= {name: float(np.sqrt(parts[0])) for name, parts in trial.powers.items()}
        return any(abs(own[name] - value) > self.most[name] for name, value in self.values.items() if name in own)


def passes_to_try(case: Case, loose: bool = False) -> int:
    """Return the number of ball passes over which the model of a case is compared with the reference.

    loose: whether the reference has a free cage, which needs ``CAGE_TURNS`` even if the record is shorter.
    """
    rate = case.bearing.ball_pass_frequency(case.speed)
    wanted = max(MIN_PASSES, ceil(TURNS * defect_turn(case) * rate), ceil(PILOT_FRACTION * case.duration * rate))
    return max(min(wanted, most_passes(case)), loose * CAGE_TURNS * case.bearing.rollers)


def most_passes(case: Case) -> int:
    """Return the largest number of ball passes in a trial of a case whose motion is not periodic, at least 1."""
    return max(int(MOST_PART * case.duration * case.bearing.ball_pass_frequency(case.speed)), 1)


def tells_friction(case: Case) -> bool:
    """Check if the record of a case contains enough turns of a free cage to show the effect of friction."""
    return case.duration >= CAGE_TURNS * cage_turn(case)


def long_enough(case: Case) -> Case:
    """Return the case with a record long enough for a trial of a free cage."""
    return case.model_copy(
        update={"duration": max(case.duration, CAGE_TURNS * cage_turn(case) / MOST_PART + SPARE)}
    )


def defect_turn(case: Case) -> float:
    """Return the time (s) for one turn of the slowest defect through the load zone; 0 if none turns."""
    return max((float(DEFECT_TURN[defect.race](case)) for defect in case.defects), default=0.0)


def last_pass(setup: Setup, passes: int) -> int:
    """Return the number of ball passes to compute so that ``passes`` after settling can be read."""
    case, cut = setup.case, setup.cut
    beyond = cut.passes - floor((case.settle_s + case.duration) * cut.rate)  # within the reach of filters
    return min(cut.passes, ceil(case.settle_s * cut.rate) + passes + beyond)


def read_trial(setup: Setup, raw: RawRecord, requested: Sequence[str], passes: int, turn: float) -> Trial:
    """Return the trial of the first ``passes`` of a run after settling.

    If the motion is not periodic, it has at most ``most_passes``. turn: period (s) of the slowest defect, or 0.
    """
    case, cut = setup.case, setup.cut
    passes = passes if raw.repetition.period > 0 else min(passes, most_passes(case))
    start, length = recording.first_sample(case, cut), passes * cut.fine_per_pass + 1
    fine = raw.read(start, length, spectral_lines.feature_rows(case))
    rows = low_pass_rows(setup, raw, start, length) if case.antialias else fine
    turning = spectral_lines.sample_angles(setup.model, cut, start, np.zeros(length))
    turn = max(1.0, turn * cut.rate)  # in ball passes
    spans = spans_of(passes, turn, cut.fine_per_pass)
    along = partial(spectral_lines.sensor_series, case)
    lines, powers = parts_of_features(setup, requested, partial(along, fine), partial(along, rows), turning, spans)
    before = ceil(start / cut.fine_per_pass)
    peaks = raw.peaks[:, FORCE]
    sources = [int(p) if p < len(peaks) else int(raw.repetition.source(p)) for p in range(before, before + passes)]
    step = float(setup.method.rtol) if assemble.is_adaptive(case) else cut.step
    stepped = (case.method, step) if case.method is not None else ("", 0.0)
    periodic = raw.repetition.period > 0
    return Trial(passes, whole_turns(passes, turn), periodic, lines, powers, peaks[sources], *stepped)


def parts_of_features(
    setup: Setup,
    requested: Sequence[str],
    fine: Callable[[str], np.ndarray],
    low: Callable[[str], np.ndarray],
    turning: SampleAngles,
    spans: Sequence[slice],
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return amplitudes of requested lines and mean squares of requested RMS values, over each of ``spans``.

    fine, low: functions that return the series (n,) of a quantity along the sensor, unfiltered and low-passed;
    turning: angles (n,) at the same samples.
    """
    case, fs = setup.case, setup.cut.fine_rate
    lines, powers = {}, {}
    for name in requested:
        quantity, _, line = name.partition("@")
        banded = read_band(name)
        if banded is not None:
            series, band = fine(banded.quantity), band_of(case, banded)
            if banded.line:
                envelope = signals.squared_envelope(series, fs, band)
                lines[name] = amplitudes(envelope, angles_near(case, turning, banded.line, spans[-1]), spans)
            else:
                powers[name] = np.square([signals.band_rms(series[span], fs, band) for span in spans])
        elif line:
            lines[name] = amplitudes(fine(quantity), angles_near(case, turning, line, spans[-1]), spans)
        elif name.endswith(".rms"):
            series = low(name.removesuffix(".rms"))
            powers[name] = np.array([mean_square(series[span]) for span in spans])
    return lines, powers


def stepped_alike(case: Case, trial: Trial) -> Case:
    """Return a case with the method and the step (or tolerance) of a trial, without step check."""
    fixed: dict[str, Any] = {"step_check": False}
    if trial.method:
        fixed |= {"method": trial.method}
        fixed |= {"tolerance" if METHODS[trial.method].adaptive else "step": trial.step}
    return case.model_copy(update=fixed)


def spans_of(passes: int, turn: float, per_pass: int) -> list[slice]:
    """Return slices of a trial's fine samples: all whole turns, then each pair of successive turns.

    turn: in ball passes. With fewer than three turns, only the whole trial is returned.
    """
    turns = whole_turns(passes, turn)
    if parts_of(turns) == 1:
        return [slice(0, passes * per_pass)]
    ends = [round(n * turn * per_pass) for n in range(turns + 1)]
    return [slice(0, ends[-1]), *(slice(a, b) for a, b in zip(ends, ends[2:], strict=False))]


def parts_of(turns: int) -> int:
    """Return the number of values of a line in a trial: one over all ``turns``, and one per pair of turns."""
    return turns if turns >= 3 else 1


def whole_turns(passes: int, turn: float) -> int:
    """Return the number of whole turns, each of ``turn`` passes, in ``passes`` passes."""
    return floor(passes / turn + ROUNDING)


def angles_near(case: Case, turning: SampleAngles, name: str, span: slice) -> np.ndarray:
    """Return the angles (1 + L, n) of a line and of L excited lines too near to resolve over ``span``."""
    angles = {line: turning.phase(LINES[line], case.bearing.rollers) for line in (name, *excited(case))}
    turns = {line: float(angle[span][-1] - angle[span][0]) / (2.0 * pi) for line, angle in angles.items()}
    return np.stack([angles[line] for line in angles if abs(turns[line] - turns[name]) < NEAR])


def excited(case: Case) -> list[str]:
    """Return the lines at which a case vibrates, due to its defects and to the passing rollers."""
    races = {defect.race for defect in case.defects}

    def is_there(line: Line) -> bool:
        of_inner, of_rollers = line.inner or line.shaft, line.spin or line.cage
        return not (of_inner and "inner" not in races) and not (of_rollers and "roller" not in races)

    return [name for name, line in LINES.items() if is_there(line)]


def amplitudes(series: np.ndarray, angles: np.ndarray, spans: Sequence[slice]) -> np.ndarray:
    """Return the complex amplitudes (spans,) of a line, without the contribution of nearby lines.

    Nearby lines are solved for over the whole series and subtracted. angles: as from ``angles_near``. All
    amplitudes are NaN if the whole series does not resolve the lines from each other or from the mean.
    """
    whole = solved(series, angles, spans[0])
    if np.isnan(whole[0]):
        return np.full(len(spans), whole[0])
    alone = series - (whole[1:] @ np.exp(1j * angles[1:])).real
    return np.array([whole[0], *(solved(alone, angles[:1], span)[0] for span in spans[1:])])


def solved(series: np.ndarray, angles: np.ndarray, span: slice) -> np.ndarray:
    """Solve for the complex amplitudes (1 + L,) of lines (SI) under Hann's window; NaN if not resolved."""
    turning, x = np.exp(-1j * angles[:, span]), series[span]
    weights = hann(len(x))
    overlap = (turning * weights) @ turning.conj().T
    turns = abs(angles[0, span][-1] - angles[0, span][0]) / (2.0 * pi) * len(x) / (len(x) - 1)
    if np.linalg.eigvalsh(overlap)[0] < LEAST_OVERLAP_EIGENVALUE or turns < MAIN_LOBE * (1.0 - ROUNDING):
        return np.full(len(angles), complex(np.nan, np.nan))
    return np.linalg.solve(overlap, 2.0 * (turning * weights) @ (x - weights @ x))


def mean_square(series: np.ndarray) -> float:
    """Return the mean square about the mean, under Hann's window."""
    weights = hann(len(series))
    return float(weights @ (series - weights @ series) ** 2)


def hann(n: int) -> np.ndarray:
    """Return Hann's window (n,), normalised to a sum of 1."""
    return np.sin(pi * (np.arange(n) + 0.5) / n) ** 2 * 2.0 / n
