"""Depth maps: example scan, accuracy of roller paths over random defects, and cost of tables.

python -m benchmarks.shapes scan studies/scans/spall.csv   # write the example scan
python -m benchmarks.shapes accuracy [--defects 200]       # largest error of h, relative to its maximum
python -m benchmarks.shapes cost                           # ns to evaluate h; ms to build a defect
"""

import argparse
import time
from math import log10
from typing import Any

import numpy as np

from bearingsim.core.defects.closed_forms import bowl_parameters, box_parameters, groove_parameters
from bearingsim.core.defects.depth import (
    Circular,
    EasedDefect,
    Elliptical,
    MergedDefects,
    Rectangular,
    ScannedDefect,
    ShiftedDefect,
    Triangular,
    section,
)
from bearingsim.core.defects.envelope import path_drop, trace_path
from bearingsim.core.defects.excitations import Envelope, defect_response
from bearingsim.core.defects.pairs import (
    GROUP_HALF_WIDTH,
    GROUP_WEIGHT,
    RollerDefectPair,
    outer_reduced_radius,
    pack_defects,
)
from bearingsim.core.defects.profile import depth_at
from bearingsim.core.defects.spall import Spall
from bearingsim.core.defects.traced import cut_along_roller, pack_traced_defects, trace_groups
from bearingsim.core.jit import jit

R, L_W = outer_reduced_radius(0.006, 0.0385), 0.012
SHAPES = (Rectangular, Triangular, Circular, Elliptical)


# Example scan of a spall, as from a profilometer


