"""Trial: the first ball passes of a run, on which models are compared in the requested features.

The amplitude of a line is a windowed mean, as is the square of an RMS. Both are computed over the whole trial and
over every pair of successive revolutions of the slowest defect (a Hann window over two revolutions removes the
period of a revolution). Between pairs the difference of two models scatters if the motion is chaotic, and hardly
at all otherwise.
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
from bearingsim.simulation import ending, recording, spectral_lines
from bearingsim.simulation.comparison import PEAK_FORCE_COLUMN
from bearingsim.simulation.features import band_of
from bearingsim.simulation.integration import Inspection, Inspector
from bearingsim.simulation.pilot import PILOT_FRACTION, ROUNDING, elements_with_deviations, longest_revolution_time
from bearingsim.simulation.recording import RawRecord
from bearingsim.simulation.run_setup import Setup
from bearingsim.simulation.settling import cage_revolution_time
from bearingsim.simulation.spectral_lines import SampleAngles

MIN_PASSES, DEFECT_REVOLUTIONS = 16, 4
"""Smallest numbers of compared ball passes, and of revolutions of every defect through the load zone."""
MAX_FRACTION = 0.5
"""Largest fraction of a record that is compared. Trials would otherwise cost more than they save."""
CAGE_REVOLUTIONS = 5
"""Smallest number of revolutions of a free cage that are compared. Tens of successive passes are correlated: the
standard error of a line is 0.9 % over 16 passes and 0.3 % over 64 (100 N, 3000 rpm)."""
INSPECTION_REVOLUTIONS = 2
"""Revolutions of the cage after which a trial may end because it is far from the reference."""
ROUNDING_MARGIN = 1e-9  # s, margin for rounding in a duration that must contain a number of passes
MAIN_LOBE, NEAR_DISTANCE = 2.0, 4.0
"""Half width of the main lobe of a Hann window, and distance beyond which its response is under 0.6 %, in cycles
over the window. The amplitudes of lines closer than ``NEAR_DISTANCE`` are solved for jointly."""
LARGEST_FORCE = "outer_force.max"
MIN_OVERLAP_EIGENVALUE = 0.1
"""Smallest eigenvalue of the overlap matrix of jointly solved lines, at which noise is amplified threefold."""


@dataclass(frozen=True)
class Trial:
    """Features over the first passes of a run after settling.

    passes: number of ball passes; revolutions: number of whole revolutions of the slowest defect in them (of ball
    passes if none rotates); is_periodic: whether the motion is periodic; amplitudes: by name, (1 + W,) complex
    amplitudes (SI) of each requested line over all whole revolutions (the whole trial if fewer than three) and
    over W pairs of successive ones, NaN if the former do not resolve the line; mean_squares: likewise, mean
    squares (SI) of each requested RMS; forces: (passes,) largest outer contact forces (N); method: name of the
    method, empty if the model has none; step: its step (s), or its tolerance if adaptive.
    """

    passes: int
    revolutions: int
    is_periodic: bool
    amplitudes: dict[str, np.ndarray]
    mean_squares: dict[str, np.ndarray]
    forces: np.ndarray
    method: str = ""
    step: float = 0.0

    @property
    def is_consistent(self) -> bool:
        """True if the lengths of all arrays agree with the numbers of passes and revolutions."""
        parts = {len(values) for values in (*self.amplitudes.values(), *self.mean_squares.values())}
        return parts <= {part_count(self.revolutions)} and len(self.forces) == self.passes >= self.revolutions

    def has_features(self, requested: Iterable[str]) -> bool:
        """Check if the trial has all requested lines and RMS values; it always has the largest force."""
        return all(
            name in self.amplitudes or name in self.mean_squares for name in requested if name != LARGEST_FORCE
        )


@dataclass(frozen=True)
class ReferenceValues:
    """Reference values with which a trial is compared, to end it early.

    values: lines and RMS values (SI) by feature; limits: differences (SI) beyond which the trial ends.
    """

    values: Mapping[str, float]
    limits: Mapping[str, float]

    def is_far(self, trial: "Trial") -> bool:
        """Check if a trial differs by more than ``limits`` in any feature."""
        values = {name: float(abs(parts[0])) for name, parts in trial.amplitudes.items()}
        values |= {name: float(np.sqrt(parts[0])) for name, parts in trial.mean_squares.items()}
        return any(
            abs(values[name] - value) > self.limits[name] for name, value in self.values.items() if name in values
        )


def trial_passes(case: Case, has_free_cage: bool = False) -> int:
    """Return the number of ball passes over which the model of a case is compared with the reference.

    has_free_cage: whether the reference has a free cage, which needs ``CAGE_REVOLUTIONS`` even if the record is
    shorter.
    """
    rate = case.bearing.ball_pass_frequency(case.speed)
    passes = max(
        MIN_PASSES,
        ceil(DEFECT_REVOLUTIONS * defect_revolution_time(case) * rate),
        ceil(PILOT_FRACTION * case.duration * rate),
    )
    return max(min(passes, max_trial_passes(case)), has_free_cage * CAGE_REVOLUTIONS * case.bearing.rollers)


def max_trial_passes(case: Case) -> int:
    """Return the largest number of ball passes in a trial of a case whose motion is not periodic, at least 1."""
    return max(int(MAX_FRACTION * case.duration * case.bearing.ball_pass_frequency(case.speed)), 1)


def shows_friction(case: Case) -> bool:
    """Check if the record of a case contains enough revolutions of a free cage to show the effect of friction."""
    return case.duration >= CAGE_REVOLUTIONS * cage_revolution_time(case)


def lengthen_for_trial(case: Case) -> Case:
    """Return the case with a record long enough for a trial of a free cage."""
    return case.model_copy(
        update={
            "duration": max(
                case.duration, CAGE_REVOLUTIONS * cage_revolution_time(case) / MAX_FRACTION + ROUNDING_MARGIN
            )
        }
    )


def defect_revolution_time(case: Case) -> float:
    """Return the time (s) for one revolution of the slowest defect through the load zone; 0 if none rotates."""
    return longest_revolution_time(case)


def last_pass(setup: Setup, passes: int) -> int:
    """Return the number of ball passes to compute so that ``passes`` after settling can be read."""
    case, grid = setup.case, setup.grid
    beyond = grid.passes - floor((case.settle_s + case.duration) * grid.rate)  # for the half length of filters
    return min(grid.passes, ceil(case.settle_s * grid.rate) + passes + beyond)


def read_trial(
    setup: Setup, raw: RawRecord, requested: Sequence[str], passes: int, revolution_time: float
) -> Trial:
    """Make the trial of the first ``passes`` of a run after settling.

    requested: names of features; revolution_time: period (s) of the slowest defect, 0 if none rotates.
    """
    case, grid = setup.case, setup.grid
    start, length = recording.first_sample(case, grid), passes * grid.fine_per_pass + 1
    fine = raw.read(start, length, spectral_lines.feature_rows(case))
    rows = raw.low_passed.read(start, length) if case.antialias else fine
    angles = spectral_lines.angles_of_record(case, setup.model, grid, raw, start, length)
    revolution = max(1.0, revolution_time * grid.rate)  # in ball passes
    spans = revolution_spans(passes, revolution, grid.fine_per_pass)
    series = partial(spectral_lines.sensor_series, case)
    amplitudes, mean_squares = feature_parts(
        setup, requested, partial(series, fine), partial(series, rows), angles, spans
    )
    start_pass = ceil(start / grid.fine_per_pass)
    peaks = raw.peaks[:, PEAK_FORCE_COLUMN]
    sources = [
        int(p) if p < len(peaks) else int(raw.repetition.source(p)) for p in range(start_pass, start_pass + passes)
    ]
    step = float(setup.method.rtol) if assemble.is_adaptive(case) else grid.step
    method_and_step = (case.method, step) if case.method is not None else ("", 0.0)
    periodic = raw.repetition.period > 0
    return Trial(
        passes,
        whole_revolutions(passes, revolution),
        periodic,
        amplitudes,
        mean_squares,
        peaks[sources],
        *method_and_step,
    )


def may_become_record(case: Case) -> bool:
    """Check if a trial far from its reference is continued as the record of the case, which must have `until`."""
    return case.step_check is not False and any(ending.inspection_passes(case))


def record_inspection(
    setup: Setup,
    inspector: Inspector,
    requested: Sequence[str],
    passes: int,
    revolution_time: float,
    reference_values: ReferenceValues,
) -> Inspection:
    """Return the inspection of a trial that may become the record.

    inspector: inspections of the record, which end the run as soon as its features are accurate enough. At the end
    of the trial, but not before that of the shortest record, the run also ends unless it is far from the
    reference, since only then the case is certainly computed with this model.
    """
    end = max(last_pass(setup, passes), min(inspector.passes))

    def may_end(raw: RawRecord) -> bool:
        computed = raw.repetition.computed
        if computed in inspector.passes and inspector.ends(raw):
            return True
        return computed == end and not reference_values.is_far(
            read_trial(setup, raw, requested, passes, revolution_time)
        )

    return Inspection((end, *inspector.passes), may_end)


def early_inspection(
    setup: Setup, requested: Sequence[str], revolution_time: float, reference_values: ReferenceValues
) -> Inspection:
    """Return the inspection that ends a trial far from the reference after ``INSPECTION_REVOLUTIONS``."""
    passes = INSPECTION_REVOLUTIONS * setup.model.bearing.Z
    return Inspection(
        (last_pass(setup, passes),),
        lambda raw: reference_values.is_far(read_trial(setup, raw, requested, passes, revolution_time)),
    )


def feature_parts(
    setup: Setup,
    requested: Sequence[str],
    unfiltered: Callable[[str], np.ndarray],
    low_passed: Callable[[str], np.ndarray],
    angles: SampleAngles,
    spans: Sequence[slice],
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Compute amplitudes of requested lines and mean squares of requested RMS values, over each of ``spans``.

    unfiltered, low_passed: functions that return the series (n,) of a quantity along the sensor, unfiltered and
    low-passed; angles: angles (n,) at the same samples.
    """
    case, fine_rate = setup.case, setup.grid.fine_rate
    amplitudes, mean_squares = {}, {}
    for name in requested:
        quantity, _, line = name.partition("@")
        band_feature = read_band(name)
        if band_feature is not None:
            series, band = unfiltered(band_feature.quantity), band_of(case, band_feature)
            if band_feature.line:
                envelope = signals.squared_envelope(series, fine_rate, band)
                amplitudes[name] = line_amplitudes(
                    envelope, nearby_angles(case, angles, band_feature.line, spans[-1]), spans
                )
            else:
                mean_squares[name] = np.square([signals.band_rms(series[span], fine_rate, band) for span in spans])
        elif line:
            amplitudes[name] = line_amplitudes(
                unfiltered(quantity), nearby_angles(case, angles, line, spans[-1]), spans
            )
        elif name.endswith(".rms"):
            series = low_passed(name.removesuffix(".rms"))
            mean_squares[name] = np.array([mean_square(series[span]) for span in spans])
    return amplitudes, mean_squares


