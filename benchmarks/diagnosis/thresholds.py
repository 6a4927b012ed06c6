"""Thresholds of `bearingsim analyze`: the scores that one of 100 healthy signals exceeds.

    nice .venv/bin/python -m benchmarks.diagnosis.thresholds [--signals 5000] [--runs results/diagnosis]

Healthy signals of ``chain.py``, seeds 1000000 and on, have 160 turns of the shaft, every fifth 320, and are cut to
shorter ones. The highest score of the three races is taken at each length and tolerance. Writes
bearingsim/diagnosis/thresholds.csv. About 15 minutes of CPU time.
"""

import argparse
import csv
import sys
from pathlib import Path

import numpy as np

from bearingsim.diagnosis.combs import envelope_spectra, find_best_comb
from bearingsim.diagnosis.kinematics import ELEMENTS
from benchmarks.diagnosis import bases, chain

TURNS = (5, 10, 20, 40, 80, 160, 320)
LONG_EVERY = 5  # signals, of which one has the greatest length
TOLERANCES = (0.005, 0.01, 0.02, 0.04)
SEED = 1_000_000
EXCEEDED_BY = 0.01
"""Share of healthy signals over the threshold."""


def scores(twins: chain.Twins, seed: int) -> np.ndarray:
    """Compute the highest scores (lengths, tolerances) of a healthy signal; nan beyond its length."""
    count = len(TURNS) - bool(seed % LONG_EVERY)
    signal = chain.sample(twins, seed, None, damaged=False, seconds=TURNS[count - 1] / chain.SHAFT_HZ).signal
    lines = bases.lines(twins.setting.bearing)
    highest = np.full((len(TURNS), len(TOLERANCES)), np.nan)
    for row, turns in enumerate(TURNS[:count]):
        spectra = envelope_spectra(signal[: round(turns * bases.RATE / chain.SHAFT_HZ)], bases.RATE, lines)
        for column, tolerance in enumerate(TOLERANCES):
            combs = (find_best_comb(spectra, lines.of_race(race), tolerance) for race in ELEMENTS)
            highest[row, column] = max(comb.score for comb in combs)
    return highest


def main() -> None:
    """Compute the table and write it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--signals", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--runs", type=Path, default=Path("results/diagnosis"))
    parser.add_argument("--csv", type=Path, default=Path("bearingsim/diagnosis/thresholds.csv"))
    parser.add_argument("--scores", type=Path, help="file for the scores of all signals (.npy)")
    arguments = parser.parse_args()
    twins = chain.all_twins(arguments.runs)
    rows = []
    for number in range(arguments.signals):
        rows.append(scores(twins[number % len(twins)], arguments.seed + number))
        if number % 100 == 0:
            print(f"{number} of {arguments.signals}", file=sys.stderr, flush=True)
    if arguments.scores:
        np.save(arguments.scores, np.array(rows))
    limits = np.nanquantile(np.array(rows), 1.0 - EXCEEDED_BY, axis=0)
    with arguments.csv.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["turns", "tolerance", "score", "signals"])
        for row, turns in enumerate(TURNS):
            count = np.count_nonzero(np.isfinite(np.array(rows)[:, row, 0]))
            for column, tolerance in enumerate(TOLERANCES):
                writer.writerow([turns, tolerance, f"{limits[row, column]:.3f}", count])


if __name__ == "__main__":
    main()
