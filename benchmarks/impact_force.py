"""The impact force that `check` foretells, against the largest contact force of a run, over random scenes.

    python benchmarks/impact_force.py [--csv FILE] [--scenes N]

Bearings of the library, defects of all simple shapes on the outer and the inner race, 600 to 3000 rpm, seeded. A
third each is damped by chi = 50 s/m, by c/k of 2.5 us and of 25 us; every other scene is loaded by 5 to 30 % of
C0, the rest by 100 to 600 N. `rollers`, 0.3 s of record after 0.05 s, the step as it is chosen. Most defects are
too short or too shallow for an element to strike: those in which one does are told apart. About 2 CPU minutes.
"""

import argparse
import csv
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

SCENES, SEED, FACTOR = 60, 6, 2.0
STRUCK = 1.5  # times the largest force at rest
PRESSURES = {"roller": 4.0e9, "ball": 4.2e9}  # Pa, largest of the static load rating (ISO 76)
SHARE_OF_ONE = 5.0  # times the mean load: the most loaded element's
DAMPINGS: tuple[dict[str, Any], ...] = ({"chi": 50.0}, {"beta": 2.5e-6}, {"beta": 25e-6})
SHAPES = ("rectangular", "rectangular", "circular", "triangular", "elliptical")
COLUMNS = (
    "scene", "bearing", "chi_s_m", "beta_us", "shape", "race", "width_mm", "depth_um", "length_mm", "rpm",
    "load_N", "share_of_C0", "clearance_um", "rest_N", "foretold_N", "largest_N", "ratio",
)  # fmt: skip


def static_load_of_element(case: Case, on_outer: bool) -> float:
    """The load (N) of one contact at which its largest pressure is that of the static load rating."""
    b, limit = case.bearing, PRESSURES[case.bearing.element]
    if b.element == "ball":
        point = assemble.contacts.point_contact(case, on_outer)
        return float((limit / point.pressure(1.0)) ** 3)
    reduced, race = (outer_reduced_radius, outer_radius) if on_outer else (inner_reduced_radius, inner_radius)
    E_star = effective_modulus(b.material.young_modulus, b.material.poisson_ratio)
    return pi * reduced(b.roller_diameter / 2.0, race(case)) * limit**2 / E_star * float(b.roller_length or 0.0)


def static_rating(case: Case) -> float:
    """C0 (N) of the bearing by the pressure on its inner race."""
    return case.bearing.rollers * static_load_of_element(case, on_outer=False) / SHARE_OF_ONE


def scene(number: int, **changes: Any) -> Case:
    """The scene of a number."""
    draw = Random(f"{SEED} {number}")

    def between(low: float, high: float) -> float:
        return exp(draw.uniform(log(low), log(high)))

    bearing = draw.choice(library_names("bearings"))
    speed = draw.uniform(600.0, 3000.0) * pi / 30.0
    base: dict[str, Any] = {"bearing": bearing, "speed": speed, "load": 100.0, "model": "rollers"}
    b = Case.model_validate(base).bearing
    share, light, shape = between(0.05, 0.30), between(100.0, 600.0), draw.choice(SHAPES)
    load = share * static_rating(Case.model_validate(base)) if number % 2 else light
    track = b.roller_length or 0.4 * b.roller_diameter
    size = between(0.3e-3, 0.2 * b.roller_diameter)
    whole = shape in ("rectangular", "triangular") and draw.random() < 0.5
    defect: dict[str, Any] = {
        "shape": shape,
        "race": draw.choice(("outer", "outer", "inner")),
        "width": size,
        "length": size if shape == "circular" else track if whole else between(0.1, 1.0) * track,
        "depth": between(5e-6, 200e-6),
    }
    given = base | {"load": load, "defect": defect, "clearance": draw.uniform(0.0, 20e-6)}
    given |= {"contact": {"damping": DAMPINGS[number // 2 % 3]}}
    given |= {"step_check": False, "settle": "50 ms", "duration": "0.3 s"}
    return Case.model_validate(given | changes)


def forces(case: Case) -> tuple[float, float]:
    """The largest contact force (N) that is foretold, and that of the run."""
    found = simulate(case).features
    return choice.limits(case).impact_force, max(found["outer_force.max"], found["inner_force.max"])


def row(number: int) -> dict[str, Any]:
    """What the table says of a scene."""
    case = scene(number)
    foretold, largest = forces(case)
    defect, damping = case.defects[0], case.contact.damping
    values = (
        number, case.bearing.name, getattr(damping, "chi", 0.0), 1e6 * getattr(damping, "beta", 0.0), defect.shape,
        defect.race, 1e3 * defect.width, 1e6 * defect.depth, 1e3 * defect.length, case.speed * 30.0 / pi,
        case.load, case.load / static_rating(case), 1e6 * case.clearance, choice.limits(case).rest_load, foretold,
        largest, foretold / largest,
    )  # fmt: skip
    return dict(zip(COLUMNS, values, strict=True))


def report(rows: Sequence[dict[str, Any]]) -> None:
    """Print the ratio's spread, of all and by damping and load, and the scenes outside the factor."""
    groups: dict[str, list[float]] = {"all": [], "heavily loaded": [], "lightly loaded": [], "struck": []}
    for one in rows:
        told = f"chi {one['chi_s_m']:g} s/m" if one["chi_s_m"] else f"c/k {one['beta_us']:g} us"
        load = "heavily loaded" if one["scene"] % 2 else "lightly loaded"
        struck = ["struck"] if one["largest_N"] > STRUCK * one["rest_N"] else []
        for name in ("all", load, told, *struck):
            groups.setdefault(name, []).append(one["ratio"])
    print("foretold over largest force of the run: 5, 50, 95 %, least, largest")
    for name, ratios in groups.items():
        spread = np.percentile(ratios, [5, 50, 95])
        inside = sum(1.0 / FACTOR <= ratio <= FACTOR for ratio in ratios)
        print(
            f"{name:16}", *(f"{value:7.3f}" for value in (*spread, min(ratios), max(ratios))),
            f"  {inside} of {len(ratios)} within a factor {FACTOR:g}",
        )  # fmt: skip
    for one in rows:
        if not 1.0 / FACTOR <= one["ratio"] <= FACTOR:
            print("outside:", {name: text(value) for name, value in one.items()})


def text(value: Any) -> str:
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--csv")
    parser.add_argument("--scenes", type=int, default=SCENES)
    arguments = parser.parse_args()
    rows = [row(number) for number in range(arguments.scenes)]
    report(rows)
    if arguments.csv:
        with open(arguments.csv, "w", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            writer.writeheader()
            writer.writerows({name: text(value) for name, value in one.items()} for one in rows)


if __name__ == "__main__":
    main()
