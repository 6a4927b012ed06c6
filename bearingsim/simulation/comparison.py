"""Two runs of the same motion, compared in what is asked of them: line, RMS, largest force, all that is recorded.

Over one period of a motion that repeats itself, else over the ball passes of a pilot that count.
"""

from math import ceil, floor
from typing import NamedTuple

import numpy as np

from bearingsim import signals
from bearingsim.config import Case
from bearingsim.config.names import FAULT_LINES, LINES
from bearingsim.core import layout as lay
from bearingsim.core.sampling import sampling_kernel
from bearingsim.simulation import channels, features, record_windows
from bearingsim.simulation.accuracy import QUIET_LINE
from bearingsim.simulation.channels import MOTION
from bearingsim.simulation.integration import Setup
from bearingsim.simulation.raw_record import RawRecord
from bearingsim.simulation.repetition import EXTREMES

FORCE = list(EXTREMES).index("outer_force.max")


class Changes(NamedTuple):
    """Relative changes from one run to another.

    line: of the fault's line, the worst of several; rms: of the wide band or of the record, the worse;
    force: of the largest outer force; record: of all that is recorded, of what changes most.
    """

    line: float
    rms: float
    force: float
    record: float


class Compared(NamedTuple):
    """What is compared of two runs, over the ball passes that count.

    fine: (n,) velocity (m/s) along the sensor at fine samples; recorded: (m,) the same as it is recorded,
    low-passed or raw; rest: (C, m) all that is recorded low-passed: the motion along the sensor, the channels
    asked for; picked: (P, k) all that is recorded raw, at the record's instants; lines: (L, parts) what each part
    of it adds to the complex amplitudes of the fault's lines; force: the largest of an outer contact (N).
    """

    fine: np.ndarray
    recorded: np.ndarray
    rest: np.ndarray
    picked: np.ndarray
    lines: np.ndarray
    force: float


def compare(one: Compared, other: Compared) -> Changes:
    """Return how far one run is from another, over the other."""
    quiet = QUIET_LINE * float(np.std(other.recorded)) or 1.0
    return Changes(
        line=float(
            max(line_change(a, b) / max(abs(b.sum()), quiet) for a, b in zip(one.lines, other.lines, strict=True))
        ),
        rms=max(rms_change(a, b) for a, b in zip(one[:2], other[:2], strict=True)),
        force=abs(one.force - other.force) / (other.force or 1.0),
        record=max(
            (
                *(rms_change(a, b) for a, b in zip(one.rest, other.rest, strict=True)),
                *(change_of_picks(a, b) for a, b in zip(one.picked, other.picked, strict=True)),
            )
        ),
    )


def rms_change(one: np.ndarray, other: np.ndarray) -> float:
    """Return relative change of an RMS about the mean; of what hardly changes at all, relative to its size."""
    size = max(float(np.std(other)), QUIET_LINE * float(np.abs(other).max()))
    return float(abs(np.std(one) - np.std(other)) / (size or 1.0))


def change_of_picks(one: np.ndarray, other: np.ndarray) -> float:
    """Return the relative change of the RMS about the mean of raw values, picked at the same instants.

    They meet the flanks of an impact by chance, and a step moves those: changes of single values, which cancel in
    their sum by luck, count for no less than the root of their sum of squares.
    """
    power, before = ((series - np.mean(other)) ** 2 for series in (other, one))
    least = (QUIET_LINE * float(np.abs(other).max(initial=0.0))) ** 2 * len(other)
    change = before - power
    return float(0.5 * max(abs(change.sum()), np.linalg.norm(change)) / (max(power.sum(), least) or 1.0))