def with_trial_step(case: Case, trial: Trial) -> Case:
    """Return a case with the method and the step (or tolerance) of a trial, without step check."""
    settings: dict[str, Any] = {"step_check": False}
    if trial.method:
        settings |= {"method": trial.method}
        settings |= {"tolerance" if METHODS[trial.method].adaptive else "step": trial.step}
    return case.model_copy(update=settings)


def revolution_spans(passes: int, revolution: float, per_pass: int) -> list[slice]:
    """Return slices of a trial's fine samples: all whole revolutions, then each pair of successive revolutions.

    revolution: in ball passes. With fewer than three revolutions, only the whole trial is returned.
    """
    count = whole_revolutions(passes, revolution)
    if part_count(count) == 1:
        return [slice(0, passes * per_pass)]
    ends = [round(n * revolution * per_pass) for n in range(count + 1)]
    return [slice(0, ends[-1]), *(slice(a, b) for a, b in zip(ends, ends[2:], strict=False))]


def part_count(revolutions: int) -> int:
    """Return the number of values of a line in a trial: one over all ``revolutions``, one per successive pair."""
    return revolutions if revolutions >= 3 else 1


def whole_revolutions(passes: int, revolution: float) -> int:
    """Return the number of whole revolutions, each of ``revolution`` passes, in ``passes`` passes."""
    return floor(passes / revolution + ROUNDING)


