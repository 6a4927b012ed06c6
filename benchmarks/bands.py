"""Test of envelope spectra for spurious lines, and of a band RMS for independence of the sampling.

    python -m benchmarks.bands [--cases 25] [--seed 1] [--csv docs/data/bands.csv]

Scenes are random outer-race defects of three bearings, and the slot of the paper. A periodic response has lines at
multiples of BPFO only, so the largest envelope line elsewhere, relative to that at BPFO, is spurious; it is
computed at two sampling rates. `velocity.rms@10-1000Hz` is compared between sampling rates of 10 240 to 409 600
Hz, and the least contact force with the largest.
"""

import random
import sys
from typing import Any, NamedTuple

import numpy as np

from bearingsim import signals
from bearingsim.config import Case
from bearingsim.simulation import simulate
from benchmarks.campaign import table

BEARINGS = ("6205", "nf308", "nu206")
SAMPLINGS = (10_240, 20_480)
FINEST_SAMPLING = 409_600
RMS = "velocity.rms@10-1000Hz"
LINE_DISTANCE = 0.1
"""Distance from a multiple of BPFO, relative to BPFO, within which a line belongs to it."""
PAPER: dict[str, Any] = {
    "bearing": "nf308",
    "speed": "1800 rpm",
    "load": "150 N",
    "defect": {"shape": "rectangular", "length": "12 mm", "width": "0.2 mm", "depth": "0.05 mm"},
}
LARGEST_SPURIOUS, LARGEST_CHANGE, LARGEST_TENSION = 0.01, 0.01, 0.01


class SceneResult(NamedTuple):
    """Result of a scene: spurious over BPFO line by sampling, change of the RMS, least over largest force."""

    scene: str
    repeats: bool
    ghost_10k: float
    ghost_20k: float
    rms_change: float
    tension: float
    held: bool


def scene(rng: random.Random) -> dict[str, Any]:
    """Draw the fields of a case."""
    width = rng.uniform(0.2, 2.0)
    return {
        "bearing": rng.choice(BEARINGS),
        "speed": f"{rng.uniform(600, 3000):.0f} rpm",
        "load": f"{rng.uniform(50, 500):.0f} N",
        "clearance": f"{rng.uniform(0, 15):.1f} um",
        "defect": {
            "shape": rng.choice(("rectangular", "circular")),
            "length": f"{rng.uniform(width, 8.0):.2f} mm",
            "width": f"{width:.2f} mm",
            "depth": f"{rng.uniform(0.01, 0.1):.3f} mm",
            "angle": f"{rng.uniform(-20, 20):.0f} deg",
        },
    }


def compare_samplings(fields: dict[str, Any]) -> SceneResult:
    """Compute a scene at each sampling rate, and compare."""
    settings = {"model": "rollers", "duration": "0.5 s", "features": [RMS], "step_check": False}
    settings["record"] = ["sensor.acceleration", "roller.1.outer_force"]
    spurious, rms, forces = [], [], np.zeros(1)
    for sampling in (*SAMPLINGS, FINEST_SAMPLING):
        case = Case.model_validate(fields | settings | {"sampling": f"{sampling} Hz"})
        record = simulate(case)
        rms.append(record.features[RMS])
        is_periodic = float(record.info["period_passes"]) > 0
        series = record.series["sensor.acceleration"]
        spurious.append(
            largest_spurious_line(series, sampling, case.bearing.ball_pass_frequency(case.speed))
            if is_periodic
            else np.nan
        )
        forces = np.append(forces, record.series["roller.1.outer_force"])
    change, tension = max(rms) / min(rms) - 1.0, float(-forces.min() / forces.max())
    ratios = spurious[: len(SAMPLINGS)]
    passed = (
        not any(ratio > LARGEST_SPURIOUS for ratio in ratios)
        and change < LARGEST_CHANGE
        and tension < LARGEST_TENSION
    )
    defect = fields["defect"]
    name = f"{fields['bearing']} {fields['speed']} {fields['load']} {defect['width']}"
    return SceneResult(name, is_periodic, ratios[0], ratios[1], change, tension, passed)


def largest_spurious_line(series: np.ndarray, fs: float, line: float) -> float:
    """Return the largest squared-envelope line off the multiples of ``line`` (Hz), over that at ``line``."""
    passes = int(len(series) / fs * line)
    frequency, amplitude = signals.envelope_spectrum(series[: round(passes * fs / line)], fs)
    is_spurious = np.abs(frequency / line - np.round(frequency / line)) > LINE_DISTANCE
    at_line = amplitude[np.abs(frequency / line - 1.0) < LINE_DISTANCE].max()
    return float(amplitude[is_spurious & (frequency > LINE_DISTANCE * line)].max() / at_line)


def main() -> None:
    """Measure all scenes and write the table. Exit code 1 if a scene exceeds a limit."""
    frame = table(__doc__, 25, scene, compare_samplings, fixed=[PAPER])
    print(f"{frame['held'].sum()} of {len(frame)} held; {frame['repeats'].sum()} repeat themselves")
    sys.exit(int(not frame["held"].all()))


if __name__ == "__main__":
    main()
