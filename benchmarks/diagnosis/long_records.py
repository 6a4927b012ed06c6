"""Share of long healthy records over the thresholds of `bearingsim analyze`, which are extrapolated to them.

    nice .venv/bin/python -m benchmarks.diagnosis.long_records [--signals 400] [--runs results/diagnosis]

Healthy signals of ``chain.py``, seeds 1100000 and on, of 1280 turns of the shaft, and their first 320 and 640.
About ten minutes of CPU time.
"""

import argparse
from pathlib import Path

from bearingsim.diagnosis.combs import envelope_spectra, find_best_comb
from bearingsim.diagnosis.kinematics import ELEMENTS
from bearingsim.diagnosis.thresholds import threshold
from benchmarks.diagnosis import bases, chain

TURNS = (320, 640, 1280)
TOLERANCE = 0.02
SEED = 1_100_000
STRIDE = 7
"""Step through the runs, so that few signals have all bearings."""


def exceeded(twins: chain.Twins, seed: int) -> list[bool]:
    """Check at each length if the highest score of a healthy signal exceeds the threshold."""
    signal = chain.sample(twins, seed, None, damaged=False, seconds=TURNS[-1] / chain.SHAFT_HZ).signal
    lines = bases.lines(twins.setting.bearing)
    results = []
    for turns in TURNS:
        spectra = envelope_spectra(signal[: round(turns * bases.RATE / chain.SHAFT_HZ)], bases.RATE, lines)
        score = max(find_best_comb(spectra, lines.of_race(race), TOLERANCE).score for race in ELEMENTS)
        results.append(score > threshold(turns, TOLERANCE))
    return results


def main() -> None:
    """Print how many signals exceed the threshold at each length."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--signals", type=int, default=400)
    parser.add_argument("--runs", type=Path, default=Path("results/diagnosis"))
    arguments = parser.parse_args()
    twins = chain.all_twins(arguments.runs)
    results = [exceeded(twins[STRIDE * number % len(twins)], SEED + number) for number in range(arguments.signals)]
    for turns, column in zip(TURNS, zip(*results, strict=True), strict=True):
        print(f"{turns} turns: {sum(column)} of {len(column)} over the threshold")


if __name__ == "__main__":
    main()
