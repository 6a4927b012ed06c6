"""Widths of outer-race defects that `bearingsim analyze` states, against the true ones.

    nice .venv/bin/python -m benchmarks.diagnosis.sizes [--count 400] [--csv docs/data/diagnosis_sizes.csv]

Random slots of 1.5 to 4.5 mm and 15 to 60 um over the whole track or half of it, 600 to 1800 rpm, 300 N, three
bearings (seeds 940000 and on), each behind a resonance, with slip of up to 0.5 % and noise of 0 to -20 dB. About
ten minutes of CPU time.
"""

import argparse
from pathlib import Path

import numpy as np

from bearingsim.config import Case
from bearingsim.diagnosis import diagnose
from bearingsim.diagnosis.size import Size
from bearingsim.simulation import simulate
from bearingsim.study import load_rolling_parts
from benchmarks.diagnosis import bases, chain
from benchmarks.rows import write_csv

SEED, COUNT, SECONDS = 940_000, 400, 2
COLUMNS = ("bearing", "width_mm", "depth_um", "length", "rpm", "noise_db", "verdict", "low_mm", "high_mm")


def row_of(seed: int) -> dict[str, object]:
    """Simulate, disturb and diagnose one bearing."""
    rng = np.random.default_rng(seed)
    bearing, share = str(rng.choice(bases.BEARINGS)), float(rng.choice([0.5, 1.0]))
    width, depth, rpm = rng.uniform(1.5e-3, 4.5e-3), rng.uniform(15e-6, 60e-6), float(rng.uniform(600.0, 1800.0))
    noise_db = rng.uniform(-20.0, 0.0)
    values = {
        "bearing": bearing, "speed": f"{rpm} rpm", "load": 300.0, "model": "rollers",
        "sampling": f"{bases.RATE} Hz", "duration": f"{SECONDS} s", "record": ["ring.acceleration"],
    }  # fmt: skip
    parts = Case.model_validate(values).bearing
    length = share * (parts.roller_length or parts.roller_diameter)
    values["defect"] = {"race": "outer", "shape": "rectangular", "length": length, "width": width, "depth": depth}
    series = np.asarray(simulate(Case.model_validate(values)).series["ring.acceleration.x"], float)
    passing = bases.lines(bearing).outer / bases.lines(bearing).shaft * rpm / 60.0
    slip = float(rng.uniform(0.0, 0.005))
    instants = chain.warped(len(series), bases.RATE / passing, float(rng.uniform(*chain.OFFSET)), slip, rng)
    resonance, damping = rng.uniform(2000.0, 6000.0), rng.uniform(0.01, 0.05)
    signal = chain.through(chain.read(series, instants), resonance, damping)
    signal += chain.noise(len(signal), resonance, rng) * signal.std() * 10.0 ** (noise_db / 20.0)
    result = diagnose(signal, bases.RATE, load_rolling_parts(bearing), rpm / 60.0)
    size = result.size if isinstance(result.size, Size) else None
    return {
        "bearing": bearing, "width_mm": f"{1e3 * width:.3f}", "depth_um": f"{1e6 * depth:.1f}", "length": share,
        "rpm": f"{rpm:.0f}", "noise_db": f"{noise_db:.1f}", "verdict": result.verdict,
        "low_mm": f"{1e3 * size.low:.3f}" if size else "", "high_mm": f"{1e3 * size.high:.3f}" if size else "",
    }  # fmt: skip


def main() -> None:
    """Compute all rows, print the coverage and write them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--csv", type=Path, default=Path("docs/data/diagnosis_sizes.csv"))
    parser.add_argument("--count", type=int, default=COUNT)
    arguments = parser.parse_args()
    rows = [row_of(SEED + number) for number in range(arguments.count)]
    stated = [row for row in rows if row["low_mm"]]
    covered = [row for row in stated if float(row["low_mm"]) <= float(row["width_mm"]) <= float(row["high_mm"])]  # type: ignore[arg-type]
    print(f"{len(stated)} of {len(rows)} widths stated, {len(covered)} of them cover the true width")
    write_csv(rows, arguments.csv, COLUMNS)


if __name__ == "__main__":
    main()
