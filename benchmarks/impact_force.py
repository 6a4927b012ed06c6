"""Impact force predicted by `check`, compared with the largest contact force of a run, for random scenes.

    python -m benchmarks.impact_force [--csv FILE] [--scenes N]

Seeded scenes use the bearings of the library, defects of all simple shapes on the outer and inner race, and 600 to
3000 rpm. A third each has chi = 50 s/m, c/k = 2.5 us and c/k = 25 us. Every second scene has a load of 5 to 30 %
of C0, the others 100 to 600 N. The model is `rollers`, with a record of 0.3 s after 0.05 s and the automatic step.
Most defects are too short or too shallow for an impact; scenes with an impact are reported separately. About 2
minutes of CPU time.
"""

import argparse
import sys
from collections.abc import Sequence
from math import exp, log, pi
from pathlib import Path
from random import Random
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np

from bearingsim import assemble
from bearingsim.assemble.geometry import inner_radius, outer_radius
from bearingsim.config import Case, library_names
from bearingsim.core.defects.pairs import inner_reduced_radius, outer_reduced_radius
from bearingsim.core.laws.hertz import effective_modulus
from bearingsim.simulation import choice
from bearingsim.simulation.simulate import simulate
from benchmarks.rows import rounded, write_csv

SCENES, SEED, FACTOR = 60, 6, 2.0
IMPACT_RATIO = 1.5  # times the largest static force; larger forces are impacts
PRESSURES = {"roller": 4.0e9, "ball": 4.2e9}  # Pa, contact pressure that defines the static load rating (ISO 76)
LOAD_CONCENTRATION = 5.0  # load of the most loaded element, over the mean load
DAMPINGS: tuple[dict[str, Any], ...] = ({"chi": 50.0}, {"beta": 2.5e-6}, {"beta": 25e-6})
SHAPES = ("rectangular", "rectangular", "circular", "triangular", "elliptical")
COLUMNS = (
    "scene", "bearing", "chi_s_m", "beta_us", "shape", "race", "width_mm", "depth_um", "length_mm", "rpm",
    "load_N", "share_of_C0", "clearance_um", "rest_N", "foretold_N", "largest_N", "ratio",
)  # fmt: skip


def static_load_of_element(case: Case, on_outer: bool) -> float:
    """Return the load (N) of a contact whose largest pressure defines the static load rating."""
    b, limit = case.bearing, PRESSURES[case.bearing.element]
    if b.element == "ball":
        point = assemble.contacts.point_contact(case, on_outer)
        return float((limit / point.pressure(1.0)) ** 3)
    reduced, race = (outer_reduced_radius, outer_radius) if on_outer else (inner_reduced_radius, inner_radius)
    E_star = effective_modulus(b.material.young_modulus, b.material.poisson_ratio)
    return pi * reduced(b.roller_diameter / 2.0, race(case)) * limit**2 / E_star * float(b.roller_length or 0.0)


def static_rating(case: Case) -> float:
    """Compute C0 (N) of the bearing from the pressure on its inner race."""
    return case.bearing.rollers * static_load_of_element(case, on_outer=False) / LOAD_CONCENTRATION


def scene(number: int, **changes: Any) -> Case:
    """Draw the scene of a number."""
    rng = Random(f"{SEED} {number}")

    def between(low: float, high: float) -> float:
        return exp(rng.uniform(log(low), log(high)))

    bearing = rng.choice(library_names("bearings"))
    speed = rng.uniform(600.0, 3000.0) * pi / 30.0
    base: dict[str, Any] = {"bearing": bearing, "speed": speed, "load": 100.0, "model": "rollers"}
    b = Case.model_validate(base).bearing
    share, light, shape = between(0.05, 0.30), between(100.0, 600.0), rng.choice(SHAPES)
    load = share * static_rating(Case.model_validate(base)) if number % 2 else light
    track = b.roller_length or 0.4 * b.roller_diameter
    size = between(0.3e-3, 0.2 * b.roller_diameter)
    is_full_length = shape in ("rectangular", "triangular") and rng.random() < 0.5
    defect: dict[str, Any] = {
        "shape": shape,
        "race": rng.choice(("outer", "outer", "inner")),
        "width": size,
        "length": size if shape == "circular" else track if is_full_length else between(0.1, 1.0) * track,
        "depth": between(5e-6, 200e-6),
    }
    fields = base | {"load": load, "defect": defect, "clearance": rng.uniform(0.0, 20e-6)}
    fields |= {"contact": {"damping": DAMPINGS[number // 2 % 3]}}
    fields |= {"step_check": False, "settle": "50 ms", "duration": "0.3 s"}
    return Case.model_validate(fields | changes)


def forces(case: Case) -> tuple[float, float]:
    """Return the largest contact force (N) as predicted, and that of the run."""
    features = simulate(case).features
    return choice.limits(case).impact_force, max(features["outer_force.max"], features["inner_force.max"])


def row(number: int) -> dict[str, Any]:
    """Return the row of a scene."""
    case = scene(number)
    predicted, largest = forces(case)
    defect, damping = case.defects[0], case.contact.damping
    values = (
        number, case.bearing.name, getattr(damping, "chi", 0.0), 1e6 * getattr(damping, "beta", 0.0), defect.shape,
        defect.race, 1e3 * defect.width, 1e6 * defect.depth, 1e3 * defect.length, case.speed * 30.0 / pi,
        case.load, case.load / static_rating(case), 1e6 * case.clearance, choice.limits(case).rest_load, predicted,
        largest, predicted / largest,
    )  # fmt: skip
    return dict(zip(COLUMNS, values, strict=True))


def report(rows: Sequence[dict[str, Any]]) -> None:
    """Print the spread of the ratio, overall and by damping and load, and the scenes outside the factor."""
    groups: dict[str, list[float]] = {"all": [], "heavily loaded": [], "lightly loaded": [], "struck": []}
    for entry in rows:
        damping = f"chi {entry['chi_s_m']:g} s/m" if entry["chi_s_m"] else f"c/k {entry['beta_us']:g} us"
        load = "heavily loaded" if entry["scene"] % 2 else "lightly loaded"
        impact = ["struck"] if entry["largest_N"] > IMPACT_RATIO * entry["rest_N"] else []
        for name in ("all", load, damping, *impact):
            groups.setdefault(name, []).append(entry["ratio"])
    print("foretold over largest force of the run: 5, 50, 95 %, least, largest")
    for name, ratios in groups.items():
        spread = np.percentile(ratios, [5, 50, 95])
        within = sum(1.0 / FACTOR <= ratio <= FACTOR for ratio in ratios)
        print(
            f"{name:16}", *(f"{value:7.3f}" for value in (*spread, min(ratios), max(ratios))),
            f"  {within} of {len(ratios)} within a factor {FACTOR:g}",
        )  # fmt: skip
    for entry in rows:
        if not 1.0 / FACTOR <= entry["ratio"] <= FACTOR:
            print("outside:", rounded(entry, 5))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--csv")
    parser.add_argument("--scenes", type=int, default=SCENES)
    arguments = parser.parse_args()
    rows = [row(number) for number in range(arguments.scenes)]
    report(rows)
    if arguments.csv:
        write_csv(rows, arguments.csv, digits=5)


if __name__ == "__main__":
    main()