def amplitudes(setup: Setup, name: str, passes: int, series: np.ndarray) -> np.ndarray:
    """What each ball pass adds to a line's complex amplitude in a series (Hann), its cage at kinematic speed."""
    start = record_windows.first_sample(setup.case, setup.cut)
    turning = features.sample_angles(setup.model, setup.cut, start, np.zeros(len(series)))
    angle = turning.along(LINES[name], setup.case.bearing.rollers)
    window = np.hanning(len(angle))
    turn = 2.0 * window * np.exp(-1j * angle) / window.sum()
    each = turn * (series - window @ series / window.sum())
    return np.add.reduceat(each, np.arange(0, len(each) - 1, (len(each) - 1) // passes)[:passes])


def line_change(one: np.ndarray, other: np.ndarray) -> float:
    """Return how much two lines differ, given what each pass adds.

    Errors that differ in sign from pass to pass may cancel in a few of them by luck: not less than their root of
    the sum of squares, which is what is left of them on average.
    """
    difference = one - other
    return float(max(abs(difference.sum()), np.linalg.norm(difference)))


def of_orbit(setup: Setup, raw: RawRecord) -> Compared:
    """Return what is compared of a motion that repeats itself: a period of it, and of rollers a turn of the cage.

    Of what is recorded raw the record: which parts of a period its instants meet is chance.
    """
    case, cut, model = setup.case, setup.cut, setup.model
    M, period = cut.fine_per_pass, raw.repetition.period
    taps = sampling_kernel(cut.fine_rate / case.sampling)
    turns = ceil((raw.repetition.computed + ceil(len(taps) / M)) / raw.Z)  # of the cage: each roller in its place
    start = turns * raw.Z * M
    fine = features.along_sensor(case, raw.read(start, period * M), "velocity")
    length = raw.Z * M if np.any(lay.lane_of(raw.places) >= 0) else period * M
    low = raw.through(taps).read(start, length) if case.antialias else None
    lines = signals.lines_by_pass(fine, M, [1], start, case.bearing.rollers * model.bearing.theta_0)
    return _compared(case, raw, fine, low, raw.picked, lines.mean(axis=1, keepdims=True), raw.peaks[-period:])


def _compared(
    case: Case,
    raw: RawRecord,
    fine: np.ndarray,
    low: np.ndarray | None,
    picked: np.ndarray,
    lines: np.ndarray,
    peaks: np.ndarray,
) -> Compared:
    """Gather what is compared; low, picked: rows of all that is recorded, low-passed (or None) and raw."""
    rows = picked if low is None else low
    along = {quantity: features.along_sensor(case, rows, quantity) for quantity in MOTION}
    motion = np.stack([*along.values()])
    asked = channels.asked(case, raw.places)
    asked = asked[asked >= len(channels.base(case))]
    raws = channels.are_contact_forces(case, raw.places[asked])
    if low is None:
        rest, picks = motion[:0], np.concatenate([motion, picked[asked]])
    else:
        rest, picks = np.concatenate([motion, low[asked[~raws]]]), picked[asked[raws]]
    return Compared(fine, along["velocity"], rest, picks, lines, float(peaks[:, FORCE].max()))


def fault_lines(case: Case) -> list[str]:
    """Return the lines of the case's pits; BPFO, at which a healthy bearing vibrates too, without any."""
    return list(dict.fromkeys(FAULT_LINES[defect.race] for defect in case.defects)) or ["BPFO"]


def of_pilot(setup: Setup, raw: RawRecord, passes: int) -> Compared:
    """Return what is compared of a pilot: its last so many ball passes."""
    case, cut = setup.case, setup.cut
    start, length = record_windows.first_sample(case, cut), passes * cut.fine_per_pass + 1
    fine = features.sensed(case, raw, "velocity", start, length)
    low = low_passed(setup, raw, start, length) if case.antialias else None
    picked = raw_values(setup, raw.picked, passes)
    lines = np.stack([amplitudes(setup, name, passes, fine) for name in fault_lines(case)])
    before = floor(case.settle_s * cut.rate + 1e-6)
    return _compared(case, raw, fine, low, picked, lines, raw.peaks[before : before + passes])


def low_passed(setup: Setup, raw: RawRecord, start: int, length: int) -> np.ndarray:
    """Return rows (C, ``length``) at fine samples from number ``start``, low-passed as the record is."""
    taps = sampling_kernel(setup.cut.fine_rate / setup.case.sampling)
    return raw.through(taps).read(start, length)


def raw_values(setup: Setup, picked: np.ndarray, passes: int) -> np.ndarray:
    """Return rows (C, n) of raw values in so many ball passes."""
    return picked[:, : floor(passes / setup.cut.rate * setup.case.sampling) + 1]
