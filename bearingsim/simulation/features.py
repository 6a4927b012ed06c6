"""Numbers read from a run: lines at characteristic frequencies, statistics, what rollers and cage did."""

from dataclasses import dataclass
from math import ceil, cos, floor, pi, sin
from typing import Any, NamedTuple

import numpy as np

from bearingsim import signals
from bearingsim.catalogue import FEATURES, MODELS, Feature, code
from bearingsim.config import Case, dataset_names
from bearingsim.config.names import HARMONICS, LINES, Line, line_name
from bearingsim.core import layout as lay
from bearingsim.core.geometry.motion import kinematic_times, speed_factor
from bearingsim.errors import UserError
from bearingsim.simulation.channels import BASE, CAGE_ANGLE, CAGE_SPEED, MOTION, PLACES
from bearingsim.simulation.time_grid import Grid

MIN_PASSES = 3
"""Ball passes that a record must hold for lines to be read against a free cage: interpolation takes its ends."""

EXTREMES = ("outer_force.max", "inner_force.max", "cage_force.max", "tilt.max", "line_load.max")

ROW_OF = {place: row for row, place in enumerate(BASE)}
OTHER_LINES = {name: line for name, line in LINES.items() if not line.outer}


@dataclass(frozen=True)
class RawRecord:
    """What the integrator leaves behind, before it is sampled.

    places: (C,) of the buffer, recorded; fine: (C, n) fine samples of them, number 0 (t = 0) in column ``zero``;
    picked: (C, m) raw values at the record's instants, empty with the low-pass on; y: the buffer at the end.
    """

    places: np.ndarray
    fine: np.ndarray
    zero: int
    picked: np.ndarray
    y: np.ndarray
    integrator_cpu_s: float


class SampleAngles(NamedTuple):
    """Angles (n,) in rad at fine samples: of the first roller, the inner ring, and a roller's roll in the cage."""

    cage: np.ndarray
    inner: np.ndarray
    roll: np.ndarray

    def along(self, line: Line, Z: int) -> np.ndarray:
        """The angle whose cosine a line follows."""
        return (
            line.outer * Z * self.cage
            + line.inner * Z * (self.inner - self.cage)
            + line.spin * self.roll
            + line.cage * self.cage
            + line.shaft * self.inner
        )


def features(case: Case, model: Any, cut: Grid, tape: RawRecord, sampled: np.ndarray) -> dict[str, float]:
    """Every feature of a run; ``sampled``: (C, n) the record."""
    return {
        **ball_pass_lines(case, model, cut, tape),
        **other_lines(case, model, cut, tape),
        **statistics(case, cut, sampled),
        **extremes(case, model, tape.y),
        **cage_and_load_zone(case, model, sampled),
    }


def of_extensions(case: Case, time: np.ndarray, series: dict[str, np.ndarray]) -> dict[str, float]:
    """Features that other packages read from the record: ``time`` (n,) in s, ``series`` (n,) by name, in SI.

    One that asks for a series that was not recorded is nan. Raises UserError for one that fails otherwise.
    """
    return {name: _of_extension(one, case, time, series) for name, one in FEATURES.items()}


def _of_extension(one: Feature, case: Case, time: np.ndarray, series: dict[str, np.ndarray]) -> float:
    try:
        return float(code(one.compute)(case, time, series))
    except KeyError:
        return float("nan")
    except Exception as error:  # whatever another package does
        raise UserError(f"the feature `{one.name}` of another package ({one.compute}) fails: {error}") from error


def along_sensor(case: Case, rows: np.ndarray, quantity: str) -> np.ndarray:
    """A quantity of the ring in the direction the sensor looks."""
    x, y = (rows[ROW_OF[PLACES[name]]] for name in dataset_names(f"ring.{quantity}"))
    return cos(case.rig.sensor_angle) * x + sin(case.rig.sensor_angle) * y


def whole_passes(case: Case, cut: Grid) -> int:
    """Ball passes that lie wholly in the record."""
    return floor(case.duration * cut.rate + 1e-6)


def first_sample(case: Case, cut: Grid) -> int:
    """The number of the record's first fine sample, counted from t = 0."""
    return ceil(case.settle * cut.fine_rate - 1e-6)


def sample_angles(model: Any, cut: Grid, start: int, slip: np.ndarray) -> SampleAngles:
    """Angles at fine samples from number ``start`` on; ``slip``: (n,) the cage's turn beyond its kinematic one."""
    b = model.bearing
    t = kinematic_times(model, (start + np.arange(len(slip))) / cut.fine_rate)
    return SampleAngles(
        b.theta_0 + b.omega_c * t + slip, b.omega_i * t, b.omega_b * t + b.omega_b / b.omega_c * slip
    )