def example() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Make a scan with s (n_s,) mm, z (n_z,) mm, depth (n_z, n_s) um of a spall of 6 mm by 2 mm, 50 um deep.

    It has the curvature of the race, a tilt, a rim raised by 1 um, roughness, noise, missing cells and a spike.
    """
    rng = np.random.default_rng(20260)
    s, z = np.arange(-1.5, 1.501, 0.025), np.arange(-4.0, 4.001, 0.1)
    defect = Spall(6e-3, 2e-3, 50e-6, 1.0, 3)
    depth = np.array([1e6 * depth_at(section(defect, 1e-3 * z_mm), 1e-3 * s) for z_mm in z])
    hollow = depth > 0.0
    rough = _smoothed(rng.normal(size=depth.shape), 1) * 3.0
    depth += np.where(hollow, np.maximum(rough, -depth), -1.2 * _smoothed(hollow.astype(float), 2) * ~hollow)
    x, y = np.meshgrid(s, z)
    depth += 6.0 + 0.8 * x - 0.5 * y - 1e3 * x**2 / (2 * 38.5) + rng.normal(scale=0.08, size=depth.shape)
    depth[12, 70] += 140.0
    for row, column in ((30, 41), (30, 42), (51, 88), (9, 20)):
        depth[row, column] = np.nan
    return s, z, depth


def _smoothed(values: np.ndarray, reach: int) -> np.ndarray:
    """Average over squares with sides of 2 reach + 1 cells."""
    padded, size = np.pad(values, reach, mode="edge"), 2 * reach + 1
    rows, columns = values.shape
    shifted = [padded[i : i + rows, j : j + columns] for i in range(size) for j in range(size)]
    return np.asarray(np.mean(shifted, axis=0))


def write_scan(path: str) -> None:
    """Write the example as a grid in CSV."""
    s, z, depth = example()
    comments = [
        "# A made-up spall, as a profilometer might give it: benchmarks/shapes.py",
        "# s along rolling, z along the axis; tilted, on a race of 38.5 mm radius, with noise, gaps and a spike",
    ]
    header = "depth [um] | z [mm] | s [mm]," + ",".join(f"{x:.3f}" for x in s)
    rows = [
        f"{y:.2f}," + ",".join("" if np.isnan(p) else f"{p:.2f}" for p in row)
        for y, row in zip(z, depth, strict=True)
    ]
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join([*comments, header, *rows, ""]))


# Accuracy


def random_defect(rng: np.random.Generator) -> Any:
    """Draw a shape, possibly with rounded or ramped edges, or merged with one or two others."""
    parts = [_random_part(rng) for _ in range(int(rng.integers(1, 4)))]
    if len(parts) == 1:
        return parts[0]
    return MergedDefects(tuple(ShiftedDefect(part, *rng.uniform(-1.5e-3, 1.5e-3, 2)) for part in parts))


def _random_part(rng: np.random.Generator) -> Any:
    sizes = rng.uniform(1e-3, 12e-3), 10 ** rng.uniform(-4.3, log10(4e-3)), 10 ** rng.uniform(-7, -4)
    kind = int(rng.integers(5))
    defect: Any = Spall(*sizes, rng.uniform(), int(rng.integers(1000))) if kind == 4 else SHAPES[kind](*sizes)
    edge = int(rng.integers(3))
    if edge == 0:
        return defect
    return (
        EasedDefect(defect, 10 ** rng.uniform(-5.7, -4), 0.0, sizes[2])
        if edge == 1
        else EasedDefect(defect, 0.0, 10 ** rng.uniform(-5.3, -4), sizes[2])
    )


def rough_scan(seed: int) -> ScannedDefect:
    """Make a spall of 6 mm by 2 mm with roughness of 2 um and a rim raised by 2 um."""
    rng = np.random.default_rng(seed)
    s, z = np.linspace(-2e-3, 2e-3, 401), np.linspace(-4e-3, 4e-3, 41)
    r = np.hypot(*np.meshgrid(s / 1e-3, z / 3e-3)) * (1.0 + 0.1 * rng.normal(size=(41, 1)))
    depth = np.where(r < 1.0, 5e-5 * (1.0 - r**4) + rng.normal(0.0, 2e-6, r.shape), np.where(r < 1.1, -2e-6, 0.0))
    return ScannedDefect(f"rough {seed}", s, z, depth)


def brute_force(profile: Any, s: np.ndarray) -> np.ndarray:
    """Compute h as the minimum of p + (t - s)^2/(2 R) over 40001 positions and all ends of pieces."""
    ends = profile.pieces[:, :2].ravel()
    t = np.linspace(min(ends.min(), s[0]) - 1e-3, max(ends.max(), s[-1]) + 1e-3, 40001)
    t = np.concatenate([t, s, ends, ends - 1e-12, ends + 1e-12])
    p = depth_at(profile, t)
    return np.array([np.min(p + (t - x) ** 2 / (2.0 * R)) for x in s])


def error(defect: Any, z: float) -> float:
    """Compute the largest error of h over a section, relative to its largest value; 0 outside the defect."""
    profile = section(defect, z)
    if len(profile.pieces) == 0:
        return 0.0
    low, high = profile.pieces[0, 0], profile.pieces[-1, 1]
    s = np.linspace(low - 0.2 * (high - low), high + 0.2 * (high - low), 401)
    exact = brute_force(profile, s)
    return float(np.abs(path_drop(trace_path(profile, R), s)[0] - exact).max() / np.abs(exact).max())


def print_accuracy(count: int) -> None:
    """Print the largest and median errors."""
    rng = np.random.default_rng(4)
    errors = [error(random_defect(rng), rng.uniform(-3e-3, 3e-3)) for _ in range(count)]
    rough_errors = [error(rough_scan(seed), z) for seed in range(5) for z in (-2e-3, -1e-3, 0.0, 1e-3, 2e-3)]
    nonzero = [error_ for error_ in errors if error_ > 0.0]
    print(f"{count} random defects: largest {max(nonzero):.1e}, median {np.median(nonzero):.1e}")
    print(f"5 rough scans, 5 sections each: largest {max(rough_errors):.1e}, median {np.median(rough_errors):.1e}")


# Cost


@jit
def sum_responses(excitation, group, positions, radius):
    """Sum h over positions (n,) in m."""
    total = 0.0
    for s in positions:
        _, h, slope = defect_response(excitation, group, s, radius)
        total += h + slope
    return total


def nanoseconds(excitation: Any, group: np.ndarray, in_order: bool) -> float:
    """Measure the time of an evaluation (ns) at positions across the defect."""
    positions = np.linspace(-1.0, 1.0, 100_000) * group[GROUP_HALF_WIDTH]
    if not in_order:
        np.random.default_rng(0).shuffle(positions)
    sum_responses(excitation, group, positions, R)
    times = []
    for _ in range(7):
        began = time.perf_counter()
        sum_responses(excitation, group, positions, R)
        times.append(time.perf_counter() - began)
    return 1e9 * min(times) / len(positions)


def print_cost() -> None:
    """Print groups of a defect, pieces of its middle path, ms to build it, ns to evaluate a group."""
    closed = {
        "rectangular": box_parameters(1e-3, 5e-6),
        "triangular": groove_parameters(1e-3, 5e-6, R),
        "circular": bowl_parameters(1e-3, 5e-6, R, 0.0),
    }
    print("closed form           ns in order, at random")
    for name, row in closed.items():
        packed = pack_defects([RollerDefectPair(0, -1, 0.0, 0.0385, R, [(1.0, *row)])], Envelope())
        ns = [nanoseconds(packed.excitation, packed.groups[0, 0], in_order) for in_order in (True, False)]
        print(f"{name:20s}  {ns[0]:5.1f}  {ns[1]:5.1f}")
    print("table                 groups, pieces, ms to build, ns in order, at random")
    kinds = {kind.__name__.lower(): kind(6e-3, 1e-3, 5e-6) for kind in SHAPES}
    further = {
        "rounded": EasedDefect(kinds["elliptical"], 2e-5, 0.0, 5e-6),
        "spall": Spall(6e-3, 2e-3, 5e-5, 1.0, 3),
    }
    for name, defect in (kinds | further | {"rough scan": rough_scan(1)}).items():
        began = time.perf_counter()
        rows, paths = trace_groups(defect, R, cut_along_roller(defect, L_W, 24))
        build_ms = 1e3 * (time.perf_counter() - began)
        packed = pack_traced_defects([RollerDefectPair(0, -1, 0.0, 0.0385, R, rows, paths)])
        k = max(range(len(rows)), key=lambda i: len(paths[i].pieces))
        ns = [nanoseconds(packed.excitation, packed.groups[0, k], in_order) for in_order in (True, False)]
        assert abs(sum(row[GROUP_WEIGHT] for row in rows) - 1.0) < 1e-9
        print(
            f"{name:20s}  {len(rows):3d}  {len(paths[k].pieces):4d}  {build_ms:7.1f}  {ns[0]:5.1f}  {ns[1]:5.1f}"
        )


def main() -> None:
    """Run the requested command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["scan", "accuracy", "cost"])
    parser.add_argument("path", nargs="?", default="studies/scans/spall.csv")
    parser.add_argument("--defects", type=int, default=200)
    options = parser.parse_args()
    if options.what == "scan":
        write_scan(options.path)
    elif options.what == "accuracy":
        print_accuracy(options.defects)
    else:
        print_cost()


if __name__ == "__main__":
    main()