def nearby_angles(case: Case, sample_angles: SampleAngles, name: str, span: slice) -> np.ndarray:
    """Return phase angles (1 + L, n) of a line and of L excited lines within ``NEAR_DISTANCE`` in ``span``."""
    angles = {
        line: sample_angles.phase(LINES[line], case.bearing.rollers) for line in (name, *excited_lines(case))
    }
    cycles = {line: float(angle[span][-1] - angle[span][0]) / (2.0 * pi) for line, angle in angles.items()}
    return np.stack([angles[line] for line in angles if abs(cycles[line] - cycles[name]) < NEAR_DISTANCE])


def excited_lines(case: Case) -> list[str]:
    """Return the names of the lines at which a case vibrates, due to defects, form and the passing rollers."""
    elements = elements_with_deviations(case)

    def is_excited(line: Line) -> bool:
        is_of_inner, is_of_rollers = bool(line.inner or line.shaft), bool(line.spin or line.cage)
        return not (is_of_inner and "inner" not in elements) and not (is_of_rollers and "roller" not in elements)

    return [name for name, line in LINES.items() if is_excited(line)]


def line_amplitudes(series: np.ndarray, angles: np.ndarray, spans: Sequence[slice]) -> np.ndarray:
    """Compute the complex amplitudes (spans,) of a line, without the contribution of nearby lines.

    Nearby lines are solved for over the whole series and subtracted. angles: as from ``nearby_angles``. All
    amplitudes are NaN if the whole series does not resolve the lines from each other or from the mean.
    """
    complete = solve_lines(series, angles, spans[0])
    if np.isnan(complete[0]):
        return np.full(len(spans), complete[0])
    residual = series - (complete[1:] @ np.exp(1j * angles[1:])).real
    return np.array([complete[0], *(solve_lines(residual, angles[:1], span)[0] for span in spans[1:])])


def solve_lines(series: np.ndarray, angles: np.ndarray, span: slice) -> np.ndarray:
    """Solve for the complex amplitudes (1 + L,) of lines (SI) under a Hann window; NaN if not resolved."""
    carriers, x = np.exp(-1j * angles[:, span]), series[span]
    weights = hann(len(x))
    overlap = (carriers * weights) @ carriers.conj().T
    cycles = abs(angles[0, span][-1] - angles[0, span][0]) / (2.0 * pi) * len(x) / (len(x) - 1)
    if np.linalg.eigvalsh(overlap)[0] < MIN_OVERLAP_EIGENVALUE or cycles < MAIN_LOBE * (1.0 - ROUNDING):
        return np.full(len(angles), complex(np.nan, np.nan))
    return np.linalg.solve(overlap, 2.0 * (carriers * weights) @ (x - weights @ x))


def mean_square(series: np.ndarray) -> float:
    """Return the mean square about the mean, under a Hann window."""
    weights = hann(len(series))
    return float(weights @ (series - weights @ series) ** 2)


def hann(n: int) -> np.ndarray:
    """Return a Hann window (n,), normalised to a sum of 1."""
    return np.sin(pi * (np.arange(n) + 0.5) / n) ** 2 * 2.0 / n
