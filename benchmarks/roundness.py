"""Example of a roundness profile: python -m benchmarks.roundness [studies/scans/roundness.csv]."""

import sys
from pathlib import Path

import numpy as np

COMMENTS = (
    "# A made-up outer race, as a roundness tester might give it: benchmarks/roundness.py",
    "# orders 2 to 60 of 0.2 um n^-1.3, an eccentricity of 3 um, noise of 5 nm, two missing points and a spike",
)


def example() -> tuple[np.ndarray, np.ndarray]:
    """Make a profile: angles (720,), deg, and deviations (720,), um."""
    rng = np.random.default_rng(2026)
    angles, orders = np.arange(0.0, 360.0, 0.5), np.arange(2, 61)
    phases = rng.uniform(0.0, 2.0 * np.pi, len(orders))
    waves = 0.2 * orders**-1.3 * np.cos(np.radians(np.outer(angles, orders)) + phases)
    deviations = waves.sum(axis=1) + 3.0 * np.cos(np.radians(angles - 40.0)) + rng.normal(scale=0.005, size=720)
    deviations[[211, 430]] = np.nan
    deviations[95] += 4.0
    return angles, deviations


def main() -> None:
    """Write the example as CSV."""
    path = Path(sys.argv[1] if len(sys.argv) > 1 else "studies/scans/roundness.csv")
    rows = [f"{a:.1f}," + ("" if np.isnan(d) else f"{d:.4f}") for a, d in zip(*example(), strict=True)]
    path.write_text("\n".join([*COMMENTS, "angle [deg],deviation [um]", *rows, ""]))


if __name__ == "__main__":
    main()