def ball_pass_lines(case: Case, model: Any, cut: Grid, tape: RawRecord) -> dict[str, float]:
    """Amplitude, phase and scatter of the lines at the outer-race frequency and its multiples."""
    M, start, Z = cut.fine_per_pass, first_sample(case, cut), case.bearing.rollers
    length = whole_passes(case, cut) * M + 1
    whole = tape.fine[: len(BASE), start + tape.zero : start + tape.zero + length]
    angle = Z * model.bearing.theta_0
    slip = whole[ROW_OF[CAGE_ANGLE]]
    rate: Any = cut.rate
    if MODELS[case.model].slips:  # its passes take what time they take
        ball_pass = Z * sample_angles(model, cut, start, slip).cage - angle
        enough = 2.0 * pi * MIN_PASSES * (1.0 - 1e-9)  # a record of just so many passes may be short by rounding
        if ball_pass[-1] - ball_pass[0] < enough or np.any(np.diff(ball_pass) <= 0.0):
            return dict.fromkeys(_ball_pass_names(), float("nan"))
        M *= ceil(2.0 * pi / (M * np.diff(ball_pass).min()))  # the longest pass keeps all its samples
        time, (whole, first) = np.arange(length) / cut.fine_rate, signals.at_equal_angles(whole, ball_pass, M)
        passes = first + np.arange((whole.shape[1] - 1) // M + 1)
        rate, start = 1.0 / np.diff(np.interp(2.0 * pi * passes, ball_pass, time)), 0
    velocity = along_sensor(case, whole, "velocity")
    by_pass = {
        quantity: signals.lines_by_pass(along_sensor(case, whole, quantity)[:-1], M, HARMONICS, start, angle)
        for quantity in ("displacement", "velocity")
    }
    by_pass["acceleration"] = signals.derivative_lines(
        by_pass["velocity"], velocity[::M], rate, HARMONICS, angle + 2.0 * pi * (start % M) / M
    )
    found = {}
    beside = MODELS[case.model].slips or any(defect.race != "outer" for defect in case.defects)
    for quantity, lines in by_pass.items():
        for harmonic, values in zip(HARMONICS, lines, strict=True):
            name = f"{quantity}@{line_name(harmonic)}"
            found[name], found[f"{name}.phase"], found[f"{name}-scatter"] = signals.line(values, beside)
    return found


def _ball_pass_names() -> list[str]:
    lines = [f"{quantity}@{line_name(harmonic)}" for quantity in MOTION for harmonic in HARMONICS]
    return [f"{line}{ending}" for line in lines for ending in ("", ".phase", "-scatter")]


def other_lines(case: Case, model: Any, cut: Grid, tape: RawRecord) -> dict[str, float]:
    """Amplitude and phase of lines whose periods do not divide the record; nan where it is too short to tell."""
    start = first_sample(case, cut)
    length = max(2, floor(case.duration * cut.fine_rate + 1e-6))
    fine = tape.fine[: len(BASE), start + tape.zero : start + tape.zero + length]
    turning = sample_angles(model, cut, start, fine[ROW_OF[CAGE_ANGLE]])
    angles = {name: turning.along(line, case.bearing.rollers) for name, line in LINES.items()}
    frequencies = [(angle[-1] - angle[0]) / (2.0 * pi * (length - 1)) * cut.fine_rate for angle in angles.values()]
    told = dict(zip(LINES, signals.resolvable(np.array(frequencies), case.duration), strict=True))
    found: dict[str, float] = {}
    for name in OTHER_LINES:
        for quantity in ("displacement", "velocity"):
            A = complex(signals.line_at(along_sensor(case, fine, quantity), angles[name]) if told[name] else "nan")
            found[f"{quantity}@{name}"], found[f"{quantity}@{name}.phase"] = float(abs(A)), float(np.angle(A))
        # by parts from the velocity, which has fewer impacts to fold into the line than an acceleration
        speed = np.gradient(angles[name]) * cut.fine_rate
        A = 1j * complex(signals.line_at(speed * along_sensor(case, fine, "velocity"), angles[name]))
        A = A if told[name] else complex("nan")
        found[f"acceleration@{name}"], found[f"acceleration@{name}.phase"] = float(abs(A)), float(np.angle(A))
    return found


def statistics(case: Case, cut: Grid, sampled: np.ndarray) -> dict[str, float]:
    """RMS, peak, crest factor and kurtosis of the record's whole ball passes, along the sensor."""
    whole = sampled[:, : round(whole_passes(case, cut) / cut.rate * case.sampling)]
    return {
        f"{quantity}.{name}": value
        for quantity in MOTION
        for name, value in signals.statistics(along_sensor(case, whole, quantity)).items()
    }


def extremes(case: Case, model: Any, y: np.ndarray) -> dict[str, float]:
    """Largest force (N), tilt (rad), line load (N/m) that any roller met; nan for what the model does not know."""
    rows = {"outer_force.max": lay.Q_O_MAX, "inner_force.max": lay.Q_I_MAX} if MODELS[case.model].loaded else {}
    rows |= {"cage_force.max": lay.Q_P_MAX} if MODELS[case.model].slips else {}
    rows |= {"tilt.max": lay.TILT_MAX, "line_load.max": lay.LINE_LOAD_MAX} if MODELS[case.model].sliced else {}
    found = {name: float(y[row : row + model.bearing.Z].max()) for name, row in rows.items()}
    return dict.fromkeys(EXTREMES, float("nan")) | found


def cage_and_load_zone(case: Case, model: Any, sampled: np.ndarray) -> dict[str, float]:
    """Mean extent of the load zone (rad), and the cage's slip; nan for what the model does not know."""
    time = case.settle + np.arange(sampled.shape[1]) / case.sampling
    slip = -sampled[ROW_OF[CAGE_SPEED]] / (model.bearing.omega_c * speed_factor(model, time))
    extent = float(sampled[ROW_OF[lay.LOADED_ROLLERS]].mean()) * 2.0 * pi / model.bearing.Z
    known = MODELS[case.model]
    return {
        "load_zone.extent": extent if known.loaded else float("nan"),
        "cage.slip.mean": float(slip.mean()) if known.slips else float("nan"),
        "cage.slip.std": float(slip.std()) if known.slips else float("nan"),
    }
